//! Results in words: the one-screen report, the page `report.html`, the captions of plots, the sentences of the verdict.

pub mod batch;
mod choice;
pub mod constant;
mod digits;
pub mod html;
pub mod paper;
mod rows;
pub mod swatches;
mod table;
pub mod terminal;
#[cfg(feature = "tradeoff")]
pub mod tradeoff;
pub mod uncertainty;
pub mod wording;

pub use digits::{plain, with_sigma};
pub use table::{Align, Table};
