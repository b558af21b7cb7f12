//! From a minimum to what is said about it: estimates, statuses, warnings, curves.

use crate::dataset::Dataset;
use crate::inversion::fit::{Held, unit_of_residuals};
use crate::inversion::nuisance::{Column, Extent, LinearPart, Multiplies};
use crate::inversion::outcome::{
    DataFound, Derived, Estimate, Fit, FitOutcome, FittedReading, IdentifiabilityFound, MinimumFound, NamedMatrix,
    NuisanceFound, Parameters, SCHEMA, SigmaSource, Status, Verdict,
};
use crate::inversion::parameter::{COUNT, Parameter, Role};
use crate::inversion::plan::Plan;
use crate::inversion::problem::{Evaluation, Problem};
use crate::inversion::search::Space;
use crate::inversion::settings::FitSettings;
use crate::inversion::wording;
use crate::optics::ReflectivityModel;
use crate::optimise::{Loss, Minimum};
use crate::uncertainty::covariance::{correlation, covariance};
use crate::uncertainty::goodness::{NINETY_FIVE, ONE_SIGMA, excess, student};
use crate::uncertainty::identifiability::Identifiability;
use nalgebra::{DMatrix, DVector};

/// Data that exceed the stated noise by this many standard deviations of chi² are missed by the model.
const MISSED: f64 = 3.7;
/// A correlation beyond this is a status of its own.
const CORRELATED: f64 = 0.99;
/// Minima within this chi² of the best fit as well: three standard deviations of one parameter.
const AS_GOOD: f64 = 9.0;
/// A value at another minimum is another value if it lies off by more standard deviations than this, ...
const ELSEWHERE: f64 = 3.0;
/// ... and by more than this share of a change that matters.
const NOTICEABLE: f64 = 0.2;
/// Minima listed.
const LISTED: usize = 10;
/// A model that lowers chi² by less than this below the best constant says nothing: of 300 sets of pure noise the fit
/// gained 21 at most, 15 in one of twenty.
const CHANCE: f64 = 30.0;
/// A derived quantity that changes by more than this share along an undetermined direction is undetermined.
const LEAK: f64 = 0.05;

/// Everything a summary is made of.
#[derive(Debug)]
pub(crate) struct Found<'a> {
    pub(crate) data: &'a Dataset,
    pub(crate) settings: &'a FitSettings,
    pub(crate) model: &'a dyn ReflectivityModel,
    pub(crate) plan: &'a Plan<'a>,
    pub(crate) linear: &'a LinearPart,
    pub(crate) robust: &'a [f64],
    /// The space that was searched.
    pub(crate) searched: &'a Space,
    /// What was left of it when the undetermined parameters were taken out.
    pub(crate) space: &'a Space,
    pub(crate) best: &'a Minimum,
    pub(crate) minima: &'a [Minimum],
    pub(crate) held: &'a [Held],
}

/// Covariance over the parameters that moved freely, and the rules for intervals.
struct Uncertainty {
    /// Free parameters inside their bounds, inside units.
    inner: Vec<Parameter>,
    /// Covariance of these, then of the nuisances in use; `None` if it does not exist.
    matrix: Option<DMatrix<f64>>,
    columns: Vec<usize>,
    quantile_68: f64,
    quantile_95: f64,
    /// Standard deviation of a weighted residual.
    unit: f64,
}

/// Minima that fit as well as the best, itself left out.
fn as_good<'a>(found: &Found<'a>, unit: f64) -> impl Iterator<Item = &'a Minimum> {
    let best = found.minima[0].sum_of_squares();
    found.minima[1..].iter().filter(move |other| other.sum_of_squares() - best < AS_GOOD * unit * unit)
}

/// Values of a parameter, user units, at other minima that fit as well, where they differ from the estimate.
fn others(found: &Found<'_>, estimate: &Estimate, parameter: Parameter, unit: f64) -> Vec<f64> {
    let (Some(value), Some(sigma)) = (estimate.value, estimate.sigma) else { return Vec::new() };
    let far = (ELSEWHERE * sigma).max(NOTICEABLE * parameter.outside(parameter.typical_change()));
    as_good(found, unit)
        .map(|minimum| parameter.outside(found.searched.freedom.expand(&minimum.parameters)[parameter.index()]))
        .filter(|other| (other - value).abs() > far)
        .collect()
}

