//! Linear least squares with non-negative coefficients, from normal equations.

use nalgebra::{Cholesky, DMatrix, DVector};

/// A column whose part outside the others is below this share of its square adds nothing and gets the coefficient 0.
const DEPENDENT: f64 = 1e-12;

/// Coefficients `c >= 0` that minimise `c' G c - 2 b' c`, for a Gram matrix `G = X' X` and `b = X' y`.
///
/// The active-set method of Lawson and Hanson on columns scaled to length 1; of two columns the closed form. A column of length
/// 0 gets 0, and of columns that depend on each other all but one. A coefficient that is 0 is exactly 0.
///
/// # Shape
/// `gram: [q, q]`, `right: [q]`, result `[q]`. Values that are not finite give zeros.
///
/// # Source
/// Lawson and Hanson 1974, *Solving Least Squares Problems*, chapter 23.
///
/// ```
/// use morpho_fit::numerics::nonnegative::solve;
/// use nalgebra::{DMatrix, DVector};
/// let gram = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
/// let found = solve(&gram, &DVector::from_vec(vec![2.0, -3.0]));
/// assert!((found[0] - 1.0).abs() < 1e-14 && found[1] == 0.0);
/// ```
#[must_use]
pub fn solve(gram: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    let q = right.len();
    if q == 2 {
        let found = pair([gram[(0, 0)], gram[(1, 0)], gram[(1, 1)]], [right[0], right[1]]);
        return DVector::from_column_slice(&found);
    }
    let mut coefficients = DVector::zeros(q);
    let length = DVector::from_fn(q, |j, _| gram[(j, j)].sqrt());
    if !(gram.iter().all(|value| value.is_finite()) && right.iter().all(|value| value.is_finite())) {
        return coefficients;
    }
    let mut usable: Vec<usize> = (0..q).filter(|&j| length[j] > 0.0).collect();
    let scaled_gram = |i: usize, j: usize| gram[(i, j)] / (length[i] * length[j]);
    let scaled_right = |j: usize| right[j] / length[j];

    // Most often no bound is active: try that first.
    let mut passive: Vec<usize> = Vec::with_capacity(q);
    if let Some(all) = equality(&usable, scaled_gram, scaled_right)
        && all.iter().all(|&value| value >= 0.0)
    {
        for (c, &j) in usable.iter().enumerate() {
            coefficients[j] = all[c] / length[j];
        }
        return coefficients;
    }
    let mut scaled = DVector::<f64>::zeros(q);
    // Columns whose slope was rounding: they became no coefficient when they entered.
    let mut barred: Vec<usize> = Vec::new();
    for _ in 0..3 * q.max(1) {
        let slope = |j: usize| scaled_right(j) - passive.iter().map(|&i| scaled_gram(j, i) * scaled[i]).sum::<f64>();
        let size =
            right.iter().zip(&length).map(|(b, l)| if *l > 0.0 { (b / l).abs() } else { 0.0 }).fold(0.0, f64::max);
        let steepest = usable
            .iter()
            .copied()
            .filter(|j| !passive.contains(j) && !barred.contains(j))
            .map(|j| (slope(j), j))
            .filter(|(slope, _)| *slope > 1e-14 * size)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, entering)) = steepest else { break };
        passive.push(entering);
        loop {
            let Some(trial) = equality(&passive, scaled_gram, scaled_right) else {
                passive.retain(|&j| j != entering);
                usable.retain(|&j| j != entering);
                break;
            };
            if scaled[entering] <= 0.0 && passive.last() == Some(&entering) && trial[passive.len() - 1] <= 0.0 {
                passive.pop();
                barred.push(entering);
                break;
            }
            // The way to the trial as far as the first coefficient that becomes 0.
            let (mut share, mut first) = (f64::INFINITY, None);
            for (c, &j) in passive.iter().enumerate().filter(|(c, _)| trial[*c] <= 0.0) {
                let own = scaled[j] / (scaled[j] - trial[c]);
                // 0/0 is a coefficient that is 0 already.
                let own = if own.is_finite() { own } else { 0.0 };
                if own < share {
                    (share, first) = (own, Some(j));
                }
            }
            let Some(first) = first else {
                for (c, &j) in passive.iter().enumerate() {
                    scaled[j] = trial[c];
                }
                barred.clear();
                break;
            };
            for (c, &j) in passive.iter().enumerate() {
                scaled[j] += share * (trial[c] - scaled[j]);
            }
            // Rounding may leave a little of the first.
            let stuck = passive.iter().copied().enumerate();
            let stuck = stuck.filter(|(c, j)| *j == first || trial[*c] <= 0.0 && scaled[*j] <= 1e-15);
            let leaving: Vec<usize> = stuck.map(|(_, j)| j).collect();
            for &j in &leaving {
                scaled[j] = 0.0;
            }
            passive.retain(|j| !leaving.contains(j));
            if passive.is_empty() {
                break;
            }
        }
    }
    for j in passive {
        coefficients[j] = scaled[j] / length[j];
    }
    coefficients
}

