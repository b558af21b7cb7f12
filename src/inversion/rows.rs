//! The readings of a plan in runs along which a node stands still or goes on by one, for arithmetic in vector registers.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::inversion::plan::{PlannedReading, TermsView};
use multiversion::multiversion;
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
    /// `values` at the nodes of `length` readings.
    fn along<'a>(&self, values: &'a [f64], length: usize, scratch: &'a mut Vec<f64>) -> &'a [f64] {
        scratch.clear();
        match self {
            Self::From(first) => return &values[*first..first + length],
            Self::Same(node) => scratch.resize(length, values[*node]),
            Self::Each(nodes) => scratch.extend(nodes.iter().map(|&node| values[node])),
        }
        scratch
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
        let (mut one, mut two) = (Vec::new(), Vec::new());
        for run in &self.runs {
            let (rows, length) = (run.rows.clone(), run.rows.len());
            if run.share_a > 0.0 {
                let interference = run.lamella.along(terms.interference, length, &mut one);
                let diffraction = run.lamella.along(terms.diffraction, length, &mut two);
                let out = &mut parts.lamella[rows.clone()];
                add_product(out, &weights[rows.clone()], run.share_a, interference, diffraction);
            }
            if run.share_b > 0.0 {
                let stack = run.stack.along(terms.stack, length, &mut one);
                let lobe = run.lobe.along(terms.lobe, length, &mut two);
                let out = &mut parts.multilayer[rows.clone()];
                add_product(out, &weights[rows], run.share_b, stack, lobe);
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
        let mut scratch: [Vec<f64>; 7] = Default::default();
        for run in &self.runs[block.runs.clone()] {
            let length = run.rows.len();
            let weights = &weights[run.rows.clone()];
            let rows = run.rows.start - block.rows.start..run.rows.end - block.rows.start;
            let [air, cuticle, tilt, half_width, width] = columns.each_mut().map(|column| &mut column[rows.clone()]);
            if run.share_a > 0.0 {
                let [one, two, ..] = &mut scratch;
                let [by_period, by_width] = slopes.lamella;
                let along = [run.lamella.along(by_period, length, one), run.lamella.along(by_width, length, two)];
                add_lamella([&mut *air, &mut *cuticle, &mut *width], weights, on_a * run.share_a, along);
            }
            if run.share_b > 0.0 {
                let factor = on_b * run.share_b;
                let [r, r_air, r_cuticle, r_tilt, l, l_tilt, l_half_width] = &mut scratch;
                let [by_air, by_cuticle, by_tilt] = slopes.stack;
                let stack = [
                    run.stack.along(terms.stack, length, r),
                    run.stack.along(by_air, length, r_air),
                    run.stack.along(by_cuticle, length, r_cuticle),
                    run.stack.along(by_tilt, length, r_tilt),
                ];
                let lobe = [
                    run.lobe.along(terms.lobe, length, l),
                    run.lobe.along(slopes.lobe[0], length, l_tilt),
                    run.lobe.along(slopes.lobe[1], length, l_half_width),
                ];
                add_multilayer([air, cuticle, tilt, half_width], weights, factor, stack, lobe);
                if let Some(by_width) = slopes.lobe_by_width {
                    let mut by = Vec::new();
                    add_product(width, weights, factor, stack[0], run.lobe.along(by_width, length, &mut by));
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
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn add_product(out: &mut [f64], weights: &[f64], factor: f64, x: &[f64], y: &[f64]) {
    let length = out.len();
    let (weights, x, y) = (&weights[..length], &x[..length], &y[..length]);
    for i in 0..length {
        out[i] += weights[i] * factor * x[i] * y[i];
    }
}

/// Both thicknesses by the period, and the width.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn add_lamella(columns: [&mut [f64]; 3], weights: &[f64], factor: f64, slopes: [&[f64]; 2]) {
    let [air, cuticle, width] = columns;
    let length = weights.len();
    let (air, cuticle, width) = (&mut air[..length], &mut cuticle[..length], &mut width[..length]);
    let [by_period, by_width] = slopes.map(|slope| &slope[..length]);
    for i in 0..length {
        let weight = weights[i] * factor;
        air[i] += weight * by_period[i];
        cuticle[i] += weight * by_period[i];
        width[i] += weight * by_width[i];
    }
}

/// Of `R L`, where each list begins with the value.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn add_multilayer(columns: [&mut [f64]; 4], weights: &[f64], factor: f64, stack: [&[f64]; 4], lobe: [&[f64]; 3]) {
    let length = weights.len();
    let [air, cuticle, tilt, half_width] = columns.map(|column| &mut column[..length]);
    let [r, r_air, r_cuticle, r_tilt] = stack.map(|values| &values[..length]);
    let [l, l_tilt, l_half_width] = lobe.map(|values| &values[..length]);
    for i in 0..length {
        let weight = weights[i] * factor;
        air[i] += weight * r_air[i] * l[i];
        cuticle[i] += weight * r_cuticle[i] * l[i];
        tilt[i] += weight * (r_tilt[i] * l[i] + r[i] * l_tilt[i]);
        half_width[i] += weight * r[i] * l_half_width[i];
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

#[cfg(test)]
mod tests;
