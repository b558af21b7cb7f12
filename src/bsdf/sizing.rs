//! How many nodes a table needs, before it is filled.
//!
//! What a table would say between its nodes can be computed from the nodes about that place, without the rest of it. So sizes are tried at
//! random directions with light: from a small one on, always that axis is made finer which lowers the error most for its bytes.

use super::density::{NODES, density};
use super::directions::{angles, direction, half, mirrored, square, unsquare};
use super::source::Scratch;
use super::tabulate::{DARK, axes, incidence, share, single};
use super::warp::{Between, Warp, slices};
use super::{BsdfError, Source};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Numbers of nodes that are tried; azimuths are odd, so that 0 is one of them.
const AZIMUTHS: [usize; 9] = [9, 13, 17, 25, 33, 49, 65, 97, 129];
const ANGLES: [usize; 9] = [8, 11, 16, 22, 32, 45, 64, 90, 128];
const SIDES: [usize; 9] = [12, 16, 23, 32, 45, 64, 90, 128, 180];
const WAVELENGTHS: [usize; 10] = [8, 12, 16, 24, 32, 48, 64, 95, 142, 236];
/// Step of the spectra that wavelengths are held against, nm.
const FINE: f64 = 2.0;
/// Wavelengths at which directions are judged.
const SEEN: usize = 12;
/// Directions with light that sizes are judged at.
const PROBES: usize = 3000;
/// Directions that are tried for each of them: a narrow lobe leaves most dark.
const TRIES: usize = 2000;

/// What a table should keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// Root mean square error between the nodes over directions with light, as a share of the peak; above 0.
    pub tolerance: f64,
    /// Bytes of the largest file that is allowed.
    pub most_bytes: u64,
    /// First and last wavelength, nm.
    pub range: [f64; 2],
    /// Seed of the directions that sizes are judged at.
    pub seed: u64,
}

/// Nodes of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Azimuths of incidence, from -180° to 180°; at least 3.
    pub azimuths: usize,
    /// Angles of incidence; at least 2.
    pub angles: usize,
    /// Nodes along each side of the square of half vectors; at least 2.
    pub side: usize,
    /// Wavelengths, or 3.
    pub channels: usize,
}

impl Size {
    /// Directions of incidence times half vectors.
    #[must_use]
    pub fn nodes(&self) -> u64 {
        [self.azimuths, self.angles, self.side, self.side]
            .into_iter()
            .fold(1, |all, one| all.saturating_mul(one as u64))
    }

    /// Bytes of the values, without the head of the file: `4 n_phi n_theta (side² (channels + 1) + 25 · 64)`.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let densities = (self.azimuths as u64).saturating_mul(self.angles as u64);
        let densities = densities.saturating_mul((NODES[0] * NODES[1]) as u64);
        self.nodes().saturating_mul(self.channels as u64 + 1).saturating_add(densities).saturating_mul(4)
    }

    pub(super) fn check(&self) -> Result<(), BsdfError> {
        let axes = [
            ("azimuths", self.azimuths, 3, 1000),
            ("angles of incidence", self.angles, 2, 1000),
            ("nodes along a side", self.side, 2, 2000),
            ("channels", self.channels, 1, 1000),
        ];
        match axes.into_iter().find(|(_, count, least, most)| !(least..=most).contains(&count)) {
            Some((axis, count, least, most)) => Err(BsdfError::Nodes { axis, count, least, most }),
            None => Ok(()),
        }
    }
}

/// The size that was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Sized {
    /// Nodes of the spectral table.
    pub size: Size,
    /// Its wavelengths, nm, each of which single precision holds.
    pub wavelengths: Vec<f64>,
    /// The error to be expected, as a share of the largest value that was met.
    pub rms: f64,
}

