//! CIELAB, and how different two colours look.

use super::error::ColourError;
use super::tristimulus::Xyz;
use palette::color_difference::Ciede2000;
use palette::convert::FromColorUnclamped;
use palette::white_point::E;

/// A colour in CIE 1976 L\*a\*b\*.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lab {
    /// Lightness, 0 for black to 100 for the white.
    pub l: f64,
    /// Redness, negative for green.
    pub a: f64,
    /// Yellowness, negative for blue.
    pub b: f64,
}

impl Lab {
    /// `colour` as an eye sees it that takes `white` for white.
    ///
    /// ```text
    /// L = 116 f(Y/Yn) - 16,   a = 500 (f(X/Xn) - f(Y/Yn)),   b = 200 (f(Y/Yn) - f(Z/Zn))
    /// f(t) = t^(1/3) above (6/29)^3, and the tangent there below
    /// ```
    ///
    /// # Source
    /// ISO/CIE 11664-4:2019; the formula is `palette`'s.
    ///
    /// # Errors
    /// [`ColourError`] if a value is not finite, or the white not above 0.
    ///
    /// ```
    /// use morpho_fit::colorimetry::{Lab, Xyz};
    /// let white = Xyz { x: 0.9505, y: 1.0, z: 1.089 };
    /// let grey = Lab::new(Xyz { x: 0.17109, y: 0.18, z: 0.19602 }, white)?;
    /// assert!((grey.l - 49.4961).abs() < 1e-4 && grey.a.abs() < 1e-9 && grey.b.abs() < 1e-9);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn new(colour: Xyz, white: Xyz) -> Result<Self, ColourError> {
        let (colour, white) = (colour.finite()?, white.as_white()?);
        // Only ratios to the white count, so that palette's white point of 1, 1, 1 serves every white.
        let relative = palette::Xyz::<E, f64>::new(colour.x / white.x, colour.y / white.y, colour.z / white.z);
        let lab = palette::Lab::<E, f64>::from_color_unclamped(relative);
        for (index, found) in [lab.l, lab.a, lab.b].into_iter().enumerate() {
            if !found.is_finite() {
                return Err(ColourError::NotFinite { quantity: "CIELAB coordinate", index, found });
            }
        }
        Ok(Self { l: lab.l, a: lab.a, b: lab.b })
    }

    /// Colour difference CIEDE2000 with all weights 1; about 1 is just noticeable.
    ///
    /// Symmetric, and continuous but where the hues are opposite. Infinite where a coordinate is not a finite number or is so
    /// large that the formula's seventh power of it is not.
    ///
    /// # Source
    /// Sharma, Wu, Dalal 2005, DOI 10.1002/col.20070; the formula is `palette`'s.
    ///
    /// ```
    /// use morpho_fit::colorimetry::Lab;
    /// let (one, other) = (Lab { l: 50.0, a: 2.6772, b: -79.7751 }, Lab { l: 50.0, a: 0.0, b: -82.7485 });
    /// assert!((one.difference(other) - 2.0425).abs() < 1e-4); // pair 1 of the paper
    /// ```
    #[must_use]
    pub fn difference(self, other: Self) -> f64 {
        let of = |lab: Self| palette::Lab::<E, f64>::new(lab.l, lab.a, lab.b);
        let difference = of(self).difference(of(other));
        if difference.is_finite() { difference } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_white_is_100_and_neutral_and_black_is_0() {
        let white = Xyz { x: 1.0985, y: 1.0, z: 0.3558 };
        let lab = Lab::new(white, white).unwrap();
        assert_relative_eq!(lab.l, 100.0, epsilon = 1e-12);
        assert!(lab.a.abs() < 1e-12 && lab.b.abs() < 1e-12);
        let black = Lab::new(Xyz::default(), white).unwrap();
        assert!(black.l.abs() < 1e-12 && black.a.abs() < 1e-12 && black.b.abs() < 1e-12, "{black:?}");
    }

    #[test]
    fn a_difference_is_never_no_number() {
        let grey = Lab { l: 50.0, a: 0.0, b: 0.0 };
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
            for other in [Lab { l: bad, ..grey }, Lab { a: bad, ..grey }, Lab { b: bad, ..grey }] {
                for difference in [grey.difference(other), other.difference(grey), other.difference(other)] {
                    assert!(!difference.is_nan() && difference >= 0.0, "{other:?}: {difference}");
                }
                assert!(grey.difference(other) > 1e3);
            }
        }
        assert!(grey.difference(grey).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_colour_is_refused() {
        let white = Xyz { x: 0.95, y: 1.0, z: 1.09 };
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(Lab::new(Xyz { x: bad, y: 0.5, z: 0.5 }, white).is_err());
            assert!(Lab::new(white, Xyz { z: bad, ..white }).is_err());
        }
        assert!(Lab::new(white, Xyz::default()).is_err());
        assert!(Lab::new(white, Xyz { x: 1e-308, ..white }).is_ok());
        assert!(Lab::new(Xyz { x: 1e308, ..white }, Xyz { x: 1e-308, ..white }).is_err());
    }
}
