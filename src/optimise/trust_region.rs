//! The step of a trust region: a linear least-squares problem in a ball and a box.
//!
//! ```text
//! minimise ‖R s + b‖   over   ‖D s‖ <= radius,   lower <= s <= upper
//! ```
//!
//! # Source
//! Moré 1978, *The Levenberg-Marquardt algorithm: implementation and theory*, DOI 10.1007/BFb0067700, with the singular
//! values of `R D⁻¹` in place of his pivoted QR: for the few columns of a fit it is as fast and sees rank loss. A triangle far from
//! that is solved by substitution first: in the ball, that is the step.

use crate::numerics::singular::is_upper_triangle;
use nalgebra::{DMatrix, DVector};

/// A multiplier is good enough if the step's length is within this share of the radius (as in MINPACK).
const RADIUS_TOLERANCE: f64 = 0.1;
/// Newton's method for the multiplier has a few steps; more than this is a sign of non-finite input.
const MAX_NEWTON_STEPS: usize = 30;

/// A diagonal entry that is less of its column than this may hide a rank loss: singular values tell.
const LEAST_SHARE: f64 = 1e-4;

/// A step, and whether the radius held it back or it met a wall of the box.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(crate) step: DVector<f64>,
    pub(crate) held_back: bool,
    pub(crate) met_wall: bool,
}

impl Step {
    /// Whether it is the least-squares step itself.
    pub(crate) fn is_whole(&self) -> bool {
        !self.held_back && !self.met_wall
    }
}

/// The step in a ball.
#[derive(Debug, Clone)]
struct InBall {
    step: DVector<f64>,
    held_back: bool,
}

