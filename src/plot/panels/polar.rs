//! The frame of a polar panel: half rings and spokes about the origin. All lengths are picture units.

use super::super::canvas::{Anchor, Canvas, Lettering, Stroke};
use super::super::palette::{GRID, SOFT_INK};
use super::data::Plot;
use super::layout::lettering;
use super::panel::TICK_EM;

/// Room around the largest radius, as parts of it: beside, below and above.
const ROOM: (f64, f64, f64) = (1.22, 0.14, 1.2);
/// Where the numbers of the spokes stand, as a part of the largest radius.
const NUMBERS: f64 = 1.1;
/// Spokes, degrees.
const SPOKES: [i32; 7] = [-90, -60, -30, 0, 30, 60, 90];
/// Half the angles between two corners of a ring, degrees.
const CORNERS: usize = 90;

/// Height over width of a plot whose rings are round.
pub(in crate::plot) const ASPECT: f64 = (ROOM.1 + ROOM.2) / (2.0 * ROOM.0);

/// The ranges of x and y about a half disc.
pub(super) fn ranges(radius: f64) -> ((f64, f64), (f64, f64)) {
    ((-ROOM.0 * radius, ROOM.0 * radius), (-ROOM.1 * radius, ROOM.2 * radius))
}

/// Draws rings at the ticks of y with their numbers, and spokes with their angles.
pub(super) fn grid(canvas: &mut Canvas, plot: &Plot<'_>) {
    let (low, high) = plot.y.ends();
    let radius = (high - low) / (ROOM.1 + ROOM.2);
    let point = |radius: f64, angle: f64| plot.at(radius * angle.sin(), radius * angle.cos());
    let stroke = Stroke::solid(GRID, 1.0);
    let ring = |radius: f64| -> Vec<(f64, f64)> {
        let angle = |corner: usize| (corner as f64 / CORNERS as f64 - 1.0) * std::f64::consts::FRAC_PI_2;
        (0..=2 * CORNERS).map(|corner| point(radius, angle(corner))).collect()
    };
    let small = Lettering { anchor: Anchor::Middle, ..lettering(TICK_EM, false, SOFT_INK) };
    for tick in &plot.y.ticks {
        let value = low + tick.place * (high - low);
        if value > 0.0 && value <= radius * (1.0 + 1e-9) {
            canvas.polyline(&ring(value), stroke);
        }
    }
    canvas.polyline(&ring(radius), stroke);
    for degrees in SPOKES {
        let angle = f64::from(degrees).to_radians();
        canvas.polyline(&[point(0.0, angle), point(radius, angle)], stroke);
        let (x, y) = point(NUMBERS * radius, angle);
        canvas.text((x, y + 0.36 * TICK_EM), &format!("{degrees}°").replace('-', "−"), small);
    }
}

/// Writes the numbers of the rings, above the lines, below the horizon.
pub(super) fn numbers(canvas: &mut Canvas, plot: &Plot<'_>) {
    let (low, high) = plot.y.ends();
    let radius = (high - low) / (ROOM.1 + ROOM.2);
    let small = Lettering { anchor: Anchor::Middle, ..lettering(TICK_EM, false, SOFT_INK) };
    for tick in &plot.y.ticks {
        let value = low + tick.place * (high - low);
        if value >= 0.0 && value <= radius * (1.0 + 1e-9) {
            let (x, y) = plot.at(value, 0.0);
            canvas.text((x, y + 1.3 * TICK_EM), &tick.label, small);
        }
    }
}
