//! `fit.json`: the outcome of a fit, readable by people and programs.

use super::ExportError;
use crate::inversion::{FitOutcome, SCHEMA};

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

/// The outcome that [`fit_json`] wrote, to the same bits.
///
/// # Errors
/// [`ExportError::NotAFit`] if the bytes are no such file of this version's schema.
///
/// ```
/// use morpho_fit::export::read_fit_json;
/// let error = read_fit_json(b"{}").unwrap_err();
/// assert!(error.to_string().contains("no result of a fit"));
/// ```
pub fn read_fit_json(bytes: &[u8]) -> Result<FitOutcome, ExportError> {
    #[derive(serde::Deserialize)]
    struct Head {
        schema: String,
    }
    let head: Head = serde_json::from_slice(bytes).map_err(ExportError::NotAFit)?;
    if head.schema != SCHEMA {
        return Err(ExportError::Schema { found: head.schema });
    }
    serde_json::from_slice(bytes).map_err(ExportError::NotAFit)
}
