//! The settings of a fit as keywords, which are the flags of the command.

use super::errors::{of_settings, unfit};
use super::model::{Model, ModelArgument};
use super::words::choose;
use crate::inversion::{
    COUNT, Derivative, Extent, FitSettings, ModelChoice, Nuisances, Parameter, Role, Search, Weight,
};
use crate::optimise::Loss;
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// Keywords that were given and not yet taken.
#[derive(Debug)]
pub(crate) struct Keywords<'py> {
    given: Option<Bound<'py, PyDict>>,
}

impl<'py> Keywords<'py> {
    /// Those of a call.
    pub(crate) fn of(given: Option<&Bound<'py, PyDict>>) -> PyResult<Self> {
        Ok(Self { given: given.map(|given| given.copy()).transpose()? })
    }

    /// Takes one; none if it is not given, or None.
    pub(crate) fn take<T>(&mut self, name: &str) -> PyResult<Option<T>>
    where
        T: FromPyObjectOwned<'py>,
    {
        let Some(given) = &self.given else { return Ok(None) };
        let Some(value) = given.get_item(name)? else { return Ok(None) };
        given.del_item(name)?;
        if value.is_none() {
            return Ok(None);
        }
        value.extract::<T>().map(Some).map_err(|error| {
            let error: PyErr = error.into();
            // What has a type of its own says what is wrong.
            let py = value.py();
            if error.is_instance_of::<PyTypeError>(py) {
                PyTypeError::new_err(format!("argument `{name}`: {}", error.value(py)))
            } else if error.is_instance_of::<PyOverflowError>(py) {
                unfit(format!("argument `{name}`: {value} is out of range"))
            } else {
                error
            }
        })
    }

    fn word<T: Clone>(&mut self, name: &str, choices: &[(&str, T)], usual: T) -> PyResult<T> {
        self.take::<String>(name)?.map_or(Ok(usual), |word| choose(name, &word, choices))
    }

    /// Refuses what nobody took.
    pub(crate) fn finish(self) -> PyResult<()> {
        let Some(name) = self.given.and_then(|given| given.keys().iter().next()) else { return Ok(()) };
        let name = name.str()?.to_string();
        let place = match name.as_str() {
            "layers" | "n_cuticle" | "n_gap" | "n_base" | "n_ambient" | "filling" => {
                "; give model=Model(stack=Stack(...))"
            }
            "numerical_aperture" | "bandwidth" | "period_spread" | "layer_spread" | "tilt_spread" => {
                "; give model=Model(averages=Averages(...))"
            }
            "snell" | "admittance" | "lamella_unit" | "ridge_spacing" => "; give model=Model(...)",
            _ => "",
        };
        Err(PyTypeError::new_err(format!("`{name}` is no keyword of this function{place}")))
    }
}

/// Strength of Model A: "fit" or a number.
#[derive(FromPyObject)]
enum WeightGiven {
    Known(f64),
    Word(String),
}

/// Values by the names of parameters, in the order of the names.
type Named<T> = BTreeMap<String, T>;

fn parameter(argument: &str, name: &str) -> PyResult<Parameter> {
    Parameter::from_name(name).ok_or_else(|| {
        let names = Parameter::ALL.map(Parameter::name).join(", ");
        unfit(format!("{argument}: `{name}` is no parameter; there are {names} (or a)"))
    })
}

fn finite(argument: &str, value: f64) -> PyResult<f64> {
    if value.is_finite() { Ok(value) } else { Err(unfit(format!("{argument}: {value} is not a finite number"))) }
}

