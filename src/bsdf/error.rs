//! Why there is no `.bsdf` file, or none that can be used.

use crate::colorimetry::ColourError;
use crate::optics::OpticsError;

/// A `.bsdf` file that cannot be read, or one that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BsdfError {
    /// The file does not begin as a tensor file does.
    #[error("byte 0: this is no tensor file; a `.bsdf` file begins with the text `tensor_file`")]
    NotATensorFile,
    /// A version that is not 1.0.
    #[error("byte 12: version {major}.{minor} of the format; version 1.0 is read")]
    Version {
        /// First number of the version.
        major: u8,
        /// Second number.
        minor: u8,
    },
    /// The file ends before what it announces.
    #[error("byte {offset}: the file is cut short: {what} needs {needed} bytes from there, and the file has {length}")]
    CutShort {
        /// Where it should begin.
        offset: u64,
        /// What should stand there.
        what: String,
        /// Its bytes.
        needed: u64,
        /// Bytes of the file.
        length: u64,
    },
    /// A name that is none.
    #[error("byte {offset}: the name of a field is {problem}")]
    Name {
        /// Where the name begins.
        offset: u64,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A number that stands for no type of elements.
    #[error("byte {offset}: field `{name}`: {code} is no type of elements; there are 1 to 11")]
    Element {
        /// Where the number stands.
        offset: u64,
        /// Name of the field.
        name: String,
        /// What stands there.
        code: u8,
    },
    /// More elements than can be counted.
    #[error("byte {offset}: field `{name}`: a shape of more elements than can be counted")]
    ShapeOverflow {
        /// Where the shape begins.
        offset: u64,
        /// Name of the field.
        name: String,
    },
    /// Values that lie in the head, or over one another.
    #[error("byte {offset}: the values of field `{name}` lie over other parts of the file")]
    Overlap {
        /// Where the values should begin.
        offset: u64,
        /// Name of the field.
        name: String,
    },
    /// A tensor that the format has no room for, or whose values do not fill its shape.
    #[error("field `{name}`: {problem}")]
    Tensor {
        /// Name of the field.
        name: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A tensor file without a field that a material has.
    #[error("field `{name}` is missing; a measured material has it")]
    Missing {
        /// Name of the field.
        name: &'static str,
    },
    /// A field of another type or shape.
    #[error("field `{name}` has the shape {found:?}, or other elements than it should; {expected}")]
    Shape {
        /// Name of the field.
        name: &'static str,
        /// Its shape.
        found: Vec<usize>,
        /// What is needed.
        expected: &'static str,
    },
    /// A value that cannot be used.
    #[error("field `{name}`, value {index}: {found} {problem}")]
    Value {
        /// Name of the field.
        name: &'static str,
        /// Number of the value, from 0.
        index: usize,
        /// The value.
        found: f32,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A direction where the file has no value, as its projected area is 0 there.
    #[error("the field `sigma` is 0 for light from {theta_deg:.3}° off the normal: there is no value")]
    NoArea {
        /// Angle from the normal, degrees.
        theta_deg: f64,
    },
    /// A direction that is none.
    #[error("the direction ({}, {}, {}) is no unit vector", found[0], found[1], found[2])]
    Direction {
        /// What was given.
        found: [f64; 3],
    },
    /// A file with other channels than asked for.
    #[error("{0}")]
    Channels(&'static str),
    /// A number of nodes that makes no table.
    #[error("{count} {axis} make no table; {least} to {most} do")]
    Nodes {
        /// What is counted.
        axis: &'static str,
        /// How many were asked for.
        count: usize,
        /// The fewest.
        least: usize,
        /// The most.
        most: usize,
    },
    /// A setting out of range.
    #[error("{quantity} is {found}; it must be {allowed}")]
    Setting {
        /// Which.
        quantity: &'static str,
        /// What was given.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A tolerance that asks for more bytes than are allowed.
    #[error(
        "with {bytes} bytes the table is still off by {rms:.2e} of its peak, {tolerance:.2e} is asked for, and {most} bytes are allowed"
    )]
    TooLarge {
        /// Bytes of the largest table that was tried.
        bytes: u64,
        /// Its root mean square error, a share of the peak.
        rms: f64,
        /// What was asked for.
        tolerance: f64,
        /// Bytes that are allowed.
        most: u64,
    },
    /// A structure that reflects nothing.
    #[error("the structure reflects nothing in any direction that was tried: there is no peak to hold a table against")]
    Dark,
    /// The model refuses a direction, or has no answer there.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A colour is none.
    #[error(transparent)]
    Colour(#[from] ColourError),
}
