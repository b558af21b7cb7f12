//! Arrays of numpy as the library reads them: where they lie, of one length or one number for all.

use super::errors::refused;
use numpy::ndarray::{ArrayView1, Ix1};
use numpy::{AllowTypeChange, IntoPyArray, IxDyn, PyArrayDyn, PyArrayLikeDyn};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

/// A column of numbers: an array [n] of float64, read without a copy, whatever numpy makes one of, or one number for all.
pub(crate) enum Column<'py> {
    /// One number for all elements.
    One(f64),
    /// An array.
    Array(PyArrayLikeDyn<'py, f64, AllowTypeChange>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Column<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        require_real(&given)?;
        // A Python number, or one of numpy: cheaper than by way of an array. Arrays of one element stay arrays.
        if !given.hasattr("__len__")?
            && let Ok(one) = given.extract::<f64>()
        {
            return Ok(Self::One(one));
        }
        Ok(Self::Array(given.extract()?))
    }
}

/// Real numbers of any dimensions.
pub(crate) struct RealArray<'py>(pub(crate) PyArrayLikeDyn<'py, f64, AllowTypeChange>);

impl<'a, 'py> FromPyObject<'a, 'py> for RealArray<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        require_real(&given)?;
        Ok(Self(given.extract()?))
    }
}

/// One number that is no complex one.
pub(crate) struct Real(pub(crate) f64);

impl<'a, 'py> FromPyObject<'a, 'py> for Real {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        require_real(&given)?;
        Ok(Self(given.extract()?))
    }
}

/// Refuses what numpy would make numbers of by leaving out a part: complex numbers, dates, spans of time and masks.
///
/// # Errors
/// `ValueError` that names the kind.
pub(crate) fn require_real(given: &Bound<'_, PyAny>) -> PyResult<()> {
    if given.get_type().name()? == "MaskedArray" {
        return Err(refused("a masked array is given: leave masked elements out, with .compressed()".to_owned()));
    }
    let Ok(kind) = given.getattr("dtype").and_then(|dtype| dtype.getattr("kind")) else { return Ok(()) };
    match kind.extract::<String>().as_deref() {
        Ok("c") => Err(refused("complex numbers are given where real ones are needed".to_owned())),
        Ok("m" | "M") => Err(refused("dates or times are given where numbers are needed".to_owned())),
        _ => Ok(()),
    }
}

impl Column<'_> {
    /// Sizes of its dimensions; none of one number.
    pub(crate) fn shape(&self) -> Vec<usize> {
        match self {
            Self::One(_) => Vec::new(),
            Self::Array(array) => array.as_array().shape().to_vec(),
        }
    }

    /// 0 for all.
    pub(crate) fn zero() -> Self {
        Self::One(0.0)
    }

    fn values(&self, what: &str) -> PyResult<Values<'_>> {
        match self {
            Self::One(one) => Ok(Values::One(*one)),
            Self::Array(array) => {
                let shape = array.as_array().shape().to_vec();
                let flat = array.as_array().into_dimensionality::<Ix1>();
                let flat =
                    flat.map_err(|_| refused(format!("{what} has the shape {shape:?}; it must be an array [n]")));
                // Contiguous arrays are slices; the rest is read with its stride.
                flat.map(|view| view.to_slice().map_or(Values::Strided(view), Values::Slice))
            }
        }
    }
}

/// The numbers of a column, which other threads can read.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Values<'a> {
    One(f64),
    Slice(&'a [f64]),
    Strided(ArrayView1<'a, f64>),
}

impl Values<'_> {
    /// Element `index`, which is below the common length.
    #[inline]
    pub(crate) fn at(&self, index: usize) -> f64 {
        match self {
            Self::One(one) => *one,
            Self::Slice(all) => all[index],
            Self::Strided(all) => all[index],
        }
    }

    fn len(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Slice(all) => Some(all.len()),
            Self::Strided(all) => Some(all.len()),
        }
    }
}

/// Elements that arguments are stretched to at most.
const MOST: usize = 1 << 30;

