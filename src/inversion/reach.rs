//! Intervals that reach as far as chi² lets them: where it rises more slowly than a parabola with the curvature at the minimum,
//! those of the covariance are too short.

use crate::inversion::conditional::Conditionals;
use crate::inversion::estimates::Found;
use crate::inversion::intervals::{Quantiles, rivals};
use crate::inversion::outcome::{Derived, Estimate, Status};
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::quantity::{Quantity, indices};
use crate::uncertainty::profile::profile;

/// Standard deviations below this share of a change that matters are short enough for chi² to be a parabola along them.
const STRAIGHT: f64 = 0.05;
/// Where chi² at the end of an interval has risen by less than this share of what it should, the interval ends elsewhere.
const SHORT: f64 = 0.9;

/// Lets the ends of intervals move out to where the profile likelihood has them, if chi² has risen too little at them; with
/// them the standard deviations. None moves in. `unit` is the standard deviation of a weighted residual.
pub(crate) fn reach(
    found: &Found<'_>,
    unit: f64,
    quantiles: Quantiles,
    estimates: &mut [Estimate; COUNT],
    derived: &mut Derived,
) {
    let (gap, cuticle) = indices(found.data, &found.settings.stack);
    let sums = [Quantity::Period, Quantity::OpticalSum { gap, cuticle }];
    let quantities = Parameter::ALL.into_iter().map(Quantity::Parameter).chain(sums);
    let all: Vec<(Quantity, &mut Estimate)> =
        quantities.zip(estimates.iter_mut().chain([&mut derived.period, &mut derived.optical_sum])).collect();
    let is_wide = |(quantity, estimate): &(Quantity, &mut Estimate)| {
        estimate.sigma.is_some_and(|sigma| sigma > STRAIGHT * quantity.outside(quantity.typical_change()))
    };
    if !all.iter().any(is_wide) || !found.best.termination.was_successful() {
        return;
    }
    let others =
        rivals(found.solution, unit).map(|minimum| found.searched.freedom.expand(&minimum.parameters)).collect();
    let conditionals = Conditionals { compiled: found.compiled, solution: found.solution, others, unit };
    for (quantity, estimate) in all {
        let is_told = estimate.status.is_determined() || estimate.status == Status::OneSided;
        if is_told && quantity.can_be_held(&found.settings.roles, found.searched) {
            reach_of(&conditionals, quantity, quantiles, estimate);
        }
    }
}

fn reach_of(conditionals: &Conditionals<'_>, quantity: Quantity, quantiles: Quantiles, estimate: &mut Estimate) {
    let (Some(sigma), Some(interval)) = (estimate.sigma, estimate.interval_95) else { return };
    let start = conditionals.start(quantity, Some(quantity.inside(sigma)));
    let Quantiles { sixty_eight, ninety_five } = quantiles;
    let is_short = |end: f64| {
        let there = conditionals.at(quantity, quantity.inside(end), &[&start.others]);
        let risen = there.map(|there| (there.sum_of_squares - start.sum_of_squares) / (start.unit * start.unit));
        risen.is_some_and(|risen| risen < SHORT * ninety_five * ninety_five)
    };
    if !interval.into_iter().flatten().any(is_short) {
        return;
    }
    let conditional = |value: f64, starts: &[&_]| conditionals.at(quantity, value, starts);
    let found = profile(conditional, &start, &[sixty_eight, ninety_five]);
    let outside = |interval: [Option<f64>; 2]| interval.map(|end| end.map(|end| quantity.outside(end)));
    let [one, two] = [0, 1].map(|place| found.intervals.get(place).copied().map_or([None; 2], outside));
    estimate.reach_to(one, two, ninety_five);
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
