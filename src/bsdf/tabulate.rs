//! A surface as the fields of a measured material.
//!
//! `ndf` is 4 and `sigma` 1 everywhere: the factor `ndf / (4 sigma)` is 1, and `spectra` holds `f cos(theta_o)` at the nodes. Their half vectors
//! are where the warp of `vndf` lays them: mostly where there is light (`density`). `luminance`, by which renderers sample, is
//! the mean over the channels times the solid angle of a node.

use super::density::density;
use super::directions::{direction, dot, jacobian, mirrored, unsquare};
use super::measured::{MeasuredFields, Plane};
use super::sizing::Size;
use super::warp::Warp;
use super::{BsdfError, Surface};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Largest angle of incidence in a table, as a share of a right angle: along the horizon there is no light to tell.
const LAST_ANGLE: f64 = 0.9995;
/// Angles of incidence are counted back from the horizon in this power: there the model changes fastest. Even ones (1) have a third more
/// error with as many nodes, those of 2 have more about the normal.
const TOWARDS_HORIZON: f64 = 1.5;
/// Least weight for sampling, as a share of the mean of its plane: with less, rare paths would be bright dots in a picture; with more,
/// paths would be spent on the dark.
const FLOOR: f64 = 0.01;
/// Largest value of a surface that reflects nothing, 1/sr: what rounding leaves of layers of one index.
pub(super) const DARK: f64 = 1e-12;

/// A table with what was found while it was filled.
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulated {
    /// The table.
    pub fields: MeasuredFields,
    /// Its largest value, 1/sr.
    pub peak: f64,
    /// What is furthest below 0 of the colours that sRGB cannot show, as a share of the peak; it became 0.
    pub clipped: f64,
    /// Share of the directions with light in which a channel became 0.
    pub clipped_directions: f64,
}

/// The nodes of azimuth and angle, rad.
pub(super) fn axes(size: &Size) -> [Vec<f32>; 2] {
    let azimuth = |index| single(PI * (2.0 * share(index, size.azimuths) - 1.0));
    let angle = |index| {
        let from_horizon = (1.0 - share(index, size.angles)).powf(TOWARDS_HORIZON);
        single(LAST_ANGLE * FRAC_PI_2 * (1.0 - from_horizon))
    };
    [(0..size.azimuths).map(azimuth).collect(), (0..size.angles).map(angle).collect()]
}

/// A half vector of the table.
struct Node {
    normal: [f64; 3],
    /// Solid angle of the mirrored direction by area of the unit square before the warp, over the cosine from the half vector, sr.
    solid_angle: f64,
}

impl Node {
    fn new(warp: &Warp, side: usize, index: usize) -> Self {
        let (place, density) = warp.forward([share(index % side, side), share(index / side, side)], 0);
        let [theta, phi] = unsquare(place);
        Self { normal: direction(theta, phi), solid_angle: jacobian(place[0], theta, 1.0) / density }
    }
}

/// The direction of the light in a slice.
pub(super) fn incidence([phi_i, theta_i]: &[&[f32]; 2], slice: usize) -> [f64; 3] {
    let node = |axis: &[f32], index: usize| axis.get(index).copied().map_or(0.0, f64::from);
    direction(node(theta_i, slice % theta_i.len()), node(phi_i, slice / theta_i.len()))
}

/// Place of node `index` of `count` from 0 to 1.
#[allow(clippy::cast_precision_loss, reason = "axes have far fewer than 2^53 nodes")]
pub(super) fn share(index: usize, count: usize) -> f64 {
    index as f64 / (count.max(2) - 1) as f64
}

#[allow(clippy::cast_possible_truncation, reason = "the format has single precision")]
pub(super) fn single(value: f64) -> f32 {
    value as f32
}

