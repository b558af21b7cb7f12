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

/// Akaike's criterion with the correction for small samples, and Bayes's, of a deviance: `-2 log` of the largest likelihood.
///
/// ```text
/// AICc = D + 2 k + 2 k (k + 1)/(n - k - 1),   BIC = D + k ln n
/// ```
///
/// The first is `None` if there are no more than `unknowns + 1` readings.
///
/// # Source
/// Burnham and Anderson 2002, *Model Selection and Multimodel Inference*, §2.4; Schwarz 1978, DOI 10.1214/aos/1176344136.
///
/// ```
/// use morpho_fit::uncertainty::goodness::information_criteria;
/// let (aicc, bic) = information_criteria(10.0, 20, 3);
/// assert_eq!(aicc, Some(10.0 + 6.0 + 24.0 / 16.0));
/// assert!((bic - (10.0 + 3.0 * 20.0_f64.ln())).abs() < 1e-12);
/// ```
#[must_use]
pub fn information_criteria(deviance: f64, readings: usize, unknowns: usize) -> (Option<f64>, f64) {
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let (n, k) = (readings as f64, unknowns as f64);
    let room = n - k - 1.0;
    ((room > 0.0).then(|| deviance + 2.0 * k + 2.0 * k * (k + 1.0) / room), deviance + k * n.ln())
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
    use approx::{assert_abs_diff_eq, assert_relative_eq};

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

    #[test]
    fn criteria_are_those_of_the_closed_form() {
        // Burnham and Anderson 2002, equation 2.11: 100 + 6 + 24/16.
        let (aicc, bic) = information_criteria(100.0, 20, 3);
        assert_relative_eq!(aicc.unwrap(), 107.5, max_relative = 1e-14);
        assert_relative_eq!(bic, 100.0 + 3.0 * 20.0_f64.ln(), max_relative = 1e-14);
        assert_eq!(information_criteria(100.0, 4, 3).0, None);
    }
}
