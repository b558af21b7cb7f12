//! As many nodes as a tolerance needs, where they are needed.

use super::error::TableError;
use super::lookup::Table;
use super::nodes::{Across, Nodes, Turn};
use super::source::Source;
use crate::colorimetry::{ColourError, Lab, Xyz};
use crate::geometry::Geometry;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Widest cell to begin with, rad (5°): narrow enough that the middle of a cell shows a lobe within it.
const WIDEST: f64 = 0.0873;
/// Planes of a model that is no sum of two, to begin with: so many intervals.
const PLANES: usize = 8;
/// Part of the tolerance that what is measured may have, as the worst direction is hardly met.
const MARGIN: f64 = 0.8;
/// Shares of the plane along the ridges at which the middles of cells are judged.
const SHARES: [f64; 7] = [0.0, 0.02, 0.1, 0.35, 0.7, 0.95, 1.0];
/// Random directions that a table is judged at.
const RANDOM: usize = 40_000;
/// Incidences of these where a model takes averages, which cost a hundred plane waves and more for each.
const INCIDENCES: usize = 400;
/// Middles of cells at most that it is judged at besides.
const MIDDLES: usize = 40_000;
/// What the tolerance of one axis shrinks by where the axes together miss theirs. Smaller takes more nodes, larger more rounds.
const SHRINK: f64 = 0.8;
/// Rounds of refinement at most.
const ROUNDS: usize = 40;

/// The directions that a table is for, rad, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Incidence.
    pub theta: [f64; 2],
    /// View.
    pub phi: [f64; 2],
    /// Plane, 0 to 90°.
    pub omega: [f64; 2],
}

impl Default for Range {
    /// Incidence to 85°, views to 85° on either side, all planes.
    fn default() -> Self {
        let grazing = 85.0_f64.to_radians();
        Self { theta: [0.0, grazing], phi: [-grazing, grazing], omega: [0.0, FRAC_PI_2] }
    }
}

impl Range {
    fn contains(&self, theta: f64, phi: f64) -> bool {
        let inside = |[low, high]: [f64; 2], value: f64| (low - 1e-12..=high + 1e-12).contains(&value);
        inside(self.theta, theta) && inside(self.phi, phi)
    }
}

/// What a table must hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// The directions.
    pub range: Range,
    /// Its second axis.
    pub across: Across,
    /// Largest CIEDE2000 difference.
    pub tolerance: f64,
    /// Nodes at most.
    pub most: usize,
    /// Seed of the directions that it is judged at.
    pub seed: u64,
}

/// What a table is off by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// Largest CIEDE2000 difference.
    pub worst: f64,
    /// The direction where it was.
    pub at: Geometry,
    /// Mean of the random directions.
    pub mean: f64,
    /// Directions that were compared.
    pub compared: usize,
}

