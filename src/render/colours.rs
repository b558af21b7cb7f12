//! The colour of any pair of directions: a table of two axes, or three, times a factor.

use super::error::RenderError;
use crate::colorimetry::{ColourError, Integration, Lab, Xyz};
use crate::geometry::Polarization;
use crate::numerics::dot::dot;
use crate::optics::hybrid::{Pair, Shape, layer_angle, require_narrow, slit_share};
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::{Join, Media, OpticsError, ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Largest `v` and `|u_x|`: two unit vectors that point the same way.
const FARTHEST: f64 = 2.0;
/// Intervals of each axis of directions to begin with, and of the gap.
const FIRST: usize = 16;
const FIRST_GAPS: usize = 1;
/// Nodes at most, 128 MB.
const MOST_NODES: usize = 1 << 23;
/// Part of the tolerance that a midpoint on one axis may take: the errors of two axes add.
const OF_ONE_AXIS: f64 = 0.5;
/// Random directions that the finished table is judged at.
const JUDGED: usize = 4096;
/// Random directions whose spectra choose the wavelengths.
const PROBES: usize = 400;
/// Seed of these directions.
const SEED: u64 = 1;

/// What the colours are seen with.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// Wavelengths of the spectra, nm.
    pub wavelengths: &'a Wavelengths,
    /// Observer and light at these.
    pub integration: &'a Integration,
}

/// How far interpolated colours are from those of spectra at the same wavelengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookupError {
    /// Largest CIEDE2000 difference of pixels. Their light holds `cos_i`, which is at most `min(1, v)`: the colour is taken
    /// times that, and the brightest of the table as light as white.
    pub worst: f64,
    /// Mean difference.
    pub mean: f64,
    /// Random pairs of directions (and gaps) that were compared.
    pub compared: usize,
}

/// XYZ of `pi f`, for any pair of directions and any gap within a range.
///
/// ```text
/// pi f -> XYZ = shape(w_i, w_o) · T(d_air, v, |u_x|),   T = pi sum_λ w(λ) R(λ, v) sinc²(k a u_x / 2) / λ
/// ```
///
/// T is linear in the gap, in `sqrt(v / 2)` and in `|u_x|` between regular nodes, as many as a tolerance needs; the shape is exact.
/// Near `v = 0` the light grazes the layers and R rises steeply to 1: the root puts more nodes there.
///
/// ```
/// use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
/// use morpho_fit::optics::{HybridModel, Structure};
/// use morpho_fit::render::{ColourLookup, Seen};
/// use morpho_fit::spectrum::Wavelengths;
/// let wavelengths = Wavelengths::visible(10.0)?;
/// let integration = Integration::new(&wavelengths, Observer::Cie1931, &Illuminant::D65)?;
/// let seen = Seen { wavelengths: &wavelengths, integration: &integration };
/// let blue = ColourLookup::new(&HybridModel::default(), &Structure::blue(), [141.0; 2], &seen, 0.5)?;
/// let [x, y, z] = blue.xyz([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], 141.0);
/// assert!(z > x && z > y && blue.error().worst < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ColourLookup {
    shape: Shape,
    /// First gap and last, nm.
    gaps: [f64; 2],
    /// Nodes of gap, v and `|u_x|`.
    nodes: [usize; 3],
    /// Nodes for each nm of gap and each unit of the directions.
    scale: [f32; 3],
    values: Vec<[f32; 4]>,
    error: LookupError,
}

impl ColourLookup {
    /// The table of `structure`, whose `d_air` may be anything from `gaps[0]` to `gaps[1]`, nm, in unpolarized light.
    ///
    /// # Errors
    /// [`RenderError`] for a model that is a sum of planes, a structure or a range out of range, and for a `tolerance`
    /// (CIEDE2000) that is not above 0 or asks for more than 8 million nodes.
    pub fn new(
        model: &dyn ReflectivityModel,
        structure: &Structure,
        gaps: [f64; 2],
        seen: &Seen<'_>,
        tolerance: f64,
    ) -> Result<Self, RenderError> {
        if !(tolerance > 0.0) {
            let quantity = "the tolerance, ΔE₀₀,";
            return Err(RenderError::OutOfRange { quantity, found: tolerance, allowed: "above 0" });
        }
        let spectra = Spectra::new(model, structure, gaps, seen.wavelengths)?.weighted_by(seen.integration)?;
        let mut intervals = [if gaps[1] > gaps[0] { FIRST_GAPS } else { 0 }, FIRST, FIRST];
        loop {
            let mut table = spectra.table(intervals)?;
            let gap = if intervals[0] > 0 { spectra.midpoints(&table, 0)? } else { 0.0 };
            let offsets = [gap, spectra.midpoints(&table, 1)?, spectra.midpoints(&table, 2)?];
            if offsets.iter().all(|offset| *offset <= OF_ONE_AXIS * tolerance) {
                table.error = spectra.judged(&table)?;
                if table.error.worst <= tolerance {
                    return Ok(table);
                }
            }
            // The axis that is worst is halved.
            let worst = (0..3).max_by(|&a, &b| offsets[a].total_cmp(&offsets[b])).unwrap_or_default();
            intervals[worst] *= 2;
            let nodes = intervals.iter().map(|count| count + 1).product();
            if nodes > MOST_NODES {
                return Err(RenderError::TooLarge { nodes, worst: offsets[worst], tolerance });
            }
        }
    }

