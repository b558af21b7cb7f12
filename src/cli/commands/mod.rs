//! One file for each word of the command line, each with one `run`.

pub(crate) mod check;
pub(crate) mod fit;
mod intervals;
pub(crate) mod simulate;
