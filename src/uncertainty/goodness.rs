//! How well a sum of squares agrees with its degrees of freedom, and how wide an interval small samples need.

/// Standard normal quantile of a two-sided interval of 68.3 % (one standard deviation).
pub const ONE_SIGMA: f64 = 1.0;
/// Standard normal quantile of a two-sided interval of 95 %.
pub const NINETY_FIVE: f64 = 1.959_963_984_540_054;

/// By how many standard deviations `chi2` exceeds what `dof` degrees of freedom allow; below 0 if it is smaller.
///
/// ```text
/// z = ((chi²/dof)^(1/3) - (1 - 2/(9 dof))) / sqrt(2/(9 dof))
/// ```
///
/// # Source
/// Wilson and Hilferty 1931, DOI 10.1073/pnas.17.12.684: chi² to the power 1/3 is nearly normal. Good to 0.05 for
/// `dof >= 3`.
///
/// ```
/// use morpho_fit::uncertainty::goodness::excess;
/// assert!((excess(124.342, 100) - 1.645).abs() < 0.01); // the 95 % point of chi² with 100 degrees of freedom
/// ```
#[must_use]
pub fn excess(chi2: f64, dof: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let dof = dof.max(1) as f64;
    let variance = 2.0 / (9.0 * dof);
    ((chi2 / dof).cbrt() - (1.0 - variance)) / variance.sqrt()
}

/// Quantile of Student's t for the probability of the standard normal quantile `z`.
///
/// # Source
/// The expansion of Fisher and Cornish, Abramowitz and Stegun 26.7.5. Good to 0.3 % for `dof >= 4` and 95 %.
///
/// ```
/// use morpho_fit::uncertainty::goodness::{NINETY_FIVE, student};
/// assert!((student(NINETY_FIVE, 10) - 2.228).abs() < 0.002);
/// ```
#[must_use]
pub fn student(z: f64, dof: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let nu = dof.max(1) as f64;
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / nu + second / (nu * nu) + third / nu.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn quantiles_of_student_agree_with_the_tables() {
        // Abramowitz and Stegun, table 26.10, two-sided 95 %.
        for (dof, table) in [(4, 2.776), (10, 2.228), (30, 2.042), (120, 1.980)] {
            assert_abs_diff_eq!(student(NINETY_FIVE, dof), table, epsilon = 0.01);
        }
    }

    #[test]
    fn the_95_per_cent_points_of_chi_squared_are_1_645_deviations_out() {
        // Abramowitz and Stegun, table 26.8.
        for (dof, table) in [(3, 7.815), (10, 18.307), (30, 43.773), (100, 124.342)] {
            assert_abs_diff_eq!(excess(table, dof), 1.645, epsilon = 0.05);
        }
    }
}
