//! Gaussian quadrature: nodes and weights for an even and for a normal distribution.
//!
//! # Source
//! Golub and Welsch 1969, DOI 10.1090/S0025-5718-69-99647-1: the nodes are the eigenvalues of the symmetric tridiagonal matrix of
//! the polynomials' recurrence, the weights the squares of the first components of its eigenvectors.

use nalgebra::{DMatrix, SymmetricEigen};

/// A node and its share of the whole: the shares of a rule sum up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Where the function is taken.
    pub at: f64,
    /// Share in the mean.
    pub share: f64,
}

/// Nodes for the mean over an even distribution on `[-1, 1]` (Gauss–Legendre), exact for polynomials of degree `2 count - 1`.
///
/// ```
/// use morpho_fit::numerics::quadrature::even;
/// let mean: f64 = even(3).iter().map(|node| node.share * node.at.powi(4)).sum();
/// assert!((mean - 1.0 / 5.0).abs() < 1e-14);
/// ```
#[must_use]
pub fn even(count: usize) -> Vec<Node> {
    golub_welsch(count, |k| k / (4.0 * k * k - 1.0).sqrt())
}

/// Nodes for the mean over a normal distribution of mean 0 and standard deviation 1 (Gauss–Hermite), exact for polynomials of
/// degree `2 count - 1`.
///
/// ```
/// use morpho_fit::numerics::quadrature::normal;
/// let mean: f64 = normal(3).iter().map(|node| node.share * node.at.powi(4)).sum();
/// assert!((mean - 3.0).abs() < 1e-13);
/// ```
#[must_use]
pub fn normal(count: usize) -> Vec<Node> {
    golub_welsch(count, f64::sqrt)
}

/// Equal steps over the same distribution to 4.5 standard deviations: for functions with many fringes within it, where
/// Gauss's rule needs as many nodes and crowds them in the middle.
///
/// ```
/// use morpho_fit::numerics::quadrature::normal_steps;
/// let mean: f64 = normal_steps(33).iter().map(|node| node.share * (3.0 * node.at).cos()).sum();
/// assert!((mean - (-4.5_f64).exp()).abs() < 1e-5);
/// ```
#[must_use]
pub fn normal_steps(count: usize) -> Vec<Node> {
    if count < 2 {
        return vec![Node { at: 0.0, share: 1.0 }];
    }
    #[allow(clippy::cast_precision_loss, reason = "node counts are small")]
    let at = |step: usize| 4.5 * (2.0 * step as f64 / (count - 1) as f64 - 1.0);
    let weight = |step: usize| (-0.5 * at(step) * at(step)).exp();
    let whole: f64 = (0..count).map(weight).sum();
    (0..count).map(|step| Node { at: at(step), share: weight(step) / whole }).collect()
}

/// The rule whose recurrence has `off_diagonal(k)` beside a diagonal of 0.
fn golub_welsch(count: usize, off_diagonal: impl Fn(f64) -> f64) -> Vec<Node> {
    let count = count.max(1);
    let matrix = DMatrix::from_fn(count, count, |i, j| {
        #[allow(clippy::cast_precision_loss, reason = "node counts are small")]
        if i.abs_diff(j) == 1 { off_diagonal(i.max(j) as f64) } else { 0.0 }
    });
    let eigen = SymmetricEigen::new(matrix);
    let node = |i: usize| Node { at: eigen.eigenvalues[i], share: eigen.eigenvectors[(0, i)].powi(2) };
    let mut nodes: Vec<Node> = (0..count).map(node).collect();
    nodes.sort_by(|a, b| a.at.total_cmp(&b.at));
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn five_nodes_are_those_of_the_tables() {
        // Abramowitz and Stegun, tables 25.4 and 25.10 (there for exp(-x²): nodes times sqrt(2), weights over sqrt(pi)).
        let legendre = [(0.0, 0.568_888_888_888_889), (0.538_469_310_105_683, 0.478_628_670_499_366)];
        let hermite = [(0.0, 0.945_308_720_482_9), (0.958_572_464_613_819, 0.393_619_323_152_2)];
        for (place, (at, weight)) in legendre.into_iter().enumerate() {
            let node = even(5)[2 + place];
            assert_abs_diff_eq!(node.at, at, epsilon = 1e-14);
            assert_abs_diff_eq!(node.share, weight / 2.0, epsilon = 1e-14);
        }
        for (place, (at, weight)) in hermite.into_iter().enumerate() {
            let node = normal(5)[2 + place];
            assert_abs_diff_eq!(node.at, at * 2.0_f64.sqrt(), epsilon = 1e-14);
            assert_abs_diff_eq!(node.share, weight / std::f64::consts::PI.sqrt(), epsilon = 1e-13);
        }
    }

    #[test]
    fn one_node_is_the_middle_and_shares_sum_up_to_one() {
        assert_eq!(even(0), even(1));
        assert_abs_diff_eq!(normal(1)[0].at, 0.0, epsilon = 0.0);
        for count in [1, 2, 7, 20] {
            assert_abs_diff_eq!(even(count).iter().map(|node| node.share).sum::<f64>(), 1.0, epsilon = 1e-13);
            assert_abs_diff_eq!(normal(count).iter().map(|node| node.share).sum::<f64>(), 1.0, epsilon = 1e-13);
        }
    }
}
