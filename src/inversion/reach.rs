//! Intervals that reach as far as chi² lets them: where it rises more slowly than a parabola with the curvature at the minimum,
//! those of the covariance are too short.

use crate::inversion::conditional::Conditionals;
use crate::inversion::estimates::{Found, Uncertainty};
use crate::inversion::intervals::{Quantiles, rivals};
use crate::inversion::outcome::{Derived, Estimate, Status};
use crate::inversion::parameter::COUNT;
use crate::inversion::problem::Problem;
use crate::inversion::quantity::{Quantity, indices, with_estimates};
use crate::optimise::LeastSquares;
use crate::uncertainty::profile::profile;
use nalgebra::DVector;

/// Standard deviations below this share of a change that matters are short enough for chi² to be a parabola along them.
const STRAIGHT: f64 = 0.05;
/// Where chi² at the end of an interval has risen by less than this share of what it should, the interval ends elsewhere.
const SHORT: f64 = 0.9;
/// Where it has risen by what it should, but for this share, straight along the covariance's way, it is taken for a parabola.
const EVEN: f64 = 0.03;

/// Lets the ends of intervals move out to where the profile likelihood has them, if chi² has risen too little at them; with
/// them the standard deviations. None moves in. `unit` is the standard deviation of a weighted residual.
pub(crate) fn reach(
    found: &Found<'_>,
    problem: &Problem<'_>,
    uncertainty: &Uncertainty,
    unit: f64,
    estimates: &mut [Estimate; COUNT],
    derived: &mut Derived,
) {
    let indices = indices(found.data, &found.settings.stack);
    let all: Vec<(Quantity, &mut Estimate)> = with_estimates(indices, estimates, derived).collect();
    let is_wide = |(quantity, estimate): &(Quantity, &mut Estimate)| {
        estimate.sigma.is_some_and(|sigma| sigma > STRAIGHT * quantity.outside(quantity.typical_change()))
    };
    if !all.iter().any(is_wide) || !found.best.termination.was_successful() {
        return;
    }
    let others =
        rivals(found.solution, unit).map(|minimum| found.searched.freedom.expand(&minimum.parameters)).collect();
    let conditionals = Conditionals { compiled: found.compiled, solution: found.solution, others, unit };
    let least = problem.sum_of_squares(found.best);
    let reach = Reach { found, problem, uncertainty, conditionals, least };
    for (quantity, estimate) in all {
        let is_told = estimate.status.is_determined() || estimate.status == Status::OneSided;
        if is_told && quantity.can_be_held(&found.settings.roles, found.searched) {
            reach.of(quantity, estimate);
        }
    }
}

struct Reach<'a> {
    found: &'a Found<'a>,
    problem: &'a Problem<'a>,
    uncertainty: &'a Uncertainty,
    conditionals: Conditionals<'a>,
    /// Sum of squares at the best point.
    least: f64,
}

impl Reach<'_> {
    fn of(&self, quantity: Quantity, estimate: &mut Estimate) {
        let (Some(value), Some(sigma), Some(interval)) = (estimate.value, estimate.sigma, estimate.interval_95) else {
            return;
        };
        let Quantiles { sixty_eight, ninety_five } = self.uncertainty.quantiles;
        let should = ninety_five * ninety_five;
        let along = self.uncertainty.along(&quantity.gradient(), self.found);
        let straight = |end: f64| self.straight(along.as_ref()?, quantity.inside(end) - quantity.inside(value));
        let start = self.conditionals.start(quantity, Some(quantity.inside(sigma)));
        let is_short = |end: f64| match straight(end) {
            // The best is no higher.
            Some(risen) if risen < SHORT * should => true,
            Some(risen) if (risen / should - 1.0).abs() < EVEN => false,
            _ => {
                let there = self.conditionals.at(quantity, quantity.inside(end), &[&start.others]);
                let risen = there.map(|there| (there.sum_of_squares - start.sum_of_squares) / start.unit.powi(2));
                risen.is_some_and(|risen| risen < SHORT * should)
            }
        };
        if !interval.into_iter().flatten().any(is_short) {
            return;
        }
        let conditional = |value: f64, starts: &[&_]| self.conditionals.at(quantity, value, starts);
        let found = profile(conditional, &start, &[sixty_eight, ninety_five]);
        let outside = |interval: [Option<f64>; 2]| interval.map(|end| end.map(|end| quantity.outside(end)));
        let [one, two] = [0, 1].map(|place| found.intervals.get(place).copied().map_or([None; 2], outside));
        estimate.reach_to(one, two, ninety_five);
    }

    /// How far chi² has risen, in squared standard deviations of a residual, `step` along the covariance's way; `None` outside the
    /// bounds.
    fn straight(&self, along: &DVector<f64>, step: f64) -> Option<f64> {
        let best = self.found.best;
        let there = &best.parameters + along * step;
        let bounds = self.problem.bounds();
        let is_inside = (0..there.len()).all(|j| there[j] >= bounds.lower()[j] && there[j] <= bounds.upper()[j]);
        let rise = |there| {
            let sum = self.problem.residuals(there).norm_squared();
            (sum - self.least) / self.conditionals.unit.powi(2)
        };
        is_inside.then(|| rise(&there)).filter(|risen| risen.is_finite())
    }
}

impl Estimate {
    /// Moves the ends of the two intervals out to those of others; an end that is open in one is open.
    fn reach_to(&mut self, sixty_eight: [Option<f64>; 2], ninety_five: [Option<f64>; 2], quantile: f64) {
        let wider = |own: [Option<f64>; 2], other: [Option<f64>; 2]| {
            let [low, high] = [0, 1].map(|side| own[side].zip(other[side]));
            [low.map(|(own, other)| own.min(other)), high.map(|(own, other)| own.max(other))]
        };
        self.interval_68 = self.interval_68.map(|own| wider(own, sixty_eight));
        self.interval_95 = self.interval_95.map(|own| wider(own, ninety_five));
        self.widen_to_interval(quantile);
        self.mark_open_ends();
    }
}
