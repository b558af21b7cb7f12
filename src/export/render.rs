//! `render.json`: how pictures of a wing were made.

use super::ExportError;
use crate::inversion::{Parameter, values};
use crate::optics::{Stack, Structure};
use crate::render::{CAMERA_DISTANCE, ColourLookup, FIELD_OF_VIEW, HALF_SIDE, Scene, Surface};
use crate::spectrum::Wavelengths;
use crate::units::degrees;
use serde_json::{Map, Value, json};

/// Schema of `render.json`.
pub const RENDER_SCHEMA: &str = "morpho-fit/render/1";

/// What stands beside the pictures.
#[derive(Debug, Clone)]
pub struct RenderSheet<'a> {
    /// Name of the forward model.
    pub model: &'a str,
    /// The stack.
    pub stack: &'a Stack,
    /// The structure.
    pub structure: &'a Structure,
    /// Name of the observer.
    pub observer: &'a str,
    /// Name of the light.
    pub illuminant: &'a str,
    /// The wavelengths of the colours.
    pub wavelengths: &'a Wavelengths,
    /// What becomes of colours that sRGB cannot show, in words.
    pub gamut: &'a str,
    /// The colours.
    pub colours: &'a ColourLookup,
    /// Largest difference that was asked for.
    pub tolerance: f64,
    /// The maps: where each comes from.
    pub maps: &'a [(&'a str, String)],
    /// The wing.
    pub surface: &'a Surface,
    /// Height of a displacement of 1, sides.
    pub relief: f64,
    /// Width and height of a picture, pixels.
    pub size: (usize, usize),
    /// Samples along a side of a pixel.
    pub samples: usize,
    /// Factor on the light, and whether it was chosen by the pictures.
    pub exposure: (f64, bool),
    /// Each picture: its files, its scene, and the share of the wing that sRGB cannot show.
    pub pictures: &'a [(Vec<String>, Scene, f64)],
}

/// The sheet as indented JSON; angles in degrees, lengths of the scene in half sides of the square.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn render_json(sheet: &RenderSheet<'_>) -> Result<Vec<u8>, ExportError> {
    let rounded = |value: f64| (value * 1e9).round() / 1e9;
    let mut parameters = Map::new();
    for (parameter, value) in Parameter::ALL.into_iter().zip(values(sheet.structure)) {
        let name = format!("{}_{}", parameter.name(), parameter.unit());
        parameters.insert(name, json!(rounded(parameter.outside(value))));
    }
    let object = |pairs: &mut dyn Iterator<Item = (String, Value)>| Value::Object(pairs.collect());
    let pictures: Vec<Value> = (sheet.pictures.iter())
        .map(|(files, scene, outside)| {
            json!({
                "files": files,
                "view_deg": rounded(degrees(scene.view)),
                "sun_deg": rounded(degrees(scene.sun)),
                "sun_azimuth_deg": rounded(degrees(scene.azimuth)),
                "share_of_wing_outside_srgb": outside,
            })
        })
        .collect();
    let error = sheet.colours.error();
    let text = json!({
        "schema": RENDER_SCHEMA,
        "program": concat!("morpho-fit ", env!("CARGO_PKG_VERSION")),
        "pictures": pictures,
        "size": [sheet.size.0, sheet.size.1],
        "samples_per_pixel": sheet.samples * sheet.samples,
        "exposure": {
            "factor": sheet.exposure.0,
            "chosen": if sheet.exposure.1 { "about 99 % of the pixels of wing over all pictures fit below 1" } else { "given" },
            "unit": "1: a white diffuser turned to the sun is white; the EXR files have this unit, without the factor",
        },
        "scene": {
            "wing": { "half_side": HALF_SIDE, "plane": "z = 0, centre in the origin, y upwards in the maps" },
            "camera": {
                "distance": CAMERA_DISTANCE, "looks_at": [0, 0, 0], "from": "(0, -sin view, cos view)",
                "field_of_view_deg": FIELD_OF_VIEW, "field_of_view_axis": "smaller",
            },
            "sun": "far away, towards (sin sun cos azimuth, sin sun sin azimuth, cos sun)",
        },
        "maps": object(&mut sheet.maps.iter().map(|(map, origin)| ((*map).to_owned(), json!(origin)))),
        "relief_sides": sheet.relief,
        "gaps_nm": sheet.surface.found_gaps().map(rounded),
        "model": sheet.model,
        "structure": parameters,
        "stack": sheet.stack,
        "observer": sheet.observer,
        "illuminant": sheet.illuminant,
        "wavelengths_nm": {
            "first": sheet.wavelengths.first(), "last": sheet.wavelengths.last(), "step": sheet.wavelengths.step(),
        },
        "gamut": sheet.gamut,
        "colours": {
            "nodes": { "d_air": sheet.colours.nodes()[0], "v": sheet.colours.nodes()[1], "u_x": sheet.colours.nodes()[2] },
            "bytes": sheet.colours.bytes(),
            "error": {
                "measure": "CIEDE2000 against spectra at the same wavelengths, the brightest colour as light as white",
                "tolerance": sheet.tolerance, "worst": error.worst, "mean": error.mean, "directions": error.compared,
            },
        },
    });
    let mut bytes = serde_json::to_vec_pretty(&text)?;
    bytes.push(b'\n');
    Ok(bytes)
}
