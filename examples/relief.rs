//! Whether relief must hide and shift what the camera sees, or may turn normals alone: rays marched through the displaced
//! butterfly, against the flat square with its normals.
//!
//! `cargo run --release --example relief` prints the table that `render`'s page quotes, in a minute.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "pixels and single precision of small images"
)]

use morpho_fit::colorimetry::{ColourError, Illuminant, Integration, Lab, Observer, Xyz};
use morpho_fit::optics::{HybridModel, Structure};
use morpho_fit::render::{ColourLookup, Raster, Scene, Seen, Surface, Wing, default_maps};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::units::radians;

/// Rays each way.
const RAYS: usize = 512;
/// Steps of a ray through the relief, then halvings.
const STEPS: usize = 400;
const HALVINGS: usize = 30;
/// Pixels each way of the blocks whose colours are compared: what an eye sees of a picture 128 pixels wide, and single ones.
const BLOCK: usize = 4;

struct Relief {
    height: Raster,
    surface: Surface,
    colours: ColourLookup,
    scale: f64,
}

impl Relief {
    /// Displacement above the square's middle height, half sides.
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let size = self.height.width() as f64;
        let place = |part: f64| (part * size - 0.5).clamp(0.0, size - 1.0);
        let (across, down) = (place(0.5 + 0.5 * x), place(0.5 - 0.5 * y));
        let (column, row) = (across.floor() as usize, down.floor() as usize);
        let (right, below) = (across.fract() as f32, down.fract() as f32);
        let level = |column, row| self.height.at(column, row, 0);
        let upper = level(column, row) + right * (level(column + 1, row) - level(column, row));
        let lower = level(column, row + 1) + right * (level(column + 1, row + 1) - level(column, row + 1));
        2.0 * self.scale * (f64::from(upper + below * (lower - upper)) - 0.5)
    }

    /// XYZ at a place of the square seen from `to_camera`, without a base.
    fn colour(&self, at: [f64; 2], to_camera: [f64; 3], to_sun: [f64; 3]) -> Option<[f64; 3]> {
        let point = self.surface.at(at).filter(|point| point.structural > 0.0)?;
        let (n, [x, y]) = (point.normal, point.ridge);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let lean = dot(n, [x, y, 0.0]);
        let along = [x - lean * n[0], y - lean * n[1], -lean * n[2]];
        let along = along.map(|component| component / dot(along, along).sqrt());
        let across =
            [along[1] * n[2] - along[2] * n[1], along[2] * n[0] - along[0] * n[2], along[0] * n[1] - along[1] * n[0]];
        let local = |w| [dot(across, w), dot(along, w), dot(n, w)];
        let colour = self.colours.xyz(local(to_sun), local(to_camera), point.gap);
        Some(colour.map(|value| point.structural * dot(n, to_sun).max(0.0) * value))
    }

    /// Where a ray that meets the flat square at `at` meets the relief first.
    fn met(&self, at: [f64; 2], to_camera: [f64; 3]) -> [f64; 2] {
        let reach = self.scale / to_camera[2];
        let place = |along: f64| [at[0] + along * to_camera[0], at[1] + along * to_camera[1]];
        let above = |along: f64| along * to_camera[2] - self.at(place(along));
        let step = 2.0 * reach / STEPS as f64;
        let mut first = reach;
        for count in 1..=STEPS {
            let next = reach - step * count as f64;
            if above(next) <= 0.0 {
                let (mut out, mut within) = (first, next);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (out + within);
                    if above(middle) > 0.0 { out = middle } else { within = middle }
                }
                return place(within);
            }
            first = next;
        }
        at
    }

    /// Whether relief stands between the surface above `at` and the camera.
    fn is_hidden(&self, at: [f64; 2], to_camera: [f64; 3]) -> bool {
        let base = self.at(at);
        let reach = (self.scale - base) / to_camera[2];
        (1..=STEPS).any(|count| {
            let along = reach * count as f64 / STEPS as f64;
            let place = [at[0] + along * to_camera[0], at[1] + along * to_camera[1]];
            self.at(place) > base + along * to_camera[2] + 1e-5
        })
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let blue = Structure::blue();
    let grid = Wavelengths::visible(10.0)?;
    let integration = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?;
    let seen = Seen { wavelengths: &grid, integration: &integration };
    let colours = ColourLookup::new(&HybridModel::default(), &blue, [blue.d_air; 2], &seen, 0.5)?;
    let maps = default_maps(&Wing { size: (1024, 1024), base: 0.0, gap: blue.d_air, gap_spread: 0.0 })?;
    let surface = Surface::new(&maps, Wing::RELIEF, blue.d_air)?;
    let relief = Relief { height: maps.height, surface, colours, scale: Wing::RELIEF };
    println!("view/deg  hidden/%  mean shift/sides  dE00 of blocks: mean, median");
    for view in [10.0, 30.0, 50.0, 60.0] {
        let scene = Scene::vertical_sun(radians(view));
        let to_sun = scene.to_sun();
        let (mut hidden, mut wing, mut shift) = (0_usize, 0_i32, 0.0);
        let blocks = RAYS / BLOCK;
        let mut sums = vec![([0.0; 3], [0.0; 3], 0); blocks * blocks];
        for row in 0..RAYS {
            for column in 0..RAYS {
                let point = [column as f64 + 0.5, row as f64 + 0.5];
                let Some((at, to_camera)) = scene.ray(point, [RAYS as f64; 2]) else { continue };
                let Some(flat) = relief.colour(at, to_camera, to_sun) else { continue };
                let met = relief.met(at, to_camera);
                wing += 1;
                hidden += usize::from(relief.is_hidden(at, to_camera));
                shift += 0.5 * (met[0] - at[0]).hypot(met[1] - at[1]);
                let displaced = relief.colour(met, to_camera, to_sun).unwrap_or_default();
                let block = &mut sums[(row / BLOCK) * blocks + column / BLOCK];
                for channel in 0..3 {
                    block.0[channel] += flat[channel];
                    block.1[channel] += displaced[channel];
                }
                block.2 += 1;
            }
        }
        let full = (BLOCK * BLOCK) as i32;
        let mut differences: Vec<f64> = (sums.iter().filter(|(_, _, count)| *count == full))
            .map(|(flat, displaced, _)| {
                let lab = |sum: &[f64; 3]| {
                    let mean = sum.map(|value| 2.0 * value / f64::from(full));
                    Lab::new(Xyz::from_array(mean), integration.white())
                };
                Ok(lab(flat)?.difference(lab(displaced)?))
            })
            .collect::<Result<_, ColourError>>()?;
        differences.sort_by(f64::total_cmp);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let median = differences[differences.len() / 2];
        let share = 100.0 * hidden as f64 / f64::from(wing);
        println!("{view:8}  {share:8.3}  {:16.5}  {mean:.2} {median:.2}", shift / f64::from(wing));
    }
    Ok(())
}
