//! The closed form at many wavelengths of one angle, in vector registers.
//!
//! Along a spectrum only the phases change: cosines and admittances stand still. Lanes of wavelengths go through the same
//! steps without a branch, and sines are taken up to sign: one half turn more turns the sign of the whole period, which
//! no reflectivity sees.

use crate::numerics::trigonometry::{cos_up_to_sign, sin_up_to_sign};
use crate::optics::multilayer::periodic::{Admittances, Cosines};
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::stack::Media;
use multiversion::multiversion;

/// Wavelengths side by side: two registers of AVX2.
const LANES: usize = 8;
/// Up to so many periods the plain Chebyshev recurrence is taken: it is shorter than doubling.
const RECURRENCE_PERIODS: usize = 16;

type Lanes = [f64; LANES];

/// What stands still along a spectrum, for one polarization.
#[derive(Debug, Clone, Copy)]
struct Fixed {
    /// `y_gap / y_cuticle` and its inverse.
    ratio: f64,
    inverse_ratio: f64,
    ambient: f64,
    base: f64,
    /// `y_ambient y_base / y_gap - y_gap` and so on: `y_a y_b m12 - m21` by its two products of sines and cosines.
    cos_sin: f64,
    sin_cos: f64,
    /// `4 y_ambient y_base`.
    through: f64,
}

impl Fixed {
    fn new(y: &Admittances) -> Self {
        let product = y.ambient * y.base;
        Self {
            ratio: y.gap / y.cuticle,
            inverse_ratio: y.cuticle / y.gap,
            ambient: y.ambient,
            base: y.base,
            cos_sin: product / y.gap - y.gap,
            sin_cos: product / y.cuticle - y.cuticle,
            through: 4.0 * product,
        }
    }
}

/// Optical path `n d cos` of each layer of a period, nm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paths {
    pub(crate) cuticle: f64,
    pub(crate) gap: f64,
}

impl Paths {
    pub(crate) fn new(media: &Media, cosines: &Cosines, period: Period) -> Self {
        Self {
            cuticle: media.cuticle.re * period.cuticle * cosines.cuticle,
            gap: media.gap.re * period.gap * cosines.gap,
        }
    }
}

/// R of `layers` periods at each of `wavenumbers`, `2 pi / wavelength` in 1/nm, for one set of admittances.
///
/// # Shape
/// The shorter of `wavenumbers` and `out` counts.
///
/// The same bits with every set of vector instructions: nothing is fused.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn one(y: &Admittances, paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    each_chunk(&[Fixed::new(y)], paths, wavenumbers, layers, out, |[value]| SAndP::both(value));
}

/// The same for two sets, s and p: the phases are taken once.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
pub(crate) fn both(y: &[Admittances; 2], paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    let fixed = [Fixed::new(&y[0]), Fixed::new(&y[1])];
    each_chunk(&fixed, paths, wavenumbers, layers, out, |[s, p]| SAndP { s, p });
}

#[inline(always)]
fn each_chunk<const SETS: usize>(
    fixed: &[Fixed; SETS],
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [SAndP],
    joined: impl Fn([f64; SETS]) -> SAndP,
) {
    for (chunk, out) in wavenumbers.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let mut k: Lanes = [0.0; LANES];
        k[..chunk.len()].copy_from_slice(chunk);
        let phases = Phases::new(&k, paths);
        let found = fixed.each_ref().map(|fixed| phases.reflectivity(fixed, layers));
        for (lane, out) in out.iter_mut().enumerate() {
            *out = joined(std::array::from_fn(|set| found[set][lane]));
        }
    }
}

/// Products of the sines and cosines of both phases.
struct Phases {
    cos_cos: Lanes,
    sin_sin: Lanes,
    cos_sin: Lanes,
    sin_cos: Lanes,
}

impl Phases {
    #[inline(always)]
    fn new(k: &Lanes, paths: Paths) -> Self {
        let (sin_c, cos_c) =
            (k.map(|k| sin_up_to_sign(k * paths.cuticle)), k.map(|k| cos_up_to_sign(k * paths.cuticle)));
        let (sin_g, cos_g) = (k.map(|k| sin_up_to_sign(k * paths.gap)), k.map(|k| cos_up_to_sign(k * paths.gap)));
        let times = |a: &Lanes, b: &Lanes| -> Lanes { std::array::from_fn(|lane| a[lane] * b[lane]) };
        Self {
            cos_cos: times(&cos_c, &cos_g),
            sin_sin: times(&sin_c, &sin_g),
            cos_sin: times(&cos_c, &sin_g),
            sin_cos: times(&sin_c, &cos_g),
        }
    }

