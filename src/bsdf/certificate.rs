//! What a table keeps of its model: reciprocity, energy and values, in numbers.

use super::directions::mirrored;
use super::sizing::{Mean, Pair, anywhere};
use super::source::Scratch;
use super::surface::albedos;
use super::tabulate::{DARK, incidence};
use super::{BsdfError, MeasuredBsdf, Source, Surface};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// Points along each side of the square of half vectors that an albedo is summed over.
const POINTS: usize = 64;
/// Directions with light that share their wavelengths.
const BLOCK: usize = 125;
/// Wavelengths between those of the table that each of these directions is judged at.
const WAVELENGTHS: usize = 8;
/// Directions that are tried for each one with light.
const TRIES: usize = 2000;

/// A difference between nodes, as a share of the table's peak.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Trial {
    /// Root mean square.
    pub rms: f64,
    /// The largest.
    pub worst: f64,
}

/// The largest share of the incident light that leaves again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Albedo {
    /// The share; 1 would be all.
    pub largest: f64,
    /// Angle of the incidence where it was found, degrees.
    pub theta_deg: f64,
    /// Its azimuth, degrees.
    pub phi_deg: f64,
    /// Its wavelength, nm; none for red, green and blue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelength_nm: Option<f64>,
}

/// What was measured of a table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Certificate {
    /// Largest value of the table, `f cos(theta_o)`, 1/sr.
    pub peak_per_sr: f64,
    /// Worst reciprocity error at the nodes, as a share of the peak: each value, times the cosine of the incidence, against the model with
    /// source and view exchanged.
    pub reciprocity_at_nodes: f64,
    /// The same between nodes: the table against itself with source and view exchanged, at the random directions.
    pub reciprocity_between_nodes: Trial,
    /// Largest albedo of the table, over incidences at its nodes and between its angles, and its channels.
    pub albedo_of_table: Albedo,
    /// Largest albedo of the model at the same incidences.
    pub albedo_of_model: Albedo,
    /// Table against model at the random directions, and at wavelengths between those of the table.
    pub error: Trial,
    /// Random directions in which model or table has light: as many as were asked for, or fewer where light is rare.
    pub directions: usize,
}

/// Measures a table of `source`.
///
/// # Seed
/// `directions` random ones follow from `seed`; the numbers are the same on any number of threads.
///
/// # Errors
/// [`BsdfError::Channels`] if the table has other channels than the source, [`BsdfError::Dark`] if it holds nothing, or no random direction has light.
pub fn certify(
    source: &Source<'_>,
    table: &MeasuredBsdf,
    directions: usize,
    seed: u64,
) -> Result<Certificate, BsdfError> {
    let fields = table.fields();
    if fields.channels() != source.channels() || fields.wavelengths.is_some() != source.wavelengths().is_some() {
        return Err(BsdfError::Channels("the table has other channels than the surface"));
    }
    let peak = f64::from(fields.spectra.iter().copied().fold(0.0, f32::max));
    if peak <= DARK {
        return Err(BsdfError::Dark);
    }
    let (error, exchanged, directions) = at_random(source, table, directions, seed)?;
    if directions == 0 {
        return Err(BsdfError::Dark);
    }
    let trial = |mean: Mean| Trial { rms: mean.square().sqrt() / peak, worst: mean.largest() / peak };
    Ok(Certificate {
        peak_per_sr: peak,
        reciprocity_at_nodes: at_nodes(source, table)? / peak,
        reciprocity_between_nodes: trial(exchanged),
        albedo_of_table: largest(table, table)?,
        albedo_of_model: largest(source, table)?,
        error: trial(error),
        directions,
    })
}

/// The largest difference of a node from the model with source and view exchanged.
fn at_nodes(source: &Source<'_>, table: &MeasuredBsdf) -> Result<f64, BsdfError> {
    let fields = table.fields();
    let (channels, plane) = (fields.channels(), fields.side * fields.side);
    let slices = fields.spectra.par_chunks(channels * plane).enumerate();
    let worst = slices.map(|(slice, spectra)| {
        let incoming = incidence(&[&fields.phi_i, &fields.theta_i], slice);
        let (mut scratch, mut values) = (Scratch::default(), vec![0.0; channels]);
        let mut worst = 0.0_f64;
        for index in 0..plane {
            let normal = table.half_vector(slice, index);
            let Some(outgoing) = normal.and_then(|normal| mirrored(incoming, normal)) else { continue };
            source.fill(outgoing, incoming, &mut scratch, &mut values)?;
            for (channel, value) in values.iter().enumerate() {
                let found = spectra.get(channel * plane + index).copied().map_or(0.0, f64::from);
                // What sRGB cannot show became 0 in both directions.
                worst = worst.max((found * incoming[2] - value.max(0.0) * outgoing[2]).abs());
            }
        }
        Ok(worst)
    });
    let worst: Result<Vec<f64>, BsdfError> = worst.collect();
    Ok(worst?.into_iter().fold(0.0, f64::max))
}

