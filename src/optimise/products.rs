//! The products of a Jacobian's columns with each other and with the residuals.
//!
//! For columns that are far from dependent their Cholesky factor is the triangle of a QR decomposition to more digits than a
//! step of a trust region needs, at a tenth of its time. A problem may sum them up without ever holding the Jacobian.

use crate::numerics::dot::dot;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Least pivot of columns of length 1: below it the factor has lost half of its digits, and QR stands in.
const LEAST_PIVOT: f64 = 1e-4;
/// The same of columns that are taken away: what they leave loses its digits on top.
const LEAST_INNER_PIVOT: f64 = 1e-2;

/// Least share of a column's square that may be left of it: what is left has lost half of its digits.
const LEAST_LEFT: f64 = 1e-7;
/// Rows that stay in the nearest memory while each column meets each other.
const ROWS: usize = 256;

/// `J' J` and `J' r`.
#[derive(Debug, Clone, PartialEq)]
pub struct Products {
    gram: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Share of the square of each column that is left of it, where something was taken away.
    left: DVector<f64>,
}

impl Products {
    /// Of a Jacobian `[m, n]` and residuals `[m]`, in one pass over the rows.
    ///
    /// ```
    /// use morpho_fit::optimise::Products;
    /// use nalgebra::{DMatrix, DVector};
    /// let products = Products::new(&DMatrix::from_row_slice(2, 1, &[3.0, 4.0]), &DVector::from_vec(vec![1.0, -1.0]));
    /// assert_eq!((products.length(0), products.gradient()[0]), (5.0, -1.0));
    /// ```
    #[must_use]
    pub fn new(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> Self {
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
        Self { gram, gradient, left: DVector::from_element(n, 1.0) }
    }

    /// `J' J`, of which the lower triangle is read, and `J' r` as they were summed up elsewhere.
    pub(crate) fn of_sums(gram: DMatrix<f64>, gradient: DVector<f64>) -> Self {
        let left = DVector::from_element(gradient.len(), 1.0);
        Self { gram, gradient, left }
    }

    /// Takes away what the columns have along others: `J' J - along' (inner)⁻¹ along`, where `inner` are the products of
    /// these others and `along` theirs with the columns, `[q, n]`. The residuals have no part along them.
    ///
    /// `None` where the others depend on each other, or where less than a ten-millionth of a column's square is left.
    pub(crate) fn without(mut self, inner: DMatrix<f64>, along: &DMatrix<f64>) -> Option<Self> {
        let q = inner.nrows();
        let all: Vec<usize> = (0..q).collect();
        let (r, _) = Self::of_sums(inner, DVector::zeros(q)).triangle_above(&all, LEAST_INNER_PIVOT)?;
        let rotated = r.tr_solve_upper_triangular(along)?;
        let before = self.gram.diagonal();
        self.gram -= rotated.tr_mul(&rotated);
        self.left =
            self.gram.diagonal().zip_map(&before, |left, before| if before > 0.0 { left / before } else { 1.0 });
        self.left.iter().all(|&left| left > LEAST_LEFT).then_some(self)
    }

    /// `J' r`.
    #[must_use]
    pub fn gradient(&self) -> &DVector<f64> {
        &self.gradient
    }

    /// Euclidean length of column `j`.
    #[must_use]
    pub fn length(&self, j: usize) -> f64 {
        self.gram[(j, j)].sqrt()
    }

    /// `(R, Q' r)` of the QR decomposition of some columns; `None` if they are so nearly dependent, or so small or large, that
    /// their products do not hold them.
    pub(crate) fn triangle(&self, columns: &[usize]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        self.triangle_above(columns, LEAST_PIVOT)
    }

    fn triangle_above(&self, columns: &[usize], least: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let n = columns.len();
        let lengths = DVector::from_fn(n, |c, _| self.length(columns[c]));
        if lengths.iter().any(|length| !(1e-100..1e100).contains(length)) {
            return None;
        }
        let unit = DMatrix::from_fn(n, n, |a, b| self.gram[(columns[a], columns[b])] / (lengths[a] * lengths[b]));
        let lower = Cholesky::new(unit)?.l();
        // What was taken away before has cost digits already.
        let lost = |(&pivot, &column): (&f64, &usize)| pivot * self.left[column].sqrt() < least;
        if lower.diagonal().iter().zip(columns).any(lost) {
            return None;
        }
        let scaled = DVector::from_fn(n, |c, _| self.gradient[columns[c]] / lengths[c]);
        let rotated = lower.solve_lower_triangular(&scaled)?;
        Some((DMatrix::from_fn(n, n, |a, b| lower[(b, a)] * lengths[b]), rotated))
    }
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
        // Once more takes away what rounding has left.
        for _ in 0..2 {
            let along = DVector::from_fn(columns.ncols(), |j, _| dot(column(j), target.as_slice()));
            let solved = factor.as_ref().and_then(|r| r.solve_upper_triangular(&r.tr_solve_upper_triangular(&along)?));
            let Some(solved) = solved else {
                let q = columns.clone().qr().q();
                let along = q.tr_mul(&target);
                target -= q * along;
                break;
            };
            for (j, share) in solved.iter().enumerate() {
                for (out, value) in target.iter_mut().zip(column(j)) {
                    *out -= share * value;
                }
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
        assert_relative_eq!(*products.gradient(), jacobian.tr_mul(&residuals), max_relative = 1e-13);
        let (r, b) = products.triangle(&[2, 0]).unwrap();
        let qr = jacobian.select_columns(&[2, 0]).qr();
        let signs = DMatrix::from_diagonal(&qr.r().diagonal().map(f64::signum));
        assert_relative_eq!(r, &signs * qr.r(), max_relative = 1e-12, epsilon = 1e-12);
        let rotated = &signs * qr.q().tr_mul(&residuals);
        assert_relative_eq!(b, rotated, max_relative = 1e-12, epsilon = 1e-12);
    }

    #[test]
    fn what_others_take_away_is_their_projection() {
        let wave = |i: usize| ((1 + i) as f64 * 0.37).sin();
        let columns = DMatrix::from_fn(40, 2, |i, j| wave(i + 1 + 7 * j * i));
        let matrix = DMatrix::from_fn(40, 3, |i, j| wave(i * (j + 2)));
        let taken = |matrix: &DMatrix<f64>, columns: &DMatrix<f64>| {
            let products = Products::new(matrix, &DVector::zeros(matrix.nrows()));
            products.without(columns.tr_mul(columns), &columns.tr_mul(matrix))
        };
        let left = taken(&matrix, &columns).unwrap();
        let expected = without_columns(matrix.clone(), &columns);
        assert_relative_eq!(left.gram, expected.tr_mul(&expected), epsilon = 1e-12);
        // A column that is one of those taken away leaves nothing to tell.
        assert_eq!(taken(&columns, &columns), None);
        // Two columns that are told apart by what is taken away alone have no factor, however little each of them loses.
        for (near, size) in [(3e-4, 5e-4), (1e-3, 5e-4), (1e-2, 3e-4), (0.1, 1e-3)] {
            let others =
                DMatrix::from_fn(40, 2, |i, j| columns[(i, 0)] + if j == 1 { near * columns[(i, 1)] } else { 0.0 });
            let parallel = DMatrix::from_fn(40, 2, |i, j| columns[(i, j)] + size * (1.0 + j as f64) * matrix[(i, 0)]);
            let factor = taken(&parallel, &others).and_then(|left| left.triangle(&[0, 1]));
            assert_eq!(factor, None, "{near} {size}");
        }
    }

    #[test]
    fn what_is_left_of_a_projection_is_orthogonal_to_it() {
        let wave = |i: usize| ((1 + i) as f64 * 0.37).sin();
        let matrix = DMatrix::from_fn(700, 3, |i, j| wave(i * (j + 2)));
        let basis = DMatrix::from_fn(700, 2, |i, j| wave([i + 1, 3 * i][j]));
        let projected = basis.clone().svd(true, false).u.unwrap();
        let expected = &matrix - &projected * projected.tr_mul(&matrix);
        // The same plane by columns far from dependent, and so nearly dependent that QR stands in.
        for near in [1.0, 3e-4, 1e-5] {
            let columns =
                DMatrix::from_fn(700, 2, |i, j| basis[(i, 0)] + if j == 1 { near * basis[(i, 1)] } else { 0.0 });
            let left = without_columns(matrix.clone(), &columns);
            let (along, error) = (basis.tr_mul(&left).amax(), (&left - &expected).amax());
            assert!(along < 1e-8 && error < 1e-9, "{near}: {along:e} {error:e}");
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
