//! `fit` and its result.

use super::arrays::array;
use super::data::{self, Given, Said};
use super::errors::{of_fit, refused, unfit};
use super::intervals::{Methods, Posterior, ProfileFound, bootstraps_of, count};
use super::model::Model;
use super::patience::patiently;
use super::settings::{Keywords, settings};
use super::structure::Structure;
use crate::dataset::Dataset;
use crate::export::{ExportError, fit_json};
use crate::inversion::intervals::{self, PosteriorSettings};
use crate::inversion::{
    AdviceError, Ask, Estimate, Extent, Fit, FitError, FittedReading, NamedMatrix, Parameter, SigmaSource, Verdict,
    advise, choose, fit as fitted, predict, structure,
};
use crate::report::{html, terminal, uncertainty, wording};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArrayDyn};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Fits a measurement; the same result, to the last bit, as the command with the same data and settings.
///
/// data is the path of a CSV file, its text or bytes, or a table whose columns have the names and units of the file: a dict of arrays
/// [n], a frame of pandas or polars. Columns: wavelength_nm, theta_deg, phi_deg, omega_deg, intensity, and if they are known
/// sigma, curve, polarization. What is the same for all readings may be a keyword: wavelength (nm), theta, phi, omega
/// (degrees), sigma, polarization. wide ("theta", "phi", "curve") reads a wide file, intensity_column names another column.
///
/// model: "blend", "hybrid", "paper", "auto" or a Model. fix={"d_cuticle": 62}, bounds={"d_air": (50, 250)},
/// start={"d_air": 120}, link={"d_cuticle": ("d_air", factor, constant)}, in nm, degrees, and radians for phi_alpha;
/// require=["d_air"]. scale, background: "none", "shared", "per-curve". weight: "fit" or a number. loss: "linear", "soft-l1",
/// "huber", "cauchy". local, derivative ("exact", "finite-difference"), level, seed: as the command's flags.
///
/// uncertainty: any of "profile", "bootstrap", "sample", "all", with replicates, effective, max_evaluations. advise=False leaves
/// out what to measure next.
///
/// Raises DataError (with path, line, column, reading, findings), FitError, OpticsError, OSError. Ctrl-C ends it.
#[pyfunction]
#[pyo3(
    signature = (data, **settings),
    text_signature = "(data, *, model='blend', fix=None, bounds=None, start=None, link=None, require=None, scale='shared', \
        background='none', weight='fit', loss='linear', local=False, derivative='exact', level=9.0, seed=1, uncertainty=None, \
        replicates=1000, effective=4000, max_evaluations=400000, advise=True, wavelength=None, theta=None, phi=None, \
        omega=None, sigma=None, polarization=None, wide=None, intensity_column=None)"
)]
pub(crate) fn fit(
    py: Python<'_>,
    data: &Bound<'_, PyAny>,
    settings: Option<&Bound<'_, PyDict>>,
) -> PyResult<FitResult> {
    let mut keywords = Keywords::of(settings)?;
    let said = Said::take(&mut keywords)?;
    let (model, settings) = self::settings(py, &mut keywords)?;
    let methods = Methods::take(&mut keywords)?;
    let asked = keywords.take("advise")?.unwrap_or(true);
    keywords.finish()?;
    let Given { data, name, notes } = data::dataset(py, data, &said)?;
    let work = |progress: &(dyn Fn(&str) + Sync)| -> Result<Fit, Trouble> {
        let mut found = match model.auto {
            Some(beside) => choose(&data, &settings, &[beside], progress)?.fit,
            None => fitted(&data, &settings, progress)?,
        };
        found.outcome.data.notes.extend(notes);
        // More data do not mend a model that misses those there are.
        if asked && found.outcome.sigma_source != SigmaSource::Widened {
            let advice = advise(&data, &found, Ask::IfNeeded)?;
            found.outcome.advice = advice.into_iter().map(|proposal| proposal.found).collect();
        }
        methods.add_to(&data, &mut found, progress)?;
        Ok(found)
    };
    let fit = patiently(py, work)?.map_err(|trouble| match trouble {
        Trouble::Fit(error) => of_fit(py, &error),
        Trouble::Advice(error) => unfit(error.to_string()),
    })?;
    Ok(FitResult { fit, data, name })
}

/// A part of a reading beside the model.
type Part = fn(&FittedReading) -> f64;

/// Why a fit has no result.
enum Trouble {
    Fit(FitError),
    Advice(AdviceError),
}

impl From<FitError> for Trouble {
    fn from(error: FitError) -> Self {
        Self::Fit(error)
    }
}

impl From<AdviceError> for Trouble {
    fn from(error: AdviceError) -> Self {
        Self::Advice(error)
    }
}

