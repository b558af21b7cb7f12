//! The colour table.

use crate::args::drawing::DrawingArgs;
use crate::args::{AcrossWord, SubjectArgs, TableFormat, ViewingArgs};
use crate::values;
use clap::Args;

#[derive(Debug, Args)]
pub(crate) struct TableArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) choice: TableChoiceArgs,
    #[command(flatten)]
    pub(crate) viewing: ViewingArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Table")]
pub(crate) struct TableChoiceArgs {
    /// Incidences, degrees.
    #[arg(long, value_name = "LOW:HIGH", value_parser = angles, default_value = "0:85", allow_hyphen_values = true)]
    pub(crate) theta: [f64; 2],
    /// Views, degrees, the same way round as the incidence.
    #[arg(long, value_name = "LOW:HIGH", value_parser = angles, default_value = "-85:85", allow_hyphen_values = true)]
    pub(crate) phi: [f64; 2],
    /// Planes: 0 lies across the ridges, 90 along them, degrees.
    #[arg(long, value_name = "LOW:HIGH", value_parser = planes, default_value = "0:90", allow_hyphen_values = true)]
    pub(crate) omega: [f64; 2],
    /// Largest CIEDE2000 difference of a colour that is looked up from the same one evaluated directly. With `--wavelengths
    /// auto` their choice is a part of it, and --max-difference holds where it asks for less.
    #[arg(long, value_name = "DELTA_E", default_value = "1", value_parser = values::positive)]
    pub(crate) tolerance: f64,
    /// The second axis: `mirror` counts theta + phi, along which peak and lobe stand still and few nodes do; `view` counts phi.
    #[arg(long, value_name = "WORD", default_value = "mirror")]
    pub(crate) across: AcrossWord,
    /// Table spectra, the reflectivity at each wavelength, instead of linear sRGB.
    #[arg(long)]
    pub(crate) spectra: bool,
    /// `npy` for table.npy, which `numpy.load` reads; `csv` for table.csv, one node a row, of small tables.
    #[arg(long, value_name = "WORD", default_value = "npy")]
    pub(crate) format: TableFormat,
    /// Nodes at most: a tolerance that asks for more is refused.
    #[arg(long, value_name = "COUNT", default_value_t = 10_000_000, value_parser = values::count)]
    pub(crate) max_nodes: usize,
    /// Seed of the directions that the table is judged at.
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    pub(crate) seed: u64,
}

/// `LOW:HIGH`, or one value.
fn ends(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once(':').unwrap_or((text, text));
    if high.contains(':') {
        return Err(format!("`{text}` is not LOW:HIGH; the table chooses its nodes itself"));
    }
    let ends = [values::number(low)?, values::number(high)?];
    if ends[0] > ends[1] { Err(format!("{} is above {}; write LOW:HIGH", ends[0], ends[1])) } else { Ok(ends) }
}

fn angles(text: &str) -> Result<[f64; 2], String> {
    let ends = ends(text)?;
    ends.into_iter().try_for_each(values::within_angles)?;
    Ok(ends)
}

fn planes(text: &str) -> Result<[f64; 2], String> {
    let ends = ends(text)?;
    match ends.into_iter().find(|end| !(0.0..=90.0).contains(end)) {
        Some(end) => Err(format!("{end} is not within 0 to 90 degrees; other planes are mirror images of these")),
        None => Ok(ends),
    }
}
