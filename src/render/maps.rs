//! What lies on the square: relief, direction of the ridges, mask, base and gap, from images.
//!
//! All maps have the same size and are stretched over the square; the middle of a pixel is where its value holds, and between
//! these they are linear. The direction of the ridges is linear in its cosine and sine, so that it has no seam where the
//! angle jumps from 360° to 0.

use super::error::RenderError;
use super::raster::Raster;
use super::scene::HALF_SIDE;
use rayon::prelude::*;
use std::f32::consts::TAU;

/// A direction shorter than this is none: its neighbours cancel each other.
const NO_DIRECTION: f32 = 1e-6;

/// A map of the gap `d_air`.
#[derive(Debug, Clone, PartialEq)]
pub struct GapMap {
    /// Grey: 0 is the first of the range, 1 the last.
    pub raster: Raster,
    /// nm.
    pub range: [f64; 2],
}

/// The images of a wing.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// Displacement along the normal, grey; [`Surface::new`] is told how high 1 is.
    pub height: Raster,
    /// Anisotropy angle `omega_map`, from the upward direction of the map counterclockwise to that of the ridges (y of the
    /// scale, towards which the layers' tilt counts).
    ///
    /// Grey, or RGB without colour: `Y = omega_map / 2 pi`, the paper's. Coloured: red `(cos + 1) / 2` and green
    /// `(sin + 1) / 2`, which has no seam for any tool that scales or blurs it.
    pub angle: Raster,
    /// Alpha says where there is wing, grey how much of its light is structural. Without alpha grey says where there is wing.
    pub mask: Raster,
    /// Linear sRGB of the Lambertian base below the scales (its reflectance); grey for a grey one.
    pub base: Raster,
    /// The gap, where it is not the same all over.
    pub gap: Option<GapMap>,
}

/// Coverage, and times this: structural share, slopes along x and y, direction of the ridges along x and y, base, gap. So what a map
/// says where there is no wing makes no fringe at its edge.
type Texel = [f32; 10];

/// One point of a wing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Share of the point that is wing.
    pub coverage: f64,
    /// Share of the structural colour, times the coverage.
    pub structural: f64,
    /// Unit normal.
    pub normal: [f64; 3],
    /// Unit vector along the ridges, in the plane of the square.
    pub ridge: [f64; 2],
    /// Linear sRGB of the base, times the coverage.
    pub base: [f64; 3],
    /// Gap, nm.
    pub gap: f64,
}

/// The maps made ready for rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
    gaps: [f64; 2],
    found: [f64; 2],
}

impl Surface {
    /// - `relief`: height of a displacement of 1, in sides of the square; `gap`: that where no map says another, nm.
    ///
    /// # Errors
    /// [`RenderError::Mismatch`] for maps of different size, [`RenderError::NoWing`] for a mask that is 0 everywhere,
    /// [`RenderError::OutOfRange`] for a relief that is not finite, or
    /// steeper than can be, and for a range of gaps that falls.
    pub fn new(maps: &Maps, relief: f64, gap: f64) -> Result<Self, RenderError> {
        let size = |raster: &Raster| (raster.width(), raster.height());
        let (width, height) = size(&maps.height);
        let others = [("angle", Some(&maps.angle)), ("mask", Some(&maps.mask)), ("base", Some(&maps.base))];
        for (map, raster) in others.into_iter().chain([("d_air", maps.gap.as_ref().map(|map| &map.raster))]) {
            let found = raster.map_or((width, height), size);
            if found != (width, height) {
                return Err(RenderError::Mismatch { map, found, other: "height", needed: (width, height) });
            }
        }
        if !(-1.0..=1.0).contains(&relief) {
            let quantity = "the relief, in sides of the square,";
            return Err(RenderError::OutOfRange { quantity, found: relief, allowed: "-1 to 1" });
        }
        let gaps = maps.gap.as_ref().map_or([gap; 2], |map| map.range);
        let rises = gaps[0] <= gaps[1];
        if !rises {
            let quantity = "the first gap of the d_air map, nm,";
            return Err(RenderError::OutOfRange { quantity, found: gaps[0], allowed: "at most the last" });
        }
        let two_channels = maps.angle.is_coloured();
        let slopes = Slopes { mask: Some(&maps.mask), ..Slopes::new(&maps.height, relief) };
        let mut texels = vec![[0.0; 10]; width * height];
        texels.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
            for (column, texel) in out.iter_mut().enumerate() {
                let coverage = covered(&maps.mask, column, row);
                let share = maps.mask.alpha(column, row).map_or(1.0, |_| maps.mask.grey(column, row));
                let [slope_x, slope_y] = slopes.at(column, row).map(|slope| coverage * slope);
                let [along_x, along_y] = ridge(&maps.angle, column, row, two_channels).map(|along| coverage * along);
                let [red, green, blue] = [0, 1, 2].map(|channel| {
                    let channel = if maps.base.channels() < 3 { 0 } else { channel };
                    coverage * maps.base.at(column, row, channel)
                });
                let gap = maps.gap.as_ref().map_or(0.0, |map| coverage * map.raster.grey(column, row));
                let structural = coverage * share;
                *texel = [coverage, structural, slope_x, slope_y, along_x, along_y, red, green, blue, gap];
            }
        });
        if texels.iter().all(|texel| texel[0] <= 0.0) {
            return Err(RenderError::NoWing);
        }
        let lit = texels.iter().filter(|texel| texel[1] > 0.0).map(|texel| f64::from(texel[9] / texel[0]));
        let [low, high] = lit.fold([f64::INFINITY, 0.0], |[low, high], gap| [low.min(gap), high.max(gap)]);
        let found = if low > high { gaps } else { [low, high].map(|gap| between(gaps, gap)) };
        Ok(Self { width, height, texels, gaps, found })
    }

    /// First and last gap of the range, nm.
    #[must_use]
    pub fn gaps(&self) -> [f64; 2] {
        self.gaps
    }

    /// Least and largest gap of the pixels with structural colour, nm; the range where there is none.
    #[must_use]
    pub fn found_gaps(&self) -> [f64; 2] {
        self.found
    }

    /// The point at x to the right and y upwards of the centre; none beyond the square, or where there is no wing.
    #[inline]
    #[must_use]
    pub fn at(&self, [x, y]: [f64; 2]) -> Option<Point> {
        let square = -HALF_SIDE..=HALF_SIDE;
        if !square.contains(&x) || !square.contains(&y) {
            return None;
        }
        let (columns, rows) = (whole(self.width), whole(self.height));
        let (left, right, across) = neighbours((0.5 + 0.5 * x / HALF_SIDE) * columns - 0.5, self.width);
        let (upper, lower, down) = neighbours((0.5 - 0.5 * y / HALF_SIDE) * rows - 0.5, self.height);
        let texel = |row: usize, column: usize| self.texels.get(row * self.width + column).copied().unwrap_or_default();
        let (above, below) = (
            mix(&texel(upper, left), &texel(upper, right), across),
            mix(&texel(lower, left), &texel(lower, right), across),
        );
        let mixed = mix(&above, &below, down);
        let [coverage, structural, slope_x, slope_y, along_x, along_y, red, green, blue, gap] = mixed.map(f64::from);
        if coverage <= 0.0 {
            return None;
        }
        let length = along_x.hypot(along_y);
        let ridge = if length > f64::from(NO_DIRECTION) { [along_x / length, along_y / length] } else { [0.0, 1.0] };
        let [slope_x, slope_y, gap] = [slope_x, slope_y, gap].map(|value| value / coverage);
        let upright = (slope_x * slope_x + slope_y * slope_y + 1.0).sqrt().recip();
        let normal = [-slope_x * upright, -slope_y * upright, upright];
        let gap = between(self.gaps, gap.min(1.0));
        Some(Point { coverage, structural, normal, ridge, base: [red, green, blue], gap })
    }
}