/// The nodes of the table of `source` whose colours differ from those of `reference` by at most the tolerance, and by how much
/// they do: at the middles of its cells and at seeded random directions, each evaluated directly; of a model that takes averages
/// these have 400 incidences.
///
/// Both sources give X/Xn, Y/Yn, Z/Zn ([`relative_weights`](crate::colorimetry::Integration::relative_weights)). `reference` may have more
/// wavelengths: then their difference counts too. A table of linear RGB or of spectra with the same nodes has the same colours, as all are linear in
/// the spectrum.
///
/// # Errors
/// [`TableError`] for a range that is none, if the tolerance is no number above 0, or would need more nodes than allowed.
///
/// ```
/// use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
/// use morpho_fit::geometry::Polarization;
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::spectrum::Wavelengths;
/// use morpho_fit::table::{Across, Needs, Quantity, Range, Source, choose};
///
/// let (model, grid) = (BlendModel::default(), Wavelengths::visible(20.0)?);
/// let weights = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?.relative_weights();
/// let wavelengths: Vec<f64> = grid.iter().collect();
/// let quantity = Quantity::Colour(weights);
/// let source = Source::new(&model, &Structure::blue(), Polarization::Unpolarized, &wavelengths, quantity)?;
/// let range = Range { theta: [0.0, 0.5], phi: [-0.5, 0.5], ..Range::default() };
/// let needs = Needs { range, across: Across::Mirror, tolerance: 2.0, most: 100_000, seed: 1 };
/// let (table, judged) = choose(&source, &source, &needs)?;
/// assert!(judged.worst <= 2.0 && table.nodes().omega().len() == 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn choose(source: &Source<'_>, reference: &Source<'_>, needs: &Needs) -> Result<(Table, Judged), TableError> {
    let Needs { tolerance, most, .. } = *needs;
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return Err(TableError::Tolerance { found: tolerance });
    }
    let goal = MARGIN * tolerance;
    let mut nodes = start(source, needs)?;
    let axes: &[usize] = if nodes.turn() == Turn::Share { &[0, 1] } else { &[0, 1, 2] };
    let mut share = 1.0;
    let mut last = None;
    for _ in 0..ROUNDS {
        if nodes.count() > most {
            break;
        }
        // First each axis by itself, which costs little, then everything: differences along the axes add up, but seldom.
        let mut split: [Vec<bool>; 3] = Default::default();
        for &axis in axes {
            split[axis] = too_wide(source, &nodes, needs, axis, share * goal)?;
        }
        if split.iter().flatten().all(|split| !split) {
            let table = Table::new(source, nodes.clone())?;
            let (judged, misses) = compared(&table, reference, needs, goal)?;
            if judged.worst <= goal {
                return Ok((table, judged));
            }
            last = Some((nodes.count(), judged.worst));
            split = around(&nodes, &misses);
            share *= SHRINK;
        }
        nodes = halved(&nodes, &split)?;
    }
    Err(match last {
        Some((nodes, worst)) => TableError::TooLarge { nodes, worst, tolerance, most },
        None => TableError::TooMany { nodes: nodes.count(), tolerance, most },
    })
}

/// What `table` is off by from `reference` within a range, both in X/Xn, Y/Yn, Z/Zn.
///
/// # Errors
/// [`TableError`] for a range that reaches beyond the table.
pub fn judge(table: &Table, reference: &Source<'_>, needs: &Needs) -> Result<Judged, TableError> {
    Ok(compared(table, reference, needs, f64::INFINITY)?.0)
}

/// The coarsest nodes that are tried.
fn start(source: &Source<'_>, needs: &Needs) -> Result<Nodes, TableError> {
    let Range { theta, phi, omega } = needs.range;
    let turn = source.turn();
    if source.edges().iter().any(|edge| theta[0] < *edge && *edge < theta[1]) {
        return Err(TableError::Axis {
            axis: "theta",
            problem: "crosses 90° from the tilted layers, where they fall into their own shadow and the colour jumps: narrow it",
        });
    }
    // θ + φ may be within its bounds where φ is not.
    Nodes::new(vec![theta[0]], vec![phi[0]], vec![omega[0]], Across::View, turn)?;
    Nodes::new(vec![theta[1]], vec![phi[1]], vec![omega[1]], Across::View, turn)?;
    let (across, bends) = match needs.across {
        Across::View => (phi, Vec::new()),
        Across::Mirror => ([theta[0] + phi[0], theta[1] + phi[1]], source.bends()),
    };
    let planes = match turn {
        Turn::Share => divided(omega, &[], f64::INFINITY, "omega")?,
        #[allow(clippy::cast_precision_loss, reason = "a few planes")]
        Turn::Angle => divided(omega, &[], FRAC_PI_2 / PLANES as f64, "omega")?,
    };
    Nodes::new(
        divided(theta, &[], WIDEST, "theta")?,
        divided(across, &bends, WIDEST, needs.across.name())?,
        planes,
        needs.across,
        turn,
    )
}

/// A range divided at `bends`, and evenly between them.
fn divided([low, high]: [f64; 2], bends: &[f64], widest: f64, axis: &'static str) -> Result<Vec<f64>, TableError> {
    if !(low.is_finite() && high.is_finite() && low <= high) {
        return Err(TableError::Axis { axis, problem: "ends before it begins, or has an end that is no number" });
    }
    // Bends next to an end would make cells of no width.
    let apart = |bend: &&f64| **bend > low + 1e-6 && **bend < high - 1e-6;
    let mut ends: Vec<f64> = bends.iter().filter(apart).copied().chain([low, high]).collect();
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let mut nodes = vec![low];
    for pair in ends.windows(2) {
        let count = ((pair[1] - pair[0]) / widest).ceil().max(1.0);
        let mut step = 1.0;
        while step < count {
            nodes.push(pair[0] + step / count * (pair[1] - pair[0]));
            step += 1.0;
        }
        nodes.push(pair[1]);
    }
    Ok(nodes)
}

