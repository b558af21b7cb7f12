//! Colours that a display cannot show: told apart, and shown as near as can be.

use super::error::ColourError;
use super::rgb::{RgbSpace, RgbTransform};
use super::tristimulus::Xyz;
use palette::convert::FromColorUnclamped;
use palette::white_point::D65;

/// Linear light by which a channel may miss 0 to 1 through rounding and still count as shown.
const EDGE: f64 = 1e-9;
/// Halvings of the chroma: to 1e-12 of it.
const HALVINGS: usize = 40;

/// What becomes of a colour outside the gamut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum GamutMapping {
    /// Each linear channel is cut at 0 and 1: brighter, but the hue moves.
    Clip,
    /// The chroma in Oklch is lowered at constant hue and lightness until the colour just fits.
    #[default]
    ReduceChroma,
}

impl GamutMapping {
    /// What a caption says of a colour so treated.
    #[must_use]
    pub fn wording(self) -> &'static str {
        match self {
            Self::Clip => "channels clipped",
            Self::ReduceChroma => "chroma reduced at constant hue and lightness",
        }
    }
}

/// A colour as a display shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Encoded red, green, blue, 0 to 1.
    pub encoded: [f64; 3],
    /// The same, rounded to 0 to 255.
    pub bytes: [u8; 3],
    /// Whether the display cannot show the colour itself, so that this is another.
    pub outside: bool,
}

/// `colour` under `white` on a display of `space`.
///
/// The white is adapted to that of the display, as in [`RgbTransform::adapted`]. A colour lighter than white is outside as
/// well; with [`GamutMapping::ReduceChroma`] it becomes white.
///
/// # Source
/// Oklab: Ottosson 2020, *A perceptual color space for image processing*, as in `palette`.
///
/// # Errors
/// As [`RgbTransform::adapted`] and [`RgbTransform::linear`].
///
/// ```
/// use morpho_fit::colorimetry::{GamutMapping, RgbSpace, Xyz, show};
/// let white = Xyz { x: 0.9505, y: 1.0, z: 1.089 };
/// let grey = show(Xyz { x: 0.19010, y: 0.2, z: 0.2178 }, white, RgbSpace::Srgb, GamutMapping::default())?;
/// assert_eq!((grey.bytes, grey.outside), ([124; 3], false));
/// let blue = show(Xyz { x: 0.3, y: 0.35, z: 1.1 }, white, RgbSpace::Srgb, GamutMapping::default())?;
/// assert!(blue.outside);
/// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
/// ```
pub fn show(colour: Xyz, white: Xyz, space: RgbSpace, mapping: GamutMapping) -> Result<Shown, ColourError> {
    RgbTransform::adapted(space, white)?.show(colour, mapping)
}

impl RgbTransform {
    /// As [`show`], for many colours under one white.
    ///
    /// # Errors
    /// As [`RgbTransform::linear`].
    pub fn show(&self, colour: Xyz, mapping: GamutMapping) -> Result<Shown, ColourError> {
        let linear = self.linear(colour)?;
        let outside = !fits(linear);
        let mapped = if outside && mapping == GamutMapping::ReduceChroma { self.less_chroma(linear) } else { linear };
        let encoded = self.space().encode(mapped.map(|channel| channel.clamp(0.0, 1.0)))?;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
        let bytes = encoded.map(|channel| (255.0 * channel).round() as u8);
        Ok(Shown { encoded, bytes, outside })
    }

    /// The colour of the same hue and lightness with the largest chroma that fits.
    fn less_chroma(&self, linear: [f64; 3]) -> [f64; 3] {
        let Xyz { x, y, z } = self.under_own_white(linear);
        let oklab = palette::Oklab::<f64>::from_color_unclamped(palette::Xyz::<D65, f64>::new(x, y, z));
        // A palette grey may miss the display's by the last digits of their whites: ends of the scale are cut.
        if oklab.l >= 1.0 || oklab.l <= 0.0 {
            return [if oklab.l >= 1.0 { 1.0 } else { 0.0 }; 3];
        }
        let own = Self::new(self.space());
        let with = |share: f64| {
            let less = palette::Oklab::new(oklab.l, share * oklab.a, share * oklab.b);
            let xyz = palette::Xyz::<D65, f64>::from_color_unclamped(less);
            own.apply([xyz.x, xyz.y, xyz.z])
        };
        let (mut fitting, mut too_much) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (fitting + too_much);
            if fits(with(middle)) {
                fitting = middle;
            } else {
                too_much = middle;
            }
        }
        with(fitting)
    }
}

fn fits(linear: [f64; 3]) -> bool {
    linear.iter().all(|channel| (-EDGE..=1.0 + EDGE).contains(channel))
}