pub(crate) fn summarise(found: &Found<'_>) -> Fit {
    let problem = Problem::new(
        found.plan,
        found.linear,
        &found.space.freedom,
        &found.space.bounds,
        &found.space.scales,
        found.robust,
    );
    // The best point was evaluated before, so it is in the models' domain.
    let point =
        problem.evaluate(&found.best.parameters).unwrap_or_else(|| Evaluation::empty(found.linear.columns.len()));
    let readings = fitted_readings(found, &point);
    let chi2: f64 = (found.plan.readings.iter().zip(&readings))
        .map(|(planned, fitted)| (fitted.residual * planned.weight).powi(2))
        .sum();
    let in_use: Vec<usize> = (0..point.coefficients.len()).filter(|&i| point.coefficients[i] > 0.0).collect();
    let unknowns = found.space.freedom.free.len() + in_use.len();
    let dof = found.plan.len().saturating_sub(unknowns);
    let weighted = found.best.sum_of_squares();
    let unit = unit_of_residuals(found.data, weighted, dof);
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let reduced = if dof > 0 { chi2 / dof as f64 } else { f64::NAN };
    let missed = found.data.has_sigma() && found.settings.loss == Loss::Linear && excess(chi2, dof) > MISSED;
    let (sigma_source, unit) = match (found.data.has_sigma(), missed) {
        (false, _) => (SigmaSource::Scatter, unit),
        (true, false) => (SigmaSource::Stated, unit),
        (true, true) => (SigmaSource::Widened, unit * reduced.sqrt()),
    };
    let uncertainty = Uncertainty::new(found, &problem, &point, &in_use, unit, dof, sigma_source);
    let mut estimates = Parameter::ALL.map(|parameter| uncertainty.parameter(found, &point, parameter));
    let mut derived = uncertainty.derived(found, &point);
    let gain = (chi2_of_constants(found) - chi2) / (unit * unit);
    let by_chance = gain < CHANCE && found.settings.loss == Loss::Linear;
    if by_chance {
        let fitted = estimates.iter_mut().filter(|estimate| estimate.bounds.is_some());
        fitted.chain([&mut derived.period, &mut derived.optical_sum]).for_each(withdraw);
    }
    let verdict = verdict(found, &estimates, &derived);
    let identifiability = identifiability(found, unit);
    let minima = minima(found);
    let mut warnings = Vec::new();
    if missed {
        warnings.push(format!(
            "the model misses the data by {:.1} times the stated noise; the standard deviations are widened by that factor, \
             and the split of the layers depends on the model",
            reduced.sqrt()
        ));
    }
    if by_chance {
        warnings.push(format!(
            "the data show no structure: chi² is only {:.0} below that of a constant, which pure noise would give",
            gain.max(0.0)
        ));
    }
    warnings.extend(identifiability.undetermined.iter().cloned());
    warnings.extend(warn_of_bounds(&estimates));
    warnings.extend(warn_of_others(found, &estimates, unit));
    let covariance = uncertainty.named_covariance(found);
    let (aicc, bic) = criteria(found.data.has_sigma(), chi2, found.plan.len(), unknowns);
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = estimates;
    let outcome = FitOutcome {
        schema: SCHEMA.to_owned(),
        verdict,
        warnings,
        parameters: Parameters { d_air, d_cuticle, delta, phi_alpha, lamella_width },
        derived,
        chi2,
        robust_cost: (found.settings.loss != Loss::Linear).then_some(weighted),
        dof,
        aicc,
        bic,
        sigma_source,
        sigma_ratio: found.data.has_sigma().then(|| reduced.sqrt()).filter(|ratio| ratio.is_finite()),
        correlation: NamedMatrix { names: covariance.names.clone(), rows: rows(&correlation(&matrix(&covariance))) },
        covariance,
        minima,
        identifiability,
        nuisance: uncertainty.nuisances(found, &point),
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
    };
    Fit { outcome, readings }
}

