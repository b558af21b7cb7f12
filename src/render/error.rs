//! Why there is no picture.

use super::raster::{MOST_PIXELS, MOST_SIDE};
use crate::colorimetry::ColourError;
use crate::optics::OpticsError;

/// A picture that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The model refuses the structure, or has no answer.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A colour is none.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// A model that is a sum of planes, and has no value for directions in general.
    #[error("the model `{name}` knows directions in one plane only; a picture needs `hybrid`")]
    Planes {
        /// Name of the model.
        name: &'static str,
    },
    /// A number out of range.
    #[error("{quantity} is {found}; allowed: {allowed}")]
    OutOfRange {
        /// What the number is, with its unit.
        quantity: &'static str,
        /// What was given.
        found: f64,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// An image file that cannot be read.
    #[error("not a PNG that can be read: {problem}")]
    Png {
        /// What is wrong.
        problem: String,
    },
    /// An image without pixels, or with too many.
    #[error("{width} × {height} pixels; allowed: 1 to {MOST_SIDE} each way, at most {MOST_PIXELS} in all")]
    Size {
        /// Pixels across.
        width: usize,
        /// Pixels upwards.
        height: usize,
    },
    /// A raster whose values are not as many as its size says, or not finite.
    #[error("an image of {width} × {height} pixels needs {channels} finite values each")]
    Values {
        /// Pixels across.
        width: usize,
        /// Pixels upwards.
        height: usize,
        /// Values of a pixel.
        channels: usize,
    },
    /// Two maps that do not lie on each other.
    #[error(
        "the {map} map is {} × {} pixels, the {other} map {} × {}; maps of one wing have the same size", found.0, found.1, needed.0, needed.1
    )]
    Mismatch {
        /// The map that differs.
        map: &'static str,
        /// Its size.
        found: (usize, usize),
        /// The map that it is held against.
        other: &'static str,
        /// The size of that one.
        needed: (usize, usize),
    },
    /// A mask that is 0 everywhere.
    #[error("the mask has no wing anywhere: its alpha, or its grey where it has none, is 0 in every pixel")]
    NoWing,
    /// A tolerance that more nodes than are allowed would meet.
    #[error("with {nodes} nodes a colour is still off by ΔE₀₀ {worst:.2}, and {tolerance} is asked for")]
    TooLarge {
        /// Nodes of the largest lookup that was tried.
        nodes: usize,
        /// Its largest difference.
        worst: f64,
        /// What was asked for.
        tolerance: f64,
    },
}
