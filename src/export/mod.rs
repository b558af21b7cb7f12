//! Results as bytes: `fit.json`, `curves.csv` and the samples behind intervals. Nothing here opens a file.

mod curves;
mod json;
mod samples;

pub use curves::curves_csv;
pub use json::fit_json;
pub use samples::{bootstrap_csv, posterior_csv, profile_csv};

/// A result that could not be turned into bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The JSON writer failed.
    #[error("the result cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// The CSV writer failed.
    #[error("the table cannot be written as CSV")]
    Csv(#[from] csv::Error),
}