/// The step for columns `r` (`[k, n]`), right side `b` (`[k]`), scaling `d` (`[n]`) and the box of the step.
///
/// A component that would leave the box is put on its wall and the rest solved again, at most `n` times.
pub(crate) fn bounded_step(
    r: &DMatrix<f64>,
    b: &DVector<f64>,
    d: &DVector<f64>,
    radius: f64,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> Step {
    let n = r.ncols();
    let mut step = DVector::zeros(n);
    let mut free: Vec<usize> = (0..n).collect();
    let mut rest = b.clone();
    let mut room = radius * radius;
    let (mut held_back, mut met_wall) = (false, false);
    while !free.is_empty() {
        let scaled = DMatrix::from_fn(r.nrows(), free.len(), |i, c| r[(i, free[c])] / d[free[c]]);
        let inner = unbounded_step(scaled, &rest, room.max(0.0).sqrt());
        held_back |= inner.held_back;
        let mut on_wall = Vec::new();
        for (c, &j) in free.iter().enumerate() {
            step[j] = inner.step[c] / d[j];
            if step[j] < lower[j] || step[j] > upper[j] {
                step[j] = step[j].clamp(lower[j], upper[j]);
                on_wall.push(j);
            }
        }
        if on_wall.is_empty() {
            break;
        }
        met_wall = true;
        for &j in &on_wall {
            rest += r.column(j) * step[j];
            room -= (d[j] * step[j]).powi(2);
        }
        free.retain(|j| !on_wall.contains(j));
    }
    Step { step, held_back, met_wall }
}

/// The least-squares step itself, if `a` is a triangle far from rank loss: the last steps of a run are of this kind.
fn by_substitution(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let n = a.ncols();
    let sound = |j: usize| a[(j, j)].abs() > LEAST_SHARE * a.column(j).norm();
    if a.nrows() != n || !is_upper_triangle(a) || !(0..n).all(sound) {
        return None;
    }
    a.solve_upper_triangular(&-b)
}

/// `minimise ‖A z + b‖ over ‖z‖ <= radius`.
fn unbounded_step(a: DMatrix<f64>, b: &DVector<f64>, radius: f64) -> InBall {
    if let Some(step) = by_substitution(&a, b).filter(|step| step.norm() <= radius * (1.0 + RADIUS_TOLERANCE)) {
        return InBall { step, held_back: false };
    }
    let columns = a.ncols();
    let svd = a.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return InBall { step: DVector::zeros(columns), held_back: true };
    };
    let singular = svd.singular_values;
    let components = u.tr_mul(b);
    #[allow(clippy::cast_precision_loss, reason = "a column count is small")]
    let floor = singular.max() * f64::EPSILON * columns as f64;
    let at = |multiplier: f64| {
        DVector::from_fn(singular.len(), |i, _| {
            let s = singular[i];
            if s <= floor && multiplier <= 0.0 { 0.0 } else { -components[i] * s / (s * s + multiplier) }
        })
    };
    let newton = at(0.0);
    if newton.norm() <= radius * (1.0 + RADIUS_TOLERANCE) {
        return InBall { step: v_t.tr_mul(&newton), held_back: false };
    }
    // Newton's method on 1/radius - 1/‖z‖, which is nearly linear in the multiplier and is approached from below.
    let mut multiplier = 0.0;
    let mut z = newton;
    for _ in 0..MAX_NEWTON_STEPS {
        let length = z.norm();
        if (length - radius).abs() <= RADIUS_TOLERANCE * radius {
            break;
        }
        let slope: f64 = (0..singular.len())
            .filter(|&i| singular[i] > floor)
            .map(|i| z[i] * z[i] / (singular[i] * singular[i] + multiplier))
            .sum();
        multiplier += (length / radius - 1.0) * length * length / slope;
        z = at(multiplier);
    }
    InBall { step: v_t.tr_mul(&z), held_back: true }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn free(n: usize) -> (DVector<f64>, DVector<f64>) {
        (DVector::from_element(n, f64::NEG_INFINITY), DVector::from_element(n, f64::INFINITY))
    }

    #[test]
    fn a_wide_region_gives_the_least_squares_step_and_a_narrow_one_its_radius() {
        let r = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 0.0, 3.0]);
        let b = DVector::from_vec(vec![-4.0, -6.0]);
        let (lower, upper) = free(2);
        let d = DVector::from_element(2, 1.0);
        let wide = bounded_step(&r, &b, &d, 100.0, &lower, &upper);
        assert!(!wide.held_back);
        assert_relative_eq!(wide.step, DVector::from_vec(vec![1.0, 2.0]), epsilon = 1e-12);
        let narrow = bounded_step(&r, &b, &d, 0.1, &lower, &upper);
        assert!(narrow.held_back);
        assert_relative_eq!(narrow.step.norm(), 0.1, max_relative = 0.11);
    }

    #[test]
    fn a_triangle_is_solved_as_its_singular_values_solve_it() {
        let r = DMatrix::from_row_slice(3, 3, &[2.0, 1.0, -0.5, 0.0, 3.0, 0.1, 0.0, 0.0, 1e-3]);
        let b = DVector::from_vec(vec![-4.0, -6.0, 1e-3]);
        let by_singular_values = -(r.clone().svd(true, true).solve(&b, 0.0).unwrap());
        assert_relative_eq!(by_substitution(&r, &b).unwrap(), by_singular_values, max_relative = 1e-12);
        // Not where a column is nearly those before it, nor of a matrix that is no triangle.
        let mut hidden = r.clone();
        hidden[(2, 2)] = 1e-6;
        assert_eq!(by_substitution(&hidden, &b), None);
        hidden[(2, 2)] = 1.0;
        hidden[(2, 0)] = 1.0;
        assert_eq!(by_substitution(&hidden, &b), None);
        assert_eq!(by_substitution(&r.remove_column(1), &b), None);
    }

    #[test]
    fn a_wall_is_met_exactly_and_the_rest_solved_again() {
        // minimise (x + y - 3)² + (x - y - 5)²: free minimum (4, -1); with x <= 1 it is y = -1 still.
        let r = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, -1.0]);
        let b = DVector::from_vec(vec![-3.0, -5.0]);
        let (lower, mut upper) = free(2);
        upper[0] = 1.0;
        let step = bounded_step(&r, &b, &DVector::from_element(2, 1.0), 100.0, &lower, &upper).step;
        assert_relative_eq!(step, DVector::from_vec(vec![1.0, -1.0]), epsilon = 1e-12);
    }
}