    /// XYZ of `pi f` (a white diffuser has Y = 1) for unit vectors to source and eye: x across the ridges, y along them, z along
    /// the normal. Below the horizon it is black. A gap beyond the range is taken at its end.
    #[inline]
    #[must_use]
    pub fn xyz(&self, incoming: [f64; 3], outgoing: [f64; 3], gap: f64) -> [f64; 3] {
        if incoming[2] < 0.0 || outgoing[2] < 0.0 {
            return [0.0; 3];
        }
        let pair = Pair::new(incoming, outgoing);
        let shape = self.shape.at(&pair);
        if shape <= 0.0 {
            return [0.0; 3];
        }
        self.interpolated(gap, pair.v, pair.u_x.abs()).map(|value| shape * f64::from(value))
    }

    /// Spectra of the light of pixels ([`LookupError::worst`]) in random pairs of directions and gaps, by 1 nm
    /// ([`Wavelengths::finest`]), the brightest value among them being 1: what [`Sampling::coarsest`](crate::sweep::Sampling::coarsest) chooses the wavelengths by.
    ///
    /// # Shape
    /// `[spectrum][401]`.
    ///
    /// # Errors
    /// As [`ColourLookup::new`].
    pub fn probes(
        model: &dyn ReflectivityModel,
        structure: &Structure,
        gaps: [f64; 2],
    ) -> Result<Vec<Vec<f64>>, RenderError> {
        let spectra = Spectra::new(model, structure, gaps, &Wavelengths::finest())?;
        let mut found = Vec::with_capacity(PROBES);
        for [gap, v, u] in spectra.random(PROBES) {
            let reflectivity = spectra.reflectivity(gap, v)?;
            found.push(
                reflectivity.iter().zip(spectra.slits(u)).map(|(value, slit)| value * slit).collect::<Vec<f64>>(),
            );
        }
        let brightest = found.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        found.iter_mut().flatten().for_each(|value| *value /= brightest);
        Ok(found)
    }

    /// Nodes of the gap, of `v` and of `|u_x|`.
    #[must_use]
    pub fn nodes(&self) -> [usize; 3] {
        self.nodes
    }

    /// Bytes of the table.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// How far it is from spectra.
    #[must_use]
    pub fn error(&self) -> LookupError {
        self.error
    }

    #[inline]
    fn interpolated(&self, gap: f64, v: f64, u: f64) -> [f32; 3] {
        let [gaps, rows, columns] = self.nodes;
        let (row, down) = place((0.5 * v).sqrt(), self.scale[1], rows);
        let (column, right) = place(u, self.scale[2], columns);
        let plane = |plane: usize| {
            let first = (plane * rows + row) * columns + column;
            mix(self.between(first, right), self.between(first + columns, right), down)
        };
        let [x, y, z, _] = if gaps > 1 {
            let (first, share) = place(gap - self.gaps[0], self.scale[0], gaps);
            mix(plane(first), plane(first + 1), share)
        } else {
            plane(0)
        };
        [x, y, z]
    }

    /// The value between node `first` and the next one.
    #[inline]
    fn between(&self, first: usize, share: f32) -> [f32; 4] {
        match self.values.get(first..first + 2) {
            Some([near, far]) => mix(*near, *far, share),
            _ => [0.0; 4],
        }
    }
}

/// The node below `at`, at most the last but one, and the share of the next one.
#[inline]
fn place(at: f64, scale: f32, nodes: usize) -> (usize, f32) {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the axis")]
    #[allow(clippy::cast_precision_loss, reason = "at most some thousand nodes")]
    let (at, last) = ((at as f32 * scale).max(0.0), (nodes - 1) as f32);
    let at = at.min(last);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the axis")]
    let below = (at as usize).min(nodes.saturating_sub(2));
    #[allow(clippy::cast_precision_loss, reason = "at most some thousand nodes")]
    let share = at - below as f32;
    (below, share)
}

#[inline]
fn mix(near: [f32; 4], far: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|channel| near[channel] + share * (far[channel] - near[channel]))
}