/// Which intervals of one axis are too wide: where the mean of both ends is not the middle.
fn too_wide(
    source: &Source<'_>,
    nodes: &Nodes,
    needs: &Needs,
    axis: usize,
    allowed: f64,
) -> Result<Vec<bool>, TableError> {
    let turn = nodes.turn();
    let mut values = [nodes.theta().to_vec(), nodes.across().to_vec(), nodes.omega().to_vec()];
    if turn == Turn::Share {
        let [low, high] = needs.range.omega.map(|omega| turn.of(omega));
        let mut looked: Vec<f64> = SHARES.iter().map(|share| turn.omega(low + share * (high - low))).collect();
        looked.dedup_by(|a, b| turn.of(*a) <= turn.of(*b));
        values[2] = looked;
    }
    let ends = &values[axis];
    if ends.len() < 2 {
        return Ok(vec![false; ends.len().saturating_sub(1)]);
    }
    let middles: Vec<f64> = ends.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let filled = |values: [Vec<f64>; 3]| -> Result<(Vec<f64>, [usize; 3]), TableError> {
        let lengths = values.each_ref().map(Vec::len);
        let [theta, across, omega] = values;
        let nodes = Nodes::new(theta, across, omega, nodes.kind(), turn)?;
        let mut out = vec![0.0; 3 * nodes.count()];
        source.fill(&nodes, &mut out)?;
        Ok((out, lengths))
    };
    let (at_nodes, node_lengths) = filled(values.clone())?;
    let mut at = values;
    at[axis] = middles;
    let (at_middles, lengths) = filled(at.clone())?;
    let index = |[i, j, k]: [usize; 3], lengths: [usize; 3]| 3 * ((i * lengths[1] + j) * lengths[2] + k);
    let colour = |values: &[f64], at: usize| [values[at], values[at + 1], values[at + 2]];
    let one = |interval: usize| -> Result<bool, TableError> {
        let mut places = [0..lengths[0], 0..lengths[1], 0..lengths[2]];
        places[axis] = interval..interval + 1;
        let [rows, columns, planes] = places;
        for i in rows {
            for j in columns.clone() {
                if !needs.range.contains(at[0][i], nodes.kind().phi(at[0][i], at[1][j])) {
                    continue;
                }
                for k in planes.clone() {
                    let place = [i, j, k];
                    let mut above = place;
                    above[axis] += 1;
                    let (low, high) =
                        (colour(&at_nodes, index(place, node_lengths)), colour(&at_nodes, index(above, node_lengths)));
                    let mean = std::array::from_fn(|channel| 0.5 * (low[channel] + high[channel]));
                    if difference(mean, colour(&at_middles, index(place, lengths)))? > allowed {
                        return Ok(true);
                    }
                }
            }
        }
        Ok(false)
    };
    (0..lengths[axis]).into_par_iter().map(one).collect()
}

/// CIEDE2000 of two colours under a white of ones.
fn difference(one: [f64; 3], other: [f64; 3]) -> Result<f64, ColourError> {
    let white = Xyz { x: 1.0, y: 1.0, z: 1.0 };
    Ok(Lab::new(Xyz::from_array(one), white)?.difference(Lab::new(Xyz::from_array(other), white)?))
}

