//! Results as bytes: `fit.json` and `curves.csv`. Nothing here opens a file.

mod curves;
mod json;

pub use curves::curves_csv;
pub use json::fit_json;

/// A result that could not be turned into bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The JSON writer failed.
    #[error("the result cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// The CSV writer failed.
    #[error("the curves cannot be written as CSV")]
    Csv(#[from] csv::Error),
}
