//! Measured data: the path of a CSV file, or a table of columns such as a dict or a frame of pandas or polars.

use super::arrays::require_real;
use super::errors::{Defect, of_defects, of_findings, refused};
use super::words;
use crate::dataset::{
    Constants, Dataset, FindingKind, Findings, Place, ReadOptions, Reading, WideHeading, check_headings,
    note_on_angles, read_csv,
};
use crate::geometry::{Geometry, Polarization};
use crate::units::radians;
use numpy::ndarray::Ix1;
use numpy::{AllowTypeChange, PyArrayLikeDyn};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};
use std::collections::HashMap;

/// Columns of numbers with their names in a file; the last is left out where there is none.
const NUMBERS: [&str; 6] = ["wavelength_nm", "theta_deg", "phi_deg", "omega_deg", "intensity", "sigma"];

/// Data as they were given, with what was noticed.
#[derive(Debug)]
pub(crate) struct Given {
    pub(crate) data: Dataset,
    /// Name of the file, for reports.
    pub(crate) name: String,
    /// What was noticed of a table that is no file.
    pub(crate) notes: Vec<String>,
}

/// What is not in the data.
#[derive(Debug, Default)]
pub(crate) struct Said {
    pub(crate) options: ReadOptions,
    pub(crate) intensity_column: Option<String>,
    /// Of a table that is a design alone: so many readings, whose intensities are 0, and what has so many.
    pub(crate) blank: Option<(usize, &'static str)>,
}

impl Said {
    /// Takes its keywords out of `settings`.
    pub(crate) fn take(settings: &mut super::settings::Keywords<'_>) -> PyResult<Self> {
        let constants = Constants { sigma: settings.take("sigma")?, ..geometry(settings)? };
        let headings = [("theta", WideHeading::Theta), ("phi", WideHeading::Phi), ("curve", WideHeading::Curve)];
        let wide = settings.take::<String>("wide")?.map(|word| words::choose("wide", &word, &headings)).transpose()?;
        let options = ReadOptions { constants, wide, ..ReadOptions::default() };
        Ok(Self { options, intensity_column: settings.take("intensity_column")?, blank: None })
    }
}

/// Takes the keywords of geometry out of `settings`.
fn geometry(settings: &mut super::settings::Keywords<'_>) -> PyResult<Constants> {
    let polarization = settings.take::<String>("polarization")?;
    Ok(Constants {
        wavelength_nm: settings.take("wavelength")?,
        theta_deg: settings.take("theta")?,
        phi_deg: settings.take("phi")?,
        omega_deg: settings.take("omega")?,
        polarization: polarization.map(|word| words::polarization(&word)).transpose()?,
        sigma: None,
    })
}

/// A design without intensities: a table, and what is the same for all of its readings as keywords.
pub(crate) fn design(
    py: Python<'_>,
    table: &Bound<'_, PyAny>,
    constants: &mut super::settings::Keywords<'_>,
) -> PyResult<Dataset> {
    let options = ReadOptions { constants: geometry(constants)?, ..ReadOptions::default() };
    let said = Said { options, intensity_column: None, blank: Some((length(table)?, "the first column")) };
    Ok(dataset(py, table, &said)?.data)
}

/// Number of rows of a table: the length of its first column.
fn length(table: &Bound<'_, PyAny>) -> PyResult<usize> {
    let names = if table.hasattr("keys")? {
        table.call_method0("keys")?
    } else if table.hasattr("columns")? {
        table.getattr("columns")?
    } else {
        return Err(refused("design is a table with named columns, such as a dict or a frame"));
    };
    match names.try_iter()?.next().transpose()? {
        Some(name) => table.get_item(&name)?.len().map_err(|_| {
            refused(format!("column `{name}` of design is no array; what is the same for all readings is a keyword"))
        }),
        None => Err(refused("design has no columns")),
    }
}

/// The readings of `design` with the numbers that its curves have in `data`; where all curves of these are `alike` any may stand
/// for one that they do not have.
pub(crate) fn in_curves_of(data: &Dataset, design: &Dataset, alike: bool) -> PyResult<Vec<Reading>> {
    let known = data.curves();
    let alike = alike || known.len() == 1 && design.curves().len() == 1;
    let numbers: Vec<usize> = design
        .curves()
        .iter()
        .map(|name| {
            let number = known.iter().position(|other| other == name).or(alike.then_some(0));
            number.ok_or_else(|| {
                let names = known.iter().take(8).map(String::as_str).collect::<Vec<_>>().join("`, `");
                refused(format!("the data have no curve `{name}`; name one in a column `curve`: `{names}`"))
            })
        })
        .collect::<PyResult<_>>()?;
    Ok(design.readings().iter().map(|reading| Reading { curve: numbers[reading.curve], ..*reading }).collect())
}

/// Reads `data`, by whatever of the two it is.
pub(crate) fn dataset(py: Python<'_>, data: &Bound<'_, PyAny>, said: &Said) -> PyResult<Given> {
    if let Ok(bytes) = data.cast::<PyBytes>() {
        return of_bytes(py, bytes.as_bytes(), "data", None, said);
    }
    if let Ok(text) = data.cast::<PyString>()
        && text.to_str().is_ok_and(|text| text.contains('\n'))
    {
        return of_bytes(py, text.to_str()?.as_bytes(), "data", None, said);
    }
    if data.hasattr("keys")? || data.hasattr("columns")? {
        return of_table(py, data, said);
    }
    let path: String =
        py.import("os")?.call_method1("fsdecode", (data,)).and_then(|path| path.extract()).map_err(|_| {
            refused(
                "data is neither a path, nor CSV as text or bytes, nor a table with named columns such as a dict or a frame",
            )
        })?;
    let file = py.import("pathlib")?.call_method1("Path", (path.as_str(),))?.call_method0("read_bytes")?;
    of_bytes(py, file.cast::<PyBytes>()?.as_bytes(), &path, Some(&path), said)
}

fn of_bytes(py: Python<'_>, bytes: &[u8], name: &str, path: Option<&str>, said: &Said) -> PyResult<Given> {
    if said.intensity_column.is_some() {
        return Err(refused(
            "intensity_column is for tables; of a file, give pandas.read_csv(file) or polars.read_csv(file)",
        ));
    }
    let data = py.detach(|| read_csv(bytes, &said.options)).map_err(|findings| of_findings(py, findings, path))?;
    Ok(Given { data, name: name.to_owned(), notes: Vec::new() })
}

fn of_table(py: Python<'_>, table: &Bound<'_, PyAny>, said: &Said) -> PyResult<Given> {
    if said.options.wide.is_some() {
        return Err(refused("wide is for files; bring a table into the tidy form, one reading a row"));
    }
    let keys = if table.hasattr("keys")? { table.call_method0("keys")? } else { table.getattr("columns")? };
    let names: Vec<String> = keys.try_iter()?.map(|key| key?.extract()).collect::<PyResult<_>>()?;
    let intensity = said.intensity_column.as_deref().unwrap_or("intensity");
    let headings = names.iter().map(|name| match name.as_str() {
        name if name == intensity => "intensity".to_owned(),
        "intensity" => "other intensity".to_owned(),
        name => name.to_owned(),
    });
    let blank = said.blank.filter(|_| !names.iter().any(|name| name == intensity));
    let headings = headings.chain(blank.map(|_| "intensity".to_owned()));
    let mut notes = check_headings(headings.collect(), &said.options).map_err(|found| of_headings(py, &found))?;
    let column = |name: &str| {
        // A column that is the intensity is nothing else.
        if name != "intensity" && name == intensity {
            return Ok(None);
        }
        let name = if name == "intensity" { intensity } else { name };
        names.iter().any(|known| known == name).then(|| table.get_item(name)).transpose()
    };
    let constants = &said.options.constants;
    let known =
        [constants.wavelength_nm, constants.theta_deg, constants.phi_deg, constants.omega_deg, None, constants.sigma];
    let mut columns: Vec<Option<Vec<f64>>> = Vec::new();
    for name in NUMBERS {
        let zeros = said.blank.filter(|_| name == "intensity").map(|(readings, _)| vec![0.0; readings]);
        columns.push(match zeros {
            None => column(name)?.map(|column| numbers(py, name, &column)).transpose()?,
            zeros => zeros,
        });
    }
    let curves = column("curve")?.map(|column| texts(py, "curve", &column)).transpose()?;
    let polarizations = column("polarization")?.map(|column| texts(py, "polarization", &column)).transpose()?;
    let lengths = NUMBERS.iter().zip(&columns).filter_map(|(name, column)| Some((*name, column.as_ref()?.len())));
    let texts = [("curve", &curves), ("polarization", &polarizations)];
    let lengths = lengths.chain(texts.into_iter().filter_map(|(name, column)| Some((name, column.as_ref()?.len()))));
    let length = columns[4].as_ref().map_or(0, Vec::len);
    for (name, found) in lengths {
        if found != length {
            let of = said.blank.map_or("intensity", |(_, of)| of);
            return Err(Defect::of_column(name, format!("{found} values, but {of} has {length}")).raise(py));
        }
    }
    let mut record = Records::default();
    let mut readings = Vec::with_capacity(length);
    for row in 0..length {
        let value = |place: usize| columns[place].as_ref().map(|column| column[row]).or(known[place]);
        let polarization = match &polarizations {
            None => constants.polarization.unwrap_or_default(),
            Some(all) => polarization_of(&all[row])
                .ok_or_else(|| {
                    Defect::of_reading("polarization", row, format!("`{}` is not s, p or unpolarized", all[row]))
                })
                .map_err(|defect| defect.raise(py))?,
        };
        // Every required column is there, or a number for all: the headings were checked.
        let needed = |place: usize| value(place).unwrap_or(f64::NAN);
        let geometry = Geometry { theta: radians(needed(1)), phi: radians(needed(2)), omega: radians(needed(3)) };
        let curve = curves.as_ref().map_or(0, |all| record.number(&all[row]));
        let (wavelength, intensity, sigma) = (needed(0), needed(4), value(5));
        readings.push(Reading { wavelength, geometry, polarization, intensity, sigma, curve, line: 0 });
    }
    if record.names.is_empty() {
        record.names.push("data".to_owned());
    }
    let data = py.detach(|| Dataset::from_readings(readings, record.names));
    let data = data.map_err(|findings| of_findings(py, findings, None))?;
    notes.extend(note_on_angles(data.readings()));
    Ok(Given { data, name: "data".to_owned(), notes })
}

/// Records by the first appearance of their names.
#[derive(Debug, Default)]
struct Records {
    names: Vec<String>,
    known: HashMap<String, usize>,
}

impl Records {
    fn number(&mut self, name: &str) -> usize {
        if let Some(number) = self.known.get(name) {
            return *number;
        }
        let number = self.names.len();
        self.names.push(name.to_owned());
        self.known.insert(name.to_owned(), number);
        number
    }
}

fn polarization_of(word: &str) -> Option<Polarization> {
    match word.to_ascii_lowercase().as_str() {
        "s" => Some(Polarization::S),
        "p" => Some(Polarization::P),
        "unpolarized" | "unpolarised" => Some(Polarization::Unpolarized),
        _ => None,
    }
}

/// A column as numbers; the first cell that is none is named.
fn numbers(py: Python<'_>, name: &str, column: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    require_real(column).map_err(|error| Defect::of_column(name, error.value(py).to_string()).raise(py))?;
    let array: PyResult<PyArrayLikeDyn<'_, f64, AllowTypeChange>> = column.extract();
    let Ok(array) = array else {
        for (row, cell) in column.try_iter()?.enumerate() {
            let cell = cell?;
            if cell.extract::<f64>().is_err() {
                let text = cell.str()?.to_string();
                return Err(Defect::of_reading(name, row, format!("`{text}` is not a number")).raise(py));
            }
        }
        return Err(Defect::of_column(name, "no column of numbers".to_owned()).raise(py));
    };
    match array.as_array().into_dimensionality::<Ix1>() {
        Ok(view) => Ok(view.to_vec()),
        Err(_) => Err(Defect::of_column(name, format!("{} dimensions, not one", array.as_array().ndim())).raise(py)),
    }
}

fn texts(py: Python<'_>, name: &str, column: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let one = |(row, cell): (usize, PyResult<Bound<'_, PyAny>>)| {
        let cell = cell?;
        // None, and what pandas puts where nothing is: NaN, NaT and NA.
        let missing = cell.is_none() || cell.ne(&cell).unwrap_or(true);
        if missing {
            return Err(Defect::of_reading(name, row, "the cell is empty".to_owned()).raise(py));
        }
        Ok(cell.str()?.to_string())
    };
    column.try_iter()?.enumerate().map(one).collect()
}

