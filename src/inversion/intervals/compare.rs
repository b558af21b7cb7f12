//! The intervals of all methods side by side, and where they part.

use crate::inversion::intervals::{Bootstrap, IntervalPair, Posterior, Profiles, Resampling};
use crate::inversion::outcome::{Estimate, Fit, Status};
use crate::numerics::quantile::quantile;
use serde::{Deserialize, Serialize};

/// Ends whose distances from the best value differ by more than this share part.
const PART: f64 = 0.2;
/// An end nearer to the best value than this share of the other's distance lies at it, as at a bound.
const NEAR: f64 = 1e-6;

/// How an interval was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Method {
    /// Curvature at the minimum.
    Covariance,
    /// Profile likelihood.
    Profile,
    /// Bootstrap of the residuals.
    BootstrapResiduals,
    /// Bootstrap of the readings.
    BootstrapCases,
    /// Markov chain Monte Carlo.
    Posterior,
}

impl Method {
    /// The method in words.
    #[must_use]
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Covariance => "covariance",
            Self::Profile => "profile",
            Self::BootstrapResiduals => "bootstrap, residuals",
            Self::BootstrapCases => "bootstrap, cases",
            Self::Posterior => "posterior",
        }
    }
}

/// What one method says of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MethodIntervals {
    /// The method.
    pub method: Method,
    /// Best value or median; `None` where there is none.
    pub value: Option<f64>,
    /// Standard deviation; `None` where the method gives none.
    pub sigma: Option<f64>,
    /// The intervals, in the unit of the quantity.
    #[serde(flatten)]
    pub intervals: IntervalPair,
    /// By how much the end that differs most lies farther from the best value than that of the covariance: 0.2 for a fifth
    /// farther, -0.2 for a fifth nearer; `None` without a covariance, or an end of the same kind.
    pub parting: Option<f64>,
}

impl MethodIntervals {
    /// Whether it parts from the covariance by more than a fifth.
    #[must_use]
    pub fn parts(&self) -> bool {
        self.parting.is_some_and(|parting| parting > PART || parting < (1.0 + PART).recip() - 1.0)
    }
}

/// What all methods say of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IntervalsFound {
    /// Name of the quantity: a parameter, `period` or `optical_sum`.
    pub name: String,
    /// nm, deg or rad.
    pub unit: String,
    /// The methods that were asked, in the order of [`Method`].
    pub methods: Vec<MethodIntervals>,
}

/// How a bootstrap went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BootstrapFound {
    /// What was drawn again.
    pub resampling: Resampling,
    /// Replicates fitted.
    pub replicates: usize,
    /// Replicates left out because their fit ended without a minimum.
    pub failed: usize,
    /// Readings drawn together.
    pub block: usize,
}

/// How the sampling of the posterior went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PosteriorFound {
    /// Samples kept.
    pub samples: usize,
    /// Chains.
    pub chains: usize,
    /// Evaluations of the model.
    pub evaluations: usize,
    /// Largest split-R̂ of a quantity; `None` if one does not move.
    pub r_hat: Option<f64>,
    /// Smallest effective sample size of a quantity, in bulk or tails.
    pub effective: Option<f64>,
    /// Share of the posterior about each of the fit's minima, in their order.
    pub weights: Vec<f64>,
    /// Whether the chains agree and are worth the samples asked for.
    pub converged: bool,
}

/// What was found beside the covariance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UncertaintyFound {
    /// One for each quantity that moves.
    pub quantities: Vec<IntervalsFound>,
    /// How the bootstraps went.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bootstraps: Vec<BootstrapFound>,
    /// How the sampling went.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub posterior: Option<PosteriorFound>,
    /// The five parameters, user units, of a minimum below that of the fit which a profile met: the fit did not find the best.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower_minimum: Option<[f64; 5]>,
}

