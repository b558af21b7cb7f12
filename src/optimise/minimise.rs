//! One run from one start.

use crate::numerics::dot::dot;
use crate::numerics::singular::{is_upper_triangle, right_singular};
use crate::optimise::levenberg_marquardt::{LevenbergMarquardt, Tolerances};
use crate::optimise::objective::{ArgminProblem, LeastSquares};
use crate::optimise::termination::Termination;
use argmin::core::Executor;
use nalgebra::{DMatrix, DVector};

/// Singular values of the scaled Jacobian below this share of the largest mark a flat direction. Central differences
/// carry an error of about 1e-10 of a column, so a smaller threshold would read noise as information.
const FLAT: f64 = 1e-9;

/// A neighbour is lower if its sum of squares is, by this share.
const LOWER: f64 = 1e-9;
/// An escape that lowers the sum of squares by less than this share of the mean square has gained nothing and is the last: a
/// hundredth of a standard deviation where the model fits.
const NOTHING: f64 = 1e-4;
/// Distances of neighbours in units of the parameters' scales.
const NEIGHBOURS: [f64; 10] = [1e-1, -1e-1, 1e-2, -1e-2, 1e-3, -1e-3, 1e-4, -1e-4, 1e-5, -1e-5];

/// Where a run ended.
#[derive(Debug, Clone)]
pub struct Minimum {
    /// Parameters, inside the bounds.
    pub parameters: DVector<f64>,
    /// Sum of squared residuals there, infinite if one is not finite; of a robust fit the cost of its loss.
    pub sum_of_squares: f64,
    /// `J' r` there, of the residuals r and their derivatives J.
    pub gradient: DVector<f64>,
    /// The factor R of J, `[n, n]`: the same singular values and directions, in a small matrix. J itself where it has fewer
    /// rows than columns, or is not finite.
    pub triangle: DMatrix<f64>,
    /// Why the run ended.
    pub termination: Termination,
    /// Residual evaluations, those for derivatives apart.
    pub evaluations: usize,
}

/// Runs [`LevenbergMarquardt`] from `start`.
///
/// A minimum on a plateau, where some parameter does nothing, is reported as [`Termination::Flat`].
///
/// ```
/// use morpho_fit::optimise::{Bounds, LeastSquares, Tolerances, minimise};
/// use nalgebra::DVector;
///
/// struct Rosenbrock { bounds: Bounds, scales: DVector<f64> }
/// impl LeastSquares for Rosenbrock {
///     fn residuals(&self, p: &DVector<f64>) -> DVector<f64> {
///         DVector::from_vec(vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]])
///     }
///     fn bounds(&self) -> &Bounds { &self.bounds }
///     fn scales(&self) -> &DVector<f64> { &self.scales }
/// }
/// let half = Rosenbrock { bounds: Bounds::new(&[-2.0, -2.0], &[0.5, 2.0])?, scales: DVector::from_element(2, 1.0) };
/// let found = minimise(&half, &DVector::from_vec(vec![-1.2, 1.0]), Tolerances::default());
/// assert!(found.termination.was_successful());
/// assert_eq!(found.parameters[0], 0.5); // on the bound, to the last bit
/// assert!((found.parameters[1] - 0.25).abs() < 1e-7);
/// # Ok::<(), morpho_fit::optimise::BoundsError>(())
/// ```
pub fn minimise<L: LeastSquares + ?Sized>(problem: &L, start: &DVector<f64>, tolerances: Tolerances) -> Minimum {
    let (mut found, count) = descend(problem, start, tolerances);
    for _ in 0..tolerances.escapes {
        if found.termination != Termination::Stalled {
            break;
        }
        match lower_neighbour(problem, &found) {
            Some(neighbour) => {
                let (spent, before) = (found.evaluations, found.sum_of_squares);
                (found, _) = descend(problem, &neighbour, tolerances);
                found.evaluations += spent;
                // Along the edge of a kink the way down has no end that a step could find: in the end what it gains is nothing.
                #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
                let nothing = NOTHING * before / count.max(1) as f64;
                if before.is_finite()
                    && found.termination == Termination::Stalled
                    && before - found.sum_of_squares <= nothing
                {
                    found.termination = Termination::Kink;
                }
            }
            None => found.termination = Termination::Kink,
        }
    }
    if found.termination.was_successful() && is_flat(problem, &found) {
        found.termination = Termination::Flat;
    }
    found
}

/// One run of the solver, and the number of residuals.
fn descend<L: LeastSquares + ?Sized>(problem: &L, start: &DVector<f64>, tolerances: Tolerances) -> (Minimum, usize) {
    let solver = LevenbergMarquardt::new(problem.bounds().clone(), tolerances);
    let run = Executor::new(ArgminProblem(problem), solver)
        .configure(|state| state.param(start.clone()).max_iters(u64::MAX))
        .ctrlc(false)
        .run();
    let (found, termination, evaluations, products) = match run {
        Ok(mut result) => {
            let found = result.state.take_param().zip(result.state.take_residuals());
            let termination = result.solver.termination().unwrap_or(Termination::Stalled);
            (found, termination, result.solver.evaluations(), result.solver.take_products())
        }
        // Neither the problem nor the solver returns an error; if argmin does, the run has not moved.
        Err(_) => (None, Termination::Stalled, 0, None),
    };
    let (parameters, residuals) = found.unwrap_or_else(|| (start.clone(), problem.residuals(start)));
    let products = products.unwrap_or_else(|| problem.products(&parameters, &residuals));
    let all: Vec<usize> = (0..parameters.len()).collect();
    let triangle = products.triangle(&all).map_or_else(
        || {
            let jacobian = problem.jacobian(&parameters);
            let whole = jacobian.nrows() >= jacobian.ncols() && jacobian.iter().all(|value| value.is_finite());
            if whole { jacobian.qr().r() } else { jacobian }
        },
        |(r, _)| r,
    );
    let sum = dot(residuals.as_slice(), residuals.as_slice());
    let sum_of_squares = if sum.is_finite() { sum } else { f64::INFINITY };
    let gradient = products.gradient().clone();
    (Minimum { parameters, sum_of_squares, gradient, triangle, termination, evaluations }, residuals.len())
}

