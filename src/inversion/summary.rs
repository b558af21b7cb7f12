//! From a minimum to what is said about it: verdict, warnings, minima, curves.

use crate::dataset::Reading;
use crate::inversion::atlas::listed;
use crate::inversion::beyond::beyond;
use crate::inversion::combinations::combinations;
use crate::inversion::estimates::{Found, Uncertainty, index_ratio};
use crate::inversion::jackknife::jackknife;
use crate::inversion::nuisance::Extent;
use crate::inversion::outcome::{
    DataFound, Derived, Estimate, FitOutcome, FittedReading, IdentifiabilityFound, Parameters, SCHEMA, SigmaSource,
    Status, Verdict,
};
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::plan::PlannedReading;
use crate::inversion::problem::{Evaluation, Problem};
use crate::inversion::quantity::indices;
use crate::inversion::reach::reach;
use crate::inversion::residuals::{by_curve, curve_residuals, neighbours, tests_by_curve, worst_curve};
use crate::inversion::settings::Search;
use crate::inversion::space::Space;
use crate::inversion::undetermined::{Held, unit_of_residuals};
use crate::inversion::wording::Missed;
use crate::inversion::{warnings, wording};
use crate::numerics::dot::dot;
use crate::optimise::{Loss, Minimum};
use crate::uncertainty::discrepancy::is_noise;
use crate::uncertainty::goodness::{excess, information_criteria};
use crate::uncertainty::identifiability::Identifiability;

/// Data that exceed the stated noise by this many standard deviations of chi² are missed by the model.
const MISSED: f64 = 3.7;
/// Neighbouring residuals that agree by this many standard deviations are no noise.
const STRUCTURED: f64 = 5.0;
/// A chi² above this for each degree of freedom is no noise that was stated too small, whatever the residuals look like:
/// between samples 10 nm apart the narrow fringes of thick layers have no neighbours to agree with.
const LOUD: f64 = 4.0;
/// chi² for each degree of freedom below which the structure of residuals does not matter.
const UNHEARD: f64 = 0.05;
/// Residuals this many standard deviations of chi² below the stated noise are not of it.
const OVERSTATED: f64 = 5.0;
/// Of the stated sigma the scatter that is told as less: above this it hardly matters, below the other the data are exact.
const QUIET: f64 = 0.7;
const HEARD: f64 = 0.01;
/// Scatter below this share of the largest reading is rounding.
const ROUNDING: f64 = 1e-6;
/// A model that lowers chi² by less than this below the best constant says nothing: of 300 sets of pure noise the fit
/// gained 21 at most, 15 in one of twenty (172 readings, two nuisances; each more adds about 1).
const CHANCE: f64 = 30.0;

/// What is said of a minimum.
pub(crate) struct Summary {
    pub(crate) outcome: FitOutcome,
    point: Evaluation,
    /// Standard deviation of a weighted residual.
    scatter: f64,
    /// The same, widened where the model misses the data.
    pub(crate) unit: f64,
}

