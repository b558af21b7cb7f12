//! Stiff and sloppy: the combinations of parameters that the data hold, the best known first.
//!
//! In units of each parameter's range the covariance has principal directions; along each the parameters are known
//! independently of all others. The optical sum of the layers is typically thirty times stiffer than their split.

use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::solution::Solution;
use crate::uncertainty::identifiability::{Direction, Identifiability};
use serde::{Deserialize, Serialize};

/// A parameter with a smaller share of a direction than this, of the largest, is not named.
const NAMED: f64 = 0.1;

/// A principal direction of what is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Names of the parameters that take part, the strongest first; of thicknesses `d_air`.
    pub names: Vec<String>,
    /// Their coefficients, in the user's units, that of the first being 1.
    pub coefficients: Vec<f64>,
    /// Value of `sum coefficient · parameter`, in the unit of the first.
    pub value: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// The standard deviation as a share of the value, where all are thicknesses that add up.
    pub relative: Option<f64>,
    /// The standard deviation along the direction as a share of the bounds' ranges.
    pub of_range: f64,
}

fn is_thickness(parameter: Parameter) -> bool {
    matches!(parameter, Parameter::DAir | Parameter::DCuticle)
}

/// The directions of what was determined, the stiffest first; `analysis` is that of the solution's best minimum. Left out is what
/// moves by more than its standard deviation where a held parameter has another value that fits: it is not known so well.
pub(crate) fn combinations(solution: &Solution, analysis: &Identifiability) -> Vec<Combination> {
    let space = &solution.space;
    let values = space.freedom.expand(&solution.best.parameters);
    let of = |direction: &Direction| {
        let parts = direction.parts();
        let largest = direction.components[*parts.first()?].abs();
        let mut taking: Vec<usize> =
            parts.into_iter().filter(|&part| direction.components[part].abs() >= NAMED * largest).collect();
        // Sums of thicknesses are read with d_air first.
        if taking.iter().all(|&part| is_thickness(space.freedom.free[part])) {
            taking.sort_unstable();
        }
        let strongest = *taking.first()?;
        let parameters: Vec<Parameter> = taking.iter().map(|&part| space.freedom.free[part]).collect();
        // d(combination)/d(parameter) for a step of one range along the direction, in the user's units.
        let slope = |part: usize| direction.components[part] / space.freedom.free[part].outside(space.ranges[part]);
        let first = slope(strongest);
        let coefficients: Vec<f64> = taking.iter().map(|&part| slope(part) / first).collect();
        let value = (parameters.iter().zip(&coefficients))
            .map(|(parameter, coefficient)| coefficient * parameter.outside(values[parameter.index()]))
            .sum::<f64>();
        let sigma = direction.deviation / first.abs();
        let adds_up =
            parameters.iter().copied().all(is_thickness) && coefficients.iter().all(|coefficient| *coefficient > 0.0);
        let along = |structure: &[f64; COUNT]| {
            let moved =
                |parameter: &Parameter| parameter.outside(structure[parameter.index()] - values[parameter.index()]);
            parameters
                .iter()
                .zip(&coefficients)
                .map(|(parameter, coefficient)| coefficient * moved(parameter))
                .sum::<f64>()
        };
        let stays = solution.open().flat_map(|held| &held.elsewhere).all(|there| along(there).abs() <= sigma);
        (sigma.is_finite() && stays).then(|| Combination {
            names: parameters.iter().map(|parameter| parameter.name().to_owned()).collect(),
            coefficients,
            value,
            sigma,
            relative: adds_up.then(|| sigma / value),
            of_range: direction.deviation,
        })
    };
    analysis.directions.iter().filter_map(of).collect()
}