/// The difference of a table from directly evaluated colours, and the directions that miss the goal.
fn compared(
    table: &Table,
    reference: &Source<'_>,
    needs: &Needs,
    goal: f64,
) -> Result<(Judged, Vec<Geometry>), TableError> {
    let mut seen = random(needs, if reference.is_dear() { INCIDENCES } else { RANDOM });
    let of_random = seen.len();
    seen.extend(middles(table.nodes(), needs));
    let one = |seen: &Geometry| -> Result<f64, TableError> {
        let outside = TableError::Axis { axis: "theta, phi or omega", problem: "of the table ends within the range" };
        let found = table.colour(seen.theta, seen.phi, seen.omega).ok_or(outside)?;
        let mut known = [0.0; 3];
        reference.evaluate(seen, &mut known)?;
        Ok(difference(found, known)?)
    };
    let differences = seen.par_iter().map(one).collect::<Result<Vec<f64>, _>>()?;
    let pairs = differences.iter().zip(&seen);
    let worst = pairs.clone().max_by(|one, other| one.0.total_cmp(other.0));
    let (worst, at) = worst.map_or((0.0, Geometry::default()), |(worst, at)| (*worst, *at));
    let misses = pairs.filter(|(difference, _)| **difference > goal).map(|(_, seen)| *seen).collect();
    #[allow(clippy::cast_precision_loss, reason = "a count of directions")]
    let mean = differences.iter().take(of_random).sum::<f64>() / of_random.max(1) as f64;
    Ok((Judged { worst, at, mean, compared: seen.len() }, misses))
}

/// Seeded directions, even in all three angles, of so many incidences.
fn random(needs: &Needs, incidences: usize) -> Vec<Geometry> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(needs.seed);
    let Range { theta, phi, omega } = needs.range;
    let mut one = |[low, high]: [f64; 2]| low + random.random::<f64>() * (high - low);
    let views = RANDOM / incidences.max(1);
    let mut seen = Vec::with_capacity(RANDOM);
    for _ in 0..incidences {
        let theta = one(theta);
        seen.extend((0..views).map(|_| Geometry { theta, phi: one(phi), omega: one(omega) }));
    }
    seen
}

/// Middles of cells, spread over the table where they are many.
fn middles(nodes: &Nodes, needs: &Needs) -> Vec<Geometry> {
    let halves = |values: &[f64]| -> Vec<f64> {
        if values.len() < 2 {
            return values.to_vec();
        }
        values.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    };
    let (thetas, across) = (halves(nodes.theta()), halves(nodes.across()));
    let planes = if nodes.turn() == Turn::Share { needs.range.omega.to_vec() } else { halves(nodes.omega()) };
    let count = thetas.len() * across.len() * planes.len();
    // A step that shares no factor with the rows meets all of them.
    let step = count.div_ceil(MIDDLES) | 1;
    let one = |index: usize| {
        let (rest, plane) = (index / planes.len(), index % planes.len());
        let theta = *thetas.get(rest / across.len())?;
        let phi = nodes.kind().phi(theta, *across.get(rest % across.len())?);
        needs.range.contains(theta, phi).then_some(Geometry { theta, phi, omega: *planes.get(plane)? })
    };
    (0..count).step_by(step).filter_map(one).collect()
}

/// The intervals that hold directions.
fn around(nodes: &Nodes, misses: &[Geometry]) -> [Vec<bool>; 3] {
    let axes = [nodes.theta(), nodes.across(), nodes.omega()];
    let mut split = axes.map(|axis| vec![false; axis.len().saturating_sub(1)]);
    if nodes.turn() == Turn::Share {
        split[2].clear();
    }
    for seen in misses {
        let at = [seen.theta, nodes.kind().of(seen.theta, seen.phi), seen.omega];
        for ((axis, split), at) in axes.iter().zip(&mut split).zip(at) {
            let interval = axis.partition_point(|node| *node <= at).saturating_sub(1).min(split.len().max(1) - 1);
            if let Some(split) = split.get_mut(interval) {
                *split = true;
            }
        }
    }
    split
}

fn halved(nodes: &Nodes, split: &[Vec<bool>; 3]) -> Result<Nodes, TableError> {
    let one = |values: &[f64], split: &[bool]| {
        let mut halved = Vec::with_capacity(2 * values.len());
        for (index, &value) in values.iter().enumerate() {
            halved.push(value);
            if let (Some(true), Some(next)) = (split.get(index), values.get(index + 1)) {
                halved.push(0.5 * (value + next));
            }
        }
        halved
    };
    Nodes::new(
        one(nodes.theta(), &split[0]),
        one(nodes.across(), &split[1]),
        one(nodes.omega(), &split[2]),
        nodes.kind(),
        nodes.turn(),
    )
}
