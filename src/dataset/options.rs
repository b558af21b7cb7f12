//! What the caller says about a file that the file does not say itself.

use crate::geometry::Polarization;

/// Quantities that are the same for every reading, given as flags instead of columns.
///
/// They carry the names and the units of the columns they replace; one that is also a column is a finding.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Constants {
    /// `--wavelength`: wavelength in vacuum, nm.
    pub wavelength_nm: Option<f64>,
    /// `--theta`: incidence angle, degrees.
    pub theta_deg: Option<f64>,
    /// `--phi`: viewing angle, degrees.
    pub phi_deg: Option<f64>,
    /// `--omega`: anisotropy angle, degrees.
    pub omega_deg: Option<f64>,
    /// `--sigma`: standard deviation of every reading, in the unit of `intensity`.
    pub sigma: Option<f64>,
    /// `--polarization`: what was measured; unpolarized light if neither a column nor a flag says.
    pub polarization: Option<Polarization>,
}

/// What the headings of a wide table are, after the first column `wavelength_nm`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WideHeading {
    /// Incidence angles in degrees: `30`, `30deg`, `theta_30`, `theta=-12.5`.
    Theta,
    /// Viewing angles in degrees: `30`, `30deg`, `phi_30`, `phi=-12.5`.
    Phi,
    /// Names of records.
    Curve,
}

/// The note of a file that is a plan.
pub(super) const PLAN: &str = "there is no column `intensity`: a plan of a measurement";

/// How to read a file.
///
/// ```
/// use morpho_fit::dataset::{Constants, ReadOptions, WideHeading, read_csv};
///
/// let options = ReadOptions {
///     constants: Constants { theta_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() },
///     wide: Some(WideHeading::Phi),
///     ..ReadOptions::default()
/// };
/// let dataset = read_csv(b"wavelength_nm,-30,30\n450,0.1,0.2\n", &options)?;
/// assert_eq!(dataset.readings().len(), 2);
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadOptions {
    /// Quantities given as flags.
    pub constants: Constants,
    /// Read a wide table with these headings; the tidy form if `None`.
    pub wide: Option<WideHeading>,
    /// Largest file to read, bytes; 1 GiB by default, which as readings takes a few times as much memory.
    pub max_bytes: u64,
    /// Number of free parameters: fewer readings are a finding; 0 by default.
    pub required_readings: usize,
    /// A file in the tidy form may be a plan, [`Dataset::is_plan`](super::Dataset::is_plan): it needs no column `intensity`, and where
    /// there is none, and none that could be it, all are 0. `false` by default.
    pub plan: bool,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self { constants: Constants::default(), wide: None, max_bytes: 1 << 30, required_readings: 0, plan: false }
    }
}
