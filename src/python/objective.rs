//! `Objective`: what a fit minimises, for optimisers and samplers of others.

use super::arrays::{Column, array, together};
use super::data::{self, Said};
use super::errors::{of_fit, refused, unfit};
use super::settings::{Keywords, settings};
use crate::inversion::{self, Parameter};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Half the gradient and half the matrix.
type NormalEquations<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArray2<f64>>);

/// Weighted residuals and their derivatives over the free parameters, scale, weight and background eliminated.
///
/// Takes the data and settings of fit(). A point [k] is in the order of `names` and in the units of fit(). A robust loss has
/// no say: residuals are those of least squares. Calls release the interpreter's lock.
#[pyclass(frozen, module = "morpho_fit")]
#[derive(Debug)]
pub(crate) struct Objective {
    inside: inversion::Objective,
}

impl Objective {
    fn point(&self, point: &Column<'_>) -> PyResult<Vec<f64>> {
        let ([values], length) = together([("point", point)])?;
        let Some(length) = length else { return Err(unfit("point is one number; it must be an array [k]")) };
        let free = self.inside.free();
        if length != free.len() {
            return Err(unfit(format!("point has {length} elements, but {} parameters are free", free.len())));
        }
        Ok(free.iter().enumerate().map(|(place, parameter)| parameter.inside(values.at(place))).collect())
    }

    fn at<T: Send>(
        &self,
        py: Python<'_>,
        point: &Column<'_>,
        ask: impl Fn(&inversion::Objective, &[f64]) -> Result<T, inversion::FitError> + Sync,
    ) -> PyResult<T> {
        let point = self.point(point)?;
        py.detach(|| ask(&self.inside, &point)).map_err(|error| of_fit(py, &error))
    }
}

#[pymethods]
impl Objective {
    #[new]
    #[pyo3(
        signature = (data, **settings),
        text_signature = "(data, *, model='blend', fix=None, bounds=None, start=None, link=None, require=None, \
            scale='shared', background='none', weight='fit', loss='linear', local=False, derivative='exact', level=9.0, seed=1, \
            wavelength=None, theta=None, phi=None, omega=None, sigma=None, polarization=None, wide=None, intensity_column=None)"
    )]
    fn new(py: Python<'_>, data: &Bound<'_, PyAny>, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut keywords = Keywords::of(settings)?;
        let said = Said::take(&mut keywords)?;
        let (model, settings) = self::settings(py, &mut keywords)?;
        keywords.finish()?;
        model.forward()?;
        let given = data::dataset(py, data, &said)?;
        let made = py.detach(|| inversion::Objective::new(&given.data, &settings));
        Ok(Self { inside: made.map_err(|error| of_fit(py, &error))? })
    }

    /// Names of the free parameters: the order of every point.
    #[getter]
    fn names(&self) -> Vec<&'static str> {
        self.inside.free().iter().map(|parameter| parameter.name()).collect()
    }

    /// Units of the free parameters.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.inside.free().iter().map(|parameter| parameter.unit()).collect()
    }

    /// Bounds [k, 2] of the free parameters, user units.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (lower, upper) = self.inside.bounds();
        let ends =
            |(place, parameter): (usize, &Parameter)| [lower[place], upper[place]].map(|end| parameter.outside(end));
        let flat: Vec<f64> = self.inside.free().iter().enumerate().flat_map(ends).collect();
        grid(py, flat, self.inside.free().len(), 2)
    }

    fn __len__(&self) -> usize {
        self.inside.len()
    }

    /// Weighted residuals [m], (model - data) / sigma, at `point` [k].
    fn residuals<'py>(&self, py: Python<'py>, point: Column<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let found = self.at(py, &point, |objective, point| Ok(objective.residuals(point)?.data.into()))?;
        let found: Vec<f64> = found;
        let shape = [found.len()];
        array(py, found, &shape)
    }

    /// Sum of squared residuals at `point` [k].
    fn chi2(&self, py: Python<'_>, point: Column<'_>) -> PyResult<f64> {
        self.at(py, &point, |objective, point| Ok(objective.residuals(point)?.norm_squared()))
    }

    /// Derivatives [m, k] of the residuals by the parameters, per unit of fit(), in Kaufman's form: at fixed nuisances, less
    /// their projection on the columns of these. With the residuals it gives the gradient of chi2, 2 J.T @ r.
    fn jacobian<'py>(&self, py: Python<'py>, point: Column<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let free = self.inside.free();
        let flat = self.at(py, &point, |objective, point| {
            let found = objective.jacobian(point)?;
            let row = |row: usize| free.iter().enumerate().map(move |(column, parameter)| (row, column, *parameter));
            let cell =
                |(row, column, parameter): (usize, usize, Parameter)| found[(row, column)] * parameter.inside(1.0);
            Ok((0..found.nrows()).flat_map(row).map(cell).collect::<Vec<f64>>())
        })?;
        grid(py, flat, self.inside.len(), free.len())
    }

    /// Half the gradient [k] of chi2 and half its matrix [k, k] of second derivatives by Gauss and Newton: (J.T r, J.T J).
    fn normal_equations<'py>(&self, py: Python<'py>, point: Column<'py>) -> PyResult<NormalEquations<'py>> {
        let free = self.inside.free();
        let (gradient, matrix) = self.at(py, &point, |objective, point| {
            let (residuals, mut jacobian) = (objective.residuals(point)?, objective.jacobian(point)?);
            for (mut column, parameter) in jacobian.column_iter_mut().zip(free) {
                column *= parameter.inside(1.0);
            }
            Ok((jacobian.tr_mul(&residuals), jacobian.tr_mul(&jacobian)))
        })?;
        let count = free.len();
        let gradient = array(py, gradient.iter().copied().collect(), &[count])?;
        Ok((gradient, grid(py, matrix.iter().copied().collect(), count, count)?))
    }

    fn __repr__(&self) -> String {
        format!("<Objective: {} residuals of {}>", self.inside.len(), self.names().join(", "))
    }
}

fn grid(py: Python<'_>, flat: Vec<f64>, rows: usize, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let shaped = Array2::from_shape_vec((rows, columns), flat).map_err(|error| refused(error.to_string()))?;
    Ok(shaped.into_pyarray(py))
}
