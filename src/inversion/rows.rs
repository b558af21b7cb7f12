//! The readings of a plan in runs along which a node stands still or goes on by one, for arithmetic in vector registers (`kernels`).

mod kernels;

use crate::inversion::plan::{PlannedReading, TermsView};
pub(crate) use kernels::residuals;
use kernels::{add_both, add_lamella, add_scaled, along_both, along_the_lobe, along_the_stack};
use std::borrow::Cow;
use std::ops::Range;

/// Runs shorter than this are joined, and their nodes listed.
const SHORT: usize = 8;
/// Readings of a block at most: few enough for their derivatives to stay in the nearest memory.
const BLOCK: usize = 512;

/// The nodes that the readings of a run look at.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Nodes {
    /// One.
    Same(usize),
    /// One after the other.
    From(usize),
    /// These.
    Each(Vec<usize>),
}

impl Nodes {
    /// The values of each of several quantities, where all readings have the same.
    fn one<const N: usize>(&self, of: [&[f64]; N]) -> Option<[f64; N]> {
        match self {
            Self::Same(node) => Some(of.map(|values| values[*node])),
            Self::From(_) | Self::Each(_) => None,
        }
    }

    /// The values of each of several quantities at the nodes of `length` readings.
    fn all<'a, const N: usize>(
        &self,
        of: [&'a [f64]; N],
        length: usize,
        scratch: &'a mut [Vec<f64>; N],
    ) -> [&'a [f64]; N] {
        let mut scratch = scratch.iter_mut();
        of.map(|values| {
            if let Self::From(first) = self {
                return &values[*first..first + length];
            }
            let Some(scratch) = scratch.next() else { return &[] };
            scratch.clear();
            match self {
                Self::Same(node) => scratch.resize(length, values[*node]),
                Self::From(_) => {}
                Self::Each(nodes) => scratch.extend(nodes.iter().map(|&node| values[node])),
            }
            scratch
        })
    }
}

/// Neighbouring readings of one curve in one plane.
#[derive(Debug, Clone)]
struct Run {
    rows: Range<usize>,
    curve: usize,
    share_a: f64,
    share_b: f64,
    lamella: Nodes,
    stack: Nodes,
    lobe: Nodes,
}

/// Some neighbouring readings of one curve.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    runs: Range<usize>,
    pub(crate) rows: Range<usize>,
    pub(crate) curve: usize,
}

/// All readings in runs.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    runs: Vec<Run>,
    blocks: Vec<Block>,
    /// Neighbouring readings of one curve.
    spans: Vec<(usize, Range<usize>)>,
    /// `1 / sigma`, and that times the intensity.
    weights: Vec<f64>,
    intensities: Vec<f64>,
}

/// What divides residuals, and the data over it.
#[derive(Debug, Clone)]
pub(crate) struct Weighted<'a> {
    /// `1 / sigma` times the square root of the robust weight.
    pub(crate) weights: Cow<'a, [f64]>,
    /// That times the intensity.
    pub(crate) intensities: Cow<'a, [f64]>,
}

/// Both models at every reading, with their shares of its plane, times its weight.
#[derive(Debug, Clone)]
pub(crate) struct WeightedParts {
    pub(crate) lamella: Vec<f64>,
    pub(crate) multilayer: Vec<f64>,
}