/// What the table is filled from.
struct Spectra<'a> {
    model: &'a dyn ReflectivityModel,
    structure: Structure,
    gaps: [f64; 2],
    shape: Shape,
    media: Vec<Media>,
    /// `2 pi / wavelength` in vacuum, 1/nm.
    wavenumbers: Vec<f64>,
    /// In the ambient medium, nm.
    ambient: Vec<f64>,
    /// Of X, Y and Z, with pi in them.
    weights: [Vec<f64>; 3],
    white: Xyz,
}

impl<'a> Spectra<'a> {
    fn new(
        model: &'a dyn ReflectivityModel,
        structure: &Structure,
        gaps: [f64; 2],
        wavelengths: &Wavelengths,
    ) -> Result<Self, RenderError> {
        model.validate()?;
        let Join::Product { ridge_spacing } = model.join() else {
            return Err(RenderError::Planes { name: model.name() });
        };
        for gap in gaps {
            Structure { d_air: gap, ..*structure }.validate()?;
        }
        if gaps[0] > gaps[1] {
            let quantity = "the first gap, nm,";
            return Err(RenderError::OutOfRange { quantity, found: gaps[0], allowed: "at most the last gap" });
        }
        require_narrow(structure, ridge_spacing)?;
        let wavelengths: Vec<f64> = wavelengths.iter().collect();
        let mut media =
            wavelengths.iter().map(|&wavelength| model.stack().media(wavelength)).collect::<Result<Vec<_>, _>>()?;
        let ambient = media.iter().map(|media| media.wavelength / media.ambient).collect();
        Media::join(&mut media);
        let wavenumbers = wavelengths.iter().map(|wavelength| TAU / wavelength).collect();
        let shape = Shape::of(structure, ridge_spacing);
        let (weights, white) = Default::default();
        Ok(Self { model, structure: *structure, gaps, shape, media, wavenumbers, ambient, weights, white })
    }

    fn weighted_by(mut self, integration: &Integration) -> Result<Self, ColourError> {
        self.white = integration.white();
        self.weights = integration.relative_weights();
        let (wavelengths, found) = (integration.wavelengths(), self.wavenumbers.len());
        if wavelengths != found {
            return Err(ColourError::Length { wavelengths, found });
        }
        for (weights, white) in self.weights.iter_mut().zip(self.white.to_array()) {
            weights.iter_mut().for_each(|weight| *weight *= PI * white);
        }
        Ok(self)
    }

