//! The posterior of a fit: what is believed of the parameters after the data, sampled.

use crate::dataset::Dataset;
use crate::inversion::atlas::laplace;
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::FitError;
use crate::inversion::intervals::{IntervalPair, rivals, stretched};
use crate::inversion::marginal::{Likelihood, Noise};
use crate::inversion::outcome::Fit;
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::quantity::Quantity;
use crate::inversion::solution::Solution;
use crate::inversion::space::Space;
use crate::numerics::quantile::{NINETY_FIVE, SIXTY_EIGHT, central};
use crate::optimise::{Bounds, BoundsError, Minimum};
use crate::uncertainty::convergence::Convergence;
use crate::uncertainty::posterior::{self as sampler, Mode, SamplerSettings, Stopped};
use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

/// The choices of a posterior.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PosteriorSettings {
    /// Effective samples wanted of every parameter, in the bulk and in the tails.
    pub effective: usize,
    /// Evaluations of the model at most.
    pub max_evaluations: usize,
    /// Seed of all draws.
    pub seed: u64,
}

impl PosteriorSettings {
    /// 4000 effective samples with at most 400 000 evaluations.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { effective: 4000, max_evaluations: 400_000, seed }
    }
}

/// Samples of the posterior.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior {
    /// Names of the quantities, as in `fit.json`.
    pub names: Vec<&'static str>,
    /// Their units.
    pub units: Vec<&'static str>,
    /// A row for each sample, a column for each quantity, user units; the steps of the first chain, then the second's, ...
    pub samples: Vec<Vec<f64>>,
    /// Chains, of equal length.
    pub chains: usize,
    /// Agreement and effective sample size of each quantity; `None` where it does not move.
    pub convergence: Vec<Option<Convergence>>,
    /// Credible intervals with equal tails, one for each quantity; open only where they are stretched to a bound.
    pub intervals: Vec<IntervalPair>,
    /// Share of the posterior about each minimum of the fit, in their order.
    pub weights: Vec<f64>,
    /// Evaluations of the model.
    pub evaluations: usize,
    /// Accepted share of independent draws, and of jumps by differential evolution.
    pub acceptance: [f64; 2],
    /// Whether the chains agree and are worth the samples asked for.
    pub converged: bool,
}