#[inline]
fn between([first, last]: [f64; 2], share: f64) -> f64 {
    first + share * (last - first)
}

/// Share of a pixel that is wing.
fn covered(mask: &Raster, column: usize, row: usize) -> f32 {
    mask.alpha(column, row).unwrap_or_else(|| mask.grey(column, row))
}

/// Slopes of a displacement by central differences, one-sided at the edge of the image and of the wing.
pub(super) struct Slopes<'a> {
    height: &'a Raster,
    /// Where there is wing; none for everywhere.
    mask: Option<&'a Raster>,
    /// Height of a displacement of 1 over the width and the height of a pixel.
    steepness: [f64; 2],
}

impl<'a> Slopes<'a> {
    pub(super) fn new(height: &'a Raster, relief: f64) -> Self {
        // Relief and pixels are both parts of the side.
        let steepness = [relief * whole(height.width()), relief * whole(height.height())];
        Self { height, mask: None, steepness }
    }

    #[allow(clippy::cast_possible_truncation, reason = "texels are in single precision")]
    pub(super) fn at(&self, column: usize, row: usize) -> [f32; 2] {
        let is_wing = |column, row| self.mask.is_none_or(|mask| covered(mask, column, row) > 0.0);
        let beside = |other, own, is_wing: bool| if is_wing { other } else { own };
        let horizontal = |other| beside(other, column, is_wing(other, row));
        let vertical = |other| beside(other, row, is_wing(column, other));
        let (left, right) =
            (horizontal(column.saturating_sub(1)), horizontal((column + 1).min(self.height.width() - 1)));
        let (above, below) = (vertical(row.saturating_sub(1)), vertical((row + 1).min(self.height.height() - 1)));
        let level = |column, row| f64::from(self.height.grey(column, row));
        let across = (level(right, row) - level(left, row)) / whole((right - left).max(1));
        let upwards = (level(column, above) - level(column, below)) / whole((below - above).max(1));
        [(across * self.steepness[0]) as f32, (upwards * self.steepness[1]) as f32]
    }
}

/// Unit vector along the ridges: the upward direction turned counterclockwise by the angle.
pub(super) fn ridge(angle: &Raster, column: usize, row: usize, two_channels: bool) -> [f32; 2] {
    let (sin, cos) = if two_channels {
        (2.0 * angle.at(column, row, 1) - 1.0, 2.0 * angle.at(column, row, 0) - 1.0)
    } else {
        (TAU * angle.grey(column, row)).sin_cos()
    };
    let length = sin.hypot(cos);
    if length > NO_DIRECTION { [-sin / length, cos / length] } else { [0.0, 1.0] }
}

/// The two pixels around a place counted in pixels, and the share of the second.
#[inline]
pub(super) fn neighbours(place: f64, count: usize) -> (usize, usize, f32) {
    let place = place.clamp(0.0, whole(count - 1));
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the image")]
    let first = place as usize;
    #[allow(clippy::cast_possible_truncation, reason = "a share")]
    let share = (place - whole(first)) as f32;
    (first, (first + 1).min(count - 1), share)
}

#[inline]
fn mix(near: &Texel, far: &Texel, share: f32) -> Texel {
    std::array::from_fn(|channel| near[channel] + share * (far[channel] - near[channel]))
}

#[allow(clippy::cast_precision_loss, reason = "sides of an image")]
fn whole(count: usize) -> f64 {
    count as f64
}
