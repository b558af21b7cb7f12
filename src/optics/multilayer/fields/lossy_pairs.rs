//! [`pairs`](super::pairs) of layers that absorb, or through which no wave travels: all numbers complex.
//!
//! ```text
//! e' = Q e + (P/Y) h,   h' = P Y e + Q h   through one layer, and the product of two such matrices through a pair
//! ```
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::pairs::{LANES, LARGEST, Lanes, RUN, SomePairs};
use super::{BLOCK, Block, Layers, Matrix, Wave, larger, two_times};
use crate::optics::multilayer::SAndP;

/// Pairs after which the fields are scaled at the latest: a part of them may shrink where the other is lost.
const SCALED: f64 = 16.0;

/// Real and imaginary part.
type Parts = (Lanes, Lanes);

/// The matrix of two layers, row by row.
pub(super) type LossyPair = [Parts; 4];

/// The sum of R of the stacks of `layers`.
#[inline(always)]
pub(super) fn sums<const FUSED: bool>(
    layers: &Layers<'_>,
    pairs: SomePairs<'_>,
    matrices: &[Matrix],
    (base, ambient, cos): (&Wave, &Block, f64),
    table: &mut Vec<LossyPair>,
) -> [SAndP; BLOCK] {
    let mut sums = [SAndP::default(); BLOCK];
    for start in (0..BLOCK).step_by(LANES) {
        for polarization in [0, 1] {
            table.clear();
            let mut largest = Lanes([1.0; LANES]);
            for &(first, second) in pairs.met {
                let pair = product::<FUSED>(&matrices[first], &matrices[second], polarization, start);
                for (re, im) in &pair {
                    for i in 0..LANES {
                        largest.0[i] = larger(largest.0[i], larger(re.0[i].abs(), im.0[i].abs()));
                    }
                }
                table.push(pair);
            }
            // Each passage multiplies the largest part by at most four times it.
            let largest = largest.0.into_iter().fold(1.0, f64::max);
            let unscaled = (LARGEST.ln() / (4.0 * largest).ln()).floor().clamp(1.0, SCALED);
            let (re, im) = &base.admittances[polarization];
            let behind = [(Lanes([1.0; LANES]), Lanes::ZERO), (Lanes::of(re, start), Lanes::of(im, start))];
            let mut admittance = Lanes::of(ambient, start);
            for n in &mut admittance.0 {
                *n = if polarization == 0 { *n * cos } else { cos / *n };
            }
            let found = sum::<FUSED>(table, pairs.order, layers.stacks, (&behind, &admittance), unscaled);
            for lane in 0..LANES {
                let sum = &mut sums[start + lane];
                *(if polarization == 0 { &mut sum.s } else { &mut sum.p }) = found.0[lane];
            }
        }
    }
    sums
}

/// Complex factors `(same, by_h, by_e)` of a layer, also of one whose matrix is real.
#[inline(always)]
fn factors(matrix: &Matrix, polarization: usize, start: usize) -> [Parts; 3] {
    let parts = |(re, im): &(Block, Block)| (Lanes::of(re, start), Lanes::of(im, start));
    let (by_h, by_e) = (&matrix.by_h[polarization], &matrix.by_e[polarization]);
    if !matrix.real {
        return [parts(&matrix.same), parts(by_h), parts(by_e)];
    }
    // Of a real one those of the other field are there without their factor -i.
    let mut turned = [(Lanes::ZERO, Lanes::of(&by_h.0, start)), (Lanes::ZERO, Lanes::of(&by_e.0, start))];
    for (_, im) in &mut turned {
        for value in &mut im.0 {
            *value = -*value;
        }
    }
    [(Lanes::of(&matrix.same.0, start), Lanes::ZERO), turned[0], turned[1]]
}

