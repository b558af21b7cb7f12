//! Model choice: the variants of one or more models, each fitted, and the smallest that does not lose.
//!
//! Which variants there are is in `variants`, how readings are left out and predicted in `held_out`, what loses in `rule`.

mod held_out;
mod rule;
mod variants;

pub use held_out::FOLDS;
pub use rule::{Criterion, Standing};

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::{FitError, fit};
use crate::inversion::outcome::{Fit, FitOutcome, SigmaSource};
use crate::inversion::parameter::{Parameter, Role};
use crate::inversion::settings::{FitSettings, ModelChoice};
use crate::inversion::undetermined::unit_of_residuals;
use crate::uncertainty::goodness::information_criteria;
use held_out::{Runs, deviances};
use rule::{Score, judge};
use serde::{Deserialize, Serialize};
use variants::{Variant, variants};

/// A larger variant must reach the deviance of one within it to this share.
const REACHED: f64 = 1e-6;

/// The table of a choice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChoiceFound {
    /// The rule as a sentence.
    pub rule: String,
    /// Factor that the deviances were divided by before the criteria: chi² for each degree of freedom of the variant that
    /// fits best, where even that misses the data, and what the correlation of its residuals makes of it; else 1.
    pub overdispersion: f64,
    /// A row for each variant.
    pub variants: Vec<VariantFound>,
}

/// One variant in the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariantFound {
    /// `lamella`, `multilayer`, `blend` or `hybrid`, with `+ tilt` and `+ background` where these are fitted, and `+ averages`
    /// where readings are averaged.
    pub name: String,
    /// Unknowns that the data feel: parameters, scale, weight and background; those that do nothing do not count.
    pub unknowns: usize,
    /// Sum of squared residuals, in units of sigma² where the data state one; of the robust loss where one is used.
    pub chi2: f64,
    /// Readings less unknowns.
    pub dof: usize,
    /// Akaike's criterion with the correction for small samples; `None` without room for it.
    pub aicc: Option<f64>,
    /// Bayes's criterion.
    pub bic: f64,
    /// Sum over all readings of -2 log of their predictive density when they were left out, without its constant: the chi²
    /// of prediction where sigma is stated. `None` if too few readings are left.
    pub held_out: Option<f64>,
    /// The same above that of the best variant.
    pub held_out_behind: Option<f64>,
    /// Standard error of `held_out_behind`, from the differences run by run.
    pub held_out_error: Option<f64>,
    /// How it came out.
    pub standing: Standing,
    /// What it is behind in; with two of them, or no convergence, it loses.
    pub behind_in: Vec<Criterion>,
}

/// A chosen fit.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The fit of the variant that is kept; the table is its `outcome.choice`, and its settings make it again.
    pub fit: Fit,
    /// What each variant found, in the order of the table.
    pub outcomes: Vec<FitOutcome>,
}

/// A variant with its fit.
struct Tried {
    variant: Variant,
    fit: Fit,
    deviance: f64,
}

/// Fits the variants of `settings` that `data` can tell apart and keeps the smallest that does not lose.
///
/// The variants of a model are the lamellae alone, the multilayer alone or both (not of `hybrid`, which is one product); the
/// tilt `delta` held at 0 or free; no background or one for all. What the settings fix, require, or ask for beyond their
/// defaults stays in all of them: a fixed `delta` is not freed, a background not taken out, a plane that the data do not see
/// not left out. The averages alone are on trial: where the settings have any, each variant with a multilayer is fitted
/// without them and with them.
///
/// - `beside`: models whose variants stand beside those of the settings' own; empty for none. The bounds of `lamella_width`
///   are cut to the room of a `hybrid` model. One that cannot hold what the settings ask for, such as a given weight or a spread
///   of the tilt, is left out, and so are all of them under an aperture, where one fit takes minutes.
///
/// ```text
/// AICc = D/c + 2 k + 2 k (k + 1) / (n - k - 1)     behind if above the lowest by more than 2
/// BIC  = D/c + k ln n                              behind if above the lowest by more than 2
/// held-out deviance                                behind if above the lowest by more than 1 standard error
/// ```
///
/// with the deviance `D` = chi² for stated sigma and `n ln(chi²/n)` without, and `c` the overdispersion of the
/// variant that fits best. A variant loses if it is behind in two of the three, or has no minimum. If each loses, the best by
/// held-out readings is kept.
///
/// Models and averages are not nested in each other. The smallest is that of fewest unknowns, of which averages have none; of
/// equally many, the first in the table: plane waves before averages, then the settings' own model before those beside it.
///
/// - `progress` is told which variant is being fitted.
///
/// # Source
/// Burnham and Anderson 2002, *Model Selection and Multimodel Inference*, sections 2.4 (`AICc`) and 2.5 (division by `c`);
/// Schwarz 1978, DOI 10.1214/aos/1176344136 (BIC); Hastie, Tibshirani and Friedman 2009, section 7.10 (one standard error).
///
/// # Errors
/// [`FitError`] if no variant can be fitted: that of the last in the table.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, ModelChoice, Parts, choose};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, upright) = (BlendModel::default(), Structure { delta: 0.0, ..Structure::blue() });
/// let data = simulate(&model, &upright, &Scan::full_design(&model, &upright)?, 1.0, 0.01, 7)?;
/// let choice = choose(&data, &FitSettings::default(), &[ModelChoice::Hybrid { ridge_spacing: 750.0 }], &|_| {})?;
/// let table = choice.fit.outcome.choice.unwrap();
/// assert_eq!(table.variants.len(), 10 + 4);
/// assert_eq!(choice.fit.outcome.settings.parts, Parts::Both);
/// assert_eq!(choice.fit.outcome.settings.model, ModelChoice::Blend);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn choose(
    data: &Dataset,
    settings: &FitSettings,
    beside: &[ModelChoice],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Choice, FitError> {
    settings.validate()?;
    settings.forward()?;
    let candidates = variants(data, settings, beside);
    let count = candidates.len();
    let mut tried: Vec<Tried> = Vec::with_capacity(count);
    let mut refused = None;
    for (place, variant) in candidates.into_iter().enumerate() {
        let head = format!("variant {} of {count}, {}", place + 1, variant.name);
        match attempt(data, variant, &tried, &|what| progress(&format!("{head}: {what}"))) {
            Ok(one) => tried.push(one),
            // A larger or a smaller one may do.
            Err(error @ (FitError::TooFewReadings { .. } | FitError::NowhereFinite { .. })) => refused = Some(error),
            Err(error) => return Err(error),
        }
    }
    let has_minimum = |one: &&Tried| one.fit.outcome.termination.was_successful();
    let lowest = |a: &&Tried, b: &&Tried| a.deviance.total_cmp(&b.deviance);
    let best = tried.iter().filter(has_minimum).min_by(lowest).or_else(|| tried.iter().min_by(lowest));
    let Some(overdispersion) = best.map(|best| overdispersion(&best.fit)) else {
        return Err(refused.unwrap_or(FitError::NowhereFinite { model: "chosen" }));
    };
    progress("predicting readings left out");
    let runs = Runs::new(data);
    let scores = tried.iter().map(|one| score(data, one, &runs, overdispersion)).collect::<Result<Vec<_>, _>>()?;
    let (kept, judged) = judge(&scores);
    let found = |((one, score), judgement): ((&Tried, &Score), rule::Judgement)| VariantFound {
        name: one.variant.name.clone(),
        unknowns: score.unknowns,
        chi2: one.fit.outcome.robust_cost.unwrap_or(one.fit.outcome.chi2),
        dof: one.fit.outcome.dof,
        aicc: score.aicc,
        bic: score.bic,
        held_out: score.held_out.as_ref().map(|runs| runs.iter().sum()),
        held_out_behind: judgement.held_out.map(|(behind, _)| behind),
        held_out_error: judgement.held_out.map(|(_, error)| error),
        standing: judgement.standing,
        behind_in: judgement.behind_in,
    };
    let rule = rule::sentence(overdispersion);
    let table =
        ChoiceFound { rule, overdispersion, variants: tried.iter().zip(&scores).zip(judged).map(found).collect() };
    let outcomes = tried.iter().map(|one| one.fit.outcome.clone()).collect();
    let mut fit = tried.swap_remove(kept).fit;
    fit.outcome.choice = Some(table);
    Ok(Choice { fit, outcomes })
}

