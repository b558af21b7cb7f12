//! Maps of a spread butterfly: what is drawn where the user has none.
//!
//! Each wing has coordinates of its own: the distance from its root, and lines that fan out from there. Veins lie along
//! these lines, the ridges of the scales point along them (away from the body), and so do the corrugations: folds between
//! the veins, and fine ones, the paper's "small corrugations in a radial pattern". Shapes and sizes are drawn by eye. The right
//! side is the mirror image of the left, but for the scatter of the single scales.

use super::base::BROWN;
use super::error::RenderError;
use super::maps::{GapMap, Maps};
use super::outline::{FOREWING, FOREWING_MARGIN, Field, HINDWING, HINDWING_MARGIN, closed, distance, part, within};
use super::raster::{self, Raster};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The butterfly that [`default_maps`] draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wing {
    /// Width and height of the maps, pixels.
    pub size: (usize, usize),
    /// Reflectance of the brown base, 0 to 0.571, at which its red is all light.
    pub base: f64,
    /// Mean gap, nm.
    pub gap: f64,
    /// Standard deviation of the gap over the wing, nm; 0 for none. No gap is farther from the mean than 2.5 of these.
    pub gap_spread: f64,
}

impl Wing {
    /// Height of a displacement of 1 that the relief is drawn for, in sides of the square.
    pub const RELIEF: f64 = 0.04;

    fn validate(&self) -> Result<(), RenderError> {
        let Self { size: (width, height), base, gap, gap_spread } = *self;
        raster::size(width, height)?;
        for (quantity, found, most, allowed) in [
            (
                "the reflectance of the base",
                base,
                BROWN[0].recip(),
                "0 to 0.571: the red of its brown is 1.75 times that",
            ),
            ("the spread of the gap, nm,", gap_spread, gap / ENDS, "0 to 0.4 of the gap"),
        ] {
            if !(0.0..=most).contains(&found) {
                return Err(RenderError::OutOfRange { quantity, found, allowed });
            }
        }
        Ok(())
    }
}

/// Standard deviations from the mean at which the range of gaps ends.
const ENDS: f64 = 2.5;
/// Standard deviation over the wings of the chance that moves the gap (measured; `tests/render.rs` holds it).
const GAP_CHANCE: f64 = 0.512;
/// How much the lines fan out with the distance from the root.
const FAN: f64 = 0.35;
/// Length and width of a scale, half sides: about 0.25 mm by 0.15 mm on wings 10 cm wide, twice the size of real ones so that a
/// picture shows them.
const SCALE: [f64; 2] = [0.011, 0.0065];
/// Scatter of the direction of single scales, rad.
const SCATTER: f64 = 0.12;
/// Half-width of a vein and its height; height of the folds between veins; half sides.
const VEIN: f64 = 0.0055;
const VEIN_HEIGHT: f64 = 0.0025;
const FOLD: f64 = 0.004;
/// Distance and height of the fine corrugations, half sides.
const CORRUGATION: f64 = 0.016;
const FINE: f64 = 0.000_17;
/// Heights of unevenness over a wing, and of single scales, half sides.
const UNEVEN: f64 = 0.0012;
const ROUGH: f64 = 0.000_22;
/// How far a wing is bent down at its edges, half sides at a distance of 1.
const CAMBER: f64 = 0.035;
/// Height of the body, as a part of a round one.
const BODY: f64 = 0.5;
/// Reflectance of pale spots.
const PALE: f64 = 0.55;

/// One wing of the right side; lengths in half sides of the square.
struct Part {
    root: [f64; 2],
    /// Angle of its middle line, rad from +x.
    middle: f64,
    /// Angles of the veins from there, rad, at the root.
    veins: [f64; 8],
    /// Distance from the outline, positive within.
    inside: Field,
    /// Distance from the outer margin.
    margin: Field,
    /// Width of the dark margin at the lower and at the upper end of the wing, and where these are.
    dark: [f64; 2],
    ends: [f64; 2],
    /// Pale spots: x, y and radius.
    spots: [[f64; 3]; 5],
}

impl Part {
    fn fields(outline: &[[f64; 2]], margin: std::ops::Range<usize>) -> (Field, Field) {
        let (whole, outer) = (closed(outline), part(outline, margin));
        let sign = |at| if within(at, &whole) { 1.0 } else { -1.0 };
        (Field::of(|at| sign(at) * distance(at, &whole)), Field::of(|at| distance(at, &outer)))
    }

