//! The readings of a plan in runs along which a node stands still or goes on by one, for arithmetic in vector registers: values
//! (`kernels`), derivatives (`slopes`) and the sums of their products (`sums`).

mod kernels;
mod slopes;
mod sums;

use crate::inversion::plan::{PlannedReading, TermsView};
pub(crate) use kernels::residuals;
use kernels::{lamellae, multilayers};
pub(crate) use slopes::Chunk;
use slopes::{Slopes, slopes};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
pub(crate) use sums::{along, sums};

/// Runs shorter than this are joined, and their nodes listed.
const SHORT: usize = 8;
/// Readings of a block at most: few enough for their derivatives, 120 bytes each, to stay near and to add little to the memory of a
/// fit (W5 of `examples/workload.rs`: 4 % faster than with 512).
const BLOCK: usize = 320;

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

/// All readings in runs, with their data.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    layout: Arc<Layout>,
    /// `1 / sigma`, or 1 where the data have none.
    weights: Vec<f64>,
    /// Weight times intensity.
    weighted: Vec<f64>,
}

/// What does not depend on the data.
#[derive(Debug, Default)]
struct Layout {
    runs: Vec<Run>,
    blocks: Vec<Block>,
    /// Neighbouring readings of one curve.
    spans: Vec<(usize, Range<usize>)>,
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
#[derive(Debug, Clone, Default)]
pub(crate) struct WeightedParts {
    pub(crate) lamella: Vec<f64>,
    pub(crate) multilayer: Vec<f64>,
}

/// Derivatives of the terms at a plan's nodes, 0 where a parameter does not move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TermSlopes<'a> {
    /// Model A by the period and by the width of the lamellae.
    pub(crate) lamella: [&'a [f64]; 2],
    /// By `d_air`, `d_cuticle` and the tilt.
    pub(crate) stack: [&'a [f64]; 3],
    /// By the tilt and the half-width.
    pub(crate) lobe: [&'a [f64]; 2],
    /// The lobe of a product by the width of the lamellae.
    pub(crate) lobe_by_width: Option<&'a [f64]>,
}

impl Layout {
    fn new(readings: &[PlannedReading], like: &[usize]) -> Self {
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
        Self { spans: spans.collect(), runs, blocks }
    }
}

impl Rows {
    /// Of readings in order, not yet arranged.
    ///
    /// - `data`: weight and intensity of each.
    pub(crate) fn of_data(data: impl ExactSizeIterator<Item = (f64, f64)>) -> Self {
        let (weights, weighted) = data.map(|(weight, intensity)| (weight, weight * intensity)).unzip();
        Self { layout: Arc::default(), weights, weighted }
    }

    /// - `like`: for each curve one whose nuisances are the same; their readings make runs together.
    pub(crate) fn arrange(&mut self, readings: &[PlannedReading], like: &[usize]) {
        self.layout = Arc::new(Layout::new(readings, like));
    }

    /// The same arrangement of other data.
    pub(crate) fn with_data(&self, data: impl ExactSizeIterator<Item = (f64, f64)>) -> Self {
        Self { layout: Arc::clone(&self.layout), ..Self::of_data(data) }
    }

    /// What multiplies each residual.
    pub(crate) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Neighbouring readings of one curve, and which it is.
    pub(crate) fn spans(&self) -> &[(usize, Range<usize>)] {
        &self.layout.spans
    }

    /// All readings, some at a time.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.layout.blocks
    }

    /// With the square roots of further weights; empty for none.
    pub(crate) fn weighted(&self, robust: &[f64]) -> Weighted<'_> {
        if robust.is_empty() {
            return Weighted { weights: Cow::Borrowed(&self.weights), intensities: Cow::Borrowed(&self.weighted) };
        }
        let times = |values: &[f64]| values.iter().zip(robust).map(|(value, root)| value * root).collect();
        Weighted { weights: Cow::Owned(times(&self.weights)), intensities: Cow::Owned(times(&self.weighted)) }
    }

    /// Both models at every reading.
    pub(crate) fn parts(&self, terms: TermsView<'_>, weights: &[f64]) -> WeightedParts {
        let mut parts = WeightedParts::default();
        self.renew(terms, weights, &mut parts);
        parts
    }

    /// Puts both models at every reading into `parts`, whatever was there.
    pub(crate) fn renew(&self, terms: TermsView<'_>, weights: &[f64], parts: &mut WeightedParts) {
        parts.lamella.resize(weights.len(), 0.0);
        parts.multilayer.resize(weights.len(), 0.0);
        lamellae(&mut parts.lamella, weights, &self.layout.runs, terms.lamella);
        multilayers(&mut parts.multilayer, weights, &self.layout.runs, [terms.stack, terms.lobe]);
    }

    /// Puts into `out`, whatever was there, the weighted derivatives of the readings of `block`, where its curve has these
    /// factors on the two models.
    pub(crate) fn slopes(
        &self,
        block: &Block,
        terms: TermsView<'_>,
        by: &TermSlopes<'_>,
        weights: &[f64],
        factors: (f64, f64),
        out: &mut Vec<Chunk>,
    ) {
        let of = Slopes {
            factors,
            lamella: by.lamella,
            stack: [terms.stack, by.stack[0], by.stack[1], by.stack[2]],
            lobe: [terms.lobe, by.lobe[0], by.lobe[1], by.lobe_by_width.unwrap_or(terms.lobe)],
            lobe_sees_width: by.lobe_by_width.is_some(),
        };
        slopes(out, weights, &self.layout.runs[block.runs.clone()], &of);
    }
}

/// How many of the first readings make one run: of one curve and plane, each node standing still or going on by one.
fn steady(readings: &[PlannedReading], curve_of: &impl Fn(&PlannedReading) -> usize) -> usize {
    let [first, second, ..] = readings else { return readings.len() };
    let of = |reading: &PlannedReading| [reading.lamella, reading.stack, reading.lobe];
    let (start, next) = (of(first), of(second));
    let mut steps = [0; 3];
    for (step, (start, next)) in steps.iter_mut().zip(start.iter().zip(next)) {
        *step = usize::from(next != *start);
    }
    for (place, reading) in readings.iter().enumerate().skip(1) {
        let mut goes_on = is_like(first, reading, curve_of);
        for ((node, start), step) in of(reading).into_iter().zip(start).zip(steps) {
            goes_on &= node == start + step * place;
        }
        if !goes_on {
            return place;
        }
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

#[cfg(test)]
mod tests;
