//! Many stacks of a few kinds of layers: what two neighbours do together is computed once for all stacks.
//!
//! ```text
//! (e_re, h_im) and (e_im, -h_re):   x' = [c, b; -a, c] x   through a layer without loss,   a two layers' matrix is their product
//! ```
//!
//! with the sine times the impedance as b, times the admittance as a. Of 961 stacks of 18 layers each pair of kinds is met nine
//! times, so that half of the products are left; and a few matrices in turn leave the fields in registers between them.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::{BLOCK, Block, Layers, Matrix, Wave};
use crate::numerics::fused::mul_add;
use crate::optics::multilayer::SAndP;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Wavelengths that go together: the table of one polarization of 961 pairs is then a quarter of a megabyte.
const LANES: usize = 8;
/// Matrices that the fields pass in one go.
const RUN: usize = 3;

/// One value for each wavelength, where a vector register can be loaded at once.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Lanes([f64; LANES]);

impl Lanes {
    const ZERO: Self = Self([0.0; LANES]);

    /// Those of a block from `start` on.
    #[inline(always)]
    fn of(block: &Block, start: usize) -> Self {
        Self(std::array::from_fn(|lane| block[start + lane]))
    }
}

/// Neighbours in stacks: each pair of kinds that is met, and the stacks as numbers of these.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pairs {
    /// Kinds of the layer that is nearer to the base and of the other.
    met: Vec<(usize, usize)>,
    /// Numbers of the pairs, stack by stack, from the base to the light.
    order: Vec<usize>,
}

impl Pairs {
    /// Those of stacks of an even number of layers each, one after the other.
    pub(crate) fn of(order: &[usize]) -> Self {
        let mut numbers = FxHashMap::default();
        let mut pairs = Self::default();
        for pair in order.chunks_exact(2) {
            let pair = (pair[0], pair[1]);
            let number = *numbers.entry(pair).or_insert_with(|| {
                pairs.met.push(pair);
                pairs.met.len() - 1
            });
            pairs.order.push(number);
        }
        pairs
    }

    /// Those of some places of the layers, whole stacks, if a table of all pairs is worth it for them.
    pub(crate) fn within(&self, places: Range<usize>) -> Option<SomePairs<'_>> {
        let order = self.order.get(places.start / 2..places.end / 2)?;
        (order.len() > self.met.len()).then_some(SomePairs { met: &self.met, order })
    }
}

/// [`Pairs`] of a part of the stacks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SomePairs<'a> {
    met: &'a [(usize, usize)],
    order: &'a [usize],
}

/// The matrix of two layers, row by row.
pub(super) type Pair = [Lanes; 4];

/// The sum of R of the stacks of `layers`, of whose kinds `matrices` are real.
#[inline(always)]
pub(super) fn sums<const FUSED: bool>(
    layers: &Layers<'_>,
    pairs: SomePairs<'_>,
    matrices: &[Matrix],
    (base, ambient, cos): (&Wave, &Block, f64),
    table: &mut Vec<Pair>,
) -> [SAndP; BLOCK] {
    let mut sums = [SAndP::default(); BLOCK];
    for start in (0..BLOCK).step_by(LANES) {
        for polarization in [0, 1] {
            table.clear();
            for &(first, second) in pairs.met {
                table.push(product::<FUSED>(&matrices[first], &matrices[second], polarization, start));
            }
            let (re, im) = &base.admittances[polarization];
            let fields =
                [Lanes([1.0; LANES]), Lanes::of(im, start), Lanes::ZERO, Lanes(Lanes::of(re, start).0.map(|h| -h))];
            let admittance =
                Lanes(Lanes::of(ambient, start).0.map(|n| if polarization == 0 { n * cos } else { cos / n }));
            let found = sum::<FUSED>(table, pairs.order, layers.stacks, (&fields, &admittance));
            for lane in 0..LANES {
                let sum = &mut sums[start + lane];
                *(if polarization == 0 { &mut sum.s } else { &mut sum.p }) = found.0[lane];
            }
        }
    }
    sums
}

