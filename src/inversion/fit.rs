//! The fit: search, robust reweighting, what is determined, and the result.

use crate::dataset::Dataset;
use crate::inversion::atlas::likeliest_first;
use crate::inversion::compiled::Compiled;
use crate::inversion::estimates::Found;
use crate::inversion::outcome::{Estimate, Fit, Status};
use crate::inversion::problem::Problem;
use crate::inversion::search::{FINE, GlobalSearch, local_minimum};
use crate::inversion::settings::{FitSettings, Search, SettingsError};
use crate::inversion::solution::Solution;
use crate::inversion::space::Space;
use crate::inversion::summary::{Summary, fitted_readings, summarise};
use crate::inversion::undetermined::{Undetermined, apart_beyond, hold_undetermined, unit_of_residuals};
use crate::optics::OpticsError;
use crate::optimise::{BoundsError, LeastSquares, Loss, Minimum, minimise};
use crate::uncertainty::posterior::SamplerError;
use nalgebra::DVector;

/// A fit that could not begin.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// The choices cannot be fitted.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The model has no value for the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// Bounds without room.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// Too little data.
    #[error(
        "too few readings, {readings}, for the unknowns, {unknowns} (free parameters: {parameters}; scales, weights and \
         backgrounds: {}): it takes {} at least, or fewer unknowns",
        unknowns - parameters, unknowns + 1
    )]
    TooFewReadings {
        /// Readings in the data.
        readings: usize,
        /// Unknowns of the fit: free parameters, scales, weights, backgrounds.
        unknowns: usize,
        /// Free parameters among them.
        parameters: usize,
    },
    /// A point of another dimension than the problem.
    #[error("{found} values are given, but {expected} parameters are free")]
    Point {
        /// Values of the point.
        found: usize,
        /// Free parameters.
        expected: usize,
    },
    /// Intensities whose squares leave the range of numbers.
    #[error("the largest intensity is {largest:e}: give it in a unit in which it lies between 1e-100 and 1e100")]
    Unit {
        /// Largest intensity in size.
        largest: f64,
    },
    /// Data that are not those of the fit they are to be compared with.
    #[error("{readings} readings do not belong to a fit of {fitted}")]
    OtherData {
        /// Readings in the data.
        readings: usize,
        /// Readings of the fit.
        fitted: usize,
    },
    /// A reading that is in no curve of the data.
    #[error("a reading is of curve {curve}, counting from 0, but the data have {curves}")]
    NoCurve {
        /// Curve of the reading.
        curve: usize,
        /// Curves of the data.
        curves: usize,
    },
    /// A reading in a plane that its curve was not measured in.
    #[error(
        "curve {curve}, counting from 0, was not measured in the plane of a reading: nothing tells how bright it is there"
    )]
    NoScale {
        /// Curve of the reading.
        curve: usize,
    },
    /// Data that were planned and not measured.
    #[error("the data are a plan without intensities: measure them, or ask what they would tell (morpho-fit check)")]
    Plan,
    /// A bootstrap of a fit with a robust loss.
    #[error(
        "the bootstrap needs the linear loss: it would draw outliers onto other readings; profile and sample do without"
    )]
    RobustBootstrap,
    /// A posterior that cannot be sampled.
    #[error(transparent)]
    Sampler(#[from] SamplerError),
    /// The model has no finite value at a point that was asked for.
    #[error("the `{model}` model has no finite value at this point")]
    NotFinite {
        /// Name of the model.
        model: &'static str,
    },
    /// A constant that the settings do not have.
    #[error("{constant} cannot be fitted: {what}")]
    NoConstant {
        /// Name of the constant.
        constant: &'static str,
        /// Why, in words.
        what: &'static str,
    },
    /// A range without room, or beyond what the constant can be; user units.
    #[error("{constant} cannot be fitted from {low} to {high}: the range must rise, within {least} to {most}")]
    ConstantRange {
        /// Name of the constant.
        constant: &'static str,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
        /// Least value of the constant.
        least: f64,
        /// Largest value of the constant.
        most: f64,
    },
    /// The model has a finite value nowhere in the bounds.
    #[error("the `{model}` model has no finite value at any start within the bounds")]
    NowhereFinite {
        /// Name of the model.
        model: &'static str,
    },
}

