//! The amplitude recurrence at many wavelengths of one angle, in vector registers: any layers, absorbing or not.
//!
//! The recurrence and its scaling are those of [`super::amplitude`], with `E2 = exp(2 i kz k d)` and
//!
//! ```text
//! e' = Q e + (P/Y) h,   h' = Q h + P Y e,   P = (1 - E2)/2,   Q = 1 - P
//! P = (1 - x)/2 + x sin² - i x sin cos,   x = exp(-2 Im(kz) k d),   sine and cosine of Re(kz) k d
//! ```
//!
//! so that sine and cosine are needed up to a common sign only, P has no difference of near numbers in a thin layer, and P/Y
//! is finite where kz vanishes. Through a layer without loss in which the waves travel a matrix of four real numbers is enough.
//! What equal layers share is computed once; wavelengths go in blocks without a branch, as in [`super::lanes`].
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

pub(crate) mod pairs;

use crate::numerics::exponential::decay;
use crate::numerics::fused::{fused_or_not, mul_add};
use crate::numerics::trigonometry::sin_cos_fused;
use crate::optics::multilayer::SAndP;
use multiversion::multiversion;
use nalgebra::Complex;
use pairs::SomePairs;

/// Wavelengths that go together.
const BLOCK: usize = 16;
/// Kinds of layers whose matrices are kept; those of later ones are computed where they are met.
const KEPT: usize = 64;
/// Layers after which the fields are scaled. A layer changes their size by 1e15 at most, in a medium of index 1000.
const SCALED: usize = 8;
/// A smaller kz² is taken for this one: it is rounding, and 1/kz must be finite.
const SMALLEST: f64 = 1e-36;
/// Largest phase of a layer, rad, for which sine and cosine are reduced exactly.
pub(crate) const LARGEST_PHASE: f64 = 1e6;

type Block = [f64; BLOCK];
const ZERO: Block = [0.0; BLOCK];

/// A stack of any layers. Indices are either one value for all wavelengths or one for each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layers<'a> {
    pub(crate) ambient: &'a [Complex<f64>],
    pub(crate) base: &'a [Complex<f64>],
    /// Indices of each medium of the layers.
    pub(crate) media: &'a [&'a [Complex<f64>]],
    /// Medium and thickness (nm) of each kind of layer.
    pub(crate) kinds: &'a [(usize, f64)],
    /// Kinds from the base to the light, to be repeated so many times; of several stacks of equally many layers one after the
    /// other.
    pub(crate) order: &'a [usize],
    pub(crate) repeats: usize,
    /// How many stacks: R is their mean.
    pub(crate) stacks: usize,
    /// Neighbours in the order where it is worth it to take them together.
    pub(crate) pairs: Option<SomePairs<'a>>,
}

impl Layers<'_> {
    /// The kinds of each stack.
    pub(crate) fn each(&self) -> impl Iterator<Item = &[usize]> {
        // Stacks without a layer are there too: an interface.
        let length = self.order.len() / self.stacks.max(1);
        (0..self.stacks).map(move |stack| self.order.get(stack * length..(stack + 1) * length).unwrap_or_default())
    }

    /// Whether every phase at wavenumbers up to `largest` is small enough.
    pub(crate) fn has_short_phases(&self, largest: f64) -> bool {
        let inside = |kind: &(usize, f64)| {
            let index = self.media[kind.0].iter().chain(self.ambient).map(|n| n.norm()).fold(0.0, f64::max);
            2.0 * index * kind.1 * largest < LARGEST_PHASE
        };
        self.kinds.iter().all(inside)
    }
}

/// R at each of `wavenumbers` (`2 pi / wavelength`, 1/nm) for light at an angle of this cosine, above 0, in the ambient medium;
/// of several stacks the mean.
#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
pub(crate) fn values(layers: &Layers<'_>, cos: f64, wavenumbers: &[f64], out: &mut [SAndP]) {
    fused_or_not!(blocks(layers, cos, wavenumbers, out));
}

