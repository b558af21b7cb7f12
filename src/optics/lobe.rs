//! The lobe of Model B: curvature spreads the mirror beam of the tilted stack over viewing angles (paper section 2.3).
//!
//! ```text
//! L = cos(pi/2 · dphi / phi_alpha)  for |dphi| < phi_alpha, else 0,   dphi = phi - (2 delta - theta)
//! ```
//!
//! The paper leaves the mirror direction of the tilted stack open; `2 delta - theta` is ours. Not normalised: its
//! integral over `phi` is `4 phi_alpha / pi`, so `phi_alpha` and the scale of a curve are coupled.

use std::f64::consts::FRAC_PI_2;

/// The lobe's value in [0, 1] at incidence `theta` and view `phi` for tilt `delta` and half-width `phi_alpha`, all rad.
///
/// ```
/// use morpho_fit::optics::lobe::lobe;
/// assert_eq!(lobe(0.2, -0.1, 0.05, 0.5), 1.0); // on the mirror direction 2·0.05 - 0.2
/// assert_eq!(lobe(0.0, 0.7, 0.0, 0.5), 0.0);
/// ```
#[must_use]
#[inline]
pub fn lobe(theta: f64, phi: f64, delta: f64, phi_alpha: f64) -> f64 {
    let offset = phi - (2.0 * delta - theta);
    if offset.abs() < phi_alpha { (FRAC_PI_2 * offset / phi_alpha).cos() } else { 0.0 }
}
