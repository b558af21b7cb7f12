//! The products of a Jacobian's columns with each other and with the residuals, in one pass over the rows.
//!
//! For columns that are far from dependent their Cholesky factor is the triangle of a QR decomposition to more digits than a
//! step of a trust region needs, at a tenth of its time: each row is read once, in vector code.

use crate::numerics::dot::dot;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Least pivot of columns of length 1: below it the factor has lost half of its digits, and QR stands in.
const LEAST_PIVOT: f64 = 1e-4;

/// Rows that stay in the nearest memory while each column meets each other.
const ROWS: usize = 256;

/// `[J r]' [J r]`.
#[derive(Debug, Clone)]
pub(crate) struct Products {
    gram: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Products {
    pub(crate) fn new(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> Self {
        let (m, n) = jacobian.shape();
        let mut gram = DMatrix::zeros(n, n);
        let mut gradient = DVector::zeros(n);
        for first in (0..m).step_by(ROWS) {
            let rows = first..m.min(first + ROWS);
            let column = |j: usize| &jacobian.as_slice()[j * m + rows.start..j * m + rows.end];
            for j in 0..n {
                for i in j..n {
                    gram[(i, j)] += dot(column(i), column(j));
                }
                gradient[j] += dot(column(j), &residuals.as_slice()[rows.clone()]);
            }
        }
        gram.fill_upper_triangle_with_lower_triangle();
        Self { gram, gradient }
    }

    /// `J' r`.
    pub(crate) fn gradient(&self) -> DVector<f64> {
        self.gradient.clone()
    }

    /// Euclidean length of column `j`.
    pub(crate) fn length(&self, j: usize) -> f64 {
        self.gram[(j, j)].sqrt()
    }

    /// `(R, Q' r)` of the QR decomposition of some columns; `None` if they are so nearly dependent, or so small or large, that
    /// their products do not hold them.
    pub(crate) fn triangle(&self, columns: &[usize]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = columns.len();
        let lengths = DVector::from_fn(n, |c, _| self.length(columns[c]));
        if lengths.iter().any(|length| !(1e-100..1e100).contains(length)) {
            return None;
        }
        let unit = DMatrix::from_fn(n, n, |a, b| self.gram[(columns[a], columns[b])] / (lengths[a] * lengths[b]));
        let lower = Cholesky::new(unit)?.l();
        if lower.diagonal().iter().any(|pivot| *pivot < LEAST_PIVOT) {
            return None;
        }
        let scaled = DVector::from_fn(n, |c, _| self.gradient[columns[c]] / lengths[c]);
        let rotated = lower.solve_lower_triangular(&scaled)?;
        Some((DMatrix::from_fn(n, n, |a, b| lower[(b, a)] * lengths[b]), rotated))
    }
}

/// The factor R of the QR decomposition of `jacobian`, up to the signs of its rows.
pub(crate) fn triangle(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let all: Vec<usize> = (0..jacobian.ncols()).collect();
    let products = Products::new(jacobian, &DVector::zeros(jacobian.nrows()));
    products.triangle(&all).map_or_else(|| jacobian.clone().qr().r(), |(r, _)| r)
}

/// `matrix` less its projection on `columns`.
///
/// # Shape
/// `[m, n]` and `[m, q]`, with `q <= m`; what comes back is `[m, n]`.
pub(crate) fn without_columns(mut matrix: DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    let all: Vec<usize> = (0..columns.ncols()).collect();
    let m = columns.nrows();
    let column = |j: usize| &columns.as_slice()[j * m..(j + 1) * m];
    let factor = Products::new(columns, &DVector::zeros(m)).triangle(&all).map(|(r, _)| r);
    for mut target in matrix.column_iter_mut() {
        let along = DVector::from_fn(columns.ncols(), |j, _| dot(column(j), target.as_slice()));
        let solved = factor.as_ref().and_then(|r| r.solve_upper_triangular(&r.tr_solve_upper_triangular(&along)?));
        let Some(solved) = solved else {
            let q = columns.clone().qr().q();
            let along = q.tr_mul(&target);
            target -= q * along;
            continue;
        };
        for (j, share) in solved.iter().enumerate() {
            for (out, value) in target.iter_mut().zip(column(j)) {
                *out -= share * value;
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_triangle_is_that_of_a_qr_decomposition() {
        let wave = |i: usize| ((1 + i) as f64 * 0.37).sin();
        let jacobian = DMatrix::from_fn(23, 3, |i, j| [wave(i), 10.0 * wave(i).powi(2), 100.0 * wave(i).powi(3)][j]);
        let residuals = DVector::from_fn(23, |i, _| (i as f64).cos());
        let products = Products::new(&jacobian, &residuals);
        assert_relative_eq!(products.gradient(), jacobian.tr_mul(&residuals), max_relative = 1e-13);
        let (r, b) = products.triangle(&[2, 0]).unwrap();
        let qr = jacobian.select_columns(&[2, 0]).qr();
        let signs = DMatrix::from_diagonal(&qr.r().diagonal().map(f64::signum));
        assert_relative_eq!(r, &signs * qr.r(), max_relative = 1e-12, epsilon = 1e-12);
        let rotated = &signs * qr.q().tr_mul(&residuals);
        assert_relative_eq!(b, rotated, max_relative = 1e-12, epsilon = 1e-12);
    }

    #[test]
    fn what_is_left_of_a_projection_is_orthogonal_to_it() {
        let wave = |i: usize| ((1 + i) as f64 * 0.37).sin();
        let matrix = DMatrix::from_fn(700, 3, |i, j| wave(i * (j + 2)));
        // Far from dependent, and so nearly dependent that QR stands in.
        for near in [1.0, 1e-6] {
            let columns = DMatrix::from_fn(700, 2, |i, j| wave(i + 1) + if j == 1 { near * wave(3 * i) } else { 0.0 });
            let left = without_columns(matrix.clone(), &columns);
            assert!(columns.tr_mul(&left).amax() < 1e-10, "{near}");
            let projected = columns.clone().svd(true, false).u.unwrap();
            assert_relative_eq!(left, &matrix - &projected * projected.tr_mul(&matrix), epsilon = 1e-9);
        }
        assert_eq!(without_columns(matrix.clone(), &DMatrix::zeros(700, 0)), matrix);
    }

    #[test]
    fn nearly_dependent_columns_have_none() {
        let jacobian = DMatrix::from_fn(9, 2, |i, j| 1.0 + if i == j { 1e-6 } else { 0.0 });
        let products = Products::new(&jacobian, &DVector::zeros(9));
        assert!(products.triangle(&[0, 1]).is_none());
        assert!(products.triangle(&[0]).is_some());
        let zero = Products::new(&DMatrix::zeros(9, 1), &DVector::zeros(9));
        assert!(zero.triangle(&[0]).is_none());
    }
}
