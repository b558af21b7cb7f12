//! Sine and cosine up to sign, as polynomials without branches, which compilers turn into vector code.
//!
//! Interference needs only squares of them. The system library's calls cost ten times a multiplication chain and keep a
//! loop from being vectorised.

use crate::numerics::fused::mul_add;
use std::f64::consts::{FRAC_1_PI, PI};

/// 1.5 · 2^52: adding and subtracting it rounds to an integer without a call.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// π in three parts; the first two have so few bits that their products with integers below 2^20 are exact.
const PI_PARTS: [f64; 3] = [3.141_592_621_803_283_7, 3.178_650_942_459_171_3e-8, 1.224_646_786_410_718_8e-16];
/// What π is more than its nearest number: all that is left of it after a product that is not rounded.
const PI_REST: f64 = 1.224_646_799_147_353_2e-16;

/// Coefficients of `cos(sqrt(z))` on the reduced range, through its values at Chebyshev's nodes: to 7e-17, two fewer than
/// Taylor's series needs.
const COSINE: [f64; TERMS] = [
    1.0,
    -4.999_999_999_999_997e-1,
    4.166_666_666_666_388e-2,
    -1.388_888_888_877_292e-3,
    2.480_158_727_740_290_5e-5,
    -2.755_731_638_990_004_4e-7,
    2.087_656_178_187_851_7e-9,
    -1.146_290_035_068_704_4e-11,
    4.608_960_242_324_344_4e-14,
];
/// The same of `sin(sqrt(z)) / sqrt(z)`, to 2e-17.
const SINE: [f64; TERMS] = [
    1.0,
    -1.666_666_666_666_666_6e-1,
    8.333_333_333_333_186e-3,
    -1.984_126_984_120_863_8e-4,
    2.755_731_921_122_325_7e-6,
    -2.505_210_688_997_513e-8,
    1.605_894_084_783_249_2e-10,
    -7.643_025_738_964_345e-13,
    2.721_566_092_112_559_7e-15,
];
const TERMS: usize = 9;

/// `x` less the nearest multiple of π, for `|x|` below a million.
#[inline(always)]
fn reduced<const FUSED: bool>(x: f64) -> f64 {
    let multiple = mul_add::<FUSED>(x, FRAC_1_PI, ROUND) - ROUND;
    if FUSED {
        // The first difference is exact: a multiple of 2^-52 below 2.
        mul_add::<FUSED>(-multiple, PI_REST, mul_add::<FUSED>(-multiple, PI, x))
    } else {
        ((x - multiple * PI_PARTS[0]) - multiple * PI_PARTS[1]) - multiple * PI_PARTS[2]
    }
}

#[inline(always)]
fn polynomial<const FUSED: bool>(coefficients: &[f64; TERMS], z: f64) -> f64 {
    let mut sum = coefficients[TERMS - 1];
    for coefficient in coefficients[..TERMS - 1].iter().rev() {
        sum = mul_add::<FUSED>(sum, z, *coefficient);
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
    let r = reduced::<false>(x);
    polynomial::<false>(&COSINE, r * r)
}

/// `(sin(x), cos(x))` or both with the other sign, each to 4e-16, for `|x|` below a million; for code compiled with fused multiply-add,
/// if `FUSED`.
#[inline(always)]
pub(crate) fn sin_cos_fused<const FUSED: bool>(x: f64) -> (f64, f64) {
    let r = reduced::<FUSED>(x);
    let z = r * r;
    (r * polynomial::<FUSED>(&SINE, z), polynomial::<FUSED>(&COSINE, z))
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
            let (sin, cos) = sin_cos_fused::<false>(x);
            worst = worst.max((sin.abs() - x.sin().abs()).abs());
            worst = worst.max((sin * cos - x.sin() * x.cos()).abs());
            let (sin, cos) = sin_cos_fused::<true>(x);
            worst = worst.max((cos.abs() - x.cos().abs()).abs()).max((sin.abs() - x.sin().abs()).abs());
            worst = worst.max((sin * cos - x.sin() * x.cos()).abs());
        }
        assert!(worst < 4e-16, "{worst:e}");
    }

    #[test]
    fn a_small_argument_keeps_its_relative_accuracy() {
        for x in [1e-300, 1e-9, 1e-3] {
            assert!((sin_cos_fused::<false>(x).0 / x.sin() - 1.0).abs() < 4e-16);
        }
    }
}
