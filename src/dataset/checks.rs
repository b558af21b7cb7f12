//! What a value may be. The reader and [`Dataset::from_readings`](super::Dataset::from_readings) use the same rules.

use std::collections::hash_map::Entry;

use rustc_hash::{FxBuildHasher, FxHashMap};
use sha2::{Digest, Sha256};

use super::Reading;
use super::cells::plain;
use super::findings::{Place, excerpt};
use super::kind::FindingKind;
use crate::geometry::Polarization;
use crate::units::{degrees, radians};

/// Below this many "nanometres" a number is a wavelength in metres: 1e-3 m is far beyond the infrared.
const METRES_BELOW: f64 = 1e-3;
/// Below this many "nanometres" a number is a wavelength in micrometres: the same limit as [`LONGEST`].
const MICROMETRES_BELOW: f64 = 20.0;
/// Vacuum ultraviolet, nm: no dielectric stack reflects by structure below it.
const SHORTEST: f64 = 100.0;
/// Thermal infrared, nm: the widest range that reflectometers of this kind cover.
const LONGEST: f64 = 20_000.0;

pub(super) fn finite(value: f64) -> Result<(), FindingKind> {
    if value.is_finite() { Ok(()) } else { Err(FindingKind::NotFinite { found: plain(value) }) }
}

/// `found` in nm.
pub(super) fn wavelength(found: f64) -> Result<(), FindingKind> {
    finite(found)?;
    if found <= 0.0 {
        Err(FindingKind::WavelengthNotPositive { found })
    } else if found < METRES_BELOW {
        Err(FindingKind::WavelengthInMetres { found })
    } else if found < MICROMETRES_BELOW {
        Err(FindingKind::WavelengthInMicrometres { found })
    } else if !(SHORTEST..=LONGEST).contains(&found) {
        Err(FindingKind::WavelengthOutOfRange { found })
    } else {
        Ok(())
    }
}

/// `found` in degrees.
pub(super) fn angle_deg(found: f64) -> Result<(), FindingKind> {
    finite(found)?;
    if found.abs() > 90.0 { Err(FindingKind::AngleOutOfRange { found }) } else { Ok(()) }
}

/// `found` in radians; compared in radians, so that the radians of 90 degrees pass whatever the way back rounds to.
fn angle(found: f64) -> Result<(), FindingKind> {
    finite(found)?;
    if found.abs() > radians(90.0) { Err(FindingKind::AngleOutOfRange { found: degrees(found) }) } else { Ok(()) }
}

pub(super) fn sigma(found: f64) -> Result<(), FindingKind> {
    finite(found)?;
    if found <= 0.0 { Err(FindingKind::SigmaNotPositive { found }) } else { Ok(()) }
}

/// A name has to survive a CSV file, in which outer spaces are trimmed and control characters are defects.
pub(super) fn curve_name(name: &str) -> Result<(), FindingKind> {
    if name.is_empty() || name.trim() != name || name.chars().any(char::is_control) {
        return Err(FindingKind::CurveName { found: excerpt(name) });
    }
    Ok(())
}

/// All that is wrong with the values of one reading, with the column each would be in.
pub(super) fn reading(reading: &Reading, sigma_expected: bool) -> impl Iterator<Item = (&'static str, FindingKind)> {
    let sigma = match reading.sigma {
        Some(found) => sigma(found),
        None if sigma_expected => Err(FindingKind::SigmaIncomplete),
        None => Ok(()),
    };
    [
        ("wavelength_nm", wavelength(reading.wavelength)),
        ("theta_deg", angle(reading.geometry.theta)),
        ("phi_deg", angle(reading.geometry.phi)),
        ("omega_deg", angle(reading.geometry.omega)),
        ("intensity", finite(reading.intensity)),
        ("sigma", sigma),
    ]
    .into_iter()
    .filter_map(|(name, result)| result.err().map(|kind| (name, kind)))
}

/// The readings met so far, to find the same measurement twice.
#[derive(Debug, Default)]
pub(super) struct Seen(FxHashMap<([u64; 4], Polarization, usize), Place>);

impl Seen {
    /// With room for `count` readings.
    pub(super) fn of(count: usize) -> Self {
        Self(FxHashMap::with_capacity_and_hasher(count, FxBuildHasher))
    }

    /// Where the same measurement was met first, if it was.
    pub(super) fn first(&mut self, reading: &Reading, place: Place) -> Option<Place> {
        let geometry = reading.geometry;
        // Adding 0 turns -0 into 0: they are one angle with two bit patterns.
        let bits = [reading.wavelength, geometry.theta, geometry.phi, geometry.omega].map(|x| (x + 0.0).to_bits());
        match self.0.entry((bits, reading.polarization, reading.curve)) {
            Entry::Occupied(first) => Some(*first.get()),
            Entry::Vacant(free) => {
                free.insert(place);
                None
            }
        }
    }
}

pub(super) fn hex_sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
