//! Units at the edge of the library: inside it every length is in nanometres and every angle in radians.
//!
//! A bare `f64` in this crate is in nanometres, in radians, or dimensionless. Users write degrees; these
//! two functions are the only place where one becomes the other. Nothing guesses a unit from a number's size.

/// Degrees to radians.
///
/// ```
/// assert_eq!(morpho_fit::units::radians(180.0), std::f64::consts::PI);
/// ```
#[must_use]
pub fn radians(degrees: f64) -> f64 {
    degrees.to_radians()
}

/// Radians to degrees.
///
/// ```
/// assert_eq!(morpho_fit::units::degrees(std::f64::consts::PI), 180.0);
/// ```
#[must_use]
pub fn degrees(radians: f64) -> f64 {
    radians.to_degrees()
}
