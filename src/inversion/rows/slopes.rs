//! Derivatives of readings, some at a time, in vector code.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::kernels::{Found, LANES, Listed, Onward, Place, Still, lanes};
use super::{Nodes, Run};
use crate::inversion::parameter::COUNT;
use crate::numerics::blocks::put;
use multiversion::multiversion;

/// Weighted derivatives of neighbouring readings of one run, a column for each parameter.
///
/// As long as a vector register in each column and laid like one: none lies across two lines of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Chunk {
    pub(super) columns: [[f64; LANES]; COUNT],
    /// The reading of the first lane.
    pub(super) first: usize,
    /// The lanes from `start` to `end` are its own; the derivatives of the others are 0.
    start: usize,
    end: usize,
}

impl Chunk {
    const ZERO: Self = Self { columns: [[0.0; LANES]; COUNT], first: 0, start: 0, end: 0 };

    /// Writes its own derivatives to their readings, of all of which `columns` are.
    pub(crate) fn write(&self, columns: &mut [&mut [f64]; COUNT]) {
        for (column, own) in columns.iter_mut().zip(&self.columns) {
            if self.end - self.start == LANES {
                put(own, column, self.first);
            } else {
                column[self.first + self.start..self.first + self.end].copy_from_slice(&own[self.start..self.end]);
            }
        }
    }
}

