//! What a table is filled from: a structure as a model sees it, in colours or as spectra.

use super::error::TableError;
use super::lamellae::{self, Lamellae};
use super::nodes::{Across, Nodes, Turn};
use crate::geometry::{Geometry, Polarization};
use crate::optics::hybrid::{self, HybridNode};
use crate::optics::lamella::LamellaNode;
use crate::optics::lobe::lobe;
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::{Join, Media, OpticsError, ReflectivityModel, Structure};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Values of three channels that are written together: a whole number of planes and of vector registers.
const STRIDE: usize = 24;

/// What stands at a node.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// Three sums over the wavelengths, by these weights, `[channel][wavelength]`: a colour.
    Colour([Vec<f64>; 3]),
    /// The reflectivity at each wavelength.
    Spectrum,
}

/// A structure that tables are filled from.
#[derive(Debug, Clone)]
pub struct Source<'a> {
    model: &'a dyn ReflectivityModel,
    structure: Structure,
    /// Shares of s and p.
    shares: (f64, f64),
    /// One for all wavelengths, or one for each.
    media: Vec<Media>,
    /// `2 pi / wavelength`, 1/nm.
    wavenumbers: Vec<f64>,
    /// `pi / wavelength`, 1/nm.
    half_k: Vec<f64>,
    quantity: Quantity,
}

impl<'a> Source<'a> {
    /// `structure` as `model` reflects it at `wavelengths` (nm).
    ///
    /// # Errors
    /// [`TableError`] for a model, structure or wavelength out of range, for no wavelength, and for weights of another length.
    pub fn new(
        model: &'a dyn ReflectivityModel,
        structure: &Structure,
        polarization: Polarization,
        wavelengths: &[f64],
        quantity: Quantity,
    ) -> Result<Self, TableError> {
        model.validate()?;
        structure.validate()?;
        if let Join::Product { ridge_spacing } = model.join() {
            hybrid::require_narrow(structure, ridge_spacing)?;
        }
        let needed = wavelengths.len().max(1);
        let lengths: Vec<usize> = match &quantity {
            Quantity::Colour(weights) => weights.iter().map(Vec::len).collect(),
            Quantity::Spectrum => vec![wavelengths.len()],
        };
        if let Some(&found) = lengths.iter().find(|&&length| length != needed) {
            return Err(TableError::Length { what: "weights of the wavelengths", found, needed });
        }
        let mut media: Vec<Media> =
            wavelengths.iter().map(|&wavelength| model.stack().media(wavelength)).collect::<Result<_, _>>()?;
        Media::join(&mut media);
        let wavenumbers = wavelengths.iter().map(|wavelength| TAU / wavelength).collect();
        let half_k = wavelengths.iter().map(|wavelength| PI / wavelength).collect();
        Ok(Self { model, structure: *structure, shares: polarization.shares(), media, wavenumbers, half_k, quantity })
    }

    /// Values at one node.
    #[must_use]
    pub fn channels(&self) -> usize {
        match self.quantity {
            Quantity::Colour(_) => 3,
            Quantity::Spectrum => self.half_k.len(),
        }
    }

    /// In what the model is linear between planes.
    #[must_use]
    pub fn turn(&self) -> Turn {
        if self.model.join() == Join::Planes { Turn::Share } else { Turn::Angle }
    }

    /// Whether directions of one incidence cost far less than as many of different ones.
    pub(super) fn is_dear(&self) -> bool {
        self.model.is_average() && self.turn() == Turn::Share
    }

    /// Incidences beyond which tilted layers are seen from behind, rad: there the colour jumps.
    pub(super) fn edges(&self) -> Vec<f64> {
        let delta = self.structure.delta;
        if self.turn() == Turn::Share { vec![delta - FRAC_PI_2, delta + FRAC_PI_2] } else { Vec::new() }
    }

    /// Angles from the mirror direction where the model has a bend, rad: the edges of the lobe.
    pub(super) fn bends(&self) -> Vec<f64> {
        let Structure { delta, phi_alpha, .. } = self.structure;
        match self.model.join() {
            Join::Planes => vec![2.0 * delta - phi_alpha, 2.0 * delta, 2.0 * delta + phi_alpha],
            Join::Product { .. } => vec![2.0 * delta],
        }
    }

