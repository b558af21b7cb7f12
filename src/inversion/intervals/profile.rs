//! Profile likelihood of every quantity of a fit.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::conditional::Conditionals;
use crate::inversion::fit::FitError;
use crate::inversion::intervals::{IntervalPair, Quantiles, rivals, stretched};
use crate::inversion::outcome::Fit;
use crate::inversion::parameter::{COUNT, outside};
use crate::inversion::quantity::Quantity;
use crate::inversion::space::Space;
use crate::uncertainty::profile::profile;
use nalgebra::DVector;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

/// A conditional minimum this far below the best, in chi², is another minimum and no rounding.
pub(super) const LOWER: f64 = 0.01;

/// The profile of one quantity, in the user's unit.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantityProfile {
    /// Name as in `fit.json`.
    pub name: &'static str,
    /// nm, deg or rad.
    pub unit: &'static str,
    /// Best value.
    pub best: f64,
    /// Standard deviation by the covariance, where it has one.
    pub sigma: Option<f64>,
    /// Values of the quantity, rising.
    pub values: Vec<f64>,
    /// Δchi² in units of the squared standard deviation of a weighted residual, one for each value.
    pub excess: Vec<f64>,
    /// The five parameters at each, user units.
    pub parameters: Vec<[f64; COUNT]>,
    /// Intervals of 68.3 and 95 %; an end at a limit is open.
    pub intervals: IntervalPair,
    /// Least and largest value within the bounds of the fit.
    pub limits: [f64; 2],
    /// Δchi² at the ends of the two intervals.
    pub levels: [f64; 2],
}

/// All profiles of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Profiles {
    /// One for each quantity that moves.
    pub quantities: Vec<QuantityProfile>,
    /// The five parameters, user units, of a minimum below that of the fit which a profile met.
    pub lower: Option<[f64; COUNT]>,
}

/// The profile likelihood of each free parameter, of the period and of the optical sum.
///
/// The others are fitted again at each point from where they were at its neighbours and at other minima; what the data do
/// not determine floats within its bounds.
///
/// ```text
/// interval of quantile z:   min chi²(quantity held) - min chi² < z² · unit²
/// ```
///
/// # Errors
/// [`FitError`] if `data` are not those of `fit`.
///
/// # Source
/// Venzon and Moolgavkar 1988, DOI 10.2307/2347496.
pub fn profiles(data: &Dataset, fit: &Fit, progress: &(dyn Fn(&str) + Sync)) -> Result<Profiles, FitError> {
    let model = fit.outcome.settings.forward()?;
    let compiled = Compiled::of_fit(data, fit, model.as_ref())?;
    let quantities = Quantity::moving(&compiled, &fit.solution.searched);
    let solution = &fit.solution;
    let searched = &solution.searched;
    let others = (rivals(solution, solution.unit).map(|minimum| searched.freedom.expand(&minimum.parameters)))
        .chain(solution.open().flat_map(|held| held.elsewhere.clone()))
        .collect();
    let conditionals = Conditionals { compiled: &compiled, solution, others, unit: solution.unit };
    let found: Vec<(QuantityProfile, Option<[f64; COUNT]>)> = quantities
        .par_iter()
        .filter(|quantity| quantity.can_be_held(&compiled.settings.roles, &fit.solution.searched))
        .map(|&quantity| {
            progress(&format!("profile of {}", quantity.name()));
            profile_of(&conditionals, fit, quantity)
        })
        .collect();
    let lower = found.iter().find_map(|(_, lower)| *lower);
    Ok(Profiles { quantities: found.into_iter().map(|(profile, _)| profile).collect(), lower })
}

fn profile_of(
    conditionals: &Conditionals<'_>,
    fit: &Fit,
    quantity: Quantity,
) -> (QuantityProfile, Option<[f64; COUNT]>) {
    let searched = &fit.solution.searched;
    let sigma = quantity.estimate(&fit.outcome).sigma.map(|sigma| quantity.inside(sigma));
    let start = conditionals.start(quantity, sigma);
    let limits = start.limits;
    let conditional = |value: f64, starts: &[&DVector<f64>]| conditionals.at(quantity, value, starts);
    let Quantiles { sixty_eight, ninety_five } = Quantiles::of(&fit.outcome);
    let found = profile(conditional, &start, &[sixty_eight, ninety_five]);
    let parameters_at = |value: f64, others: &DVector<f64>| {
        let roles = quantity.held(&fit.outcome.settings.roles, searched, value);
        let space = roles.and_then(|roles| Space::new(&roles).ok());
        let space = space.filter(|space| space.freedom.free.len() == others.len());
        space.map(|space| outside(&space.freedom.expand(others)))
    };
    let points: Vec<(f64, f64, [f64; COUNT])> = (found.points.iter())
        .filter_map(|point| {
            let parameters = parameters_at(point.value, &point.others)?;
            Some((quantity.outside(point.value), point.excess, parameters))
        })
        .collect();
    let lowest = points.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let lower = lowest.filter(|point| point.1 < -LOWER).map(|point| point.2);
    let outside = |interval: [Option<f64>; 2]| interval.map(|end| end.map(|end| quantity.outside(end)));
    let interval = |place: usize| found.intervals.get(place).copied().map_or([None, None], outside);
    let intervals = IntervalPair { interval_68: interval(0), interval_95: interval(1) };
    let outer = [quantity.outside(limits.0), quantity.outside(limits.1)];
    let profile = QuantityProfile {
        name: quantity.name(),
        unit: quantity.unit(),
        best: quantity.outside(start.value),
        sigma: sigma.map(|sigma| quantity.outside(sigma)),
        values: points.iter().map(|point| point.0).collect(),
        excess: points.iter().map(|point| point.1).collect(),
        parameters: points.iter().map(|point| point.2).collect(),
        intervals: stretched(intervals, quantity, fit, quantity.outside(start.value), outer),
        limits: outer,
        levels: [sixty_eight * sixty_eight, ninety_five * ninety_five],
    };
    (profile, lower)
}