/// First through the layer that is nearer to the base.
#[inline(always)]
fn product<const FUSED: bool>(first: &Matrix, second: &Matrix, polarization: usize, start: usize) -> Pair {
    let rows = |matrix: &Matrix| {
        let (to_e, to_h) = (&matrix.by_h[polarization].0, &matrix.by_e[polarization].0);
        [&matrix.same.0, to_e, to_h].map(|block| Lanes::of(block, start).0)
    };
    let ([c, b, a], [cos, to_e, to_h]) = (rows(first), rows(second));
    let mut pair = [Lanes::ZERO; 4];
    for i in 0..LANES {
        pair[0].0[i] = mul_add::<FUSED>(cos[i], c[i], -to_e[i] * a[i]);
        pair[1].0[i] = mul_add::<FUSED>(cos[i], b[i], to_e[i] * c[i]);
        pair[2].0[i] = -mul_add::<FUSED>(to_h[i], c[i], cos[i] * a[i]);
        pair[3].0[i] = mul_add::<FUSED>(cos[i], c[i], -to_h[i] * b[i]);
    }
    pair
}

/// The sum of R of all stacks, of one polarization.
#[inline(always)]
fn sum<const FUSED: bool>(
    table: &[Pair],
    order: &[usize],
    stacks: usize,
    (behind, admittance): (&[Lanes; 4], &Lanes),
) -> Lanes {
    let mut sum = Lanes::ZERO;
    for stack in order.chunks_exact((order.len() / stacks.max(1)).max(1)) {
        let mut fields = *behind;
        for run in stack.chunks(RUN) {
            if let &[one, two, three] = run {
                pass::<FUSED, RUN>(&mut fields, [&table[one], &table[two], &table[three]]);
            } else {
                for &pair in run {
                    pass::<FUSED, 1>(&mut fields, [&table[pair]]);
                }
            }
        }
        for i in 0..LANES {
            let y = admittance.0[i];
            let (e, h) = ((y * fields[0].0[i], y * fields[2].0[i]), (-fields[3].0[i], fields[1].0[i]));
            let whole = (e.0 + h.0) * (e.0 + h.0) + (e.1 + h.1) * (e.1 + h.1);
            let reflected = (e.0 - h.0) * (e.0 - h.0) + (e.1 - h.1) * (e.1 - h.1);
            let ratio = reflected / whole;
            // Without loss fields grow where the stack reflects, by 1e150 and more only where it reflects all but 1e-300: what overflowed, or
            // is 0/0, reflects all.
            sum.0[i] += if ratio < 1.0 { ratio } else { 1.0 };
        }
    }
    sum
}

#[inline(always)]
fn pass<const FUSED: bool, const COUNT: usize>(fields: &mut [Lanes; 4], pairs: [&Pair; COUNT]) {
    for i in 0..LANES {
        let [mut e, mut h, mut other_e, mut other_h] = [fields[0].0[i], fields[1].0[i], fields[2].0[i], fields[3].0[i]];
        for pair in pairs {
            let [ee, eh, he, hh] = [pair[0].0[i], pair[1].0[i], pair[2].0[i], pair[3].0[i]];
            (e, h) = (mul_add::<FUSED>(ee, e, eh * h), mul_add::<FUSED>(hh, h, he * e));
            (other_e, other_h) =
                (mul_add::<FUSED>(ee, other_e, eh * other_h), mul_add::<FUSED>(hh, other_h, he * other_e));
        }
        [fields[0].0[i], fields[1].0[i], fields[2].0[i], fields[3].0[i]] = [e, h, other_e, other_h];
    }
}