/// Fills a table: the channels of `surface` at the directions of `size`, in parallel, with the same bits on any number of
/// threads.
///
/// Channels below 0, which colours outside sRGB have, become 0; [`Tabulated`] says how much that is.
///
/// # Errors
/// [`BsdfError::Nodes`] for a size that is none, or that does not have the channels of the surface; [`BsdfError::Dark`] where all values are 0;
/// and those of the surface.
pub fn tabulate(surface: &dyn Surface, size: &Size, description: &str) -> Result<Tabulated, BsdfError> {
    size.check()?;
    if size.channels != surface.channels() {
        let (count, needed) = (size.channels, surface.channels());
        return Err(BsdfError::Nodes { axis: "channels", count, least: needed, most: needed });
    }
    let [phi_i, theta_i] = axes(size);
    let (side, channels) = (size.side, size.channels);
    let plane = side * side;
    let slices = phi_i.len() * theta_i.len();
    let incoming = |slice| incidence(&[&phi_i, &theta_i], slice);
    let density = density(surface)?;
    let warp = Warp::new(&density.values, density.size);
    let nodes: Vec<Node> = (0..plane).map(|index| Node::new(&warp, side, index)).collect();
    let mut spectra = vec![0.0; slices * channels * plane];
    let mut luminance = vec![0.0; slices * plane];
    let found = spectra
        .par_chunks_mut(channels * plane)
        .zip(luminance.par_chunks_mut(plane))
        .enumerate()
        .map(|(slice, (spectra, luminance))| {
            let incoming = incoming(slice);
            let mut found = Found::default();
            let mut values = vec![0.0; channels];
            for (index, (weight, node)) in luminance.iter_mut().zip(&nodes).enumerate() {
                let Some(outgoing) = mirrored(incoming, node.normal) else { continue };
                surface.values(incoming, outgoing, &mut values)?;
                found.add(&mut values);
                let mean = values.iter().sum::<f64>() / share_count(channels);
                *weight = single(mean * node.solid_angle * dot(incoming, node.normal));
                for (channel, value) in values.iter().enumerate() {
                    if let Some(out) = spectra.get_mut(channel * plane + index) {
                        *out = single(*value);
                    }
                }
            }
            raise(luminance);
            Ok(found)
        })
        .collect::<Result<Vec<Found>, BsdfError>>()?;
    let found = found.into_iter().fold(Found::default(), Found::with);
    if found.peak <= DARK {
        return Err(BsdfError::Dark);
    }
    let everywhere = |value: f32| Plane { size: [2, 2], values: vec![value; 4] };
    let fields = MeasuredFields {
        description: description.to_owned(),
        theta_i,
        phi_i,
        wavelengths: surface.wavelengths().map(|wavelengths| wavelengths.into_iter().map(single).collect()),
        ndf: everywhere(4.0),
        sigma: everywhere(1.0),
        vndf: Plane { size: density.size, values: density.values.repeat(slices) },
        luminance,
        side,
        spectra,
        jacobian: true,
    };
    let clipped_directions = share_count(found.clipped) / share_count(found.lit).max(1.0);
    Ok(Tabulated { fields, peak: found.peak, clipped: found.below / found.peak, clipped_directions })
}

#[allow(clippy::cast_precision_loss, reason = "a table has fewer than 2^53 values")]
fn share_count(count: usize) -> f64 {
    count as f64
}

/// Puts a floor under the weights of a plane; a dark plane is weighted evenly.
fn raise(weights: &mut [f32]) {
    let mean = weights.iter().map(|weight| f64::from(*weight)).sum::<f64>() / share_count(weights.len());
    let floor = if mean > 0.0 { single(FLOOR * mean).max(f32::MIN_POSITIVE) } else { 1.0 };
    weights.iter_mut().for_each(|weight| *weight = weight.max(0.0) + floor);
}

/// What was met in a slice.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    peak: f64,
    below: f64,
    lit: usize,
    clipped: usize,
}

impl Found {
    /// Counts the values of one direction and takes away what is below 0.
    fn add(&mut self, values: &mut [f64]) {
        let (lowest, highest) = values.iter().fold((0.0_f64, 0.0_f64), |(l, h), value| (l.min(*value), h.max(*value)));
        self.peak = self.peak.max(highest);
        self.below = self.below.max(-lowest);
        self.lit += usize::from(highest > 0.0);
        self.clipped += usize::from(lowest < 0.0);
        values.iter_mut().for_each(|value| *value = value.max(0.0));
    }

    fn with(self, other: Self) -> Self {
        Self {
            peak: self.peak.max(other.peak),
            below: self.below.max(other.below),
            lit: self.lit + other.lit,
            clipped: self.clipped + other.clipped,
        }
    }
}
