//! `Structure`: the five parameters in the user's units.

use super::errors::of_optics;
use crate::inversion::{Parameter, structure, values};
use crate::optics;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

/// The structure of one scale; every argument is in the unit of the command line.
///
/// d_air, d_cuticle and lamella_width are nm, delta is degrees, phi_alpha is radians. What is not given is that of the blue
/// Morpho: 141 nm, 62 nm, 2.5 deg, 0.5 rad, 300 nm.
#[pyclass(frozen, eq, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Structure {
    pub(crate) inside: optics::Structure,
    /// As they were given: the way to radians and back may change the last bit.
    outside: [f64; 5],
}

impl Structure {
    /// The structure of five values in the user's units.
    pub(crate) fn of(outside: [f64; 5]) -> Self {
        let inside = structure(&Parameter::ALL.map(|parameter| parameter.inside(outside[parameter.index()])));
        Self { inside, outside }
    }

    /// A structure of the library.
    pub(crate) fn of_inside(inside: optics::Structure) -> Self {
        let values = values(&inside);
        Self { inside, outside: Parameter::ALL.map(|parameter| parameter.outside(values[parameter.index()])) }
    }
}

#[pymethods]
#[allow(
    clippy::wrong_self_convention,
    clippy::trivially_copy_pass_by_ref,
    reason = "methods of Python borrow their object"
)]
impl Structure {
    #[new]
    #[pyo3(signature = (*, d_air=141.0, d_cuticle=62.0, delta=2.5, phi_alpha=0.5, lamella_width=300.0))]
    fn new(
        py: Python<'_>,
        d_air: f64,
        d_cuticle: f64,
        delta: f64,
        phi_alpha: f64,
        lamella_width: f64,
    ) -> PyResult<Self> {
        let made = Self::of([d_air, d_cuticle, delta, phi_alpha, lamella_width]);
        made.inside.validate().map_err(|error| of_optics(py, &error, None))?;
        Ok(made)
    }

    /// A blue Morpho: air 141 nm, cuticle 62 nm, the rest as in Table 1 of the paper.
    #[staticmethod]
    fn blue() -> Self {
        Self::of([141.0, 62.0, 2.5, 0.5, 300.0])
    }

    /// Table 1 of the paper: air 135 nm, cuticle 100 nm, tilt 2.5 deg, lobe 0.5 rad, lamella 300 nm.
    #[staticmethod]
    fn table1() -> Self {
        Self::of([135.0, 100.0, 2.5, 0.5, 300.0])
    }

    /// Thickness of one air gap, nm.
    #[getter]
    fn d_air(&self) -> f64 {
        self.outside[0]
    }

    /// Thickness of one cuticle layer, nm.
    #[getter]
    fn d_cuticle(&self) -> f64 {
        self.outside[1]
    }

    /// Mean tilt of the layers, degrees.
    #[getter]
    fn delta(&self) -> f64 {
        self.outside[2]
    }

    /// Half-width of the lobe, radians.
    #[getter]
    fn phi_alpha(&self) -> f64 {
        self.outside[3]
    }

    /// Width of a lamella, nm.
    #[getter]
    fn lamella_width(&self) -> f64 {
        self.outside[4]
    }

    /// d_air + d_cuticle, nm.
    #[getter]
    fn period(&self) -> f64 {
        self.inside.period()
    }

    /// The five values by name, in the user's units.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for parameter in Parameter::ALL {
            all.set_item(parameter.name(), self.outside[parameter.index()])?;
        }
        Ok(all)
    }

    /// The same structure with other values: replace(d_air=120.0).
    #[pyo3(signature = (*, d_air=None, d_cuticle=None, delta=None, phi_alpha=None, lamella_width=None))]
    fn replace(
        &self,
        py: Python<'_>,
        d_air: Option<f64>,
        d_cuticle: Option<f64>,
        delta: Option<f64>,
        phi_alpha: Option<f64>,
        lamella_width: Option<f64>,
    ) -> PyResult<Self> {
        let given = [d_air, d_cuticle, delta, phi_alpha, lamella_width];
        let made = Self::of(std::array::from_fn(|place| given[place].unwrap_or(self.outside[place])));
        made.inside.validate().map_err(|error| of_optics(py, &error, None))?;
        Ok(made)
    }

    /// For pickle and copy.
    fn __getnewargs_ex__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyTuple>, Bound<'py, PyDict>)> {
        Ok((PyTuple::empty(py), self.to_dict(py)?))
    }

    fn __repr__(&self) -> String {
        let values = Parameter::ALL.map(|parameter| format!("{parameter}={:?}", self.outside[parameter.index()]));
        format!("Structure({})", values.join(", "))
    }
}
