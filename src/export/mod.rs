//! Results as bytes: `fit.json`, `curves.csv`, the samples behind intervals, tables. Nothing here opens a file.

mod batch;
mod bsdf;
mod colours;
mod constant;
mod curves;
#[cfg(feature = "cli")]
mod exr;
mod image;
mod json;
mod mitsuba;
mod npy;
mod ply;
mod render;
mod samples;
mod table;
mod terms;
#[cfg(feature = "tradeoff")]
mod tradeoff;

pub use batch::{BATCH_SCHEMA, Batch, BatchCounts, BatchFit, BatchRow, BatchValue, BatchValues, batch_csv, batch_json};
#[cfg(feature = "python")]
pub(crate) use batch::{JOINT, nothing, word};
pub use bsdf::{BSDF_SCHEMA, BsdfFile, BsdfSheet, certificate_json};
pub use colours::colours_csv;
pub use constant::{CONSTANT_SCHEMA, constant_csv, constant_json};
pub use curves::curves_csv;
#[cfg(feature = "cli")]
pub use exr::exr;
pub use image::{Pixels, animated_png, png, png16};
pub use json::{fit_json, read_fit_json};
pub use mitsuba::{MitsubaScene, mitsuba_files};
pub use npy::npy;
pub use ply::ply;
pub use render::{RENDER_SCHEMA, RenderSheet, render_json};
pub use samples::{bootstrap_csv, posterior_csv, profile_csv};
pub use table::{MOST_ROWS, TABLE_SCHEMA, TableAverages, TableSheet, table_csv, table_json};
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
    /// An array that has not as many values as its shape says, or more than the format takes.
    #[error("an array of the shape {shape:?} with {values} values cannot be written in this format")]
    Shape {
        /// Length of each axis.
        shape: Vec<usize>,
        /// Number of values.
        values: usize,
    },
    /// The PNG writer failed: a picture without pixels, or with too few or too many bytes.
    #[error("the picture cannot be written as PNG")]
    Png(#[from] ::png::EncodingError),
    /// The `OpenEXR` writer failed.
    #[error("the picture cannot be written as OpenEXR: {problem}")]
    Exr {
        /// What it says.
        problem: String,
    },
    /// The CSV writer failed.
    #[error("the table cannot be written as CSV")]
    Csv(#[from] csv::Error),
}