/// Derivatives of the terms at a plan's nodes, 0 where a parameter does not move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TermSlopes<'a> {
    /// `interference · diffraction` by the period and by the width of the lamellae.
    pub(crate) lamella: [&'a [f64]; 2],
    /// By `d_air`, `d_cuticle` and the tilt.
    pub(crate) stack: [&'a [f64]; 3],
    /// By the tilt and the half-width.
    pub(crate) lobe: [&'a [f64]; 2],
    /// The lobe of a product by the width of the lamellae.
    pub(crate) lobe_by_width: Option<&'a [f64]>,
}

impl Rows {
    /// - `like`: for each curve one whose nuisances are the same; their readings make runs together.
    pub(crate) fn new(readings: &[PlannedReading], like: &[usize]) -> Self {
        let curve_of = |reading: &PlannedReading| like.get(reading.curve).copied().unwrap_or(reading.curve);
        let mut runs: Vec<Run> = Vec::new();
        let mut first = 0;
        while first < readings.len() {
            let length = steady(&readings[first..readings.len().min(first + BLOCK)], &curve_of);
            let own = &readings[first..first + length];
            let last = runs.last_mut().filter(|last| {
                let short = length < SHORT && (last.rows.len() < SHORT || matches!(last.stack, Nodes::Each(_)));
                short && last.rows.len() + length <= BLOCK && is_like(&readings[last.rows.start], &own[0], &curve_of)
            });
            match last {
                Some(last) => {
                    last.rows.end += length;
                    let all = &readings[last.rows.clone()];
                    let list = |of: fn(&PlannedReading) -> usize| Nodes::Each(all.iter().map(of).collect());
                    (last.lamella, last.stack, last.lobe) = (list(|r| r.lamella), list(|r| r.stack), list(|r| r.lobe));
                }
                None => runs.push(Run {
                    rows: first..first + length,
                    curve: curve_of(&own[0]),
                    share_a: own[0].share_a,
                    share_b: own[0].share_b,
                    lamella: nodes(own, |reading| reading.lamella),
                    stack: nodes(own, |reading| reading.stack),
                    lobe: nodes(own, |reading| reading.lobe),
                }),
            }
            first += length;
        }
        let spans = readings.chunk_by(|a, b| curve_of(a) == curve_of(b)).scan(0, |next, span| {
            let first = std::mem::replace(next, *next + span.len());
            Some((curve_of(&span[0]), first..*next))
        });
        let mut blocks: Vec<Block> = Vec::new();
        for (index, Run { rows, curve, .. }) in runs.iter().enumerate() {
            let room = |block: &&mut Block| block.curve == *curve && block.rows.len() + rows.len() <= BLOCK;
            match blocks.last_mut().filter(room) {
                Some(block) => (block.runs.end, block.rows.end) = (index + 1, rows.end),
                None => blocks.push(Block { runs: index..index + 1, rows: rows.clone(), curve: *curve }),
            }
        }
        Self {
            runs,
            blocks,
            spans: spans.collect(),
            weights: readings.iter().map(|reading| reading.weight).collect(),
            intensities: readings.iter().map(|reading| reading.weight * reading.intensity).collect(),
        }
    }

    /// Puts other intensities in the place of those of the data.
    pub(crate) fn set_intensities(&mut self, intensities: &[f64]) {
        for ((own, weight), intensity) in self.intensities.iter_mut().zip(&self.weights).zip(intensities) {
            *own = weight * intensity;
        }
    }

    /// Neighbouring readings of one curve, and which it is.
    pub(crate) fn spans(&self) -> &[(usize, Range<usize>)] {
        &self.spans
    }

    /// All readings, some at a time.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// With the square roots of further weights; empty for none.
    pub(crate) fn weighted(&self, robust: &[f64]) -> Weighted<'_> {
        if robust.is_empty() {
            return Weighted { weights: Cow::Borrowed(&self.weights), intensities: Cow::Borrowed(&self.intensities) };
        }
        let times = |values: &[f64]| values.iter().zip(robust).map(|(value, root)| value * root).collect();
        Weighted { weights: Cow::Owned(times(&self.weights)), intensities: Cow::Owned(times(&self.intensities)) }
    }

    pub(crate) fn parts(&self, terms: TermsView<'_>, weights: &[f64]) -> WeightedParts {
        let mut parts = WeightedParts { lamella: vec![0.0; weights.len()], multilayer: vec![0.0; weights.len()] };
        let mut scratch: [[Vec<f64>; 1]; 2] = Default::default();
        for run in &self.runs {
            let rows = run.rows.clone();
            if run.share_a > 0.0 {
                let factors = [(&run.lamella, terms.interference), (&run.lamella, terms.diffraction)];
                let out = &mut parts.lamella[rows.clone()];
                add_product(out, &weights[rows.clone()], run.share_a, factors, &mut scratch);
            }
            if run.share_b > 0.0 {
                let factors = [(&run.stack, terms.stack), (&run.lobe, terms.lobe)];
                let out = &mut parts.multilayer[rows.clone()];
                add_product(out, &weights[rows], run.share_b, factors, &mut scratch);
            }
        }
        parts
    }

    /// Adds to `columns`, of the readings of `block` alone, the weighted derivatives by `d_air`, `d_cuticle`, the tilt, the half-width of the lobe and the width
    /// of the lamellae, where its curve has the factors `on_a` and `on_b` on the two models.
    pub(crate) fn add_slopes(
        &self,
        block: &Block,
        terms: TermsView<'_>,
        slopes: &TermSlopes<'_>,
        weights: &[f64],
        (on_a, on_b): (f64, f64),
        mut columns: [&mut [f64]; 5],
    ) {
        let (mut of_lamella, mut of_stack): ([Vec<f64>; 2], [Vec<f64>; 4]) = Default::default();
        let (mut of_lobe, mut scratch): ([Vec<f64>; 3], [[Vec<f64>; 1]; 2]) = Default::default();
        let stack = [terms.stack, slopes.stack[0], slopes.stack[1], slopes.stack[2]];
        let lobe = [terms.lobe, slopes.lobe[0], slopes.lobe[1]];
        for run in &self.runs[block.runs.clone()] {
            let length = run.rows.len();
            let weights = &weights[run.rows.clone()];
            let rows = run.rows.start - block.rows.start..run.rows.end - block.rows.start;
            let [air, cuticle, tilt, half_width, width] = columns.each_mut().map(|column| &mut column[rows.clone()]);
            if run.share_a > 0.0 {
                let along = run.lamella.all(slopes.lamella, length, &mut of_lamella);
                add_lamella([&mut *air, &mut *cuticle, &mut *width], weights, on_a * run.share_a, along);
            }
            if run.share_b > 0.0 {
                let factor = on_b * run.share_b;
                let columns = [air, cuticle, tilt, half_width];
                match (run.stack.one(stack), run.lobe.one(lobe)) {
                    (Some(stack), None) => {
                        along_the_lobe(columns, weights, factor, stack, run.lobe.all(lobe, length, &mut of_lobe));
                    }
                    (None, Some(lobe)) => {
                        along_the_stack(columns, weights, factor, run.stack.all(stack, length, &mut of_stack), lobe);
                    }
                    _ => {
                        let stack = run.stack.all(stack, length, &mut of_stack);
                        along_both(columns, weights, factor, stack, run.lobe.all(lobe, length, &mut of_lobe));
                    }
                }
                if let Some(by_width) = slopes.lobe_by_width {
                    let factors = [(&run.stack, terms.stack), (&run.lobe, by_width)];
                    add_product(width, weights, factor, factors, &mut scratch);
                }
            }
        }
    }
}

/// How many of the first readings make one run: of one curve and plane, each node standing still or going on by one.
fn steady(readings: &[PlannedReading], curve_of: &impl Fn(&PlannedReading) -> usize) -> usize {
    let Some(first) = readings.first() else { return 0 };
    let of = |reading: &PlannedReading| [reading.lamella, reading.stack, reading.lobe];
    let start = of(first);
    let mut can_be = [(true, true); 3];
    for (place, reading) in readings.iter().enumerate().skip(1) {
        let next: [(bool, bool); 3] = std::array::from_fn(|i| {
            let (same, from) = can_be[i];
            let node = of(reading)[i];
            (same && node == start[i], from && node == start[i] + place)
        });
        if !is_like(first, reading, curve_of) || next.iter().any(|(same, from)| !(same | from)) {
            return place;
        }
        can_be = next;
    }
    readings.len()
}

/// Whether two readings are of one curve and plane.
fn is_like(one: &PlannedReading, other: &PlannedReading, curve_of: &impl Fn(&PlannedReading) -> usize) -> bool {
    let shares = |reading: &PlannedReading| [reading.share_a, reading.share_b].map(f64::to_bits);
    curve_of(one) == curve_of(other) && shares(one) == shares(other)
}

/// The nodes of a steady run.
fn nodes(run: &[PlannedReading], of: impl Fn(&PlannedReading) -> usize) -> Nodes {
    match run {
        [first, second, ..] if of(second) != of(first) => Nodes::From(of(first)),
        [first, ..] => Nodes::Same(of(first)),
        [] => Nodes::Each(Vec::new()),
    }
}

/// `out_i += w_i factor x_i y_i`
fn add_product(
    out: &mut [f64],
    weights: &[f64],
    factor: f64,
    [(x, of_x), (y, of_y)]: [(&Nodes, &[f64]); 2],
    [scratch_x, scratch_y]: &mut [[Vec<f64>; 1]; 2],
) {
    let length = out.len();
    match (x.one([of_x]), y.one([of_y])) {
        (Some([x]), _) => add_scaled(out, weights, factor * x, y.all([of_y], length, scratch_y)[0]),
        (_, Some([y])) => add_scaled(out, weights, factor * y, x.all([of_x], length, scratch_x)[0]),
        _ => {
            let ([x], [y]) = (x.all([of_x], length, scratch_x), y.all([of_y], length, scratch_y));
            add_both(out, weights, factor, x, y);
        }
    }
}

#[cfg(test)]
mod tests;
