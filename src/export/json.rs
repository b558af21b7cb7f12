//! `fit.json`: the outcome of a fit, readable by people and programs.

use super::ExportError;
use crate::inversion::FitOutcome;

/// The outcome as indented JSON with a line feed at its end.
///
/// Numbers are the shortest text with the same bits; what has no value is `null`.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn fit_json(outcome: &FitOutcome) -> Result<Vec<u8>, ExportError> {
    let mut bytes = serde_json::to_vec_pretty(outcome)?;
    bytes.push(b'\n');
    Ok(bytes)
}
