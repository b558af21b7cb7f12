//! `model.csv`: the model and its contributions along curves.

use super::ExportError;
use super::curves::{angle, number};
use crate::sweep::Curve;

const HEADINGS: [&str; 7] =
    ["wavelength_nm", "theta_deg", "phi_deg", "omega_deg", "lamella", "multilayer", "intensity"];

/// The readings of all curves, one a row, with both contributions and their sum; empty where the model has no answer.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn terms_csv(curves: &[Curve]) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADINGS)?;
    for ((geometry, wavelength), terms) in curves.iter().flat_map(|curve| curve.readings.iter().zip(&curve.terms)) {
        let value = |part: fn(&crate::sweep::Terms) -> f64| terms.as_ref().map(|terms| number(part(terms)));
        writer.write_record([
            number(*wavelength),
            angle(geometry.theta),
            angle(geometry.phi),
            angle(geometry.omega),
            value(|terms| terms.lamella).unwrap_or_default(),
            value(|terms| terms.multilayer).unwrap_or_default(),
            value(crate::sweep::Terms::sum).unwrap_or_default(),
        ])?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}
