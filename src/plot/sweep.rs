//! Colour against a parameter of the structure: a strip at one angle, and the chart over the viewing angle beside the
//! reflectivity.

use super::atlas::edges_around;
use super::contour::contour;
use super::{ColourGrid, ColourMap, Figure, HeatMap, LineSeries, Panel, PlotError, PointSeries, VerticalLine, check};

const CHART: &str = "sweep";
/// Columns or rows at most.
pub const CELLS: usize = 1000;
const STRIP_SIZE: (f64, f64) = (720.0, 96.0);
const CHART_SIZE: (f64, f64) = (470.0, 400.0);
/// Marks of colours outside the gamut stand in every so many-th column and row.
const MARKS: usize = 22;
/// Part of the width below which an end of an interval would touch its value.
const APART: f64 = 0.008;
const BLACK: usize = 6;
/// Colours of the marks of fits, which must be seen on any colour.
const FITS: [usize; 4] = [6, 1, 4, 3];

/// The colours of a sweep, as a display shows them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sweep {
    /// First line of the charts.
    pub title: String,
    /// Second line of the charts.
    pub subtitle: String,
    /// What varies across, with its unit.
    pub x_label: String,
    /// Its values, ascending, 2 to 1000.
    pub x: Vec<f64>,
    /// What varies upwards, with its unit.
    pub y_label: String,
    /// Its values, likewise.
    pub y: Vec<f64>,
    /// Colours of the chart; empty where the model has no answer.
    pub cells: Vec<Option<Cell>>,
    /// What the strip shows, such as `θ = 0°`.
    pub strip_label: String,
    /// What became of the colours outside sRGB, for the legend.
    pub outside: String,
    /// Colours of the strip.
    pub strip: Vec<Option<Cell>>,
    /// Wavelengths of the reflectivity that belongs to the strip, nm, ascending.
    pub wavelengths: Vec<f64>,
    /// The reflectivity; not a number where the model has no answer.
    pub reflectivity: Vec<f64>,
    /// Measured values of what varies across.
    pub fits: Vec<FitMark>,
}

/// One colour of a display.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// Encoded red, green and blue.
    pub bytes: [u8; 3],
    /// Whether the display cannot show the colour itself.
    pub outside: bool,
}

/// A value that a fit found, with its interval.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FitMark {
    /// Name in the legend, with the value.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Ends of its interval; none where it is open.
    pub interval: [Option<f64>; 2],
}

/// The strip: the colours at one angle.
///
/// # Shape
/// `strip: [columns]`.
///
/// # Errors
/// As [`sweep_figure`].
pub fn strip_figure(sweep: &Sweep) -> Result<Figure, PlotError> {
    check::count(CHART, "columns", (2, CELLS), sweep.x.len())?;
    check::length(CHART, "colours of the strip", sweep.x.len(), sweep.strip.len())?;
    let panel = Panel {
        bare_y: true,
        title: format!("at {}", sweep.strip_label),
        x_label: sweep.x_label.clone(),
        vertical_lines: upright(&sweep.fits, &sweep.x),
        ..coloured(&sweep.x, &[0.5], &sweep.strip, &sweep.outside)
    };
    Ok(Figure {
        title: sweep.title.clone(),
        subtitle: sweep.subtitle.clone(),
        panels: vec![panel],
        columns: None,
        plot_size: Some(STRIP_SIZE),
    })
}

/// The chart of colours, and beside it the reflectivity that makes those of the strip.
///
/// Dots and an outline mark the colours that the display cannot show.
///
/// # Shape
/// `cells: [y][x]`, the lowest y first; `reflectivity: [wavelength][x]`.
///
/// # Errors
/// [`PlotError::Count`] for less than 2 or more than [`CELLS`] values on a side, [`PlotError::Unequal`] if there is not one
/// colour for each cell; the axes are checked when the figure is drawn.
pub fn sweep_figure(sweep: &Sweep) -> Result<Figure, PlotError> {
    for (what, values) in [("columns", &sweep.x), ("rows", &sweep.y), ("wavelengths", &sweep.wavelengths)] {
        check::count(CHART, what, (2, CELLS), values.len())?;
    }
    check::length(CHART, "colours", sweep.x.len() * sweep.y.len(), sweep.cells.len())?;
    check::length(CHART, "reflectivities", sweep.x.len() * sweep.wavelengths.len(), sweep.reflectivity.len())?;
    let chart = Panel {
        title: "colour".to_owned(),
        x_label: sweep.x_label.clone(),
        y_label: sweep.y_label.clone(),
        vertical_lines: upright(&sweep.fits, &sweep.x),
        ..coloured(&sweep.x, &sweep.y, &sweep.cells, &sweep.outside)
    };
    let heat = HeatMap {
        x_edges: edges_around(&sweep.x),
        y_edges: edges_around(&sweep.wavelengths),
        values: sweep.reflectivity.clone(),
        label: "reflectivity".to_owned(),
        colours: ColourMap::Viridis,
        ..HeatMap::default()
    };
    let spectra = Panel {
        title: format!("reflectivity at {}", sweep.strip_label),
        x_label: sweep.x_label.clone(),
        y_label: "wavelength / nm".to_owned(),
        heat: Some(heat),
        vertical_lines: upright(&sweep.fits, &sweep.x),
        ..Panel::default()
    };
    Ok(Figure {
        title: sweep.title.clone(),
        subtitle: sweep.subtitle.clone(),
        panels: vec![chart, spectra],
        columns: Some(2),
        plot_size: Some(CHART_SIZE),
    })
}

