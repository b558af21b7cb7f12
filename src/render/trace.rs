//! From a surface to the light in each pixel.

use super::base;
use super::colours::ColourLookup;
use super::error::RenderError;
use super::maps::{Point, Surface};
use super::raster;
use super::scene::Scene;
use crate::colorimetry::Xyz;
use rayon::prelude::*;

/// Samples of a pixel along each side at most.
const MOST_SAMPLES: usize = 64;

/// A picture in linear light: XYZ times coverage, and coverage, where a white diffuser turned to the sun has Y = 1.
///
/// # Shape
/// `pixels: [height][width]`, the upper row first, each X, Y, Z, coverage.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: usize,
    /// Pixels upwards.
    pub height: usize,
    /// X, Y, Z and coverage of each.
    pub pixels: Vec<[f32; 4]>,
    /// XYZ of a white diffuser turned to the sun.
    pub white: Xyz,
}

/// The picture of `surface`, whose structural colours are `colours`, from a scene.
///
/// Each pixel is the mean of `samples × samples` rays, one at a place by chance within each part of it; chance is a function
/// of the pixel's place, so that the picture has the same bits on any number of threads.
///
/// - `size`: width and height, pixels; `white`: XYZ of a perfect white in the light of `colours`.
///
/// # Errors
/// [`RenderError`] for a scene, a size or samples (1 to 64) out of range.
pub fn trace(
    surface: &Surface,
    colours: &ColourLookup,
    scene: &Scene,
    size: (usize, usize),
    samples: usize,
    white: Xyz,
) -> Result<Picture, RenderError> {
    scene.validate()?;
    let (width, height) = size;
    raster::size(width, height)?;
    if !(1..=MOST_SAMPLES).contains(&samples) {
        let quantity = "the samples along a side of a pixel";
        return Err(RenderError::OutOfRange { quantity, found: whole(samples), allowed: "1 to 64" });
    }
    let shader = Shader { surface, colours, scene: *scene, to_sun: scene.to_sun(), base: base::to_xyz(white)? };
    let extent = [whole(width), whole(height)];
    let mut pixels = vec![[0.0; 4]; width * height];
    pixels.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        for (column, pixel) in out.iter_mut().enumerate() {
            *pixel = shader.pixel([column, row], extent, samples);
        }
    });
    Ok(Picture { width, height, pixels, white })
}

struct Shader<'a> {
    surface: &'a Surface,
    colours: &'a ColourLookup,
    scene: Scene,
    to_sun: [f64; 3],
    /// XYZ of a base.
    base: [[f64; 3]; 3],
}

impl Shader<'_> {
    #[allow(clippy::cast_possible_truncation, reason = "pictures are in single precision")]
    fn pixel(&self, [column, row]: [usize; 2], size: [f64; 2], samples: usize) -> [f32; 4] {
        let mut chance = Chance::of(column, row);
        let step = whole(samples).recip();
        let (mut structural, mut base, mut coverage) = ([0.0; 3], [0.0; 3], 0.0);
        for part in 0..samples * samples {
            let (right, down) = (whole(part % samples), whole(part / samples));
            let point = [whole(column) + step * (right + chance.next()), whole(row) + step * (down + chance.next())];
            let Some((at, to_camera)) = self.scene.ray(point, size) else { continue };
            let Some(point) = self.surface.at(at) else { continue };
            coverage += point.coverage;
            self.shade(&point, to_camera, &mut structural, &mut base);
        }
        let share = step * step;
        let of_base = self.base.map(|row| row[0] * base[0] + row[1] * base[1] + row[2] * base[2]);
        let [x, y, z]: [f64; 3] = std::array::from_fn(|channel| share * (structural[channel] + of_base[channel]));
        [x as f32, y as f32, z as f32, (share * coverage) as f32]
    }

    /// Adds the light of a point: XYZ of the scales, linear sRGB of the base.
    #[inline]
    fn shade(&self, point: &Point, to_camera: [f64; 3], structural: &mut [f64; 3], base: &mut [f64; 3]) {
        let normal = point.normal;
        let cos_sun = dot(normal, self.to_sun);
        let cos_camera = dot(normal, to_camera);
        if cos_sun <= 0.0 || cos_camera <= 0.0 {
            return;
        }
        for (sum, reflectance) in base.iter_mut().zip(point.base) {
            *sum += cos_sun * reflectance;
        }
        if point.structural <= 0.0 {
            return;
        }
        let [across, along] = frame(normal, point.ridge);
        let local = |direction: [f64; 3], upright: f64| [dot(across, direction), dot(along, direction), upright];
        let colour = self.colours.xyz(local(self.to_sun, cos_sun), local(to_camera, cos_camera), point.gap);
        for (sum, value) in structural.iter_mut().zip(colour) {
            *sum += point.structural * cos_sun * value;
        }
    }
}

/// Unit vectors across the ridges and along them, in the plane of the normal: the ridge's direction put upright on it.
#[inline]
fn frame(normal: [f64; 3], [x, y]: [f64; 2]) -> [[f64; 3]; 2] {
    let lean = normal[0] * x + normal[1] * y;
    let along = [x - lean * normal[0], y - lean * normal[1], -lean * normal[2]];
    // A normal above the square is never along a direction in it.
    let length = dot(along, along).sqrt().recip();
    let along = along.map(|component| length * component);
    let across = [
        along[1] * normal[2] - along[2] * normal[1],
        along[2] * normal[0] - along[0] * normal[2],
        along[0] * normal[1] - along[1] * normal[0],
    ];
    [across, along]
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Even numbers from 0 to 1 that follow from a pixel's place.
///
/// # Source
/// Steele, Lea and Flood 2014, DOI 10.1145/2660193.2660195: `SplitMix64`.
struct Chance(u64);

impl Chance {
    fn of(column: usize, row: usize) -> Self {
        let mut chance = Self(((row as u64) << 32) ^ column as u64);
        // Neighbours begin far from each other.
        Self(chance.bits())
    }

    #[inline]
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ (mixed >> 31)
    }

    #[inline]
    #[allow(clippy::cast_precision_loss, reason = "53 bits")]
    fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[inline]
#[allow(clippy::cast_precision_loss, reason = "pixels of a picture")]
fn whole(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_right_handed_and_flat_where_the_wing_is() {
        assert_eq!(frame([0.0, 0.0, 1.0], [0.0, 1.0]), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let normal = [0.6, 0.0, 0.8];
        let [across, along] = frame(normal, [0.6, 0.8]);
        for (product, expected) in [
            (dot(across, along), 0.0),
            (dot(across, normal), 0.0),
            (dot(along, normal), 0.0),
            (dot(across, across), 1.0),
            (dot(along, along), 1.0),
        ] {
            assert!((product - expected).abs() < 1e-12, "{product}");
        }
    }
}