    /// The values at all nodes, in parallel; the same bits on any number of threads.
    ///
    /// A node of θ + φ whose φ lies beyond 90° has what the formulas go on to there.
    ///
    /// # Shape
    /// `out: [theta][across][omega][channel]`.
    ///
    /// # Errors
    /// [`TableError::Length`] for a wrong `out`; [`TableError::Optics`] where the model has no answer.
    pub fn fill(&self, nodes: &Nodes, out: &mut [f64]) -> Result<(), TableError> {
        let needed = nodes.count() * self.channels();
        if out.len() != needed {
            return Err(TableError::Length { what: "values of a table", found: out.len(), needed });
        }
        let shares: Vec<(f64, f64)> =
            nodes.omega().iter().map(|&omega| Geometry { omega, ..Geometry::default() }.plane_shares()).collect();
        if let [theta] = nodes.theta() {
            // Waking other threads for one row would cost more than the row.
            return Ok(self.row(*theta, nodes, &shares, out)?);
        }
        let rows = out.par_chunks_mut(needed / nodes.theta().len()).zip(nodes.theta());
        rows.try_for_each(|(out, &theta)| self.row(theta, nodes, &shares, out))?;
        Ok(())
    }

    /// All nodes of one incidence.
    fn row(&self, theta: f64, nodes: &Nodes, shares: &[(f64, f64)], out: &mut [f64]) -> Result<(), OpticsError> {
        let phis: Vec<f64> = nodes.across().iter().map(|&at| nodes.kind().phi(theta, at)).collect();
        match self.model.join() {
            Join::Planes => self.planes(theta, &phis, shares, out),
            Join::Product { ridge_spacing } => self.product(theta, &phis, nodes.omega(), ridge_spacing, out),
        }
    }

    /// The values of one direction: what a table saves.
    ///
    /// # Shape
    /// `out: [channel]`.
    ///
    /// # Errors
    /// As [`Source::fill`], and [`TableError::Axis`] for angles out of range.
    pub fn evaluate(&self, geometry: &Geometry, out: &mut [f64]) -> Result<(), TableError> {
        let Geometry { theta, phi, omega } = *geometry;
        let nodes = Nodes::new(vec![theta], vec![phi], vec![omega], Across::View, Turn::Angle)?;
        self.fill(&nodes, out)
    }

    /// R of the stack at every wavelength.
    fn stack(&self, angle: f64, both: &mut [SAndP], out: &mut [f64]) -> Result<(), OpticsError> {
        let (s, p) = self.shares;
        self.model.stack_reflectivities(&self.media, &self.wavenumbers, Period::of(&self.structure), angle, both)?;
        for (out, both) in out.iter_mut().zip(both) {
            *out = s * both.s + p * both.p;
        }
        Ok(())
    }

