//! Covariance of parameters at a minimum, from the curvature of the sum of squares.
//!
//! ```text
//! C = (J' J)⁻¹   for residuals in units of their standard deviation
//! ```

use crate::numerics::singular::right_singular;
use nalgebra::{DMatrix, DVector};

/// Covariance `(J' J)⁻¹` of the columns of `jacobian`, by singular values of the columns scaled to length 1.
///
/// `None` if a column is zero or not finite, or if the columns depend on each other to rounding: then some combination
/// has no finite variance, which [`identifiability`](crate::uncertainty::identifiability) names.
///
/// # Shape
/// `jacobian: [m, n]`, result `[n, n]`.
///
/// ```
/// use morpho_fit::uncertainty::covariance::covariance;
/// use nalgebra::DMatrix;
/// // four readings of one number with sigma 1: variance 1/4
/// assert_eq!(covariance(&DMatrix::from_element(4, 1, 1.0)).unwrap()[(0, 0)], 0.25);
/// ```
#[must_use]
pub fn covariance(jacobian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = jacobian.ncols();
    if n == 0 {
        return Some(DMatrix::zeros(0, 0));
    }
    let length = DVector::from_iterator(n, jacobian.column_iter().map(|column| column.norm()));
    if jacobian.nrows() < n || !length.iter().all(|value| value.is_finite() && *value > 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(jacobian.nrows(), n, |i, j| jacobian[(i, j)] / length[j]);
    let (singular, v_t) = right_singular(&scaled)?;
    #[allow(clippy::cast_precision_loss, reason = "a column count is small")]
    let floor = singular.max() * f64::EPSILON * 10.0 * n as f64;
    if singular.iter().any(|&value| value <= floor) {
        return None;
    }
    let whitened = DMatrix::from_fn(n, n, |k, j| v_t[(k, j)] / (singular[k] * length[j]));
    Some(whitened.tr_mul(&whitened))
}

/// Covariance `(J' J + 12 diag(range)⁻²)⁻¹` of a Jacobian and a normal prior as wide as an even guess over each range.
///
/// It exists where the data alone leave a direction open; `None` only if `jacobian` is not finite.
///
/// # Shape
/// `jacobian: [m, n]`, `ranges: [n]`, above 0, result `[n, n]`.
#[must_use]
pub fn regularised(jacobian: &DMatrix<f64>, ranges: &DVector<f64>) -> Option<DMatrix<f64>> {
    let n = jacobian.ncols();
    let mut both = jacobian.clone().resize_vertically(jacobian.nrows() + n, 0.0);
    for j in 0..n {
        both[(jacobian.nrows() + j, j)] = 12.0_f64.sqrt() / ranges[j];
    }
    covariance(&both)
}

/// Correlations of a covariance, `[n, n]`; 0 beside a variance of 0.
#[must_use]
pub fn correlation(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if i == j {
            1.0
        } else if scale > 0.0 {
            (covariance[(i, j)] / scale).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_straight_line_has_its_textbook_covariance() {
        // Bevington: x = 0..4, sigma 1: var(slope) = 1/10, var(intercept) = 30/50, cov = -10/50.
        let jacobian = DMatrix::from_fn(5, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let expected = DMatrix::from_row_slice(2, 2, &[0.6, -0.2, -0.2, 0.1]);
        assert_relative_eq!(covariance(&jacobian).unwrap(), expected, epsilon = 1e-14);
        assert_relative_eq!(correlation(&expected)[(0, 1)], -0.2 / 0.06_f64.sqrt(), epsilon = 1e-14);
    }

    #[test]
    fn units_do_not_matter_and_dependence_is_seen() {
        let jacobian = DMatrix::from_fn(5, 2, |i, j| if j == 0 { 1e12 } else { 1e-12 * i as f64 });
        assert_relative_eq!(covariance(&jacobian).unwrap()[(1, 1)], 0.1e24, max_relative = 1e-12);
        assert!(covariance(&DMatrix::from_element(5, 2, 1.0)).is_none());
        assert!(covariance(&DMatrix::from_element(5, 1, 0.0)).is_none());
        assert!(covariance(&DMatrix::from_element(1, 2, 1.0)).is_none());
    }
}