/// What derivatives of readings are made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slopes<'a> {
    /// Factors on the two models.
    pub(super) factors: (f64, f64),
    /// Derivatives of Model A by the period and by the width.
    pub(super) lamella: [&'a [f64]; 2],
    /// R, and its derivatives by `d_air`, `d_cuticle` and the tilt.
    pub(super) stack: [&'a [f64]; 4],
    /// L, and its derivatives by the tilt, the half-width and the width of the lamellae.
    pub(super) lobe: [&'a [f64]; 4],
    /// Whether the lobe depends on the width of the lamellae, as that of a product does; else its fourth list is taken 0 times, and
    /// may be any of finite values and the length of the others.
    pub(super) lobe_sees_width: bool,
}

/// The chunks of `runs`, into `out` in the place of what was there; `weights` are those of all readings.
pub(super) fn slopes(out: &mut Vec<Chunk>, weights: &[f64], runs: &[Run], of: &Slopes<'_>) {
    out.resize(runs.iter().map(|run| run.rows.len().div_ceil(LANES)).sum(), Chunk::ZERO);
    fill(out, weights, runs, of);
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn fill(out: &mut [Chunk], weights: &[f64], runs: &[Run], of: &Slopes<'_>) {
    let mut rest = out;
    for run in runs {
        let own;
        (own, rest) = rest.split_at_mut(run.rows.len().div_ceil(LANES));
        let weights = &weights[run.rows.clone()];
        // Where a model is not seen nothing is looked up.
        let lamella = if run.share_a > 0.0 { &run.lamella } else { &Nodes::From(0) };
        let (stack, lobe) =
            if run.share_b > 0.0 { (&run.stack, &run.lobe) } else { (&Nodes::Same(0), &Nodes::From(0)) };
        match (lamella, stack, lobe) {
            (Nodes::From(lamella), Nodes::Same(stack), Nodes::From(lobe)) => {
                fill_run(own, weights, run, of, Onward(*lamella), Still(*stack), Onward(*lobe));
            }
            (Nodes::From(lamella), Nodes::From(stack), Nodes::Same(lobe)) => {
                fill_run(own, weights, run, of, Onward(*lamella), Onward(*stack), Still(*lobe));
            }
            (lamella, stack, lobe) => {
                fill_run(own, weights, run, of, Listed(lamella), Listed(stack), Listed(lobe));
            }
        }
    }
}

/// The chunks of a run. The last one lies over the one before, and leaves to it what they share.
#[inline(always)]
fn fill_run(
    out: &mut [Chunk],
    weights: &[f64],
    run: &Run,
    of: &Slopes<'_>,
    lamella: impl Place,
    stack: impl Place,
    lobe: impl Place,
) {
    let length = weights.len();
    for (place, chunk) in out.iter_mut().enumerate() {
        let at = (place * LANES).min(length.saturating_sub(LANES));
        (chunk.first, chunk.start, chunk.end) = (run.rows.start + at, place * LANES - at, LANES.min(length));
    }
    if run.share_b > 0.0 {
        put_multilayer(out, weights, run, of, stack, lobe);
    } else {
        out.iter_mut().for_each(|chunk| chunk.columns = Chunk::ZERO.columns);
    }
    if run.share_a > 0.0 {
        add_lamella(out, weights, run, of, lamella);
    }
    if let Some(last) = out.last_mut() {
        for lane in (0..last.start).chain(last.end..LANES) {
            for j in 0..COUNT {
                last.columns[j][lane] = 0.0;
            }
        }
    }
}

/// Calls `$body` for all chunks of a run: with all lanes of each, or one by one where there are fewer.
macro_rules! each {
    ($out:expr, $start:expr, $length:expr, $body:ident($($argument:expr),*)) => {
        if $length < LANES {
            for lane in 0..$length {
                $body::<1, _, _>(&mut $out[0], lane, lane, $($argument),*);
            }
        } else {
            for chunk in $out.iter_mut() {
                let at = chunk.first - $start;
                $body::<LANES, _, _>(chunk, 0, at, $($argument),*);
            }
        }
    };
}

/// Puts the derivatives of Model B in the place of what was there.
#[inline(always)]
fn put_multilayer(out: &mut [Chunk], weights: &[f64], run: &Run, of: &Slopes<'_>, stack: impl Place, lobe: impl Place) {
    let (factor, length) = (of.factors.1 * run.share_b, weights.len());
    let ([r, air, cuticle, tilt], [l, l_tilt, half_width, width]) = (of.stack, of.lobe);
    let stack = [stack.of(r, length), stack.of(air, length), stack.of(cuticle, length), stack.of(tilt, length)];
    let lobe = [lobe.of(l, length), lobe.of(l_tilt, length), lobe.of(half_width, length), lobe.of(width, length)];
    let factors = (factor, if of.lobe_sees_width { factor } else { 0.0 });
    each!(out, run.rows.start, length, multilayer_at(weights, factors, stack, lobe));
}

#[inline(always)]
fn multilayer_at<const N: usize, R: Found, L: Found>(
    chunk: &mut Chunk,
    lane: usize,
    at: usize,
    weights: &[f64],
    (factor, by_width): (f64, f64),
    [r, r_air, r_cuticle, r_tilt]: [R; 4],
    [l, l_tilt, l_half_width, l_width]: [L; 4],
) {
    let (weights, r, r_air) = (lanes::<N>(weights, at), r.lanes::<N>(at), r_air.lanes::<N>(at));
    let (r_cuticle, r_tilt) = (r_cuticle.lanes::<N>(at), r_tilt.lanes::<N>(at));
    let (l, l_tilt) = (l.lanes::<N>(at), l_tilt.lanes::<N>(at));
    let (l_half_width, l_width) = (l_half_width.lanes::<N>(at), l_width.lanes::<N>(at));
    for i in 0..N {
        let weight = weights[i] * factor;
        let (weighted, reflected) = (weight * l[i], weight * r[i]);
        chunk.columns[0][lane + i] = weighted * r_air[i];
        chunk.columns[1][lane + i] = weighted * r_cuticle[i];
        chunk.columns[2][lane + i] = weighted * r_tilt[i] + reflected * l_tilt[i];
        chunk.columns[3][lane + i] = reflected * l_half_width[i];
        chunk.columns[4][lane + i] = weights[i] * by_width * (r[i] * l_width[i]);
    }
}

/// Adds those of Model A.
#[inline(always)]
fn add_lamella(out: &mut [Chunk], weights: &[f64], run: &Run, of: &Slopes<'_>, lamella: impl Place) {
    let (factor, length) = (of.factors.0 * run.share_a, weights.len());
    let [by_period, by_width] = of.lamella.map(|slopes| lamella.of(slopes, length));
    each!(out, run.rows.start, length, lamella_at(weights, factor, by_period, by_width));
}

#[inline(always)]
fn lamella_at<const N: usize, P: Found, W: Found>(
    chunk: &mut Chunk,
    lane: usize,
    at: usize,
    weights: &[f64],
    factor: f64,
    by_period: P,
    by_width: W,
) {
    let (weights, by_period, by_width) = (lanes::<N>(weights, at), by_period.lanes::<N>(at), by_width.lanes::<N>(at));
    for i in 0..N {
        let weight = weights[i] * factor;
        let by_period = weight * by_period[i];
        chunk.columns[0][lane + i] += by_period;
        chunk.columns[1][lane + i] += by_period;
        chunk.columns[4][lane + i] += weight * by_width[i];
    }
}