    /// One incidence of a sum of planes.
    fn planes(&self, theta: f64, phis: &[f64], shares: &[(f64, f64)], out: &mut [f64]) -> Result<(), OpticsError> {
        let Structure { delta, phi_alpha, lamella_width, .. } = self.structure;
        let mut reflectivity = vec![0.0; self.half_k.len()];
        if shares.iter().any(|share| share.1 > 0.0) {
            let mut both = vec![SAndP::default(); self.half_k.len()];
            self.stack(theta - delta, &mut both, &mut reflectivity)?;
        }
        let lamellae =
            Lamellae { period: self.structure.period(), width: lamella_width, layers: self.model.stack().layers };
        // With the wavelength pi, k/2 is 1.
        let seen: Vec<LamellaNode> = phis.iter().map(|&phi| LamellaNode::new(PI, theta, phi)).collect();
        let u: Vec<f64> = seen.iter().map(|node| node.half_ku).collect();
        let v: Vec<f64> = seen.iter().map(|node| node.half_kv).collect();
        let strength = self.model.lamella_factor(lamella_width) * seen.first().map_or(0.0, |node| node.obliquity);
        let lobes = phis.iter().map(|&phi| lobe(theta, phi, delta, phi_alpha));
        match &self.quantity {
            Quantity::Colour(weights) => {
                let mut across = vec![[0.0; 3]; phis.len()];
                if shares.iter().any(|share| share.0 > 0.0) {
                    lamellae::colours(lamellae, &self.half_k, weights, &u, &v, &mut across);
                }
                let along = weighted(weights, &reflectivity);
                // The share of each of the values of a direction.
                let of_a: Vec<f64> = shares.iter().flat_map(|share| [strength * share.0; 3]).collect();
                let of_b: Vec<f64> = shares.iter().flat_map(|share| [share.1; 3]).collect();
                for ((out, across), lobe) in out.chunks_mut(3 * shares.len()).zip(&across).zip(lobes) {
                    blend(out, &of_a, across, &of_b, &along.map(|channel| lobe * channel));
                }
            }
            Quantity::Spectrum => {
                let count = self.half_k.len();
                let mut across = vec![0.0; count * phis.len()];
                if shares.iter().any(|share| share.0 > 0.0) {
                    lamellae::spectra(lamellae, &self.half_k, &u, &v, &mut across);
                }
                for ((out, across), lobe) in out.chunks_mut(count * shares.len()).zip(across.chunks(count)).zip(lobes) {
                    for (out, (of_a, of_b)) in out.chunks_mut(count).zip(shares) {
                        for ((out, a), b) in out.iter_mut().zip(across).zip(&reflectivity) {
                            *out = of_a * strength * a + of_b * lobe * b;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// One incidence of a product; a view beyond the horizon is taken on it.
    fn product(
        &self,
        theta: f64,
        phis: &[f64],
        omegas: &[f64],
        ridge_spacing: f64,
        out: &mut [f64],
    ) -> Result<(), OpticsError> {
        let count = self.half_k.len();
        let (mut both, mut reflectivity) = (vec![SAndP::default(); count], vec![0.0; count]);
        let mut spectrum = vec![0.0; count];
        let ambient: Vec<f64> = (self.wavenumbers.iter().zip(self.media.iter().cycle()))
            .map(|(wavenumber, media)| TAU / wavenumber / media.ambient)
            .collect();
        for (out, &phi) in out.chunks_mut(self.channels() * omegas.len()).zip(phis) {
            let geometry = |omega| Geometry { theta, phi: phi.clamp(-FRAC_PI_2, FRAC_PI_2), omega };
            let Some(&longest) = ambient.last() else { continue };
            // The angle in the stack does not depend on the plane.
            let angle = HybridNode::in_plane(&geometry(0.0), longest).angle;
            self.stack(angle, &mut both, &mut reflectivity)?;
            for (out, &omega) in out.chunks_mut(self.channels()).zip(omegas) {
                for ((value, &wavelength), reflectivity) in spectrum.iter_mut().zip(&ambient).zip(&reflectivity) {
                    let node = HybridNode::in_plane(&geometry(omega), wavelength);
                    *value = reflectivity * node.spread(&self.structure, ridge_spacing);
                }
                match &self.quantity {
                    Quantity::Colour(weights) => out.copy_from_slice(&weighted(weights, &spectrum)),
                    Quantity::Spectrum => out.copy_from_slice(&spectrum),
                }
            }
        }
        Ok(())
    }
}

fn weighted(weights: &[Vec<f64>; 3], spectrum: &[f64]) -> [f64; 3] {
    weights.each_ref().map(|weights| weights.iter().zip(spectrum).map(|(weight, value)| weight * value).sum())
}

/// `of_a · a + of_b · b` of all planes, channel by channel.
#[inline]
fn blend(out: &mut [f64], of_a: &[f64], a: &[f64; 3], of_b: &[f64], b: &[f64; 3]) {
    let a: [f64; STRIDE] = std::array::from_fn(|index| a[index % 3]);
    let b: [f64; STRIDE] = std::array::from_fn(|index| b[index % 3]);
    for ((out, of_a), of_b) in out.chunks_mut(STRIDE).zip(of_a.chunks(STRIDE)).zip(of_b.chunks(STRIDE)) {
        for ((((out, of_a), a), of_b), b) in out.iter_mut().zip(of_a).zip(&a).zip(of_b).zip(&b) {
            *out = of_a * a + of_b * b;
        }
    }
}
