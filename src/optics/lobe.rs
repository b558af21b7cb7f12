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

/// Derivatives of [`lobe`] by `delta` and by `phi_alpha`, 1/rad; 0 at the lobe's edges, where it has a kink.
///
/// ```
/// use morpho_fit::optics::lobe::{lobe, lobe_slopes};
/// let [by_delta, by_phi_alpha] = lobe_slopes(0.2, 0.1, 0.05, 0.5);
/// let step = 1e-6;
/// let difference = (lobe(0.2, 0.1, 0.05 + step, 0.5) - lobe(0.2, 0.1, 0.05 - step, 0.5)) / (2.0 * step);
/// assert!((by_delta - difference).abs() < 1e-9);
/// let difference = (lobe(0.2, 0.1, 0.05, 0.5 + step) - lobe(0.2, 0.1, 0.05, 0.5 - step)) / (2.0 * step);
/// assert!((by_phi_alpha - difference).abs() < 1e-9);
/// ```
#[must_use]
pub fn lobe_slopes(theta: f64, phi: f64, delta: f64, phi_alpha: f64) -> [f64; 2] {
    let offset = phi - (2.0 * delta - theta);
    if offset.abs() >= phi_alpha || !phi_alpha.is_finite() {
        return [0.0; 2];
    }
    let by_offset = -FRAC_PI_2 / phi_alpha * (FRAC_PI_2 * offset / phi_alpha).sin();
    [-2.0 * by_offset, -offset / phi_alpha * by_offset]
}
