//! Small multiples: a grid of panels with points, lines, bars, heat maps and labels, one title, one legend.
//!
//! The size follows from the number of panels and the length of the texts; long texts are wrapped, never cut.

mod axis;
mod colours;
mod data;
mod heat;
mod labels;
mod layout;
mod legend;
#[cfg(test)]
mod mark_tests;
mod marks;
mod panel;
mod polar;
#[cfg(test)]
mod tests;
mod validate;

pub(super) use axis::factor;
pub use marks::{BarSeries, ColourGrid, ColourMap, ColourScale, HeatMap, Label, LabelStyle, VerticalLine};
pub(super) use polar::ASPECT as POLAR_ASPECT;

use super::PlotError;
use super::canvas::{Picture, picture};

/// A chart: panels in reading order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// First line of the chart, bold; may be empty.
    pub title: String,
    /// What the reader must know besides, under the title; may be empty.
    pub subtitle: String,
    /// The panels, row by row. At least one.
    pub panels: Vec<Panel>,
    /// Panels in a row; none to have it chosen from their number.
    pub columns: Option<usize>,
    /// Width and height of each plot without its labels, in picture units, each at least 60; the panels then stand
    /// close together. None to have it chosen.
    pub plot_size: Option<(f64, f64)>,
}

/// One pair of axes with what is drawn in it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Heading; may be empty.
    pub title: String,
    /// What x is, with its unit: `wavelength / nm`.
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// Ends of the x axis. None, or an end that is not finite, for the range of the data with some air.
    pub x_range: Option<(f64, f64)>,
    /// Ends of the y axis, likewise; the data are those within `x_range`, with their error bars.
    pub y_range: Option<(f64, f64)>,
    /// Measured points.
    pub points: Vec<PointSeries>,
    /// Model lines, drawn above the points.
    pub lines: Vec<LineSeries>,
    /// Heights of dashed lines across the panel, such as zero in a residual plot.
    pub horizontal_lines: Vec<f64>,
    /// Lower and upper ends of shaded bands across the panel, such as plus and minus two sigma.
    pub bands: Vec<(f64, f64)>,
    /// Values on a grid, as colours, behind everything else; there is no other grid then.
    pub heat: Option<HeatMap>,
    /// Cells that show a colour itself, behind everything else; there is no grid then.
    pub colours: Option<ColourGrid>,
    /// Histograms, behind points and lines.
    pub bars: Vec<BarSeries>,
    /// Lines from the bottom to the top, such as the ends of an interval.
    pub vertical_lines: Vec<VerticalLine>,
    /// Texts at points, above everything else.
    pub labels: Vec<Label>,
    /// Rings and spokes about the origin instead of a frame with axes: for lines of `r sin φ` across and `r cos φ`
    /// upwards, φ from -90° to 90°. The rings stand where the ticks of y would.
    pub polar: bool,
    /// The values of x are decimal logarithms, and the ticks name the numbers themselves.
    pub x_in_powers: bool,
    /// The same for y.
    pub y_in_powers: bool,
    /// Leave the numbers at the ticks of x away, as between panels that share an axis.
    pub bare_x: bool,
    /// Leave the numbers at the ticks of y away.
    pub bare_y: bool,
    /// Leave the place of the panel empty.
    pub blank: bool,
}

/// Points, with error bars if `sigma` is given. A point with a value that is not finite is left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointSeries {
    /// Name in the legend; without one the series is not in the legend.
    pub name: String,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates, one for each x.
    pub y: Vec<f64>,
    /// Standard deviations, one for each x; where one is not positive and finite there is no bar.
    pub sigma: Option<Vec<f64>>,
    /// Number of the colour in [`palette::OKABE_ITO`](super::palette::OKABE_ITO); after the last comes the first again.
    pub colour: usize,
}

/// A line through points in the given order, interrupted where a value is not finite.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSeries {
    /// Name in the legend; without one the series is not in the legend.
    pub name: String,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates, one for each x.
    pub y: Vec<f64>,
    /// Number of the colour, as in [`PointSeries::colour`].
    pub colour: usize,
    /// Dashed instead of solid.
    pub dashed: bool,
    /// Width in picture units, positive; 1.8 by default.
    pub width: f64,
}

impl Default for LineSeries {
    fn default() -> Self {
        Self { name: String::new(), x: Vec::new(), y: Vec::new(), colour: 0, dashed: false, width: 1.8 }
    }
}

/// Draws the figure as SVG and PNG.
///
/// Values that are not finite, or beyond 1e300 in size, are left out; a panel without any other says so. Points and
/// lines outside a given range are cut off at the frame. The legend has each name once, in order of appearance; the
/// first series of a name decides how it looks there, so a name should have the same colour in all panels. A
/// point series and a line series of one name share an entry.
///
/// ```
/// use morpho_fit::plot::{Figure, LineSeries, Panel, PointSeries, draw};
///
/// let wavelength = vec![400.0, 450.0, 500.0, 550.0];
/// let measured = PointSeries {
///     name: "measured".into(),
///     x: wavelength.clone(),
///     y: vec![0.21, 0.48, 0.39, 0.12],
///     sigma: Some(vec![0.02; 4]),
///     colour: 0,
/// };
/// let model = LineSeries {
///     name: "model".into(),
///     x: wavelength,
///     y: vec![0.20, 0.47, 0.41, 0.10],
///     colour: 1,
///     ..LineSeries::default()
/// };
/// let panel = Panel {
///     title: "θ = 0°".into(),
///     x_label: "wavelength / nm".into(),
///     y_label: "reflectivity".into(),
///     points: vec![measured],
///     lines: vec![model],
///     ..Panel::default()
/// };
/// let figure = Figure { title: "One curve".into(), panels: vec![panel], ..Figure::default() };
///
/// let picture = draw(&figure)?;
/// assert!(picture.svg.contains("wavelength / nm"));
/// assert!(picture.png.starts_with(b"\x89PNG"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
///
/// # Errors
/// [`PlotError::NoPanels`], [`PlotError::NoColumns`], [`PlotError::PlotSize`], [`PlotError::LengthMismatch`],
/// [`PlotError::ReversedRange`], [`PlotError::LineWidth`], [`PlotError::Edges`], [`PlotError::CellCount`],
/// [`PlotError::ColourRange`] or [`PlotError::BadgeLength`] if the figure contradicts the descriptions of its fields;
/// [`PlotError::PictureSize`] if it has too many panels or too long texts for one picture; the errors of [`picture`].
pub fn draw(figure: &Figure) -> Result<Picture, PlotError> {
    validate::validate(figure)?;
    let layout = layout::Layout::of(figure)?;
    picture(layout.width, layout.height, |canvas| layout.paint(canvas))
}
