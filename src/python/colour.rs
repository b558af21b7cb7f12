//! Colours: of spectra, and of structures over a parameter or over angles.

use super::arrays::{Column, RealArray, together};
use super::errors::{of_optics, refused};
use super::model::ModelArgument;
use super::structure::Structure;
use super::words::{self, choose};
use crate::colorimetry::{
    ColourError, GamutMapping, Illuminant, Integration, Lab, Observer, PowerTable, RgbSpace, RgbTransform, Xyz,
};
use crate::geometry::Geometry;
use crate::inversion::{Parameter, structure, values};
use crate::spectrum::Wavelengths;
use crate::sweep::{SweepError, View, Viewing, colours};
use crate::units::radians;
use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;

/// Relative distance from a regular grid that counts as none.
const REGULAR: f64 = 1e-6;
/// What a spectrum must cover for its colour, nm: outside, a white under D65 has 0.2 % of its Y and 1.1 % of its Z.
const VISIBLE: [f64; 2] = [410.0, 680.0];
/// Reflectances beyond this are taken for per cent.
const PER_CENT: f64 = 5.0;

/// A light: "D65", "A", "E", or (wavelength [m], power [m]).
#[derive(FromPyObject)]
pub(crate) enum Light<'py> {
    Word(String),
    Measured(Column<'py>, Column<'py>),
}

impl Light<'_> {
    fn illuminant(given: Option<Self>) -> PyResult<Illuminant> {
        let known = [("D65", Illuminant::D65), ("A", Illuminant::A), ("E", Illuminant::E)];
        match given {
            None => Ok(Illuminant::D65),
            Some(Self::Word(word)) => choose("illuminant", &word, &known),
            Some(Self::Measured(wavelength, power)) => {
                let ([wavelength, power], rows) = together([("wavelength", &wavelength), ("power", &power)])?;
                let rows = (0..rows.unwrap_or(1)).map(|row| [wavelength.at(row), power.at(row)]).collect();
                PowerTable::new(rows).map(Illuminant::Measured).map_err(|error| of_colour(&error))
            }
        }
    }
}

fn of_colour(error: &ColourError) -> PyErr {
    refused(error.to_string())
}

fn observer(word: &str) -> PyResult<Observer> {
    choose("observer", word, &[("1931", Observer::Cie1931), ("1964", Observer::Cie1964)])
}

fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let message = CString::new(message).map_err(|error| refused(error.to_string()))?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &message, 1)
}

/// Colours [n] under one white.
#[pyclass(frozen, module = "morpho_fit")]
#[derive(Debug)]
pub(crate) struct Colours {
    colours: Vec<Xyz>,
    white: Xyz,
    /// Step of the wavelengths that were used, nm.
    #[pyo3(get)]
    step: f64,
}

impl Colours {
    fn rows<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(Xyz) -> Result<[T; 3], ColourError>,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let mut flat = Vec::with_capacity(3 * self.colours.len());
        for colour in &self.colours {
            flat.extend(of(*colour).map_err(|error| of_colour(&error))?);
        }
        let shaped = Array2::from_shape_vec((self.colours.len(), 3), flat);
        Ok(shaped.map_err(|error| refused(error.to_string()))?.into_pyarray(py))
    }

    fn transform(&self) -> PyResult<RgbTransform> {
        RgbTransform::adapted(RgbSpace::Srgb, self.white).map_err(|error| of_colour(&error))
    }
}

#[pymethods]
impl Colours {
    fn __len__(&self) -> usize {
        self.colours.len()
    }

    /// Tristimulus values [n, 3]; a perfect white has Y = 1.
    #[getter]
    fn xyz<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.rows(py, |colour| Ok(colour.to_array()))
    }

    /// XYZ [3] of the perfect white.
    #[getter]
    fn white<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        Array1::from_vec(self.white.to_array().to_vec()).into_pyarray(py)
    }

    /// CIELAB [n, 3] under the white.
    #[getter]
    fn lab<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.rows(py, |colour| Lab::new(colour, self.white).map(|lab| [lab.l, lab.a, lab.b]))
    }

    /// Encoded sRGB [n, 3], 0 to 1, the white adapted; what a display cannot show has its chroma reduced.
    #[getter]
    fn srgb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let transform = self.transform()?;
        self.rows(py, |colour| transform.show(colour, GamutMapping::ReduceChroma).map(|shown| shown.encoded))
    }

    /// Linear sRGB [n, 3], not mapped: below 0 or above 1 outside the gamut.
    #[getter]
    fn linear<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let transform = self.transform()?;
        self.rows(py, |colour| transform.linear(colour))
    }

    /// Whether a display of sRGB cannot show the colour itself, [n].
    #[getter]
    fn outside<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let transform = self.transform()?;
        let one = |colour: &Xyz| transform.show(*colour, GamutMapping::ReduceChroma).map(|shown| shown.outside);
        let all = self.colours.iter().map(one).collect::<Result<Vec<bool>, _>>().map_err(|error| of_colour(&error))?;
        Ok(all.into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        format!("<Colours: {}>", self.colours.len())
    }
}