#[inline(always)]
fn blocks<const FUSED: bool>(layers: &Layers<'_>, cos: f64, wavenumbers: &[f64], out: &mut [SAndP]) {
    let same = layers.media.iter().chain([&layers.ambient, &layers.base]).all(|row| row.len() == 1);
    let mut waves = Vec::with_capacity(layers.media.len());
    let mut table = Vec::new();
    let (mut kept, mut met) = (vec![Matrix::NONE; layers.kinds.len().min(KEPT)], Matrix::NONE);
    let mut base = Wave::NONE;
    let mut ambient = [1.0; BLOCK];
    #[allow(clippy::cast_precision_loss, reason = "a count of stacks is small")]
    let stacks = layers.stacks as f64;
    for (number, (chunk, out)) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)).enumerate() {
        let start = number * BLOCK;
        if number == 0 || !same {
            (ambient, _) = block_of(layers.ambient, start);
            base = Wave::new::<FUSED>(block_of(layers.base, start), &ambient, cos);
            waves.clear();
            for row in layers.media {
                waves.push(Wave::new::<FUSED>(block_of(row, start), &ambient, cos));
            }
        }
        let mut k = [chunk[chunk.len() - 1]; BLOCK];
        k[..chunk.len()].copy_from_slice(chunk);
        for (matrix, &(medium, thickness)) in kept.iter_mut().zip(layers.kinds) {
            matrix.set::<FUSED>(&waves[medium], thickness, &k);
        }
        let mut sum = [SAndP::default(); BLOCK];
        // Complex matrices of pairs were measured to take longer than the layers one by one.
        let all_real = kept.len() == layers.kinds.len() && kept.iter().all(|matrix| matrix.real);
        let pairs = layers.pairs.filter(|_| all_real && layers.repeats == 1);
        if let Some(pairs) = pairs {
            sum = pairs::sums::<FUSED>(layers, pairs, &kept, (&base, &ambient, cos), &mut table);
        }
        for order in layers.each().filter(|_| pairs.is_none()) {
            let mut fields = Fields::behind(&base);
            let mut unscaled = 0;
            for &kind in std::iter::repeat_n(order, layers.repeats).flatten() {
                let matrix = if kind < kept.len() {
                    &kept[kind]
                } else {
                    let (medium, thickness) = layers.kinds[kind];
                    met.set::<FUSED>(&waves[medium], thickness, &k);
                    &met
                };
                if matrix.real {
                    fields.pass_real::<FUSED>(matrix);
                } else {
                    fields.pass::<FUSED>(matrix);
                }
                unscaled += 1;
                if unscaled == SCALED {
                    fields.scale();
                    unscaled = 0;
                }
            }
            for (sum, found) in sum.iter_mut().zip(fields.reflectivity(&ambient, cos)) {
                *sum = SAndP { s: sum.s + found.s, p: sum.p + found.p };
            }
        }
        let mean = |sum: &SAndP| SAndP { s: sum.s / stacks, p: sum.p / stacks };
        out.iter_mut().zip(&sum).for_each(|(out, sum)| *out = mean(sum));
    }
}

/// Real and imaginary part of a row at the wavelengths from `start` on; the last one fills the block.
#[inline(always)]
fn block_of(row: &[Complex<f64>], start: usize) -> (Block, Block) {
    let (mut re, mut im) = (ZERO, ZERO);
    for i in 0..BLOCK {
        let n = row[(start + i).min(row.len() - 1)];
        (re[i], im[i]) = (n.re, n.im);
    }
    (re, im)
}

/// What a medium does to a wave, for s and p: the admittances `kz` and `kz / n²`, and one over them.
#[derive(Debug, Clone, Copy)]
struct Wave {
    admittances: [(Block, Block); 2],
    impedances: [(Block, Block); 2],
    /// No loss, and the wave travels: the imaginary parts are 0.
    real: bool,
}

impl Wave {
    const NONE: Self = Self { admittances: [(ZERO, ZERO); 2], impedances: [(ZERO, ZERO); 2], real: false };

