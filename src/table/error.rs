//! Why there is no table.

use crate::colorimetry::ColourError;
use crate::optics::OpticsError;

/// A table that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// The model refuses a direction, or has no answer there.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A colour is none.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// An axis that is none.
    #[error("the axis of {axis} {problem}")]
    Axis {
        /// `theta`, `phi`, `theta + phi` or `omega`.
        axis: &'static str,
        /// What is wrong, in words.
        problem: &'static str,
    },
    /// A list whose length does not fit.
    #[error("{what}: {found} given, {needed} needed")]
    Length {
        /// What has the length.
        what: &'static str,
        /// What was given.
        found: usize,
        /// What is needed.
        needed: usize,
    },
    /// A tolerance that is no number above 0.
    #[error("a tolerance of {found} is no number above 0")]
    Tolerance {
        /// What was given.
        found: f64,
    },
    /// More nodes than are allowed, before a table could be judged.
    #[error("at least {nodes} nodes would be needed for ΔE₀₀ {tolerance}, and {most} are allowed")]
    TooMany {
        /// Nodes so far.
        nodes: usize,
        /// What was asked for.
        tolerance: f64,
        /// Nodes that are allowed.
        most: usize,
    },
    /// The tolerance asks for more nodes than are allowed.
    #[error(
        "with {nodes} nodes a colour is still off by ΔE₀₀ {worst:.2}, {tolerance} is asked for, and {most} nodes are allowed"
    )]
    TooLarge {
        /// Nodes of the largest table that was tried.
        nodes: usize,
        /// Its largest difference.
        worst: f64,
        /// What was asked for.
        tolerance: f64,
        /// Nodes that are allowed.
        most: usize,
    },
}
