//! RGB spaces of displays, linear and encoded, from XYZ under any white.
//!
//! The matrix of sRGB is the standard's own, of four digits; those of Display P3 and Rec. 2020 follow from their
//! primaries. `palette` has them from a white of other digits: up to 5e-4 of an encoded channel from `colour-science`.

use super::encoding::{REC2020, SRGB, Transfer};
use super::error::ColourError;
use super::tristimulus::Xyz;
use nalgebra::{Matrix3, Vector3};

/// Chromaticity x, y of D65 as the standards of RGB spaces round it.
const D65: [f64; 2] = [0.3127, 0.3290];

/// XYZ to linear sRGB, IEC 61966-2-1:1999; it makes the white (0.9505, 1, 1.0890) to four digits.
const XYZ_TO_SRGB: [[f64; 3]; 3] = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];

/// XYZ to the sharpened cones of Bradford, in which whites are scaled.
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The primaries and the encoding of a display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum RgbSpace {
    /// IEC 61966-2-1: what a screen and a PNG without a profile mean.
    #[default]
    Srgb,
    /// SMPTE RP 431-2 primaries with D65 and the encoding of sRGB: most newer screens.
    DisplayP3,
    /// ITU-R BT.2020-2: wide enough for blue Morphos, beyond most screens.
    Rec2020,
}

impl RgbSpace {
    /// The usual name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "sRGB",
            Self::DisplayP3 => "Display P3",
            Self::Rec2020 => "Rec. 2020",
        }
    }

    /// XYZ (white Y = 1) of what the space shows as (1, 1, 1).
    ///
    /// ```
    /// use morpho_fit::colorimetry::RgbSpace;
    /// let white = RgbSpace::Srgb.white();
    /// assert!((white.x - 0.9505).abs() < 2e-4 && (white.y - 1.0).abs() < 2e-4 && (white.z - 1.089).abs() < 2e-4);
    /// ```
    #[must_use]
    pub fn white(self) -> Xyz {
        let white = inverse(self.matrix_from_xyz()) * Vector3::repeat(1.0);
        Xyz { x: white.x, y: white.y, z: white.z }
    }

    /// The stored values of linear ones, which may lie outside 0 to 1: the encoding goes on there.
    ///
    /// # Errors
    /// [`ColourError::NotFinite`].
    ///
    /// ```
    /// use morpho_fit::colorimetry::RgbSpace;
    /// let [grey, ..] = RgbSpace::Srgb.encode([0.5; 3])?;
    /// assert!((grey - 0.735356983052449).abs() < 1e-11);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn encode(self, linear: [f64; 3]) -> Result<[f64; 3], ColourError> {
        if let Some((index, &found)) = linear.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(ColourError::NotFinite { quantity: "linear RGB channel", index, found });
        }
        Ok(linear.map(|value| self.transfer().encode(value)))
    }

    pub(super) fn transfer(self) -> &'static Transfer {
        match self {
            Self::Srgb | Self::DisplayP3 => &SRGB,
            Self::Rec2020 => &REC2020,
        }
    }

    /// The matrix from XYZ to linear RGB.
    fn matrix_from_xyz(self) -> Matrix3<f64> {
        match self {
            Self::Srgb => matrix(XYZ_TO_SRGB),
            Self::DisplayP3 => of_primaries([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]]),
            Self::Rec2020 => of_primaries([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]]),
        }
    }
}

/// The matrix from XYZ to the linear RGB of primaries with these chromaticities x, y, which together make D65.
fn of_primaries(chromaticities: [[f64; 2]; 3]) -> Matrix3<f64> {
    let of = |[x, y]: [f64; 2]| Vector3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = Matrix3::from_columns(&chromaticities.map(of));
    let amounts = inverse(primaries) * of(D65);
    inverse(primaries * Matrix3::from_diagonal(&amounts))
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| rows[row][column])
}

/// The inverse of a matrix of this file; all of them have one.
fn inverse(of: Matrix3<f64>) -> Matrix3<f64> {
    of.try_inverse().unwrap_or_else(Matrix3::zeros)
}

impl RgbSpace {
    /// XYZ, under the space's own D65, of linear red, green and blue.
    ///
    /// ```
    /// use morpho_fit::colorimetry::RgbSpace;
    /// // The matrix of sRGB has four digits, and so has its inverse.
    /// let white = RgbSpace::Srgb.xyz([1.0; 3])?;
    /// assert!((white.y - 1.0).abs() < 1e-4);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    ///
    /// # Errors
    /// [`ColourError::NotFinite`].
    pub fn xyz(self, linear: [f64; 3]) -> Result<Xyz, ColourError> {
        RgbTransform::new(self).under_own_white(linear).finite()
    }
}

/// From XYZ to one RGB space: a matrix, with the adaptation to the space's white in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RgbTransform {
    space: RgbSpace,
    matrix: [[f64; 3]; 3],
}

impl RgbTransform {
    /// For colours that are given under the space's own D65: the matrix alone.
    #[must_use]
    pub fn new(space: RgbSpace) -> Self {
        Self::from_matrix(space, &space.matrix_from_xyz())
    }

