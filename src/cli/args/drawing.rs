//! Charts of a structure: curves over the angle.

use crate::args::SubjectArgs;
use crate::scans::{Values, values};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct CurvesArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) curves: CurveArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Curves (START:STOP:STEP for a range, | between single values)")]
pub(crate) struct CurveArgs {
    /// Wavelengths of the curves over the viewing angle, nm, at most 8 [default: 420:580:40, or those of the data].
    #[arg(long, value_name = "NM", value_parser = values)]
    pub(crate) wavelength: Option<Values>,
    /// Incidence of the curves over the viewing angle, degrees [default: 0, or that of the data].
    #[arg(long, value_name = "DEG", value_parser = crate::values::number, allow_negative_numbers = true)]
    pub(crate) theta: Option<f64>,
    /// Planes: 0 lies across the ridges, 90 along them; at most 4 [default: 0|45|90, or those of the data].
    #[arg(long, value_name = "DEG", value_parser = values)]
    pub(crate) omega: Option<Values>,
    /// Incidences of the spectra, degrees, each viewed in the mirror direction, at most 8.
    #[arg(long, value_name = "DEG", value_parser = values, default_value = "0:60:15", allow_negative_numbers = true)]
    pub(crate) spectra: Values,
    /// Draw these readings beside the model: a CSV file as the fit reads it. They are divided by the scale of the fit.
    #[arg(long, value_name = "DATA.csv")]
    pub(crate) data: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct DrawingArgs {
    /// Folder of the charts, made if it is missing [default: the folder of the fit, or fits/<name of the preset>].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print no report and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
}