/// The cells at the middles `x` and `y`, with dots and an outline named `marked` for those that are not the colour itself.
///
/// A single row is one unit high.
pub(crate) fn coloured(x: &[f64], y: &[f64], cells: &[Option<Cell>], marked: &str) -> Panel {
    let colours = cells.iter().map(|cell| cell.map(|cell| cell.bytes)).collect();
    let y_edges = if let [middle] = y { vec![middle - 0.5, middle + 0.5] } else { edges_around(y) };
    let outside: Vec<f64> = cells.iter().map(|cell| f64::from(u8::from(is_outside(cell)))).collect();
    let (outline_x, outline_y) = contour(x, y, &outside, 0.5);
    Panel {
        colours: Some(ColourGrid { x_edges: edges_around(x), y_edges, colours }),
        points: marks(x, y, &outside, marked),
        lines: vec![LineSeries { x: outline_x, y: outline_y, colour: BLACK, width: 1.0, ..LineSeries::default() }],
        ..Panel::default()
    }
}

fn is_outside(cell: &Option<Cell>) -> bool {
    cell.is_some_and(|cell| cell.outside)
}

/// Dots on colours that sRGB cannot show, at most 22 across and upwards, and one in the middle of each
/// run in a row that would have none.
fn marks(x: &[f64], y: &[f64], outside: &[f64], name: &str) -> Vec<PointSeries> {
    let every = |count: usize| count.div_ceil(MARKS).max(1);
    let (across, up) = (every(x.len()), every(y.len()));
    let mut dots = PointSeries { name: name.to_owned(), colour: BLACK, ..PointSeries::default() };
    let rows = y.iter().zip(outside.chunks(x.len().max(1)));
    for (&y, row) in rows.skip(up / 2).step_by(up) {
        let mut start = 0;
        while start < row.len() {
            let length = row[start..].iter().take_while(|&&outside| outside > 0.5).count();
            let columns = start..start + length;
            let mut marked: Vec<usize> = columns.clone().filter(|column| column % across == across / 2).collect();
            if marked.is_empty() && length > 0 {
                marked.push(start + length / 2);
            }
            dots.x.extend(marked.iter().filter_map(|&column| x.get(column)));
            dots.y.extend(marked.iter().map(|_| y));
            start += length.max(1);
        }
    }
    if dots.x.is_empty() { Vec::new() } else { vec![dots] }
}

/// A line at the value of each fit, and dashed ones at the ends of its interval where they stand apart from it.
fn upright(fits: &[FitMark], x: &[f64]) -> Vec<VerticalLine> {
    let width = x.last().zip(x.first()).map_or(0.0, |(last, first)| last - first);
    let mut lines = Vec::new();
    for (fit, colour) in fits.iter().zip(FITS.into_iter().cycle()) {
        lines.push(VerticalLine { name: fit.name.clone(), x: fit.value, colour, dashed: false });
        for end in fit.interval.into_iter().flatten().filter(|end| (end - fit.value).abs() > APART * width) {
            lines.push(VerticalLine { name: "ends of the interval".to_owned(), x: end, colour, dashed: true });
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    fn sweep() -> Sweep {
        let cell = |outside| Some(Cell { bytes: [10, 20, 200], outside });
        Sweep {
            x: vec![100.0, 120.0, 140.0],
            y: vec![0.0, 30.0],
            cells: vec![cell(true), cell(false), None, cell(true), cell(true), cell(false)],
            outside: "outside sRGB".into(),
            strip: vec![cell(true), None, cell(false)],
            wavelengths: vec![400.0, 500.0],
            reflectivity: vec![0.1, f64::NAN, 0.2, 0.4, 0.3, 0.0],
            fits: vec![FitMark { name: "a fit".into(), value: 121.0, interval: [Some(118.0), None] }],
            ..Sweep::default()
        }
    }

    #[test]
    fn colours_that_cannot_be_shown_are_marked() {
        let figure = sweep_figure(&sweep()).unwrap();
        let dots = &figure.panels[0].points[0];
        assert_eq!((&dots.x, &dots.y), (&vec![100.0, 100.0, 120.0], &vec![0.0, 30.0, 30.0]));
        let svg = draw(&figure).unwrap().svg;
        assert!(svg.contains("outside sRGB") && svg.contains("a fit") && svg.to_lowercase().contains("#0a14c8"));
        assert!(draw(&strip_figure(&sweep()).unwrap()).unwrap().svg.contains("outside sRGB"));
    }

    #[test]
    fn a_missing_colour_is_an_error_and_not_a_shift() {
        let short = Sweep { cells: vec![None; 5], ..sweep() };
        assert!(matches!(sweep_figure(&short), Err(PlotError::Unequal { .. })));
        let narrow = Sweep { x: vec![1.0], strip: vec![None], ..sweep() };
        assert!(matches!(strip_figure(&narrow), Err(PlotError::Count { .. })));
    }
}
