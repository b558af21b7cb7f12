//! What a run of the sampler is given, and what it refuses.

use nalgebra::{DMatrix, DVector};

/// Approximation of the density about one of its modes, such as the covariance at a minimum of chi².
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Where it is, `[d]`; it may lie on or outside the box.
    pub centre: DVector<f64>,
    /// Its covariance, `[d, d]`, in the units of the parameters. One that is singular or indefinite is made thin, with
    /// its variances kept.
    pub covariance: DMatrix<f64>,
    /// Logarithm of its share of the probability, up to a constant common to all modes.
    pub log_weight: f64,
}

/// How long and with what to sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SamplerSettings {
    /// Independent ensembles, at least 1; with fewer than 4, agreement between them means less.
    pub ensembles: usize,
    /// Effective samples wanted, in bulk and tails of every parameter.
    pub effective: f64,
    /// Calls of the target at most.
    pub max_evaluations: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        Self { ensembles: 4, effective: 2000.0, max_evaluations: 1_000_000, seed: 0 }
    }
}

/// Modes or settings that cannot be sampled with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SamplerError {
    /// Nothing to start from.
    #[error("there are no modes or no parameters to sample")]
    Empty,
    /// A mode is of another dimension than the box.
    #[error(
        "mode {mode} has a centre of {centre} and a covariance of {rows} by {columns}, the box {bounds} parameters"
    )]
    Dimension {
        /// Which mode, from 0.
        mode: usize,
        /// Length of its centre.
        centre: usize,
        /// Rows of its covariance.
        rows: usize,
        /// Columns of its covariance.
        columns: usize,
        /// Parameters of the box.
        bounds: usize,
    },
    /// A centre, covariance or weight is not finite, or a variance is not above 0.
    #[error("mode {mode} has a value that is not finite, or a variance that is not above 0")]
    Mode {
        /// Which mode, from 0.
        mode: usize,
    },
    /// A setting is out of its range.
    #[error("{setting} must be a finite number above 0")]
    Setting {
        /// Its name.
        setting: &'static str,
    },
}
