//! Samples of a probability density over a box, from an approximation by its modes.
//!
//! Ensembles of walkers are moved by two kinds of proposal, chosen at random:
//!
//! - independent draws from a mixture of Student distributions, one about each mode: where the mixture is near the
//!   density, most are accepted and successive samples are all but independent;
//! - differential evolution, which needs no approximation, for what no mixture fits.
//!
//! In a warm-up the mixture is fitted to the history and the share of the moves is set by what was accepted. All of that
//! is thrown away, and nothing is adapted while samples are kept, so that they are of the density itself. Sampling ends by
//! [`Convergence`] over all walkers, or with the budget.
//!
//! Sampling that ends by the look of its chains favours those that have not yet met a rare, far tail: on a strongly curved
//! ridge, second moments come out one to three per cent small.
//!
//! No mode that neither the approximation nor the walkers ever touch is found: it is a sampler, not a search.

mod ensemble;
mod mixture;
mod settings;
mod start;
#[cfg(test)]
mod tests;

pub use settings::{Mode, SamplerError, SamplerSettings};

use crate::optimise::Bounds;
use crate::uncertainty::convergence::Convergence;
use ensemble::{Ensemble, Moves};
use mixture::Mixture;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::{IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use start::Start;

/// Largest split-R̂ of chains that agree (Vehtari et al. 2021).
const AGREEMENT: f64 = 1.01;
/// Steps of the first rounds of the warm-up; the last number is repeated.
const ROUNDS: [usize; 3] = [10, 20, 30];
/// Rounds at most.
const MAX_ROUNDS: usize = 12;
/// Kept samples that are worth less than this part of their number are given up for one more fit of the mixture.
const POOR: f64 = 0.15;
/// So many times at most: giving up what looks poor favours chains that did not get caught in a tail.
const MAX_REFITS: usize = 5;
/// A round that raises the share of accepted draws by less than this, ends the warm-up,
const IMPROVEMENT: f64 = 0.03;
/// and so does a share that is as good as this.
const ENOUGH: f64 = 0.7;
/// The warm-up takes at most one part in so many of the budget.
const WARM_UP_PART: usize = 3;
/// Samples at most that the mixture is fitted to.
const FITTED: usize = 4000;
/// Acceptance of independent draws at which half of the moves are of that kind: a jump of differential evolution is worth
/// about a twentieth of an independent sample.
const EVEN: f64 = 0.05;
/// Smallest and largest share of independent draws.
const SHARES: [f64; 2] = [0.1, 0.95];
/// Largest share where the mixture needed more components than there are modes: what it still misses at the ends of a
/// curved ridge is reached by jumps.
const CURVED_SHARE: f64 = 0.8;
/// Steps of the first batch that is kept; a later one is as long as what is still missing asks for.
const FIRST_BATCH: usize = 60;

/// How many proposals of one kind were made and accepted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Acceptance {
    /// Proposals, those outside the box among them.
    pub proposed: usize,
    /// Of these accepted.
    pub accepted: usize,
}

impl Acceptance {
    /// Accepted share, 0 without proposals.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    pub fn share(&self) -> f64 {
        self.accepted as f64 / self.proposed.max(1) as f64
    }

    fn sum(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::default(), |sum, one| Self {
            proposed: sum.proposed + one.proposed,
            accepted: sum.accepted + one.accepted,
        })
    }
}

/// Why sampling ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stopped {
    /// All chains agree and are worth the number of samples asked for.
    Converged,
    /// The evaluations allowed were used up.
    Budget,
    /// Too few points of finite density were found to start from; there are no samples.
    NoStart,
}

