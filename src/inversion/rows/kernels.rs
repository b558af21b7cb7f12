//! Vector code over the readings of runs.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use super::{Nodes, Run};
use multiversion::multiversion;

/// Readings that go together.
pub(super) const LANES: usize = 8;

/// Where the readings of a run find a quantity.
pub(super) trait Place: Copy {
    type Found<'v>: Found;

    /// What `length` readings find there.
    fn of(self, values: &[f64], length: usize) -> Self::Found<'_>;
}

/// A quantity of the readings of a run.
pub(super) trait Found: Copy {
    /// The values of `N` readings from `reading` on.
    fn lanes<const N: usize>(self, reading: usize) -> [f64; N];
}

/// All at one node.
#[derive(Clone, Copy)]
pub(super) struct Still(pub(super) usize);

/// At one node after the other.
#[derive(Clone, Copy)]
pub(super) struct Onward(pub(super) usize);

/// Where each node says.
#[derive(Clone, Copy)]
pub(super) struct Listed<'n>(pub(super) &'n Nodes);

impl Place for Still {
    type Found<'v> = Constant;

    #[inline(always)]
    fn of(self, values: &[f64], _: usize) -> Constant {
        Constant(values[self.0])
    }
}

impl Place for Onward {
    type Found<'v> = Slice<'v>;

    #[inline(always)]
    fn of(self, values: &[f64], length: usize) -> Slice<'_> {
        Slice(&values[self.0..self.0 + length])
    }
}

impl<'n> Place for Listed<'n> {
    type Found<'v> = Gathered<'n, 'v>;

    #[inline(always)]
    fn of<'v>(self, values: &'v [f64], _: usize) -> Gathered<'n, 'v> {
        Gathered { nodes: self.0, values }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Constant(f64);

#[derive(Clone, Copy)]
pub(super) struct Slice<'v>(&'v [f64]);

#[derive(Clone, Copy)]
pub(super) struct Gathered<'n, 'v> {
    nodes: &'n Nodes,
    values: &'v [f64],
}

impl Found for Constant {
    #[inline(always)]
    fn lanes<const N: usize>(self, _: usize) -> [f64; N] {
        [self.0; N]
    }
}

impl Found for Slice<'_> {
    #[inline(always)]
    fn lanes<const N: usize>(self, reading: usize) -> [f64; N] {
        lanes(self.0, reading)
    }
}

impl Found for Gathered<'_, '_> {
    #[inline(always)]
    fn lanes<const N: usize>(self, reading: usize) -> [f64; N] {
        match self.nodes {
            Nodes::Same(node) => [self.values[*node]; N],
            Nodes::From(first) => lanes(self.values, first + reading),
            Nodes::Each(nodes) => {
                let mut lanes = [0.0; N];
                for i in 0..N {
                    lanes[i] = self.values[nodes[reading + i]];
                }
                lanes
            }
        }
    }
}

#[inline(always)]
pub(super) fn lanes<const N: usize>(values: &[f64], first: usize) -> [f64; N] {
    let mut lanes = [0.0; N];
    lanes.copy_from_slice(&values[first..first + N]);
    lanes
}

/// `w_i share x_i` of all readings, with the share and the nodes of Model A; 0 where the share is 0.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn lamellae(out: &mut [f64], weights: &[f64], runs: &[Run], values: &[f64]) {
    for run in runs {
        let (out, weights) = (&mut out[run.rows.clone()], &weights[run.rows.clone()]);
        let (share, one) = (run.share_a, Constant(1.0));
        if share <= 0.0 {
            out.fill(0.0);
            continue;
        }
        match &run.lamella {
            Nodes::From(first) => products(out, weights, share, Onward(*first).of(values, weights.len()), one),
            nodes => products(out, weights, share, Listed(nodes).of(values, weights.len()), one),
        }
    }
}

/// `w_i share x_i y_i` of all readings, with the share and the nodes of Model B; 0 where the share is 0.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn multilayers(out: &mut [f64], weights: &[f64], runs: &[Run], [r, l]: [&[f64]; 2]) {
    for run in runs {
        let (out, weights) = (&mut out[run.rows.clone()], &weights[run.rows.clone()]);
        let (share, length) = (run.share_b, weights.len());
        if share <= 0.0 {
            out.fill(0.0);
            continue;
        }
        match (&run.stack, &run.lobe) {
            (Nodes::From(x), Nodes::From(y)) => {
                products(out, weights, share, Onward(*x).of(r, length), Onward(*y).of(l, length));
            }
            (Nodes::Same(x), Nodes::From(y)) => {
                products(out, weights, share, Still(*x).of(r, length), Onward(*y).of(l, length));
            }
            (Nodes::From(x), Nodes::Same(y)) => {
                products(out, weights, share, Onward(*x).of(r, length), Still(*y).of(l, length));
            }
            (x, y) => products(out, weights, share, Listed(x).of(r, length), Listed(y).of(l, length)),
        }
    }
}

/// Many readings at a time. The last ones lie over those before: what is written twice is the same.
#[inline(always)]
fn products(out: &mut [f64], weights: &[f64], share: f64, x: impl Found, y: impl Found) {
    let length = out.len();
    if length < LANES {
        for reading in 0..length {
            out[reading] = weights[reading] * share * x.lanes::<1>(reading)[0] * y.lanes::<1>(reading)[0];
        }
        return;
    }
    let mut first = 0;
    while first < length {
        let reading = first.min(length - LANES);
        let weights = lanes::<LANES>(weights, reading);
        let (x, y) = (x.lanes::<LANES>(reading), y.lanes::<LANES>(reading));
        let mut found = [0.0; LANES];
        for i in 0..LANES {
            found[i] = weights[i] * share * x[i] * y[i];
        }
        out[reading..reading + LANES].copy_from_slice(&found);
        first += LANES;
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
