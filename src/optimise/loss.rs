//! Loss functions that let outliers count for less.

use serde::{Deserialize, Serialize};

/// How a residual `z` (in units of its standard deviation) enters the cost `sum rho(z)`.
///
/// `rho` is scaled so that it equals `z²` for small `z`. Fits by iteratively reweighted least squares use
/// [`weight`](Self::weight) `= rho'(z) / (2 z)`: each reweighted step lowers the robust cost, because each `rho` is concave
/// in `z²`.
///
/// # Source
/// Triggs et al. 2000, *Bundle adjustment: a modern synthesis*, section 3.3; the same scaling as `scipy.optimize.least_squares`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Loss {
    /// `z²`: ordinary least squares.
    #[default]
    Linear,
    /// `2 (sqrt(1 + z²) - 1)`.
    SoftL1,
    /// `z²` up to 1, then `2 |z| - 1`.
    Huber,
    /// `ln(1 + z²)`.
    Cauchy,
}

impl Loss {
    /// `rho(z)`, at least 0.
    ///
    /// ```
    /// use morpho_fit::optimise::Loss;
    /// assert_eq!(Loss::Huber.rho(3.0), 5.0);
    /// ```
    #[must_use]
    pub fn rho(self, z: f64) -> f64 {
        let square = z * z;
        match self {
            Self::Linear => square,
            Self::SoftL1 => 2.0 * square / ((1.0 + square).sqrt() + 1.0),
            Self::Huber if square <= 1.0 => square,
            Self::Huber => 2.0 * z.abs() - 1.0,
            Self::Cauchy => square.ln_1p(),
        }
    }

    /// `psi'(z)` of the influence `psi(z) = z · weight(z)`: how fast a residual's pull grows.
    #[must_use]
    pub fn influence_slope(self, z: f64) -> f64 {
        let square = z * z;
        match self {
            Self::Linear => 1.0,
            Self::SoftL1 => (1.0 + square).powf(-1.5),
            Self::Huber => f64::from(u8::from(square <= 1.0)),
            Self::Cauchy => (1.0 - square) / (1.0 + square).powi(2),
        }
    }

    /// Weight of the squared residual in reweighted least squares, in (0, 1].
    #[must_use]
    pub fn weight(self, z: f64) -> f64 {
        let square = z * z;
        match self {
            Self::Linear => 1.0,
            Self::SoftL1 => 1.0 / (1.0 + square).sqrt(),
            Self::Huber if square <= 1.0 => 1.0,
            Self::Huber => 1.0 / z.abs(),
            Self::Cauchy => 1.0 / (1.0 + square),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn each_weight_is_the_slope_of_its_loss() {
        for loss in [Loss::Linear, Loss::SoftL1, Loss::Huber, Loss::Cauchy] {
            for z in [1e-4, 0.3, 0.9, 1.1, 5.0, 80.0] {
                let step = 1e-6 * z;
                let slope = (loss.rho(z + step) - loss.rho(z - step)) / (2.0 * step);
                assert_relative_eq!(loss.weight(z), slope / (2.0 * z), max_relative = 1e-6);
                let pull = |z: f64| z * loss.weight(z);
                let slope = (pull(z + step) - pull(z - step)) / (2.0 * step);
                assert_relative_eq!(loss.influence_slope(z), slope, max_relative = 1e-6, epsilon = 1e-9);
            }
            assert_relative_eq!(loss.rho(1e-6), 1e-12, max_relative = 1e-9);
        }
    }
}
