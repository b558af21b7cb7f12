//! Measured reflectivity: CSV bytes in, checked readings out, and back.
//!
//! [`read_csv`] takes the bytes of a file and gives a [`Dataset`], or [`Findings`]: every defect of the file at once,
//! with its line and column. Nothing is repaired and nothing is dropped unsaid; what was read although it is unusual
//! (semicolons, decimal commas, a column that is not used) is in [`Dataset::notes`].
//!
//! Columns of the tidy form, one reading a row:
//!
//! | column | unit | |
//! |---|---|---|
//! | `wavelength_nm` | nm | column or [`Constants`] |
//! | `theta_deg`, `phi_deg`, `omega_deg` | degrees, -90 to 90 | column or [`Constants`] |
//! | `intensity` | as measured; a fitted scale makes it a reflectivity | column |
//! | `sigma` | as `intensity`, above 0 | optional; in every row or in none |
//! | `curve` | name of the record, which may have its own scale | optional |
//! | `polarization` | `s`, `p`, `unpolarized` | optional |
//!
//! Wide tables (first column `wavelength_nm`, one column for each angle or record) are read with
//! [`ReadOptions::wide`]; a file with many measurements, such as the pixels of a map, by [`split_csv`]. Cells are separated by commas, or else by the semicolons or tabs of the heading line; decimal
//! commas are read only where commas do not separate cells. Lines starting with `#` and blank lines are skipped.
//!
//! This module opens no file.

mod angles;
mod cells;
mod checks;
mod columns;
mod findings;
mod kind;
mod options;
mod parts;
mod read;
mod records;
mod rows;
#[cfg(test)]
mod tests;
mod text;
mod wide;
mod write;

pub use self::angles::note_on_angles;
pub use self::findings::{Column, Finding, Findings, Place};
pub use self::kind::{FindingKind, NumberHint};
pub use self::options::{Constants, ReadOptions, WideHeading};
pub use self::parts::{Part, SplitBy, split_csv};
pub use self::read::{check_headings, read_csv};
pub use self::write::{NotWide, to_csv, to_wide_csv};

use self::checks::{Seen, curve_name, hex_sha256};
use self::findings::Collector;
use self::options::PLAN;
use crate::geometry::{Geometry, Polarization};

/// One measured value and where it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Wavelength in vacuum, nm, 100 to 20000.
    pub wavelength: f64,
    /// Incidence, viewing and anisotropy angle, rad, each at most a quarter turn either way.
    pub geometry: Geometry,
    /// Which polarization was measured.
    pub polarization: Polarization,
    /// Measured intensity, proportional to the reflectivity; finite, and below 0 only through noise.
    pub intensity: f64,
    /// Standard deviation of `intensity`, in its unit, above 0.
    pub sigma: Option<f64>,
    /// Record the reading belongs to: an index into [`Dataset::curves`].
    pub curve: usize,
    /// Line of the file counting from 1, comments included; 0 for a reading that is not from a file.
    pub line: u64,
}

/// Readings that passed every check; there is no other way to hold one.
///
/// - at least one reading; every number finite and in the range that [`Reading`] gives
/// - no wavelength, geometry and polarization twice in one curve
/// - a sigma with every reading or with none
/// - curves have different names, and every curve has a reading
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, read_csv};
///
/// let csv = b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n\
///             450,0,30,90,0.42\n\
///             460,0,30,90,0.47\n";
/// let dataset = read_csv(csv, &ReadOptions::default())?;
/// assert_eq!(dataset.readings()[1].wavelength, 460.0);
/// assert_eq!(dataset.readings()[1].line, 3);
/// assert_eq!(dataset.curves(), ["data"]);
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    readings: Vec<Reading>,
    curves: Vec<String>,
    notes: Vec<String>,
    sha256: String,
    middle_wavelength: f64,
    largest: f64,
}

