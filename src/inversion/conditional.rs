//! The best of everything else with one quantity held.

use crate::inversion::compiled::Compiled;
use crate::inversion::parameter::COUNT;
use crate::inversion::problem::Problem;
use crate::inversion::quantity::Quantity;
use crate::inversion::solution::Solution;
use crate::inversion::space::Space;
use crate::optimise::{LeastSquares, Minimum, Tolerances, minimise};
use crate::uncertainty::profile::{Conditional, ProfileStart};
use nalgebra::DVector;

/// Where the covariance gives no standard deviation, the first steps are this share of the range.
const BLIND: f64 = 0.1;
/// Tolerances of a conditional minimum: the cost to far less than the 0.004 of chi² that the ends are found to.
const CONDITIONAL: Tolerances = Tolerances { cost: 1e-9, step: 1e-8, gradient: 1e-11, max_evaluations: 80, escapes: 2 };

/// Conditional minima of one fit.
#[derive(Debug)]
pub(crate) struct Conditionals<'a> {
    pub(crate) compiled: &'a Compiled<'a>,
    pub(crate) solution: &'a Solution,
    /// Structures to begin from, too.
    pub(crate) others: Vec<[f64; COUNT]>,
    /// Standard deviation of a weighted residual.
    pub(crate) unit: f64,
}

impl Conditionals<'_> {
    /// With `quantity` held at `value`, from `starts` of what is left free.
    pub(crate) fn at(&self, quantity: Quantity, value: f64, starts: &[&DVector<f64>]) -> Option<Conditional> {
        let Solution { searched, robust, .. } = self.solution;
        // The spaces of one quantity differ in the held value alone: the free parameters are numbered alike.
        let roles = quantity.held(&self.compiled.settings.roles, searched, value)?;
        let space = Space::new(&roles).ok()?;
        let problem = Problem::new(self.compiled, &space, robust);
        let mut all: Vec<DVector<f64>> = starts
            .iter()
            .filter(|start| start.len() == space.freedom.free.len())
            .map(|start| (*start).clone())
            .collect();
        let neighbours = all.len();
        // A held quantity moves the follower of a link, not what is free beside it.
        all.extend(self.others.iter().map(|other| space.freedom.restrict(other)));
        lowest(&problem, &all, neighbours)
    }

    /// Where a profile of `quantity` begins: at the best minimum; `sigma` in its inside unit.
    pub(crate) fn start(&self, quantity: Quantity, sigma: Option<f64>) -> ProfileStart {
        let Solution { searched, minima, robust, .. } = self.solution;
        let best = &minima[0];
        let values = searched.freedom.expand(&best.parameters);
        let limits = quantity.limits(searched);
        let range = limits.1 - limits.0;
        let at_best = quantity.held(&self.compiled.settings.roles, searched, quantity.of(&values));
        let own = at_best.and_then(|roles| Space::new(&roles).ok()).map(|space| space.freedom.restrict(&values));
        let sum_of_squares = Problem::new(self.compiled, searched, robust).sum_of_squares(best);
        ProfileStart {
            value: quantity.of(&values),
            others: own.unwrap_or_else(|| DVector::zeros(0)),
            sum_of_squares,
            sigma: sigma.unwrap_or(BLIND * range).min(range).max(f64::MIN_POSITIVE),
            limits,
            unit: self.unit,
        }
    }
}

/// The lowest of the minima that the starts lead to, the first `neighbours` of which are of one basin.
pub(crate) fn lowest(problem: &Problem<'_>, starts: &[DVector<f64>], neighbours: usize) -> Option<Conditional> {
    if problem.bounds().is_empty() {
        let sum_of_squares = problem.residuals(&DVector::zeros(0)).norm_squared();
        return Some(Conditional { sum_of_squares, others: DVector::zeros(0) });
    }
    let run = |start: &DVector<f64>| minimise(problem, &problem.bounds().clamp(start), CONDITIONAL);
    let mut best: Option<Minimum> = None;
    for (place, start) in starts.iter().enumerate() {
        // The neighbours' extrapolation comes first; the neighbours themselves are for when that fails.
        if place < neighbours && best.as_ref().is_some_and(|best| best.termination.was_successful()) {
            continue;
        }
        let found = run(start);
        if best.as_ref().is_none_or(|best| found.sum_of_squares < best.sum_of_squares) {
            best = Some(found);
        }
    }
    best.map(|best| Conditional { sum_of_squares: best.sum_of_squares, others: best.parameters })
}
