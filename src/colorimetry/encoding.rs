//! The transfer functions of RGB spaces: from linear light to the value that is stored.
//!
//! Both are a straight line near black and a power above. A library's `powf` costs more than the whole integral of a
//! spectrum and keeps a loop from being vectorised; three square roots and a polynomial in `x^(1/8)` do not.
//!
//! # Source
//! sRGB and Display P3: IEC 61966-2-1:1999. Rec. 2020: ITU-R BT.2020-2, table 4, with the two constants to the digits that
//! make the function continuous.

use multiversion::multiversion;

/// Half-way of the range of `x^(1/8)` on which the polynomials hold, which is 0.48 to 1 (`x` from 0.0028).
const MIDDLE: f64 = 0.74;

/// Chebyshev interpolation of `s^(10/3)` in 11 nodes on 0.48 to 1, in powers of `s - 0.74`; error below 1e-12.
const SRGB_POWER: [f64; 11] = [
    0.366_526_797_642_668_16,
    1.651_021_610_973_622_4,
    2.602_961_999_354_406_4,
    1.563_340_548_808_725,
    0.176_051_855_094_200_15,
    -0.031_721_769_708_385_82,
    0.011_907_924_616_994_874,
    -0.006_106_098_305_360_936,
    0.003_775_944_012_558_263_3,
    -0.003_001_734_891_366_851,
    0.002_334_100_217_917_782,
];
/// The same of `s^3.6`.
const REC2020_POWER: [f64; 11] = [
    0.338_247_185_064_473_65,
    1.645_526_846_234_272,
    2.890_790_405_612_192_2,
    2.083_452_552_044_932_7,
    0.422_321_455_474_830_74,
    -0.045_656_989_441_595_43,
    0.014_396_670_989_148_187,
    -0.006_649_500_922_609_459,
    0.003_813_499_525_768_717,
    -0.002_826_086_192_735_015_7,
    0.002_094_697_431_688_681,
];

/// `slope x` up to `threshold`, `gain x^exponent - (gain - 1)` above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transfer {
    threshold: f64,
    slope: f64,
    gain: f64,
    exponent: f64,
    power: [f64; 11],
}

/// sRGB and Display P3.
pub(super) const SRGB: Transfer =
    Transfer { threshold: 0.003_130_8, slope: 12.92, gain: 1.055, exponent: 1.0 / 2.4, power: SRGB_POWER };
/// Rec. 2020 and Rec. 709.
pub(super) const REC2020: Transfer = Transfer {
    threshold: 0.018_053_968_510_807,
    slope: 4.5,
    gain: 1.099_296_826_809_44,
    exponent: 0.45,
    power: REC2020_POWER,
};

impl Transfer {
    /// The value stored for `linear`; the straight line goes on below 0, the power above 1.
    pub(super) fn encode(&self, linear: f64) -> f64 {
        if linear > 1.0 {
            self.gain * linear.powf(self.exponent) - (self.gain - 1.0)
        } else if linear < 0.0 {
            self.slope * linear
        } else {
            self.within(linear)
        }
    }

    /// The value stored for `linear` between 0 and 1, without a branch and with an error below 1.1e-12.
    #[inline(always)]
    fn within(&self, linear: f64) -> f64 {
        let s = linear.sqrt().sqrt().sqrt() - MIDDLE;
        let mut power = self.power[10];
        for coefficient in self.power[..10].iter().rev() {
            power = power * s + coefficient;
        }
        let above = self.gain * power - (self.gain - 1.0);
        // The polynomial leaves 1 by its own error at the end of its range.
        if linear <= self.threshold { self.slope * linear } else { above.min(1.0) }
    }
}

/// Replaces each linear value by the stored one, clipped to 0 to 1; the same bits with all vector instructions.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn clip_and_encode(transfer: &Transfer, values: &mut [f64]) {
    for value in values {
        *value = transfer.within(value.clamp(0.0, 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomials_are_the_system_librarys_power() {
        for transfer in [SRGB, REC2020] {
            let mut worst = 0.0_f64;
            for step in 0..=1_000_000 {
                let x = f64::from(step) * 1e-6;
                let power = transfer.gain * x.powf(transfer.exponent) - (transfer.gain - 1.0);
                let exact = if x <= transfer.threshold { transfer.slope * x } else { power };
                worst = worst.max((transfer.within(x) - exact).abs());
            }
            assert!(worst < 1.1e-12, "{worst:e}");
        }
    }

    #[test]
    fn line_and_power_meet_where_the_standards_say() {
        // IEC 61966-2-1 rounds its threshold: a step of 3e-8. The constants of BT.2020 are exact.
        for (transfer, step) in [(SRGB, 4e-8), (REC2020, 2e-12)] {
            let x = transfer.threshold;
            assert!((transfer.encode(x.next_up()) - transfer.encode(x)).abs() < step);
            assert!((transfer.encode(1.0) - 1.0).abs() < 2e-12 && transfer.encode(1.0) <= 1.0);
            assert!((transfer.encode(1.0_f64.next_up()) - 1.0).abs() < 1e-12);
            assert!(transfer.encode(0.0).abs() < 1e-300 && transfer.encode(-0.5) < -1.0);
        }
    }

    #[test]
    fn many_values_have_the_bits_of_one() {
        for transfer in [SRGB, REC2020] {
            let linear: Vec<f64> = (0..1003).map(|step| f64::from(step) * 1.1e-3 - 0.05).collect();
            let mut many = linear.clone();
            clip_and_encode(&transfer, &mut many);
            for (x, encoded) in linear.into_iter().zip(many) {
                assert_eq!(encoded.to_bits(), transfer.encode(x.clamp(0.0, 1.0)).to_bits(), "{x}");
            }
        }
    }
}