/// Findings about names of columns: there is no line.
fn of_headings(py: Python<'_>, findings: &Findings) -> PyErr {
    let defects = findings.as_slice().iter().map(|finding| {
        if let FindingKind::MissingColumn { name, flag } = &finding.kind {
            let keyword = flag.and_then(|flag| flag.split([' ', '-']).find(|word| !word.is_empty()));
            let keyword = keyword.map(|word| format!(", or give {word}= if one value holds for all readings"));
            let message = format!("column `{name}` is missing; add it{}", keyword.unwrap_or_default());
            return Defect { line: None, column: Some((*name).to_owned()), reading: None, message };
        }
        let column = finding.column.as_ref().map(|column| column.name.clone());
        let place = column.as_ref().map(|name| format!("column `{name}`: ")).unwrap_or_default();
        let reading = match finding.place {
            Some(Place::Reading(number)) => Some(number - 1),
            _ => None,
        };
        Defect { line: None, column, reading, message: format!("{place}{}", finding.kind) }
    });
    of_defects(py, None, defects.collect(), None)
}

/// The arrays of `data` by the names of columns, for results beside them.
pub(crate) fn columns<'py>(py: Python<'py>, data: &Dataset) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let of = |value: &dyn Fn(&Reading) -> f64| data.readings().iter().map(value).collect::<Vec<f64>>();
    let put = |name, values: Vec<f64>| {
        let shape = [values.len()];
        all.set_item(name, super::arrays::array(py, values, &shape)?)
    };
    let degrees = |angle: f64| (crate::units::degrees(angle) * 1e9).round() / 1e9 + 0.0;
    let curve = |reading: &Reading| data.curves().get(reading.curve).cloned().unwrap_or_default();
    all.set_item("curve", data.readings().iter().map(curve).collect::<Vec<_>>())?;
    put("wavelength_nm", of(&|reading| reading.wavelength))?;
    put("theta_deg", of(&|reading| degrees(reading.geometry.theta)))?;
    put("phi_deg", of(&|reading| degrees(reading.geometry.phi)))?;
    put("omega_deg", of(&|reading| degrees(reading.geometry.omega)))?;
    all.set_item("polarization", data.readings().iter().map(|one| one.polarization.word()).collect::<Vec<_>>())?;
    put("intensity", of(&|reading| reading.intensity))?;
    if data.has_sigma() {
        put("sigma", of(&|reading| reading.sigma.unwrap_or(f64::NAN)))?;
    }
    Ok(all)
}
