//! `curves.csv`: every reading beside the model and its contributions.

use super::ExportError;
use crate::dataset::Dataset;
use crate::inversion::Fit;
use crate::units::degrees;

const HEADINGS: [&str; 14] = [
    "curve",
    "wavelength_nm",
    "theta_deg",
    "phi_deg",
    "omega_deg",
    "polarization",
    "intensity",
    "sigma",
    "model",
    "residual",
    "normalised_residual",
    "lamella",
    "multilayer",
    "background",
];

/// The readings of `data` in their order, each with the model's value at the minimum of `fit`.
///
/// `model = lamella + multilayer + background` and `residual = intensity - model`, all in the unit of the data;
/// `normalised_residual` is in standard deviations. `sigma` is empty where the data state none.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn curves_csv(data: &Dataset, fit: &Fit) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADINGS)?;
    for (reading, fitted) in data.readings().iter().zip(&fit.readings) {
        let geometry = reading.geometry;
        let curve = data.curves().get(reading.curve).map_or("", String::as_str);
        writer.write_record([
            curve,
            &number(reading.wavelength),
            &angle(geometry.theta),
            &angle(geometry.phi),
            &angle(geometry.omega),
            reading.polarization.word(),
            &number(reading.intensity),
            &reading.sigma.map(number).unwrap_or_default(),
            &number(fitted.model),
            &number(fitted.residual),
            &number(fitted.normalised),
            &number(fitted.lamella),
            &number(fitted.multilayer),
            &number(fitted.background),
        ])?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}

/// The shortest text with the same bits; very small and very large numbers have an exponent.
pub(super) fn number(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-5..1e15).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

/// Degrees to nine decimals, as the reader's and writer's of data; adding 0 turns -0 into 0.
pub(super) fn angle(radians: f64) -> String {
    number((degrees(radians) * 1e9).round() / 1e9 + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_written_as_they_were_typed() {
        assert_eq!(angle(12.5_f64.to_radians()), "12.5");
        assert_eq!(angle(-0.0), "0");
        assert_eq!(number(1.5e-9), "1.5e-9");
    }
}
