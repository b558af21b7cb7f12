//! Angles in degrees that may be radians.

use super::Reading;
use crate::units::degrees;

/// Different angles that make a scan.
const SCAN: usize = 5;
/// A scan that reaches less far, 0.5 rad or 29 degrees, is not taken for one in radians.
const LEAST_RADIANS: f64 = 0.5;
/// No angle in radians is beyond a quarter turn.
const MOST_RADIANS: f64 = 1.58;

/// A note on a scan whose angles of incidence or view end where those in radians do.
#[must_use]
pub fn note_on_angles(readings: &[Reading]) -> Option<String> {
    let angles = |of: fn(&Reading) -> f64| readings.iter().map(move |reading| degrees(of(reading)));
    let columns = [|reading: &Reading| reading.geometry.theta, |reading: &Reading| reading.geometry.phi];
    let most = columns.iter().flat_map(|of| angles(*of)).map(f64::abs).fold(0.0, f64::max);
    let is_scan = |of| {
        let mut values: Vec<f64> = Vec::with_capacity(SCAN);
        angles(of).any(|angle| {
            if !values.contains(&angle) {
                values.push(angle);
            }
            values.len() == SCAN
        })
    };
    let likely = (LEAST_RADIANS..=MOST_RADIANS).contains(&most) && columns.into_iter().any(is_scan);
    likely.then(|| format!("no theta or phi is beyond {most:.2} degrees: if they are radians, write them in degrees"))
}
