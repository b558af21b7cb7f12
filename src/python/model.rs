//! `Model`, with its `Stack`, indices and `Averages`: what the command line's flags of the model say.

use super::arrays::{Column, Real};
use super::errors::{of_optics, refused};
use super::words;
use crate::inversion::ModelChoice;
use crate::optics::{self, HybridModel, LamellaUnit, Material, OpticsError, ReflectivityModel};
use crate::units::{degrees, radians};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyComplexMethods};
use std::sync::Arc;

/// An index by Cauchy's formula, n = a + b / wavelength², without absorption; b in nm².
#[pyclass(frozen, eq, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cauchy {
    #[pyo3(get)]
    a: f64,
    #[pyo3(get)]
    b: f64,
}

#[pymethods]
impl Cauchy {
    #[new]
    fn new(a: f64, b: f64) -> Self {
        Self { a, b }
    }

    /// For pickle and copy.
    fn __getnewargs__(&self) -> (f64, f64) {
        (self.a, self.b)
    }

    fn __repr__(&self) -> String {
        format!("Cauchy({:?}, {:?})", self.a, self.b)
    }
}

/// A measured index: arrays [row] of wavelength in nm, rising, n, and k or none; linear in between.
#[pyclass(frozen, eq, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct IndexTable {
    table: optics::IndexTable,
}

#[pymethods]
impl IndexTable {
    #[new]
    #[pyo3(signature = (wavelength, n, k=None))]
    fn new(py: Python<'_>, wavelength: Column<'_>, n: Column<'_>, k: Option<Column<'_>>) -> PyResult<Self> {
        let none = Column::zero();
        let columns = [("wavelength", &wavelength), ("n", &n), ("k", k.as_ref().unwrap_or(&none))];
        let ([wavelength, n, k], rows) = super::arrays::together(columns)?;
        let rows = (0..rows.unwrap_or(1)).map(|row| [wavelength.at(row), n.at(row), k.at(row)]).collect();
        let table = optics::IndexTable::new(rows).map_err(|error| of_optics(py, &error, None))?;
        Ok(Self { table })
    }

    fn __len__(&self) -> usize {
        self.table.rows().len()
    }

    fn __repr__(&self) -> String {
        let rows = self.table.rows();
        let end = |row: Option<&[f64; 3]>| row.map_or(f64::NAN, |row| row[0]);
        format!("<IndexTable: {} rows, {:?} to {:?} nm>", rows.len(), end(rows.first()), end(rows.last()))
    }
}

/// An index as it may be given: a number, a complex number n + ik, a formula or a table.
pub(crate) enum Index<'py> {
    Cauchy(Cauchy),
    Table(IndexTable),
    Complex(Bound<'py, PyComplex>),
    Real(Real),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Index<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(cauchy) = given.extract() {
            return Ok(Self::Cauchy(cauchy));
        }
        if let Ok(table) = given.extract() {
            return Ok(Self::Table(table));
        }
        // Before the real one: a complex number of numpy is a number too, without its absorption.
        if let Ok(complex) = given.cast::<PyComplex>() {
            return Ok(Self::Complex(complex.to_owned()));
        }
        given.extract().map(Self::Real).map_err(|_| {
            let kind = given.get_type().name().map(|name| name.to_string()).unwrap_or_default();
            let needed = "a number, a complex number n + kj, a Cauchy or an IndexTable";
            PyTypeError::new_err(format!("an index is {needed}, not of the type {kind}"))
        })
    }
}

/// A material as Python writes it.
fn written(material: &Material) -> String {
    match material {
        Material::Constant { n, k } if *k > 0.0 => format!("{n:?}+{k:?}j"),
        Material::Constant { n, .. } => format!("{n:?}"),
        Material::Cauchy { a, b } => Cauchy { a: *a, b: *b }.__repr__(),
        Material::Table(table) => IndexTable { table: table.clone() }.__repr__(),
    }
}

impl Index<'_> {
    fn material(self, what: &str) -> PyResult<Material> {
        Ok(match self {
            Self::Cauchy(Cauchy { a, b }) => Material::Cauchy { a, b },
            Self::Table(IndexTable { table }) => Material::Table(table),
            Self::Real(Real(n)) => constant(n, 0.0, what)?,
            Self::Complex(index) => constant(index.real(), index.imag(), what)?,
        })
    }
}

