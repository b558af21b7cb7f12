//! Taking out what the data do not determine: directions, the parameters held for them, and minima along them.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::parameter::{COUNT, Parameter, Role};
use crate::inversion::problem::Problem;
use crate::inversion::search::{APART, FINE};
use crate::inversion::space::Space;
use crate::optimise::{BoundsError, Minimum, minimise};
use crate::uncertainty::identifiability::Identifiability;
use nalgebra::DVector;

/// A direction that the data do not determine, among the parameters that were searched.
#[derive(Debug, Clone)]
pub(crate) struct Held {
    /// All parameters of the direction, the strongest first, with the step along it in inside units.
    pub(crate) direction: Vec<(Parameter, f64)>,
    /// Standard deviation along it in units of the ranges; infinite if nothing depends on it.
    pub(crate) deviation: f64,
    /// Whether the data do depend on its first parameter, but a scale or background does the same.
    pub(crate) absorbed: bool,
    /// Structures that fit as well with its parameter elsewhere, if no thickness is a part of it; inside units.
    pub(crate) elsewhere: Vec<[f64; COUNT]>,
}

impl Held {
    /// The step along the direction of all five parameters, those that follow another included; inside units.
    pub(crate) fn step(&self, searched: &Space) -> [f64; COUNT] {
        let mut step = DVector::zeros(searched.freedom.free.len());
        for (parameter, size) in &self.direction {
            if let Some(j) = searched.freedom.free.iter().position(|free| free == parameter) {
                step[j] = *size;
            }
        }
        let all = searched.freedom.matrix() * step;
        std::array::from_fn(|row| all[row])
    }
}

/// Data met to this share of the largest reading are exact: no scatter below it is believed.
const EXACT: f64 = 1e-9;
/// A parameter that changes the model by more than this share of the data over its range does enter it.
const ABSORBED: f64 = 1e-6;

