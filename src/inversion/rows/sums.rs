//! Sums of products of derivatives over readings, in vector code.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::kernels::{LANES, lanes};
use super::slopes::Chunk;
use crate::inversion::parameter::COUNT;
use crate::numerics::blocks::padded;
use crate::numerics::fused::{fused_or_not, mul_add};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Sums over the readings of chunks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ColumnSums {
    /// Products of each column with itself and those before it; 0 elsewhere.
    pub(crate) gram: [[f64; COUNT]; COUNT],
    /// Products with the residuals.
    pub(crate) gradient: [f64; COUNT],
}

/// The sums of `chunks`; `residuals` are those of all readings.
#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
pub(crate) fn sums(chunks: &[Chunk], residuals: &[f64]) -> ColumnSums {
    if target_cfg_f!(target_feature = "avx512f") {
        return sums_of::<true, LANES>(chunks, residuals);
    }
    fused_or_not!(sums_by_halves(chunks, residuals))
}

#[inline(always)]
fn sums_by_halves<const FUSED: bool>(chunks: &[Chunk], residuals: &[f64]) -> ColumnSums {
    sums_of::<FUSED, { LANES / 2 }>(chunks, residuals)
}

/// With `N` lanes at a time, in two passes: more sums at once than registers would have to wait in memory.
#[inline(always)]
pub(super) fn sums_of<const FUSED: bool, const N: usize>(chunks: &[Chunk], residuals: &[f64]) -> ColumnSums {
    let z = [0.0; N];
    let (mut aa, mut ab, mut ac, mut ad, mut ae, mut ar) = (z, z, z, z, z, z);
    let (mut bb, mut bc, mut bd, mut be, mut br) = (z, z, z, z, z);
    for chunk in chunks {
        let all = padded::<LANES>(residuals, chunk.first);
        let mut at = 0;
        while at < LANES {
            let (a, b) = (lanes::<N>(&chunk.columns[0], at), lanes::<N>(&chunk.columns[1], at));
            let (c, d) = (lanes::<N>(&chunk.columns[2], at), lanes::<N>(&chunk.columns[3], at));
            let (e, r) = (lanes::<N>(&chunk.columns[4], at), lanes::<N>(&all, at));
            aa = add::<FUSED, N>(a, a, aa);
            ab = add::<FUSED, N>(a, b, ab);
            ac = add::<FUSED, N>(a, c, ac);
            ad = add::<FUSED, N>(a, d, ad);
            ae = add::<FUSED, N>(a, e, ae);
            ar = add::<FUSED, N>(a, r, ar);
            bb = add::<FUSED, N>(b, b, bb);
            bc = add::<FUSED, N>(b, c, bc);
            bd = add::<FUSED, N>(b, d, bd);
            be = add::<FUSED, N>(b, e, be);
            br = add::<FUSED, N>(b, r, br);
            at += N;
        }
    }
    let (mut cc, mut cd, mut ce, mut cr) = (z, z, z, z);
    let (mut dd, mut de, mut dr, mut ee, mut er) = (z, z, z, z, z);
    for chunk in chunks {
        let all = padded::<LANES>(residuals, chunk.first);
        let mut at = 0;
        while at < LANES {
            let (c, d) = (lanes::<N>(&chunk.columns[2], at), lanes::<N>(&chunk.columns[3], at));
            let (e, r) = (lanes::<N>(&chunk.columns[4], at), lanes::<N>(&all, at));
            cc = add::<FUSED, N>(c, c, cc);
            cd = add::<FUSED, N>(c, d, cd);
            ce = add::<FUSED, N>(c, e, ce);
            cr = add::<FUSED, N>(c, r, cr);
            dd = add::<FUSED, N>(d, d, dd);
            de = add::<FUSED, N>(d, e, de);
            dr = add::<FUSED, N>(d, r, dr);
            ee = add::<FUSED, N>(e, e, ee);
            er = add::<FUSED, N>(e, r, er);
            at += N;
        }
    }
    together(
        &[[aa, z, z, z, z], [ab, bb, z, z, z], [ac, bc, cc, z, z], [ad, bd, cd, dd, z], [ae, be, ce, de, ee]],
        &[ar, br, cr, dr, er],
    )
}

#[inline(always)]
fn add<const FUSED: bool, const N: usize>(a: [f64; N], b: [f64; N], c: [f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for lane in 0..N {
        sum[lane] = mul_add::<FUSED>(a[lane], b[lane], c[lane]);
    }
    sum
}

/// The lanes together; apart from the loops, whose sums then stay in registers.
#[inline(never)]
fn together<const N: usize>(gram: &[[[f64; N]; COUNT]; COUNT], gradient: &[[f64; N]; COUNT]) -> ColumnSums {
    let one = |lanes: &[f64; N]| lanes.iter().sum();
    ColumnSums { gram: gram.map(|row| row.each_ref().map(one)), gradient: gradient.each_ref().map(one) }
}

/// The products of each column of `chunks` with `values`, of all readings.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(crate) fn along(chunks: &[Chunk], values: &[f64]) -> [f64; COUNT] {
    let mut sums = [[0.0; LANES]; COUNT];
    for chunk in chunks {
        let values = padded::<LANES>(values, chunk.first);
        for j in 0..COUNT {
            for lane in 0..LANES {
                sums[j][lane] += chunk.columns[j][lane] * values[lane];
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}
