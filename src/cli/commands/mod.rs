//! One file for each word of the command line, each with one `run`.

pub(crate) mod check;
pub(crate) mod curves;
pub(crate) mod fit;
mod intervals;
pub(crate) mod paper;
pub(crate) mod simulate;
pub(crate) mod sweep;

use anyhow::Result;
use morpho_fit::plot::{Figure, Picture, draw};

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