/// Readings that the global stage looks at; more would cost time and not change the ranking of minima.
pub(crate) const THINNED: usize = 320;
/// Reweightings of a robust fit.
const REWEIGHTINGS: usize = 30;
/// A reweighting that changes the robust cost by less than this share is the last.
const SETTLED: f64 = 1e-9;

/// Fits `data`.
///
/// The same data, settings and version give the same result to the last bit, whatever the number of threads.
///
/// - `progress` is told what is being done, for a user who waits.
///
/// # Errors
/// [`FitError`] if the fit cannot begin. How it ended is in the outcome.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, fit};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, blue) = (BlendModel::default(), Structure::blue());
/// let data = simulate(&model, &blue, &Scan::full_design(&model, &blue)?, 1.0, 0.01, 7)?;
/// let found = fit(&data, &FitSettings::default(), &|_| {})?;
/// let d_air = &found.outcome.parameters.d_air;
/// assert!((d_air.value.unwrap() - 141.0).abs() < 4.0 * d_air.sigma.unwrap());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(data: &Dataset, settings: &FitSettings, progress: &(dyn Fn(&str) + Sync)) -> Result<Fit, FitError> {
    settings.validate()?;
    check(data)?;
    let model = settings.forward()?;
    let compiled = Compiled::new(data, settings, model.as_ref())?;
    let thin = match settings.search {
        Search::Global => Some(Compiled::thinned(data, settings, model.as_ref(), THINNED)?),
        Search::Local => None,
    };
    fit_compiled(&compiled, thin.as_ref(), progress)
}

/// Refuses a plan, and intensities whose squares leave the range of numbers.
pub(crate) fn check(data: &Dataset) -> Result<(), FitError> {
    if data.is_plan() {
        return Err(FitError::Plan);
    }
    let largest = data.largest();
    if largest > 1e100 || (largest > 0.0 && largest < 1e-100) { Err(FitError::Unit { largest }) } else { Ok(()) }
}

/// The fit of compiled data; `thin` has the readings that the global stage looks at, if there is one.
pub(crate) fn fit_compiled(
    compiled: &Compiled<'_>,
    thin: Option<&Compiled<'_>>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Fit, FitError> {
    let (mut solution, summary) = solve(compiled, thin, progress)?;
    let readings = fitted_readings(&Found::new(compiled, &solution), &summary);
    solution.unit = summary.unit;
    Ok(Fit { outcome: summary.outcome, readings, solution })
}

/// What is said of the fit of compiled data, with where it ended.
pub(crate) fn solve(
    compiled: &Compiled<'_>,
    thin: Option<&Compiled<'_>>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<(Solution, Summary), FitError> {
    let searched = Space::new(&compiled.settings.roles)?;
    let (readings, parameters) = (compiled.plan.len(), searched.freedom.free.len());
    let unknowns = parameters + compiled.linear.columns.len();
    if readings <= unknowns {
        return Err(FitError::TooFewReadings { readings, unknowns, parameters });
    }
    let Some(thin) = thin else {
        return judge(compiled, searched.clone(), local_minimum(compiled, &searched), progress);
    };
    let mut search = GlobalSearch::new(compiled, thin, &searched, progress);
    let first = judge(compiled, searched.clone(), search.minima(), progress);
    // Where data leave thicknesses, tilt or lobe open many structures fit alike: those that the first look misses, the intervals
    // would miss.
    let is_settled = matches!(&first, Ok((_, summary)) if summary.outcome.parameters.each()[..4].iter().all(is_told));
    let is_asked = !searched.freedom.free.is_empty();
    if is_asked && !is_settled && search.deepen(progress) {
        return judge(compiled, searched.clone(), search.minima(), progress);
    }
    first
}

/// Whether the data tell a parameter; a thickness may have several values, as where layers can be swapped.
fn is_told((name, estimate): &(&str, &Estimate)) -> bool {
    let may_be_several = ["d_air", "d_cuticle"].contains(name);
    match estimate.status {
        Status::Ok | Status::Correlated | Status::Fixed | Status::Linked => true,
        Status::Ambiguous => may_be_several,
        _ => false,
    }
}

