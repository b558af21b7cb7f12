//! Forward models over arrays.

use super::arrays::{Column, Elements, array, together};
use super::errors::{of_optics, refused};
use super::model::{ModelArgument, Stack};
use super::structure::Structure;
use super::words;
use crate::geometry::Geometry;
use crate::optics::multilayer::{Period, spectra};
use crate::optics::{self, Contribution, Material, OpticsError};
use crate::units::radians;
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray2, PyArrayDyn};
use pyo3::prelude::*;
use rayon::prelude::*;

/// Readings that one thread takes at a time: enough that starting it costs little.
const SHARE: usize = 1024;

/// Angles whose spectra are turned into rows together: as many numbers as a line of the cache holds.
const TOGETHER: usize = 8;

/// A row of s and a row of p.
type Planes<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);
/// The two contributions.
type Terms<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);

/// Reflectivity of the stack alone, exact for s and p, over a grid.
///
/// wavelength [m], nm; theta [n], degrees from the normal of the layers (the tilt delta is not taken off). Returns
/// (R_s, R_p), each [m, n], dimensionless. Raises OpticsError, with the `index` of theta, for input out of range.
#[pyfunction]
#[pyo3(signature = (structure, wavelength, theta, *, stack=None))]
pub(crate) fn multilayer_reflectivity<'py>(
    py: Python<'py>,
    structure: &Structure,
    wavelength: Column<'py>,
    theta: Column<'py>,
    stack: Option<Stack>,
) -> PyResult<Planes<'py>> {
    let ([wavelength], rows) = together([("wavelength", &wavelength)])?;
    let ([theta], columns) = together([("theta", &theta)])?;
    for column in 0..columns.unwrap_or(1) {
        let (quantity, found, allowed) =
            ("theta", theta.at(column), "at most 90 in size, from the normal of the layers");
        if found.is_nan() || found.abs() > 90.0 {
            let error = OpticsError::OutOfRange { quantity, found, unit: "deg", allowed };
            return Err(of_optics(py, &error, columns.map(|_| column)));
        }
    }
    let stack = stack.map(|stack| stack.stack).unwrap_or_default();
    let (rows, columns) = (rows.unwrap_or(1), columns.unwrap_or(1));
    let period = Period::of(&structure.inside);
    let work = || -> Result<Vec<f64>, OpticsError> {
        let wavelengths: Vec<f64> = (0..rows).map(|row| wavelength.at(row)).collect();
        let runs = runs(&stack, &wavelengths)?;
        let mut found = vec![0.0; 2 * rows * columns];
        let (s, p) = found.split_at_mut(rows * columns);
        for start in (0..columns).step_by(TOGETHER) {
            let angles: Vec<f64> =
                (start..columns.min(start + TOGETHER)).map(|column| radians(theta.at(column))).collect();
            for (first, media, length) in &runs {
                let along = &wavelengths[*first..first + length];
                let spectra = spectra(media, along, period, stack.layers, &angles)?;
                for row in 0..*length {
                    let place = (first + row) * columns + start;
                    for (column, both) in spectra[row..].iter().step_by(*length).enumerate() {
                        (s[place + column], p[place + column]) = (both.s, both.p);
                    }
                }
            }
        }
        Ok(found)
    };
    let found = py.detach(work).map_err(|error| of_optics(py, &error, None))?;
    // Two views of one array: the memory of two would go back to the system after each call, and cost a third more time.
    let both = Array3::from_shape_vec((2, rows, columns), found).map_err(|error| refused(error.to_string()))?;
    let both = both.into_pyarray(py);
    Ok((both.get_item(0)?.cast_into()?, both.get_item(1)?.cast_into()?))
}