fn constant(n: f64, k: f64, what: &str) -> PyResult<Material> {
    if n.is_finite() && n > 0.0 && k.is_finite() && k >= 0.0 {
        return Ok(Material::Constant { n, k });
    }
    Err(refused(format!("{what} is {n} + {k}i, no index: n must be above 0 and k, which absorbs, at least 0")))
}

/// Media and layer count of ambient | (cuticle, gap) x layers | base, counted from the light.
///
/// An index is a number, a complex number n + kj, a Cauchy or an IndexTable. filling is the share of a layer that is cuticle.
#[pyclass(frozen, eq, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stack {
    pub(crate) stack: optics::Stack,
}

#[pymethods]
impl Stack {
    #[new]
    #[pyo3(signature = (*, layers=9, n_cuticle=None, n_gap=None, n_base=None, n_ambient=None, filling=None))]
    fn new(
        layers: usize,
        n_cuticle: Option<Index<'_>>,
        n_gap: Option<Index<'_>>,
        n_base: Option<Index<'_>>,
        n_ambient: Option<Index<'_>>,
        filling: Option<f64>,
    ) -> PyResult<Self> {
        let usual = optics::Stack::default();
        let of = |index: Option<Index<'_>>, what, usual| index.map_or(Ok(usual), |index| index.material(what));
        if let Some(found) = filling.filter(|share| !(*share > 0.0 && *share <= 1.0)) {
            return Err(refused(format!(
                "filling is {found}: the share of a layer that is cuticle is above 0, at most 1"
            )));
        }
        if !(1..=optics::MAX_LAYERS).contains(&layers) {
            return Err(refused(format!(
                "layers is {layers}: the number of layers is from 1 to {}",
                optics::MAX_LAYERS
            )));
        }
        let stack = optics::Stack {
            ambient: of(n_ambient, "n_ambient", usual.ambient)?,
            cuticle: of(n_cuticle, "n_cuticle", usual.cuticle)?,
            gap: of(n_gap, "n_gap", usual.gap)?,
            base: of(n_base, "n_base", usual.base)?,
            layers,
            filling,
        };
        Ok(Self { stack })
    }

    /// Number of cuticle layers.
    #[getter]
    fn layers(&self) -> usize {
        self.stack.layers
    }

    /// Share of a layer that is cuticle; None for whole layers.
    #[getter]
    fn filling(&self) -> Option<f64> {
        self.stack.filling
    }

    fn __repr__(&self) -> String {
        let optics::Stack { ambient, cuticle, gap, base, layers, filling } = &self.stack;
        let media = [("n_cuticle", cuticle), ("n_gap", gap), ("n_base", base), ("n_ambient", ambient)];
        let media = media.map(|(name, material)| format!("{name}={}", written(material))).join(", ");
        let filling = filling.map_or_else(|| "None".to_owned(), |share| format!("{share:?}"));
        format!("Stack(layers={layers}, {media}, filling={filling})")
    }
}

/// What a reading of the multilayer is averaged over; 0 is no average.
///
/// numerical_aperture 0 to 0.99; bandwidth, full width at half maximum, nm; period_spread and
/// layer_spread, standard deviations of the period over the spot and of each layer by itself, nm; tilt_spread, standard
/// deviation, degrees.
#[pyclass(frozen, eq, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Averages {
    pub(crate) averages: optics::Averages,
}

#[pymethods]
impl Averages {
    #[new]
    #[pyo3(signature = (*, numerical_aperture=0.0, bandwidth=0.0, period_spread=0.0, layer_spread=0.0, tilt_spread=0.0))]
    fn new(
        py: Python<'_>,
        numerical_aperture: f64,
        bandwidth: f64,
        period_spread: f64,
        layer_spread: f64,
        tilt_spread: f64,
    ) -> PyResult<Self> {
        let tilt_spread = radians(tilt_spread);
        let averages = optics::Averages { numerical_aperture, bandwidth, period_spread, layer_spread, tilt_spread };
        averages.validate().map_err(|error| of_optics(py, &error, None))?;
        Ok(Self { averages })
    }

