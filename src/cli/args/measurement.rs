//! A simulated measurement.

use crate::args::{ModelArgs, StructureArgs, WideWord};
use crate::scans::ScanRequest;
use crate::values;
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    pub(crate) structure: StructureArgs,
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    #[command(flatten)]
    pub(crate) measurement: MeasurementArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Measurement")]
pub(crate) struct MeasurementArgs {
    /// One record, every combination of its values: `wavelength=380:740:10,theta=0,phi=-60:60:5,omega=0|90`, with
    /// START:STOP:STEP for a range (both ends included) and | between single values; wavelengths in nm, angles in
    /// degrees (0 where left out); `polarization=s` and `name=...` if wanted. May be repeated. Default: a spectrum and an
    /// angular scan in each plane, 172 readings.
    #[arg(long, value_name = "DESIGN", value_parser = crate::scans::parse)]
    pub(crate) scan: Vec<ScanRequest>,
    /// Standard deviation of the noise as a share of the largest intensity.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// Factor on all intensities.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) scale: f64,
    /// Seed of the noise: the same seed gives the same file.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Add the noise but leave its standard deviation out of the file.
    #[arg(long)]
    pub(crate) no_sigma: bool,
    /// Write a wide table with these headings.
    #[arg(long, value_name = "HEADINGS")]
    pub(crate) wide: Option<WideWord>,
    /// File to write [default: standard output].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}
