//! `table.json` and `table.csv`: what a colour table is, and its nodes as text.

use super::ExportError;
use super::curves::{angle, number};
use crate::geometry::Polarization;
use crate::inversion::{Parameter, values};
use crate::optics::{Averages, Stack, Structure};
use crate::spectrum::Wavelengths;
use crate::table::{Judged, Needs, Nodes, Table};
use crate::units::degrees;
use serde_json::{Map, json};

/// Schema of `table.json`.
pub const TABLE_SCHEMA: &str = "morpho-fit/table/1";
/// Nodes of a table that is written as text, at most.
pub const MOST_ROWS: usize = 1_000_000;

/// The averages of what is tabled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableAverages<'a> {
    /// Their widths.
    pub averages: &'a Averages,
    /// Whether they are left out, as plane waves stay within the tolerance.
    pub plane_waves: bool,
    /// Largest CIEDE2000 difference of plane waves in random directions.
    pub missed: f64,
}

/// What stands beside the values of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableSheet<'a> {
    /// The table.
    pub table: &'a Table,
    /// Name of the file with its values.
    pub file: &'a str,
    /// Whether it has spectra, or linear sRGB.
    pub spectra: bool,
    /// Name of the forward model.
    pub model: &'a str,
    /// What is averaged over; none where nothing is.
    pub averages: Option<TableAverages<'a>>,
    /// The stack.
    pub stack: &'a Stack,
    /// The structure.
    pub structure: &'a Structure,
    /// What is seen.
    pub polarization: Polarization,
    /// Name of the observer.
    pub observer: &'a str,
    /// Name of the light.
    pub illuminant: &'a str,
    /// The wavelengths that it was computed at.
    pub wavelengths: &'a Wavelengths,
    /// The wavelengths that it was held against.
    pub reference: &'a Wavelengths,
    /// What was asked for.
    pub needs: &'a Needs,
    /// What it is off by.
    pub judged: &'a Judged,
}

/// The table in words and numbers, as indented JSON: axes in degrees, range, structure, light, exposure and error.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn table_json(sheet: &TableSheet<'_>) -> Result<Vec<u8>, ExportError> {
    let TableSheet { table, needs, judged, .. } = sheet;
    let nodes = table.nodes();
    let axis = |name: &str, values: &[f64]| json!({ "name": name, "unit": "deg", "values": values.iter().map(|&value| rounded(value)).collect::<Vec<_>>() });
    let channels = if sheet.spectra {
        json!({ "name": "wavelength", "unit": "nm", "values": sheet.wavelengths.iter().collect::<Vec<_>>() })
    } else {
        json!({ "name": "channel", "values": ["red", "green", "blue"] })
    };
    let mut parameters = Map::new();
    for (parameter, value) in Parameter::ALL.into_iter().zip(values(sheet.structure)) {
        let value = (parameter.outside(value) * 1e9).round() / 1e9;
        parameters.insert(format!("{}_{}", parameter.name(), parameter.unit()), json!(value));
    }
    let averages = sheet.averages.as_ref().map(|TableAverages { averages, plane_waves, missed }| {
        json!({
            "numerical_aperture": averages.numerical_aperture,
            "bandwidth_nm": averages.bandwidth,
            "period_spread_nm": averages.period_spread,
            "layer_spread_nm": averages.layer_spread,
            "tilt_spread_deg": rounded(averages.tilt_spread),
            "computed": !plane_waves,
            "difference_of_plane_waves": missed,
        })
    });
    let ends = |ends: [f64; 2]| ends.map(rounded);
    let (second, turn) = (nodes.kind().name(), nodes.turn().name());
    let quantity = if sheet.spectra { "reflectivity at each wavelength, a fraction" } else { "linear sRGB" };
    let grid = |grid: &Wavelengths| json!({ "first": grid.first(), "last": grid.last(), "step": grid.step() });
    let text = json!({
        "schema": TABLE_SCHEMA,
        "program": concat!("morpho-fit ", env!("CARGO_PKG_VERSION")),
        "file": sheet.file,
        "quantity": quantity,
        "exposure": "1: a perfect white diffuser in this light is (1, 1, 1), or 1 at each wavelength",
        "order": [&format!("theta, {second}, omega, {}", if sheet.spectra { "wavelength" } else { "channel" }), "the last fastest"],
        "shape": [nodes.theta().len(), nodes.across().len(), nodes.omega().len(), table.channels()],
        "dtype": "<f4",
        "axes": [axis("theta", nodes.theta()), axis(second, nodes.across()), axis("omega", nodes.omega()), channels],
        "between_nodes": format!("linear in theta, in {second} and in {turn}"),
        "signs": "theta and phi from the scale normal, the same way round: the mirror direction is phi = -theta; omega 0 \
                  across the ridges, 90 along them",
        "range_deg": {
            "theta": ends(needs.range.theta), "phi": ends(needs.range.phi), "omega": ends(needs.range.omega),
            "note": "nodes whose phi lies outside serve the cells at the edge only",
        },
        "nodes": nodes.count(),
        "bytes": table.bytes(),
        "model": sheet.model,
        "structure": parameters,
        "stack": sheet.stack,
        "averages": averages,
        "polarization": sheet.polarization.word(),
        "observer": sheet.observer,
        "illuminant": sheet.illuminant,
        "wavelengths_nm": grid(sheet.wavelengths),
        "error": {
            "measure": "CIEDE2000 under the perfect white in this light, against direct evaluation",
            "reference_wavelengths_nm": grid(sheet.reference),
            "tolerance": needs.tolerance,
            "worst": judged.worst,
            "worst_at_deg": {
                "theta": rounded(judged.at.theta), "phi": rounded(judged.at.phi), "omega": rounded(judged.at.omega),
            },
            "mean": judged.mean,
            "directions": judged.compared,
            "seed": needs.seed,
        },
    });
    let mut bytes = serde_json::to_vec_pretty(&text)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Degrees to nine decimals.
fn rounded(radians: f64) -> f64 {
    (degrees(radians) * 1e9).round() / 1e9 + 0.0
}

/// One node a row: the three axes in degrees, then the values: `red`, `green`, `blue` (linear sRGB), or one for each wavelength.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails, [`ExportError::Shape`] for more than [`MOST_ROWS`] nodes.
pub fn table_csv(sheet: &TableSheet<'_>) -> Result<Vec<u8>, ExportError> {
    let table = sheet.table;
    let nodes: &Nodes = table.nodes();
    if nodes.count() > MOST_ROWS {
        let shape = vec![nodes.theta().len(), nodes.across().len(), nodes.omega().len(), table.channels()];
        return Err(ExportError::Shape { shape, values: table.values().len() });
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    let second = format!("{}_deg", nodes.kind().name().replace(" + ", "_plus_"));
    let mut head = vec!["theta_deg".to_owned(), second, "omega_deg".to_owned()];
    if sheet.spectra {
        head.extend(sheet.wavelengths.iter().map(|wavelength| format!("{}_nm", number(wavelength))));
    } else {
        head.extend(["red", "green", "blue"].map(str::to_owned));
    }
    writer.write_record(&head)?;
    let mut rows = table.values().chunks(table.channels());
    for &theta in nodes.theta() {
        for &across in nodes.across() {
            for &omega in nodes.omega() {
                let Some(row) = rows.next() else { continue };
                let place = [theta, across, omega].map(angle);
                // The shortest text of a value in single precision.
                writer.write_record(place.into_iter().chain(row.iter().map(ToString::to_string)))?;
            }
        }
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}
