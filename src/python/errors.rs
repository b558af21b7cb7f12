//! Errors as exceptions: each is a `ValueError`, and those about data carry path, line and column.

use crate::dataset::{Finding, FindingKind, Findings, Place};
use crate::inversion::{FitError as Unfit, SettingsError};
use crate::optics;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// Defects that a message tells.
const SHOWN: usize = 20;

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

/// An argument that cannot be.
pub(crate) fn refused(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// What cannot be fitted.
pub(crate) fn unfit(message: impl Into<String>) -> PyErr {
    FitError::new_err(message.into())
}

/// One defect of data.
#[derive(Debug, Clone)]
pub(crate) struct Defect {
    /// Line of the file, counting from 1.
    pub(crate) line: Option<u64>,
    pub(crate) column: Option<String>,
    /// Row of a table, counting from 0.
    pub(crate) reading: Option<usize>,
    pub(crate) message: String,
}

impl Defect {
    pub(crate) fn of_column(column: &str, problem: String) -> Self {
        Self {
            line: None,
            column: Some(column.to_owned()),
            reading: None,
            message: format!("column `{column}`: {problem}"),
        }
    }

    pub(crate) fn of_reading(column: &str, row: usize, problem: String) -> Self {
        let message = format!("row {row}, column `{column}`: {problem}");
        Self { line: None, column: Some(column.to_owned()), reading: Some(row), message }
    }

    pub(crate) fn raise(self, py: Python<'_>) -> PyErr {
        of_defects(py, None, vec![self], None)
    }
}

/// Each finding with its place; rows of a table count from 0.
pub(crate) fn defects(findings: &Findings) -> Vec<Defect> {
    let mut said = Vec::new();
    let defect = |finding: &Finding| {
        let remedy = finding.kind.remedy().filter(|remedy| !said.contains(remedy));
        said.extend(remedy);
        let remedy = remedy.map(|remedy| format!("; {remedy}")).unwrap_or_default();
        let missing = match finding.kind {
            FindingKind::MissingColumn { name, .. } => Some(name.to_owned()),
            _ => None,
        };
        let column = finding.column.as_ref().map(|column| column.name.clone()).or(missing);
        match finding.place {
            Some(Place::Reading(number)) => {
                let message = finding.kind.to_string();
                let message = match finding.kind {
                    FindingKind::DuplicateReading { first: first @ Place::Reading(number) } => {
                        message.replace(&first.to_string(), &format!("row {}", number.saturating_sub(1)))
                    }
                    _ => message,
                };
                let place = column.as_ref().map(|name| format!(", column `{name}`")).unwrap_or_default();
                let row = number.saturating_sub(1);
                Defect {
                    line: None,
                    column,
                    reading: Some(row),
                    message: format!("row {row}{place}: {message}{remedy}"),
                }
            }
            _ => Defect { line: finding.line(), column, reading: None, message: finding.to_string() },
        }
    };
    findings.as_slice().iter().map(defect).collect()
}

/// Findings about `path`, or about a table.
pub(crate) fn of_findings(py: Python<'_>, findings: Findings, path: Option<&str>) -> PyErr {
    let findings = match path {
        Some(path) => findings.in_file(path),
        None => findings,
    };
    let defects = defects(&findings);
    // Rows of a table count from 0, as everywhere in Python; lines of a file are written as the command writes them.
    let text = path.map(|_| findings.to_string());
    of_defects(py, path, defects, text)
}

/// A `DataError` with all defects; its place is that of the first.
pub(crate) fn of_defects(py: Python<'_>, path: Option<&str>, defects: Vec<Defect>, text: Option<String>) -> PyErr {
    let text = text.unwrap_or_else(|| {
        let shown: Vec<&str> = defects.iter().take(SHOWN).map(|defect| defect.message.as_str()).collect();
        let more = defects.len().saturating_sub(SHOWN);
        let more = if more > 0 { format!("\nand {more} more") } else { String::new() };
        format!("{}{more}", shown.join("\n"))
    });
    let error = DataError::new_err(text);
    hang(py, &error, path, &defects).err().unwrap_or(error)
}

fn hang(py: Python<'_>, error: &PyErr, path: Option<&str>, defects: &[Defect]) -> PyResult<()> {
    let all = PyList::empty(py);
    for defect in defects {
        let one = PyDict::new(py);
        one.set_item("line", defect.line)?;
        one.set_item("column", defect.column.as_deref())?;
        one.set_item("reading", defect.reading)?;
        one.set_item("message", &defect.message)?;
        all.append(one)?;
    }
    let (value, first) = (error.value(py), defects.first());
    value.setattr("path", path)?;
    value.setattr("line", first.and_then(|first| first.line))?;
    value.setattr("column", first.and_then(|first| first.column.as_deref()))?;
    value.setattr("reading", first.and_then(|first| first.reading))?;
    value.setattr("findings", all)
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
        other => unfit(other.to_string()),
    }
}

/// Choices that cannot be fitted.
pub(crate) fn of_settings(found: &SettingsError) -> PyErr {
    unfit(found.to_string())
}
