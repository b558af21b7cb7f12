//! One file for each word of the command line, each with one `run`.

pub(crate) mod batch;
pub(crate) mod bsdf;
pub(crate) mod check;
pub(crate) mod constant;
pub(crate) mod curves;
pub(crate) mod fit;
pub(crate) mod import_bsdf;
mod intervals;
mod mitsuba;
pub(crate) mod paper;
pub(crate) mod render;
pub(crate) mod simulate;
pub(crate) mod sweep;
pub(crate) mod table;
pub(crate) mod tradeoff;

use crate::exit::Usage;
use crate::output::Folder;
use anyhow::Result;
use morpho_fit::plot::{Figure, Picture, draw};
use std::path::PathBuf;

fn drawn(figures: Vec<(&'static str, Figure)>) -> Result<Vec<(&'static str, Picture)>> {
    figures.into_iter().map(|(name, figure)| Ok((name, draw(&figure)?))).collect()
}

/// Each picture as SVG and PNG.
fn chart_files(pictures: &[(&'static str, Picture)]) -> Vec<(String, Vec<u8>)> {
    let both = |(name, picture): &(&str, Picture)| {
        let Picture { svg, png } = picture.clone();
        [(format!("{name}.svg"), svg.into_bytes()), (format!("{name}.png"), png)]
    };
    pictures.iter().flat_map(both).collect()
}

/// An error if a result would take the place of something that was read.
fn refuse_to_replace(
    folder: &Folder,
    files: &[(String, Vec<u8>)],
    inputs: impl IntoIterator<Item = PathBuf>,
) -> Result<(), Usage> {
    let read: Vec<PathBuf> = inputs.into_iter().filter_map(|path| path.canonicalize().ok()).collect();
    let place = |name: &str| folder.path().join(name).canonicalize().ok();
    match files.iter().find(|(name, _)| place(name).is_some_and(|place| read.contains(&place))) {
        Some((name, _)) => {
            Err(Usage(format!("{name} of this folder was read and would be replaced; give another --out")))
        }
        None => Ok(()),
    }
}
