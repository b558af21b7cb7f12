//! One file for each word of the command line, each with one `run`.

pub(crate) mod check;
pub(crate) mod curves;
pub(crate) mod fit;
mod intervals;
pub(crate) mod simulate;

use anyhow::Result;
use morpho_fit::plot::{Figure, draw};

/// Each figure as SVG and PNG.
fn drawn(figures: Vec<(&'static str, Figure)>) -> Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    for (name, figure) in figures {
        let picture = draw(&figure)?;
        files.extend([(format!("{name}.svg"), picture.svg.into_bytes()), (format!("{name}.png"), picture.png)]);
    }
    Ok(files)
}
