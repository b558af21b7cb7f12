//! Singular values and right singular vectors of a tall matrix, safe for any input.

use nalgebra::{DMatrix, DVector};

/// Singular values, largest first, and right singular vectors as the rows of a matrix, of an `[m, n]` matrix.
///
/// By way of its factor R, which has the same and is small. `None` if the matrix is empty, has fewer rows than columns, or
/// holds a value that is not finite. The matrix is scaled by its largest element first, so nothing overflows.
///
/// ```
/// use morpho_fit::numerics::singular::right_singular;
/// use nalgebra::DMatrix;
/// let (values, vectors) = right_singular(&DMatrix::from_row_slice(2, 2, &[0.0, 3.0, 1e-200, 0.0])).unwrap();
/// assert!((values[0] - 3.0).abs() < 1e-15 && (vectors[(0, 1)].abs() - 1.0).abs() < 1e-15);
/// assert!(right_singular(&DMatrix::from_element(1, 1, f64::NAN)).is_none());
/// ```
#[must_use]
pub fn right_singular(matrix: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let (m, n) = matrix.shape();
    if n == 0 || m < n || !matrix.iter().all(|value| value.is_finite()) {
        return None;
    }
    let size = matrix.amax();
    if size <= 0.0 {
        return Some((DVector::zeros(n), DMatrix::identity(n, n)));
    }
    let scaled = matrix / size;
    let is_triangle = m == n && (0..n).all(|j| scaled.column(j).iter().skip(j + 1).all(|below| *below == 0.0));
    let factor = if is_triangle { scaled } else { scaled.qr().r() };
    let svd = factor.try_svd(false, true, f64::EPSILON, 0)?;
    Some((svd.singular_values * size, svd.v_t?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_and_tiny_matrices_do_not_overflow() {
        for size in [1e-300, 1.0, 1e300] {
            let (values, _) =
                right_singular(&(DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 0.0, 2.0, 0.0, 0.0]) * size)).unwrap();
            // eigenvalues of [[1, 1], [1, 5]]: 3 ± sqrt(5)
            assert!((values[0] / size - (3.0 + 5.0_f64.sqrt()).sqrt()).abs() < 1e-14);
            assert!((values[1] / size - (3.0 - 5.0_f64.sqrt()).sqrt()).abs() < 1e-14);
        }
    }

    #[test]
    fn what_has_no_singular_values_gives_none() {
        assert!(right_singular(&DMatrix::zeros(0, 0)).is_none());
        assert!(right_singular(&DMatrix::zeros(1, 2)).is_none());
        assert!(right_singular(&DMatrix::from_element(2, 1, f64::INFINITY)).is_none());
        assert_eq!(right_singular(&DMatrix::zeros(3, 2)).unwrap().0, DVector::zeros(2));
    }
}
