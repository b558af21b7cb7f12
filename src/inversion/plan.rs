//! A data set compiled for one model, once, so that a fit computes nothing twice.
//!
//! ```text
//! unique (wavelength, theta, polarization)   reflectivity of the stack
//! unique (wavelength, theta, phi)            array and slit factor of the lamellae
//! unique (theta, phi)                        lobe
//! unique (wavelength, theta, phi, omega)     all but the stack, of a model that is one product
//! ```
//!
//! Each reading is then three indices and two shares. [`Terms`] holds the values at the unique points for one structure;
//! changing one parameter renews only the terms it enters.

mod model_held;
mod seen;
mod terms;

use crate::dataset::{Dataset, Reading};
use crate::inversion::numbering::Numbers;
use crate::inversion::rows::Rows;
use crate::inversion::settings::Parts;
use crate::optics::hybrid::HybridNode;
use crate::optics::lamella::LamellaNode;
use crate::optics::multilayer::Period;
use crate::optics::{Join, Media, OpticsError, ReflectivityModel};
use model_held::ModelHeld;
use rustc_hash::FxHashSet;
use std::f64::consts::TAU;
pub(crate) use terms::{LamellaSlopes, Terms, TermsView};

/// Readings that a thinned plan keeps of each curve, if it has them.
const LEAST_OF_A_CURVE: usize = 16;

/// Denominator and numerator of the golden ratio's fractional part: multiples of it are spread evenly.
const SPREAD: usize = 1 << 16;
const GOLDEN: usize = 40_503;

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
    pub(crate) intensity: f64,
    /// `1 / sigma`, or 1 where the data have none.
    pub(crate) weight: f64,
    pub(crate) curve: usize,
}

/// Nodes of one incidence: a spectrum.
#[derive(Debug, Clone, Default)]
struct StackRun {
    /// One for each node, or one for all where the indices do not vary along the spectrum.
    media: Vec<Media>,
    /// Incidence `theta`, of which the tilt is taken; of a product `acos(v / 2)`, rad.
    angle: f64,
    /// `2 pi / wavelength` of each node, 1/nm.
    wavenumbers: Vec<f64>,
    /// Number of each node, and the shares of s and p in it.
    nodes: Vec<(usize, (f64, f64))>,
}

/// What multiplies the residual of a reading: `1 / sigma`, or 1 where the data have none.
fn weight(reading: &Reading) -> f64 {
    reading.sigma.map_or(1.0, f64::recip)
}

/// A data set compiled for one model.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    model: ModelHeld<'a>,
    stack: Vec<StackRun>,
    /// Number of stack nodes.
    nodes: usize,
    half_kv: Vec<f64>,
    half_ku: Vec<f64>,
    obliquity: Vec<f64>,
    lobe: Vec<(f64, f64)>,
    /// The same of a product; then there are no lamella nodes and no lobes.
    product: Vec<HybridNode>,
    /// Number of directions of incidence and view in which the stack is seen.
    directions: usize,
    pub(crate) readings: Vec<PlannedReading>,
    pub(crate) rows: Rows,
    pub(crate) curves: usize,
}

impl<'a> Plan<'a> {
    /// Compiles `data` for the `parts` of `model`.
    ///
    /// # Errors
    /// [`OpticsError`] if a medium has no valid index at a wavelength of the data, or the model cannot hold the media.
    pub fn new(data: &Dataset, model: &'a dyn ReflectivityModel, parts: Parts) -> Result<Self, OpticsError> {
        let all: Vec<usize> = (0..data.readings().len()).collect();
        Self::of_rows(data, model, parts, &all)
    }

    /// [`Plan::new`] for about `limit` readings of all.
    pub(crate) fn thinned(
        data: &Dataset,
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        limit: usize,
    ) -> Result<Self, OpticsError> {
        Self::of_rows(data, model, parts, &Self::thinned_rows(data, limit))
    }

    /// About `limit` rows of all, curve by curve: one from each run of neighbours in a curve; short curves are kept.
    ///
    /// Which one of a run is spread by the golden ratio: a fixed stride would take the same angles from each scan wherever
    /// it shares a factor with the length of a scan, and then the search sees none of the others.
    pub(crate) fn thinned_rows(data: &Dataset, limit: usize) -> Vec<usize> {
        let stride = data.readings().len().div_ceil(limit.max(1)).max(1);
        let mut curves: Vec<Vec<usize>> = vec![Vec::new(); data.curves().len()];
        for (row, reading) in data.readings().iter().enumerate() {
            curves[reading.curve].push(row);
        }
        let mut rows: Vec<usize> = Vec::new();
        for curve in &curves {
            let stride = stride.min(curve.len() / LEAST_OF_A_CURVE).max(1);
            let spread = |place: usize, run: &[usize]| run[place.wrapping_mul(GOLDEN) % SPREAD * run.len() / SPREAD];
            rows.extend(curve.chunks(stride).enumerate().map(|(place, run)| spread(place, run)));
        }
        rows
    }