#[cfg(test)]
mod tests {
    use super::super::{blocks, values};
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::Complex;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Two kinds of gaps and three of cuticle in stacks of 1 to 10 periods; the last index is that of the base.
    fn differs(indices: [Vec<Complex<f64>>; 4], periods: usize, angle: f64) -> f64 {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(periods as u64);
        let [ambient, gap, cuticle, base] = &indices;
        let kinds: Vec<(usize, f64)> =
            (0..5).map(|kind| (usize::from(kind > 1), random.random_range(0.0..300.0))).collect();
        let stacks = 17;
        let order: Vec<usize> =
            (0..stacks * periods).flat_map(|_| [random.random_range(0..2), random.random_range(2..5)]).collect();
        let pairs = Pairs::of(&order);
        let layers = Layers {
            ambient,
            base,
            media: &[gap, cuticle],
            kinds: &kinds,
            order: &order,
            repeats: 1,
            stacks,
            pairs: None,
        };
        let together = Layers { pairs: pairs.within(0..order.len()), ..layers };
        assert!(together.pairs.is_some());
        let wavenumbers: Vec<f64> =
            (0..37).map(|step| std::f64::consts::TAU / (380.0 + 10.0 * f64::from(step))).collect();
        let mut found = [(); 3].map(|()| vec![SAndP::default(); wavenumbers.len()]);
        values(&layers, angle.cos(), &wavenumbers, &mut found[0]);
        values(&together, angle.cos(), &wavenumbers, &mut found[1]);
        blocks::<false>(&together, angle.cos(), &wavenumbers, &mut found[2]);
        let [apart, together, portable] = &found;
        let each = apart.iter().zip(together.iter().zip(portable));
        each.flat_map(|(a, (b, c))| [a.s - b.s, a.p - b.p, a.s - c.s, a.p - c.p]).fold(0.0, |most, d| d.abs().max(most))
    }

    /// Against the recurrence layer by layer.
    #[test]
    fn neighbours_together_do_what_they_do_one_after_the_other() {
        let index = |n: f64, loss: f64| vec![Complex::new(n, loss)];
        let row = |n: f64| (0..37).map(|place| Complex::new(n + 1e-3 * f64::from(place), 0.0)).collect();
        for periods in 1..=10 {
            for angle in [0.0, 0.7, 1.5] {
                for indices in [
                    [index(1.0, 0.0), index(1.0, 0.0), index(1.56, 0.0), index(1.0, 0.0)],
                    [index(1.0, 0.0), row(1.1), row(1.6), index(1.5, 0.1)],
                    [row(1.0), row(1.3), row(2.4), index(3.5, 0.0)],
                    // A cuticle that absorbs, which has no real matrix, and a gap through which no wave travels at 0.7.
                    [index(1.0, 0.0), index(1.0, 0.0), index(1.56, 0.06), index(1.56, 0.06)],
                    [index(1.6, 0.0), index(1.0, 0.0), index(1.56, 0.0), index(1.6, 0.0)],
                ] {
                    assert_abs_diff_eq!(differs(indices, periods, angle), 0.0, epsilon = 1e-13);
                }
            }
        }
    }

    /// Each period multiplies the field by up to 1e5 and more: 1000 of them pass the largest number many times.
    #[test]
    fn a_stack_whose_fields_overflow_reflects_all() {
        let index = |n: f64| vec![Complex::new(n, 0.0)];
        let off = differs([index(1.0), index(1.0), index(300.0), index(1.0)], 1000, 0.3);
        assert_abs_diff_eq!(off, 0.0, epsilon = 1e-13);
    }

    #[test]
    fn a_table_is_made_where_it_saves_products() {
        let pairs = Pairs::of(&[0, 2, 1, 3, 0, 2, 0, 2]);
        assert_eq!(pairs.met, [(0, 2), (1, 3)]);
        assert_eq!(pairs.order, [0, 1, 0, 0]);
        assert!(pairs.within(0..4).is_none() && pairs.within(2..8).is_some() && pairs.within(0..10).is_none());
    }
}
