//! `fit_map`: the pixels of a map, measured alike, as arrays.

use super::arrays::{Column, array};
use super::data::{self, Given, Said};
use super::errors::{defects, of_fit, refused};
use super::patience::patiently;
use super::settings::{Keywords, settings};
use crate::dataset::{Dataset, Reading};
use crate::export::{BatchFit, BatchValue, JOINT, nothing, word};
use crate::inversion::{Fitter, choose};
use crate::numerics::side_by_side::side_by_side;
use numpy::IxDyn;
use numpy::ndarray::{ArrayView1, Axis};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::convert::Infallible;

/// Fits every pixel of a map, on all threads; each to the same bits as fit() does.
///
/// design says where each of n readings was measured: what fit() takes. Its intensity is not used, and a table may leave it out.
/// intensity is an array [..., n] of any shape before the readings; what is NaN or masked was not measured. sigma is a number, an
/// array that numpy broadcasts to it, or a column of design. settings as in fit().
///
/// Returns a dict of arrays [...] with the names of batch.csv, ready for a frame or for xarray: model, verdict, chi2, dof,
/// sigma_source; d_air_nm, d_air_sigma_nm, d_air_status, d_air_low_95_nm, d_air_high_95_nm and so on for each quantity; warnings;
/// error, which says why a pixel has no fit. Where there is no value, or an interval is open, a number is NaN (dof -1) and a word
/// "". The standard deviation of an "ambiguous" value is that of one structure alone: its interval spans all that fit.
///
/// Raises DataError, FitError, OpticsError, OSError, ValueError. Ctrl-C ends it, and nothing is kept: fit a large map row by row.
#[pyfunction]
#[pyo3(signature = (design, intensity, *, sigma=None, **settings))]
pub(crate) fn fit_map<'py>(
    py: Python<'py>,
    design: &Bound<'py, PyAny>,
    intensity: &Bound<'py, PyAny>,
    sigma: Option<Column<'py>>,
    settings: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut keywords = Keywords::of(settings)?;
    let mut said = Said::take(&mut keywords)?;
    if said.intensity_column.is_some() {
        return Err(refused("intensity_column is for fit(): here the intensities are an array"));
    }
    let (model, settings) = self::settings(py, &mut keywords)?;
    keywords.finish()?;
    let intensity = unmasked(py, intensity)?;
    let Column::Array(intensity) = intensity.extract::<Column<'_>>()? else {
        return Err(refused("intensity is one number; it must be an array [..., n] with the readings last"));
    };
    let intensity = intensity.as_array();
    let Some((&readings, shape)) = intensity.shape().split_last() else {
        return Err(refused("intensity is one number; it must be an array [..., n] with the readings last"));
    };
    said.blank = Some((readings, "the last axis of intensity"));
    // One number for all is read as fit() reads it.
    let sigma = match sigma {
        Some(Column::One(one)) => {
            said.options.constants.sigma = Some(one);
            None
        }
        Some(Column::Array(array)) => Some(array.as_array().to_owned()),
        None => None,
    };
    let Given { data: design, .. } = data::dataset(py, design, &said)?;
    if sigma.is_some() && design.has_sigma() {
        return Err(refused("sigma is given twice: by design and as an argument; leave one out"));
    }
    let expected = design.readings().len();
    if readings != expected {
        return Err(refused(format!("intensity has {readings} readings in its last axis, but design has {expected}")));
    }
    let last = Axis(shape.len());
    let intensities: Vec<ArrayView1<'_, f64>> = intensity.lanes(last).into_iter().collect();
    let stretched = sigma.as_ref().map(|sigma| {
        let (own, all) = (sigma.shape(), intensity.shape());
        let view = sigma.broadcast(IxDyn(intensity.shape()));
        view.ok_or_else(|| {
            let hint = if own == shape { "; one for each pixel is sigma[..., None]" } else { "" };
            refused(format!("sigma has the shape {own:?}, which does not go with {all:?}, that of intensity{hint}"))
        })
    });
    let stretched = stretched.transpose()?;
    let sigmas: Option<Vec<ArrayView1<'_, f64>>> = stretched.as_ref().map(|all| all.lanes(last).into_iter().collect());

    let fitter = Fitter::new(settings.clone()).map_err(|error| of_fit(py, &error))?;
    let one = |pixel: usize, progress: &(dyn Fn(&str) + Sync)| {
        let data = pixel_of(&design, &intensities[pixel], sigmas.as_ref().map(|all| &all[pixel]))?;
        let found = match model.auto {
            Some(beside) => choose(&data, &settings, &[beside], progress).map(|choice| choice.fit.outcome),
            None => fitter.outcome(&data, progress),
        };
        found.map(|outcome| BatchFit::of(&outcome)).map_err(|error| error.to_string())
    };
    let found = patiently(py, |progress| {
        let mut found: Vec<Option<Result<BatchFit, String>>> = vec![None; intensities.len()];
        let take = |pixel: usize, fit| {
            found[pixel] = Some(fit);
            Ok::<(), Infallible>(())
        };
        side_by_side(intensities.len(), |pixel| one(pixel, progress), take).map(|()| found)
    })?;
    let Ok(found) = found;
    let found: Vec<Result<BatchFit, String>> = found.into_iter().flatten().collect();
    Table { py, shape, found: &found, all: PyDict::new(py) }.filled()
}

