//! Other lobes at the thicknesses of a minimum. Between the readings of a scan whose steps are as wide as the lobe, the edge of the lobe
//! makes valleys of chi² that no slope joins.

use super::{FINE, middles, runs};
use crate::inversion::compiled::Compiled;
use crate::inversion::parameter::Parameter;
use crate::inversion::problem::Problem;
use crate::inversion::space::Space;
use crate::optimise::{LeastSquares, Minimum};
use nalgebra::DVector;

/// Tilts and lobe widths looked at, the widths evenly on a logarithmic scale.
const LOOKED_AT: [usize; 2] = [21, 12];
/// Valleys of each minimum that are walked down.
const WALKED: usize = 8;

/// The minima below the lowest places of a grid of tilts and lobe widths, all else as at `minimum`.
pub(super) fn other_lobes(compiled: &Compiled<'_>, space: &Space, minimum: &Minimum) -> Vec<Minimum> {
    let place = |parameter: Parameter| {
        let is_seen = compiled.plan.sees(parameter);
        space.freedom.free.iter().position(|free| *free == parameter).filter(|_| is_seen)
    };
    let axis = |parameter: Parameter, count: usize, by_ratio: bool| {
        place(parameter)
            .map_or_else(Vec::new, |j| middles(space.bounds.lower()[j], space.bounds.upper()[j], count, by_ratio))
    };
    let [tilts, widths] = [axis(Parameter::Delta, LOOKED_AT[0], false), axis(Parameter::PhiAlpha, LOOKED_AT[1], true)];
    if tilts.is_empty() && widths.is_empty() {
        return Vec::new();
    }
    let problem = Problem::new(compiled, space, &[]);
    let at = |row: usize, column: usize| {
        let mut there = minimum.parameters.clone();
        for (parameter, value) in [(Parameter::Delta, tilts.get(row)), (Parameter::PhiAlpha, widths.get(column))] {
            if let (Some(j), Some(&value)) = (place(parameter), value) {
                there[j] = value;
            }
        }
        there
    };
    let (rows, columns) = (tilts.len().max(1), widths.len().max(1));
    let costs: Vec<Vec<f64>> = (0..rows)
        .map(|row| (0..columns).map(|column| problem.residuals(&at(row, column)).norm_squared()).collect())
        .collect();
    let mut valleys: Vec<(f64, DVector<f64>)> = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let own = costs[row][column];
            let near = |middle: usize, count: usize| middle.saturating_sub(1)..=(middle + 1).min(count - 1);
            let is_lowest = near(row, rows).all(|r| near(column, columns).all(|c| costs[r][c] >= own));
            if own.is_finite() && is_lowest {
                valleys.push((own, at(row, column)));
            }
        }
    }
    valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
    let starts: Vec<DVector<f64>> = valleys.into_iter().take(WALKED).map(|(_, start)| start).collect();
    runs(compiled, space, &starts, FINE)
}
