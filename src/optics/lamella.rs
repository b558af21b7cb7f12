//! Model A: light diffracted by separate lamellae (paper section 2.2, after Kinoshita et al. 2002).
//!
//! ```text
//! I_A = factor · A(x, M)^2 · S(y)^2 · cos^2(theta)
//! A(x, M) = sin(M x) / (M sin x),   x = k d v / 2,   v = cos(theta) + cos(phi)
//! S(y)    = sin(y) / y,             y = k a u / 2,   u = sin(theta) + sin(phi),   k = 2 pi / wavelength
//! ```
//!
//! Every 0/0 of the printed form has its limit: `A = ±1` at `x = m pi`, `S = 1` at `y = 0`. The printed `cos^2(theta)`
//! is kept; it is not reciprocal. The path is that of the vacuum: Model A does not see the cuticle's index.

mod lanes;

use crate::numerics::trigonometry::cos_up_to_sign;
pub(crate) use lanes::{Lamella, LamellaNodes, diffraction, intensity, intensity_and_slopes, interference};
use std::f64::consts::{PI, TAU};

/// Up to so many layers the Chebyshev recurrence is taken: twice as fast as the ratio, and its rounding grows as
/// `M²/3`, to 1e-14 here.
pub(crate) const CHEBYSHEV_LAYERS: usize = 16;

/// `sin(M x) / (M sin x)`, the normalised amplitude of M equal waves with phase step `2 x`; at most 1 in size.
///
/// For many layers `x` is reduced to [-pi/2, pi/2] first, so the ratio keeps its accuracy next to each order and is 1
/// on it. The sign is lost: use the square. `|x|` below a million, which a gap of 0.1 mm does not reach.
///
/// ```
/// use morpho_fit::optics::lamella::array_factor;
/// assert_eq!(array_factor(0.0, 9), 1.0);
/// assert!((array_factor(0.1, 2) - 0.1_f64.cos()).abs() < 1e-15);
/// ```
#[must_use]
#[inline]
pub fn array_factor(x: f64, layers: usize) -> f64 {
    if layers <= CHEBYSHEV_LAYERS {
        return chebyshev([x], layers.max(1))[0];
    }
    let reduced = x - PI * (x * std::f64::consts::FRAC_1_PI).round();
    if reduced.abs() < f64::MIN_POSITIVE {
        return 1.0;
    }
    #[allow(clippy::cast_precision_loss, reason = "a layer count is far below 2^53")]
    let count = layers as f64;
    (count * reduced).sin() / (count * reduced.sin())
}

/// `sin(M x) / (M sin x) = U_(M-1)(cos x) / M` for several `x` at once: no ratio, and nothing to guard.
#[inline(always)]
pub(crate) fn chebyshev<const LANES: usize>(x: [f64; LANES], layers: usize) -> [f64; LANES] {
    let mut twice_cos = [0.0; LANES];
    for (twice_cos, x) in twice_cos.iter_mut().zip(x) {
        *twice_cos = 2.0 * cos_up_to_sign(x);
    }
    let (mut u, mut before) = ([1.0; LANES], [0.0; LANES]);
    for _ in 1..layers {
        for lane in 0..LANES {
            (u[lane], before[lane]) = (twice_cos[lane] * u[lane] - before[lane], u[lane]);
        }
    }
    #[allow(clippy::cast_precision_loss, reason = "at most 16")]
    let count = layers as f64;
    u.map(|u| u / count)
}

/// `sin(y) / y` up to sign, the amplitude of a slit; 1 at `y = 0`.
#[must_use]
#[inline(always)]
pub fn slit_factor(y: f64) -> f64 {
    lanes::slit::<false>(y)
}

/// The angles of one reading as Model A sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LamellaNode {
    /// `k v / 2`, 1/nm: the array factor is taken at this times the period.
    pub half_kv: f64,
    /// `k u / 2`, 1/nm: the slit factor is taken at this times the lamella width.
    pub half_ku: f64,
    /// `cos^2(theta)`.
    pub obliquity: f64,
}

