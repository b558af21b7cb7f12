//! `sweep.csv`: colours of structures and views as numbers.

use super::ExportError;
use super::curves::{angle, number};
use crate::colorimetry::{Lab, Shown, Xyz};
use crate::sweep::View;
use crate::units::degrees;

const HEADINGS: [&str; 20] = [
    "d_air_nm",
    "d_cuticle_nm",
    "delta_deg",
    "phi_alpha_rad",
    "lamella_width_nm",
    "theta_deg",
    "phi_deg",
    "omega_deg",
    "X",
    "Y",
    "Z",
    "x",
    "y",
    "L",
    "a",
    "b",
    "red",
    "green",
    "blue",
    "outside_srgb",
];

/// One view a row: structure, angles, tristimulus values (perfect white: Y = 100), chromaticity, CIELAB, and red, green and
/// blue from 0 to 255 as they are shown. Empty where the model has no answer.
///
/// # Shape
/// One colour and one shown colour for each view; rows end with the shortest list.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn colours_csv(
    views: &[View],
    colours: &[Option<Xyz>],
    white: Xyz,
    shown: &[Option<Shown>],
) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADINGS)?;
    for ((view, colour), shown) in views.iter().zip(colours).zip(shown) {
        let (one, seen) = (view.structure, view.geometry);
        let mut row = vec![
            rounded(one.d_air),
            rounded(one.d_cuticle),
            rounded(degrees(one.delta)),
            rounded(one.phi_alpha),
            rounded(one.lamella_width),
            angle(seen.theta),
            angle(seen.phi),
            angle(seen.omega),
        ];
        if let (Some(colour), Some(shown)) = (colour, shown) {
            let [x, y, z] = colour.to_array().map(|value| number(100.0 * value));
            row.extend([x, y, z]);
            let chromaticity = colour.chromaticity();
            row.extend(
                [chromaticity.map(|c| number(c.x)), chromaticity.map(|c| number(c.y))].map(Option::unwrap_or_default),
            );
            match Lab::new(*colour, white) {
                Ok(lab) => row.extend([lab.l, lab.a, lab.b].map(number)),
                Err(_) => row.extend(std::iter::repeat_n(String::new(), 3)),
            }
            row.extend(shown.bytes.map(|byte| byte.to_string()));
            row.push(shown.outside.to_string());
        }
        row.resize(HEADINGS.len(), String::new());
        writer.write_record(&row)?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}

/// Without the last digits of a grid or of a conversion.
fn rounded(value: f64) -> String {
    number((value * 1e9).round() / 1e9 + 0.0)
}