/// The lowest of the points around a minimum, if one is lower: steps of several sizes along each parameter and along
/// the principal directions of the problem.
fn lower_neighbour<L: LeastSquares + ?Sized>(problem: &L, at: &Minimum) -> Option<DVector<f64>> {
    let n = at.parameters.len();
    let mut directions: Vec<DVector<f64>> =
        (0..n).map(|j| DVector::from_fn(n, |i, _| if i == j { problem.scales()[j] } else { 0.0 })).collect();
    let scaled = DMatrix::from_fn(at.triangle.nrows(), n, |i, j| at.triangle[(i, j)] * problem.scales()[j]);
    if let Some((_, vectors)) = right_singular(&scaled) {
        directions.extend(vectors.row_iter().map(|row| row.transpose().component_mul(problem.scales())));
    }
    let mut lowest = (at.sum_of_squares * (1.0 - LOWER), None);
    for direction in &directions {
        for size in NEIGHBOURS {
            let point = problem.bounds().clamp(&(&at.parameters + direction * size));
            let sum = problem.residuals(&point).norm_squared();
            if sum < lowest.0 {
                lowest = (sum, Some(point));
            }
        }
    }
    lowest.1
}

/// Whether the pivots of a triangle alone tell that no direction is flat: of its singular values the least over the largest is
/// at least `|det| / ‖triangle‖^n`.
fn is_far_from_flat(triangle: &DMatrix<f64>) -> bool {
    let size = triangle.norm();
    let (rows, n) = triangle.shape();
    let least: f64 = (0..n.min(rows)).map(|j| triangle[(j, j)].abs() / size).product();
    rows >= n && is_upper_triangle(triangle) && least > FLAT
}

/// Whether some combination of the parameters inside the box does nothing.
fn is_flat<L: LeastSquares + ?Sized>(problem: &L, found: &Minimum) -> bool {
    let parameters = &found.parameters;
    let gradient = &found.gradient;
    let bounds = problem.bounds();
    let free: Vec<usize> = (0..parameters.len())
        .filter(|&j| {
            let pressed = (parameters[j] <= bounds.lower()[j] && gradient[j] > 0.0)
                || (parameters[j] >= bounds.upper()[j] && gradient[j] < 0.0);
            !pressed
        })
        .collect();
    if free.is_empty() {
        return false;
    }
    let mut scaled = found.triangle.select_columns(&free);
    for (c, &j) in free.iter().enumerate() {
        scaled.column_mut(c).scale_mut(problem.scales()[j].max(parameters[j].abs()));
    }
    if is_far_from_flat(&scaled) {
        return false;
    }
    match right_singular(&scaled) {
        Some((values, _)) => values.iter().any(|&value| value <= FLAT * values.max()),
        None => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::Bounds;

    /// A valley across which the least-squares step is long: cut at the walls of the box it would rise.
    struct Valley {
        bounds: Bounds,
        scales: DVector<f64>,
    }

    impl LeastSquares for Valley {
        fn residuals(&self, p: &DVector<f64>) -> DVector<f64> {
            let (x, y) = (p[0] - 10.0, p[1] - 10.0);
            DVector::from_vec(vec![x + y, 0.01 * y + 1.0])
        }

        fn bounds(&self) -> &Bounds {
            &self.bounds
        }

        fn scales(&self) -> &DVector<f64> {
            &self.scales
        }
    }

    #[test]
    fn a_step_that_walls_cut_short_is_no_end() {
        let bounds = Bounds::new(&[0.0, 0.0], &[50.0, 50.0]).unwrap();
        let valley = Valley { bounds, scales: DVector::from_element(2, 1.0) };
        let start = DVector::from_element(2, 10.0);
        for cost in [1e-4, 1e-10] {
            let found = minimise(&valley, &start, Tolerances { cost, ..Tolerances::default() });
            // On the wall y = 0 the least of (x - 20)² + 0.81 is at 20.
            assert!(found.termination.was_successful(), "{:?}", found.termination);
            assert!((found.sum_of_squares - 0.81).abs() < 1e-4 && found.parameters[1] <= 0.0, "{found:?}");
        }
    }

    #[test]
    fn pivots_tell_no_more_than_singular_values() {
        let told = |triangle: &DMatrix<f64>| {
            let (values, _) = right_singular(triangle).unwrap();
            values.iter().all(|&value| value > FLAT * values.max())
        };
        let round = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, -0.5, 0.0, 3.0, 0.1, 0.0, 0.0, 1e-3]);
        assert!(is_far_from_flat(&round) && told(&round));
        // Sound pivots, and yet a direction that does next to nothing.
        let n = 40;
        let hidden = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                1.0
            } else if i < j {
                -1.0
            } else {
                0.0
            }
        });
        assert!(!is_far_from_flat(&hidden) && !told(&hidden));
        let mut full = round.clone();
        full[(2, 0)] = 1.0;
        for other in [full, DMatrix::zeros(1, 1), DMatrix::from_element(1, 1, f64::NAN), round.rows(0, 2).into_owned()]
        {
            assert!(!is_far_from_flat(&other), "{other}");
        }
        assert!(is_far_from_flat(&DMatrix::from_element(1, 1, -1e-200)));
    }
}
