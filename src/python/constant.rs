//! `fit_constant`: a constant of the model fitted beside the parameters.

use super::data::{self, Given, Said};
use super::errors::{of_fit, unfit};
use super::patience::patiently;
use super::settings::{Keywords, settings};
use super::words::choose;
use crate::export::constant_json;
use crate::inversion::Constant;
use crate::inversion::intervals::over_constant;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Fits a constant of the model beside the parameters, as the command's `constant`.
///
/// constant: "n_cuticle", "k_cuticle", "n_gap", "n_base", "filling", "ridge_spacing" (nm), "numerical_aperture", "bandwidth" (nm),
/// "period_spread" (nm), "layer_spread" (nm) or "tilt_spread" (degrees), searched from low to high. data and settings as in
/// fit(). Returns constant.json as dicts and lists: value, interval_68, interval_95, quantities with the intervals that allow for it, fit.
///
/// Raises DataError, FitError, OpticsError, OSError, ValueError. Ctrl-C ends it.
#[pyfunction]
#[pyo3(signature = (data, constant, low, high, **settings))]
pub(crate) fn fit_constant<'py>(
    py: Python<'py>,
    data: &Bound<'py, PyAny>,
    constant: &str,
    low: f64,
    high: f64,
    settings: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let constant = choose("constant", constant, &Constant::ALL.map(|constant| (constant.name(), constant)))?;
    let mut keywords = Keywords::of(settings)?;
    let said = Said::take(&mut keywords)?;
    let (model, settings) = self::settings(py, &mut keywords)?;
    keywords.finish()?;
    if model.auto.is_some() {
        return Err(unfit("a constant is fitted for one model; give \"blend\", \"hybrid\" or \"paper\""));
    }
    let Given { data, .. } = data::dataset(py, data, &said)?;
    let found = patiently(py, |progress| over_constant(&data, &settings, constant, [low, high], progress))?;
    let found = found.map_err(|error| of_fit(py, &error))?;
    let bytes = constant_json(&found).map_err(|error| unfit(error.to_string()))?;
    py.import("json")?.call_method1("loads", (String::from_utf8_lossy(&bytes).as_ref(),))
}
