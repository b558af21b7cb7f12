//! A stack whose layers differ: each thickness of Model B drawn by itself, as `blend` cannot hold it.

use morpho_fit::geometry::Polarization;
use morpho_fit::optics::multilayer::{Period, SAndP};
use morpho_fit::optics::{Media, OpticsError, ReflectivityModel, Stack};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// `blend` with independent layer thicknesses; the reflectivity is the incoherent mean of all realisations.
#[derive(Debug, Clone)]
pub struct Disordered {
    stack: Stack,
    /// Normal deviates of each realisation: cuticle, gap, cuticle, ... from the light.
    deviates: Vec<Vec<f64>>,
    /// Standard deviation of a layer's thickness, nm.
    sd: f64,
}

impl Disordered {
    /// The mean over `realisations` stacks of independent layers.
    pub fn ensemble(sd: f64, realisations: usize, seed: u64) -> Self {
        let stack = Stack::default();
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        // No deviate beyond 2 keeps layers of 20 nm and more above 0, and the mean what it is.
        let mut deviate = || {
            loop {
                let z: f64 = StandardNormal.sample(&mut random);
                if z.abs() <= 2.0 {
                    return z;
                }
            }
        };
        let deviates = (0..realisations).map(|_| (0..2 * stack.layers - 1).map(|_| deviate()).collect()).collect();
        Self { stack, deviates, sd }
    }

    /// One stack, whose own mean layers are those of the structure: what a fit of one specimen can find.
    pub fn single(sd: f64, seed: u64) -> Self {
        let mut one = Self::ensemble(sd, 1, seed);
        for first in 0..2 {
            let of_a_kind = |deviates: &[f64]| deviates.iter().skip(first).step_by(2).copied().collect::<Vec<f64>>();
            for deviates in &mut one.deviates {
                let kind = of_a_kind(deviates);
                #[allow(clippy::cast_precision_loss, reason = "a small count")]
                let mean = kind.iter().sum::<f64>() / kind.len() as f64;
                deviates.iter_mut().skip(first).step_by(2).for_each(|z| *z -= mean);
            }
        }
        one
    }
}

impl ReflectivityModel for Disordered {
    fn name(&self) -> &'static str {
        "disordered"
    }

    fn stack(&self) -> &Stack {
        &self.stack
    }

    fn lamella_factor(&self, _: f64) -> f64 {
        1.0
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        let sum = self.deviates.iter().fold(SAndP::default(), |sum, deviates| {
            let layers = deviates.iter().enumerate().map(|(place, z)| {
                let (index, mean) =
                    if place % 2 == 0 { (media.cuticle.re, period.cuticle) } else { (media.gap.re, period.gap) };
                (index, (mean + self.sd * z).max(0.0))
            });
            let layers: Vec<(f64, f64)> = layers.collect();
            let of = |polarization| characteristic(media, &layers, angle, polarization);
            SAndP { s: sum.s + of(Polarization::S), p: sum.p + of(Polarization::P) }
        });
        #[allow(clippy::cast_precision_loss, reason = "a small count")]
        let count = self.deviates.len() as f64;
        Ok(SAndP { s: sum.s / count, p: sum.p / count })
    }
}

/// Reflectivity of `(index, thickness)` layers by the product of characteristic matrices (Born and Wolf §1.6).
pub fn characteristic(media: &Media, layers: &[(f64, f64)], angle: f64, polarization: Polarization) -> f64 {
    let sin = media.ambient * angle.sin();
    let cos = |n: f64| (1.0 - (sin / n).powi(2)).sqrt();
    let admittance = |n: f64| if polarization == Polarization::P { n / cos(n) } else { n * cos(n) };
    // The field (b, i c) at the base, carried to the light.
    let base = media.base.re;
    let (mut b, mut c) = ((1.0, 0.0), (admittance(base), 0.0));
    for &(n, thickness) in layers.iter().rev() {
        let (s, k) = (std::f64::consts::TAU * n * thickness * cos(n) / media.wavelength).sin_cos();
        let y = admittance(n);
        // b' = b cos + i c sin / y, c' = c cos + i y b sin
        (b, c) = ((b.0 * k - c.1 * s / y, b.1 * k + c.0 * s / y), (c.0 * k - y * b.1 * s, c.1 * k + y * b.0 * s));
    }
    let outside = admittance(media.ambient);
    let (minus, plus) = ((outside * b.0 - c.0, outside * b.1 - c.1), (outside * b.0 + c.0, outside * b.1 + c.1));
    (minus.0 * minus.0 + minus.1 * minus.1) / (plus.0 * plus.0 + plus.1 * plus.1)
}