    fn forewing() -> Self {
        let (inside, margin) = Self::fields(&FOREWING, FOREWING_MARGIN);
        let veins = [-0.40, -0.29, -0.17, -0.05, 0.06, 0.155, 0.235, 0.30];
        let spots = [
            [0.915, 0.655, 0.013],
            [0.892, 0.555, 0.011],
            [0.866, 0.455, 0.010],
            [0.845, 0.36, 0.009],
            [0.80, 0.735, 0.012],
        ];
        Self { root: [0.02, 0.06], middle: 0.36, veins, inside, margin, dark: [0.07, 0.17], ends: [0.0, 0.76], spots }
    }

    fn hindwing() -> Self {
        let (inside, margin) = Self::fields(&HINDWING, HINDWING_MARGIN);
        let veins = [-0.55, -0.42, -0.29, -0.16, -0.03, 0.11, 0.26, 0.42];
        let spots = [
            [0.772, -0.27, 0.007],
            [0.735, -0.42, 0.007],
            [0.66, -0.57, 0.007],
            [0.553, -0.68, 0.008],
            [0.425, -0.755, 0.009],
        ];
        let root = [0.01, 0.04];
        Self { root, middle: -0.62, veins, inside, margin, dark: [0.075, 0.06], ends: [-0.85, 0.06], spots }
    }
}

/// What is drawn at one place.
struct Drawn {
    coverage: f64,
    structural: f64,
    /// Displacement, half sides.
    height: f64,
    /// Direction of the ridges, rad from +x.
    ridge: f64,
    base: [f64; 3],
    /// Gap in standard deviations from its mean.
    gap: f64,
}

impl Drawn {
    /// With what shows beside it where it covers a part of the pixel: relief and ridges are its own.
    fn over(mut self, below: &Self) -> Self {
        let seen = (1.0 - self.coverage) * below.coverage;
        let total = self.coverage + seen;
        let share = seen / total;
        self.structural += share * (below.structural - self.structural);
        for (above, below) in self.base.iter_mut().zip(below.base) {
            *above += share * (below - *above);
        }
        self.coverage = total;
        self
    }
}

impl Part {
    /// At a place of the right half; `place` is where it is on the whole square, which chance goes by.
    fn drawn(&self, at: [f64; 2], place: [f64; 2], pixel: f64, base: f64) -> Option<Drawn> {
        let inside = self.inside.at(at);
        let coverage = (0.5 + inside / pixel).clamp(0.0, 1.0);
        if coverage <= 0.0 {
            return None;
        }
        let (right, up) = (at[0] - self.root[0], at[1] - self.root[1]);
        let reach = right.hypot(up);
        // The line through the place: its angle at the root, from which it fans out.
        let fan = 1.0 + FAN * reach;
        let line = (up.atan2(right) - self.middle) / fan;
        let across = line * fan * reach;
        let ridge = self.middle + line * fan + (reach * FAN * line).atan();
        let nearest = |veins: &[f64]| {
            let distances = veins.iter().map(|vein| fan * reach * (line - vein).abs());
            distances.fold(f64::INFINITY, f64::min)
        };
        let vein = (-(nearest(&self.veins) / VEIN).powi(2)).exp() * smooth(0.05, 0.15, reach);
        // Chance of the single scale.
        let mirrored = if place[0] < 0.0 { 57.0 } else { 0.0 };
        let scale = |seed| noise(reach / SCALE[0] + mirrored, across / SCALE[1], seed);
        let wide = |size: f64, seed| noise(reach / size + mirrored, across / size, seed);
        let upwards = ((at[1] - self.ends[0]) / (self.ends[1] - self.ends[0])).clamp(0.0, 1.0);
        let dark = self.dark[0] + upwards.powi(2) * (self.dark[1] - self.dark[0]);
        // The margin reaches inwards along the veins, and its edge is of single scales.
        let dark = dark * (1.0 + 0.25 * vein + 0.10 * wide(0.06, 1)) + 0.006 * scale(2);
        let lit = smooth(0.0, 0.02, self.margin.at(at) - dark) * smooth(0.004, 0.016, inside + 0.003 * scale(3));
        // The root is dusted with dark hairs.
        let lit = lit * smooth(0.06, 0.20, reach + 0.03 * wide(0.03, 4));
        let spot = self.spots.iter().map(|[x, y, radius]| {
            let away = (at[0] - x).hypot(at[1] - y) + 0.003 * scale(5);
            1.0 - smooth(0.6 * radius, 1.1 * radius, away)
        });
        let spot = spot.fold(0.0, f64::max);
        let structural = lit * (1.0 - 0.75 * vein) * (0.94 + 0.06 * scale(6)) * (1.0 - spot);
        // Folds between the veins, fine corrugations, scales, and the camber of the whole.
        let fold = wave(&self.veins, line) * FOLD * smooth(0.05, 0.5, reach);
        let fine = (TAU * across / CORRUGATION + 2.0 * wide(0.15, 7)).sin() * FINE * (1.0 + 0.5 * wide(0.1, 8));
        let camber = -CAMBER * (across * across + 0.4 * reach * reach);
        let height = camber + fold + fine + VEIN_HEIGHT * vein + UNEVEN * wide(0.09, 9) + ROUGH * scale(10);
        let pale = base.max(PALE * spot);
        let brown = BROWN.map(|channel| base * (0.6 + 0.4 * lit) * channel * (1.0 - spot) + spot * pale);
        let gap = (0.8 * wide(0.2, 11) + 0.9 * scale(12)) / GAP_CHANCE;
        Some(Drawn { coverage, structural, height, ridge: ridge + SCATTER * scale(13), base: brown, gap })
    }
}

