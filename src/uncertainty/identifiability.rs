//! Which parameters, and which combinations of them, the data can tell.
//!
//! The columns of the Jacobian are put in units of each parameter's range, so that the singular values `s` of
//!
//! ```text
//! J · diag(range),   residuals in units of their standard deviation,
//! ```
//!
//! are comparable: along the direction of `s` the data hold the parameters to `1 / s` of their ranges.

use crate::numerics::singular::right_singular;
use nalgebra::{DMatrix, DVector};

/// Singular values below this share of the largest are zero up to the error of differences.
const STRUCTURAL: f64 = 1e-8;
/// A direction known to no better than this share of the range is not determined: an even guess over the range has a
/// standard deviation of `1/sqrt(12) = 0.29` of it.
const PRACTICAL: f64 = 0.29;
/// A parameter with a smaller share in a direction is no part of it.
const SHARE: f64 = 0.05;

/// One direction of parameter space and how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Components in units of each parameter's range, of length 1.
    pub components: DVector<f64>,
    /// Standard deviation along it, in the same units; infinite if the data say nothing, up to rounding.
    pub deviation: f64,
}

impl Direction {
    /// Indices of the parameters that take part in it, the strongest first.
    #[must_use]
    pub fn parts(&self) -> Vec<usize> {
        let mut parts: Vec<usize> = (0..self.components.len()).collect();
        parts.sort_by(|&a, &b| self.components[b].abs().total_cmp(&self.components[a].abs()));
        let largest = parts.first().map_or(0.0, |&first| self.components[first].abs());
        parts.retain(|&j| self.components[j].abs() >= SHARE * largest);
        parts
    }
}

/// What the data can tell about a set of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Identifiability {
    /// All directions, the best known first.
    pub directions: Vec<Direction>,
    /// How many of them are determined.
    pub rank: usize,
    /// Largest over smallest singular value; infinite if the smallest is 0.
    pub condition: f64,
}

impl Identifiability {
    /// Analyses a Jacobian.
    ///
    /// - `jacobian`: derivatives of residuals in units of their standard deviation, `[m, n]`.
    /// - `ranges`: width of each parameter's range, `[n]`, above 0.
    #[must_use]
    pub fn new(jacobian: &DMatrix<f64>, ranges: &DVector<f64>) -> Self {
        let n = jacobian.ncols();
        let mut scaled = jacobian.clone();
        for (mut column, &range) in scaled.column_iter_mut().zip(ranges) {
            column.scale_mut(range);
            if !column.iter().all(|value| value.is_finite()) {
                column.fill(0.0);
            }
        }
        let mut directions: Vec<Direction> = Vec::with_capacity(n);
        if let Some((values, vectors)) = right_singular(&scaled) {
            for (k, &value) in values.iter().enumerate() {
                let deviation = if value > 0.0 { value.recip() } else { f64::INFINITY };
                directions.push(Direction { components: vectors.row(k).transpose(), deviation });
            }
        }
        directions.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
        let best = directions.first().map_or(f64::INFINITY, |direction| direction.deviation);
        let worst = directions.last().map_or(f64::INFINITY, |direction| direction.deviation);
        let determined =
            |direction: &&Direction| direction.deviation < PRACTICAL && direction.deviation * STRUCTURAL < best;
        let rank = directions.iter().filter(determined).count();
        for direction in &mut directions {
            if direction.deviation * STRUCTURAL >= best {
                direction.deviation = f64::INFINITY;
            }
        }
        Self { directions, rank, condition: if worst.is_finite() { worst / best } else { f64::INFINITY } }
    }

    /// Directions that the data do not determine, the worst last.
    #[must_use]
    pub fn undetermined(&self) -> &[Direction] {
        &self.directions[self.rank..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_is_told_and_its_split_is_not() {
        // Two parameters that enter only as their sum, and one that does nothing.
        let jacobian = DMatrix::from_fn(10, 3, |i, j| if j < 2 { 100.0 + i as f64 } else { 0.0 });
        let found = Identifiability::new(&jacobian, &DVector::from_element(3, 1.0));
        assert_eq!(found.rank, 1);
        assert!(found.condition.is_infinite());
        let mut parts: Vec<Vec<usize>> = found.undetermined().iter().map(Direction::parts).collect();
        parts.iter_mut().for_each(|part| part.sort_unstable());
        parts.sort();
        assert_eq!(parts, [vec![0, 1], vec![2]]);
    }

    #[test]
    fn a_direction_known_no_better_than_a_guess_is_not_determined() {
        let jacobian = DMatrix::from_diagonal(&DVector::from_vec(vec![10.0, 1.0]));
        let found = Identifiability::new(&jacobian, &DVector::from_element(2, 1.0));
        assert_eq!(found.rank, 1);
        assert_eq!(found.undetermined()[0].parts(), [1]);
    }
}
