//! Many starts: all runs kept, equal minima merged, the best first.

use crate::optimise::levenberg_marquardt::Tolerances;
use crate::optimise::minimise::{Minimum, minimise};
use crate::optimise::objective::LeastSquares;
use nalgebra::DVector;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

/// Two runs whose sums of squares agree to this share and whose parameters agree to [`SAME_PLACE`] are one minimum.
const SAME_COST: f64 = 1e-5;
/// In units of each parameter's scale.
const SAME_PLACE: f64 = 1e-3;

/// Runs every start in parallel; result in the order of `starts`, whatever the number of threads.
///
/// - `problem`: makes an objective for one run, so that an objective may keep a workspace of its own.
pub fn multistart<L: LeastSquares>(
    problem: impl Fn() -> L + Sync,
    starts: &[DVector<f64>],
    tolerances: Tolerances,
) -> Vec<Minimum> {
    let run = |start: &DVector<f64>| minimise(&problem(), start, tolerances);
    match starts {
        // A batch of single runs brings its own threads, or wants none.
        [only] => vec![run(only)],
        _ => starts.par_iter().map(run).collect(),
    }
}

/// The distinct minima, best first; of equal ones, in place and cost, the lowest is kept.
///
/// - `scales`: a change of each parameter that matters, `[n]`.
#[must_use]
pub fn merge_equal(runs: Vec<Minimum>, scales: &DVector<f64>) -> Vec<Minimum> {
    merge(runs, scales, SAME_PLACE, SAME_COST)
}

/// The minima that lie apart by more than `apart` scales in some parameter, best first; of near ones the lowest is kept.
#[must_use]
pub fn merge_near(runs: Vec<Minimum>, scales: &DVector<f64>, apart: f64) -> Vec<Minimum> {
    merge(runs, scales, apart, f64::INFINITY)
}

fn merge(mut runs: Vec<Minimum>, scales: &DVector<f64>, place: f64, share: f64) -> Vec<Minimum> {
    runs.sort_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares));
    let mut distinct: Vec<Minimum> = Vec::new();
    for run in runs {
        let cost = run.sum_of_squares;
        let known = distinct.iter().any(|other| {
            let apart = (&run.parameters - &other.parameters).component_div(scales).amax();
            apart <= place && cost - other.sum_of_squares <= share * cost
        });
        if !known {
            distinct.push(run);
        }
    }
    distinct
}
