//! The likelihood of the structure alone: scale, weight and background integrated over.
//!
//! ```text
//! integral over c >= 0 of exp(-(y - f - B c)²/(2 s²)) sqrt(det(B'B)/s²) dc  ~  exp(-chi²_min/(2 s²)) P(c >= 0)
//! ```
//!
//! with weighted data y, known part f and columns B: the integral over all c is a Gaussian one, and `P(c >= 0)` is the
//! share of that Gaussian, about the unconstrained best c, where no coefficient is negative.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::outcome::Fit;
use crate::inversion::parameter::inside;
use crate::inversion::rows::Weighted;
use crate::inversion::space::Space;
use crate::inversion::undetermined::unit_of_residuals;
use crate::numerics::normal::{density, distribution};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A coefficient this many standard deviations above 0 is not held back by it.
const FREE: f64 = 7.0;

/// What is known of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Noise {
    /// Standard deviation of a weighted residual.
    Known(f64),
    /// Unknown, with the prior `1/sigma`.
    Unknown {
        /// The best guess, which decides how far coefficients are from 0.
        unit: f64,
        /// Readings that count as independent, for each reading.
        independent: f64,
    },
}

impl Noise {
    pub(crate) fn of(data: &Dataset, fit: &Fit) -> Self {
        let unit = fit.solution.unit;
        // The weights of a robust loss leave no likelihood to integrate sigma over.
        if data.has_sigma() || !fit.solution.robust.is_empty() {
            return Self::Known(unit);
        }
        let scatter = unit_of_residuals(data, fit.outcome.chi2, fit.outcome.dof);
        Self::Unknown { unit, independent: (scatter / unit).powi(2).min(1.0) }
    }
}

/// The logarithm of the likelihood as a function of the free parameters.
#[derive(Debug)]
pub(crate) struct Likelihood<'a> {
    compiled: &'a Compiled<'a>,
    space: &'a Space,
    weighted: Weighted<'a>,
    noise: Noise,
}

impl<'a> Likelihood<'a> {
    pub(crate) fn new(compiled: &'a Compiled<'a>, space: &'a Space, robust: &'a [f64], noise: Noise) -> Self {
        Self { compiled, space, weighted: compiled.plan.rows.weighted(robust), noise }
    }

    /// Up to a constant; NaN where the model has no value.
    pub(crate) fn log(&self, free: &DVector<f64>) -> f64 {
        let values = self.space.freedom.expand(free);
        if !inside(&values) {
            return f64::NAN;
        }
        let plan = &self.compiled.plan;
        let terms = plan.terms(&values);
        let parts = plan.rows.parts(terms.view(), &self.weighted.weights);
        let sums = self.compiled.linear.normal_equations(&plan.rows, &parts, &self.weighted);
        let factors = sums.factors();
        let best = factors.as_ref().map_or_else(|| sums.solve(), |factors| sums.unconstrained(factors));
        let chi2 = sums.sum_of_squares(&best);
        let (unit, deviance) = match self.noise {
            Noise::Known(unit) => (unit, chi2 / (unit * unit)),
            Noise::Unknown { unit, independent } => {
                #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
                let count = plan.len().saturating_sub(best.len()) as f64;
                (unit, independent * count * chi2.max(f64::MIN_POSITIVE).ln())
            }
        };
        -0.5 * deviance + factors.map_or(0.0, |factors| log_positive(&best, &factors, unit))
    }
}

/// `ln P(c >= 0)` for `c` normal about `mean` with covariance `unit² (factors)⁻¹`.
///
/// One coefficient after the other is cut at 0, and the others take on the mean and covariance that this leaves them.
///
/// # Source
/// Mendell and Elston 1974, DOI 10.2307/2529268; exact for one coefficient near 0, and for several that do not correlate.
fn log_positive(mean: &DVector<f64>, factors: &Cholesky<f64, Dyn>, unit: f64) -> f64 {
    let mut covariance: Option<DMatrix<f64>> = None;
    let mut mean = mean.clone();
    let mut sum = 0.0;
    for i in 0..mean.len() {
        let covariance = covariance.get_or_insert_with(|| factors.inverse() * (unit * unit));
        let deviation = covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt();
        let z = mean[i] / deviation;
        if z > FREE {
            continue;
        }
        let share = distribution(z).max(f64::MIN_POSITIVE);
        sum += share.ln();
        let pull = density(z) / share;
        let column: DVector<f64> = covariance.column(i) / deviation;
        mean += &column * pull;
        *covariance -= &column * column.transpose() * (pull * (pull + z));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn log_positive_of(mean: &[f64], covariance: DMatrix<f64>) -> f64 {
        let factors = covariance.try_inverse().unwrap().cholesky().unwrap();
        log_positive(&DVector::from_column_slice(mean), &factors, 1.0)
    }

    #[test]
    fn the_positive_share_of_a_normal_distribution() {
        assert_abs_diff_eq!(log_positive_of(&[0.0], DMatrix::identity(1, 1)), 0.5_f64.ln(), epsilon = 1e-12);
        assert_abs_diff_eq!(log_positive_of(&[0.0, 0.0], DMatrix::identity(2, 2)), 0.25_f64.ln(), epsilon = 1e-12);
        assert_abs_diff_eq!(log_positive_of(&[20.0, 30.0], DMatrix::identity(2, 2)), 0.0, epsilon = 1e-12);
        // Sheppard 1899: P(x > 0, y > 0) = 1/4 + asin(rho)/(2 pi) for zero means.
        for rho in [-0.6_f64, -0.2, 0.3, 0.7] {
            let exact = 0.25 + rho.asin() / std::f64::consts::TAU;
            let covariance = DMatrix::from_row_slice(2, 2, &[1.0, rho, rho, 1.0]);
            assert_abs_diff_eq!(log_positive_of(&[0.0, 0.0], covariance), exact.ln(), epsilon = 0.05);
        }
    }
}