/// Samples the posterior of the free parameters.
///
/// ```text
/// p(parameters | data) ~ integral of exp(-chi²/(2 unit²)) sqrt(det G) dc,   parameters flat within their bounds
/// ```
///
/// over the linear nuisances `c >= 0`, whose prior `sqrt(det G)`, with the normal matrix G of their columns, is flat in what
/// they add to the curve: a structure is not favoured because it reflects little and needs a large scale. Where the data
/// state no sigma, it is integrated over with the prior `1/sigma`. `unit` is the factor by which intervals are widened
/// where the model misses the data. With a robust loss the weights of the fit stand.
///
/// # Errors
/// [`FitError`] if `data` are not those of `fit`, or if no parameter is free.
///
/// # Source
/// The sampler: [`crate::uncertainty::posterior`].
pub fn posterior(
    data: &Dataset,
    fit: &Fit,
    settings: &PosteriorSettings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Posterior, FitError> {
    let model = fit.outcome.settings.forward()?;
    let compiled = Compiled::of_fit(data, fit, model.as_ref())?;
    let solution = &fit.solution;
    let noise = Noise::of(data, fit);
    let likelihood = Likelihood::new(&compiled, &solution.searched, &solution.robust, noise);
    #[allow(clippy::cast_precision_loss, reason = "numbers of samples are below 2^53")]
    let sampler_settings = SamplerSettings {
        effective: settings.effective as f64,
        max_evaluations: settings.max_evaluations,
        seed: settings.seed,
        ..SamplerSettings::default()
    };
    let seen = Seen::new(&compiled, &solution.searched);
    let modes: Vec<Mode> = std::iter::once(&solution.minima[0])
        .chain(rivals(solution, solution.unit))
        .filter_map(|minimum| mode(solution, minimum))
        .map(|mode| seen.restrict(&mode))
        .collect();
    let middle = &solution.minima[0].parameters;
    let target = |sampled: &DVector<f64>| likelihood.log(&seen.complete(sampled, middle));
    let drawn = sampler::sample(target, &seen.bounds(&solution.searched)?, &modes, &sampler_settings, progress)?;
    let whole = seen.filled(&drawn.samples, &solution.searched, settings.seed);
    let quantities = Quantity::moving(&compiled, &solution.searched);
    let values: Vec<[f64; COUNT]> =
        whole.row_iter().map(|row| solution.searched.freedom.expand(&row.transpose())).collect();
    let of = |values: &[f64; COUNT]| quantities.iter().map(|q| q.outside(q.of(values))).collect::<Vec<f64>>();
    let samples: Vec<Vec<f64>> = values.iter().map(of).collect();
    let columns: Vec<Vec<f64>> =
        (0..quantities.len()).map(|column| samples.iter().map(|row| row[column]).collect()).collect();
    let steps = samples.len() / drawn.chains.max(1);
    let convergence = |column: &Vec<f64>| {
        let chains: Vec<&[f64]> = column.chunks_exact(steps.max(1)).collect();
        Convergence::of(&chains)
    };
    let at_best = solution.searched.freedom.expand(&solution.minima[0].parameters);
    let intervals = |(column, &quantity): (&Vec<f64>, &Quantity)| {
        let mut rising = column.clone();
        rising.sort_by(f64::total_cmp);
        let interval = |share| central(&rising, share).map_or([None, None], |ends| ends.map(Some));
        let pair = IntervalPair { interval_68: interval(SIXTY_EIGHT), interval_95: interval(NINETY_FIVE) };
        let (low, high) = quantity.limits(&solution.searched);
        let (best, limits) = (quantity.outside(quantity.of(&at_best)), [low, high].map(|end| quantity.outside(end)));
        stretched(pair, quantity, fit, best, limits)
    };
    Ok(Posterior {
        names: quantities.iter().map(|quantity| quantity.name()).collect(),
        units: quantities.iter().map(|quantity| quantity.unit()).collect(),
        chains: drawn.chains,
        convergence: columns.iter().map(convergence).collect(),
        intervals: columns.iter().zip(&quantities).map(intervals).collect(),
        weights: weights(solution, &whole),
        evaluations: drawn.evaluations,
        acceptance: [drawn.independence.share(), drawn.evolution.share()],
        converged: drawn.stopped == Stopped::Converged,
        samples,
    })
}

/// The free parameters that the data see at all: the posterior of the others is their prior, and needs no sampler.
struct Seen(Vec<usize>);

impl Seen {
    fn new(compiled: &Compiled<'_>, space: &Space) -> Self {
        let moves = |column: usize, parameter: Parameter| {
            space.freedom.matrix()[(parameter.index(), column)].abs() > 0.0 && compiled.plan.sees(parameter)
        };
        let all = 0..space.freedom.free.len();
        let seen: Vec<usize> =
            all.clone().filter(|&column| Parameter::ALL.iter().any(|&parameter| moves(column, parameter))).collect();
        Self(if seen.is_empty() { all.collect() } else { seen })
    }

    fn of(&self, whole: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.0.len(), self.0.iter().map(|&column| whole[column]))
    }

    fn bounds(&self, space: &Space) -> Result<Bounds, BoundsError> {
        let (lower, upper) = (self.of(space.bounds.lower()), self.of(space.bounds.upper()));
        Bounds::new(lower.as_slice(), upper.as_slice())
    }

    fn restrict(&self, mode: &Mode) -> Mode {
        let covariance = mode.covariance.select_rows(&self.0).select_columns(&self.0);
        Mode { centre: self.of(&mode.centre), covariance, log_weight: mode.log_weight }
    }

    /// All free parameters, those that are not seen as in `whole`.
    fn complete(&self, sampled: &DVector<f64>, whole: &DVector<f64>) -> DVector<f64> {
        let mut whole = whole.clone();
        for (value, &column) in sampled.iter().zip(&self.0) {
            whole[column] = *value;
        }
        whole
    }

    /// All free parameters for each sample, those that are not seen drawn evenly from their bounds.
    fn filled(&self, samples: &DMatrix<f64>, space: &Space, seed: u64) -> DMatrix<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let (lower, ranges) = (space.bounds.lower(), &space.ranges);
        let mut whole = DMatrix::zeros(samples.nrows(), lower.len());
        for row in 0..samples.nrows() {
            for column in 0..lower.len() {
                whole[(row, column)] = match self.0.iter().position(|&seen| seen == column) {
                    Some(place) => samples[(row, place)],
                    None => lower[column] + ranges[column] * random.random::<f64>(),
                };
            }
        }
        whole
    }
}

fn mode(solution: &Solution, minimum: &Minimum) -> Option<Mode> {
    let (covariance, log_weight) = laplace(minimum, &solution.minima[0], &solution.searched.ranges, solution.unit)?;
    Some(Mode { centre: minimum.parameters.clone(), covariance, log_weight })
}

/// Share of the samples that are nearest to each minimum, in its own covariance.
fn weights(solution: &Solution, samples: &DMatrix<f64>) -> Vec<f64> {
    let inverse: Vec<Option<(DVector<f64>, DMatrix<f64>)>> = (solution.minima.iter())
        .map(|minimum| {
            let mode = mode(solution, minimum)?;
            Some((mode.centre, mode.covariance.cholesky()?.inverse()))
        })
        .collect();
    let mut counts = vec![0.0; inverse.len()];
    for sample in samples.row_iter() {
        let sample = sample.transpose();
        let distance = |of: &Option<(DVector<f64>, DMatrix<f64>)>| {
            of.as_ref().map_or(f64::INFINITY, |(centre, inverse)| {
                let step = &sample - centre;
                (inverse * &step).dot(&step)
            })
        };
        let nearest = (inverse.iter().map(distance).enumerate()).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((nearest, _)) = nearest {
            counts[nearest] += 1.0;
        }
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    let all = samples.nrows().max(1) as f64;
    counts.iter().map(|count| count / all).collect()
}
