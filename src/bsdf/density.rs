//! Where a surface has light: the density by which the nodes of a table are laid.
//!
//! Along a row of half vectors of one azimuth the density is even where there is light and 0 elsewhere, and its integral is the extent of the light
//! in `sin(theta)`. The nodes then span the lobe from edge to edge, and azimuths are the denser the farther it reaches: the same step across
//! it is the smaller an angle the farther it is from the normal.

use super::directions::{direction, mirrored, unsquare};
use super::measured::Plane;
use super::tabulate::{share, single};
use super::{BsdfError, Surface};
use rayon::prelude::*;

/// Rows and columns of the density of a slice. It has one channel: many of them are cheap.
pub(super) const NODES: [usize; 2] = [25, 64];
/// Halvings of a cell in which the light ends.
const HALVINGS: usize = 12;
/// Least integral of a row, as a share of the largest: dark rows keep their place.
const LEAST: f64 = 0.01;

/// The densities of the half vectors of each slice, of the light from `incoming(slice)`.
///
/// # Errors
/// As [`Surface::lit`].
pub(super) fn densities(
    surface: &dyn Surface,
    slices: usize,
    incoming: impl Fn(usize) -> [f64; 3] + Sync,
) -> Result<Plane, BsdfError> {
    let mut values = vec![0.0; slices * NODES[0] * NODES[1]];
    let all = values.par_chunks_mut(NODES[0] * NODES[1]).enumerate();
    all.try_for_each(|(slice, values)| fill(surface, incoming(slice), values))?;
    Ok(Plane { size: NODES, values })
}

fn fill(surface: &dyn Surface, incoming: [f64; 3], values: &mut [f32]) -> Result<(), BsdfError> {
    let [rows, columns] = NODES;
    let mut reached = Vec::with_capacity(rows);
    for (row, values) in values.chunks_exact_mut(columns).enumerate() {
        reached.push(fill_row(surface, incoming, share(row, rows), values)?);
    }
    let farthest = reached.iter().copied().fold(0.0, f64::max);
    for (values, reached) in values.chunks_exact_mut(columns).zip(reached) {
        // A row without light, or whose light is narrower than its cells, keeps nodes everywhere.
        if values.iter().all(|value| *value <= 0.0) {
            values.fill(1.0);
        }
        let pairs = values.iter().zip(values.iter().skip(1));
        let integral: f64 = pairs.map(|(left, right)| f64::from(left + right)).sum();
        let share = if farthest > 0.0 { (reached / farthest).max(LEAST) } else { 1.0 };
        values.iter_mut().for_each(|value| *value = single(f64::from(*value) * share / integral));
    }
    Ok(())
}

/// The share of the cell about each node of a row that has light, and the extent of the light in `sin(theta)`.
fn fill_row(surface: &dyn Surface, incoming: [f64; 3], y: f64, values: &mut [f32]) -> Result<f64, BsdfError> {
    let lit = |x: f64| {
        let [theta, phi] = unsquare([x, y]);
        let outgoing = mirrored(incoming, direction(theta, phi));
        outgoing.map_or(Ok(false), |outgoing| surface.lit(incoming, outgoing))
    };
    let sine = |x: f64| unsquare([x, y])[0].sin();
    let last = values.len() - 1;
    let (mut low, mut of_low, mut reached) = (0.0, lit(0.0)?, 0.0);
    for node in 0..last {
        let high = share(node + 1, last + 1);
        let of_high = lit(high)?;
        // From where to where in the cell between both nodes.
        let [from, to] = if of_low == of_high {
            [0.0, f64::from(u8::from(of_low))]
        } else {
            let mut ends = [0.0, 1.0];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (ends[0] + ends[1]);
                ends[usize::from(lit(low + (high - low) * middle)? != of_low)] = middle;
            }
            if of_low { [0.0, ends[0]] } else { [ends[1], 1.0] }
        };
        reached += sine(low + (high - low) * to) - sine(low + (high - low) * from);
        let halves = [to.min(0.5) - from.min(0.5), to.max(0.5) - from.max(0.5)];
        for (value, half) in values.iter_mut().skip(node).zip(halves) {
            *value += single(half);
        }
        (low, of_low) = (high, of_high);
    }
    // The cells at both ends are half as wide.
    values.iter_mut().step_by(last).for_each(|value| *value *= 2.0);
    Ok(reached)
}