    #[inline(always)]
    fn new<const FUSED: bool>((n, loss): (Block, Block), ambient: &Block, cos: f64) -> Self {
        let mut wave = Self::NONE;
        for i in 0..BLOCK {
            // n² - n_ambient² sin² without the cancellation at grazing in the ambient's own medium
            let (along, lost) = (ambient[i] * cos, loss[i] * loss[i]);
            let re = mul_add::<FUSED>(n[i] - ambient[i], n[i] + ambient[i], -lost) + along * along;
            let im = 2.0 * n[i] * loss[i];
            let squared = (mul_add::<FUSED>(n[i], n[i], -lost), im);
            let re = if re.abs() + im > SMALLEST { re } else { SMALLEST };
            // The square root in the upper half plane: the larger part first, the other by division.
            let large = (0.5 * ((re * re + im * im).sqrt() + re.abs())).sqrt();
            let small = 0.5 * im / large;
            let kz = if re > 0.0 { (large, small) } else { (small, large) };
            (wave.admittances[0].0[i], wave.admittances[0].1[i]) = kz;
            (wave.admittances[1].0[i], wave.admittances[1].1[i]) = over::<FUSED>(kz, squared);
            (wave.impedances[0].0[i], wave.impedances[0].1[i]) = over::<FUSED>((1.0, 0.0), kz);
            (wave.impedances[1].0[i], wave.impedances[1].1[i]) = over::<FUSED>(squared, kz);
        }
        wave.real = wave.admittances[0].1.iter().sum::<f64>() <= 0.0;
        wave
    }
}

/// What a layer does to the fields: `same` to each, `by_h` from h to e and `by_e` from e to h, for s and p. Of a layer with a
/// real wave both of these times i.
#[derive(Debug, Clone, Copy)]
struct Matrix {
    real: bool,
    same: (Block, Block),
    by_h: [(Block, Block); 2],
    by_e: [(Block, Block); 2],
}

impl Matrix {
    const NONE: Self = Self { real: true, same: (ZERO, ZERO), by_h: [(ZERO, ZERO); 2], by_e: [(ZERO, ZERO); 2] };

    /// That of a layer; the imaginary parts of a real one are left as they were.
    #[inline(always)]
    fn set<const FUSED: bool>(&mut self, wave: &Wave, thickness: f64, k: &Block) {
        self.real = wave.real;
        let (kz, loss) = &wave.admittances[0];
        let (mut re, mut im) = (ZERO, ZERO);
        if wave.real {
            for i in 0..BLOCK {
                (re[i], self.same.0[i]) = sin_cos_fused::<FUSED>(k[i] * thickness * kz[i]);
            }
            for polarization in [0, 1] {
                let (to_e, to_h) = (&wave.impedances[polarization].0, &wave.admittances[polarization].0);
                for i in 0..BLOCK {
                    self.by_h[polarization].0[i] = re[i] * to_e[i];
                    self.by_e[polarization].0[i] = re[i] * to_h[i];
                }
            }
            return;
        }
        for i in 0..BLOCK {
            let path = k[i] * thickness;
            let (sin, cos) = sin_cos_fused::<FUSED>(path * kz[i]);
            let (left, gone) = decay::<FUSED>(2.0 * path * loss[i]);
            (re[i], im[i]) = (mul_add::<FUSED>(left * sin, sin, 0.5 * gone), -left * sin * cos);
            (self.same.0[i], self.same.1[i]) = (1.0 - re[i], -im[i]);
        }
        for polarization in [0, 1] {
            let (to_e, to_h) = (&wave.impedances[polarization], &wave.admittances[polarization]);
            let (by_h, by_e) = (&mut self.by_h[polarization], &mut self.by_e[polarization]);
            for i in 0..BLOCK {
                (by_h.0[i], by_h.1[i]) = times::<FUSED>((re[i], im[i]), (to_e.0[i], to_e.1[i]));
                (by_e.0[i], by_e.1[i]) = times::<FUSED>((re[i], im[i]), (to_h.0[i], to_h.1[i]));
            }
        }
    }
}

#[inline(always)]
fn times<const FUSED: bool>(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (mul_add::<FUSED>(a.0, b.0, -a.1 * b.1), mul_add::<FUSED>(a.0, b.1, a.1 * b.0))
}

#[inline(always)]
fn over<const FUSED: bool>(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let inverse = 1.0 / mul_add::<FUSED>(b.0, b.0, b.1 * b.1);
    let (re, im) = times::<FUSED>(a, (b.0, -b.1));
    (re * inverse, im * inverse)
}

/// `a b + c d`.
#[inline(always)]
fn two_times<const FUSED: bool>(a: (f64, f64), b: (f64, f64), c: (f64, f64), d: (f64, f64)) -> (f64, f64) {
    let re = mul_add::<FUSED>(a.0, b.0, mul_add::<FUSED>(-a.1, b.1, mul_add::<FUSED>(c.0, d.0, -c.1 * d.1)));
    let im = mul_add::<FUSED>(a.0, b.1, mul_add::<FUSED>(a.1, b.0, mul_add::<FUSED>(c.0, d.1, c.1 * d.0)));
    (re, im)
}