/// Neighbouring wavelengths whose media have the same indices: first, media, how many.
fn runs(stack: &optics::Stack, wavelengths: &[f64]) -> Result<Vec<(usize, optics::Media, usize)>, OpticsError> {
    let mut runs: Vec<(usize, optics::Media, usize)> = Vec::new();
    let is_constant = |material: &Material| matches!(material, Material::Constant { .. });
    if let Some(&first) = wavelengths.first()
        && [&stack.ambient, &stack.cuticle, &stack.gap, &stack.base].into_iter().all(is_constant)
    {
        return Ok(vec![(0, stack.media(first)?, wavelengths.len())]);
    }
    for (row, &wavelength) in wavelengths.iter().enumerate() {
        let media = stack.media(wavelength)?;
        match runs.last_mut() {
            Some((_, known, length)) if *known == (optics::Media { wavelength: known.wavelength, ..media }) => {
                *length += 1;
            }
            _ => runs.push((row, media, 1)),
        }
    }
    Ok(runs)
}

/// What a measurement of scale 1 would read, for each reading.
///
/// wavelength in nm, theta, phi and omega in degrees: arrays or single numbers, broadcast as numpy does; arrays [n] are read
/// without a copy. polarization is "unpolarized", "s" or "p". Returns an array of the common shape, dimensionless. Raises
/// OpticsError, with the `index` of the element in C order, for input out of range, ValueError for shapes that do not go
/// together.
#[pyfunction]
#[pyo3(signature = (structure, wavelength, theta, phi, omega, *, polarization="unpolarized", model=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn reflectivity<'py>(
    py: Python<'py>,
    structure: &Structure,
    wavelength: Column<'py>,
    theta: Column<'py>,
    phi: Column<'py>,
    omega: Column<'py>,
    polarization: &str,
    model: Option<ModelArgument>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let sum = |terms: [Contribution; 2]| terms.iter().map(|term| term.intensity).sum::<f64>();
    let columns = [&wavelength, &theta, &phi, &omega];
    let (found, shape) = evaluated(py, structure, columns, polarization, model, &sum)?;
    array(py, found, &shape)
}

/// The two contributions of reflectivity(): (lamella, multilayer), each with its share of the plane in it.
///
/// Arguments, shapes, units and errors as in reflectivity(). In the "hybrid" model, one product, all is multilayer.
#[pyfunction]
#[pyo3(signature = (structure, wavelength, theta, phi, omega, *, polarization="unpolarized", model=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn contributions<'py>(
    py: Python<'py>,
    structure: &Structure,
    wavelength: Column<'py>,
    theta: Column<'py>,
    phi: Column<'py>,
    omega: Column<'py>,
    polarization: &str,
    model: Option<ModelArgument>,
) -> PyResult<Terms<'py>> {
    let both = |terms: [Contribution; 2]| terms.map(|term| term.intensity);
    let columns = [&wavelength, &theta, &phi, &omega];
    let (found, shape) = evaluated(py, structure, columns, polarization, model, &both)?;
    let column = |term: usize| array(py, found.iter().map(|terms| terms[term]).collect(), &shape);
    Ok((column(0)?, column(1)?))
}

/// `of` the contributions at each reading, in parallel, and the shape of the readings.
fn evaluated<'py, T: Send>(
    py: Python<'py>,
    structure: &Structure,
    [wavelength, theta, phi, omega]: [&Column<'py>; 4],
    polarization: &str,
    model: Option<ModelArgument>,
    of: &(dyn Fn([Contribution; 2]) -> T + Sync),
) -> PyResult<(Vec<T>, Vec<usize>)> {
    let polarization = words::polarization(polarization)?;
    let model = ModelArgument::model(model, py)?.forward()?;
    let columns = [("wavelength", wavelength), ("theta", theta), ("phi", phi), ("omega", omega)];
    let (elements, shape) = Elements::of(columns)?;
    let one = |index: usize| -> Result<T, (usize, OpticsError)> {
        let [wavelength, theta, phi, omega] = elements.at(index);
        let geometry = Geometry { theta: radians(theta), phi: radians(phi), omega: radians(omega) };
        let found = model.contributions(&structure.inside, &geometry, polarization, wavelength);
        found.map(of).map_err(|error| (index, error))
    };
    let count = shape.iter().product();
    let all = || (0..count).into_par_iter().with_min_len(SHARE).map(one).collect::<Result<Vec<T>, _>>();
    let found = py.detach(all).map_err(|(index, error)| of_optics(py, &error, (!shape.is_empty()).then_some(index)))?;
    Ok((found, shape))
}
