//! The maps of a wing as other renderers take them: one meaning an image.

use super::error::RenderError;
use super::maps::{Maps, ridge};
use super::raster::Raster;

/// Images over the square, of the same size.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// Where there is wing, grey.
    pub coverage: Raster,
    /// How much of its light is structural, grey.
    pub share: Raster,
    /// Red `(cos + 1) / 2` and green `(sin + 1) / 2` of the angle from the upward direction to the ridges, counterclockwise.
    pub angle: Raster,
    /// Reflectance of the base, encoded as sRGB.
    pub base: Raster,
}

impl Maps {
    /// The images, whatever the form of the maps.
    ///
    /// # Errors
    /// [`RenderError::Mismatch`] for maps of different size.
    ///
    /// ```
    /// use morpho_fit::render::{Wing, plain_maps};
    /// let plain = plain_maps(&Wing { size: (4, 4), base: 0.03, gap: 141.0, gap_spread: 0.0 })?;
    /// assert_eq!(plain.layers()?.angle.values()[..3], [1.0, 0.5, 0.0]);
    /// # Ok::<(), morpho_fit::render::RenderError>(())
    /// ```
    pub fn layers(&self) -> Result<Layers, RenderError> {
        let size = |raster: &Raster| (raster.width(), raster.height());
        let (width, height) = size(&self.height);
        for (map, raster) in [("angle", &self.angle), ("mask", &self.mask), ("base", &self.base)] {
            if size(raster) != (width, height) {
                let (found, needed) = (size(raster), (width, height));
                return Err(RenderError::Mismatch { map, found, other: "height", needed });
            }
        }
        let two_channels = self.angle.is_coloured();
        let pixels = || (0..width * height).map(|pixel| (pixel % width, pixel / width));
        let coverage = pixels().map(|(x, y)| self.mask.alpha(x, y).unwrap_or_else(|| self.mask.grey(x, y))).collect();
        let share = pixels().map(|(x, y)| self.mask.alpha(x, y).map_or(1.0, |_| self.mask.grey(x, y))).collect();
        let angle = pixels().flat_map(|(x, y)| {
            let [along_x, along_y] = ridge(&self.angle, x, y, two_channels);
            [0.5 + 0.5 * along_y, 0.5 - 0.5 * along_x, 0.0]
        });
        let base = pixels().flat_map(|(x, y)| {
            [0, 1, 2].map(|channel| self.base.at(x, y, if self.base.channels() < 3 { 0 } else { channel }))
        });
        Ok(Layers {
            coverage: Raster::new(width, height, 1, coverage)?,
            share: Raster::new(width, height, 1, share)?,
            angle: Raster::new(width, height, 3, angle.collect())?,
            base: Raster::new(width, height, 3, base.collect())?.encoded(),
        })
    }
}
