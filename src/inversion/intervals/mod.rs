//! Four intervals for each number of a fit: covariance, profile likelihood, bootstrap and posterior.
//!
//! The covariance comes with every [`fit`](fn@crate::inversion::fit); the others ask the model again, some thousand times.
//! Where they agree the problem is as good as linear; where they part by more than a fifth, [`compare`] says so.

mod bootstrap;
mod compare;
mod constant;
mod posterior;
mod profile;

pub use bootstrap::{Bootstrap, BootstrapSettings, Resampling, bootstrap};
pub use compare::{BootstrapFound, IntervalsFound, Method, MethodIntervals, PosteriorFound, UncertaintyFound, compare};
pub use constant::{ConstantProfile, QuantityOver, over_constant};
pub use posterior::{Posterior, PosteriorSettings, posterior};
pub use profile::{Profiles, QuantityProfile, profiles};

use crate::inversion::outcome::{Fit, FitOutcome, SigmaSource};
use crate::inversion::quantity::Quantity;
use crate::inversion::solution::Solution;
use crate::optimise::Minimum;
use crate::uncertainty::goodness::{NINETY_FIVE, ONE_SIGMA, student};
use serde::{Deserialize, Serialize};

/// Minima within this chi² of the best take part in intervals: five standard deviations of one parameter.
const RIVAL: f64 = 25.0;
/// Minima that take part at most.
const RIVALS: usize = 6;

/// Two intervals, in the user's unit; an end that is open, at a bound, is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IntervalPair {
    /// Of 68.3 %.
    pub interval_68: [Option<f64>; 2],
    /// Of 95 %.
    pub interval_95: [Option<f64>; 2],
}

/// Half-widths of the two intervals in standard deviations: normal where sigma is stated, Student's t where it is not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quantiles {
    pub(crate) sixty_eight: f64,
    pub(crate) ninety_five: f64,
}

impl Quantiles {
    pub(crate) fn new(source: SigmaSource, dof: usize) -> Self {
        let of = |z| if source == SigmaSource::Stated { z } else { student(z, dof) };
        Self { sixty_eight: of(ONE_SIGMA), ninety_five: of(NINETY_FIVE) }
    }

    pub(crate) fn of(outcome: &FitOutcome) -> Self {
        Self::new(outcome.sigma_source, outcome.dof)
    }

    /// Factors on the half-widths of the two intervals of `quantity` for what the model's misses add.
    fn stretch(self, quantity: Quantity, outcome: &FitOutcome) -> [f64; 2] {
        let Some(factor) = quantity.estimate(outcome).widened_by else { return [1.0; 2] };
        let [sixty_eight, ninety_five] = outcome.quantiles;
        [factor * sixty_eight / self.sixty_eight, factor * ninety_five / self.ninety_five]
    }
}

/// Intervals of a method stretched about the best value as those of the covariance are, where the model misses the data;
/// user units. An end that leaves `limits` is open.
pub(crate) fn stretched(
    pair: IntervalPair,
    quantity: Quantity,
    fit: &Fit,
    best: f64,
    limits: [f64; 2],
) -> IntervalPair {
    let [one, two] = Quantiles::of(&fit.outcome).stretch(quantity, &fit.outcome);
    let end = |end: Option<f64>, factor: f64| {
        let moved = end.map(|end| best + factor * (end - best))?;
        (factor <= 1.0 || (limits[0] < moved && moved < limits[1])).then_some(moved)
    };
    IntervalPair {
        interval_68: pair.interval_68.map(|ours| end(ours, one)),
        interval_95: pair.interval_95.map(|ours| end(ours, two)),
    }
}

/// Minima beside the best that are not far above it; `unit` is the standard deviation of a weighted residual.
pub(crate) fn rivals(solution: &Solution, unit: f64) -> impl Iterator<Item = &Minimum> {
    let best = solution.minima.first().map_or(0.0, |minimum| minimum.sum_of_squares);
    let far = RIVAL * unit * unit;
    solution.minima.iter().skip(1).filter(move |minimum| minimum.sum_of_squares - best < far).take(RIVALS)
}
