//! Marks of a panel beyond points and lines: heat maps, bars, upright lines and labels.

/// Colours of a heat map, from the low to the high end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourMap {
    /// From dark blue over green to yellow, in even steps for the eye.
    #[default]
    Viridis,
    /// The same, from yellow to dark blue: low values stand out.
    ViridisReversed,
    /// From white to the first colour of the palette, for shares and densities.
    White,
}

/// How values become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColourScale {
    /// In equal steps.
    #[default]
    Linear,
    /// In equal ratios. Values that are not positive count as the low end.
    Logarithmic,
}

/// Values on a grid of cells, as colours. It fills the panel from edge to edge unless a range is requested.
///
/// # Shape
/// `x_edges: [columns + 1]`, `y_edges: [rows + 1]`, `values: [rows * columns]`, row by row, the row of the lowest y
/// first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HeatMap {
    /// Ends of the columns, finite and ascending.
    pub x_edges: Vec<f64>,
    /// Ends of the rows, likewise.
    pub y_edges: Vec<f64>,
    /// One value for each cell. A cell whose value is not a number is left empty.
    pub values: Vec<f64>,
    /// What the values are, with their unit, beside the colour bar; without it there is no bar.
    pub label: String,
    /// Colours to use.
    pub colours: ColourMap,
    /// How values become colours.
    pub scale: ColourScale,
    /// Values of the first and the last colour; values beyond get the nearest. None for the range of the values.
    pub range: Option<(f64, f64)>,
}

impl HeatMap {
    /// Number of columns of cells.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.x_edges.len().saturating_sub(1)
    }

    /// Number of rows of cells.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.y_edges.len().saturating_sub(1)
    }
}

/// Colours on a grid of cells. It fills the panel from edge to edge unless a range is requested.
///
/// # Shape
/// `x_edges: [columns + 1]`, `y_edges: [rows + 1]`, `colours: [rows * columns]`, row by row, the row of the lowest y
/// first.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ColourGrid {
    /// Ends of the columns, finite and ascending.
    pub x_edges: Vec<f64>,
    /// Ends of the rows, likewise.
    pub y_edges: Vec<f64>,
    /// Encoded red, green and blue of each cell; a cell without a colour is left empty.
    pub colours: Vec<Option<[u8; 3]>>,
}

/// Bars that stand on zero, side by side, as in a histogram. A bar whose height is not finite is left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BarSeries {
    /// Name in the legend; without one the series is not in the legend.
    pub name: String,
    /// Ends of the bars, finite and ascending: one more than there are bars.
    pub edges: Vec<f64>,
    /// Heights of the bars.
    pub heights: Vec<f64>,
    /// Number of the colour, as in [`PointSeries::colour`](super::PointSeries::colour).
    pub colour: usize,
}

/// A line from the lower to the upper end of the panel; not drawn where it would lie outside, or is not finite.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VerticalLine {
    /// Name in the legend; without one the line is not in the legend.
    pub name: String,
    /// Where it stands.
    pub x: f64,
    /// Number of the colour, as in [`PointSeries::colour`](super::PointSeries::colour).
    pub colour: usize,
    /// Dashed instead of solid.
    pub dashed: bool,
}

/// How a label looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LabelStyle {
    /// A remark beside the point, on white.
    #[default]
    Remark,
    /// A dot at the point, and a white badge beside it with a leader, for a number.
    Badge,
    /// The same with a dark badge, for the most important one.
    StrongBadge,
}

/// A text at a point. It keeps free of the other labels of the panel and inside the frame; where there is no room left,
/// or the point lies outside, it is not written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Label {
    /// Name of a badge in the legend; without one, and for a remark, it is not in the legend.
    pub name: String,
    /// Abscissa of the point.
    pub x: f64,
    /// Ordinate of the point.
    pub y: f64,
    /// What is written; in a badge at most 3 characters.
    pub text: String,
    /// How it looks.
    pub style: LabelStyle,
}
