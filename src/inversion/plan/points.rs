//! The unique points of a data set, and where each reading finds its own.

use crate::dataset::Reading;
use crate::geometry::Polarization;
use crate::inversion::numbering::Numbers;
use crate::inversion::settings::Parts;
use crate::optics::hybrid::HybridNode;
use crate::optics::lamella::LamellaNode;
use crate::optics::multilayer::Period;
use crate::optics::{Join, Media, OpticsError, ReflectivityModel};
use rustc_hash::FxHashSet;
use std::f64::consts::TAU;

/// One reading as indices into the unique points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlannedReading {
    pub(crate) lamella: usize,
    pub(crate) stack: usize,
    pub(crate) lobe: usize,
    /// `cos²(omega)`.
    pub(crate) share_a: f64,
    /// `sin²(omega)`.
    pub(crate) share_b: f64,
    pub(crate) curve: usize,
}

/// Nodes of one incidence: a spectrum.
#[derive(Debug, Clone, Default)]
pub(super) struct StackRun {
    /// One for each node, or one for all where the indices do not vary along the spectrum.
    pub(super) media: Vec<Media>,
    /// Incidence `theta`, of which the tilt is taken; of a product `acos(v / 2)`, rad.
    pub(super) angle: f64,
    /// `2 pi / wavelength` of each node, 1/nm.
    pub(super) wavenumbers: Vec<f64>,
    /// Number of each node, and the shares of s and p in it.
    pub(super) nodes: Vec<(usize, (f64, f64))>,
}

/// What a design of measurement sees of one model.
#[derive(Debug, Clone, Default)]
pub(super) struct Points {
    pub(super) stack: Vec<StackRun>,
    /// Number of stack nodes.
    pub(super) nodes: usize,
    /// `k v / 2`, `k u / 2` (1/nm) and `cos²(theta)` of each lamella node, as in [`LamellaNode`].
    pub(super) half_kv: Vec<f64>,
    pub(super) half_ku: Vec<f64>,
    pub(super) obliquity: Vec<f64>,
    /// Incidence and view of each lobe node, rad.
    pub(super) lobe: Vec<(f64, f64)>,
    /// The nodes of a product; then there are no lamella nodes and no lobes.
    pub(super) product: Vec<HybridNode>,
    /// Number of directions of incidence and view in which the stack is seen.
    pub(super) directions: usize,
    pub(super) readings: Vec<PlannedReading>,
}

/// Not met yet.
const NONE: usize = usize::MAX;
/// Wavelengths that a direction has room for at first.
const ROOM: usize = 32;

/// What was met of one direction of incidence and view.
#[derive(Debug)]
struct Direction {
    /// Its angles as Model A sees them, at a wavelength of 2 pi nm: phases go as the wavenumber.
    node: LamellaNode,
    /// Lamella node by wavelength.
    lamellae: Vec<usize>,
    lobe: usize,
}

/// What was met so far.
#[derive(Debug, Default)]
struct Met {
    stacks: Numbers<(u64, u64, Polarization)>,
    stack_runs: Numbers<u64>,
    wavelengths: Numbers<u64>,
    planes: Numbers<u64>,
    /// Shares of both models by plane.
    shares: Vec<(f64, f64)>,
    numbers: Numbers<(u64, u64)>,
    directions: Vec<Direction>,
    products: Numbers<(u64, usize, usize)>,
    /// Direction and plane of products.
    lit: FxHashSet<(usize, usize)>,
}