    /// Gaps, `v` and `|u_x|` by chance, of unit vectors.
    fn random(&self, count: usize) -> Vec<[f64; 3]> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
        let mut found = Vec::with_capacity(count);
        while found.len() < count {
            let [gap, v, u] = std::array::from_fn(|_| random.random::<f64>());
            if u * u + v * v <= 1.0 {
                found.push([self.gaps[0] + gap * (self.gaps[1] - self.gaps[0]), FARTHEST * v, FARTHEST * u]);
            }
        }
        found
    }

    /// Values at regular nodes, in parallel; the same bits on any number of threads.
    fn table(&self, intervals: [usize; 3]) -> Result<ColourLookup, RenderError> {
        let nodes = intervals.map(|count| count + 1);
        let [gaps, rows, columns] = nodes;
        let slits: Vec<Vec<f64>> =
            (0..columns).map(|column| self.slits(part(column, intervals[2]) * FARTHEST)).collect();
        let mut values = vec![[0.0; 4]; gaps * rows * columns];
        values.par_chunks_mut(columns).enumerate().try_for_each(|(row, out)| {
            let gap = self.gaps[0] + part(row / rows, intervals[0]) * (self.gaps[1] - self.gaps[0]);
            let weighted = self.weighted(gap, layers_cosine(part(row % rows, intervals[1])))?;
            for (out, slits) in out.iter_mut().zip(&slits) {
                let [x, y, z] = sums(&weighted, slits).map(single);
                *out = [x, y, z, 0.0];
            }
            Ok::<(), OpticsError>(())
        })?;
        let range = self.gaps[1] - self.gaps[0];
        let per = |count: usize, length: f64| if length > 0.0 { single(whole(count) / length) } else { 0.0 };
        let scale = [per(intervals[0], range), per(intervals[1], 1.0), per(intervals[2], FARTHEST)];
        let error = LookupError { worst: f64::INFINITY, mean: f64::INFINITY, compared: 0 };
        Ok(ColourLookup { shape: self.shape, gaps: self.gaps, nodes, scale, values, error })
    }

    /// R at every wavelength.
    fn reflectivity(&self, gap: f64, v: f64) -> Result<Vec<f64>, OpticsError> {
        let mut both = vec![SAndP::default(); self.wavenumbers.len()];
        let period = Period::of(&Structure { d_air: gap, ..self.structure });
        self.model.stack_reflectivities(&self.media, &self.wavenumbers, period, layer_angle(v), &mut both)?;
        let (s, p) = Polarization::Unpolarized.shares();
        Ok(both.iter().map(|both| s * both.s + p * both.p).collect())
    }

    /// The same times the weights.
    fn weighted(&self, gap: f64, v: f64) -> Result<[Vec<f64>; 3], OpticsError> {
        let reflectivity = self.reflectivity(gap, v)?;
        Ok(self.weights.each_ref().map(|weights| weights.iter().zip(&reflectivity).map(|(a, b)| a * b).collect()))
    }

    /// The part of the lamellae at every wavelength.
    fn slits(&self, u: f64) -> Vec<f64> {
        let one = |&wavelength: &f64| slit_share(PI * u / wavelength, self.structure.lamella_width, wavelength.recip());
        self.ambient.iter().map(one).collect()
    }

    /// Largest difference halfway between the nodes of one axis, at the nodes of the others.
    fn midpoints(&self, table: &ColourLookup, axis: usize) -> Result<f64, RenderError> {
        let counts = [0, 1, 2].map(|other| table.nodes[other] - usize::from(other == axis));
        let ends = [self.gaps, [0.0, 1.0], [0.0, FARTHEST]];
        let at = |other: usize, index: usize| {
            let shift = if other == axis { 0.5 } else { 0.0 };
            let share = (whole(index) + shift) / whole((table.nodes[other] - 1).max(1));
            ends[other][0] + share * (ends[other][1] - ends[other][0])
        };
        let slits: Vec<Vec<f64>> = (0..counts[2]).map(|column| self.slits(at(2, column))).collect();
        let scale = self.brightest(table);
        let rows = (0..counts[0] * counts[1]).into_par_iter().map(|row| {
            let (gap, v) = (at(0, row / counts[1]), layers_cosine(at(1, row % counts[1])));
            let weighted = self.weighted(gap, v)?;
            let mut worst = 0.0_f64;
            for (column, slits) in slits.iter().enumerate() {
                let u = at(2, column);
                // No two unit vectors meet there.
                if u * u + v * v <= FARTHEST * FARTHEST {
                    let found = table.interpolated(gap, v, u).map(f64::from);
                    worst = worst.max(self.difference(sums(&weighted, slits), found, scale * v.min(1.0))?);
                }
            }
            Ok::<f64, RenderError>(worst)
        });
        rows.try_reduce(|| 0.0, |one, other| Ok(one.max(other)))
    }

    /// Differences in random directions.
    fn judged(&self, table: &ColourLookup) -> Result<LookupError, RenderError> {
        let (scale, seen) = (self.brightest(table), self.random(JUDGED));
        let one = |&[gap, v, u]: &[f64; 3]| {
            let right = sums(&self.weighted(gap, v)?, &self.slits(u));
            self.difference(right, table.interpolated(gap, v, u).map(f64::from), scale * v.min(1.0))
        };
        let found = seen.par_iter().map(one).collect::<Result<Vec<f64>, RenderError>>()?;
        let worst = found.iter().copied().fold(0.0, f64::max);
        Ok(LookupError { worst, mean: found.iter().sum::<f64>() / whole(found.len()), compared: found.len() })
    }

    /// What makes the lightest pixel as light as white.
    fn brightest(&self, table: &ColourLookup) -> f64 {
        let [_, rows, columns] = table.nodes;
        let one = |(index, value): (usize, &[f32; 4])| {
            let v = layers_cosine(part(index / columns % rows, rows - 1));
            v.min(1.0) * f64::from(value[1])
        };
        let lightest = table.values.iter().enumerate().map(one).fold(0.0, f64::max);
        if lightest > 0.0 { lightest.recip() } else { 1.0 }
    }

    fn difference(&self, right: [f64; 3], found: [f64; 3], scale: f64) -> Result<f64, RenderError> {
        let lab = |colour: [f64; 3]| Lab::new(Xyz::from_array(colour.map(|value| scale * value)), self.white);
        Ok(lab(right)?.difference(lab(found)?))
    }
}

fn sums(weighted: &[Vec<f64>; 3], slits: &[f64]) -> [f64; 3] {
    weighted.each_ref().map(|weighted| dot(weighted, slits))
}

/// `v` at a place on its axis.
fn layers_cosine(place: f64) -> f64 {
    FARTHEST * place * place
}

/// Node `index` as a part of the axis.
fn part(index: usize, intervals: usize) -> f64 {
    whole(index) / whole(intervals.max(1))
}

#[allow(clippy::cast_precision_loss, reason = "at most some million nodes")]
fn whole(count: usize) -> f64 {
    count as f64
}

#[allow(clippy::cast_possible_truncation, reason = "the table is in single precision")]
fn single(value: f64) -> f32 {
    value as f32
}