/// The result of a fit; fit() makes it.
#[pyclass(frozen, module = "morpho_fit")]
#[derive(Debug)]
pub(crate) struct FitResult {
    fit: Fit,
    data: Dataset,
    name: String,
}

/// A value for each parameter, by name.
fn by_name<'py>(py: Python<'py>, fit: &Fit, of: impl Fn(&Estimate) -> Option<f64>) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for (name, estimate) in fit.outcome.parameters.each() {
        all.set_item(name, of(estimate))?;
    }
    all.set_item("period", of(&fit.outcome.derived.period))?;
    all.set_item("optical_sum", of(&fit.outcome.derived.optical_sum))?;
    Ok(all)
}

fn matrix<'py>(py: Python<'py>, found: &NamedMatrix) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let size = found.rows.len();
    let flat = found.rows.iter().flatten().copied().collect();
    let shaped = Array2::from_shape_vec((size, size), flat).map_err(|error| refused(error.to_string()))?;
    Ok(shaped.into_pyarray(py))
}

fn unwritten(error: &ExportError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

impl FitResult {
    fn json(&self) -> PyResult<String> {
        let bytes = fit_json(&self.fit.outcome).map_err(|error| unwritten(&error))?;
        String::from_utf8(bytes).map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    fn serialised<'py, T: serde::Serialize>(&self, py: Python<'py>, part: &T) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(part).map_err(|error| unwritten(&error.into()))?;
        py.import("json")?.call_method1("loads", (text,))
    }
}

