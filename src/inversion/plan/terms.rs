//! Values at the unique points of a plan for one structure, and their derivatives.

use super::{Plan, PlannedReading, Points};
use crate::inversion::parameter::{COUNT, structure};
use crate::optics::lamella::{self, Lamella, LamellaNodes};
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::{Join, lobe};
use nalgebra::DVector;

/// A direction this near the edge of the lobe is at it, rad.
const EDGE: f64 = 1e-4;

/// Values at the unique points of a plan.
#[derive(Debug, Clone, Default)]
pub(crate) struct Terms {
    pub(crate) lamella: Vec<f64>,
    pub(crate) stack: Vec<f64>,
    pub(crate) lobe: Vec<f64>,
}

/// [`Terms`] by reference: a search joins terms that many points share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TermsView<'a> {
    /// `A² · factor(a) · S² · cos²(theta)` by lamella node.
    pub(crate) lamella: &'a [f64],
    /// R of the reading's polarization by stack node.
    pub(crate) stack: &'a [f64],
    /// L by lobe node; of a product all but R.
    pub(crate) lobe: &'a [f64],
}

impl Terms {
    pub(crate) fn view(&self) -> TermsView<'_> {
        TermsView { lamella: &self.lamella, stack: &self.stack, lobe: &self.lobe }
    }
}

/// Derivatives of Model A by lamella node, 1/nm.
#[derive(Debug, Clone, Default)]
pub(crate) struct LamellaSlopes {
    pub(crate) by_period: Vec<f64>,
    pub(crate) by_width: Vec<f64>,
}