/// Fits a variant; again from the minimum of one within it if the search ended above that.
fn attempt(
    data: &Dataset,
    mut variant: Variant,
    tried: &[Tried],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Tried, FitError> {
    let mut found = fit(data, &variant.settings, progress)?;
    let lowest = tried.iter().filter(|one| one.variant.is_within(&variant));
    let lowest = lowest.min_by(|a, b| a.deviance.total_cmp(&b.deviance));
    if let Some(smaller) = lowest.filter(|one| cost(&one.fit) < cost(&found) * (1.0 - REACHED)) {
        let values = smaller.fit.solution.space.freedom.expand(&smaller.fit.solution.best.parameters);
        for (parameter, role) in Parameter::ALL.into_iter().zip(variant.settings.roles) {
            if let Role::Free { lower, upper } = role {
                variant.settings.start[parameter.index()] = Some(values[parameter.index()].clamp(lower, upper));
            }
        }
        let again = fit(data, &variant.settings, progress)?;
        if cost(&again) < cost(&found) {
            found = again;
        } else {
            variant.settings = found.outcome.settings.clone();
        }
    }
    let deviance = deviance(data, &found);
    Ok(Tried { variant, fit: found, deviance })
}

/// What the fit minimised.
fn cost(fit: &Fit) -> f64 {
    fit.outcome.robust_cost.unwrap_or(fit.outcome.chi2)
}

/// -2 log of the likelihood at the minimum, without its constant.
fn deviance(data: &Dataset, fit: &Fit) -> f64 {
    let readings = data.readings().len();
    if data.has_sigma() {
        return cost(fit);
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let n = readings as f64;
    2.0 * n * unit_of_residuals(data, cost(fit), readings).ln()
}

fn score(data: &Dataset, one: &Tried, runs: &Runs, overdispersion: f64) -> Result<Score, FitError> {
    let settings = &one.variant.settings;
    let model = settings.forward()?;
    let compiled = Compiled::new(data, settings, model.as_ref())?;
    let readings = data.readings().len();
    let unknowns = readings.saturating_sub(one.fit.outcome.dof);
    // Without a stated sigma the scatter is one unknown more.
    let counted = unknowns + usize::from(!data.has_sigma());
    let (aicc, bic) = information_criteria(one.deviance / overdispersion, readings, counted);
    let converged = one.fit.outcome.termination.was_successful();
    Ok(Score { converged, unknowns, aicc, bic, held_out: deviances(&compiled, &one.fit, runs) })
}

/// chi² for each degree of freedom where the model misses the data, and what the correlation of neighbouring residuals makes
/// of it; else 1. How far the answer moves over parts of the data has no say: it is no noise.
fn overdispersion(fit: &Fit) -> f64 {
    let outcome = &fit.outcome;
    if outcome.sigma_source != SigmaSource::Widened {
        return 1.0;
    }
    let scatter = outcome.sigma_ratio.unwrap_or(1.0).max(1.0);
    let r = outcome.residual_correlation.clamp(0.0, 0.99);
    scatter * scatter * (1.0 + r) / (1.0 - r)
}