    /// Numerical aperture of illumination and detector.
    #[getter]
    fn numerical_aperture(&self) -> f64 {
        self.averages.numerical_aperture
    }

    /// Full width at half maximum of the band, nm.
    #[getter]
    fn bandwidth(&self) -> f64 {
        self.averages.bandwidth
    }

    /// Standard deviation of the period, nm.
    #[getter]
    fn period_spread(&self) -> f64 {
        self.averages.period_spread
    }

    /// Standard deviation of each layer's thickness by itself, nm.
    #[getter]
    fn layer_spread(&self) -> f64 {
        self.averages.layer_spread
    }

    /// Standard deviation of the tilt, degrees.
    #[getter]
    fn tilt_spread(&self) -> f64 {
        // Without the rounding of the way to radians and back.
        (degrees(self.averages.tilt_spread) * 1e12).round() / 1e12
    }

    fn __repr__(&self) -> String {
        let (aperture, band) = (self.numerical_aperture(), self.bandwidth());
        let (period, layer, tilt) = (self.period_spread(), self.layer_spread(), self.tilt_spread());
        format!(
            "Averages(numerical_aperture={aperture:?}, bandwidth={band:?}, period_spread={period:?}, layer_spread={layer:?}, tilt_spread={tilt:?})"
        )
    }
}

/// What Model A of the paper's formulas is divided by.
#[derive(FromPyObject)]
pub(crate) enum Unit {
    Word(String),
    Width(f64),
}

/// A forward model: "blend", "hybrid", "paper", or, for fit() alone, "auto".
///
/// snell ("right", "printed"), admittance ("mean", "per-polarization") and lamella_unit ("peak", "printed", or a width in nm)
/// are of "paper"; ridge_spacing (nm, 750 unless given) is of "hybrid".
#[pyclass(frozen, module = "morpho_fit", from_py_object)]
#[derive(Debug, Clone)]
pub(crate) struct Model {
    pub(crate) choice: ModelChoice,
    pub(crate) stack: optics::Stack,
    pub(crate) averages: optics::Averages,
    /// "auto": the fit chooses among the variants of "blend" and of this.
    pub(crate) auto: Option<ModelChoice>,
    built: Arc<dyn ReflectivityModel>,
}

impl Model {
    /// The model of a choice.
    pub(crate) fn build(
        choice: ModelChoice,
        stack: optics::Stack,
        averages: optics::Averages,
        auto: Option<ModelChoice>,
    ) -> Result<Self, OpticsError> {
        let model = choice.build(stack.clone());
        let built: Arc<dyn ReflectivityModel> =
            if averages.is_none() { model.into() } else { Arc::new(optics::AveragedModel::new(model, averages)?) };
        built.validate()?;
        Ok(Self { choice, stack, averages, auto, built })
    }

    /// The forward model; none for "auto".
    pub(crate) fn forward(&self) -> PyResult<Arc<dyn ReflectivityModel>> {
        if self.auto.is_some() {
            return Err(refused(
                "\"auto\" compares fits and is for fit() alone; give \"blend\", \"hybrid\" or \"paper\"",
            ));
        }
        Ok(Arc::clone(&self.built))
    }
}

