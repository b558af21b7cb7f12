//! The products of a Jacobian's columns with each other and with the residuals, in one pass over the rows.
//!
//! For columns that are far from dependent their Cholesky factor is the triangle of a QR decomposition to more digits than a
//! step of a trust region needs, at a tenth of its time: each row is read once, in vector code.

use crate::numerics::dot::dot;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Least pivot of columns of length 1: below it the factor has lost half of its digits, and QR stands in.
const LEAST_PIVOT: f64 = 1e-4;

/// `[J r]' [J r]`.
#[derive(Debug, Clone)]
pub(crate) struct Products {
    gram: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Products {
    pub(crate) fn new(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> Self {
        let n = jacobian.ncols();
        let column = |j: usize| {
            let rows = jacobian.nrows();
            &jacobian.as_slice()[j * rows..(j + 1) * rows]
        };
        let mut gram = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..=i {
                let product = dot(column(i), column(j));
                gram[(i, j)] = product;
                gram[(j, i)] = product;
            }
        }
        Self { gram, gradient: DVector::from_fn(n, |j, _| dot(column(j), residuals.as_slice())) }
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
    fn nearly_dependent_columns_have_none() {
        let jacobian = DMatrix::from_fn(9, 2, |i, j| 1.0 + if i == j { 1e-6 } else { 0.0 });
        let products = Products::new(&jacobian, &DVector::zeros(9));
        assert!(products.triangle(&[0, 1]).is_none());
        assert!(products.triangle(&[0]).is_some());
        let zero = Products::new(&DMatrix::zeros(9, 1), &DVector::zeros(9));
        assert!(zero.triangle(&[0]).is_none());
    }
}