#[pymethods]
impl FitResult {
    /// "determined", "partly_determined", "no_thickness", "not_converged" or "given" (nothing was free).
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.serialised(py, &self.fit.outcome.verdict)
    }

    /// What a reader must know, the most important first.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.fit.outcome.warnings.clone()
    }

    /// Whether the fit ended in a minimum.
    #[getter]
    fn converged(&self) -> bool {
        self.fit.outcome.verdict != Verdict::NotConverged
    }

    /// Best values by name, and of `period` and `optical_sum`, user units; None where the data do not determine one.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, &self.fit, |estimate| estimate.value)
    }

    /// Their standard deviations; None where they mean nothing.
    #[getter]
    fn sigma<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_name(py, &self.fit, |estimate| estimate.sigma)
    }

    /// All that is said of each parameter, as in fit.json: value, unit, sigma, status, with, intervals, bounds.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.serialised(py, &self.fit.outcome.parameters)
    }

    /// Scale, weight and background: a list of dicts with name, value, sigma, conditional.
    #[getter]
    fn nuisance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.serialised(py, &self.fit.outcome.nuisance)
    }

    /// The distinct minima, best first: dicts with chi2, delta_chi2, fits, weight, relation, values, termination.
    #[getter]
    fn minima<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.serialised(py, &self.fit.outcome.minima)
    }

    /// The structure at the best minimum; what is not determined is as the fit ended. None without a minimum.
    #[getter]
    fn structure(&self) -> Option<Structure> {
        let mut values = self.fit.outcome.minima.first()?.values;
        for (value, parameter) in values.iter_mut().zip(Parameter::ALL) {
            *value = parameter.inside(*value);
        }
        Some(Structure::of_inside(structure(&values)))
    }

    /// The model that was fitted.
    #[getter]
    fn model(&self, py: Python<'_>) -> PyResult<Model> {
        let settings = &self.fit.outcome.settings;
        let made = Model::build(settings.model, settings.stack.clone(), settings.averages, None);
        made.map_err(|error| super::errors::of_optics(py, &error, None))
    }

    /// Sum of squared residuals, in units of sigma² where the data state one.
    #[getter]
    fn chi2(&self) -> f64 {
        self.fit.outcome.chi2
    }

    /// Readings less parameters and nuisances in use.
    #[getter]
    fn dof(&self) -> usize {
        self.fit.outcome.dof
    }

    /// Names of the rows of covariance and correlation: free parameters, then nuisances in use.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.fit.outcome.covariance.names.clone()
    }

    /// Covariance [k, k] of `names`, user units; [0, 0] where it does not exist.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, &self.fit.outcome.covariance)
    }

    /// Correlation [k, k] of `names`.
    #[getter]
    fn correlation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        matrix(py, &self.fit.outcome.correlation)
    }

    /// Residuals [n] in units of their standard deviation: data less model, in the order of the data.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values: Vec<f64> = self.fit.readings.iter().map(|reading| reading.normalised).collect();
        let shape = [values.len()];
        array(py, values, &shape)
    }

    /// The data beside the model, as in curves.csv: a dict of columns [n], ready for a frame.
    fn curves<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = data::columns(py, &self.data)?;
        let columns: [(&str, Part); 6] = [
            ("model", |one| one.model),
            ("residual", |one| one.residual),
            ("normalised_residual", |one| one.normalised),
            ("lamella", |one| one.lamella),
            ("multilayer", |one| one.multilayer),
            ("background", |one| one.background),
        ];
        for (name, of) in columns {
            let values: Vec<f64> = self.fit.readings.iter().map(of).collect();
            let shape = [values.len()];
            all.set_item(name, array(py, values, &shape)?)?;
        }
        Ok(all)
    }

    /// The fitted model at readings that need not be of the data: a dict of columns [n], ready for a frame.
    ///
    /// design has the columns of data but intensity and sigma: a dict of arrays [n] or a frame; what is the same for all readings may be
    /// a keyword: wavelength (nm), theta, phi, omega (degrees), polarization. Where curves have a scale or background each, a column
    /// curve says which a reading has. No two rows of a curve are alike. Added: model, lamella, multilayer, background.
    #[pyo3(
        signature = (design, **constants),
        text_signature = "($self, design, *, wavelength=None, theta=None, phi=None, omega=None, polarization=None)"
    )]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        design: &Bound<'py, PyAny>,
        constants: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut keywords = Keywords::of(constants)?;
        let design = data::design(py, design, &mut keywords)?;
        keywords.finish()?;
        let nuisances = &self.fit.outcome.settings.nuisances;
        let alike = ![nuisances.scale, nuisances.background].contains(&Extent::PerCurve);
        let readings = data::in_curves_of(&self.data, &design, alike)?;
        let found = py.detach(|| predict(&self.data, &self.fit, &readings)).map_err(|error| of_fit(py, &error))?;
        let all = data::columns(py, &design)?;
        all.del_item("intensity")?;
        let put = |name, values: Vec<f64>| all.set_item(name, array(py, values, &[found.len()])?);
        put("model", found.iter().map(|one| one.model).collect())?;
        put("lamella", found.iter().map(|one| one.lamella).collect())?;
        put("multilayer", found.iter().map(|one| one.multilayer).collect())?;
        put("background", found.iter().map(|one| one.background).collect())?;
        Ok(all)
    }

    /// fit.json as text, byte for byte.
    fn to_json(&self) -> PyResult<String> {
        self.json()
    }

    /// fit.json as dicts and lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.json()?,))
    }

    /// The report that the command prints, in lines of its width.
    #[pyo3(signature = (width=100))]
    fn summary(&self, width: usize) -> String {
        let mut report = terminal::text(&self.fit, width);
        if let Some(found) = &self.fit.outcome.uncertainty {
            report.push_str(&format!("\n{}", uncertainty::text(found, width)));
        }
        report
    }

    /// report.html as text, without charts: one page that needs no other file.
    fn to_html(&self) -> String {
        html::page(&self.fit.outcome, &self.name, &[], &[])
    }

    fn _repr_html_(&self) -> String {
        html::fragment(&self.fit.outcome, &self.name)
    }

    fn __repr__(&self) -> String {
        format!("<FitResult: {}>", wording::verdict(&self.fit.outcome))
    }

    /// Profile likelihood of every quantity, as the command's `profile`.
    fn profile(&self, py: Python<'_>) -> PyResult<Vec<ProfileFound>> {
        let found = patiently(py, |progress| intervals::profiles(&self.data, &self.fit, progress))?;
        let found = found.map_err(|error| of_fit(py, &error))?;
        Ok(found.quantities.into_iter().map(ProfileFound::of).collect())
    }

    /// Samples of the posterior, as the command's `sample`. seed is that of the fit unless given.
    #[pyo3(signature = (*, effective=4000, max_evaluations=400_000, seed=None))]
    fn sample(
        &self,
        py: Python<'_>,
        effective: usize,
        max_evaluations: usize,
        seed: Option<u64>,
    ) -> PyResult<Posterior> {
        let (effective, max_evaluations) = (count("effective", effective)?, count("max_evaluations", max_evaluations)?);
        let settings = PosteriorSettings { effective, max_evaluations, seed: seed.unwrap_or(self.fit.outcome.seed) };
        let found = patiently(py, |progress| intervals::posterior(&self.data, &self.fit, &settings, progress))?;
        let found = found.map_err(|error| of_fit(py, &error))?;
        Ok(Posterior::of(found, &self.fit))
    }

    /// Replicates of the bootstrap of "residuals" or "cases": (names, array [replicate, quantity]), user units.
    #[pyo3(signature = (resampling="residuals", *, replicates=1000, seed=None))]
    fn bootstrap<'py>(
        &self,
        py: Python<'py>,
        resampling: &str,
        replicates: usize,
        seed: Option<u64>,
    ) -> PyResult<(Vec<&'static str>, Bound<'py, PyArray2<f64>>)> {
        let seed = seed.unwrap_or(self.fit.outcome.seed);
        bootstraps_of(py, &self.data, &self.fit, resampling, replicates, seed)
    }
}
