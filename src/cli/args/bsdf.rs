//! `.bsdf` files, written and read.

use crate::args::drawing::DrawingArgs;
use crate::args::{PolarizationWord, SubjectArgs};
use crate::scans::{self, Values};
use crate::values;
use clap::Args;
use std::path::PathBuf;

/// Root mean square error of a table unless another is asked for, and what else holds unless said otherwise.
pub(crate) const TOLERANCE: f64 = 0.018;
const WAVELENGTHS: [f64; 2] = [360.0, 830.0];
const MOST_BYTES: u64 = 256_000_000;
const DIRECTIONS: usize = 5000;
const SEED: u64 = 1;

#[derive(Debug, Args)]
pub(crate) struct BsdfArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) choice: BsdfChoiceArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Table")]
pub(crate) struct BsdfChoiceArgs {
    /// Root mean square error between the nodes, over directions and wavelengths with light, as a share of the largest value.
    #[arg(long, value_name = "SHARE", default_value_t = TOLERANCE, value_parser = values::positive)]
    pub(crate) tolerance: f64,
    /// First and last wavelength of the spectral file, nm: Mitsuba samples 360 to 830, and holds the ends beyond them. The file of
    /// colours is of 380 to 780 nm always.
    #[arg(long, value_name = "FIRST:LAST", default_value = "360:830", value_parser = ends)]
    pub(crate) wavelengths: [f64; 2],
    /// Polarization of the light, against the plane of incidence and view.
    #[arg(long, value_name = "WORD", default_value = "unpolarized")]
    pub(crate) polarization: PolarizationWord,
    /// Bytes of the largest file: a tolerance that asks for more is refused. About twice as many are held in memory.
    #[arg(long, value_name = "BYTES", default_value_t = MOST_BYTES)]
    pub(crate) max_bytes: u64,
    /// Random directions with light that the certificate compares table and model in, 100 to 100000000.
    #[arg(long, value_name = "COUNT", default_value_t = DIRECTIONS, value_parser = values::count)]
    pub(crate) directions: usize,
    /// Seed of these directions, and of those that the nodes are chosen at.
    #[arg(long, value_name = "SEED", default_value_t = SEED)]
    pub(crate) seed: u64,
}

impl BsdfChoiceArgs {
    /// The table that is asked for by its tolerance alone.
    pub(crate) fn within(tolerance: f64) -> Self {
        Self {
            tolerance,
            wavelengths: WAVELENGTHS,
            polarization: PolarizationWord::Unpolarized,
            max_bytes: MOST_BYTES,
            directions: DIRECTIONS,
            seed: SEED,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct ImportBsdfArgs {
    /// A spectral file of the RGL material database, or one that `morpho-fit bsdf` wrote.
    #[arg(value_name = "FILE.bsdf")]
    pub(crate) file: PathBuf,
    /// Planes of incidence and view, degrees from that across the ridges [default: 0|90, or 0 where the material is isotropic].
    #[arg(long, value_name = "DEG", value_parser = angles, allow_hyphen_values = true)]
    pub(crate) omega: Option<Values>,
    /// Angles of incidence, degrees from the normal (START:STOP:STEP for a range, | between single values, as in "0|20|40", in
    /// quotes in a shell).
    #[arg(long, value_name = "DEG", value_parser = angles, default_value = "0:60:15", allow_hyphen_values = true)]
    pub(crate) theta: Values,
    /// Viewing angles, degrees, the same way round as theta: the mirror direction is -theta.
    #[arg(long, value_name = "DEG", value_parser = angles, default_value = "-80:80:5", allow_hyphen_values = true)]
    pub(crate) phi: Values,
    /// Wavelengths, nm: FIRST:LAST keeps those of the file in that range; FIRST:LAST:STEP and values with | between them, as in "450|550", are
    /// linear between those of the file [default: all].
    #[arg(long, value_name = "FIRST:LAST[:STEP]", value_parser = wavelengths)]
    pub(crate) wavelengths: Option<WavelengthChoice>,
    /// Azimuth in the file of the direction across the ridges, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::number, default_value = "0", allow_negative_numbers = true)]
    pub(crate) across: f64,
    /// File to write [default: standard output].
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) out: Option<PathBuf>,
}

/// Which wavelengths of a file are wanted.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WavelengthChoice {
    /// Those of the file from the first to the last, nm.
    Within([f64; 2]),
    /// These, nm.
    At(Vec<f64>),
}

/// `FIRST:LAST`, nm.
fn ends(text: &str) -> Result<[f64; 2], String> {
    match *text.split(':').collect::<Vec<_>>().as_slice() {
        [first, last] => {
            let ends = [values::positive(first)?, values::positive(last)?];
            if ends[0] < ends[1] { Ok(ends) } else { Err(format!("{} is not below {}", ends[0], ends[1])) }
        }
        _ => Err(format!("`{text}` is not FIRST:LAST, such as 360:830")),
    }
}

fn wavelengths(text: &str) -> Result<WavelengthChoice, String> {
    if text.matches(':').count() == 1 && !text.contains('|') {
        return ends(text).map(WavelengthChoice::Within);
    }
    let Values(values) = scans::values(text)?;
    match values.iter().find(|value| **value <= 0.0) {
        Some(value) => Err(format!("{value} nm is not above 0")),
        None => Ok(WavelengthChoice::At(values)),
    }
}

fn angles(text: &str) -> Result<Values, String> {
    let values = scans::values(text)?;
    values.0.iter().try_for_each(|&value| values::within_angles(value))?;
    Ok(values)
}