impl Plan<'_> {
    /// `A²` by lamella node.
    pub(crate) fn interference(&self, period: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.points.half_kv.len()];
        lamella::interference(&self.points.half_kv, period, self.model.stack().layers, &mut values);
        values
    }

    /// `factor(a) · S² · cos²(theta)` by lamella node.
    pub(crate) fn diffraction(&self, lamella_width: f64) -> Vec<f64> {
        let mut values = vec![0.0; self.points.half_ku.len()];
        let factor = self.model.lamella_factor(lamella_width);
        lamella::diffraction(&self.points.half_ku, &self.points.obliquity, lamella_width, factor, &mut values);
        values
    }

    /// NaN where the model has no answer, which a fit reads as a forbidden point.
    pub(crate) fn stack(&self, d_air: f64, d_cuticle: f64, delta: f64) -> Vec<f64> {
        let period = Period { cuticle: d_cuticle, gap: d_air };
        let mut values = vec![f64::NAN; self.points.nodes];
        let mut both = Vec::new();
        for run in &self.points.stack {
            both.clear();
            both.resize(run.wavenumbers.len(), SAndP::both(f64::NAN));
            let angle = if self.is_product() { run.angle } else { run.angle - delta };
            if self.model.stack_reflectivities(&run.media, &run.wavenumbers, period, angle, &mut both).is_err() {
                continue;
            }
            for (&(node, (s, p)), both) in run.nodes.iter().zip(&both) {
                values[node] = s * both.s + p * both.p;
            }
        }
        values
    }

    /// Derivatives of [`Plan::stack`] by `d_air`, `d_cuticle` and `delta` (per nm and rad), in exact form; `None` where the
    /// model has none.
    pub(crate) fn stack_slopes(&self, d_air: f64, d_cuticle: f64, delta: f64) -> Option<[DVector<f64>; 3]> {
        let period = Period { cuticle: d_cuticle, gap: d_air };
        // Of a product the tilt moves the lobe alone.
        let product = self.is_product();
        let mut slopes = [0, 1, 2].map(|_| DVector::zeros(self.points.nodes));
        let mut found = Vec::new();
        for run in &self.points.stack {
            found.clear();
            found.resize(run.wavenumbers.len(), StackSlopes::default());
            let angle = if product { run.angle } else { run.angle - delta };
            self.model.stack_slopes(&run.media, &run.wavenumbers, period, angle, &mut found).then_some(())?;
            for (&(node, (s, p)), found) in run.nodes.iter().zip(&found) {
                let of = |both: SAndP| s * both.s + p * both.p;
                slopes[0][node] = of(found.gap);
                slopes[1][node] = of(found.cuticle);
                slopes[2][node] = if product { 0.0 } else { -of(found.angle) };
            }
        }
        Some(slopes)
    }

    /// Of a product all factors but the stack, which only then depend on the lamella width.
    pub(crate) fn lobe(&self, delta: f64, phi_alpha: f64, lamella_width: f64) -> Vec<f64> {
        if let Join::Product { ridge_spacing } = self.model.join() {
            let of = structure(&[0.0, 0.0, delta, phi_alpha, lamella_width]);
            return self.points.product.iter().map(|node| node.spread(&of, ridge_spacing)).collect();
        }
        self.points.lobe.iter().map(|&(theta, phi)| lobe::lobe(theta, phi, delta, phi_alpha)).collect()
    }

    /// Derivatives of [`Plan::lobe`] by the tilt and the half-width, 1/rad, in exact form; `None` for a product, and
    /// with a direction next to the lobe's edge, where the slope jumps and a difference sees both sides.
    pub(crate) fn lobe_slopes(&self, delta: f64, phi_alpha: f64) -> Option<[DVector<f64>; 2]> {
        let at_edge = |&(theta, phi): &(f64, f64)| ((phi + theta - 2.0 * delta).abs() - phi_alpha).abs() < EDGE;
        if self.points.lobe.iter().any(at_edge) {
            return None;
        }
        let of = |&(theta, phi): &(f64, f64)| lobe::lobe_slopes(theta, phi, delta, phi_alpha);
        let slopes: Vec<[f64; 2]> = self.points.lobe.iter().map(of).collect();
        let by = |which: usize| DVector::from_iterator(slopes.len(), slopes.iter().map(|slopes| slopes[which]));
        (!self.is_product()).then(|| [0, 1].map(by))
    }

    pub(crate) fn terms(&self, values: &[f64; COUNT]) -> Terms {
        let mut terms = Terms::default();
        self.renew(values, &mut terms, None);
        terms
    }

    /// Puts the values at `values` into `terms`, whatever was there, and with them the slopes of Model A if they are asked for;
    /// returns whether these are there, which they are not for so many layers that no recurrence is taken.
    pub(crate) fn renew(&self, values: &[f64; COUNT], terms: &mut Terms, slopes: Option<&mut LamellaSlopes>) -> bool {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = *values;
        terms.stack = self.stack(d_air, d_cuticle, delta);
        terms.lobe = self.lobe(delta, phi_alpha, lamella_width);
        let (nodes, of) = (self.lamella_nodes(), self.lamella_of(d_air + d_cuticle, lamella_width));
        let count = nodes.half_kv.len();
        terms.lamella.resize(count, 0.0);
        let has_slopes = slopes.is_some_and(|LamellaSlopes { by_period, by_width }| {
            by_period.resize(count, 0.0);
            by_width.resize(count, 0.0);
            lamella::intensity_and_slopes(nodes, of, &mut terms.lamella, [by_period, by_width])
        });
        if !has_slopes {
            lamella::intensity(nodes, of, &mut terms.lamella);
        }
        has_slopes
    }

    /// Whether Model A has exact slopes.
    pub(crate) fn has_lamella_slopes(&self) -> bool {
        self.model.stack().layers <= lamella::CHEBYSHEV_LAYERS
    }

    /// Model A by lamella node.
    pub(crate) fn lamella(&self, period: f64, width: f64) -> Vec<f64> {
        let nodes = self.lamella_nodes();
        let mut values = vec![0.0; nodes.half_kv.len()];
        lamella::intensity(nodes, self.lamella_of(period, width), &mut values);
        values
    }

    /// Its slopes in exact form; `None` for so many layers that no recurrence is taken.
    pub(crate) fn lamella_slopes(&self, period: f64, width: f64) -> Option<LamellaSlopes> {
        let (nodes, of) = (self.lamella_nodes(), self.lamella_of(period, width));
        let mut slopes = LamellaSlopes { by_period: vec![0.0; nodes.half_kv.len()], by_width: Vec::new() };
        slopes.by_width.clone_from(&slopes.by_period);
        let LamellaSlopes { by_period, by_width } = &mut slopes;
        let mut values = by_period.clone();
        lamella::intensity_and_slopes(nodes, of, &mut values, [by_period, by_width]).then_some(slopes)
    }

    fn lamella_nodes(&self) -> LamellaNodes<'_> {
        let Points { half_kv, half_ku, obliquity, .. } = &*self.points;
        LamellaNodes { half_kv, half_ku, obliquity }
    }

    fn lamella_of(&self, period: f64, width: f64) -> Lamella {
        let factor = (self.model.lamella_factor(width), self.model.lamella_factor_slope(width));
        Lamella { period, layers: self.model.stack().layers, width, factor }
    }

    /// `(I_A cos² omega, I_B sin² omega)` of a reading; of a product 0 and all of it.
    #[inline]
    pub(crate) fn parts(&self, reading: &PlannedReading, terms: TermsView<'_>) -> (f64, f64) {
        let a = if reading.share_a > 0.0 { reading.share_a * terms.lamella[reading.lamella] } else { 0.0 };
        let b = if reading.share_b > 0.0 {
            reading.share_b * terms.stack[reading.stack] * terms.lobe[reading.lobe]
        } else {
            0.0
        };
        (a, b)
    }
}