/// First through the layer that is nearer to the base.
#[inline(always)]
fn product<const FUSED: bool>(first: &Matrix, second: &Matrix, polarization: usize, start: usize) -> LossyPair {
    let ([c, b, a], [same, by_h, by_e]) = (factors(first, polarization, start), factors(second, polarization, start));
    let mut pair = [(Lanes::ZERO, Lanes::ZERO); 4];
    for i in 0..LANES {
        let at = |parts: &Parts| (parts.0.0[i], parts.1.0[i]);
        let ([c, b, a], [same, by_h, by_e]) = ([at(&c), at(&b), at(&a)], [at(&same), at(&by_h), at(&by_e)]);
        let found = [
            two_times::<FUSED>(same, c, by_h, a),
            two_times::<FUSED>(same, b, by_h, c),
            two_times::<FUSED>(by_e, c, same, a),
            two_times::<FUSED>(by_e, b, same, c),
        ];
        for (pair, found) in pair.iter_mut().zip(found) {
            (pair.0.0[i], pair.1.0[i]) = found;
        }
    }
    pair
}

/// The sum of R of all stacks, of one polarization.
#[inline(always)]
fn sum<const FUSED: bool>(
    table: &[LossyPair],
    order: &[usize],
    stacks: usize,
    (behind, admittance): (&[Parts; 2], &Lanes),
    unscaled: f64,
) -> Lanes {
    let mut sum = Lanes::ZERO;
    for stack in order.chunks_exact((order.len() / stacks.max(1)).max(1)) {
        let mut fields = *behind;
        let mut passed = 0.0;
        for run in stack.chunks(RUN) {
            if let &[one, two, three] = run {
                pass::<FUSED, RUN>(&mut fields, [&table[one], &table[two], &table[three]]);
                passed += 3.0;
            } else {
                for &pair in run {
                    pass::<FUSED, 1>(&mut fields, [&table[pair]]);
                    passed += 1.0;
                }
            }
            if passed + 3.0 > unscaled {
                scale(&mut fields);
                passed = 0.0;
            }
        }
        let [(e, e_im), (h, h_im)] = &fields;
        for i in 0..LANES {
            let y = admittance.0[i];
            let (e, h) = ((y * e.0[i], y * e_im.0[i]), (h.0[i], h_im.0[i]));
            let whole = (e.0 + h.0) * (e.0 + h.0) + (e.1 + h.1) * (e.1 + h.1);
            let reflected = (e.0 - h.0) * (e.0 - h.0) + (e.1 - h.1) * (e.1 - h.1);
            let ratio = reflected / whole;
            // What overflowed or is 0/0 reflects all.
            sum.0[i] += if ratio < 1.0 { ratio } else { 1.0 };
        }
    }
    sum
}

#[inline(always)]
fn pass<const FUSED: bool, const COUNT: usize>(fields: &mut [Parts; 2], pairs: [&LossyPair; COUNT]) {
    for i in 0..LANES {
        let mut e = (fields[0].0.0[i], fields[0].1.0[i]);
        let mut h = (fields[1].0.0[i], fields[1].1.0[i]);
        for pair in pairs {
            let [ee, eh, he, hh] = [
                (pair[0].0.0[i], pair[0].1.0[i]),
                (pair[1].0.0[i], pair[1].1.0[i]),
                (pair[2].0.0[i], pair[2].1.0[i]),
                (pair[3].0.0[i], pair[3].1.0[i]),
            ];
            (e, h) = (two_times::<FUSED>(ee, e, eh, h), two_times::<FUSED>(he, e, hh, h));
        }
        (fields[0].0.0[i], fields[0].1.0[i]) = e;
        (fields[1].0.0[i], fields[1].1.0[i]) = h;
    }
}

/// Makes the largest part of each lane 1: reflectivity is a ratio.
#[inline(always)]
fn scale(fields: &mut [Parts; 2]) {
    for i in 0..LANES {
        let (e, h) = ((fields[0].0.0[i], fields[0].1.0[i]), (fields[1].0.0[i], fields[1].1.0[i]));
        let inverse = 1.0 / larger(larger(e.0.abs(), e.1.abs()), larger(h.0.abs(), h.1.abs()));
        (fields[0].0.0[i], fields[0].1.0[i]) = (e.0 * inverse, e.1 * inverse);
        (fields[1].0.0[i], fields[1].1.0[i]) = (h.0 * inverse, h.1 * inverse);
    }
}
