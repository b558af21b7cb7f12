//! A model at many readings of one structure: those of one angle in the stack and one wavelength share what it reflects.

use crate::geometry::{Geometry, Polarization};
use crate::optics::hybrid::{self, HybridNode};
use crate::optics::lamella::LamellaNode;
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::{
    Contribution, Join, LAMELLA, MULTILAYER, Media, OpticsError, ReflectivityModel, Structure, check_geometry, lobe,
};
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

/// Numbers of a run and of a wavelength in it.
type Node = (usize, usize);

/// A reading without what the stack reflects.
#[derive(Debug, Clone, Copy)]
struct Seen {
    lamella: f64,
    /// Indices, and the angle in the stack; none where it is not seen.
    stack: Option<(Media, f64)>,
    /// Factors before and after what the stack reflects.
    factors: (f64, f64),
}

impl Seen {
    /// Of a structure that was checked.
    fn new(
        model: &(impl ReflectivityModel + ?Sized),
        structure: &Structure,
        geometry: &Geometry,
        wavelength: f64,
    ) -> Result<Self, OpticsError> {
        check_geometry(geometry)?;
        let Geometry { theta, phi, .. } = *geometry;
        let media = model.stack().media(wavelength)?;
        if let Join::Product { ridge_spacing } = model.join() {
            // Lamellae and layers are factors, not terms.
            hybrid::require_narrow(structure, ridge_spacing)?;
            let node = HybridNode::in_plane(geometry, wavelength / media.ambient);
            let factors = (1.0, node.spread(structure, ridge_spacing));
            return Ok(Self { lamella: 0.0, stack: Some((media, node.angle)), factors });
        }
        let (share_a, share_b) = geometry.plane_shares();
        let lamella = if share_a > 0.0 {
            let node = LamellaNode::new(wavelength, theta, phi);
            let shape = node.interference(structure.period(), model.stack().layers)
                * node.diffraction(structure.lamella_width)
                * node.obliquity;
            share_a * model.lamella_factor(structure.lamella_width) * shape
        } else {
            0.0
        };
        let stack = (share_b > 0.0).then_some((media, theta - structure.delta));
        let through = if share_b > 0.0 { lobe::lobe(theta, phi, structure.delta, structure.phi_alpha) } else { 0.0 };
        Ok(Self { lamella, stack, factors: (share_b, through) })
    }

    fn contributions(&self, polarization: Polarization, reflected: SAndP) -> [Contribution; 2] {
        let ((s, p), (before, after)) = (polarization.shares(), self.factors);
        let multilayer = if self.stack.is_some() { before * (s * reflected.s + p * reflected.p) * after } else { 0.0 };
        [
            Contribution { name: LAMELLA, intensity: self.lamella },
            Contribution { name: MULTILAYER, intensity: multilayer },
        ]
    }
}

/// See [`ReflectivityModel::contributions`].
pub(super) fn contributions(
    model: &(impl ReflectivityModel + ?Sized),
    structure: &Structure,
    geometry: &Geometry,
    polarization: Polarization,
    wavelength: f64,
) -> Result<[Contribution; 2], OpticsError> {
    model.validate()?;
    structure.validate()?;
    let seen = Seen::new(model, structure, geometry, wavelength)?;
    let reflected = match &seen.stack {
        Some((media, angle)) => model.stack_reflectivity(media, Period::of(structure), *angle)?,
        None => SAndP::default(),
    };
    Ok(seen.contributions(polarization, reflected))
}

/// See [`ReflectivityModel::contributions_at`].
pub(super) fn contributions_at(
    model: &(impl ReflectivityModel + ?Sized),
    structure: &Structure,
    polarization: Polarization,
    readings: &[(Geometry, f64)],
) -> Result<Vec<Result<[Contribution; 2], OpticsError>>, OpticsError> {
    model.validate()?;
    structure.validate()?;
    let mut stacks = Stacks::default();
    let seen: Vec<Result<(Seen, Node), OpticsError>> = (readings.iter())
        .map(|(geometry, wavelength)| {
            let seen = Seen::new(model, structure, geometry, *wavelength)?;
            Ok((seen, seen.stack.map_or((0, 0), |(media, angle)| stacks.place(media, *wavelength, angle))))
        })
        .collect();
    let reflected: Vec<_> =
        stacks.runs.into_iter().map(|run| run.reflectivities(model, Period::of(structure))).collect();
    let one = |(seen, (run, node)): (Seen, Node)| {
        let reflected = match &seen.stack {
            Some(_) => reflected[run][node].clone()?,
            None => SAndP::default(),
        };
        Ok(seen.contributions(polarization, reflected))
    };
    Ok(seen.into_iter().map(|seen| seen.and_then(one)).collect())
}

/// The wavelengths of one angle in the stack.
#[derive(Debug)]
struct Run {
    angle: f64,
    media: Vec<Media>,
    wavenumbers: Vec<f64>,
}

impl Run {
    /// R at each wavelength.
    fn reflectivities(
        mut self,
        model: &(impl ReflectivityModel + ?Sized),
        period: Period,
    ) -> Vec<Result<SAndP, OpticsError>> {
        let each = self.media.clone();
        Media::join(&mut self.media);
        let mut found = vec![SAndP::default(); self.wavenumbers.len()];
        if model.stack_reflectivities(&self.media, &self.wavenumbers, period, self.angle, &mut found).is_ok() {
            return found.into_iter().map(Ok).collect();
        }
        // One that has no answer does not take it from the others.
        each.iter().map(|media| model.stack_reflectivity(media, period, self.angle)).collect()
    }
}

/// What the stack is asked for, each angle and wavelength once.
#[derive(Debug, Default)]
struct Stacks {
    runs: Vec<Run>,
    of_angle: FxHashMap<u64, usize>,
    nodes: FxHashMap<(usize, u64), usize>,
}

impl Stacks {
    /// The number of the run and of the wavelength in it.
    fn place(&mut self, media: Media, wavelength: f64, angle: f64) -> Node {
        let run = *self.of_angle.entry(angle.to_bits()).or_insert(self.runs.len());
        if run == self.runs.len() {
            self.runs.push(Run { angle, media: Vec::new(), wavenumbers: Vec::new() });
        }
        let Run { media: of_run, wavenumbers, .. } = &mut self.runs[run];
        let node = *self.nodes.entry((run, wavelength.to_bits())).or_insert_with(|| {
            of_run.push(media);
            wavenumbers.push(TAU / wavelength);
            of_run.len() - 1
        });
        (run, node)
    }
}
