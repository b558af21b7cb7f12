//! Vector code over the readings of runs.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::{Nodes, Run};
use multiversion::multiversion;

/// Readings that go together.
const LANES: usize = 8;

/// Where the readings of a run find a quantity.
trait Place: Copy {
    /// The values of `N` readings from `reading` on.
    fn lanes<const N: usize>(self, values: &[f64], reading: usize) -> [f64; N];
}

/// All at one node.
#[derive(Clone, Copy)]
struct Still(usize);

/// At one node after the other.
#[derive(Clone, Copy)]
struct Onward(usize);

/// 1 everywhere, whatever the values.
#[derive(Clone, Copy)]
struct One;

impl Place for One {
    #[inline(always)]
    fn lanes<const N: usize>(self, _: &[f64], _: usize) -> [f64; N] {
        [1.0; N]
    }
}

impl Place for Still {
    #[inline(always)]
    fn lanes<const N: usize>(self, values: &[f64], _: usize) -> [f64; N] {
        [values[self.0]; N]
    }
}

impl Place for Onward {
    #[inline(always)]
    fn lanes<const N: usize>(self, values: &[f64], reading: usize) -> [f64; N] {
        lanes(values, self.0 + reading)
    }
}

impl Place for &Nodes {
    #[inline(always)]
    fn lanes<const N: usize>(self, values: &[f64], reading: usize) -> [f64; N] {
        match self {
            Nodes::Same(node) => Still(*node).lanes(values, reading),
            Nodes::From(first) => Onward(*first).lanes(values, reading),
            Nodes::Each(nodes) => {
                let mut lanes = [0.0; N];
                for i in 0..N {
                    lanes[i] = values[nodes[reading + i]];
                }
                lanes
            }
        }
    }
}

#[inline(always)]
fn lanes<const N: usize>(values: &[f64], first: usize) -> [f64; N] {
    let mut lanes = [0.0; N];
    lanes.copy_from_slice(&values[first..first + N]);
    lanes
}

/// Calls `$one` for the readings 0 to `$length` of a run, many at a time.
///
/// The last ones lie over those before: what is written twice is the same.
macro_rules! along {
    ($length:expr, $one:ident($($argument:expr),*)) => {
        if $length < LANES {
            for reading in 0..$length {
                $one::<1, _, _>($($argument,)* reading);
            }
        } else {
            let mut first = 0;
            while first < $length {
                $one::<LANES, _, _>($($argument,)* first.min($length - LANES));
                first += LANES;
            }
        }
    };
}

/// `w_i share x_i` of all readings, with the share and the nodes of Model A; 0 where the share is 0.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn lamellae(out: &mut [f64], weights: &[f64], runs: &[Run], values: &[f64]) {
    for run in runs {
        let (out, weights) = (&mut out[run.rows.clone()], &weights[run.rows.clone()]);
        if run.share_a <= 0.0 {
            out.fill(0.0);
            continue;
        }
        let length = out.len();
        match &run.lamella {
            Nodes::From(first) => {
                along!(length, product(out, weights, run.share_a, [values, values], Onward(*first), One));
            }
            nodes => along!(length, product(out, weights, run.share_a, [values, values], nodes, One)),
        }
    }
}

/// `w_i share x_i y_i` of all readings, with the share and the nodes of Model B; 0 where the share is 0.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn multilayers(out: &mut [f64], weights: &[f64], runs: &[Run], terms: [&[f64]; 2]) {
    for run in runs {
        let (out, weights) = (&mut out[run.rows.clone()], &weights[run.rows.clone()]);
        let (share, length) = (run.share_b, out.len());
        if share <= 0.0 {
            out.fill(0.0);
            continue;
        }
        match (&run.stack, &run.lobe) {
            (Nodes::From(x), Nodes::From(y)) => {
                along!(length, product(out, weights, share, terms, Onward(*x), Onward(*y)));
            }
            (Nodes::Same(x), Nodes::From(y)) => {
                along!(length, product(out, weights, share, terms, Still(*x), Onward(*y)));
            }
            (Nodes::From(x), Nodes::Same(y)) => {
                along!(length, product(out, weights, share, terms, Onward(*x), Still(*y)));
            }
            (x, y) => along!(length, product(out, weights, share, terms, x, y)),
        }
    }
}