/// Standard deviation of a weighted residual: 1 where the data state sigma, the scatter where they do not.
pub(crate) fn unit_of_residuals(data: &Dataset, sum_of_squares: f64, dof: usize) -> f64 {
    if data.has_sigma() || dof == 0 {
        return 1.0;
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let scatter = (sum_of_squares / dof as f64).sqrt();
    let largest = data.largest();
    let least = if largest > 0.0 { EXACT * largest } else { EXACT };
    scatter.max(least)
}

/// The minima that differ by more than a move along the undetermined directions: minima along these are one answer.
pub(crate) fn apart_beyond(minima: Vec<Minimum>, held: &[Held], space: &Space) -> Vec<Minimum> {
    let free = &space.freedom.free;
    let mut flat: Vec<DVector<f64>> = Vec::new();
    for held in held {
        let mut direction = DVector::zeros(free.len());
        for (parameter, step) in &held.direction {
            if let Some(j) = free.iter().position(|other| other == parameter) {
                direction[j] = step / space.scales[j];
            }
        }
        for other in &flat {
            let along = direction.dot(other);
            direction -= other * along;
        }
        if direction.norm() > 0.0 {
            flat.push(direction.normalize());
        }
    }
    let mut kept: Vec<Minimum> = Vec::new();
    for minimum in minima {
        let known = kept.iter().any(|other| {
            let mut step = (&minimum.parameters - &other.parameters).component_div(&space.scales);
            for direction in &flat {
                let along = step.dot(direction);
                step -= direction * along;
            }
            step.amax() <= APART
        });
        if !known {
            kept.push(minimum);
        }
    }
    kept
}

/// What is left when the directions that the data do not determine are taken out.
#[derive(Debug)]
pub(crate) struct Undetermined {
    pub(crate) held: Vec<Held>,
    /// Tilt, lobe or width of the lamellae that ended on a bound: not held, but the others were found with it there.
    pub(crate) stopped: Vec<Held>,
    pub(crate) space: Space,
    pub(crate) best: Minimum,
}

/// Takes out one parameter for each direction that the data do not determine, and fits the others again.
pub(crate) fn hold_undetermined(
    compiled: &Compiled<'_>,
    robust: &[f64],
    searched: &Space,
    best: &Minimum,
) -> Result<Undetermined, BoundsError> {
    let mut roles: [Role; COUNT] = compiled.settings.roles;
    let mut space = Space::new(&roles)?;
    let mut best = best.clone();
    let mut held: Vec<Held> = Vec::new();
    for _ in 0..searched.freedom.free.len() {
        let free = &space.freedom.free;
        let dof = compiled.plan.len().saturating_sub(free.len() + compiled.linear.columns.len());
        let unit = unit_of_residuals(compiled.data, best.sum_of_squares, dof);
        let found = Identifiability::new(&(&best.triangle / unit), &space.ranges);
        let Some(worst) = found.undetermined().last() else { break };
        let step = |&j: &usize| (free[j], worst.components[j] * space.ranges[j]);
        let direction: Vec<(Parameter, f64)> = worst.parts().iter().map(step).collect();
        let Some(&(parameter, _)) = direction.first() else { break };
        let deviation = worst.deviation;
        let values = space.freedom.expand(&best.parameters);
        let value = values[parameter.index()];
        let problem = Problem::new(compiled, &space, robust);
        let absorbed = problem.evaluate(&best.parameters).is_some_and(|point| {
            let column = free.iter().position(|other| *other == parameter);
            let bare = column.map_or(0.0, |j| problem.full_jacobian(&point).column(j).norm() * space.ranges[j]);
            bare > ABSORBED * problem.size_of_data()
        });
        roles[parameter.index()] = Role::Fixed { value };
        space = Space::new(&roles)?;
        let problem = Problem::new(compiled, &space, robust);
        best = minimise(&problem, &space.freedom.restrict(&values), FINE);
        // Its slope is 0, as at a symmetry, or so small that the noise hides it: the others move with it either way. A lobe or a
        // width that only acts as a scale does moves nothing but the scale; a tilt does so at one place, and the phases elsewhere.
        let moves = |walked| !absorbed || deviation.is_finite() || walked == Parameter::Delta;
        let elsewhere = match walked(&direction).filter(|&walked| moves(walked) && compiled.plan.sees(walked)) {
            Some(walked) => {
                let most = best.sum_of_squares + compiled.settings.level * unit * unit;
                elsewhere(compiled, robust, walked, &values, most)
            }
            None => Vec::new(),
        };
        held.push(Held { direction, deviation, absorbed, elsewhere });
    }
    let dof = compiled.plan.len().saturating_sub(space.freedom.free.len() + compiled.linear.columns.len());
    let sum = Problem::new(compiled, &space, robust).sum_of_squares(&best);
    let unit = unit_of_residuals(compiled.data, sum, dof);
    let most = sum + compiled.settings.level * unit * unit;
    let values = space.freedom.expand(&best.parameters);
    let on_a_bound = (0..space.freedom.free.len()).filter(|&j| {
        let at = best.parameters[j];
        at <= space.bounds.lower()[j] || at >= space.bounds.upper()[j]
    });
    let stopped = on_a_bound
        .map(|j| space.freedom.free[j])
        .filter(|parameter| !matches!(parameter, Parameter::DAir | Parameter::DCuticle))
        .map(|parameter| {
            let direction = vec![(parameter, 0.0)];
            Held {
                direction,
                deviation: 0.0,
                absorbed: false,
                elsewhere: elsewhere(compiled, robust, parameter, &values, most),
            }
        })
        .collect();
    Ok(Undetermined { held, stopped, space, best })
}

/// The parameter that is moved to see what moves along a direction beyond its derivatives; none if thicknesses are a part of it:
/// then they are not told, and what is told of their sums does not change along it.
fn walked(direction: &[(Parameter, f64)]) -> Option<Parameter> {
    let holds = |wanted: Parameter| direction.iter().any(|(part, _)| *part == wanted);
    match direction {
        [(alone, _)] => Some(*alone),
        _ if holds(Parameter::DAir) || holds(Parameter::DCuticle) => None,
        // Tilt and lobe may do as one; the thicknesses move with the tilt.
        [(first, _), ..] => Some(if holds(Parameter::Delta) { Parameter::Delta } else { *first }),
        [] => None,
    }
}

/// Structures off in `parameter`, to either side, whose sum of squares is below `most`.
///
/// At a symmetry, such as no tilt under normal incidence, the derivative is zero and yet the others move with it: the farthest may be
/// the mirror image, where they are back, so that those between are taken too.
fn elsewhere(
    compiled: &Compiled<'_>,
    robust: &[f64],
    parameter: Parameter,
    values: &[f64; COUNT],
    most: f64,
) -> Vec<[f64; COUNT]> {
    let Role::Free { lower, upper } = compiled.settings.roles[parameter.index()] else { return Vec::new() };
    let mut found = Vec::new();
    for end in [lower, upper] {
        for share in [1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12] {
            let mut roles = compiled.settings.roles;
            let here = values[parameter.index()];
            roles[parameter.index()] = Role::Fixed { value: here + share * (end - here) };
            let Ok(space) = Space::new(&roles) else { break };
            let problem = Problem::new(compiled, &space, robust);
            let from = |start: &[f64; COUNT]| minimise(&problem, &space.freedom.restrict(start), FINE);
            let mut there = from(values);
            // A lobe that a tilt leaves dark has no slope: begin with the widest, too.
            if let Role::Free { upper, .. } = roles[Parameter::PhiAlpha.index()] {
                let mut widest = *values;
                widest[Parameter::PhiAlpha.index()] = upper;
                let other = from(&widest);
                if other.sum_of_squares < there.sum_of_squares {
                    there = other;
                }
            }
            if there.sum_of_squares <= most {
                found.push(space.freedom.expand(&there.parameters));
            }
        }
    }
    found
}
