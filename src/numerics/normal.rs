//! The standard normal distribution.

/// `x` at which the standard normal distribution reaches `probability`.
///
/// ```text
/// Phi(x) = probability,   Phi(x) = 1/2 erfc(-x / sqrt(2))
/// ```
///
/// Relative error about 1e-16. `None` unless `0 < probability < 1`.
///
/// # Source
/// Wichura 1988, algorithm AS 241, PPND16, DOI 10.2307/2347330.
///
/// ```
/// use morpho_fit::numerics::normal::normal_quantile;
/// assert!((normal_quantile(0.975).unwrap() - 1.959963984540054).abs() < 1e-15);
/// assert!(normal_quantile(1.0).is_none());
/// ```
#[must_use]
pub fn normal_quantile(probability: f64) -> Option<f64> {
    if !(probability > 0.0 && probability < 1.0) {
        return None;
    }
    let centred = probability - 0.5;
    if centred.abs() <= 0.425 {
        let r = 0.180_625 - centred * centred;
        return Some(centred * ratio(&CENTRE, r));
    }
    let tail = probability.min(1.0 - probability);
    let r = (-tail.ln()).sqrt();
    let size = if r <= 5.0 { ratio(&MIDDLE, r - 1.6) } else { ratio(&FAR, r - 5.0) };
    Some(size.copysign(centred))
}

/// Coefficients of a ratio of polynomials, the constants first.
type Rational = ([f64; 8], [f64; 8]);

fn ratio((above, below): &Rational, x: f64) -> f64 {
    let polynomial = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    polynomial(above) / polynomial(below)
}

/// For probabilities within 0.425 of 1/2.
const CENTRE: Rational = (
    [
        3.387_132_872_796_366_5,
        1.331_416_678_917_843_8e2,
        1.971_590_950_306_551_3e3,
        1.373_169_376_550_946e4,
        4.592_195_393_154_987e4,
        6.726_577_092_700_87e4,
        3.343_057_558_358_813e4,
        2.509_080_928_730_122_7e3,
    ],
    [
        1.0,
        4.231_333_070_160_091e1,
        6.871_870_074_920_579e2,
        5.394_196_021_424_751e3,
        2.121_379_430_158_659_7e4,
        3.930_789_580_009_271e4,
        2.872_908_573_572_194_3e4,
        5.226_495_278_852_545e3,
    ],
);
/// For tails down to `exp(-25)`.
const MIDDLE: Rational = (
    [
        1.423_437_110_749_683_5,
        4.630_337_846_156_546,
        5.769_497_221_460_691,
        3.647_848_324_763_204_5,
        1.270_458_252_452_368_4,
        2.417_807_251_774_506e-1,
        2.272_384_498_926_918_4e-2,
        7.745_450_142_783_414e-4,
    ],
    [
        1.0,
        2.053_191_626_637_759,
        1.676_384_830_183_803_8,
        6.897_673_349_851e-1,
        1.481_039_764_274_800_8e-1,
        1.519_866_656_361_645_7e-2,
        5.475_938_084_995_345e-4,
        1.050_750_071_644_416_9e-9,
    ],
);
/// For tails beyond.
const FAR: Rational = (
    [
        6.657_904_643_501_103,
        5.463_784_911_164_114,
        1.784_826_539_917_291_3,
        2.965_605_718_285_048_7e-1,
        2.653_218_952_657_612_4e-2,
        1.242_660_947_388_078_4e-3,
        2.711_555_568_743_487_6e-5,
        2.010_334_399_292_288_1e-7,
    ],
    [
        1.0,
        5.998_322_065_558_88e-1,
        1.369_298_809_227_358e-1,
        1.487_536_129_085_061_5e-2,
        7.868_691_311_456_133e-4,
        1.846_318_317_510_054_8e-5,
        1.421_511_758_316_446e-7,
        2.044_263_103_389_939_8e-15,
    ],
);

/// Density of the standard normal distribution.
#[must_use]
pub fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt()
}

/// Share of the standard normal distribution below `x`, to 1e-15 of itself on either side.
///
/// ```
/// use morpho_fit::numerics::normal::distribution;
/// assert!((distribution(1.0) - distribution(-1.0) - 0.682_689_492_137_085_9).abs() < 1e-15);
/// ```
#[must_use]
pub fn distribution(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn quantiles_are_those_of_another_program() {
        // scipy 1.17.1, scipy.stats.norm.ppf
        for (probability, expected) in [
            (0.3, -0.5244005127080409),
            (0.92, 1.4050715603096329),
            (0.05, -1.6448536269514729),
            (0.001, -3.090232306167813),
            (1e-10, -6.361340902404056),
            (1e-12, -7.034483825301131),
            (1e-100, -21.273453560965322),
            (1e-300, -37.0470962993612),
        ] {
            assert_relative_eq!(normal_quantile(probability).unwrap(), expected, max_relative = 1e-14);
        }
    }

    #[test]
    fn quantiles_are_odd_about_one_half() {
        assert_relative_eq!(normal_quantile(0.5).unwrap(), 0.0);
        for probability in [0.4, 0.0625, 2.0_f64.powi(-20), 2.0_f64.powi(-45)] {
            assert_relative_eq!(
                normal_quantile(1.0 - probability).unwrap(),
                -normal_quantile(probability).unwrap(),
                max_relative = 1e-14
            );
        }
    }

    #[test]
    fn what_is_no_probability_has_no_quantile() {
        assert!([0.0, 1.0, -0.1, 1.1, f64::NAN, f64::INFINITY].into_iter().all(|p| normal_quantile(p).is_none()));
        assert!(normal_quantile(f64::MIN_POSITIVE).unwrap().is_finite());
    }
}
