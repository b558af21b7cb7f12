//! Errors as exceptions: each is a `ValueError`, and those about data carry path, line and column.

use crate::dataset::{Findings, Place};
use crate::inversion::{FitError as Unfit, SettingsError};
use crate::optics;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

create_exception!(
    morpho_fit,
    DataError,
    PyValueError,
    "Data that cannot be used. `path`, `line`, `column` and `reading` are those of the first finding, or None; `findings` is a \
     list of dicts with `line`, `column`, `reading` and `message`, one for each defect, at most 1000."
);
create_exception!(morpho_fit, FitError, PyValueError, "Settings or data that cannot be fitted.");
create_exception!(
    morpho_fit,
    OpticsError,
    PyValueError,
    "A structure, geometry or material for which there is no reflectivity. `index` is the number of the element of the arrays, \
     or None."
);

/// A choice that cannot be.
pub(crate) fn refused(message: impl Into<String>) -> PyErr {
    FitError::new_err(message.into())
}

/// Findings about `path`, or about arrays.
pub(crate) fn of_findings(py: Python<'_>, findings: Findings, path: Option<&str>) -> PyErr {
    let findings = match path {
        Some(path) => findings.in_file(path),
        None => findings,
    };
    let all = PyList::empty(py);
    let filled = findings.as_slice().iter().try_for_each(|finding| {
        let one = PyDict::new(py);
        one.set_item("line", finding.line())?;
        one.set_item("column", finding.column.as_ref().map(|column| column.name.as_str()))?;
        let reading = match finding.place {
            Some(Place::Reading(number)) => Some(number - 1),
            _ => None,
        };
        one.set_item("reading", reading)?;
        one.set_item("message", finding.to_string())?;
        all.append(one)
    });
    let error = DataError::new_err(findings.to_string());
    filled.and_then(|()| about(py, &error, path, &all)).err().unwrap_or(error)
}

/// One defect of a column of arrays.
pub(crate) fn of_column(py: Python<'_>, column: &str, message: &str) -> PyErr {
    let all = PyList::empty(py);
    let one = PyDict::new(py);
    let nothing = py.None();
    let filled = [("line", None), ("column", Some(column)), ("reading", None), ("message", Some(message))]
        .into_iter()
        .try_for_each(|(name, value)| one.set_item(name, value))
        .and_then(|()| all.append(one));
    drop(nothing);
    let error = DataError::new_err(format!("`{column}`: {message}"));
    filled.and_then(|()| about(py, &error, None, &all)).err().unwrap_or(error)
}

/// Hangs the findings on the exception, and the first one's place.
fn about(py: Python<'_>, error: &PyErr, path: Option<&str>, findings: &Bound<'_, PyList>) -> PyResult<()> {
    let value = error.value(py);
    value.setattr("path", path)?;
    for name in ["line", "column", "reading"] {
        let first = findings.get_item(0).and_then(|first| first.get_item(name));
        value.setattr(name, first.unwrap_or_else(|_| py.None().into_bound(py)))?;
    }
    value.setattr("findings", findings)
}

/// What the optics refuse; `index` counts the elements of arrays.
pub(crate) fn of_optics(py: Python<'_>, found: &optics::OpticsError, index: Option<usize>) -> PyErr {
    let message = match index {
        Some(index) => format!("element {index}: {found}"),
        None => found.to_string(),
    };
    let error = OpticsError::new_err(message);
    error.value(py).setattr("index", index).err().unwrap_or(error)
}

/// A fit that could not begin.
pub(crate) fn of_fit(py: Python<'_>, found: &Unfit) -> PyErr {
    match found {
        Unfit::Optics(error) => of_optics(py, error, None),
        other => refused(other.to_string()),
    }
}

/// Choices that cannot be fitted.
pub(crate) fn of_settings(found: &SettingsError) -> PyErr {
    refused(found.to_string())
}
