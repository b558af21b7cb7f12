//! From linear light to what a display shows.

use super::error::RenderError;
use super::raster::decoded;
use super::trace::Picture;
use crate::colorimetry::{GamutMapping, RgbSpace, RgbTransform, Xyz};
use rayon::prelude::*;

/// Coverage below which a pixel holds too little wing to have a colour of its own.
const BARE: f32 = 1e-4;
/// Coverage from which on a pixel counts for the exposure.
const MOSTLY: f32 = 0.5;
/// Share of the pixels of wing that the exposure keeps below the display's white in every channel.
const WITHIN: f64 = 0.99;

/// What stands behind the wing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Background {
    /// Nothing: the alpha of the picture is the coverage.
    #[default]
    Transparent,
    /// A colour of the display, linear sRGB.
    Colour([f64; 3]),
}

impl Background {
    /// Of encoded red, green and blue.
    #[must_use]
    pub fn encoded(bytes: [u8; 3]) -> Self {
        Self::Colour(bytes.map(|byte| f64::from(decoded(f32::from(byte) / f32::from(u8::MAX)))))
    }
}

/// The exposure at which 99 % of the pixels of wing, over all pictures, have no linear channel of sRGB above 1; 1 if all are
/// black.
///
/// Each picture is taken when the one before is done with; four bytes of each pixel of wing stay.
///
/// # Errors
/// [`RenderError::Colour`] for a white that is none, and what a picture brings.
pub fn exposure(pictures: impl IntoIterator<Item = Result<Picture, RenderError>>) -> Result<f64, RenderError> {
    let mut largest: Vec<f32> = Vec::new();
    for picture in pictures {
        let picture = picture?;
        let display = RgbTransform::adapted(RgbSpace::Srgb, picture.white)?;
        for pixel in picture.pixels.iter().filter(|pixel| pixel[3] >= MOSTLY) {
            let linear = display.linear(straight(pixel))?;
            #[allow(clippy::cast_possible_truncation, reason = "pictures are in single precision")]
            largest.push(linear.into_iter().fold(0.0, f64::max) as f32);
        }
    }
    largest.sort_unstable_by(f32::total_cmp);
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let within = (WITHIN * largest.len() as f64).ceil() as usize;
    let last = largest.get(within.saturating_sub(1)).filter(|value| **value > 0.0);
    Ok(last.map_or(1.0, |value| f64::from(*value).recip()))
}

/// XYZ of the wing in a pixel, whatever its coverage.
fn straight([x, y, z, coverage]: &[f32; 4]) -> Xyz {
    let share = f64::from(coverage.max(BARE)).recip();
    Xyz { x: share * f64::from(*x), y: share * f64::from(*y), z: share * f64::from(*z) }
}

impl Picture {
    /// Encoded sRGB and alpha of each pixel, and the share of the pixels of wing whose colour sRGB cannot show.
    ///
    /// # Shape
    /// The result: `[height][width][red, green, blue, alpha]`.
    ///
    /// # Errors
    /// [`RenderError::Colour`] for an exposure or a white that makes no colour.
    pub fn bytes(
        &self,
        exposure: f64,
        mapping: GamutMapping,
        background: Background,
    ) -> Result<(Vec<u8>, f64), RenderError> {
        let display = RgbTransform::adapted(RgbSpace::Srgb, self.white)?;
        let behind = match background {
            Background::Transparent => None,
            Background::Colour(linear) => Some(display.colour(linear)?),
        };
        let one = |pixel: &[f32; 4]| {
            let coverage = pixel[3].clamp(0.0, 1.0);
            if coverage < BARE && behind.is_none() {
                return Ok(([0; 4], false));
            }
            let (colour, alpha) = match behind {
                None => (scaled(straight(pixel), exposure), coverage),
                Some(behind) => {
                    let wing = [pixel[0], pixel[1], pixel[2]].map(f64::from);
                    let bare = 1.0 - f64::from(coverage);
                    let [x, y, z] = behind.to_array();
                    let light =
                        [bare * x + exposure * wing[0], bare * y + exposure * wing[1], bare * z + exposure * wing[2]];
                    (Xyz::from_array(light), 1.0)
                }
            };
            let shown = display.show(colour, mapping)?;
            let [red, green, blue] = shown.bytes;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
            let alpha = (255.0 * alpha).round() as u8;
            Ok(([red, green, blue, alpha], shown.outside && coverage >= MOSTLY))
        };
        let shown = self.pixels.par_iter().map(one).collect::<Result<Vec<_>, RenderError>>()?;
        let (wing, outside) = (
            self.pixels.iter().filter(|pixel| pixel[3] >= MOSTLY).count().max(1),
            shown.iter().filter(|(_, outside)| *outside).count(),
        );
        #[allow(clippy::cast_precision_loss, reason = "a share")]
        let outside = outside as f64 / wing as f64;
        Ok((shown.into_iter().flat_map(|(pixel, _)| pixel).collect(), outside))
    }

    /// Linear sRGB times coverage, and coverage, of each pixel: light without exposure, with channels below 0 where sRGB
    /// cannot show the colour.
    ///
    /// # Shape
    /// `[height][width]`.
    ///
    /// # Errors
    /// [`RenderError::Colour`] for a white that is none.
    pub fn linear(&self) -> Result<Vec<[f32; 4]>, RenderError> {
        let display = RgbTransform::adapted(RgbSpace::Srgb, self.white)?;
        let one = |[x, y, z, coverage]: &[f32; 4]| {
            let [red, green, blue] = display.linear(Xyz { x: (*x).into(), y: (*y).into(), z: (*z).into() })?;
            #[allow(clippy::cast_possible_truncation, reason = "single precision")]
            let pixel = [red as f32, green as f32, blue as f32, *coverage];
            Ok(pixel)
        };
        self.pixels.iter().map(one).collect()
    }
}

fn scaled(colour: Xyz, by: f64) -> Xyz {
    Xyz { x: by * colour.x, y: by * colour.y, z: by * colour.z }
}