impl Dataset {
    /// A dataset from values instead of a file, under the same checks.
    ///
    /// `curves` are the names of the records that [`Reading::curve`] counts.
    ///
    /// The hash is that of eight 64-bit little-endian numbers for each reading (wavelength in nm, theta, phi and omega in rad,
    /// intensity, sigma or 0, polarization: 0 unpolarized, 1 s, 2 p, and curve; -0 as 0), then of each name and a line feed. In
    /// numpy these are the bytes `column_stack(columns).astype("<f8").tobytes() + b"data\n"` of eight columns and one curve.
    ///
    /// # Errors
    /// [`Findings`] with every reading that breaks a rule of [`Dataset`]; a reading with [`Reading::line`] 0 is named
    /// by its number, counting from 1.
    ///
    /// ```
    /// use morpho_fit::{dataset::{Dataset, Reading}, geometry::{Geometry, Polarization}};
    ///
    /// let reading = Reading {
    ///     wavelength: 0.45,
    ///     geometry: Geometry::default(),
    ///     polarization: Polarization::S,
    ///     intensity: 0.3,
    ///     sigma: None,
    ///     curve: 0,
    ///     line: 0,
    /// };
    /// let findings = Dataset::from_readings(vec![reading], vec!["blue".to_owned()]).unwrap_err();
    /// assert_eq!(
    ///     findings.to_string(),
    ///     "reading 1, `wavelength_nm`: 0.45 looks like micrometres; give nanometres, 100 to 20000"
    /// );
    /// ```
    pub fn from_readings(readings: Vec<Reading>, curves: Vec<String>) -> Result<Self, Findings> {
        let mut found = Collector::default();
        check_names(&curves, &mut found);
        if readings.is_empty() {
            found.push(None, None, FindingKind::NoReadings);
        }
        let any_sigma = readings.iter().any(|reading| reading.sigma.is_some());
        let mut seen = Seen::of(readings.len());
        let mut used = vec![false; curves.len()];
        for (index, reading) in readings.iter().enumerate() {
            let place = if reading.line > 0 { Place::Line(reading.line) } else { Place::Reading(index + 1) };
            let mut valid = true;
            for (name, kind) in checks::reading(reading, any_sigma) {
                valid = false;
                found.push(Some(place), Some(Column::named(name)), kind);
            }
            match used.get_mut(reading.curve) {
                Some(used) => *used = true,
                None => {
                    let kind = FindingKind::UnknownCurve { curve: reading.curve, curves: curves.len() };
                    found.push(Some(place), Some(Column::named("curve")), kind);
                }
            }
            if valid && let Some(first) = seen.first(reading, place) {
                found.push(Some(place), None, FindingKind::DuplicateReading { first });
            }
        }
        for (name, _) in curves.iter().zip(&used).filter(|(_, used)| !**used) {
            found.push(None, None, FindingKind::UnusedCurve { name: findings::excerpt(name) });
        }
        found.finish()?;
        let sha256 = hex_sha256(&bytes_of(&readings, &curves));
        Ok(Self::checked(readings, curves, Vec::new(), sha256))
    }

    fn checked(readings: Vec<Reading>, curves: Vec<String>, notes: Vec<String>, sha256: String) -> Self {
        let mut wavelengths: Vec<f64> = readings.iter().map(|reading| reading.wavelength).collect();
        let half = wavelengths.len() / 2;
        // There is at least one reading; no choice of a value stands for none.
        let middle_wavelength =
            if wavelengths.is_empty() { f64::NAN } else { *wavelengths.select_nth_unstable_by(half, f64::total_cmp).1 };
        let largest = readings.iter().map(|reading| reading.intensity.abs()).fold(0.0, f64::max);
        Self { readings, curves, notes, sha256, middle_wavelength, largest }
    }

    /// The readings, in the order of the file; at least one.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The median of the readings' wavelengths, nm.
    #[must_use]
    pub fn middle_wavelength(&self) -> f64 {
        self.middle_wavelength
    }

    /// Names of the records, by first appearance; one called `data` if the file names none.
    #[must_use]
    pub fn curves(&self) -> &[String] {
        &self.curves
    }

    /// Whether the readings come with a standard deviation: all of them, or none.
    #[must_use]
    pub fn has_sigma(&self) -> bool {
        self.readings.first().is_some_and(|reading| reading.sigma.is_some())
    }

    /// The largest intensity in size; 0 if all are 0.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// What the reader of the file should be told although nothing is wrong, one sentence each.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Whether it is a plan, whose intensities are all 0 because there are none: see [`ReadOptions::plan`].
    #[must_use]
    pub fn is_plan(&self) -> bool {
        self.notes.iter().any(|note| note == PLAN)
    }

    /// SHA-256 of the bytes that were read, or of the values where none were, 64 hexadecimal digits.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

/// What the hash of values is of; text would take ten times as long as a fit.
fn bytes_of(readings: &[Reading], curves: &[String]) -> Vec<u8> {
    let names = curves.iter().map(|name| name.len() + 1).sum::<usize>();
    let mut bytes = Vec::with_capacity(readings.len() * 64 + names);
    for reading in readings {
        let Geometry { theta, phi, omega } = reading.geometry;
        let polarization = match reading.polarization {
            Polarization::Unpolarized => 0.0,
            Polarization::S => 1.0,
            Polarization::P => 2.0,
        };
        #[allow(clippy::cast_precision_loss, reason = "counts of curves are below 2^53")]
        let curve = reading.curve as f64;
        let sigma = reading.sigma.unwrap_or(0.0);
        let values = [reading.wavelength, theta, phi, omega, reading.intensity, sigma, polarization, curve];
        // Adding 0 turns -0 into 0: one measurement has one hash.
        bytes.extend_from_slice(values.map(|value| (value + 0.0).to_le_bytes()).as_flattened());
    }
    for name in curves {
        bytes.extend_from_slice(name.as_bytes());
        bytes.push(b'\n');
    }
    bytes
}

fn check_names(curves: &[String], found: &mut Collector) {
    for (index, name) in curves.iter().enumerate() {
        if let Err(kind) = curve_name(name) {
            found.push(None, Some(Column::named("curve")), kind);
        }
        if curves.iter().take(index).any(|earlier| earlier == name) {
            found.push(None, None, FindingKind::DuplicateCurve { name: findings::excerpt(name) });
        }
    }
}
