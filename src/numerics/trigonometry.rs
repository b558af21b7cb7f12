//! Sine and cosine up to sign, as polynomials without branches, which compilers turn into vector code.
//!
//! Interference needs only squares of them. The system library's calls cost ten times a multiplication chain and keep a
//! loop from being vectorised.

use std::f64::consts::FRAC_1_PI;

/// 1.5 · 2^52: adding and subtracting it rounds to an integer without a call.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// π in three parts; the first two have so few bits that their products with integers below 2^20 are exact.
const PI_PARTS: [f64; 3] = [3.141_592_621_803_283_7, 3.178_650_942_459_171_3e-8, 1.224_646_786_410_718_8e-16];

/// Taylor coefficients of `cos(sqrt(z))`; the first one left out is below 2e-17 on the reduced range.
const COSINE: [f64; 11] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 6_402_373_705_728_000.0,
    1.0 / 2_432_902_008_176_640_000.0,
];
/// Taylor coefficients of `sin(sqrt(z)) / sqrt(z)`.
const SINE: [f64; 11] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
    -1.0 / 121_645_100_408_832_000.0,
    1.0 / 51_090_942_171_709_440_000.0,
];

/// `x` less the nearest multiple of π, for `|x|` below a million.
#[inline(always)]
fn reduced(x: f64) -> f64 {
    let multiple = (x * FRAC_1_PI + ROUND) - ROUND;
    ((x - multiple * PI_PARTS[0]) - multiple * PI_PARTS[1]) - multiple * PI_PARTS[2]
}

#[inline(always)]
fn polynomial(coefficients: &[f64; 11], z: f64) -> f64 {
    let mut sum = coefficients[10];
    for coefficient in coefficients[..10].iter().rev() {
        sum = sum * z + coefficient;
    }
    sum
}

/// `cos(x)` or `-cos(x)`, to 4e-16, for `|x|` below a million.
///
/// ```
/// use morpho_fit::numerics::trigonometry::cos_up_to_sign;
/// assert!((cos_up_to_sign(2.0).abs() - 2.0_f64.cos().abs()).abs() < 4e-16);
/// ```
#[must_use]
#[inline(always)]
pub fn cos_up_to_sign(x: f64) -> f64 {
    let r = reduced(x);
    polynomial(&COSINE, r * r)
}

/// `sin(x)` or `-sin(x)`, to 4e-16, for `|x|` below a million.
///
/// ```
/// use morpho_fit::numerics::trigonometry::sin_up_to_sign;
/// assert!((sin_up_to_sign(2.0).abs() - 2.0_f64.sin()).abs() < 4e-16);
/// ```
#[must_use]
#[inline(always)]
pub fn sin_up_to_sign(x: f64) -> f64 {
    let r = reduced(x);
    r * polynomial(&SINE, r * r)
}

/// `(sin(x), cos(x))` or both with the other sign, each to 4e-16, for `|x|` below a million.
///
/// ```
/// use morpho_fit::numerics::trigonometry::sin_cos_up_to_sign;
/// let (sin, cos) = sin_cos_up_to_sign(2.0);
/// assert!((sin * cos - 2.0_f64.sin() * 2.0_f64.cos()).abs() < 4e-16);
/// ```
#[must_use]
#[inline(always)]
pub fn sin_cos_up_to_sign(x: f64) -> (f64, f64) {
    let r = reduced(x);
    let z = r * r;
    (r * polynomial(&SINE, z), polynomial(&COSINE, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_agree_with_the_system_library() {
        let mut worst = 0.0_f64;
        for step in 0..200_000 {
            let x = f64::from(step - 100_000) * 1.234_567e-2;
            worst = worst.max((cos_up_to_sign(x).abs() - x.cos().abs()).abs());
            worst = worst.max((sin_up_to_sign(x).abs() - x.sin().abs()).abs());
            let (sin, cos) = sin_cos_up_to_sign(x);
            worst = worst.max((sin * cos - x.sin() * x.cos()).abs());
        }
        assert!(worst < 4e-16, "{worst:e}");
    }

    #[test]
    fn a_small_argument_keeps_its_relative_accuracy() {
        for x in [1e-300, 1e-9, 1e-3] {
            assert!((sin_up_to_sign(x) / x.sin() - 1.0).abs() < 4e-16);
        }
    }
}