/// Tangential field amplitudes of one polarization.
#[derive(Debug, Clone, Copy)]
struct Field {
    e: (Block, Block),
    h: (Block, Block),
}

impl Field {
    /// R where the ambient's admittance is `y`. What overflowed or is 0/0 reflects all.
    #[inline(always)]
    fn reflectivity(&self, lane: usize, y: f64) -> f64 {
        let (e, h) = ((y * self.e.0[lane], y * self.e.1[lane]), (self.h.0[lane], self.h.1[lane]));
        let whole = (e.0 + h.0) * (e.0 + h.0) + (e.1 + h.1) * (e.1 + h.1);
        let reflected = (e.0 - h.0) * (e.0 - h.0) + (e.1 - h.1) * (e.1 - h.1);
        let ratio = reflected / whole;
        if ratio < 1.0 { ratio } else { 1.0 }
    }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Those of s and of p.
#[derive(Debug, Clone, Copy)]
struct Fields([Field; 2]);

impl Fields {
    /// The wave that leaves into the base.
    #[inline(always)]
    fn behind(base: &Wave) -> Self {
        Self(base.admittances.map(|h| Field { e: ([1.0; BLOCK], ZERO), h }))
    }

    #[inline(always)]
    fn pass<const FUSED: bool>(&mut self, matrix: &Matrix) {
        let (same, same_im) = &matrix.same;
        for (field, (by_h, by_e)) in self.0.iter_mut().zip(matrix.by_h.iter().zip(&matrix.by_e)) {
            for i in 0..BLOCK {
                let (same, by_h, by_e) = ((same[i], same_im[i]), (by_h.0[i], by_h.1[i]), (by_e.0[i], by_e.1[i]));
                let (e, h) = ((field.e.0[i], field.e.1[i]), (field.h.0[i], field.h.1[i]));
                (field.e.0[i], field.e.1[i]) = two_times::<FUSED>(same, e, by_h, h);
                (field.h.0[i], field.h.1[i]) = two_times::<FUSED>(same, h, by_e, e);
            }
        }
    }

    #[inline(always)]
    fn pass_real<const FUSED: bool>(&mut self, matrix: &Matrix) {
        let same = &matrix.same.0;
        for (field, (by_h, by_e)) in self.0.iter_mut().zip(matrix.by_h.iter().zip(&matrix.by_e)) {
            for i in 0..BLOCK {
                let (e, h) = ((field.e.0[i], field.e.1[i]), (field.h.0[i], field.h.1[i]));
                field.e.0[i] = mul_add::<FUSED>(same[i], e.0, by_h.0[i] * h.1);
                field.e.1[i] = mul_add::<FUSED>(same[i], e.1, -by_h.0[i] * h.0);
                field.h.0[i] = mul_add::<FUSED>(same[i], h.0, by_e.0[i] * e.1);
                field.h.1[i] = mul_add::<FUSED>(same[i], h.1, -by_e.0[i] * e.0);
            }
        }
    }

    /// Makes the largest part of each lane 1: reflectivity is a ratio.
    #[inline(always)]
    fn scale(&mut self) {
        for field in &mut self.0 {
            for i in 0..BLOCK {
                let e = larger(field.e.0[i].abs(), field.e.1[i].abs());
                let h = larger(field.h.0[i].abs(), field.h.1[i].abs());
                let inverse = 1.0 / larger(e, h);
                field.e.0[i] *= inverse;
                field.e.1[i] *= inverse;
                field.h.0[i] *= inverse;
                field.h.1[i] *= inverse;
            }
        }
    }

    #[inline(always)]
    fn reflectivity(&self, ambient: &Block, cos: f64) -> [SAndP; BLOCK] {
        let mut found = [SAndP { s: 0.0, p: 0.0 }; BLOCK];
        let [s, p] = &self.0;
        for i in 0..BLOCK {
            found[i] = SAndP { s: s.reflectivity(i, ambient[i] * cos), p: p.reflectivity(i, cos / ambient[i]) };
        }
        found
    }
}

#[cfg(test)]
mod tests;