/// What is said of these minima, with what the data leave of them.
fn judge(
    compiled: &Compiled<'_>,
    searched: Space,
    mut minima: Vec<Minimum>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<(Solution, Summary), FitError> {
    let (data, settings) = (compiled.data, compiled.settings);
    let unknowns = searched.freedom.free.len() + compiled.linear.columns.len();
    let (robust, robust_unit) = if settings.loss == Loss::Linear {
        (Vec::new(), 1.0)
    } else {
        progress("reweighting outliers");
        reweight(compiled, &searched, &mut minima)
    };
    minima.retain(|minimum| minimum.sum_of_squares.is_finite());
    if minima.is_empty() {
        return Err(FitError::NowhereFinite { model: compiled.plan.model_name() });
    }
    if robust.is_empty() {
        let dof = compiled.plan.len().saturating_sub(unknowns);
        let unit = unit_of_residuals(data, minima[0].sum_of_squares, dof);
        likeliest_first(&mut minima, &searched.ranges, unit);
    }
    progress("asking what the data determine");
    let Undetermined { held, stopped, space, best } = hold_undetermined(compiled, &robust, &searched, &minima[0])?;
    let minima = apart_beyond(minima, &held, &searched);
    let solution = Solution { searched, space, best, minima, held, stopped, robust, robust_unit, unit: 1.0 };
    let summary = summarise(&Found::new(compiled, &solution));
    let summary = summary.ok_or(FitError::NowhereFinite { model: compiled.plan.model_name() })?;
    Ok((solution, summary))
}

/// Square roots of the robust weights at the best minimum, and the residual that counts as one standard deviation;
/// `minima` are brought to the robust cost, which their sums of squares then are, and sorted by it.
fn reweight(compiled: &Compiled<'_>, space: &Space, minima: &mut [Minimum]) -> (Vec<f64>, f64) {
    let loss = compiled.settings.loss;
    let plain = |robust: &[f64], free: &DVector<f64>| {
        let problem = Problem::new(compiled, space, robust);
        let mut residuals = problem.residuals(free);
        for (residual, root) in residuals.iter_mut().zip(robust) {
            *residual /= root;
        }
        residuals
    };
    let scale = |residuals: &DVector<f64>| if compiled.data.has_sigma() { 1.0 } else { median_deviation(residuals) };
    let unit = vec![1.0; compiled.plan.len()];
    let common = minima.first().map_or(1.0, |best| scale(&plain(&unit, &best.parameters)));
    let cost = |residuals: &DVector<f64>| residuals.iter().map(|r| loss.rho(r / common)).sum::<f64>();
    let mut ranked: Vec<(f64, Vec<f64>, Minimum)> = minima
        .iter()
        .map(|minimum| {
            let mut minimum = minimum.clone();
            let mut weights = unit.clone();
            let mut residuals = plain(&unit, &minimum.parameters);
            let mut last = cost(&residuals);
            for _ in 0..REWEIGHTINGS {
                weights = residuals.iter().map(|r| loss.weight(r / common).sqrt()).collect();
                let problem = Problem::new(compiled, space, &weights);
                minimum = minimise(&problem, &minimum.parameters, FINE);
                residuals = plain(&weights, &minimum.parameters);
                let now = cost(&residuals);
                let falls = last - now > SETTLED * last;
                if !falls {
                    break;
                }
                last = now;
            }
            let cost = cost(&residuals);
            minimum.sum_of_squares = common * common * cost;
            (cost, weights, minimum)
        })
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (place, (_, _, minimum)) in minima.iter_mut().zip(&ranked) {
        *place = minimum.clone();
    }
    (ranked.into_iter().next().map(|(_, weights, _)| weights).unwrap_or_default(), common)
}

/// Median absolute residual times 1.4826: the standard deviation of a normal sample, whatever its outliers.
fn median_deviation(residuals: &DVector<f64>) -> f64 {
    let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0);
    if median > 0.0 { 1.4826 * median } else { 1.0 }
}