    /// As [`super::periodic::reflectivity`], without a branch. What overflows is opaque, and 0/0 is grazing: both are 1.
    #[inline(always)]
    fn reflectivity(&self, y: &Fixed, layers: usize) -> Lanes {
        let m11: Lanes = std::array::from_fn(|lane| self.cos_cos[lane] - self.sin_sin[lane] * y.ratio);
        let m22: Lanes = std::array::from_fn(|lane| self.cos_cos[lane] - self.sin_sin[lane] * y.inverse_ratio);
        let (u, v) = power(&std::array::from_fn(|lane| m11[lane] + m22[lane]), layers);
        std::array::from_fn(|lane| {
            let real = y.ambient * (u[lane] * m11[lane] - v[lane]) - y.base * (u[lane] * m22[lane] - v[lane]);
            let imaginary = u[lane] * (y.cos_sin * self.cos_sin[lane] + y.sin_cos * self.sin_cos[lane]);
            let numerator = real * real + imaginary * imaginary;
            let ratio = numerator / (numerator + y.through);
            if ratio <= 1.0 { ratio } else { 1.0 }
        })
    }
}

/// `(U_(M-1)(x), U_(M-2)(x))` for `trace = 2 x` in each lane.
#[inline(always)]
fn power(trace: &Lanes, periods: usize) -> (Lanes, Lanes) {
    let (mut u, mut v): (Lanes, Lanes) = ([1.0; LANES], [0.0; LANES]);
    if periods <= RECURRENCE_PERIODS {
        for _ in 1..periods {
            (u, v) = (std::array::from_fn(|lane| trace[lane] * u[lane] - v[lane]), u);
        }
        return (u, v);
    }
    let bits = usize::BITS - periods.leading_zeros();
    for bit in (0..bits.saturating_sub(1)).rev() {
        let doubled = std::array::from_fn(|lane| u[lane] * (trace[lane] * u[lane] - 2.0 * v[lane]));
        (u, v) = (doubled, std::array::from_fn(|lane| (u[lane] - v[lane]) * (u[lane] + v[lane])));
        if (periods >> bit) & 1 == 1 {
            (u, v) = (std::array::from_fn(|lane| trace[lane] * u[lane] - v[lane]), u);
        }
    }
    (u, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Stack;
    use crate::optics::multilayer::THICKNESSES;
    use crate::optics::multilayer::periodic;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn a_million_random_values_are_those_of_the_scalar_form() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
        let mut worst = 0.0_f64;
        for case in 0..2500 {
            let layers = [1, 2, 3, 9, 16, 17, 40, 3000][case % 8];
            // Edges among them: normal and grazing incidence, no layer at all, no contrast.
            let angle = match case % 5 {
                0 => 0.0,
                1 => 89.9_f64.to_radians(),
                _ => random.random_range(0.0..1.55),
            };
            let mut thickness =
                || if random.random_bool(0.03) { *THICKNESSES.start() } else { random.random_range(0.0..400.0) };
            let period = Period { cuticle: thickness(), gap: thickness() };
            let index = if case % 50 == 0 { 1.0 } else { random.random_range(1.0..2.6) };
            let mut media = Stack::default().media(500.0).unwrap();
            media.cuticle.re = index;
            media.base.re = if case % 2 == 0 { 1.0 } else { random.random_range(1.0..3.0) };
            let cosines = Cosines::refracted(&media, angle).unwrap();
            let rules: [fn(f64, f64) -> f64; 2] = [|n, cos| n * cos, |n, cos| cos / n];
            let y = rules.map(|rule| Admittances::each(&media, &cosines, rule));
            let paths = Paths::new(&media, &cosines, period);
            let wavelengths: Vec<f64> = (0..401).map(|nm| 380.0 + f64::from(nm)).collect();
            let wavenumbers: Vec<f64> = wavelengths.iter().map(|nm| std::f64::consts::TAU / nm).collect();
            let mut found = vec![SAndP::both(0.0); wavenumbers.len()];
            both(&y, paths, &wavenumbers, layers, &mut found);
            let mut single = vec![SAndP::both(0.0); wavenumbers.len()];
            one(&y[1], paths, &wavenumbers, layers, &mut single);
            for ((&wavelength, found), single) in wavelengths.iter().zip(&found).zip(&single) {
                media.wavelength = wavelength;
                let scalar = periodic::exact(&media, &cosines, period, layers);
                // Thousands of layers turn the last digit of a phase into their number of it.
                let within = if layers > 100 { 1e-8 } else { 1e-11 };
                let off = (scalar.s - found.s).abs().max((scalar.p - found.p).abs());
                assert!(off <= within, "{layers} layers, {wavelength} nm, {angle}: {scalar:?} {found:?}");
                assert_eq!(found.p.to_bits(), single.s.to_bits());
                worst = if layers > 100 { worst } else { worst.max(off) };
            }
        }
        assert!(worst > 0.0, "the two forms round differently");
    }
}
