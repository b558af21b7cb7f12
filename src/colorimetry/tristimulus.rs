//! Tristimulus values and chromaticity.

use super::error::ColourError;

/// A colour as a standard observer's X, Y, Z. This crate scales them so that a perfect white has Y = 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Xyz {
    /// X.
    pub x: f64,
    /// Y, the luminance factor.
    pub y: f64,
    /// Z.
    pub z: f64,
}

/// Chromaticity and luminance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct XyY {
    /// `x = X / (X + Y + Z)`.
    pub x: f64,
    /// `y = Y / (X + Y + Z)`.
    pub y: f64,
    /// Y, as in [`Xyz`].
    pub luminance: f64,
}

impl Xyz {
    /// From X, Y, Z in this order.
    #[must_use]
    pub fn from_array([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }

    /// X, Y, Z in this order.
    #[must_use]
    pub fn to_array(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }

    /// Chromaticity x, y and luminance Y; `None` for black and whatever has no finite chromaticity.
    ///
    /// ```text
    /// x = X / (X + Y + Z),   y = Y / (X + Y + Z)
    /// ```
    ///
    /// ```
    /// use morpho_fit::colorimetry::Xyz;
    /// let white = Xyz { x: 1.0, y: 1.0, z: 1.0 }.chromaticity().unwrap();
    /// assert_eq!((white.x, white.y), (1.0 / 3.0, 1.0 / 3.0));
    /// assert!(Xyz::default().chromaticity().is_none());
    /// ```
    #[must_use]
    pub fn chromaticity(self) -> Option<XyY> {
        let sum = self.x + self.y + self.z;
        let found = XyY { x: self.x / sum, y: self.y / sum, luminance: self.y };
        (sum.is_finite() && found.x.is_finite() && found.y.is_finite()).then_some(found)
    }

    /// The colour itself, if its values are finite.
    pub(super) fn finite(self) -> Result<Self, ColourError> {
        match self.to_array().into_iter().enumerate().find(|(_, value)| !value.is_finite()) {
            Some((index, found)) => Err(ColourError::NotFinite { quantity: "tristimulus value", index, found }),
            None => Ok(self),
        }
    }

    /// The white itself, if a light can have it: finite and above 0.
    pub(super) fn as_white(self) -> Result<Self, ColourError> {
        let Self { x, y, z } = self.finite()?;
        if x > 0.0 && y > 0.0 && z > 0.0 { Ok(self) } else { Err(ColourError::BadWhite { x, y, z }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_is_no_colour_has_a_chromaticity() {
        for bad in [f64::NAN, f64::INFINITY, 1e308] {
            assert!(Xyz { x: bad, y: bad, z: bad }.chromaticity().is_none());
        }
        assert!(Xyz { x: 1.0, y: -1.0, z: 0.0 }.chromaticity().is_none());
        assert!(Xyz { x: f64::NAN, y: 0.0, z: 0.0 }.finite().is_err());
        assert!(Xyz { x: 1.0, y: 1.0, z: 0.0 }.as_white().is_err());
    }
}