/// Table against model, and against itself with source and view exchanged; and in how many directions there was light.
fn at_random(
    source: &Source<'_>,
    table: &MeasuredBsdf,
    directions: usize,
    seed: u64,
) -> Result<(Mean, Mean, usize), BsdfError> {
    let blocks = directions.div_ceil(BLOCK);
    let one = |block: usize| {
        let mut random =
            Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(block as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let asked = BLOCK.min(directions - block * BLOCK);
        let ends = source.wavelengths().and_then(|all| Some([*all.first()?, *all.last()?]));
        let wavelengths: Option<Vec<f64>> = ends
            .map(|[first, last]| (0..WAVELENGTHS).map(|_| first + (last - first) * random.random::<f64>()).collect());
        let model = match &wavelengths {
            Some(wavelengths) => source.at(wavelengths)?,
            None => source.clone(),
        };
        let read = |[incoming, outgoing]: Pair, out: &mut [f64]| match &wavelengths {
            None => table.evaluate(incoming, outgoing, out),
            Some(wavelengths) => out.iter_mut().zip(wavelengths).try_for_each(|(out, wavelength)| {
                *out = table.evaluate_at(incoming, outgoing, *wavelength)?;
                Ok(())
            }),
        };
        let (mut error, mut exchanged) = (Mean::default(), Mean::default());
        let mut rows: [Vec<f64>; 3] = std::array::from_fn(|_| vec![0.0; model.channels()]);
        let mut found = 0;
        for _ in 0..TRIES * asked {
            if found == asked {
                break;
            }
            let [incoming, outgoing] = [anywhere(&mut random), anywhere(&mut random)];
            let [truth, there, back] = &mut rows;
            model.evaluate(incoming, outgoing, truth)?;
            read([incoming, outgoing], there)?;
            if truth.iter().chain(&*there).all(|value| value.abs() <= 0.0) {
                continue;
            }
            found += 1;
            read([outgoing, incoming], back)?;
            for ((truth, there), back) in truth.iter().zip(there).zip(back) {
                error.add(*there - truth.max(0.0));
                exchanged.add(*there * incoming[2] - *back * outgoing[2]);
            }
        }
        Ok((error, exchanged, found))
    };
    let all: Result<Vec<(Mean, Mean, usize)>, BsdfError> = (0..blocks).into_par_iter().map(one).collect();
    let both = |(error, exchanged, found): (Mean, Mean, usize), (other, other_exchanged, more)| {
        (error.with(other), exchanged.with(other_exchanged), found + more)
    };
    Ok(all?.into_iter().fold((Mean::default(), Mean::default(), 0), both))
}

/// The largest albedo over the incidences of the table, at nodes and halfway between angles; mirror images across the ridges are left out.
fn largest(surface: &dyn Surface, table: &MeasuredBsdf) -> Result<Albedo, BsdfError> {
    let fields = table.fields();
    let nodes: Vec<f64> = fields.theta_i.iter().copied().map(f64::from).collect();
    let middles = nodes.iter().zip(nodes.iter().skip(1)).map(|(low, high)| 0.5 * (low + high));
    let thetas = nodes.iter().copied().chain(middles);
    let phis: Vec<f64> =
        fields.phi_i.iter().copied().map(f64::from).filter(|phi| phi.abs() <= FRAC_PI_2 + 1e-6).collect();
    let places: Vec<[f64; 2]> = thetas.flat_map(|theta| phis.iter().map(move |&phi| [theta, phi])).collect();
    let albedos = albedos(surface, &places, POINTS)?;
    let mut found = Albedo { largest: 0.0, theta_deg: 0.0, phi_deg: 0.0, wavelength_nm: None };
    for ([theta, phi], albedos) in places.iter().zip(albedos) {
        for (channel, largest) in albedos.into_iter().enumerate() {
            if largest > found.largest {
                let wavelengths = fields.wavelengths.as_ref();
                let wavelength_nm = wavelengths.and_then(|all| all.get(channel).copied().map(f64::from));
                found = Albedo { largest, theta_deg: theta.to_degrees(), phi_deg: phi.to_degrees(), wavelength_nm };
            }
        }
    }
    Ok(found)
}