/// Puts the intervals of all methods together.
///
/// ```text
/// parting = |end - best| / |end of the covariance - best| - 1   at the level and side where it is largest
/// ```
///
/// An open end counts as the bound it reached.
#[must_use]
pub fn compare(
    fit: &Fit,
    profiles: Option<&Profiles>,
    bootstraps: &[Bootstrap],
    posterior: Option<&Posterior>,
) -> UncertaintyFound {
    let outcome = &fit.outcome;
    let derived = [("period", &outcome.derived.period), ("optical_sum", &outcome.derived.optical_sum)];
    let quantities = (outcome.parameters.each().into_iter().chain(derived))
        .filter_map(|(name, estimate)| {
            let mut methods: Vec<MethodIntervals> = covariance(estimate).into_iter().collect();
            let profile = profiles.and_then(|all| all.quantities.iter().find(|profile| profile.name == name));
            methods.extend(profile.map(|profile| MethodIntervals {
                method: Method::Profile,
                value: Some(profile.best),
                sigma: None,
                intervals: profile.intervals,
                parting: None,
            }));
            for bootstrap in bootstraps {
                let method = match bootstrap.resampling {
                    Resampling::Residuals => Method::BootstrapResiduals,
                    Resampling::Cases => Method::BootstrapCases,
                };
                methods.extend(sampled(method, name, &bootstrap.names, &bootstrap.replicates, &bootstrap.intervals));
            }
            if let Some(posterior) = posterior {
                let Posterior { names, samples, intervals, .. } = posterior;
                methods.extend(sampled(Method::Posterior, name, names, samples, intervals));
            }
            methods.sort_by_key(|method| method.method);
            let best = estimate.value.or(estimate.held_at)?;
            let limits = profile.map(|profile| profile.limits).or(estimate.bounds);
            let first = methods.first().filter(|method| method.method == Method::Covariance).cloned();
            for method in methods.iter_mut().filter(|method| method.method != Method::Covariance) {
                // An interval that spans several answers is no measure for one about each.
                let one = estimate.status != Status::Ambiguous;
                method.parting = first.as_ref().filter(|_| one).and_then(|first| parting(method, first, best, limits));
            }
            let asked = methods.iter().any(|method| method.method != Method::Covariance);
            asked.then(|| IntervalsFound { name: name.to_owned(), unit: estimate.unit.clone(), methods })
        })
        .collect();
    UncertaintyFound {
        quantities,
        bootstraps: (bootstraps.iter())
            .map(|bootstrap| BootstrapFound {
                resampling: bootstrap.resampling,
                replicates: bootstrap.replicates.len(),
                failed: bootstrap.failed,
                block: bootstrap.block,
            })
            .collect(),
        posterior: posterior.map(|posterior| {
            let all = || posterior.convergence.iter().copied();
            let r_hat = all().try_fold(1.0, |most: f64, one| one.map(|one| most.max(one.r_hat)));
            let least = |least: f64, one: Option<crate::uncertainty::convergence::Convergence>| {
                one.map(|one| least.min(one.bulk).min(one.tail))
            };
            PosteriorFound {
                samples: posterior.samples.len(),
                chains: posterior.chains,
                evaluations: posterior.evaluations,
                r_hat,
                effective: all().try_fold(f64::INFINITY, least).filter(|least| least.is_finite()),
                weights: posterior.weights.clone(),
                converged: posterior.converged,
            }
        }),
        lower_minimum: profiles.and_then(|profiles| profiles.lower),
    }
}

fn covariance(estimate: &Estimate) -> Option<MethodIntervals> {
    let intervals = IntervalPair { interval_68: estimate.interval_68?, interval_95: estimate.interval_95? };
    Some(MethodIntervals {
        method: Method::Covariance,
        value: estimate.value,
        sigma: estimate.sigma,
        intervals,
        parting: None,
    })
}

fn sampled(
    method: Method,
    name: &str,
    names: &[&'static str],
    rows: &[Vec<f64>],
    intervals: &[IntervalPair],
) -> Option<MethodIntervals> {
    let column = names.iter().position(|other| *other == name).filter(|_| !rows.is_empty())?;
    let mut values: Vec<f64> = rows.iter().map(|row| row[column]).collect();
    values.sort_by(f64::total_cmp);
    #[allow(clippy::cast_precision_loss, reason = "sizes of samples are below 2^53")]
    let (count, less) = (values.len() as f64, values.len().saturating_sub(1) as f64);
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / less;
    Some(MethodIntervals {
        method,
        value: quantile(&values, 0.5),
        sigma: Some(variance.sqrt()).filter(|sigma| sigma.is_finite()),
        intervals: *intervals.get(column)?,
        parting: None,
    })
}

fn parting(method: &MethodIntervals, first: &MethodIntervals, best: f64, limits: Option<[f64; 2]>) -> Option<f64> {
    let pairs = [
        (method.intervals.interval_68, first.intervals.interval_68),
        (method.intervals.interval_95, first.intervals.interval_95),
    ];
    let distance = |end: Option<f64>, side: usize| {
        end.or(limits.map(|limits| limits[side])).map(|end| (end - best).abs()).filter(|distance| distance.is_finite())
    };
    let of_side = |ours: [Option<f64>; 2], theirs: [Option<f64>; 2], side: usize| {
        let both = ours[side].is_some() || theirs[side].is_some();
        let (ours, theirs) = (distance(ours[side], side)?, distance(theirs[side], side)?);
        // Ends that lie at the best value, as at a bound, have no ratio.
        (both && theirs > NEAR * ours && ours > NEAR * theirs).then(|| ours / theirs)
    };
    (pairs.into_iter())
        .flat_map(|(ours, theirs)| [0, 1].into_iter().filter_map(move |side| of_side(ours, theirs, side)))
        .max_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()))
        .map(|ratio| ratio - 1.0)
}