/// The same for two columns in closed form: the solution without bounds if both are above 0, else the better column alone.
///
/// - `gram`: its elements `[G_11, G_21, G_22]`.
#[must_use]
pub fn pair([first, across, second]: [f64; 3], right: [f64; 2]) -> [f64; 2] {
    if ![first, across, second, right[0], right[1]].into_iter().all(f64::is_finite) {
        return [0.0; 2];
    }
    let usable = [first > 0.0, second > 0.0];
    if usable == [true; 2] {
        // The square of the sine between the columns.
        let apart = 1.0 - (across / first) * (across / second);
        if apart > DEPENDENT {
            let other = (right[1] - across / first * right[0]) / (second * apart);
            // From the other, not by its own formula: of columns nearly alike the sum keeps its digits.
            let one = (right[0] - across * other) / first;
            if one >= 0.0 && other >= 0.0 {
                return [one, other];
            }
        }
    }
    let gain = |j: usize, square: f64| if usable[j] && right[j] > 0.0 { right[j] / square * right[j] } else { 0.0 };
    let gains = [gain(0, first), gain(1, second)];
    if gains[0] >= gains[1] {
        [if gains[0] > 0.0 { right[0] / first } else { 0.0 }, 0.0]
    } else {
        [0.0, right[1] / second]
    }
}

/// Solution on `columns` alone, without bounds; `None` if they depend on each other.
fn equality(
    columns: &[usize],
    gram: impl Fn(usize, usize) -> f64,
    right: impl Fn(usize) -> f64,
) -> Option<DVector<f64>> {
    let matrix = DMatrix::from_fn(columns.len(), columns.len(), |i, j| gram(columns[i], columns[j]));
    let factor = Cholesky::new(matrix)?;
    if factor.l_dirty().diagonal().iter().any(|pivot| pivot * pivot <= DEPENDENT) {
        return None;
    }
    Some(factor.solve(&DVector::from_fn(columns.len(), |c, _| right(columns[c]))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::{prop_assert, proptest};

    #[test]
    fn a_repeated_column_and_an_empty_one_are_left_out() {
        let x = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
        let y = DVector::from_vec(vec![1.0, 2.0, 5.0]);
        let c = solve(&(x.transpose() * &x), &(x.transpose() * &y));
        assert!((c[0] + c[1] - 1.0).abs() < 1e-12 && (c[0] < 1e-300 || c[1] < 1e-300) && c[2] < 1e-300, "{c}");
    }

    /// Two columns and a third that is 0, which the active sets of three columns solve.
    #[test]
    fn the_closed_form_of_two_columns_is_what_the_active_sets_find() {
        let sizes = [0.0, 1e-150, 1e-3, 1.0, 7.0, 1e150];
        // The last three have squared sines of 2e-6, 1e-9 and 2e-12.
        let near = [0.999_999, 1.0 - 5e-10, 1.0 - 1e-12];
        let cosines = [-1.0, -0.999_999, -0.3, 0.0, 0.6, 1.0].into_iter().chain(near);
        let along = [-2.0, -1e-9, 0.0, 0.3, 1.0];
        for first in sizes {
            for second in sizes {
                for (cosine, x) in cosines.clone().flat_map(|cosine| along.map(|x| (cosine, x))) {
                    for y in along {
                        let gram = [first * first, cosine * first * second, second * second];
                        let right = [x * first, y * second];
                        let three = DMatrix::from_row_slice(
                            3,
                            3,
                            &[gram[0], gram[1], 0.0, gram[1], gram[2], 0.0, 0.0, 0.0, 0.0],
                        );
                        let expected = solve(&three, &DVector::from_vec(vec![right[0], right[1], 0.0]));
                        let found = pair(gram, right);
                        let cost = |c: [f64; 2]| {
                            let [c, d] = [c[0] * first, c[1] * second];
                            c * c + 2.0 * cosine * c * d + d * d - 2.0 * (x * c + y * d)
                        };
                        let [low, high] = [cost(found), cost([expected[0], expected[1]])];
                        assert!(found.iter().all(|c| *c >= 0.0), "{gram:?} {right:?}: {found:?}");
                        assert!(
                            (low - high).abs() <= 1e-9 * (1.0 + high.abs()),
                            "{gram:?} {right:?}: {found:?} {expected}"
                        );
                    }
                }
            }
        }
    }

    /// Half of either column, nearly alike: however badly that is told from others, the sum of squares left is 0.
    #[test]
    fn columns_nearly_alike_still_meet_what_they_make() {
        for squared_sine in [1e-3, 1e-6, 1e-9, 2e-12] {
            let cosine = f64::sqrt(1.0 - squared_sine);
            let across = 0.5 * (1.0 + cosine);
            let [c, d] = pair([1.0, cosine, 1.0], [across, across]);
            let left = c * c + 2.0 * cosine * c * d + d * d - 2.0 * across * (c + d) + across;
            assert!(left.abs() < 2e-15, "{squared_sine}: {c}, {d}, {left}");
        }
    }

    #[test]
    fn values_that_are_not_finite_give_zeros() {
        let c = solve(&DMatrix::from_element(1, 1, f64::NAN), &DVector::from_element(1, 1.0));
        assert_eq!(c.as_slice(), &[0.0]);
    }

    proptest! {
        /// The Karush–Kuhn–Tucker conditions, which hold at the minimum and nowhere else.
        #[test]
        fn the_solution_is_optimal(values in proptest::collection::vec(-1.0_f64..1.0, 40)) {
            let x = DMatrix::from_column_slice(8, 4, &values[..32]);
            let y = DVector::from_column_slice(&values[32..]);
            let (gram, right) = (x.transpose() * &x, x.transpose() * &y);
            let c = solve(&gram, &right);
            let slope = &right - &gram * &c;
            for j in 0..4 {
                prop_assert!(c[j] >= 0.0);
                prop_assert!(slope[j] <= 1e-9, "a column outside would help: {slope}");
                prop_assert!((c[j] * slope[j]).abs() <= 1e-9, "a column inside is not at its best: {slope}");
            }
        }
    }
}