    /// [`Plan::new`] for some rows of the data, in their order.
    pub(crate) fn of_rows(
        data: &Dataset,
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        rows: &[usize],
    ) -> Result<Self, OpticsError> {
        model.validate()?;
        let mut plan = Self {
            model: ModelHeld::Lent(model),
            stack: Vec::new(),
            nodes: 0,
            half_kv: Vec::new(),
            half_ku: Vec::new(),
            obliquity: Vec::new(),
            lobe: Vec::new(),
            product: Vec::new(),
            directions: 0,
            readings: Vec::with_capacity(rows.len()),
            rows: Rows::default(),
            curves: data.curves().len(),
        };
        let (mut stacks, mut stack_runs) = (Numbers::default(), Numbers::default());
        let (mut directions, mut wavelengths, mut planes) =
            (Numbers::default(), Numbers::default(), Numbers::default());
        // By plane of incidence: its shares of both models.
        let mut shares: Vec<(f64, f64)> = Vec::new();
        // By direction: its angles as Model A sees them, its lamella nodes by wavelength, and its lobe node.
        let mut nodes: Vec<LamellaNode> = Vec::new();
        let mut lamellae: Vec<Vec<Option<usize>>> = Vec::new();
        let mut lobes: Vec<Option<usize>> = Vec::new();
        let mut products = Numbers::default();
        let mut seen = FxHashSet::default();
        let join = model.join();
        for reading in rows.iter().map(|&row| &data.readings()[row]) {
            let (theta, phi) = (reading.geometry.theta, reading.geometry.phi);
            let plane = planes.of(reading.geometry.omega.to_bits());
            if plane == shares.len() {
                shares.push(reading.geometry.plane_shares());
            }
            let wavelength = reading.wavelength;
            let product = match join {
                Join::Planes => None,
                Join::Product { .. } => {
                    let ambient = model.stack().media(wavelength)?.ambient;
                    Some(HybridNode::in_plane(&reading.geometry, wavelength / ambient))
                }
            };
            // A product has no share of either plane: all of it goes by way of the stack.
            let (share_a, share_b) = parts.shares(if product.is_some() { (0.0, 1.0) } else { shares[plane] });
            let angle = product.map_or(theta, |node| node.angle);
            let mut planned = PlannedReading {
                lamella: 0,
                stack: 0,
                lobe: 0,
                share_a,
                share_b,
                intensity: reading.intensity,
                weight: weight(reading),
                curve: reading.curve,
            };
            let direction = directions.of((theta.to_bits(), phi.to_bits()));
            if direction == nodes.len() {
                nodes.push(LamellaNode::new(TAU, theta, phi));
                lamellae.push(Vec::new());
                lobes.push(None);
            }
            if share_a > 0.0 {
                let along = wavelengths.of(wavelength.to_bits());
                let row = &mut lamellae[direction];
                if row.len() <= along {
                    row.resize(along + 1, None);
                }
                planned.lamella = *row[along].get_or_insert_with(|| {
                    // Phases go as the wavenumber: the angles of a direction are taken once.
                    let (wavenumber, node) = (TAU / wavelength, nodes[direction]);
                    plan.half_kv.push(node.half_kv * wavenumber);
                    plan.half_ku.push(node.half_ku * wavenumber);
                    plan.obliquity.push(node.obliquity);
                    plan.half_kv.len() - 1
                });
            }
            if share_b > 0.0 {
                planned.stack = stacks.of((wavelength.to_bits(), angle.to_bits(), reading.polarization));
                if planned.stack == plan.nodes {
                    plan.nodes += 1;
                    let media = model.stack().media(wavelength)?;
                    let run = stack_runs.of(angle.to_bits());
                    if run == plan.stack.len() {
                        plan.stack.push(StackRun { angle, ..StackRun::default() });
                    }
                    plan.stack[run].media.push(media);
                    plan.stack[run].wavenumbers.push(TAU / wavelength);
                    plan.stack[run].nodes.push((planned.stack, reading.polarization.shares()));
                }
                planned.lobe = if let Some(node) = product {
                    seen.insert((direction, plane));
                    let number = products.of((wavelength.to_bits(), direction, plane));
                    if number == plan.product.len() {
                        plan.product.push(node);
                    }
                    number
                } else {
                    *lobes[direction].get_or_insert_with(|| {
                        plan.lobe.push((theta, phi));
                        plan.lobe.len() - 1
                    })
                };
            }
            plan.readings.push(planned);
        }
        plan.stack.iter_mut().for_each(|run| Media::join(&mut run.media));
        plan.directions = plan.lobe.len() + seen.len();
        // The model itself may refuse the media; learn that now, and not as a fit without a finite value.
        for media in plan.stack.iter().flat_map(|run| &run.media) {
            model.stack_reflectivity(media, Period { cuticle: 1.0, gap: 1.0 }, 0.0)?;
        }
        Ok(plan)
    }

    /// Lays the readings out for arithmetic; `like` as in [`Rows::new`].
    pub(crate) fn arrange(&mut self, like: &[usize]) {
        self.rows = Rows::new(&self.readings, like);
    }

    /// Puts other intensities, one for each reading, in the place of those of the data.
    pub(crate) fn set_intensities(&mut self, intensities: &[f64]) {
        for (reading, &intensity) in self.readings.iter_mut().zip(intensities) {
            reading.intensity = intensity;
        }
        self.rows.set_readings(&self.readings);
    }

    /// Puts intensities and sigmas of readings of the same design in the place of those of the data.
    pub(crate) fn set_readings<'r>(&mut self, readings: impl Iterator<Item = &'r Reading>) {
        for (own, reading) in self.readings.iter_mut().zip(readings) {
            (own.intensity, own.weight) = (reading.intensity, weight(reading));
        }
        self.rows.set_readings(&self.readings);
    }
}