/// The body: thorax, abdomen and head, without structural colour, and the feelers.
fn body([x, y]: [f64; 2], pixel: f64, base: f64) -> Option<Drawn> {
    let round = |centre: f64, half_width: f64, half_length: f64| {
        let (across, along) = (x / half_width, (y - centre) / half_length);
        let out = (across * across + along * along).sqrt();
        ((1.0 - out) * half_width, half_width * (1.0 - out * out).max(0.0).sqrt())
    };
    let parts = [round(0.10, 0.045, 0.13), round(-0.17, 0.032, 0.21), round(0.245, 0.024, 0.03)];
    let (inside, height) =
        parts.into_iter().fold((f64::NEG_INFINITY, 0.0_f64), |best, part| (best.0.max(part.0), best.1.max(part.1)));
    let feeler = [[0.008, 0.26], [0.06, 0.40], [0.15, 0.53], [0.235, 0.60]];
    let club = 0.004 + 0.006 * smooth(0.54, 0.60, y);
    let inside = inside.max(club - distance([x, y], &feeler));
    let coverage = (0.5 + inside / pixel).clamp(0.0, 1.0);
    let hair = 0.7 + 0.3 * noise(x / 0.006, y / 0.02, 14);
    let base = BROWN.map(|channel| hair * base * channel);
    let height = BODY * height;
    (coverage > 0.0).then_some(Drawn { coverage, structural: 0.0, height, ridge: 0.5 * PI, base, gap: 0.0 })
}

/// Maps of a spread butterfly.
///
/// # Errors
/// [`RenderError`] for a size, a base or gaps out of range.
///
/// ```
/// use morpho_fit::render::{Wing, default_maps};
/// let maps = default_maps(&Wing { size: (64, 64), base: 0.03, gap: 141.0, gap_spread: 0.0 })?;
/// assert_eq!((maps.mask.width(), maps.mask.channels(), maps.gap), (64, 2, None));
/// # Ok::<(), morpho_fit::render::RenderError>(())
/// ```
pub fn default_maps(wing: &Wing) -> Result<Maps, RenderError> {
    let Wing { size, base, gap, gap_spread } = *wing;
    let (width, height) = size;
    wing.validate()?;
    let parts = [Part::forewing(), Part::hindwing()];
    let pixel = [2.0 / whole(width), 2.0 / whole(height)];
    let edge = 0.5 * (pixel[0] + pixel[1]);
    // Height, angle (two), mask (two), base (three), gap.
    let mut values = vec![[0.0_f32; 9]; width * height];
    values.par_chunks_mut(width).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            let place = [pixel[0] * (whole(column) + 0.5) - 1.0, 1.0 - pixel[1] * (whole(row) + 0.5)];
            *out = texel(&parts, place, edge, base).map(single);
        }
    });
    let channels = |from: usize, count: usize| {
        let values = values.iter().flat_map(|value| value.iter().skip(from).take(count)).copied().collect();
        Raster::new(width, height, count, values)
    };
    // A third channel makes the directions a colour image.
    let angle = values.iter().flat_map(|value| [value[1], value[2], 0.5]).collect();
    let range = [gap - ENDS * gap_spread, gap + ENDS * gap_spread];
    let gap =
        (gap_spread > 0.0).then(|| Ok::<_, RenderError>(GapMap { raster: channels(8, 1)?, range })).transpose()?;
    Ok(Maps {
        height: channels(0, 1)?,
        angle: Raster::new(width, height, 3, angle)?,
        mask: channels(3, 2)?,
        base: channels(5, 3)?,
        gap,
    })
}

