//! The spectra that a table of colours is filled from, and held against.

use super::colours::{ColourLookup, LookupError};
use super::error::RenderError;
use crate::colorimetry::{ColourError, Integration, Lab, Xyz};
use crate::geometry::Polarization;
use crate::numerics::dot::dot;
use crate::optics::hybrid::{Shape, layer_angle, require_narrow, slit_share};
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::{Join, Media, OpticsError, ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Largest `v` and `|u_x|`: two unit vectors that point the same way.
const FARTHEST: f64 = 2.0;
/// Midpoints that are compared on each axis, about; they are taken from rows all over the table.
const MIDPOINTS: usize = 1 << 15;
/// Random directions that the finished table is judged at.
const JUDGED: usize = 4096;
/// Seed of these directions.
const SEED: u64 = 1;

/// What the table is filled from.
pub(super) struct Spectra<'a> {
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
    pub(super) fn new(
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

    pub(super) fn weighted_by(mut self, integration: &Integration) -> Result<Self, ColourError> {
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
    pub(super) fn random(&self, count: usize) -> Vec<[f64; 3]> {
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
    pub(super) fn table(&self, intervals: [usize; 3]) -> Result<ColourLookup, RenderError> {
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
    pub(super) fn reflectivity(&self, gap: f64, v: f64) -> Result<Vec<f64>, OpticsError> {
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
    pub(super) fn slits(&self, u: f64) -> Vec<f64> {
        let one = |&wavelength: &f64| slit_share(PI * u / wavelength, self.structure.lamella_width, wavelength);
        self.ambient.iter().map(one).collect()
    }

    /// Largest difference halfway between the nodes of one axis, at nodes of the others.
    pub(super) fn midpoints(&self, table: &ColourLookup, axis: usize) -> Result<f64, RenderError> {
        let counts = [0, 1, 2].map(|other| table.nodes[other] - usize::from(other == axis));
        let ends = [self.gaps, [0.0, 1.0], [0.0, FARTHEST]];
        let at = |other: usize, index: usize| {
            let shift = if other == axis { 0.5 } else { 0.0 };
            let share = (whole(index) + shift) / whole((table.nodes[other] - 1).max(1));
            ends[other][0] + share * (ends[other][1] - ends[other][0])
        };
        let slits: Vec<Vec<f64>> = (0..counts[2]).map(|column| self.slits(at(2, column))).collect();
        let scale = self.brightest(table);
        // An odd stride meets every row of directions.
        let every = (counts[0] * counts[1] * counts[2] / MIDPOINTS) | 1;
        let rows = (0..counts[0] * counts[1]).into_par_iter().step_by(every).map(|row| {
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
    pub(super) fn judged(&self, table: &ColourLookup) -> Result<LookupError, RenderError> {
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