/// A masked array with NaN where it is masked; anything else as it is.
fn unmasked<'py>(py: Python<'py>, intensity: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if intensity.get_type().name()? != "MaskedArray" {
        return Ok(intensity.clone());
    }
    let numbers = py.import("numpy")?.getattr("float64")?;
    intensity.call_method1("astype", (numbers,))?.call_method1("filled", (f64::NAN,))
}

/// The readings of `design` with other intensities, but for those that are NaN, or what is wrong with these in a line.
fn pixel_of(
    design: &Dataset,
    intensities: &ArrayView1<'_, f64>,
    sigmas: Option<&ArrayView1<'_, f64>>,
) -> Result<Dataset, String> {
    let mut curves: Vec<usize> = Vec::new();
    let mut readings = Vec::with_capacity(intensities.len());
    for (row, (reading, &intensity)) in design.readings().iter().zip(intensities).enumerate() {
        if intensity.is_nan() {
            continue;
        }
        let curve = curves.iter().position(|known| *known == reading.curve).unwrap_or_else(|| {
            curves.push(reading.curve);
            curves.len() - 1
        });
        let sigma = sigmas.map(|all| all[row]).or(reading.sigma);
        readings.push(Reading { intensity, sigma, curve, line: 0, ..*reading });
    }
    if readings.is_empty() {
        return Err("nothing was measured".to_owned());
    }
    let names = curves.into_iter().map(|curve| design.curves()[curve].clone());
    Dataset::from_readings(readings, names.collect()).map_err(|findings| {
        let more = findings.total() - 1;
        let first = defects(&findings).into_iter().next().map(|defect| defect.message).unwrap_or_default();
        if more > 0 { format!("{first}, and {more} more") } else { first }
    })
}

/// Columns that are filled one after another.
struct Table<'a, 'py> {
    py: Python<'py>,
    shape: &'a [usize],
    found: &'a [Result<BatchFit, String>],
    all: Bound<'py, PyDict>,
}

impl<'py> Table<'_, 'py> {
    fn filled(self) -> PyResult<Bound<'py, PyDict>> {
        self.words("model", |fit| fit.model.clone())?;
        self.words("verdict", |fit| word(&fit.verdict).unwrap_or_default())?;
        self.numbers("chi2", |fit| Some(fit.chi2))?;
        let dof = |fit: &Result<BatchFit, String>| fit.as_ref().map_or(Ok(-1), |fit| i64::try_from(fit.dof));
        let dof: Vec<i64> = self.found.iter().map(dof).collect::<Result<_, _>>()?;
        self.put("dof", dof, "int64")?;
        self.words("sigma_source", |fit| word(&fit.sigma_source).unwrap_or_default())?;
        for (place, (name, unit, _)) in nothing().each().into_iter().enumerate() {
            let of = |fit: &BatchFit| -> BatchValue { *fit.values.each()[place].2 };
            self.numbers(&format!("{name}_{unit}"), |fit| of(fit).value)?;
            self.numbers(&format!("{name}_sigma_{unit}"), |fit| of(fit).sigma)?;
            self.words(&format!("{name}_status"), |fit| word(&of(fit).status).unwrap_or_default())?;
            for (end, place) in [("low", 0), ("high", 1)] {
                self.numbers(&format!("{name}_{end}_95_{unit}"), |fit| {
                    of(fit).interval_95.and_then(|ends| ends[place])
                })?;
            }
        }
        // Sentences: as text of one width each would take the room of the longest.
        let warnings =
            self.found.iter().map(|fit| fit.as_ref().map_or_else(|_| String::new(), |fit| fit.warnings.join(JOINT)));
        self.put("warnings", warnings.collect::<Vec<String>>(), "object")?;
        let errors = self.found.iter().map(|fit| fit.as_ref().err().cloned().unwrap_or_default());
        self.put("error", errors.collect::<Vec<String>>(), "object")?;
        Ok(self.all)
    }

    fn numbers(&self, name: &str, of: impl Fn(&BatchFit) -> Option<f64>) -> PyResult<()> {
        let values = self.found.iter().map(|fit| fit.as_ref().ok().and_then(&of).unwrap_or(f64::NAN)).collect();
        self.all.set_item(name, array(self.py, values, self.shape)?)
    }

    fn words(&self, name: &str, of: impl Fn(&BatchFit) -> String) -> PyResult<()> {
        let words = self.found.iter().map(|fit| fit.as_ref().map_or_else(|_| String::new(), &of));
        self.put(name, words.collect::<Vec<String>>(), "str")
    }

    /// By way of a list.
    fn put<T: IntoPyObject<'py>>(&self, name: &str, values: Vec<T>, dtype: &str) -> PyResult<()> {
        let made = self.py.import("numpy")?.call_method1("array", (values, dtype))?;
        self.all.set_item(name, made.call_method1("reshape", (PyTuple::new(self.py, self.shape)?,))?)
    }
}