/// Chooses the nodes of a spectral table of the surface of `source`.
///
/// # Errors
/// [`BsdfError::Setting`] for needs that are none; [`BsdfError::TooLarge`] if more bytes would be needed than are allowed;
/// [`BsdfError::Dark`] without a direction with light; [`BsdfError::Optics`] where the model has no answer.
///
/// # Seed
/// The same seed gives the same size on any number of threads.
pub fn size(source: &Source<'_>, needs: &Needs) -> Result<Sized, BsdfError> {
    let [first, last] = needs.range;
    let setting = |quantity, found, allowed| Err(BsdfError::Setting { quantity, found, allowed });
    if !(needs.tolerance > 0.0 && needs.tolerance.is_finite()) {
        return setting("the tolerance", needs.tolerance, "above 0");
    }
    if !(first > 0.0 && last > first && last.is_finite()) {
        return setting("the last wavelength", last, "above the first, and both above 0 nm");
    }
    let nodes = |count: usize| -> Vec<f64> {
        (0..count).map(|index| f64::from(single(first + (last - first) * share(index, count)))).collect()
    };
    let finest: Vec<f64> = nodes(usize::max(SEEN, between(((last - first) / FINE).ceil())));
    let fine = source.at(&finest)?;
    let probes = lit(&fine, needs.seed)?;
    let exact = spectra(&fine, &probes)?;
    let peak = exact.iter().flatten().copied().fold(0.0, f64::max);
    if peak <= DARK {
        return Err(BsdfError::Dark);
    }
    // Errors of wavelengths and of directions are nearly independent: their squares add up.
    let mut of_wavelengths = Vec::with_capacity(WAVELENGTHS.len());
    for count in WAVELENGTHS {
        let wavelengths = nodes(count);
        let coarse = source.at(&wavelengths)?;
        of_wavelengths.push(linear_between(&coarse, &wavelengths, &finest, &probes, &exact)? / (peak * peak));
    }
    let seen = source.at(&nodes(SEEN))?;
    let exact = spectra(&seen, &probes)?;
    let density = density(&seen)?;
    let warp = Warp::new(&density.values, density.size);
    let judged = |at: [usize; 4]| -> Result<Option<Step>, BsdfError> {
        let counts = [AZIMUTHS.get(at[0]), ANGLES.get(at[1]), SIDES.get(at[2]), WAVELENGTHS.get(at[3])];
        let [Some(&azimuths), Some(&angles), Some(&side), Some(&channels)] = counts else { return Ok(None) };
        let size = Size { azimuths, angles, side, channels };
        if size.bytes() > needs.most_bytes {
            return Ok(None);
        }
        let of_wavelengths = of_wavelengths.get(at[3]).copied().unwrap_or(0.0);
        let square = of_directions(&seen, &size, &warp, &probes, &exact)? / (peak * peak) + of_wavelengths;
        Ok(Some(Step { at, size, square }))
    };
    let too_large = |bytes: u64, square: f64| {
        let (rms, tolerance, most) = (square.sqrt(), needs.tolerance, needs.most_bytes);
        BsdfError::TooLarge { bytes, rms, tolerance, most }
    };
    let Some(mut now) = judged([0; 4])? else { return Err(too_large(0, 1.0)) };
    while now.square > needs.tolerance * needs.tolerance {
        let mut best: Option<(f64, Step)> = None;
        for axis in 0..4 {
            let mut at = now.at;
            at[axis] += 1;
            let Some(finer) = judged(at)? else { continue };
            #[allow(clippy::cast_precision_loss, reason = "a ratio")]
            let price = (finer.size.bytes() as f64 / now.size.bytes() as f64).ln();
            let gain = (now.square / finer.square).ln() / price;
            if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, finer));
            }
        }
        let Some((_, finer)) = best else { return Err(too_large(now.size.bytes(), now.square)) };
        now = finer;
    }
    Ok(Sized { size: now.size, wavelengths: nodes(now.size.channels), rms: now.square.sqrt() })
}

