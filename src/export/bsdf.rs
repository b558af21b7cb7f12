//! `certificate.json`: what the `.bsdf` files keep of the model.

use super::ExportError;
use crate::bsdf::{Certificate, Size};
use crate::geometry::Polarization;
use crate::inversion::{Parameter, values};
use crate::optics::{HybridModel, Structure};
use serde_json::{Map, Value, json};

/// Schema of `certificate.json`.
pub const BSDF_SCHEMA: &str = "morpho-fit/bsdf/1";

/// One file and what was measured of it.
#[derive(Debug, Clone, PartialEq)]
pub struct BsdfFile<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its bytes.
    pub bytes: usize,
    /// Its nodes.
    pub size: Size,
    /// What it keeps of the model.
    pub certificate: &'a Certificate,
    /// Wavelengths, nm; none for red, green and blue.
    pub wavelengths: Option<&'a [f64]>,
    /// What became 0 of colours outside sRGB: the largest channel below 0 as a share of the peak, and the share of the directions with light.
    pub clipped: Option<[f64; 2]>,
}

/// The surface and its files.
#[derive(Debug, Clone, PartialEq)]
pub struct BsdfSheet<'a> {
    /// The model.
    pub model: &'a HybridModel,
    /// The structure.
    pub structure: &'a Structure,
    /// Which polarization is written.
    pub polarization: Polarization,
    /// Root mean square error that was asked for, as a share of the peak.
    pub tolerance: f64,
    /// Seed of the random directions.
    pub seed: u64,
    /// The files.
    pub files: &'a [BsdfFile<'a>],
}

/// Files, settings and what was measured, as indented JSON.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn certificate_json(sheet: &BsdfSheet<'_>) -> Result<Vec<u8>, ExportError> {
    let mut parameters = Map::new();
    for (parameter, value) in Parameter::ALL.into_iter().zip(values(sheet.structure)) {
        let value = (parameter.outside(value) * 1e9).round() / 1e9;
        parameters.insert(format!("{}_{}", parameter.name(), parameter.unit()), json!(value));
    }
    let mut files = Vec::with_capacity(sheet.files.len());
    for file in sheet.files {
        let Size { azimuths, angles, side, channels } = file.size;
        let mut about = Map::new();
        let mut tell = |key: &str, value: Value| about.insert(key.to_owned(), value);
        tell("file", json!(file.name));
        tell("bytes", json!(file.bytes));
        tell("directions_of_the_table", json!(file.size.nodes()));
        tell("azimuths", json!(azimuths));
        tell("angles", json!(angles));
        tell("half_vectors", json!([side, side]));
        tell("channels", json!(channels));
        match file.wavelengths {
            Some(wavelengths) => tell("wavelengths_nm", json!(wavelengths)),
            None => tell(
                "colour",
                json!("linear sRGB in D65, observer 1931; a perfect white diffuser is 1/pi in each channel"),
            ),
        };
        if let Some([largest, share]) = file.clipped {
            tell(
                "below_zero_became_zero",
                json!({ "largest_share_of_peak": largest, "share_of_lit_directions": share }),
            );
        }
        tell("certificate", serde_json::to_value(file.certificate)?);
        files.push(Value::Object(about));
    }
    let text = json!({
        "schema": BSDF_SCHEMA,
        "program": concat!("morpho-fit ", env!("CARGO_PKG_VERSION")),
        "model": "hybrid",
        "structure": parameters,
        "stack": sheet.model.stack,
        "ridge_spacing_nm": sheet.model.ridge_spacing,
        "polarization": sheet.polarization.word(),
        "quantity": "f_r cos(theta_o), 1/sr; theta_i, phi_i and the first vector of a pair are the direction that a renderer calls wi",
        "frame": "x across the ridges, y along them, z the scale normal",
        "tolerance_rms_share_of_peak": sheet.tolerance,
        "seed": sheet.seed,
        "measures": {
            "reciprocity_at_nodes": "|T(i, o) cos_i - M(o, i) cos_o| / peak, worst of all nodes; T table, M model, both f cos of the second vector",
            "reciprocity_between_nodes": "|T(i, o) cos_i - T(o, i) cos_o| / peak at random directions",
            "error": "|T - M| / peak at random directions in which table or model has light, spectra at random wavelengths",
            "albedo": "integral of f cos(theta_o) over the hemisphere, largest over channels and incidences at nodes and between angles",
        },
        "files": files,
    });
    let mut bytes = serde_json::to_vec_pretty(&text)?;
    bytes.push(b'\n');
    Ok(bytes)
}