#[pymethods]
impl Model {
    #[new]
    #[pyo3(signature = (name="blend", *, stack=None, averages=None, snell=None, admittance=None, lamella_unit=None,
        ridge_spacing=None))]
    #[allow(clippy::too_many_arguments, reason = "keywords of Python")]
    fn new(
        py: Python<'_>,
        name: &str,
        stack: Option<Stack>,
        averages: Option<Averages>,
        snell: Option<&str>,
        admittance: Option<&str>,
        lamella_unit: Option<Unit>,
        ridge_spacing: Option<f64>,
    ) -> PyResult<Self> {
        let of_paper = [
            ("snell", snell.is_some()),
            ("admittance", admittance.is_some()),
            ("lamella_unit", lamella_unit.is_some()),
        ];
        if name != "paper"
            && let Some((argument, _)) = of_paper.into_iter().find(|(_, given)| *given)
        {
            return Err(refused(format!(
                "{argument} is a choice of the paper's formulas; it needs the model \"paper\""
            )));
        }
        if !matches!(name, "hybrid" | "auto") && ridge_spacing.is_some() {
            return Err(refused("ridge_spacing is of the model \"hybrid\""));
        }
        let hybrid = ModelChoice::Hybrid { ridge_spacing: ridge_spacing.unwrap_or(HybridModel::RIDGE_SPACING) };
        let choice = match name {
            "blend" | "auto" => ModelChoice::Blend,
            "hybrid" => hybrid,
            "paper" => ModelChoice::Paper {
                snell: snell.map(words::snell).transpose()?.unwrap_or_default(),
                admittance: admittance.map(words::admittance).transpose()?.unwrap_or_default(),
                lamella_unit: match lamella_unit {
                    None => LamellaUnit::default(),
                    Some(Unit::Width(width)) => LamellaUnit::Reference { width },
                    Some(Unit::Word(word)) => {
                        let printed = LamellaUnit::Printed { ridges: 1.0 };
                        words::choose("lamella_unit", &word, &[("peak", LamellaUnit::Peak), ("printed", printed)])?
                    }
                },
            },
            other => {
                let problem = "it must be \"blend\", \"hybrid\", \"paper\" or, for a fit, \"auto\"";
                return Err(refused(format!("the model is \"{other}\"; {problem}")));
            }
        };
        let stack = stack.map(|stack| stack.stack).unwrap_or_default();
        let averages = averages.map(|averages| averages.averages).unwrap_or_default();
        Self::build(choice, stack, averages, (name == "auto").then_some(hybrid))
            .map_err(|error| of_optics(py, &error, None))
    }

    /// "blend", "hybrid", "paper" or "auto".
    #[getter]
    fn name(&self) -> &'static str {
        if self.auto.is_some() { "auto" } else { self.built.name() }
    }

    /// Media and layer count.
    #[getter(stack)]
    fn stack_of(&self) -> Stack {
        Stack { stack: self.stack.clone() }
    }

    /// What a reading is averaged over.
    #[getter(averages)]
    fn averages_of(&self) -> Averages {
        Averages { averages: self.averages }
    }

    /// Distance of the ridges of "hybrid", nm; None for the other models.
    #[getter]
    fn ridge_spacing(&self) -> Option<f64> {
        match self.auto.unwrap_or(self.choice) {
            ModelChoice::Hybrid { ridge_spacing } => Some(ridge_spacing),
            _ => None,
        }
    }

    fn __repr__(&self) -> String {
        let mut parts = vec![format!("\"{}\"", self.name()), format!("stack={}", self.stack_of().__repr__())];
        if !self.averages.is_none() {
            parts.push(format!("averages={}", self.averages_of().__repr__()));
        }
        match self.choice {
            ModelChoice::Paper { snell, admittance, lamella_unit } => {
                parts.push(format!("snell=\"{}\"", words::of_snell(snell)));
                parts.push(format!("admittance=\"{}\"", words::of_admittance(admittance)));
                parts.push(match lamella_unit {
                    LamellaUnit::Peak => "lamella_unit=\"peak\"".to_owned(),
                    LamellaUnit::Printed { .. } => "lamella_unit=\"printed\"".to_owned(),
                    LamellaUnit::Reference { width } => format!("lamella_unit={width:?}"),
                });
            }
            _ => parts.extend(self.ridge_spacing().map(|spacing| format!("ridge_spacing={spacing:?}"))),
        }
        format!("Model({})", parts.join(", "))
    }
}

/// A model by its name or with its choices.
#[derive(FromPyObject)]
pub(crate) enum ModelArgument {
    Model(Model),
    Name(String),
}

impl ModelArgument {
    /// The model; "blend" if none was given.
    pub(crate) fn model(given: Option<Self>, py: Python<'_>) -> PyResult<Model> {
        match given {
            Some(Self::Model(model)) => Ok(model),
            Some(Self::Name(name)) => Model::new(py, &name, None, None, None, None, None, None),
            None => Model::new(py, "blend", None, None, None, None, None, None),
        }
    }
}