    /// For colours under `white`, which becomes (1, 1, 1): what an eye adapted to that light sees on the display.
    ///
    /// ```text
    /// RGB = M B⁻¹ diag(B white(space) / B white) B XYZ,   B: Bradford
    /// ```
    ///
    /// A sampled D65 is adapted too: that moves a linear channel by up to 4e-4 at 1 nm and by 1e-3 at 10 nm, and white is
    /// white.
    ///
    /// # Source
    /// Lam 1985, the Bradford transform, in the linear form of ICC.1:2022, annex E.
    ///
    /// # Errors
    /// [`ColourError`] if the white is not finite and above 0, or is so far from any light that a cone sees less than
    /// nothing of it.
    ///
    /// ```
    /// use morpho_fit::colorimetry::{RgbSpace, RgbTransform, Xyz};
    /// let white = Xyz { x: 1.0985, y: 1.0, z: 0.3558 }; // illuminant A
    /// let rgb = RgbTransform::adapted(RgbSpace::Srgb, white)?.linear(white)?;
    /// assert!(rgb.iter().all(|channel| (channel - 1.0).abs() < 1e-12));
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn adapted(space: RgbSpace, white: Xyz) -> Result<Self, ColourError> {
        let Xyz { x, y, z } = white.as_white()?;
        let bradford = matrix(BRADFORD);
        let cones = |white: Xyz| bradford * Vector3::from(white.to_array());
        let gains = cones(space.white()).component_div(&cones(white));
        if !gains.iter().all(|gain| gain.is_finite() && *gain > 0.0) {
            return Err(ColourError::BadWhite { x, y, z });
        }
        let adaptation = inverse(bradford) * Matrix3::from_diagonal(&gains) * bradford;
        Ok(Self::from_matrix(space, &(space.matrix_from_xyz() * adaptation)))
    }

    fn from_matrix(space: RgbSpace, matrix: &Matrix3<f64>) -> Self {
        Self { space, matrix: std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)])) }
    }

    /// The space that this leads to.
    #[must_use]
    pub fn space(&self) -> RgbSpace {
        self.space
    }

    /// Linear RGB; outside 0 to 1 the display cannot show it.
    ///
    /// # Errors
    /// [`ColourError::NotFinite`].
    pub fn linear(&self, colour: Xyz) -> Result<[f64; 3], ColourError> {
        let linear = self.apply(colour.finite()?.to_array());
        match linear.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            Some((index, &found)) => Err(ColourError::NotFinite { quantity: "linear RGB channel", index, found }),
            None => Ok(linear),
        }
    }

    /// The colour, under the white that this was made for, of linear RGB: the inverse of [`RgbTransform::linear`].
    ///
    /// # Errors
    /// [`ColourError::NotFinite`].
    ///
    /// ```
    /// use morpho_fit::colorimetry::{RgbSpace, RgbTransform, Xyz};
    /// let white = Xyz { x: 1.0985, y: 1.0, z: 0.3558 }; // illuminant A
    /// let display = RgbTransform::adapted(RgbSpace::Srgb, white)?;
    /// let [red, ..] = display.linear(display.colour([0.5, 0.1, 0.2])?)?;
    /// assert!((red - 0.5).abs() < 1e-12);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn colour(&self, linear: [f64; 3]) -> Result<Xyz, ColourError> {
        let colour = inverse(matrix(self.matrix)) * Vector3::from(linear);
        Xyz { x: colour.x, y: colour.y, z: colour.z }.finite()
    }

    /// Encoded RGB, neither clipped nor moved into the gamut; see [`super::show`] for that.
    ///
    /// # Errors
    /// [`ColourError::NotFinite`].
    pub fn encoded(&self, colour: Xyz) -> Result<[f64; 3], ColourError> {
        self.space.encode(self.linear(colour)?)
    }

    /// XYZ under the space's own white.
    pub(super) fn under_own_white(&self, linear: [f64; 3]) -> Xyz {
        let xyz = inverse(self.space.matrix_from_xyz()) * Vector3::from(linear);
        Xyz { x: xyz.x, y: xyz.y, z: xyz.z }
    }

    #[inline(always)]
    pub(super) fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.matrix.map(|row| row[0] * x + row[1] * y + row[2] * z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const SPACES: [RgbSpace; 3] = [RgbSpace::Srgb, RgbSpace::DisplayP3, RgbSpace::Rec2020];

    #[test]
    fn all_whites_are_d65_to_the_digits_of_their_standards() {
        for space in SPACES {
            let white = space.white().chromaticity().unwrap();
            assert_relative_eq!(white.x, D65[0], epsilon = 3e-5);
            assert_relative_eq!(white.y, D65[1], epsilon = 3e-5);
        }
    }

    #[test]
    fn the_standards_matrix_of_srgb_is_that_of_its_primaries_to_four_digits() {
        let derived = of_primaries([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]]);
        assert_relative_eq!(derived, matrix(XYZ_TO_SRGB), epsilon = 5e-4);
    }

    /// Table of ITU-R BT.2020-2: `Y = 0.2627 R + 0.6780 G + 0.0593 B`.
    #[test]
    fn rec_2020_has_the_luma_of_its_standard() {
        let rgb_to_xyz = inverse(RgbSpace::Rec2020.matrix_from_xyz());
        for (column, printed) in [0.2627, 0.6780, 0.0593].into_iter().enumerate() {
            assert_relative_eq!(rgb_to_xyz[(1, column)], printed, epsilon = 5e-5);
        }
    }

    #[test]
    fn what_is_no_colour_or_white_is_refused() {
        let white = RgbSpace::Srgb.white();
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            let colour = Xyz { y: bad, ..white };
            assert!(RgbTransform::new(RgbSpace::Srgb).encoded(colour).is_err(), "{bad}");
        }
        for bad in [f64::NAN, f64::INFINITY, 0.0, -1.0, 100.0] {
            assert!(RgbTransform::adapted(RgbSpace::Srgb, Xyz { x: bad, y: 1.0, z: 1e-9 }).is_err(), "{bad}");
        }
        assert!(RgbSpace::Rec2020.encode([0.0, f64::NAN, 0.0]).is_err());
    }
}
