//! Results as bytes: `fit.json`, `curves.csv` and the samples behind intervals. Nothing here opens a file.

mod colours;
mod curves;
mod json;
mod samples;
mod terms;
#[cfg(feature = "tradeoff")]
mod tradeoff;

pub use colours::colours_csv;
pub use curves::curves_csv;
pub use json::{fit_json, read_fit_json};
pub use samples::{bootstrap_csv, posterior_csv, profile_csv};
pub use terms::terms_csv;
#[cfg(feature = "tradeoff")]
pub use tradeoff::tradeoff_csv;

use crate::inversion::SCHEMA;

/// A result that could not be turned into bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The JSON writer failed.
    #[error("the result cannot be written as JSON")]
    Json(#[from] serde_json::Error),
    /// A file that is no result of a fit.
    #[error("this is no result of a fit: {0}")]
    NotAFit(#[source] serde_json::Error),
    /// A result of a fit in another schema.
    #[error("the result has the schema `{found}`; this version reads `{SCHEMA}`: fit again")]
    Schema {
        /// The schema it names.
        found: String,
    },
    /// The CSV writer failed.
    #[error("the table cannot be written as CSV")]
    Csv(#[from] csv::Error),
}
