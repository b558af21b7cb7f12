//! A decay and what it leaves out, as polynomials without branches, which compilers turn into vector code.

use crate::numerics::fused::mul_add;
use std::f64::consts::LOG2_E;

/// 1.5 · 2^52: adding it leaves the nearest integer in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts; the products of the first with integers below 2^20 are exact.
const LN_2_PARTS: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// `1/13!` to `1/2!`: what is left out of the series is below 4e-18 where `|r| <= ln(2) / 2`.
const SERIES: [f64; 12] = [
    1.605_904_383_682_161_3e-10,
    2.087_675_698_786_81e-9,
    2.505_210_838_544_172e-8,
    2.755_731_922_398_589e-7,
    2.755_731_922_398_589_3e-6,
    2.480_158_730_158_73e-5,
    1.984_126_984_126_984e-4,
    1.388_888_888_888_889e-3,
    8.333_333_333_333_333e-3,
    4.166_666_666_666_666_4e-2,
    0.166_666_666_666_666_66,
    0.5,
];
/// Beyond it a decay is below 1e-300, and is taken for what it is here.
const LARGEST: f64 = 700.0;

/// `(exp(-x), 1 - exp(-x))` for `x >= 0`, each to 4e-16 of its size; for code compiled with fused multiply-add, if `FUSED`.
#[inline(always)]
pub(crate) fn decay<const FUSED: bool>(x: f64) -> (f64, f64) {
    let x = if x < LARGEST { x } else { LARGEST };
    let shifted = mul_add::<FUSED>(x, LOG2_E, ROUND);
    let halvings = shifted - ROUND;
    // exp(-x) = 2^-halvings exp(r)
    let r = mul_add::<FUSED>(halvings, LN_2_PARTS[1], mul_add::<FUSED>(halvings, LN_2_PARTS[0], -x));
    let mut sum = SERIES[0];
    for term in &SERIES[1..] {
        sum = mul_add::<FUSED>(sum, r, *term);
    }
    let less_one = mul_add::<FUSED>(sum, r * r, r);
    let scale = f64::from_bits((1023 - (shifted.to_bits() & 0xffff)) << 52);
    (mul_add::<FUSED>(scale, less_one, scale), mul_add::<FUSED>(-scale, less_one, 1.0 - scale))
}

#[cfg(test)]
mod tests {
    use super::decay;

    #[test]
    fn both_agree_with_the_system_library() {
        let sizes = (-60_000..2900).map(|step| (f64::from(step) * 1e-3).exp2() * 90.0);
        for x in sizes.chain([0.0, 1e-300, 1e-17, 0.346, 0.347, 699.0]) {
            for (left, gone) in [decay::<false>(x), decay::<true>(x)] {
                let near = |found: f64, expected: f64| (found - expected).abs() <= 4e-16 * expected.abs();
                assert!(near(left, (-x).exp()) && near(gone, -(-x).exp_m1()), "{x}: {left} {gone}");
            }
        }
        assert!(decay::<false>(1e300).0 < 1e-300 && decay::<false>(f64::INFINITY).1 >= 1.0);
    }
}
