//! From a minimum to what is said about it: verdict, warnings, minima, curves.

use crate::inversion::atlas::listed;
use crate::inversion::combinations::combinations;
use crate::inversion::estimates::{Found, Uncertainty, as_good, index_ratio};
use crate::inversion::jackknife::jackknife;
use crate::inversion::nuisance::Extent;
use crate::inversion::outcome::{
    CurveResiduals, DataFound, Derived, Estimate, FitOutcome, FittedReading, IdentifiabilityFound, Parameters, SCHEMA,
    SigmaSource, Status, Verdict,
};
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::problem::{Evaluation, Problem};
use crate::inversion::quantity::indices;
use crate::inversion::settings::Search;
use crate::inversion::undetermined::{Held, unit_of_residuals};
use crate::inversion::wording;
use crate::optimise::Loss;
use crate::uncertainty::discrepancy::{ResidualTests, is_noise, residual_tests};
use crate::uncertainty::goodness::excess;
use crate::uncertainty::identifiability::Identifiability;

/// Data that exceed the stated noise by this many standard deviations of chi² are missed by the model.
const MISSED: f64 = 3.7;
/// Neighbouring residuals that agree by this many standard deviations are no noise.
const STRUCTURED: f64 = 5.0;
/// chi² for each degree of freedom below which the structure of residuals does not matter.
const UNHEARD: f64 = 0.05;
/// Scatter below this share of the largest reading is rounding.
const ROUNDING: f64 = 1e-6;
/// A correlation beyond this counts as this: the rule for it has no limit.
const MOST_CORRELATED: f64 = 0.99;
/// A reading with more than this share of chi² is named.
const OUTLIER: f64 = 0.5;
/// A model that lowers chi² by less than this below the best constant says nothing: of 300 sets of pure noise the fit
/// gained 21 at most, 15 in one of twenty (172 readings, two nuisances; each more adds about 1).
const CHANCE: f64 = 30.0;

/// What is said of a minimum.
pub(crate) struct Summary {
    pub(crate) outcome: FitOutcome,
    pub(crate) readings: Vec<FittedReading>,
    /// Standard deviation of a weighted residual, widened where the model misses the data.
    pub(crate) unit: f64,
}