/// The model and the settings of the keywords, checked.
pub(crate) fn settings(py: Python<'_>, keywords: &mut Keywords<'_>) -> PyResult<(Model, FitSettings)> {
    let extents = [("none", Extent::None), ("shared", Extent::Shared), ("per-curve", Extent::PerCurve)];
    let losses =
        [("linear", Loss::Linear), ("soft-l1", Loss::SoftL1), ("huber", Loss::Huber), ("cauchy", Loss::Cauchy)];
    let derivatives = [("exact", Derivative::Exact), ("finite-difference", Derivative::FiniteDifference)];
    let model = ModelArgument::model(keywords.take("model")?, py)?;
    let weight = match keywords.take("weight")? {
        None => Weight::Fitted,
        Some(WeightGiven::Known(weight)) => Weight::Fixed(weight),
        Some(WeightGiven::Word(word)) => choose("weight", &word, &[("fit", Weight::Fitted)])?,
    };
    let scale = keywords.word("scale", &extents, Extent::Shared)?;
    let background = keywords.word("background", &extents, Extent::None)?;
    let usual = FitSettings::default();
    let mut settings = FitSettings {
        model: model.choice,
        stack: model.stack.clone(),
        averages: model.averages,
        nuisances: Nuisances { scale, weight, background },
        loss: keywords.word("loss", &losses, Loss::Linear)?,
        search: if keywords.take("local")?.unwrap_or(false) { Search::Local } else { Search::Global },
        derivative: keywords.word("derivative", &derivatives, Derivative::Exact)?,
        level: keywords.take("level")?.unwrap_or(usual.level),
        seed: keywords.take("seed")?.unwrap_or(usual.seed),
        ..usual
    };
    for name in keywords.take::<Vec<String>>("require")?.unwrap_or_default() {
        settings.required.push(parameter("require", &name)?);
    }
    roles(&mut settings, keywords)?;
    settings.validate().map_err(|error| of_settings(&error))?;
    Ok((model, settings))
}

fn roles(settings: &mut FitSettings, keywords: &mut Keywords<'_>) -> PyResult<()> {
    if let (ModelChoice::Hybrid { ridge_spacing }, Role::Free { lower, upper }) =
        (settings.model, &mut settings.roles[Parameter::LamellaWidth.index()])
        && ridge_spacing > *lower
    {
        *upper = upper.min(ridge_spacing);
    }
    let mut given: Vec<(&str, Parameter, Role)> = Vec::new();
    for (name, value) in keywords.take::<Named<f64>>("fix")?.unwrap_or_default() {
        let parameter = parameter("fix", &name)?;
        given.push(("fix", parameter, Role::Fixed { value: parameter.inside(finite("fix", value)?) }));
    }
    for (name, ends) in keywords.take::<Named<Vec<f64>>>("bounds")?.unwrap_or_default() {
        let parameter = parameter("bounds", &name)?;
        let ends = <[f64; 2]>::try_from(ends);
        let [lower, upper] = ends.map_err(|_| unfit(format!("bounds of {name}: give two numbers, (low, high)")))?;
        let (lower, upper) = (finite("bounds", lower)?, finite("bounds", upper)?);
        given.push((
            "bounds",
            parameter,
            Role::Free { lower: parameter.inside(lower), upper: parameter.inside(upper) },
        ));
    }
    for (name, (other, factor, constant)) in keywords.take::<Named<(String, f64, f64)>>("link")?.unwrap_or_default() {
        let (parameter, other) = (parameter("link", &name)?, parameter("link", &other)?);
        // In the users' units: one unit of the parameter over one unit of the other.
        let factor = finite("link", factor)? * parameter.inside(1.0) / other.inside(1.0);
        let constant = parameter.inside(finite("link", constant)?);
        given.push(("link", parameter, Role::Linked { other, factor, constant }));
    }
    let mut said: [Option<&str>; COUNT] = [None; COUNT];
    for (argument, parameter, role) in given {
        if let Some(earlier) = said[parameter.index()].replace(argument) {
            return Err(unfit(format!("{parameter} is given in {earlier} and in {argument}; leave one of them out")));
        }
        settings.roles[parameter.index()] = role;
    }
    for (name, value) in keywords.take::<Named<f64>>("start")?.unwrap_or_default() {
        let parameter = parameter("start", &name)?;
        if !matches!(settings.roles[parameter.index()], Role::Free { .. }) {
            return Err(unfit(format!("{parameter} is not free; leave its start out")));
        }
        settings.start[parameter.index()] = Some(parameter.inside(finite("start", value)?));
    }
    Ok(())
}
