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
    let factor = if m == n && is_upper_triangle(&scaled) { scaled } else { scaled.qr().r() };
    let svd = factor.try_svd(false, true, f64::EPSILON, 0)?;
    Some((svd.singular_values * size, svd.v_t?))
}

/// Whether all below the diagonal is 0.
pub(crate) fn is_upper_triangle(matrix: &DMatrix<f64>) -> bool {
    matrix.column_iter().enumerate().all(|(j, column)| column.iter().skip(j + 1).all(|below| *below == 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The factor of a matrix, which is taken as it is, has the singular values and vectors of the matrix, which is factored first.
    #[test]
    fn a_triangle_is_taken_as_it_is() {
        let matrix = DMatrix::from_fn(7, 4, |i, j| (0.37 * (1 + i) as f64 * (1 + j * j) as f64).sin());
        let factor = matrix.clone().qr().r();
        assert!(is_upper_triangle(&factor) && !is_upper_triangle(&matrix));
        let mut nearly = factor.clone();
        nearly[(3, 0)] = 1e-9;
        assert!(!is_upper_triangle(&nearly));
        let (values, vectors) = right_singular(&matrix).unwrap();
        for other in [factor, nearly] {
            let (found, directions) = right_singular(&other).unwrap();
            for k in 0..4 {
                assert!((found[k] - values[k]).abs() < 1e-8 * values[0]);
                assert!((directions.row(k).dot(&vectors.row(k)).abs() - 1.0).abs() < 1e-8);
            }
        }
    }

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
