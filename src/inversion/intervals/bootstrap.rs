//! The bootstrap: the fit of data sets drawn from the data themselves.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::FitError;
use crate::inversion::intervals::{IntervalPair, rivals, stretched};
use crate::inversion::outcome::{Fit, SigmaSource};
use crate::inversion::parameter::COUNT;
use crate::inversion::problem::Problem;
use crate::inversion::quantity::Quantity;
use crate::numerics::quantile::{NINETY_FIVE, SIXTY_EIGHT, central};
use crate::optimise::{LeastSquares, Loss, Minimum, Tolerances, minimise};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tolerances of one replicate: the parameters to far less than their spread.
const REPLICATE: Tolerances = Tolerances { cost: 1e-8, step: 1e-7, gradient: 1e-11, max_evaluations: 80, escapes: 1 };
/// An end nearer to a limit than this share of the range lies on it.
const ON_LIMIT: f64 = 1e-9;
/// Replicates between two words of progress.
const TOLD: usize = 50;

/// What is drawn again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resampling {
    /// Residuals, added to the fitted curve: keeps the design; neighbours together where they agree.
    Residuals,
    /// Readings, with their geometry: keeps nothing fixed, and trusts the model least.
    Cases,
}

/// The choices of a bootstrap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct BootstrapSettings {
    /// What is drawn again.
    pub resampling: Resampling,
    /// Data sets.
    pub replicates: usize,
    /// Seed of the draws.
    pub seed: u64,
}

impl BootstrapSettings {
    /// 1000 replicates.
    #[must_use]
    pub fn new(resampling: Resampling, seed: u64) -> Self {
        Self { resampling, replicates: 1000, seed }
    }
}

/// The fits of the replicates.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap {
    /// What was drawn again.
    pub resampling: Resampling,
    /// Names of the quantities, as in `fit.json`.
    pub names: Vec<&'static str>,
    /// Their units.
    pub units: Vec<&'static str>,
    /// A row for each replicate that was fitted, a column for each quantity; user units.
    pub replicates: Vec<Vec<f64>>,
    /// Percentile intervals, one for each quantity.
    pub intervals: Vec<IntervalPair>,
    /// Replicates whose fit ended without a minimum; they are left out.
    pub failed: usize,
    /// Readings that were drawn together, as neighbours: 1 unless the residuals of the fit are correlated.
    pub block: usize,
}

/// Fits replicates of the data, each from the best minimum and from its rivals.
///
/// ```text
/// residuals   y*_i = model_i + sigma_i e_j,   e = weighted residuals of the same curve, brought to the size of the noise
/// cases       chi²* = sum_i m_i r_i²,   m_i = how often reading i of its curve was drawn
/// ```
///
/// The size is 1 where sigma is stated, else the scatter. What the data do not determine stays where the fit held it.
/// Intervals are percentiles: half of what is left out lies on either side.
///
/// # Errors
/// [`FitError`] if `data` are not those of `fit`, or if its loss is robust: the weights that tame outliers are not those of
/// the readings they would be drawn to.
///
/// # Seed
/// Each replicate has a generator of its own: the number of threads changes nothing.
///
/// # Source
/// Efron and Tibshirani 1993, *An Introduction to the Bootstrap*, §9 and §13; blocks of neighbours: Künsch 1989,
/// DOI 10.1214/aos/1176347265.
pub fn bootstrap(
    data: &Dataset,
    fit: &Fit,
    settings: &BootstrapSettings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Bootstrap, FitError> {
    if fit.outcome.settings.loss != Loss::Linear {
        return Err(FitError::RobustBootstrap);
    }
    let model = fit.outcome.settings.forward()?;
    let compiled = Compiled::of_fit(data, fit, model.as_ref())?;
    let solution = &fit.solution;
    let quantities = Quantity::moving(&compiled, &solution.space);
    let draws = Draws::new(&compiled, fit);
    let starts: Vec<[f64; COUNT]> = std::iter::once(&solution.best)
        .map(|best| solution.space.freedom.expand(&best.parameters))
        .chain(rivals(solution, solution.unit).map(|rival| solution.searched.freedom.expand(&rival.parameters)))
        .collect();
    let done = AtomicUsize::new(0);
    let of = match settings.resampling {
        Resampling::Residuals => "residuals",
        Resampling::Cases => "readings",
    };
    let replicate = |index: usize| {
        let mut random = generator(settings.seed, index);
        let (plan, weights);
        let problem = match settings.resampling {
            Resampling::Residuals => {
                plan = compiled.with_intensities(&draws.intensities(&mut random));
                Problem::new(&plan, &solution.space, &solution.robust)
            }
            Resampling::Cases => {
                weights = draws.counts(&mut random, &solution.robust);
                Problem::new(&compiled, &solution.space, &weights)
            }
        };
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(TOLD) {
            progress(&format!("bootstrap of {of}: {count} of {}", settings.replicates));
        }
        let values = refit(&problem, &starts, solution.space.freedom.free.len())?;
        Some(quantities.iter().map(|quantity| quantity.outside(quantity.of(&values))).collect::<Vec<f64>>())
    };
    let found: Vec<Option<Vec<f64>>> = (0..settings.replicates).into_par_iter().map(replicate).collect();
    let replicates: Vec<Vec<f64>> = found.into_iter().flatten().collect();
    let intervals = (quantities.iter().enumerate())
        .map(|(column, quantity)| {
            let mut values: Vec<f64> = replicates.iter().map(|row| row[column]).collect();
            values.sort_by(f64::total_cmp);
            let (low, high) = quantity.limits(&solution.space);
            let (low, high) = (quantity.outside(low), quantity.outside(high));
            let margin = ON_LIMIT * (high - low);
            let interval = |share| match central(&values, share) {
                Some([a, b]) => [(a > low + margin).then_some(a), (b < high - margin).then_some(b)],
                None => [None, None],
            };
            let pair = IntervalPair { interval_68: interval(SIXTY_EIGHT), interval_95: interval(NINETY_FIVE) };
            let best = quantity.outside(quantity.of(&starts[0]));
            stretched(pair, *quantity, fit, best, [low, high])
        })
        .collect();
    Ok(Bootstrap {
        resampling: settings.resampling,
        names: quantities.iter().map(|quantity| quantity.name()).collect(),
        units: quantities.iter().map(|quantity| quantity.unit()).collect(),
        failed: settings.replicates - replicates.len(),
        replicates,
        intervals,
        block: draws.block,
    })
}

/// The five parameters of the lowest minimum that the starts lead to.
fn refit(problem: &Problem<'_>, starts: &[[f64; COUNT]], free: usize) -> Option<[f64; COUNT]> {
    if free == 0 {
        return None;
    }
    let run = |start: &[f64; COUNT]| {
        let start = problem.bounds().clamp(&problem.space().freedom.restrict(start));
        minimise(problem, &start, REPLICATE)
    };
    let best = starts.iter().map(run).filter(|run| run.termination.was_successful());
    let best: Option<Minimum> = best.min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares));
    best.map(|best| problem.space().freedom.expand(&best.parameters))
}