/// Samples of a density over `d` parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// Samples, `[n, d]`: the steps of the first chain, those of the second, ...
    pub samples: DMatrix<f64>,
    /// Logarithm of the density at each, as the target gave it, `[n]`.
    pub log_densities: DVector<f64>,
    /// Number of chains, one for each walker; each has `n / chains` steps.
    pub chains: usize,
    /// Chains that shared one ensemble, next to each other in `samples`; ensembles are independent of each other.
    pub chains_per_ensemble: usize,
    /// Calls of the target, those of the warm-up among them.
    pub evaluations: usize,
    /// Calls before the first sample that was kept.
    pub warm_up_evaluations: usize,
    /// Independent draws, after the warm-up.
    pub independence: Acceptance,
    /// Jumps by differential evolution, after the warm-up.
    pub evolution: Acceptance,
    /// Components of the mixture after the warm-up.
    pub components: usize,
    /// Agreement and effective sample sizes of each parameter, `[d]`; `None` where chains are too short or stand still.
    pub convergence: Vec<Option<Convergence>>,
    /// Why it ended.
    pub stopped: Stopped,
}

impl Posterior {
    /// The chains of one parameter, `[chain][step]`; none if there is no such parameter.
    #[must_use]
    pub fn traces(&self, parameter: usize) -> Vec<&[f64]> {
        if parameter >= self.samples.ncols() || self.samples.nrows() == 0 {
            return Vec::new();
        }
        let column = parameter * self.samples.nrows();
        let values = self.samples.as_slice().get(column..column + self.samples.nrows()).unwrap_or(&[]);
        values.chunks_exact((self.samples.nrows() / self.chains.max(1)).max(1)).collect()
    }

    /// Smallest effective sample size, of bulk or tail, over all parameters; `None` if one has none.
    #[must_use]
    pub fn effective(&self) -> Option<f64> {
        smallest(&self.convergence)
    }
}

fn smallest(convergence: &[Option<Convergence>]) -> Option<f64> {
    convergence.iter().try_fold(f64::INFINITY, |least, one| one.map(|one| least.min(one.bulk).min(one.tail)))
}

fn largest(convergence: &[Option<Convergence>]) -> Option<f64> {
    convergence.iter().try_fold(1.0, |most: f64, one| one.map(|one| most.max(one.r_hat)))
}

/// Samples the density `exp(target)` over a box.
///
/// - `target`: logarithm of the density up to a constant; where it is not finite, the density is 0. It is not called
///   outside the box.
/// - `bounds`: the box, open on any side; the density must have a finite integral over it.
/// - `modes`: where the density is, at least one. Covariances need not be right, but a mode that is far too narrow or too wide
///   costs warm-up. Weights may be wrong too.
/// - `progress`: told in words how far it is, from the calling thread.
///
/// # Seed
/// The same settings give the same samples whatever the number of threads, if `target` depends on nothing but its argument.
///
/// # Errors
/// [`SamplerError`] if there is no mode, or one does not fit the box or is not finite. How the sampling ended is in
/// [`Posterior::stopped`].
///
/// # Examples
/// ```
/// use morpho_fit::optimise::Bounds;
/// use morpho_fit::uncertainty::posterior::{Mode, SamplerSettings, Stopped, sample};
/// use nalgebra::{DMatrix, DVector};
/// // exp(-x) over x > 0: mean 1
/// let bounds = Bounds::new(&[0.0], &[f64::INFINITY])?;
/// let mode = Mode { centre: DVector::zeros(1), covariance: DMatrix::identity(1, 1), log_weight: 0.0 };
/// let found = sample(|x| -x[0], &bounds, &[mode], &SamplerSettings::default(), &|_| {})?;
/// assert_eq!(found.stopped, Stopped::Converged);
/// assert!((found.samples.mean() - 1.0).abs() < 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn sample(
    target: impl Fn(&DVector<f64>) -> f64 + Sync,
    bounds: &Bounds,
    modes: &[Mode],
    settings: &SamplerSettings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Posterior, SamplerError> {
    let start = Start::new(bounds, modes, settings)?;
    let walkers = start.walkers();
    let mut run = Run {
        target: &target,
        bounds,
        ensembles: Vec::new(),
        mixture: start.mixture.clone(),
        share: f64::midpoint(SHARES[0], SHARES[1]),
        per_step: walkers * start.ensembles,
        spent: 0,
    };
    let Some(ensembles) = start.ensembles(&target, bounds, settings, &mut run.spent) else {
        return Ok(run.finish(Vec::new(), 0, 0, Stopped::NoStart));
    };
    run.ensembles = ensembles;
    run.warm_up(settings, progress);
    let (convergence, warm_up, stopped) = run.keep(settings, progress);
    Ok(run.finish(convergence, walkers, warm_up, stopped))
}

