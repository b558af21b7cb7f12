//! Closed form of the periodic lossless stack: cost independent of the number of layers, no phase, no square root of R.
//!
//! One period (cuticle, gap) has the real characteristic matrix
//!
//! ```text
//! P = | m11    i m12 |    M periods: P^M = u P - v 1,  u = U_(M-1)(x),  v = U_(M-2)(x),  x = (m11 + m22) / 2
//!     | i m21  m22   |    U: Chebyshev polynomials of the second kind
//! R = N / (N + 4 Y_ambient Y_base),   N = (Y_ambient A11 - Y_base A22)^2 + (Y_ambient Y_base A12 - A21)^2,   A = P^M
//! ```
//!
//! # Source
//! Born and Wolf, *Principles of Optics*, §1.6.5; Yariv and Yeh, *Optical Waves in Crystals*, §6.2.

use crate::optics::multilayer::{Period, SAndP};
use crate::optics::stack::Media;
use std::f64::consts::TAU;

/// Where `u` passes this the stack transmits less than 1e-200: R is 1, and going on would overflow.
const OPAQUE: f64 = 1e100;

/// Cosine of the angle of travel in each medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cosines {
    pub(crate) ambient: f64,
    pub(crate) cuticle: f64,
    pub(crate) gap: f64,
    pub(crate) base: f64,
}

impl Cosines {
    /// Snell's law, `n sin = n_ambient sin(angle)`; `None` if a wave is evanescent or exactly along its layer.
    #[inline]
    pub(crate) fn refracted(media: &Media, angle: f64) -> Option<Self> {
        Self::of(media, angle.sin_cos())
    }

    /// [`Cosines::refracted`] by sine and cosine of the angle.
    #[inline]
    fn of(media: &Media, (sin, cos): (f64, f64)) -> Option<Self> {
        let inside = |n: f64| {
            // Where the medium is the ambient one the cosine is known exactly; 1 - sin² would lose it at grazing.
            let ratio = media.ambient / n;
            let squared = cos * cos + (1.0 - ratio) * (1.0 + ratio) * sin * sin;
            (squared > 0.0).then(|| squared.sqrt())
        };
        Some(Self {
            ambient: cos,
            cuticle: inside(media.cuticle.re)?,
            gap: inside(media.gap.re)?,
            base: inside(media.base.re)?,
        })
    }
}

/// The cosines at one angle and their derivatives by it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Incidence {
    pub(crate) cosines: Cosines,
    pub(crate) slopes: Cosines,
}

impl Incidence {
    /// As [`Cosines::refracted`].
    pub(crate) fn refracted(media: &Media, angle: f64) -> Option<Self> {
        Self::of(media, angle.sin_cos())
    }

    /// [`Incidence::refracted`] by sine and cosine of the angle.
    #[inline]
    pub(crate) fn of(media: &Media, (sin, cos): (f64, f64)) -> Option<Self> {
        let cosines = Cosines::of(media, (sin, cos))?;
        // cos_j² = 1 - (n_a/n_j)² sin²
        let slope = |n: f64, inside: f64| -(media.ambient / n).powi(2) * sin * cos / inside;
        let slopes = Cosines {
            ambient: -sin,
            cuticle: slope(media.cuticle.re, cosines.cuticle),
            gap: slope(media.gap.re, cosines.gap),
            base: slope(media.base.re, cosines.base),
        };
        Some(Self { cosines, slopes })
    }

    /// Derivatives of the admittances by the angle.
    pub(crate) fn admittance_slopes(&self, media: &Media, rule: Rule) -> Admittances {
        let of = |n: f64, cos: f64, slope: f64| rule.slope(n, cos) * slope;
        Admittances {
            ambient: of(media.ambient, self.cosines.ambient, self.slopes.ambient),
            cuticle: of(media.cuticle.re, self.cosines.cuticle, self.slopes.cuticle),
            gap: of(media.gap.re, self.cosines.gap, self.slopes.gap),
            base: of(media.base.re, self.cosines.base, self.slopes.base),
        }
    }
}

/// What stands for the tilted admittance of a medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rule {
    /// `n cos`, of s.
    S,
    /// The impedance `cos / n` in place of the admittance `n / cos` of p: the same R, finite at grazing.
    P,
    /// The mean of the admittances of s and p, as printed.
    Mean,
}

impl Rule {
    #[inline]
    pub(crate) fn value(self, n: f64, cos: f64) -> f64 {
        match self {
            Self::S => n * cos,
            Self::P => cos / n,
            Self::Mean => 0.5 * (n * cos + n / cos),
        }
    }