#[inline(always)]
fn product<const N: usize, X: Place, Y: Place>(
    out: &mut [f64],
    weights: &[f64],
    share: f64,
    terms: [&[f64]; 2],
    x: X,
    y: Y,
    reading: usize,
) {
    let weights = lanes::<N>(weights, reading);
    let (x, y) = (x.lanes::<N>(terms[0], reading), y.lanes::<N>(terms[1], reading));
    let mut found = [0.0; N];
    for i in 0..N {
        found[i] = weights[i] * share * x[i] * y[i];
    }
    out[reading..reading + N].copy_from_slice(&found);
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
    /// Whether the lobe depends on the width of the lamellae, as that of a product does; else its fourth list means nothing.
    pub(super) lobe_sees_width: bool,
}

/// Weighted derivatives by `d_air`, `d_cuticle`, the tilt, the half-width of the lobe and the width of the lamellae, of the readings of
/// `runs`, which follow each other; both `columns` and `weights` begin at the first.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn slopes(mut columns: [&mut [f64]; 5], weights: &[f64], runs: &[Run], of: &Slopes<'_>) {
    let mut first = 0;
    for run in runs {
        let length = run.rows.len();
        let own = &weights[first..first + length];
        match (&run.stack, &run.lobe) {
            (Nodes::Same(stack), Nodes::From(lobe)) => {
                along!(length, slope(&mut columns, first, own, run, of, Still(*stack), Onward(*lobe)));
            }
            (Nodes::From(stack), Nodes::Same(lobe)) => {
                along!(length, slope(&mut columns, first, own, run, of, Onward(*stack), Still(*lobe)));
            }
            (stack, lobe) => along!(length, slope(&mut columns, first, own, run, of, stack, lobe)),
        }
        first += length;
    }
}

#[allow(clippy::too_many_arguments, reason = "one place calls it, by a macro")]
#[inline(always)]
fn slope<const N: usize, R: Place, L: Place>(
    columns: &mut [&mut [f64]; 5],
    first: usize,
    weights: &[f64],
    run: &Run,
    of: &Slopes<'_>,
    stack: R,
    lobe: L,
    reading: usize,
) {
    let weights = lanes::<N>(weights, reading);
    let mut found = [[0.0; N]; 5];
    if run.share_a > 0.0 {
        let factor = of.factors.0 * run.share_a;
        let node = |which: usize| (&run.lamella).lanes::<N>(of.lamella[which], reading);
        let (by_period, by_width) = (node(0), node(1));
        for i in 0..N {
            let weight = weights[i] * factor;
            let by_period = weight * by_period[i];
            found[0][i] = by_period;
            found[1][i] = by_period;
            found[4][i] = weight * by_width[i];
        }
    }
    if run.share_b > 0.0 {
        let factor = of.factors.1 * run.share_b;
        let [r, r_air, r_cuticle, r_tilt] = of.stack;
        let [r, r_air] = [stack.lanes::<N>(r, reading), stack.lanes::<N>(r_air, reading)];
        let [r_cuticle, r_tilt] = [stack.lanes::<N>(r_cuticle, reading), stack.lanes::<N>(r_tilt, reading)];
        let [l, l_tilt] = [lobe.lanes::<N>(of.lobe[0], reading), lobe.lanes::<N>(of.lobe[1], reading)];
        let l_half_width = lobe.lanes::<N>(of.lobe[2], reading);
        for i in 0..N {
            let weight = weights[i] * factor;
            let (weighted, reflected) = (weight * l[i], weight * r[i]);
            found[0][i] += weighted * r_air[i];
            found[1][i] += weighted * r_cuticle[i];
            found[2][i] = weighted * r_tilt[i] + reflected * l_tilt[i];
            found[3][i] = reflected * l_half_width[i];
        }
        if of.lobe_sees_width {
            let l_width = lobe.lanes::<N>(of.lobe[3], reading);
            for i in 0..N {
                found[4][i] += weights[i] * factor * r[i] * l_width[i];
            }
        }
    }
    let at = first + reading;
    for j in 0..5 {
        columns[j][at..at + N].copy_from_slice(&found[j]);
    }
}

/// Weighted residuals, `on_a A + on_b B + background w - w y`, of readings with the same factors.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(crate) fn residuals(out: &mut [f64], factors: (f64, f64, f64), parts: [&[f64]; 2], weighted: [&[f64]; 2]) {
    let (on_a, on_b, background) = factors;
    let length = out.len();
    let [a, b] = parts.map(|values| &values[..length]);
    let [weights, intensities] = weighted.map(|values| &values[..length]);
    for i in 0..length {
        out[i] = on_a * a[i] + on_b * b[i] + background * weights[i] - intensities[i];
    }
}
