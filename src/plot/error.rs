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
    /// The plots of a figure would be too small to read or too large to draw.
    #[error("figure `{figure}`: plots of {width} x {height}; both sides must be from {shortest} to {longest}")]
    PlotSize {
        /// Title of the figure.
        figure: String,
        /// Requested width, in picture units.
        width: f64,
        /// Requested height, in picture units.
        height: f64,
        /// The shortest allowed side.
        shortest: f64,
        /// The longest allowed side.
        longest: f64,
    },
    /// The edges of bars or cells do not enclose any, or not in order.
    #[error("panel `{panel}`, `{series}`: the {found} edges must be at least 2, finite and ascending")]
    Edges {
        /// Title of the panel.
        panel: String,
        /// Name of the bars, or label of the heat map.
        series: String,
        /// Number of edges.
        found: usize,
    },
    /// There is not one value for each bar or cell.
    #[error("panel `{panel}`, `{series}`: the edges enclose {cells} cells, but there are {found} values")]
    CellCount {
        /// Title of the panel.
        panel: String,
        /// Name of the bars, or label of the heat map.
        series: String,
        /// Number of cells between the edges.
        cells: usize,
        /// Number of values.
        found: usize,
    },
    /// The range of the colours is none.
    #[error("panel `{panel}`, `{series}`: colours from {low} to {high}; they must rise, a logarithmic scale above 0")]
    ColourRange {
        /// Title of the panel.
        panel: String,
        /// Label of the heat map.
        series: String,
        /// Value of the first colour.
        low: f64,
        /// Value of the last colour.
        high: f64,
    },
    /// The text of a badge is too long for it.
    #[error("panel `{panel}`: the badge `{text}` has more than {most} characters; put the rest into its name")]
    BadgeLength {
        /// Title of the panel.
        panel: String,
        /// The text.
        text: String,
        /// The largest number of characters.
        most: usize,
    },
    /// A chart has too few or too many of something.
    #[error("{chart} chart: {found} {what}, where {least} to {most} can be drawn")]
    Count {
        /// Kind of the chart.
        chart: &'static str,
        /// What was counted.
        what: String,
        /// The smallest number that can be drawn.
        least: usize,
        /// The largest number that can be drawn.
        most: usize,
        /// The given number.
        found: usize,
    },
    /// Lists that belong together differ in length.
    #[error("{chart} chart: {found} values of {what}, but {expected} are needed")]
    Unequal {
        /// Kind of the chart.
        chart: &'static str,
        /// What has another length.
        what: String,
        /// The length of the others.
        expected: usize,
        /// Its own length.
        found: usize,
    },
    /// A number cannot be drawn, or is outside the range that its field allows.
    #[error("{chart} chart: value {index} of {what} is {value}, which cannot be drawn")]
    Unusable {
        /// Kind of the chart.
        chart: &'static str,
        /// Whose value it is.
        what: String,
        /// Its place, counted from 0.
        index: usize,
        /// The value.
        value: f64,
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