/// Colours of spectra of reflectance.
///
/// wavelength [m], nm, evenly spaced, over the visible range; reflectance [m] or [n, m], fractions. Warns of a window that leaves
/// out part of what an eye sees, and of per cent. observer "1931" or "1964"; illuminant "D65", "A",
/// "E" or (wavelength, power). Returns Colours [1] or [n].
#[pyfunction]
#[pyo3(signature = (wavelength, reflectance, *, observer="1931", illuminant=None))]
pub(crate) fn colour<'py>(
    py: Python<'py>,
    wavelength: Column<'py>,
    reflectance: RealArray<'py>,
    observer: &str,
    illuminant: Option<Light<'py>>,
) -> PyResult<Colours> {
    let RealArray(reflectance) = reflectance;
    let ([wavelength], points) = together([("wavelength", &wavelength)])?;
    let points = points.filter(|points| *points >= 2).ok_or_else(|| refused("wavelength needs two values or more"))?;
    #[allow(clippy::cast_precision_loss, reason = "a spectrum has fewer points than 2^53")]
    let step = (wavelength.at(points - 1) - wavelength.at(0)) / (points - 1) as f64;
    let grid = Wavelengths::new(wavelength.at(0), wavelength.at(points - 1), step).ok();
    let grid = grid.filter(|grid| grid.len() == points);
    let even = grid.filter(|grid| (0..points).all(|at| (grid.at(at) - wavelength.at(at)).abs() <= REGULAR * step));
    let even = even.ok_or_else(|| refused("wavelength must rise in even steps, nm above 0"))?;
    let integration = Integration::new(&even, self::observer(observer)?, &Light::illuminant(illuminant)?);
    let integration = integration.map_err(|error| of_colour(&error))?;
    let shape = reflectance.as_array().shape().to_vec();
    if !(matches!(shape.as_slice(), [_] | [_, _]) && shape.last() == Some(&points)) {
        return Err(refused(format!("reflectance has the shape {shape:?}; it must be [{points}] or [n, {points}]")));
    }
    let [first, last] = [wavelength.at(0), wavelength.at(points - 1)];
    if first > VISIBLE[0] || last < VISIBLE[1] {
        warn(
            py,
            &format!(
                "the spectrum covers {first} to {last} nm: colours and their white are those of this window alone, not what an \
                 eye sees; give {} to {} nm or more",
                VISIBLE[0], VISIBLE[1]
            ),
        )?;
    }
    let view = reflectance.as_array();
    if view.iter().any(|value| *value > PER_CENT) {
        warn(py, "reflectance goes beyond 5: it is a fraction, 1 for a perfect white, not per cent")?;
    }
    let whole = view.as_standard_layout();
    let flat = whole.as_slice().unwrap_or_default();
    let colours = py.detach(|| integration.xyz_of_many(flat)).map_err(|error| of_colour(&error))?;
    Ok(Colours { colours, white: integration.white(), step })
}

/// Colours of a structure over one of its parameters, or over angles.
///
/// parameter is "d_air", "d_cuticle", "delta", "phi_alpha" or "lamella_width", values [n] its values (nm, degrees, phi_alpha in
/// radians); theta, phi and omega are degrees, arrays [n] or single numbers; phi is -theta, the mirror direction of a scale that
/// is not tilted, unless given. Returns Colours [n].
#[pyfunction]
#[pyo3(signature = (parameter, values, *, structure=None, theta=None, phi=None, omega=None, model=None,
    polarization="unpolarized", observer="1931", illuminant=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    parameter: &str,
    values: Column<'py>,
    structure: Option<Structure>,
    theta: Option<Column<'py>>,
    phi: Option<Column<'py>>,
    omega: Option<Column<'py>>,
    model: Option<ModelArgument>,
    polarization: &str,
    observer: &str,
    illuminant: Option<Light<'py>>,
) -> PyResult<Colours> {
    let names = Parameter::ALL.map(|parameter| (parameter.name(), parameter));
    let parameter = choose("parameter", parameter, &names)?;
    let (zero, along) = (Column::One(0.0), Column::One(90.0));
    let (theta, omega) = (theta.as_ref().unwrap_or(&zero), omega.as_ref().unwrap_or(&along));
    let columns = [("values", &values), ("theta", theta), ("phi", phi.as_ref().unwrap_or(theta)), ("omega", omega)];
    let ([value, theta, phi_or_theta, omega], length) = together(columns)?;
    let mirrored = if phi.is_some() { 1.0 } else { -1.0 };
    let base =
        self::values(&structure.unwrap_or_else(|| Structure::of_inside(crate::optics::Structure::blue())).inside);
    let view = |row: usize| {
        let mut own = base;
        own[parameter.index()] = parameter.inside(value.at(row));
        let geometry = Geometry {
            theta: radians(theta.at(row)),
            phi: radians(mirrored * phi_or_theta.at(row)),
            omega: radians(omega.at(row)),
        };
        View { structure: self::structure(&own), geometry }
    };
    let views: Vec<View> = (0..length.unwrap_or(1)).map(view).collect();
    let model = ModelArgument::model(model, py)?.forward()?;
    let viewing = Viewing {
        observer: self::observer(observer)?,
        illuminant: Light::illuminant(illuminant)?,
        ..Viewing::default()
    };
    let polarization = words::polarization(polarization)?;
    let found = py.detach(|| colours(model.as_ref(), &views, polarization, &viewing)).map_err(|error| match error {
        SweepError::Optics(error) => of_optics(py, &error, None),
        SweepError::Colour(error) => of_colour(&error),
    })?;
    let missing = found.colours.iter().position(Option::is_none);
    if let Some(row) = missing {
        return Err(refused(format!("element {row} has no colour: the model has no refracted ray there")));
    }
    let step = found.sampling.wavelengths.step();
    Ok(Colours { colours: found.colours.into_iter().flatten().collect(), white: found.white, step })
}
