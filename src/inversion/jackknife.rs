//! The best structure without each part of the data: how far a model that misses them is led by a part.

use crate::inversion::estimates::Found;
use crate::inversion::parameter::COUNT;
use crate::inversion::problem::{Evaluation, Problem};
use crate::optimise::{LeastSquares, Tolerances, minimise};
use crate::uncertainty::discrepancy::{Blocks, Spread, groupings};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

/// Tolerances of a fit without a block: to a thousandth of the spread it is to tell.
const ROUGH: Tolerances = Tolerances { cost: 1e-5, step: 1e-5, gradient: 1e-8, max_evaluations: 60, escapes: 0 };

/// Spread of the five values and of the nuisances `in_use` about `point`, in that order; `None` without two blocks.
///
/// Each fit starts from the minimum of the whole that is best without the block: where a part decides between minima, the
/// spread has their distance in it. With `halves` the finer grouping stands alone: where residuals may be noise that was stated
/// too small, a curve that is needed is not left out whole.
pub(crate) fn jackknife(found: &Found<'_>, point: &Evaluation, in_use: &[usize], halves: bool) -> Option<Spread> {
    let freedom = &found.space.freedom;
    let others = found.minima.iter().skip(1);
    let others = others.map(|minimum| freedom.restrict(&found.searched.freedom.expand(&minimum.parameters)));
    let starts: Vec<DVector<f64>> = std::iter::once(found.best.parameters.clone()).chain(others).collect();
    let curves: Vec<usize> = found.plan.readings().iter().map(|reading| reading.curve).collect();
    let without_each = |blocks: &Blocks| {
        let fits: Vec<DVector<f64>> = (0..blocks.count)
            .into_par_iter()
            .filter_map(|block| without(found, &starts, blocks, block, point, in_use))
            .collect();
        DMatrix::from_fn(fits.len(), COUNT + in_use.len(), |row, column| fits[row][column])
    };
    let groupings = groupings(&curves);
    let differences: Vec<DMatrix<f64>> = groupings[usize::from(halves)..].iter().map(without_each).collect();
    let mut spread = Spread::new(&differences)?;
    // Halves of one curve share its error: they are no more independent than the curves.
    spread.dof = spread.dof.min(groupings[0].count.saturating_sub(1)).max(1);
    Some(spread)
}

/// The best point without `block` less `point`; `None` if the model has no value there.
fn without(
    found: &Found<'_>,
    starts: &[DVector<f64>],
    blocks: &Blocks,
    block: usize,
    point: &Evaluation,
    in_use: &[usize],
) -> Option<DVector<f64>> {
    let own = |row: usize| found.robust.get(row).copied().unwrap_or(1.0);
    let labels = blocks.labels.iter().enumerate();
    let weights: Vec<f64> = labels.map(|(row, &label)| if label == block { 0.0 } else { own(row) }).collect();
    let space = found.space;
    let problem = || Problem::new(found.compiled, space, &weights);
    let compared = problem();
    let cost = |start: &&DVector<f64>| compared.residuals(start).norm_squared();
    let start = starts.iter().map(|start| (cost(&start), start)).min_by(|a, b| a.0.total_cmp(&b.0))?.1;
    let refit = minimise(&problem(), start, ROUGH);
    let at = compared.evaluate(&refit.parameters)?;
    Some(DVector::from_fn(COUNT + in_use.len(), |j, _| match in_use.get(j.wrapping_sub(COUNT)) {
        Some(&column) => at.coefficients[column] - point.coefficients[column],
        None => at.values[j] - point.values[j],
    }))
}