/// What is said of a minimum; `None` if the model has no value there.
pub(crate) fn summarise(found: &Found<'_>) -> Option<Summary> {
    let problem = Problem::new(found.compiled, found.space, found.robust);
    let point = problem.evaluate(&found.best.parameters)?;
    let mut readings = fitted_readings(found, &point);
    let chi2: f64 = (found.plan.readings.iter().zip(&readings))
        .map(|(planned, fitted)| (fitted.residual * planned.weight).powi(2))
        .sum();
    let in_use: Vec<usize> = (0..point.coefficients.len()).filter(|&i| point.coefficients[i] > 0.0).collect();
    let unknowns = found.space.freedom.free.len() + in_use.len();
    let dof = found.plan.len().saturating_sub(unknowns);
    let robust = robust(found, &readings, dof);
    let unit = match &robust {
        #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
        Some(robust) => unit_of_residuals(found.data, robust.unit.powi(2) * dof as f64, dof),
        None => unit_of_residuals(found.data, chi2, dof),
    };
    for (planned, fitted) in found.plan.readings.iter().zip(&mut readings) {
        fitted.normalised = fitted.residual * planned.weight / unit;
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let reduced = if dof > 0 { chi2 / dof as f64 } else { f64::NAN };
    let missed = found.data.has_sigma() && found.settings.loss == Loss::Linear && excess(chi2, dof) > MISSED;
    let by_misfit = if missed { reduced.sqrt() } else { 1.0 };
    let correlation_of_residuals = neighbours(found, &readings);
    // Residuals far below the stated noise, or below rounding, are not the model's: they have no say.
    let largest = found.data.readings().iter().map(|reading| reading.intensity.abs()).fold(0.0, f64::max);
    let told = if found.data.has_sigma() { reduced > UNHEARD } else { unit > ROUNDING * largest };
    let structured = told && correlation_of_residuals.deviations > STRUCTURED;
    let by_structure = if structured { correlation_of_residuals.widening() } else { 1.0 };
    let sigma_source = match (missed || structured, found.data.has_sigma()) {
        (true, _) => SigmaSource::Widened,
        (false, true) => SigmaSource::Stated,
        (false, false) => SigmaSource::Scatter,
    };
    let (plain_unit, unit) = (unit * by_misfit, unit * by_misfit * by_structure);
    let mut uncertainty = Uncertainty::new(found, &problem, &point, &in_use, unit, dof, sigma_source);
    let tests = tests_by_curve(found, &readings);
    // Residuals larger than stated that look like noise are noise: a factor mends it.
    let bent = structured || (missed && !is_noise(&tests, reduced));
    let by_spread = if bent { uncertainty.widen(jackknife(found, &point, &in_use), dof) } else { 1.0 };
    let widened_by = by_misfit * by_structure * by_spread;
    let mut estimates = Parameter::ALL.map(|parameter| uncertainty.parameter(found, &point, parameter));
    let mut derived = uncertainty.derived(found, &point);
    let gain = (chi2_of_constants(found) - chi2) / (plain_unit * plain_unit);
    #[allow(clippy::cast_precision_loss, reason = "a column count is small")]
    let by_luck = CHANCE + 2.0 * found.linear.columns.len().saturating_sub(3) as f64;
    let by_chance = gain < by_luck && found.settings.loss == Loss::Linear;
    if by_chance || !found.best.termination.was_successful() {
        let fitted = estimates.iter_mut().filter(|estimate| estimate.bounds.is_some());
        fitted.chain([&mut derived.period, &mut derived.optical_sum]).for_each(Estimate::withdraw);
    }
    let verdict = verdict(found, &estimates, &derived);
    let identifiability = identifiability(found, unit);
    let minima =
        listed(found.minima, found.searched, unit, found.settings.level, indices(found.data, &found.settings.stack));
    let mut warnings = Vec::new();
    if by_chance {
        warnings.push(if found.settings.search == Search::Local {
            "the minimum next to the start explains nothing of the data: give a better start, or search everywhere"
                .to_owned()
        } else {
            format!(
                "the data show no structure that the model explains: chi² is only {:.0} below that of a constant, which \
                 fitting pure noise would give",
                gain.max(0.0)
            )
        });
    }
    if missed && !by_chance {
        warnings.push(wording::missed(reduced.sqrt(), bent, widened_by));
    }
    if let Some(worst) = outlier(found, &readings, chi2).filter(|_| missed || by_chance) {
        warnings.push(worst);
    }
    if structured && !by_chance {
        warnings.push(format!(
            "the model misses the data: neighbouring residuals agree (correlation {:.2}), which noise does not make; the \
             standard deviations are widened {widened_by:.1} times, by that and by how far the answer moves as parts of the \
             data are left out, and the split of the layers depends on the model",
            correlation_of_residuals.value
        ));
    }
    if !by_chance {
        warnings.extend(identifiability.undetermined.iter().cloned());
        warnings.extend(warn_of_hidden_scale(found));
        warnings.extend(warn_of_open_intervals(found, &estimates));
        warnings.extend(warn_of_bounds(&estimates));
        warnings.extend(warn_of_others(found, &estimates, unit));
    }
    let (covariance, correlation) = uncertainty.named_matrices(found);
    let (aicc, bic) = criteria(found.data.has_sigma(), chi2, found.plan.len(), unknowns);
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = estimates;
    let outcome = FitOutcome {
        schema: SCHEMA.to_owned(),
        verdict,
        warnings,
        parameters: Parameters { d_air, d_cuticle, delta, phi_alpha, lamella_width },
        derived,
        chi2,
        robust_cost: robust.map(|robust| robust.cost),
        dof,
        aicc,
        bic,
        sigma_source,
        residual_correlation: correlation_of_residuals.value,
        curve_residuals: curve_residuals(found, &tests),
        widened_by,
        quantiles: [uncertainty.quantiles.sixty_eight, uncertainty.quantiles.ninety_five],
        sigma_ratio: found.data.has_sigma().then(|| reduced.sqrt()).filter(|ratio| ratio.is_finite()),
        correlation,
        covariance,
        minima,
        identifiability,
        uncertainty: None,
        nuisance: uncertainty.nuisances(found, &point),
        advice: Vec::new(),
        termination: found.best.termination,
        evaluations: found.best.evaluations,
        settings: found.settings.clone(),
        seed: found.settings.seed,
        program: concat!("morpho-fit ", env!("CARGO_PKG_VERSION")).to_owned(),
        data: DataFound {
            sha256: found.data.sha256().to_owned(),
            readings: found.data.readings().len(),
            curves: found.data.curves().to_vec(),
            notes: found.data.notes().to_vec(),
        },
        choice: None,
    };
    Some(Summary { outcome, readings, unit })
}

/// What a robust loss makes of the residuals.
struct Robust {
    /// Sum of the loss, in the unit of chi².
    cost: f64,
    /// Standard deviation of a weighted residual that makes the covariance at fixed weights that of the estimate.
    unit: f64,
}

/// Cost and unit of the robust loss; `None` for least squares.
///
/// ```text
/// unit² = s² · sum(psi²)/dof · mean(w) / mean(psi')²,   psi = z w(z),   z = r / s
/// ```
///
/// The covariance is taken at fixed weights, `(J' W J)⁻¹`; the estimate's is `(J' J)⁻¹ s² sum(psi²)/dof / mean(psi')²`.
///
/// # Source
/// Huber 1981, *Robust Statistics*, §7.6, equation 6.5.
fn robust(found: &Found<'_>, readings: &[FittedReading], dof: usize) -> Option<Robust> {
    let (loss, scale) = (found.settings.loss, found.robust_unit);
    if loss == Loss::Linear {
        return None;
    }
    let (mut rho, mut pull, mut weight, mut slope) = (0.0, 0.0, 0.0, 0.0);
    for (planned, fitted) in found.plan.readings.iter().zip(readings) {
        let z = fitted.residual * planned.weight / scale;
        rho += loss.rho(z);
        pull += (z * loss.weight(z)).powi(2);
        weight += loss.weight(z);
        slope += loss.influence_slope(z);
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let (n, dof) = (readings.len() as f64, dof.max(1) as f64);
    // Far outliers have a falling pull; if most are, the formula ends and the weights alone stand.
    let slope = (slope / n).max(0.1 * weight / n);
    Some(Robust { cost: scale * scale * rho, unit: scale * (pull / dof * (weight / n)).sqrt() / slope })
}

/// Correlation of each residual with the next one of its curve.
#[derive(Debug, Clone, Copy)]
struct Neighbours {
    value: f64,
    /// In units of its standard deviation for noise, `1/sqrt(pairs)`.
    deviations: f64,
}

impl Neighbours {
    /// Factor on standard deviations: of `n` readings so correlated only `n (1 - r)/(1 + r)` are independent.
    fn widening(&self) -> f64 {
        let r = self.value.min(MOST_CORRELATED);
        ((1.0 + r) / (1.0 - r)).sqrt()
    }
}

/// The lag-1 autocorrelation of the weighted residuals, in the order of the data, over all curves.
fn neighbours(found: &Found<'_>, readings: &[FittedReading]) -> Neighbours {
    let mut last: Vec<Option<f64>> = vec![None; found.plan.curves];
    let (mut products, mut squares, mut pairs) = (0.0, 0.0, 0_u32);
    for (planned, fitted) in found.plan.readings.iter().zip(readings) {
        squares += fitted.normalised * fitted.normalised;
        if let Some(before) = last[planned.curve].replace(fitted.normalised) {
            products += before * fitted.normalised;
            pairs += 1;
        }
    }
    let value = if squares > 0.0 { products / squares } else { 0.0 };
    Neighbours { value, deviations: value * f64::from(pairs).sqrt() }
}

/// Tests of the residuals of each curve, with its number of readings.
fn tests_by_curve(found: &Found<'_>, readings: &[FittedReading]) -> Vec<(ResidualTests, usize)> {
    let mut curves: Vec<Vec<f64>> = vec![Vec::new(); found.plan.curves];
    for (planned, fitted) in found.plan.readings.iter().zip(readings) {
        curves[planned.curve].push(fitted.normalised);
    }
    curves.iter().map(|residuals| (residual_tests(residuals), residuals.len())).collect()
}

fn curve_residuals(found: &Found<'_>, tests: &[(ResidualTests, usize)]) -> Vec<CurveResiduals> {
    (found.data.curves().iter().zip(tests))
        .map(|(curve, &(tests, readings))| {
            let ResidualTests { chi2, correlation, runs } = tests;
            CurveResiduals { curve: curve.clone(), readings, chi2, correlation, runs_z: runs }
        })
        .collect()
}

/// chi² of the best constant; of one for each curve where the fit has something of its own for each.
fn chi2_of_constants(found: &Found<'_>) -> f64 {
    let nuisances = &found.settings.nuisances;
    let each = nuisances.scale == Extent::PerCurve || nuisances.background == Extent::PerCurve;
    let mut sums = vec![(0.0, 0.0, 0.0); found.plan.curves];
    for reading in &found.plan.readings {
        let (weight, sum) = (reading.weight * reading.weight, &mut sums[if each { reading.curve } else { 0 }]);
        sum.0 += weight;
        sum.1 += weight * reading.intensity;
        sum.2 += weight * reading.intensity * reading.intensity;
    }
    sums.iter().filter(|sum| sum.0 > 0.0).map(|(w, wy, wyy)| wyy - wy * wy / w).sum()
}

fn fitted_readings(found: &Found<'_>, point: &Evaluation) -> Vec<FittedReading> {
    (found.plan.readings.iter())
        .map(|reading| {
            let parts = found.plan.parts(reading, point.terms.view());
            let (on_a, on_b, background) = found.linear.factors(reading.curve, &point.coefficients);
            let (lamella, multilayer) = (on_a * parts.0, on_b * parts.1);
            let model = lamella + multilayer + background;
            let residual = reading.intensity - model;
            FittedReading { model, residual, normalised: f64::NAN, lamella, multilayer, background }
        })
        .collect()
}

/// Akaike's corrected and Bayes's criterion, from chi² where sigma is stated and from the scatter where it is not.
fn criteria(has_sigma: bool, chi2: f64, readings: usize, unknowns: usize) -> (Option<f64>, f64) {
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let (n, k) = (readings as f64, (unknowns + usize::from(!has_sigma)) as f64);
    let deviance = if has_sigma { chi2 } else { n * (chi2 / n).max(f64::MIN_POSITIVE).ln() };
    let room = n - k - 1.0;
    ((room > 0.0).then(|| deviance + 2.0 * k + 2.0 * k * (k + 1.0) / room), deviance + k * n.ln())
}

fn verdict(found: &Found<'_>, estimates: &[Estimate; COUNT], derived: &Derived) -> Verdict {
    if !found.best.termination.was_successful() {
        return Verdict::NotConverged;
    }
    let asked = |parameter: &Parameter| found.searched.freedom.free.contains(parameter);
    let told = |estimate: &Estimate| estimate.status.is_determined();
    // A value on a bound, on one side, or one of several, is not determined, but the data do speak of it.
    let heard = |estimate: &Estimate| {
        let spoken = [Status::AtBound, Status::OneSided, Status::Ambiguous, Status::Linked];
        told(estimate) || spoken.contains(&estimate.status)
    };
    let thickness = [Parameter::DAir, Parameter::DCuticle].iter().any(asked);
    let nothing =
        thickness && ![&estimates[0], &estimates[1], &derived.period, &derived.optical_sum].into_iter().any(heard);
    if nothing {
        Verdict::NoThickness
    } else if Parameter::ALL.iter().filter(|p| asked(p)).all(|p| told(&estimates[p.index()])) {
        Verdict::Determined
    } else {
        Verdict::PartlyDetermined
    }
}

fn identifiability(found: &Found<'_>, unit: f64) -> IdentifiabilityFound {
    let jacobian = &found.minima[0].triangle / unit;
    let analysis = Identifiability::new(&jacobian, &found.searched.ranges);
    let ratio = index_ratio(found);
    // What is told in combination first, then what is not told at all, in the order of the parameters.
    let mut held: Vec<&Held> = found.held.iter().collect();
    held.sort_by_key(|held| (std::cmp::Reverse(held.direction.len()), held.direction.first().map(|(part, _)| *part)));
    IdentifiabilityFound {
        free: found.searched.freedom.free.iter().map(|parameter| parameter.name().to_owned()).collect(),
        rank: found.searched.freedom.free.len() - found.held.len(),
        condition: Some(analysis.condition).filter(|condition| condition.is_finite()),
        undetermined: held.into_iter().map(|held| wording::undetermined(held, ratio)).collect(),
        combinations: combinations(found.solution, unit),
    }
}

/// A warning if one reading makes up most of chi².
fn outlier(found: &Found<'_>, readings: &[FittedReading], chi2: f64) -> Option<String> {
    let size = |row: usize| readings[row].residual.abs() * found.plan.readings[row].weight;
    let worst = (0..readings.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
    let line = found.data.readings()[worst].line;
    let place = if line > 0 { format!("line {line}") } else { format!("reading {}", worst + 1) };
    (size(worst).powi(2) > OUTLIER * chi2).then(|| {
        format!("one reading makes up most of chi²: {place}; leave it out or use a robust loss (huber, cauchy)")
    })
}

fn warn_of_bounds(estimates: &[Estimate; COUNT]) -> Vec<String> {
    (Parameter::ALL.iter().zip(estimates))
        .filter(|(_, estimate)| estimate.status == Status::AtBound)
        .map(|(parameter, estimate)| {
            let value = estimate.value.unwrap_or_default();
            let unit = parameter.unit();
            let hint = if *parameter == Parameter::Delta {
                " (or is phi the other way round? a mirror reflects theta = 20 into phi = -20)"
            } else {
                ""
            };
            format!(
                "{parameter} ended on its bound {value:.4} {unit}: widen it with --bounds {parameter}=LOW:HIGH{hint}"
            )
        })
        .collect()
}

/// A warning if the lobe acts as a scale although none is fitted.
fn warn_of_hidden_scale(found: &Found<'_>) -> Option<String> {
    let free = &found.searched.freedom.free;
    // A width that the data do not feel, as in the mirror direction of a fixed tilt, was taken out of the fit.
    let lobe = free.contains(&Parameter::Delta) || found.space.freedom.free.contains(&Parameter::PhiAlpha);
    let hidden = found.settings.nuisances.scale == Extent::None && found.plan.directions() == 1 && lobe;
    hidden.then(|| {
        "with one direction of incidence and view the lobe acts as a scale, although none is fitted: fix delta and phi_alpha \
         if the intensities are absolute"
            .to_owned()
    })
}

/// Warnings of parameters whose interval spans all of their bounds.
fn warn_of_open_intervals(found: &Found<'_>, estimates: &[Estimate; COUNT]) -> Vec<String> {
    let of_a_direction =
        |parameter: &Parameter| found.held.iter().any(|held| held.direction.iter().any(|(part, _)| part == parameter));
    (Parameter::ALL.iter().zip(estimates))
        .filter(|(parameter, estimate)| estimate.status == Status::NotIdentifiable && !of_a_direction(parameter))
        .map(|(parameter, _)| format!("{parameter} cannot be told: its interval spans all of its bounds"))
        .collect()
}

/// A warning if a minimum elsewhere fits as well as the best.
fn warn_of_others(found: &Found<'_>, estimates: &[Estimate; COUNT], unit: f64) -> Option<String> {
    let ambiguous: Vec<&str> = (Parameter::ALL.iter().zip(estimates))
        .filter(|(_, estimate)| estimate.status == Status::Ambiguous)
        .map(|(parameter, _)| parameter.name())
        .collect();
    let minima = as_good(found, unit).count();
    (!ambiguous.is_empty()).then(|| {
        let (structures, fit) = if minima == 1 { ("structure", "fits") } else { ("structures", "fit") };
        format!(
            "{minima} other {structures} {fit} as well, with another {}: see `minima` in fit.json",
            ambiguous.join(", ")
        )
    })
}