impl LamellaNode {
    /// The node of incidence `theta` and view `phi` (rad) at `wavelength` (nm).
    #[must_use]
    pub fn new(wavelength: f64, theta: f64, phi: f64) -> Self {
        let (sin_theta, cos_theta) = theta.sin_cos();
        let (sin_phi, cos_phi) = phi.sin_cos();
        let half_k = 0.5 * TAU / wavelength;
        // At the mirror direction u is 0, which the sum of two rounded sines need not be.
        let u = if (theta + phi).abs() < f64::EPSILON { 0.0 } else { sin_theta + sin_phi };
        Self { half_kv: half_k * (cos_theta + cos_phi), half_ku: half_k * u, obliquity: cos_theta * cos_theta }
    }

    /// `A^2`, in [0, 1].
    #[must_use]
    #[inline]
    pub fn interference(&self, period: f64, layers: usize) -> f64 {
        let amplitude = array_factor(self.half_kv * period, layers);
        amplitude * amplitude
    }

    /// `S^2`, in [0, 1].
    #[must_use]
    #[inline]
    pub fn diffraction(&self, lamella_width: f64) -> f64 {
        let amplitude = slit_factor(self.half_ku * lamella_width);
        amplitude * amplitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    /// Table 1 at normal incidence, peak-normalised.
    fn table1(wavelength: f64, phi_deg: f64) -> f64 {
        let node = LamellaNode::new(wavelength, 0.0, phi_deg.to_radians());
        node.interference(235.0, 9) * node.diffraction(300.0) * node.obliquity
    }

    #[test]
    fn each_singular_point_has_its_limit() {
        let mirror = LamellaNode::new(480.0, 0.4, -0.4);
        assert_eq!(mirror.diffraction(300.0).to_bits(), 1.0_f64.to_bits(), "u = 0");
        let node = LamellaNode::new(480.0, 0.1, 0.3);
        assert_abs_diff_eq!(node.diffraction(1e-300), 1.0);
        assert_abs_diff_eq!(node.interference(0.0, 9), 1.0);
        let grazing = LamellaNode { half_kv: 0.0, half_ku: 0.01, obliquity: 0.0 };
        assert_abs_diff_eq!(grazing.interference(235.0, 9), 1.0);
        for order in 1..=3 {
            let on_order = LamellaNode::new(2.0 * 235.0 / f64::from(order), 0.0, 0.0);
            assert_abs_diff_eq!(on_order.interference(235.0, 9), 1.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_thousand_layers_keep_the_peak() {
        for layers in [1, 2, 9, 1000, 3000] {
            assert_abs_diff_eq!(array_factor(PI, layers).abs(), 1.0, epsilon = 1e-12);
            assert!(array_factor(1.234, layers).abs() <= 1.0);
        }
    }

    #[test]
    fn half_maxima_of_table_1_lie_where_independent_code_put_them() {
        // PHYSICS golden numbers: ±23.5° at 470 nm, ±19.4° at 480, ±13.5° at 500.
        for (wavelength, half_maximum) in [(470.0, 23.5), (480.0, 19.4), (500.0, 13.5)] {
            let half = table1(wavelength, 0.0) / 2.0;
            assert!(table1(wavelength, half_maximum - 0.1) > half && table1(wavelength, half_maximum + 0.1) < half);
        }
    }

    #[test]
    fn below_the_peak_wavelength_the_lobe_splits() {
        for (wavelength, maximum) in [(460.0, 12.2), (440.0, 26.9), (420.0, 36.3), (400.0, 43.9)] {
            let top = (0..900)
                .map(|tenth| f64::from(tenth) / 10.0)
                .max_by(|a, b| table1(wavelength, *a).total_cmp(&table1(wavelength, *b)));
            assert_abs_diff_eq!(top.unwrap(), maximum, epsilon = 0.11);
        }
    }
}