impl Points {
    pub(super) fn new<'r>(
        readings: impl ExactSizeIterator<Item = &'r Reading>,
        model: &dyn ReflectivityModel,
        parts: Parts,
    ) -> Result<Self, OpticsError> {
        let mut points = Self { readings: Vec::with_capacity(readings.len()), ..Self::default() };
        let mut met = Met::default();
        let join = model.join();
        for reading in readings {
            let planned = match join {
                Join::Planes => points.of_planes(reading, &mut met, model, parts)?,
                Join::Product { .. } => points.of_product(reading, &mut met, model, parts)?,
            };
            points.readings.push(planned);
        }
        points.stack.iter_mut().for_each(|run| Media::join(&mut run.media));
        points.directions = points.lobe.len() + met.lit.len();
        // The model itself may refuse the media; learn that now, and not as a fit without a finite value.
        for media in points.stack.iter().flat_map(|run| &run.media) {
            model.stack_reflectivity(media, Period { cuticle: 1.0, gap: 1.0 }, 0.0)?;
        }
        Ok(points)
    }

    fn of_planes(
        &mut self,
        reading: &Reading,
        met: &mut Met,
        model: &dyn ReflectivityModel,
        parts: Parts,
    ) -> Result<PlannedReading, OpticsError> {
        let (plane, direction) = met.place(reading);
        let (share_a, share_b) = parts.shares(met.shares[plane]);
        let (mut lamella, mut stack, mut lobe) = (0, 0, 0);
        if share_a > 0.0 {
            lamella = self.lamella_node(reading.wavelength, direction, met);
        }
        if share_b > 0.0 {
            stack = self.stack_node(reading, reading.geometry.theta, met, model)?;
            let known = &mut met.directions[direction].lobe;
            if *known == NONE {
                *known = self.lobe.len();
                self.lobe.push((reading.geometry.theta, reading.geometry.phi));
            }
            lobe = *known;
        }
        Ok(PlannedReading { lamella, stack, lobe, share_a, share_b, curve: reading.curve })
    }

    /// A product has no share of either plane: all of it goes by way of the stack.
    fn of_product(
        &mut self,
        reading: &Reading,
        met: &mut Met,
        model: &dyn ReflectivityModel,
        parts: Parts,
    ) -> Result<PlannedReading, OpticsError> {
        let (plane, direction) = met.place(reading);
        let (share_a, share_b) = parts.shares((0.0, 1.0));
        let (mut stack, mut lobe) = (0, 0);
        if share_b > 0.0 {
            let ambient = model.stack().media(reading.wavelength)?.ambient;
            let node = HybridNode::in_plane(&reading.geometry, reading.wavelength / ambient);
            stack = self.stack_node(reading, node.angle, met, model)?;
            met.lit.insert((direction, plane));
            lobe = met.products.of((reading.wavelength.to_bits(), direction, plane));
            if lobe == self.product.len() {
                self.product.push(node);
            }
        }
        Ok(PlannedReading { lamella: 0, stack, lobe, share_a, share_b, curve: reading.curve })
    }

    #[inline]
    fn lamella_node(&mut self, wavelength: f64, direction: usize, met: &mut Met) -> usize {
        let along = met.wavelengths.of(wavelength.to_bits());
        let Direction { node, lamellae, .. } = &mut met.directions[direction];
        if lamellae.len() <= along {
            lamellae.resize(along + 1, NONE);
        }
        if lamellae[along] == NONE {
            lamellae[along] = self.half_kv.len();
            let wavenumber = TAU / wavelength;
            self.half_kv.push(node.half_kv * wavenumber);
            self.half_ku.push(node.half_ku * wavenumber);
            self.obliquity.push(node.obliquity);
        }
        lamellae[along]
    }

    #[inline]
    fn stack_node(
        &mut self,
        reading: &Reading,
        angle: f64,
        met: &mut Met,
        model: &dyn ReflectivityModel,
    ) -> Result<usize, OpticsError> {
        let number = met.stacks.of((reading.wavelength.to_bits(), angle.to_bits(), reading.polarization));
        if number == self.nodes {
            self.nodes += 1;
            let media = model.stack().media(reading.wavelength)?;
            let run = met.stack_runs.of(angle.to_bits());
            if run == self.stack.len() {
                self.stack.push(StackRun { angle, ..StackRun::default() });
            }
            self.stack[run].media.push(media);
            self.stack[run].wavenumbers.push(TAU / reading.wavelength);
            self.stack[run].nodes.push((number, reading.polarization.shares()));
        }
        Ok(number)
    }
}

impl Met {
    /// Numbers of a reading's plane and direction.
    #[inline]
    fn place(&mut self, reading: &Reading) -> (usize, usize) {
        let geometry = &reading.geometry;
        let plane = self.planes.of(geometry.omega.to_bits());
        if plane == self.shares.len() {
            self.shares.push(geometry.plane_shares());
        }
        let direction = self.numbers.of((geometry.theta.to_bits(), geometry.phi.to_bits()));
        if direction == self.directions.len() {
            let node = LamellaNode::new(TAU, geometry.theta, geometry.phi);
            self.directions.push(Direction { node, lamellae: Vec::with_capacity(ROOM), lobe: NONE });
        }
        (plane, direction)
    }
}