/// What is said of a minimum; `None` if the model has no value there.
pub(crate) fn summarise(found: &Found<'_>) -> Option<Summary> {
    let problem = Problem::new(found.compiled, found.space, found.robust);
    let point = problem.evaluate(&found.best.parameters)?;
    let weighted = problem.plain_residuals(&point);
    let weighted = weighted.as_slice();
    let chi2 = dot(weighted, weighted);
    let in_use: Vec<usize> = (0..point.coefficients.len()).filter(|&i| point.coefficients[i] > 0.0).collect();
    let unknowns = found.space.freedom.free.len() + in_use.len();
    let dof = found.plan.len().saturating_sub(unknowns);
    let robust = robust(found, weighted, dof);
    let scatter = match &robust {
        #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
        Some(robust) => unit_of_residuals(found.data, robust.unit.powi(2) * dof as f64, dof),
        None => unit_of_residuals(found.data, chi2, dof),
    };
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let reduced = if dof > 0 { chi2 / dof as f64 } else { f64::NAN };
    let comparable = found.data.has_sigma() && found.settings.loss == Loss::Linear;
    let missed = comparable && excess(chi2, dof) > MISSED;
    let by_misfit = if missed { reduced.sqrt() } else { 1.0 };
    let residuals = by_curve(found, weighted, scatter);
    let correlation_of_residuals = neighbours(&residuals);
    // Residuals far below the stated noise, or below rounding, are not the model's: they have no say.
    let told = if found.data.has_sigma() { reduced > UNHEARD } else { scatter > ROUNDING * found.data.largest() };
    let tests = tests_by_curve(&residuals);
    // Residuals a little larger than stated that look like noise are noise: a factor mends it.
    let noise = is_noise(&tests, reduced / (scatter * scatter));
    let structured = told && (correlation_of_residuals.deviations > STRUCTURED || !noise);
    let loud = missed && noise && reduced > LOUD;
    // One curve beyond its noise, among others that fit, is lost in the sum over all.
    let lone = if missed || !comparable { None } else { worst_curve(&tests, MISSED) };
    let by_structure = if structured { correlation_of_residuals.widening() } else { 1.0 };
    let sigma_source = match (missed || structured || lone.is_some(), found.data.has_sigma()) {
        (true, _) => SigmaSource::Widened,
        (false, true) => SigmaSource::Stated,
        (false, false) => SigmaSource::Scatter,
    };
    let (plain_unit, unit) = (scatter * by_misfit, scatter * by_misfit * by_structure);
    let mut uncertainty = Uncertainty::new(found, &problem, &point, &in_use, unit, dof, sigma_source);
    let bent = structured || loud || lone.is_some() || (missed && !noise);
    let by_spread =
        if bent { uncertainty.widen(jackknife(found, &point, &in_use, loud && !structured), dof) } else { 1.0 };
    uncertainty.settle(found);
    let widened_by = by_misfit * by_structure * by_spread;
    let mut estimates = Parameter::ALL.map(|parameter| uncertainty.parameter(found, &point, parameter));
    let mut derived = uncertainty.derived(found, &point);
    reach(found, &problem, &uncertainty, unit, &mut estimates, &mut derived);
    let bound_costs = beyond(found, unit, &mut estimates, &mut derived);
    let left = if found.robust.is_empty() {
        chi2
    } else {
        weighted.iter().zip(found.robust).map(|(weighted, root)| (weighted * root).powi(2)).sum()
    };
    let gain = (about_constants(found) - left) / (plain_unit * plain_unit);
    #[allow(clippy::cast_precision_loss, reason = "a column count is small")]
    let by_luck = CHANCE + 2.0 * found.linear.columns.len().saturating_sub(3) as f64;
    let by_chance = gain < by_luck;
    if by_chance || !found.best.termination.was_successful() {
        let all = estimates.iter_mut().chain([&mut derived.period, &mut derived.optical_sum]);
        all.filter(|estimate| estimate.status != Status::Fixed).for_each(Estimate::withdraw);
    }
    let verdict = verdict(found, &estimates, &derived);
    let identifiability = identifiability(found, unit);
    let minima =
        listed(found.minima, found.searched, unit, found.settings.level, indices(found.data, &found.settings.stack));
    let mut warnings = Vec::new();
    if by_chance {
        warnings.push(if verdict == Verdict::Given {
            if gain < -by_luck {
                "a constant describes the data better than the given structure".to_owned()
            } else {
                "the data cannot tell the given structure from a constant".to_owned()
            }
        } else if found.settings.search == Search::Local {
            "the minimum next to the start explains nothing of the data: give a better start, or search everywhere"
                .to_owned()
        } else {
            let offset = if found.settings.nuisances.background == Extent::None {
                "; if the readings stand on an offset, fit it: --background shared"
            } else {
                ""
            };
            format!(
                "the data show no structure that the model explains: chi² is only {:.0} below that of a constant, which \
                 fitting pure noise would give{offset}",
                gain.max(0.0)
            )
        });
    }
    if (missed || structured || lone.is_some()) && (!by_chance || verdict == Verdict::Given) {
        let times = match lone {
            Some(lone) => Some((lone.times, Some(found.data.curves()[lone.curve].as_str()))),
            None => missed.then(|| (reduced.sqrt(), None)),
        };
        let agree = structured && correlation_of_residuals.deviations > STRUCTURED;
        let missed = Missed { times, structured, correlation: agree.then_some(correlation_of_residuals.value) };
        warnings.push(if verdict == Verdict::Given {
            wording::given_missed(missed)
        } else {
            wording::missed(missed, bent, widened_by)
        });
        warnings.push(warnings::may_help(found, &estimates, verdict));
    }
    let is_stated = comparable && sigma_source == SigmaSource::Stated && verdict != Verdict::Given;
    if is_stated && !by_chance && excess(chi2, dof) < -OVERSTATED && (HEARD..QUIET).contains(&reduced.sqrt()) {
        warnings.push(wording::overstated(reduced.sqrt()));
    }
    if missed || by_chance {
        warnings.extend(warnings::outlier(found, weighted, chi2));
    }
    if !by_chance {
        warnings.extend(identifiability.undetermined.iter().cloned());
        warnings.extend(warnings::hidden_scale(found));
        warnings.extend(warnings::open_intervals(found, &estimates));
        warnings.extend(warnings::bounds(found, &estimates));
        warnings.extend(warnings::others(found, &estimates, unit));
    }
    let (covariance, correlation) = uncertainty.named_matrices(found, &estimates);
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
        nuisance: uncertainty.nuisances(found, &point, bound_costs),
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
    Some(Summary { outcome, point, scatter, unit })
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
fn robust(found: &Found<'_>, weighted: &[f64], dof: usize) -> Option<Robust> {
    let (loss, scale) = (found.settings.loss, found.robust_unit);
    if loss == Loss::Linear {
        return None;
    }
    let (mut rho, mut pull, mut weight, mut slope) = (0.0, 0.0, 0.0, 0.0);
    for weighted in weighted {
        let z = weighted / scale;
        rho += loss.rho(z);
        pull += (z * loss.weight(z)).powi(2);
        weight += loss.weight(z);
        slope += loss.influence_slope(z);
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let (n, dof) = (weighted.len() as f64, dof.max(1) as f64);
    // Far outliers have a falling pull; if most are, the formula ends and the weights alone stand.
    let slope = (slope / n).max(0.1 * weight / n);
    Some(Robust { cost: scale * scale * rho, unit: scale * (pull / dof * (weight / n)).sqrt() / slope })
}

/// The weighted sum of squares about the best constant; about one for each curve where the fit has something of its own for each.
/// A robust loss weighs it as it weighs the fit.
fn about_constants(found: &Found<'_>) -> f64 {
    let nuisances = &found.settings.nuisances;
    let each = nuisances.scale == Extent::PerCurve || nuisances.background == Extent::PerCurve;
    let weighted = found.plan.rows.weighted(found.robust);
    let mut sums = vec![(0.0, 0.0, 0.0); found.plan.curves];
    let curve_of = |reading: &PlannedReading| if each { reading.curve } else { 0 };
    let mut first = 0;
    for span in found.plan.readings().chunk_by(|a, b| curve_of(a) == curve_of(b)) {
        let [w, y] = [&weighted.weights, &weighted.intensities].map(|values| &values[first..first + span.len()]);
        let sum = &mut sums[curve_of(&span[0])];
        *sum = (sum.0 + dot(w, w), sum.1 + dot(w, y), sum.2 + dot(y, y));
        first += span.len();
    }
    sums.iter().filter(|sum| sum.0 > 0.0).map(|(w, wy, yy)| yy - wy * wy / w).sum()
}

/// A row for each reading.
pub(crate) fn fitted_readings(found: &Found<'_>, summary: &Summary) -> Vec<FittedReading> {
    let Summary { point, scatter, .. } = summary;
    let (terms, curves, rows) = (point.terms.view(), 0..found.plan.curves, &found.plan.rows);
    let factors: Vec<_> = curves.map(|curve| found.linear.factors(curve, &point.coefficients)).collect();
    (found.plan.readings().iter().zip(found.data.readings()).zip(rows.weights()))
        .map(|((reading, Reading { intensity, .. }), weight)| {
            let parts = found.plan.parts(reading, terms);
            let (on_a, on_b, background) = factors[reading.curve];
            let (lamella, multilayer) = (on_a * parts.0, on_b * parts.1);
            let model = lamella + multilayer + background;
            let residual = intensity - model;
            let normalised = residual * weight / scatter;
            FittedReading { model, residual, normalised, lamella, multilayer, background }
        })
        .collect()
}

/// Akaike's corrected and Bayes's criterion, from chi² where sigma is stated and from the scatter where it is not.
fn criteria(has_sigma: bool, chi2: f64, readings: usize, unknowns: usize) -> (Option<f64>, f64) {
    if has_sigma {
        return information_criteria(chi2, readings, unknowns);
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let n = readings as f64;
    information_criteria(n * (chi2 / n).max(f64::MIN_POSITIVE).ln(), readings, unknowns + 1)
}

fn verdict(found: &Found<'_>, estimates: &[Estimate; COUNT], derived: &Derived) -> Verdict {
    if found.searched.freedom.free.is_empty() {
        return Verdict::Given;
    }
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

/// Sentences of the held directions. What a parameter has in common with one that is open by itself is open as well.
fn undetermined(held: &[&Held], ratio: f64) -> Vec<String> {
    let open: Vec<Parameter> = (held.iter().filter(|held| held.direction.len() == 1))
        .filter_map(|held| held.direction.first().map(|(parameter, _)| *parameter))
        .collect();
    let sentence = |held: &&Held| {
        let parts: Vec<Parameter> = held.direction.iter().map(|(parameter, _)| *parameter).collect();
        let rest: Vec<&str> = parts.iter().filter(|part| !open.contains(part)).map(|part| part.name()).collect();
        match rest.as_slice() {
            [name] if parts.len() == 2 => format!("{name} cannot be told apart from what is open besides"),
            _ => wording::undetermined(held, ratio),
        }
    };
    held.iter().map(sentence).collect()
}

fn identifiability(found: &Found<'_>, unit: f64) -> IdentifiabilityFound {
    let of = |minimum: &Minimum, space: &Space| Identifiability::new(&(&minimum.triangle / unit), &space.ranges);
    let analysis = of(&found.minima[0], found.searched);
    let ratio = index_ratio(found);
    // What is told in combination first, then what is not told at all, in the order of the parameters.
    let mut held: Vec<&Held> = found.held.iter().collect();
    held.sort_by_key(|held| (std::cmp::Reverse(held.direction.len()), held.direction.first().map(|(part, _)| *part)));
    IdentifiabilityFound {
        free: found.searched.freedom.free.iter().map(|parameter| parameter.name().to_owned()).collect(),
        rank: found.searched.freedom.free.len() - found.held.len(),
        condition: Some(analysis.condition).filter(|condition| condition.is_finite()),
        undetermined: undetermined(&held, ratio),
        combinations: if found.held.is_empty() {
            combinations(found.solution, &analysis)
        } else {
            combinations(found.solution, &of(found.best, found.space))
        },
    }
}