/// A size on the way, with its mean square error as a share of the squared peak.
struct Step {
    at: [usize; 4],
    size: Size,
    square: f64,
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held within 2 and 2000")]
fn between(count: f64) -> usize {
    count.clamp(2.0, 2000.0) as usize
}

/// Both directions of a probe.
pub(super) type Pair = [[f64; 3]; 2];

/// A direction anywhere above the horizon, each solid angle as likely.
pub(super) fn anywhere(random: &mut Xoshiro256PlusPlus) -> [f64; 3] {
    let (z, phi) = (1.0 - random.random::<f64>(), TAU * random.random::<f64>());
    let sin = (1.0 - z * z).max(0.0).sqrt();
    [sin * phi.cos(), sin * phi.sin(), z]
}

/// Random pairs of directions in which there is light at some wavelength.
fn lit(source: &Source<'_>, seed: u64) -> Result<Vec<Pair>, BsdfError> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut pairs = Vec::with_capacity(PROBES);
    let (mut scratch, mut values) = (Scratch::default(), vec![0.0; source.channels()]);
    for _ in 0..TRIES * PROBES {
        let pair = [anywhere(&mut random), anywhere(&mut random)];
        source.fill(pair[0], pair[1], &mut scratch, &mut values)?;
        if values.iter().any(|value| *value > 0.0) {
            pairs.push(pair);
            if pairs.len() == PROBES {
                break;
            }
        }
    }
    Ok(pairs)
}

fn spectra(source: &Source<'_>, probes: &[Pair]) -> Result<Vec<Vec<f64>>, BsdfError> {
    let one = |scratch: &mut Scratch, [incoming, outgoing]: &Pair| {
        let mut values = vec![0.0; source.channels()];
        source.fill(*incoming, *outgoing, scratch, &mut values)?;
        Ok(values)
    };
    probes.par_iter().map_init(Scratch::default, one).collect()
}

/// Mean square error of spectra that are linear between `nodes`, held against those at `finest`.
fn linear_between(
    source: &Source<'_>,
    nodes: &[f64],
    finest: &[f64],
    probes: &[Pair],
    exact: &[Vec<f64>],
) -> Result<f64, BsdfError> {
    let singles: Vec<f32> = nodes.iter().copied().map(single).collect();
    let places: Vec<Between> = finest.iter().map(|&wavelength| Between::of(&singles, wavelength)).collect();
    let coarse = spectra(source, probes)?;
    let mut sum = Mean::default();
    for (coarse, exact) in coarse.iter().zip(exact) {
        for (place, exact) in places.iter().zip(exact) {
            let of = |(node, share): (usize, f64)| share * coarse.get(node).copied().unwrap_or(0.0);
            sum.add(place.both().into_iter().map(of).sum::<f64>() - exact);
        }
    }
    Ok(sum.square())
}

/// Mean square error of a table of this size, held against the exact values.
fn of_directions(
    source: &Source<'_>,
    size: &Size,
    warp: &Warp,
    probes: &[Pair],
    exact: &[Vec<f64>],
) -> Result<f64, BsdfError> {
    let axes = axes(size);
    let one = |scratch: &mut (Scratch, Vec<f64>), (probe, exact): (&Pair, &Vec<f64>)| {
        let (scratch, corner) = scratch;
        corner.resize(exact.len(), 0.0);
        let mut values = vec![0.0; exact.len()];
        for (incoming, outgoing, weight) in corners(size, warp, &axes, *probe) {
            source.fill(incoming, outgoing, scratch, corner)?;
            values.iter_mut().zip(&*corner).for_each(|(value, corner)| *value += weight * corner);
        }
        let mut sum = Mean::default();
        values.iter().zip(exact).for_each(|(value, exact)| sum.add(value - exact));
        Ok(sum)
    };
    let all = probes.par_iter().zip(exact).map_init(<(Scratch, Vec<f64>)>::default, one);
    let sums: Result<Vec<Mean>, BsdfError> = all.collect();
    Ok(sums?.into_iter().fold(Mean::default(), Mean::with).square())
}

/// The directions of the nodes about a place in the table, each with its share; those below the horizon, which are dark, are left out.
fn corners(
    size: &Size,
    warp: &Warp,
    [phi_i, theta_i]: &[Vec<f32>; 2],
    [incoming, outgoing]: Pair,
) -> Vec<([f64; 3], [f64; 3], f64)> {
    let Some(normal) = half(incoming, outgoing) else { return Vec::new() };
    let ([theta, phi], [theta_m, phi_m]) = (angles(incoming), angles(normal));
    let alone = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
    let [x, y] = warp.inverse(square(theta_m, phi_m), &alone).map(|place| Between::regular(size.side, place));
    let mut found = Vec::with_capacity(16);
    for (row, of_row) in y.both() {
        for (column, of_column) in x.both() {
            let (place, _) = warp.forward([share(column, size.side), share(row, size.side)], 0);
            let [theta_m, phi_m] = unsquare(place);
            let normal = direction(theta_m, phi_m);
            for (slice, of_slice) in slices(Between::of(phi_i, phi), Between::of(theta_i, theta), theta_i.len()) {
                let (incoming, share) = (incidence(&[phi_i, theta_i], slice), of_slice * of_row * of_column);
                let Some(outgoing) = mirrored(incoming, normal).filter(|_| share > 0.0) else { continue };
                found.push((incoming, outgoing, share));
            }
        }
    }
    found
}

/// A mean square, and the largest.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mean {
    sum: f64,
    count: f64,
    largest: f64,
}

impl Mean {
    pub(super) fn add(&mut self, value: f64) {
        self.sum += value * value;
        self.count += 1.0;
        self.largest = self.largest.max(value.abs());
    }

    pub(super) fn with(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, count: self.count + other.count, largest: self.largest.max(other.largest) }
    }

    pub(super) fn square(self) -> f64 {
        if self.count > 0.0 { self.sum / self.count } else { 0.0 }
    }

    pub(super) fn largest(self) -> f64 {
        self.largest
    }
}