/// Maps of a plain square: no relief, ridges upwards, wing all over, a brown base.
///
/// # Errors
/// As [`default_maps`]; there is no map of the gap.
pub fn plain_maps(wing: &Wing) -> Result<Maps, RenderError> {
    wing.validate()?;
    let (width, height) = wing.size;
    let even = |value: &[f64]| {
        let value: Vec<f32> = value.iter().copied().map(single).collect();
        Raster::new(width, height, value.len(), value.repeat(width * height))
    };
    Ok(Maps {
        height: even(&[0.5])?,
        angle: even(&[0.0])?,
        mask: even(&[1.0, 1.0])?,
        base: even(&BROWN.map(|channel| wing.base * channel))?,
        gap: None,
    })
}

fn texel(parts: &[Part; 2], place: [f64; 2], pixel: f64, base: f64) -> [f64; 9] {
    let right = [place[0].abs(), place[1]];
    let mut seen: Option<Drawn> = None;
    // The upper one hides the lower.
    for part in [None, Some(&parts[0]), Some(&parts[1])] {
        if seen.as_ref().is_some_and(|seen| seen.coverage >= 1.0) {
            break;
        }
        let drawn = part.map_or_else(|| body(right, pixel, base), |part| part.drawn(right, place, pixel, base));
        seen = match (seen, drawn) {
            (Some(above), Some(below)) => Some(above.over(&below)),
            (above, below) => above.or(below),
        };
    }
    let Some(top) = seen else {
        return [0.5, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5];
    };
    let ridge = if place[0] < 0.0 { PI - top.ridge } else { top.ridge };
    // From the upward direction.
    let (sin, cos) = (ridge - 0.5 * PI).sin_cos();
    // Half sides to parts of the relief, which is in sides.
    let height = 0.5 + 0.5 * top.height / Wing::RELIEF;
    let [red, green, blue] = top.base;
    let gap = 0.5 + 0.5 * top.gap / ENDS;
    [height, 0.5 + 0.5 * cos, 0.5 + 0.5 * sin, top.structural, top.coverage, red, green, blue, gap]
        .map(|value| value.clamp(0.0, 1.0))
}

/// 1 halfway between neighbouring veins and 0 on them.
fn wave(veins: &[f64], line: f64) -> f64 {
    let pair = veins.windows(2).find(|pair| (pair[0]..pair[1]).contains(&line));
    pair.map_or(0.0, |pair| (PI * (line - pair[0]) / (pair[1] - pair[0])).sin())
}

/// From 0 at `from` to 1 at `to`, without a bend.
fn smooth(from: f64, to: f64, at: f64) -> f64 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Smooth chance from -1 to 1: values at whole numbers by chance, smooth between them.
fn noise(x: f64, y: f64, seed: u64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let (right, up) = (smooth(0.0, 1.0, x - column), smooth(0.0, 1.0, y - row));
    #[allow(clippy::cast_possible_truncation, reason = "some thousand cells")]
    let value = |columns: i64, rows: i64| chance(column as i64 + columns, row as i64 + rows, seed);
    let lower = value(0, 0) + right * (value(1, 0) - value(0, 0));
    let upper = value(0, 1) + right * (value(1, 1) - value(0, 1));
    lower + up * (upper - lower)
}

/// A number from -1 to 1 that follows from three whole ones.
fn chance(column: i64, row: i64, seed: u64) -> f64 {
    let mut mixed = (column.cast_unsigned().wrapping_mul(0x9E37_79B9_7F4A_7C15))
        ^ (row.cast_unsigned().wrapping_mul(0xC2B2_AE3D_27D4_EB4F))
        ^ seed.wrapping_mul(0x1656_67B1_9E37_79F9);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    #[allow(clippy::cast_precision_loss, reason = "53 bits")]
    let share = ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64;
    2.0 * share - 1.0
}

#[allow(clippy::cast_possible_truncation, reason = "maps are in single precision")]
fn single(value: f64) -> f32 {
    value as f32
}

#[allow(clippy::cast_precision_loss, reason = "sides of an image")]
fn whole(count: usize) -> f64 {
    count as f64
}