/// A generator for one replicate: neighbouring seeds are spread by the generator's own seeding.
fn generator(seed: u64, index: usize) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(index as u64))
}

/// What replicates are drawn from.
struct Draws {
    /// Rows of each curve, in the order of the data.
    curves: Vec<Vec<usize>>,
    /// Fitted value, residual in units of its standard deviation and that deviation, for each row.
    model: Vec<f64>,
    residuals: Vec<f64>,
    deviations: Vec<f64>,
    block: usize,
}

impl Draws {
    fn new(compiled: &Compiled<'_>, fit: &Fit) -> Self {
        let mut curves = vec![Vec::new(); compiled.plan.curves];
        for (row, reading) in compiled.plan.readings().iter().enumerate() {
            curves[reading.curve].push(row);
        }
        let deviations: Vec<f64> = compiled.plan.rows.weights().iter().map(|weight| weight.recip()).collect();
        let mut residuals: Vec<f64> =
            fit.readings.iter().zip(&deviations).map(|(row, sigma)| row.residual / sigma).collect();
        #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
        let (n, dof) = (compiled.plan.len() as f64, fit.outcome.dof.max(1) as f64);
        let scatter = (residuals.iter().map(|residual| residual * residual).sum::<f64>() / dof).sqrt();
        // Noise has no mean: what the residuals of a curve have of one would move every replicate.
        for rows in &curves {
            #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
            let mean = rows.iter().map(|&row| residuals[row]).sum::<f64>() / rows.len().max(1) as f64;
            rows.iter().for_each(|&row| residuals[row] -= mean);
        }
        let size = if fit.outcome.sigma_source == SigmaSource::Stated { 1.0 } else { scatter };
        let own = (residuals.iter().map(|residual| residual * residual).sum::<f64>() / n).sqrt();
        let factor = if own > 0.0 { size / own } else { 0.0 };
        residuals.iter_mut().for_each(|residual| *residual *= factor);
        Self {
            curves,
            model: fit.readings.iter().map(|row| row.model).collect(),
            residuals,
            deviations,
            block: block(fit),
        }
    }

    fn intensities(&self, random: &mut impl Rng) -> Vec<f64> {
        let mut intensities = self.model.clone();
        for rows in &self.curves {
            let mut at = 0;
            while at < rows.len() {
                let first = random.random_range(0..rows.len());
                for step in 0..self.block.min(rows.len() - at) {
                    // A run that leaves the curve goes on at its other end: every residual is as likely.
                    let (to, from) = (rows[at + step], rows[(first + step) % rows.len()]);
                    intensities[to] += self.deviations[to] * self.residuals[from];
                }
                at += self.block;
            }
        }
        intensities
    }

    /// Square roots of the weights: how often each reading was drawn, times the robust weight.
    fn counts(&self, random: &mut impl Rng, robust: &[f64]) -> Vec<f64> {
        let mut counts = vec![0.0; self.model.len()];
        for rows in &self.curves {
            let mut drawn = 0;
            while drawn < rows.len() {
                let first = random.random_range(0..rows.len());
                for step in 0..self.block.min(rows.len() - drawn) {
                    counts[rows[(first + step) % rows.len()]] += 1.0;
                }
                drawn += self.block;
            }
        }
        (counts.iter().enumerate())
            .map(|(row, count)| f64::sqrt(*count) * robust.get(row).copied().unwrap_or(1.0))
            .collect()
    }
}

/// How many neighbours are drawn together: as many as count as one independent reading, `(1 + r)/(1 - r)`.
fn block(fit: &Fit) -> usize {
    let r = fit.outcome.residual_correlation;
    if fit.outcome.sigma_source != SigmaSource::Widened || r <= 0.0 {
        return 1;
    }
    let most = fit.readings.len().div_ceil(8).max(1);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to the number of readings")]
    let block = ((1.0 + r) / (1.0 - r).max(1e-3)).ceil() as usize;
    block.clamp(1, most)
}