/// A run under way.
struct Run<'a> {
    target: &'a (dyn Fn(&DVector<f64>) -> f64 + Sync),
    bounds: &'a Bounds,
    ensembles: Vec<Ensemble>,
    mixture: Mixture,
    share: f64,
    /// Evaluations of one step of all ensembles at most.
    per_step: usize,
    /// Evaluations of the start.
    spent: usize,
}

impl Run<'_> {
    fn evaluations(&self) -> usize {
        self.spent + self.ensembles.iter().map(|ensemble| ensemble.evaluations).sum::<usize>()
    }

    /// `steps` steps, or as many as the evaluations up to `limit` allow. Returns their number.
    fn advance(&mut self, steps: usize, limit: usize) -> usize {
        let steps = steps.min(limit.saturating_sub(self.evaluations()) / self.per_step.max(1));
        let moves = Moves {
            target: self.target,
            bounds: self.bounds,
            mixture: &self.mixture,
            deviations: self.mixture.deviations(),
            share: self.share,
        };
        self.ensembles.par_iter_mut().for_each(|ensemble| ensemble.run(&moves, steps));
        steps
    }

    fn independence(&self) -> Acceptance {
        Acceptance::sum(self.ensembles.iter().map(|ensemble| ensemble.independence))
    }

    fn warm_up(&mut self, settings: &SamplerSettings, progress: &(dyn Fn(&str) + Sync)) {
        let limit = settings.max_evaluations / WARM_UP_PART;
        let mut before = 0.0;
        for round in 0..MAX_ROUNDS {
            let steps = ROUNDS[round.min(ROUNDS.len() - 1)];
            if self.advance(steps, limit) < steps {
                break;
            }
            let accepted = self.independence().share();
            progress(&format!("warm-up {}: {:.0} % of independent draws accepted", round + 1, 100.0 * accepted));
            self.adapt(accepted);
            if round + 1 >= ROUNDS.len() && (accepted < before + IMPROVEMENT || accepted > ENOUGH) {
                break;
            }
            before = accepted;
        }
        self.ensembles.iter_mut().for_each(Ensemble::clear);
    }

    /// Fits the mixture to the later half of the history.
    fn adapt(&mut self, accepted: f64) {
        let mut halves = [Vec::new(), Vec::new()];
        let steps = self.ensembles.iter().flat_map(|ensemble| &ensemble.history).map(Vec::len).max().unwrap_or(0);
        let every = (steps.div_ceil(2) * self.per_step).div_ceil(FITTED).max(1);
        for ensemble in &self.ensembles {
            for (walker, history) in ensemble.history.iter().enumerate() {
                halves[walker % 2].extend(history.iter().skip(steps / 2 + walker % every).step_by(every).cloned());
            }
        }
        self.mixture = self.mixture.refitted(&halves[0], &halves[1]);
        let odds = (accepted / EVEN).powi(2);
        let most = if self.mixture.is_extended() { CURVED_SHARE } else { SHARES[1] };
        self.share = (odds / (1.0 + odds)).clamp(SHARES[0], most);
        self.ensembles.iter_mut().for_each(Ensemble::forget_moves);
    }

    /// Samples that are kept, until they are enough. Where they are worth little they become warm-up: the longer history
    /// shows the mixture what it missed. Returns how they converged and the evaluations before them.
    fn keep(
        &mut self,
        settings: &SamplerSettings,
        progress: &(dyn Fn(&str) + Sync),
    ) -> (Vec<Option<Convergence>>, usize, Stopped) {
        #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
        let count = |number: usize| number as f64;
        let mut warm_up = self.evaluations();
        let mut refits = 0;
        let mut steps = 0;
        let mut batch = FIRST_BATCH;
        loop {
            let done = self.advance(batch, settings.max_evaluations);
            steps += done;
            let convergence = self.convergence();
            let (effective, r_hat) = (smallest(&convergence), largest(&convergence));
            let (worth, apart) = (effective.unwrap_or(0.0), r_hat.unwrap_or(f64::INFINITY));
            progress(&format!("{} samples, worth {worth:.0}, split-R̂ {apart:.3}", steps * self.per_step));
            if apart < AGREEMENT && worth >= settings.effective {
                return (convergence, warm_up, Stopped::Converged);
            }
            if done < batch {
                return (convergence, warm_up, Stopped::Budget);
            }
            let poor = worth < POOR * count(steps * self.per_step);
            if poor && refits < MAX_REFITS && self.evaluations() < settings.max_evaluations / WARM_UP_PART {
                self.adapt(self.independence().share());
                self.ensembles.iter_mut().for_each(Ensemble::clear);
                warm_up = self.evaluations();
                refits += 1;
                batch = steps;
                steps = 0;
                continue;
            }
            batch = missing_steps(steps, settings.effective / worth, (apart - 1.0) / (AGREEMENT - 1.0));
        }
    }

    fn convergence(&self) -> Vec<Option<Convergence>> {
        let histories = || self.ensembles.iter().flat_map(|ensemble| &ensemble.history);
        let chain = |j: usize| move |history: &Vec<(DVector<f64>, f64)>| history.iter().map(|(x, _)| x[j]).collect();
        let of = |j: usize| {
            let chains: Vec<Vec<f64>> = histories().map(chain(j)).collect();
            Convergence::of(&chains.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        (0..self.bounds.len()).into_par_iter().map(of).collect()
    }

    fn finish(
        self,
        convergence: Vec<Option<Convergence>>,
        chains_per_ensemble: usize,
        warm_up_evaluations: usize,
        stopped: Stopped,
    ) -> Posterior {
        let d = self.bounds.len();
        let histories: Vec<_> = self.ensembles.iter().flat_map(|ensemble| &ensemble.history).collect();
        let points: Vec<&(DVector<f64>, f64)> = histories.iter().copied().flatten().collect();
        Posterior {
            samples: DMatrix::from_fn(points.len(), d, |i, j| points[i].0[j]),
            log_densities: DVector::from_iterator(points.len(), points.iter().map(|point| point.1)),
            chains: histories.len(),
            chains_per_ensemble,
            evaluations: self.evaluations(),
            warm_up_evaluations: if stopped == Stopped::NoStart { self.spent } else { warm_up_evaluations },
            independence: self.independence(),
            evolution: Acceptance::sum(self.ensembles.iter().map(|ensemble| ensemble.evolution)),
            components: self.mixture.len(),
            convergence: if convergence.is_empty() { vec![None; d] } else { convergence },
            stopped,
        }
    }
}

/// Further steps after `steps`, if the effective size has to grow by `growth` and the excess of R̂, which falls as the
/// inverse of the steps, by `excess`. Between a tenth and twice of what there is: the estimates are rough.
fn missing_steps(steps: usize, growth: f64, excess: f64) -> usize {
    #[allow(clippy::cast_precision_loss, reason = "counts of steps are below 2^53")]
    let done = steps as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0.1 and 2 times a count")]
    let more = (done * (1.02 * growth.max(excess) - 1.0).clamp(0.1, 2.0)).ceil() as usize;
    more.max(1)
}
