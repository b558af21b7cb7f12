//! What can be wrong with a chart.

use std::error::Error;

/// Why a chart could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The figure has no panel.
    #[error("figure `{figure}` has no panel: give it at least one")]
    NoPanels {
        /// Title of the figure.
        figure: String,
    },
    /// A grid of zero columns was asked for.
    #[error("figure `{figure}` asks for 0 columns: give at least 1, or none to have the number chosen")]
    NoColumns {
        /// Title of the figure.
        figure: String,
    },
    /// The coordinates of a series are not pairs.
    #[error("panel `{panel}`, series `{series}`: {x} values of x but {found} of {what}; there must be one for each x")]
    LengthMismatch {
        /// Title of the panel.
        panel: String,
        /// Name of the series.
        series: String,
        /// What has another length: `y` or `sigma`.
        what: &'static str,
        /// Number of x values.
        x: usize,
        /// Number of the other values.
        found: usize,
    },
    /// A requested range runs backwards.
    #[error("panel `{panel}`: the range of {axis} runs from {low} down to {high}; the first must be the smaller")]
    ReversedRange {
        /// Title of the panel.
        panel: String,
        /// `x` or `y`.
        axis: &'static str,
        /// The requested start.
        low: f64,
        /// The requested end.
        high: f64,
    },
    /// A line would be drawn with a width that is not positive.
    #[error("panel `{panel}`, series `{series}`: the line width {width} is not a positive number")]
    LineWidth {
        /// Title of the panel.
        panel: String,
        /// Name of the series.
        series: String,
        /// The requested width, in picture units.
        width: f64,
    },
    /// The picture has no area, or more than can be drawn.
    #[error("a picture of {width} x {height} cannot be drawn: both sides must be at least 1 and at most {largest}")]
    PictureSize {
        /// Requested width, in picture units.
        width: f64,
        /// Requested height, in picture units.
        height: f64,
        /// The longest allowed side.
        largest: u32,
    },
    /// The embedded font is damaged.
    #[error("the embedded {style} font could not be read; this is a bug of the program, please report it")]
    Font {
        /// `normal` or `bold`.
        style: &'static str,
    },
    /// The drawing library failed.
    #[error("the {format} picture could not be drawn")]
    Drawing {
        /// `SVG` or `PNG`.
        format: &'static str,
        /// What the drawing library said.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The pixels could not be packed.
    #[error("the PNG picture could not be encoded")]
    Encoding {
        /// What the encoder said.
        source: Box<dyn Error + Send + Sync>,
    },
}
