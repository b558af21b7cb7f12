//! Derivatives by finite differences: relative, central, and inside the bounds.

use crate::optimise::bounds::Bounds;
use nalgebra::{DMatrix, DVector};

/// The step of a central difference at `value` for a parameter whose changes of `scale` matter.
///
/// `cbrt(machine epsilon)` of the larger of the two balances truncation against rounding; an absolute step would lose
/// every digit in some unit. The step is rounded so that `value + step` is exact.
///
/// ```
/// use morpho_fit::optimise::step;
/// assert!((step(100.0, 1.0) / 100.0 - 6.06e-6).abs() < 1e-8);
/// ```
#[must_use]
pub fn step(value: f64, scale: f64) -> f64 {
    let wanted = f64::EPSILON.cbrt() * value.abs().max(scale);
    let there = value + wanted;
    there - value
}

/// Derivative of a vector-valued `function` of one number at `value`, by a central difference of second order.
///
/// Next to a bound, and where one side is not finite, a one-sided difference over three points, also of second order,
/// stands in, so that `function` is never called outside `[lower, upper]`. NaN where neither side is finite.
#[must_use]
pub fn derivative(
    function: impl Fn(f64) -> DVector<f64>,
    value: f64,
    scale: f64,
    (lower, upper): (f64, f64),
) -> DVector<f64> {
    let step = step(value, scale);
    let at = |place: f64| {
        let inside = (lower..=upper).contains(&place);
        inside.then(|| function(place)).filter(|values| values.iter().all(|value| value.is_finite()))
    };
    let one_sided = |near: DVector<f64>, step: f64| {
        let here = function(value);
        match at(value + 2.0 * step) {
            Some(far) => (near * 4.0 - far - here * 3.0) / (2.0 * step),
            None => (near - here) / step,
        }
    };
    match (at(value + step), at(value - step)) {
        (Some(above), Some(below)) => (above - below) / (2.0 * step),
        (Some(above), None) => one_sided(above, step),
        (None, Some(below)) => one_sided(below, -step),
        (None, None) => function(value) * f64::NAN,
    }
}

/// Jacobian of `function` at `parameters`, a [`derivative`] a column.
///
/// # Shape
/// `parameters`, `scales`: `[n]`; `function` returns `[m]`; result `[m, n]`.
#[must_use]
pub fn central_jacobian(
    function: impl Fn(&DVector<f64>) -> DVector<f64>,
    parameters: &DVector<f64>,
    scales: &DVector<f64>,
    bounds: &Bounds,
) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = (0..parameters.len())
        .map(|j| {
            let along = |value: f64| {
                let mut moved = parameters.clone();
                moved[j] = value;
                function(&moved)
            };
            derivative(along, parameters[j], scales[j], (bounds.lower()[j], bounds.upper()[j]))
        })
        .collect();
    if columns.is_empty() {
        return DMatrix::zeros(function(parameters).len(), 0);
    }
    DMatrix::from_columns(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn cubic(p: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec(vec![p[0].powi(3), p[0] * p[1], p[1].exp()])
    }

    #[test]
    fn differences_agree_with_the_derivatives_in_any_unit() {
        for unit in [1e-9, 1.0, 1e9] {
            let scaled = |p: &DVector<f64>| cubic(&(p / unit));
            let p = DVector::from_vec(vec![3.0, 0.5]) * unit;
            let scales = DVector::from_element(2, unit);
            let jacobian = central_jacobian(scaled, &p, &scales, &Bounds::none(2)) * unit;
            assert_relative_eq!(jacobian[(0, 0)], 27.0, max_relative = 1e-9);
            assert_relative_eq!(jacobian[(1, 1)], 3.0, max_relative = 1e-9);
            assert_relative_eq!(jacobian[(2, 1)], 0.5_f64.exp(), max_relative = 1e-9);
        }
    }

    #[test]
    fn no_point_outside_the_bounds_is_visited() {
        let bounds = Bounds::new(&[3.0, 0.0], &[4.0, 0.5]).unwrap();
        let guarded = |p: &DVector<f64>| {
            assert!(bounds.contain(p));
            cubic(p)
        };
        let p = DVector::from_vec(vec![3.0, 0.5]);
        let jacobian = central_jacobian(guarded, &p, &DVector::from_element(2, 1.0), &bounds);
        assert_relative_eq!(jacobian[(0, 0)], 27.0, max_relative = 1e-8);
        assert_relative_eq!(jacobian[(2, 1)], 0.5_f64.exp(), max_relative = 1e-8);
    }
}