/// Takes back a value that the data do not support.
fn withdraw(estimate: &mut Estimate) {
    estimate.status = Status::NotIdentifiable;
    estimate.held_at = estimate.value.take().or(estimate.held_at);
    (estimate.sigma, estimate.interval_68, estimate.interval_95) = (None, None, None);
    estimate.others.clear();
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
    let scatter =
        unit_of_residuals(found.data, found.best.sum_of_squares(), found.plan.len() - point.coefficients.len());
    (found.plan.readings.iter())
        .map(|reading| {
            let parts = found.plan.parts(reading, point.terms.view());
            let (on_a, on_b, background) = found.linear.factors(reading.curve, &point.coefficients);
            let (lamella, multilayer) = (on_a * parts.0, on_b * parts.1);
            let model = lamella + multilayer + background;
            let residual = reading.intensity - model;
            FittedReading {
                model,
                residual,
                normalised: residual * reading.weight / scatter,
                lamella,
                multilayer,
                background,
            }
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
    let thickness = [Parameter::DAir, Parameter::DCuticle].iter().any(asked);
    let nothing =
        thickness && ![&estimates[0], &estimates[1], &derived.period, &derived.optical_sum].into_iter().any(told);
    if nothing {
        Verdict::NothingDetermined
    } else if Parameter::ALL.iter().filter(|p| asked(p)).all(|p| told(&estimates[p.index()])) {
        Verdict::Determined
    } else {
        Verdict::PartlyDetermined
    }
}

fn identifiability(found: &Found<'_>, unit: f64) -> IdentifiabilityFound {
    let jacobian = &found.minima[0].jacobian / unit;
    let analysis = Identifiability::new(&jacobian, &found.searched.ranges);
    let ratio = index_ratio(found);
    IdentifiabilityFound {
        free: found.searched.freedom.free.iter().map(|parameter| parameter.name().to_owned()).collect(),
        rank: found.searched.freedom.free.len() - found.held.len(),
        condition: Some(analysis.condition).filter(|condition| condition.is_finite()),
        undetermined: found.held.iter().map(|held| wording::undetermined(held, ratio)).collect(),
    }
}

/// Real indices of gap and cuticle at the middle wavelength of the data.
fn indices(found: &Found<'_>) -> (f64, f64) {
    let mut wavelengths: Vec<f64> = found.data.readings().iter().map(|reading| reading.wavelength).collect();
    wavelengths.sort_by(f64::total_cmp);
    let middle = wavelengths.get(wavelengths.len() / 2).copied().unwrap_or(550.0);
    found.model.stack().media(middle).map_or((1.0, 1.56), |media| (media.gap.re, media.cuticle.re))
}

fn index_ratio(found: &Found<'_>) -> f64 {
    let (gap, cuticle) = indices(found);
    cuticle / gap
}

fn minima(found: &Found<'_>) -> Vec<MinimumFound> {
    let of = |minimum: &Minimum| {
        let values = found.searched.freedom.expand(&minimum.parameters);
        let mut outside = [0.0; COUNT];
        for parameter in Parameter::ALL {
            outside[parameter.index()] = parameter.outside(values[parameter.index()]);
        }
        MinimumFound { chi2: minimum.sum_of_squares(), values: outside, termination: minimum.termination }
    };
    found.minima.iter().take(LISTED).map(of).collect()
}

fn warn_of_bounds(estimates: &[Estimate; COUNT]) -> Vec<String> {
    (Parameter::ALL.iter().zip(estimates))
        .filter(|(_, estimate)| estimate.status == Status::AtBound)
        .map(|(parameter, estimate)| {
            let value = estimate.value.unwrap_or_default();
            let unit = parameter.unit();
            format!("{parameter} ended on its bound {value:.4} {unit}: widen it with --bounds {parameter}=LOW:HIGH")
        })
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

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

fn matrix(named: &NamedMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(named.rows.len(), named.rows.len(), |i, j| named.rows[i][j])
}

impl Uncertainty {
    fn new(
        found: &Found<'_>,
        problem: &Problem<'_>,
        point: &Evaluation,
        in_use: &[usize],
        unit: f64,
        dof: usize,
        source: SigmaSource,
    ) -> Self {
        let free = &found.space.freedom.free;
        let (lower, upper) = (found.space.bounds.lower(), found.space.bounds.upper());
        let at = &found.best.parameters;
        let moved: Vec<usize> = (0..free.len()).filter(|&j| at[j] > lower[j] && at[j] < upper[j]).collect();
        let full = problem.full_jacobian(point);
        let columns: Vec<usize> = moved.iter().copied().chain(free.len()..full.ncols()).collect();
        let matrix = covariance(&full.select_columns(&columns)).map(|matrix| matrix * (unit * unit));
        let quantile = |z| if source == SigmaSource::Scatter { student(z, dof) } else { z };
        Self {
            inner: moved.iter().map(|&j| free[j]).collect(),
            matrix,
            columns: in_use.to_vec(),
            quantile_68: quantile(ONE_SIGMA),
            quantile_95: quantile(NINETY_FIVE),
            unit,
        }
    }

    /// Variance of `sum_j gradient_j · parameter_j` over the free parameters inside their bounds.
    fn variance(&self, gradient: &[f64; COUNT], found: &Found<'_>) -> Option<f64> {
        let matrix = self.matrix.as_ref()?;
        let to_free = found.space.freedom.matrix();
        let mut along = DVector::zeros(matrix.nrows());
        for (c, parameter) in self.inner.iter().enumerate() {
            let column = found.space.freedom.free.iter().position(|free| free == parameter)?;
            along[c] = (0..COUNT).map(|row| gradient[row] * to_free[(row, column)]).sum();
        }
        Some((matrix * &along).dot(&along).max(0.0))
    }

    fn parameter(&self, found: &Found<'_>, point: &Evaluation, parameter: Parameter) -> Estimate {
        let inside = point.values[parameter.index()];
        let mut gradient = [0.0; COUNT];
        gradient[parameter.index()] = 1.0;
        let mut estimate = Estimate {
            value: Some(parameter.outside(inside)),
            unit: parameter.unit().to_owned(),
            sigma: None,
            status: Status::Ok,
            with: Vec::new(),
            interval_68: None,
            interval_95: None,
            others: Vec::new(),
            held_at: None,
            bounds: None,
        };
        let role = found.settings.roles[parameter.index()];
        if let Role::Free { lower, upper } = role {
            estimate.bounds = Some([parameter.outside(lower), parameter.outside(upper)]);
        }
        if let Role::Fixed { .. } = role {
            estimate.status = Status::Fixed;
            return estimate;
        }
        let touched: Vec<&Held> =
            found.held.iter().filter(|held| held.direction.iter().any(|(part, _)| *part == parameter)).collect();
        if !touched.is_empty() {
            let alone = touched.iter().any(|held| held.direction.len() == 1 && held.deviation.is_infinite());
            estimate.status = if alone { Status::Insensitive } else { Status::NotIdentifiable };
            let partners = touched.iter().flat_map(|held| &held.direction).map(|(part, _)| *part);
            let mut partners: Vec<Parameter> = partners.filter(|part| *part != parameter).collect();
            partners.sort();
            partners.dedup();
            estimate.with = partners.iter().map(|part| part.name().to_owned()).collect();
            estimate.held_at = estimate.value.take();
            return estimate;
        }
        let followed = match role {
            Role::Linked { other, .. } => {
                estimate.status = Status::Linked;
                estimate.with = vec![other.name().to_owned()];
                other
            }
            Role::Free { .. } | Role::Fixed { .. } => parameter,
        };
        if role_is_free(role) && !self.inner.contains(&followed) {
            estimate.status = Status::AtBound;
            return estimate;
        }
        let sigma = self.variance(&gradient, found).map(f64::sqrt);
        self.finish(&mut estimate, sigma.map(|sigma| parameter.outside(sigma)));
        if estimate.status == Status::Ok {
            estimate.with = self.correlated_with(parameter);
            if !estimate.with.is_empty() {
                estimate.status = Status::Correlated;
            }
        }
        estimate.others = others(found, &estimate, parameter, self.unit);
        if !estimate.others.is_empty() {
            estimate.status = Status::Ambiguous;
        }
        estimate
    }

    /// Names of the parameters whose correlation with `parameter` is beyond [`CORRELATED`].
    fn correlated_with(&self, parameter: Parameter) -> Vec<String> {
        let (Some(matrix), Some(row)) = (&self.matrix, self.inner.iter().position(|p| *p == parameter)) else {
            return Vec::new();
        };
        let correlation = correlation(matrix);
        let close = |&(column, other): &(usize, &Parameter)| {
            column != row && *other != parameter && correlation[(row, column)].abs() > CORRELATED
        };
        self.inner.iter().enumerate().filter(close).map(|(_, other)| other.name().to_owned()).collect()
    }

    /// Sigma and intervals; an interval that reaches a bound is open there.
    fn finish(&self, estimate: &mut Estimate, sigma: Option<f64>) {
        let (Some(value), Some(sigma)) = (estimate.value, sigma.filter(|sigma| sigma.is_finite())) else {
            return;
        };
        estimate.sigma = Some(sigma);
        let bounds = estimate.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let interval = |quantile: f64| {
            let (low, high) = (value - quantile * sigma, value + quantile * sigma);
            [(low > bounds[0]).then_some(low), (high < bounds[1]).then_some(high)]
        };
        estimate.interval_68 = Some(interval(self.quantile_68));
        let wide = interval(self.quantile_95);
        estimate.interval_95 = Some(wide);
        if estimate.status == Status::Ok && wide.contains(&None) {
            estimate.status = Status::OneSided;
        }
    }

    fn derived(&self, found: &Found<'_>, point: &Evaluation) -> Derived {
        let (gap, cuticle) = indices(found);
        let of = |gradient: [f64; COUNT]| {
            let value: f64 = gradient.iter().zip(&point.values).map(|(g, value)| g * value).sum();
            let mut estimate = Estimate {
                value: Some(value),
                unit: "nm".to_owned(),
                sigma: None,
                status: Status::Ok,
                with: Vec::new(),
                interval_68: None,
                interval_95: None,
                others: Vec::new(),
                held_at: None,
                bounds: None,
            };
            let free_thickness =
                [Parameter::DAir, Parameter::DCuticle].into_iter().any(|p| found.space.freedom.moves(p));
            let mut extra = 0.0;
            for held in found.held {
                let changes = held.direction.iter().map(|(part, step)| gradient[part.index()] * step);
                let (change, size) = changes.fold((0.0, 0.0), |(sum, size), c| (sum + c, size + f64::abs(c)));
                if size > 0.0 && f64::abs(change) > LEAK * size {
                    estimate.status = Status::NotIdentifiable;
                    estimate.held_at = estimate.value.take();
                    return estimate;
                }
                extra += (change * held.deviation.min(1.0)).powi(2);
            }
            if !free_thickness {
                estimate.status = Status::Fixed;
                return estimate;
            }
            let at_bound = [Parameter::DAir, Parameter::DCuticle]
                .into_iter()
                .any(|p| found.space.freedom.free.contains(&p) && !self.inner.contains(&p));
            if at_bound {
                estimate.status = Status::AtBound;
            }
            let sigma = self.variance(&gradient, found).map(|variance| (variance + extra).sqrt());
            self.finish(&mut estimate, sigma);
            estimate
        };
        Derived { period: of([1.0, 1.0, 0.0, 0.0, 0.0]), optical_sum: of([gap, cuticle, 0.0, 0.0, 0.0]) }
    }

    fn named_covariance(&self, found: &Found<'_>) -> NamedMatrix {
        let Some(matrix) = &self.matrix else { return NamedMatrix::default() };
        let names: Vec<String> = (self.inner.iter().map(|parameter| parameter.name().to_owned()))
            .chain(self.columns.iter().map(|&i| column_name(&found.linear.columns[i], found.data)))
            .collect();
        let factor = |j: usize| self.inner.get(j).map_or(1.0, |parameter| parameter.outside(1.0));
        let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| factor(i) * factor(j) * matrix[(i, j)]);
        NamedMatrix { names, rows: rows(&scaled) }
    }

    fn nuisances(&self, found: &Found<'_>, point: &Evaluation) -> Vec<NuisanceFound> {
        let sigma = |i: usize| {
            let place = self.columns.iter().position(|&column| column == i)? + self.inner.len();
            self.matrix.as_ref().map(|matrix| matrix[(place, place)].sqrt())
        };
        (found.linear.columns.iter().enumerate())
            .map(|(i, column)| NuisanceFound {
                name: column_name(column, found.data),
                value: point.coefficients[i],
                sigma: sigma(i),
            })
            .collect()
    }
}

fn role_is_free(role: Role) -> bool {
    matches!(role, Role::Free { .. })
}

/// `scale`, `lamella_scale` (scale · weight) or `background`, with the curve it belongs to.
fn column_name(column: &Column, data: &Dataset) -> String {
    let what = match column.multiplies {
        Multiplies::Lamella => "lamella_scale",
        Multiplies::Multilayer | Multiplies::Both => "scale",
        Multiplies::One => "background",
    };
    column.curve.map_or_else(|| what.to_owned(), |curve| format!("{what} of {}", data.curves()[curve]))
}