    /// Derivative by `cos`.
    #[inline]
    fn slope(self, n: f64, cos: f64) -> f64 {
        match self {
            Self::S => n,
            Self::P => n.recip(),
            Self::Mean => 0.5 * (n - n / (cos * cos)),
        }
    }
}

/// Tilted admittances of the four media; any common factor cancels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Admittances {
    pub(crate) ambient: f64,
    pub(crate) cuticle: f64,
    pub(crate) gap: f64,
    pub(crate) base: f64,
}

impl Admittances {
    /// The same rule for each medium.
    #[inline]
    pub(crate) fn each(media: &Media, cosines: &Cosines, rule: Rule) -> Self {
        Self {
            ambient: rule.value(media.ambient, cosines.ambient),
            cuticle: rule.value(media.cuticle.re, cosines.cuticle),
            gap: rule.value(media.gap.re, cosines.gap),
            base: rule.value(media.base.re, cosines.base),
        }
    }
}

/// Sine and cosine of the phase thickness of the two layers of a period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Phases {
    cuticle: (f64, f64),
    gap: (f64, f64),
}

impl Phases {
    /// `beta = 2 pi / wavelength · n d cos` for each layer.
    #[inline]
    pub(crate) fn new(media: &Media, cosines: &Cosines, period: Period) -> Self {
        let k = TAU / media.wavelength;
        Self {
            cuticle: (k * media.cuticle.re * period.cuticle * cosines.cuticle).sin_cos(),
            gap: (k * media.gap.re * period.gap * cosines.gap).sin_cos(),
        }
    }
}

/// `R_s` and `R_p`.
#[inline]
pub(crate) fn exact(media: &Media, cosines: &Cosines, period: Period, layers: usize) -> SAndP {
    let phases = Phases::new(media, cosines, period);
    SAndP {
        s: reflectivity(&Admittances::each(media, cosines, Rule::S), &phases, layers),
        p: reflectivity(&Admittances::each(media, cosines, Rule::P), &phases, layers),
    }
}

/// R of `layers` periods for one set of admittances.
#[inline]
pub(crate) fn reflectivity(y: &Admittances, phases: &Phases, layers: usize) -> f64 {
    let ((sin_c, cos_c), (sin_g, cos_g)) = (phases.cuticle, phases.gap);
    let (cc, ss) = (cos_c * cos_g, sin_c * sin_g);
    let ratio = y.gap / y.cuticle;
    let m11 = cc - ss * ratio;
    let m22 = cc - ss / ratio;
    let m12 = cos_c * sin_g / y.gap + sin_c * cos_g / y.cuticle;
    let m21 = y.cuticle * sin_c * cos_g + y.gap * cos_c * sin_g;
    let Some((u, v)) = power(m11 + m22, layers) else { return 1.0 };
    let real = y.ambient * (u * m11 - v) - y.base * (u * m22 - v);
    let imaginary = u * (y.ambient * y.base * m12 - m21);
    let numerator = real * real + imaginary * imaginary;
    let denominator = numerator + 4.0 * y.ambient * y.base;
    // 0/0 only where nothing travels into or out of the stack: grazing.
    if denominator > 0.0 { numerator / denominator } else { 1.0 }
}

/// `(U_(M-1)(x), U_(M-2)(x))` for `trace = 2 x` by doubling, in `2 log2 M` steps; `None` beyond [`OPAQUE`].
#[inline]
fn power(trace: f64, periods: usize) -> Option<(f64, f64)> {
    let (mut u, mut v) = (1.0_f64, 0.0_f64);
    let bits = usize::BITS - periods.leading_zeros();
    for bit in (0..bits.saturating_sub(1)).rev() {
        (u, v) = (u * (trace * u - 2.0 * v), (u - v) * (u + v));
        if (periods >> bit) & 1 == 1 {
            (u, v) = (trace * u - v, u);
        }
        if u.abs() > OPAQUE {
            return None;
        }
    }
    Some((u, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn doubling_gives_the_chebyshev_polynomials() {
        for trace in [-2.0, -1.3, 0.0, 0.7, 1.99, 2.0, 2.5] {
            let (mut u, mut v) = (1.0, 0.0);
            for periods in 1..40 {
                let (doubled_u, doubled_v) = power(trace, periods).unwrap();
                assert_relative_eq!(doubled_u, u, max_relative = 1e-12, epsilon = 1e-12);
                assert_relative_eq!(doubled_v, v, max_relative = 1e-12, epsilon = 1e-12);
                (u, v) = (trace * u - v, u);
            }
        }
    }

    #[test]
    fn an_opaque_stack_is_a_mirror_and_does_not_overflow() {
        assert_eq!(power(2.5, 3000), None);
        assert!(power(1.0, 3000).is_some());
    }
}