/// The elements of columns of any shapes, stretched to the shape that numpy's rules of broadcasting give them.
pub(crate) enum Elements<'a, const N: usize> {
    /// Arrays of one length and single numbers, read where they lie.
    InPlace([Values<'a>; N]),
    /// Copies, each in the order of the common shape.
    Stretched([Vec<f64>; N]),
}

impl<'a, const N: usize> Elements<'a, N> {
    /// With their shape.
    pub(crate) fn of(columns: [(&str, &'a Column<'_>); N]) -> PyResult<(Self, Vec<usize>)> {
        let shape = common_shape(&columns)?;
        let in_place = |column: &Column<'_>| match column {
            Column::One(_) => true,
            Column::Array(_) => shape.len() == 1 && column.shape() == shape,
        };
        if columns.iter().all(|(_, column)| in_place(column)) {
            return Ok((Self::InPlace(together(columns)?.0), shape));
        }
        let count = shape.iter().try_fold(1_usize, |count, size| count.checked_mul(*size));
        let count = count.filter(|count| *count <= MOST).ok_or_else(|| {
            PyMemoryError::new_err(format!("the arguments go together to an array of the shape {shape:?}: too large"))
        })?;
        let mut stretched: [Vec<f64>; N] = std::array::from_fn(|_| Vec::new());
        for (values, (_, column)) in stretched.iter_mut().zip(columns) {
            let room = |_| PyMemoryError::new_err(format!("no room for {count} numbers"));
            values.try_reserve_exact(count).map_err(room)?;
            match column {
                Column::One(one) => values.resize(count, *one),
                Column::Array(array) => {
                    if let Some(all) = array.as_array().broadcast(IxDyn(&shape)) {
                        values.extend(all.iter());
                    }
                }
            }
        }
        Ok((Self::Stretched(stretched), shape))
    }

    /// One of each column; `index` is below the product of the shape.
    #[inline]
    pub(crate) fn at(&self, index: usize) -> [f64; N] {
        match self {
            Self::InPlace(values) => values.map(|values| values.at(index)),
            Self::Stretched(values) => std::array::from_fn(|column| values[column][index]),
        }
    }
}

fn common_shape(columns: &[(&str, &Column<'_>)]) -> PyResult<Vec<usize>> {
    let mut shape: Vec<usize> = Vec::new();
    for (name, column) in columns {
        let own = column.shape();
        let missing = own.len().saturating_sub(shape.len());
        shape.splice(0..0, std::iter::repeat_n(1, missing));
        let (offset, before) = (shape.len() - own.len(), shape.clone());
        for (size, own_size) in shape[offset..].iter_mut().zip(&own) {
            if *size == 1 {
                *size = *own_size;
            } else if *own_size != 1 && own_size != size {
                return Err(refused(format!(
                    "{name} has the shape {own:?}, which does not go with {before:?}, that of the arguments before it"
                )));
            }
        }
    }
    Ok(shape)
}

/// Columns with their common length; `None` if all of them are single numbers.
pub(crate) fn together<'a, const N: usize>(
    columns: [(&str, &'a Column<'_>); N],
) -> PyResult<([Values<'a>; N], Option<usize>)> {
    let mut values = [Values::One(0.0); N];
    let mut length: Option<(&str, usize)> = None;
    for (slot, (name, column)) in values.iter_mut().zip(columns) {
        *slot = column.values(name)?;
        if let Some(found) = slot.len() {
            match length {
                None => length = Some((name, found)),
                Some((first, expected)) if expected != found => {
                    return Err(refused(format!("{name} has {found} elements, but {first} has {expected}")));
                }
                Some(_) => {}
            }
        }
    }
    Ok((values, length.map(|(_, length)| length)))
}

/// Results as an array of `shape`.
pub(crate) fn array<'py>(py: Python<'py>, values: Vec<f64>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let shaped = numpy::ndarray::ArrayD::from_shape_vec(IxDyn(shape), values);
    Ok(shaped.map_err(|error| refused(error.to_string()))?.into_pyarray(py))
}
