//! Directions and the unit square of half vectors.
//!
//! ```text
//! x = sqrt(2 theta / pi),   y = (phi + pi) / (2 pi)
//! dω_o = 4 (w_i · m) dω_m = 4 (w_i · m) · 2 pi² x sin(theta_m) dx dy
//! ```

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Squared lengths of a unit vector, to the rounding of a file with seven digits.
const UNIT: std::ops::RangeInclusive<f64> = 1.0 - 1e-6..=1.0 + 1e-6;

pub(super) fn is_unit(vector: [f64; 3]) -> bool {
    UNIT.contains(&dot(vector, vector))
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Of the angle from the normal and the azimuth, rad.
pub(super) fn direction(theta: f64, phi: f64) -> [f64; 3] {
    let ((sin, cos), (y, x)) = (theta.sin_cos(), phi.sin_cos());
    [sin * x, sin * y, cos]
}

/// Angle from the normal and azimuth of a unit vector, rad; the angle keeps its digits near the normal.
pub(super) fn angles([x, y, z]: [f64; 3]) -> [f64; 2] {
    let chord = (x * x + y * y + (z - 1.0) * (z - 1.0)).sqrt();
    [2.0 * (0.5 * chord).min(1.0).asin(), y.atan2(x)]
}

/// The half vector of two directions; none where they are opposite.
pub(super) fn half(a: [f64; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let sum: [f64; 3] = std::array::from_fn(|axis| a[axis] + b[axis]);
    let length = dot(sum, sum).sqrt();
    (length > 0.0).then(|| sum.map(|part| part / length))
}

/// The mirror image of `of` about `normal`, above the horizon on the side of the normal; none elsewhere.
pub(super) fn mirrored(of: [f64; 3], normal: [f64; 3]) -> Option<[f64; 3]> {
    let along = dot(of, normal);
    let image: [f64; 3] = std::array::from_fn(|axis| 2.0 * along * normal[axis] - of[axis]);
    (along > 0.0 && image[2] > 0.0).then_some(image)
}

/// Place in the unit square of an angle from the normal and an azimuth, which is taken modulo a turn.
pub(super) fn square(theta: f64, phi: f64) -> [f64; 2] {
    let turns = (phi + PI) / TAU;
    [(theta / FRAC_PI_2).max(0.0).sqrt(), turns - turns.floor()]
}

/// Angle from the normal and azimuth of a place in the unit square.
pub(super) fn unsquare([x, y]: [f64; 2]) -> [f64; 2] {
    [x * x * FRAC_PI_2, (2.0 * y - 1.0) * PI]
}

/// `dω_o / (dx dy)`, sr: solid angle of the mirrored direction by area of the unit square.
pub(super) fn jacobian(x: f64, theta: f64, cos_between: f64) -> f64 {
    2.0 * PI * PI * x * theta.sin() * 4.0 * cos_between
}
