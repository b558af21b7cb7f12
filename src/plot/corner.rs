//! The corner chart of a posterior: a histogram of each quantity, and below it each pair of them.

use super::contour::contour;
use super::histogram::{bins, counts, edges, enclosing_level, grid_counts, quantile, smoothed};
use super::panels::factor;
use super::{BarSeries, ColourMap, Figure, HeatMap, LineSeries, Panel, PlotError, VerticalLine, check};

const CHART: &str = "corner";
/// Quantities at most; more are too small to read.
pub const QUANTITIES: usize = 8;
/// Bins of a histogram, and of one side of a two-dimensional one.
const BINS: (usize, usize) = (10, 40);
const GRID_BINS: (usize, usize) = (10, 28);
/// Air beside the samples, as a part of their range.
const AIR: f64 = 0.04;
/// The central interval that is marked: plus and minus one standard deviation of a normal distribution.
const CENTRAL: f64 = 0.6827;
/// Shares inside the two contours.
const CONTOURS: [(&str, f64, f64); 2] =
    [("68 % of the samples within", 0.68, 1.6), ("95 % of the samples within", 0.95, 1.0)];

/// Names up to so many characters are repeated in the heading.
const LONGEST_HEADING: usize = 18;

const SAMPLES: usize = 0;
const BEST: usize = 1;
const TRUTH: usize = 2;
const INK: usize = 6;

/// Samples of several quantities with what is to be marked in them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Corner {
    /// First line of the chart.
    pub title: String,
    /// Second line of the chart.
    pub subtitle: String,
    /// Names with units, such as `d_air / nm`; 1 to 8.
    pub names: Vec<String>,
    /// The samples of each quantity, all equally many, finite.
    pub samples: Vec<Vec<f64>>,
    /// The value of each quantity at the best fit.
    pub best: Option<Vec<f64>>,
    /// The true value of each quantity, where data were simulated.
    pub truths: Option<Vec<f64>>,
    /// Ends of the interval of each quantity; none for the central 68.27 % of the samples.
    pub intervals: Option<Vec<(f64, f64)>>,
}

/// One quantity, ready to be drawn.
struct Column<'a> {
    name: &'a str,
    samples: &'a [f64],
    sorted: Vec<f64>,
    /// First and last sample, a little apart if they are equal: the bins lie between.
    binned: (f64, f64),
    /// What the panels show.
    shown: (f64, f64),
    interval: (f64, f64),
    best: Option<f64>,
    truth: Option<f64>,
}

/// Histograms with the interval and the best value on the diagonal, below them the pairs with contours.
///
/// Every sample is in a bin. The heading of a histogram has the median and the distances to the ends of the interval.
/// Contours enclose the highest cells of the histogram, smoothed over one cell, that hold the share of the samples.
///
/// # Shape
/// `samples: [quantities][samples]`; the other lists have one entry for each quantity.
///
/// # Errors
/// [`PlotError::Count`] unless there are 1 to [`QUANTITIES`] names and a sample; [`PlotError::Unequal`] if a list has
/// another length; [`PlotError::Unusable`] for a value that is not finite or beyond 1e300.
///
/// ```
/// use morpho_fit::plot::{corner::{Corner, corner_figure}, draw};
///
/// let samples = Corner {
///     names: vec!["d_air / nm".into(), "d_cuticle / nm".into()],
///     samples: vec![vec![139.0, 141.0, 140.0, 142.0], vec![63.0, 61.0, 62.5, 60.0]],
///     best: Some(vec![140.5, 61.8]),
///     ..Corner::default()
/// };
/// let picture = draw(&corner_figure(&samples)?)?;
/// assert!(picture.svg.contains("d_cuticle / nm"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
pub fn corner_figure(corner: &Corner) -> Result<Figure, PlotError> {
    validate(corner)?;
    let columns: Vec<Column<'_>> = (0..corner.names.len()).filter_map(|index| column(corner, index)).collect();
    let count = columns.len();
    let mut panels = Vec::with_capacity(count * count);
    for (row, y) in columns.iter().enumerate() {
        for (across, x) in columns.iter().enumerate() {
            let panel = match across.cmp(&row) {
                std::cmp::Ordering::Less => pair(x, y),
                std::cmp::Ordering::Equal => histogram(x),
                std::cmp::Ordering::Greater => Panel { blank: true, ..Panel::default() },
            };
            // Names and numbers stand at the outer sides only.
            let lowest = row + 1 == count;
            let outer = across == 0 && row > 0;
            panels.push(Panel {
                x_label: if lowest { x.name.to_owned() } else { String::new() },
                y_label: if outer { y.name.to_owned() } else { String::new() },
                bare_x: !lowest,
                bare_y: !outer,
                ..panel
            });
        }
    }
    let side = match count {
        1 => (420.0, 280.0),
        2 => (280.0, 240.0),
        3 => (230.0, 190.0),
        4 => (190.0, 165.0),
        _ => (160.0, 140.0),
    };
    Ok(Figure {
        title: corner.title.clone(),
        subtitle: corner.subtitle.clone(),
        panels,
        columns: Some(count),
        plot_size: Some(side),
    })
}

fn validate(corner: &Corner) -> Result<(), PlotError> {
    let count = corner.names.len();
    check::count(CHART, "quantities", (1, QUANTITIES), count)?;
    check::length(CHART, "samples", count, corner.samples.len())?;
    let samples = corner.samples.first().map_or(0, Vec::len);
    check::count(CHART, "samples", (1, usize::MAX), samples)?;
    for (name, values) in corner.names.iter().zip(&corner.samples) {
        check::length(CHART, name, samples, values.len())?;
        check::drawable(CHART, name, values)?;
    }
    for (what, values) in [("best", &corner.best), ("truths", &corner.truths)] {
        if let Some(values) = values {
            check::length(CHART, what, count, values.len())?;
            check::drawable(CHART, what, values)?;
        }
    }
    if let Some(intervals) = &corner.intervals {
        check::length(CHART, "intervals", count, intervals.len())?;
        for &(low, high) in intervals {
            check::drawable(CHART, "intervals", &[low, high])?;
        }
    }
    Ok(())
}

fn column(corner: &Corner, index: usize) -> Option<Column<'_>> {
    let samples = corner.samples.get(index)?;
    let mut sorted = samples.clone();
    sorted.sort_by(f64::total_cmp);
    let (&first, &last) = (sorted.first()?, sorted.last()?);
    let binned = apart(first, last);
    let value = |values: &Option<Vec<f64>>| values.as_ref().and_then(|values| values.get(index).copied());
    let (best, truth) = (value(&corner.best), value(&corner.truths));
    let central = || (quantile(&sorted, 0.5 - CENTRAL / 2.0), quantile(&sorted, 0.5 + CENTRAL / 2.0));
    let given = corner.intervals.as_ref().and_then(|intervals| intervals.get(index).copied());
    let interval = given.unwrap_or_else(central);
    let marked = [best, truth, Some(interval.0), Some(interval.1)].into_iter().flatten();
    let (low, high) = marked.fold(binned, |(low, high), value| (low.min(value), high.max(value)));
    let air = AIR * (high - low);
    let shown = (low - air, high + air);
    Some(Column { name: corner.names.get(index)?, samples, binned, shown, interval, best, truth, sorted })
}

/// A range in which bins can be told apart.
fn apart(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > 1e-9 * size && high - low > 1e-302 {
        return (low, high);
    }
    let room = if size > 1e-302 { 1e-3 * size } else { 1.0 };
    (low - room, high + room)
}

fn histogram(column: &Column<'_>) -> Panel {
    let bins = bins(&column.sorted, BINS);
    let heights = counts(column.samples, column.binned, bins);
    let top = 1.08 * heights.iter().copied().fold(1.0, f64::max);
    let bars = BarSeries { name: String::new(), edges: edges(column.binned, bins), heights, colour: SAMPLES };
    let end = |x| VerticalLine { name: "interval".to_owned(), x, colour: INK, dashed: true };
    let mut vertical_lines = vec![end(column.interval.0), end(column.interval.1)];
    for (name, x, colour) in [("best fit", column.best, BEST), ("truth", column.truth, TRUTH)] {
        vertical_lines.extend(x.map(|x| VerticalLine { name: name.to_owned(), x, colour, dashed: false }));
    }
    Panel {
        title: heading(column),
        bars: vec![bars],
        vertical_lines,
        x_range: Some(column.shown),
        y_range: Some((0.0, top)),
        ..Panel::default()
    }
}

/// `d_air: 141.2 +1.3 −1.1`, with two figures in the distances. The unit stands at the axes, a long name as well.
fn heading(column: &Column<'_>) -> String {
    let values = spread(quantile(&column.sorted, 0.5), column.interval);
    match column.name.split(" / ").next() {
        Some(name) if name.chars().count() <= LONGEST_HEADING => format!("{name}: {values}"),
        _ => values,
    }
}

/// A value with the distances to the ends of its interval; very large and very small ones with a power of ten.
fn spread(value: f64, (low, high): (f64, f64)) -> String {
    let (above, below) = (high - value, low - value);
    let size = value.abs().max(above.abs()).max(below.abs());
    let power = if size > 0.0 && !(1e-3..1e6).contains(&size) { size.log10().floor() } else { 0.0 };
    // In two steps: ten to the -308 has no inverse.
    let scaled = |value: f64| value / 10f64.powf(power / 2.0) / 10f64.powf(power / 2.0);
    let distances = [scaled(above).abs(), scaled(below).abs()];
    let smallest = distances.into_iter().filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min);
    let finest = if smallest.is_finite() { smallest } else { 1e-2 };
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped from 0 to 8")]
    let places = (1.0 - finest.log10().floor()).clamp(0.0, 8.0) as usize;
    let text = format!("{:.places$} {:+.places$} {:+.places$}", scaled(value), scaled(above), scaled(below));
    let text = text.replace('-', "−");
    #[allow(clippy::cast_possible_truncation, reason = "the power of ten of a double")]
    let factor = factor(power as i64);
    if factor.is_empty() { text } else { format!("({text}) {factor}") }
}

fn pair(x: &Column<'_>, y: &Column<'_>) -> Panel {
    let bins = bins(&x.sorted, GRID_BINS).max(bins(&y.sorted, GRID_BINS));
    let counts = grid_counts(x.samples, y.samples, [x.binned, y.binned], bins);
    let lines = outlines(x, y, &smoothed(&counts, bins), bins);
    // Cells without a sample stay paper.
    let highest = counts.iter().copied().fold(1.0, f64::max);
    let values = counts.into_iter().map(|count| if count > 0.0 { count } else { f64::NAN }).collect();
    let heat = HeatMap {
        x_edges: edges(x.binned, bins),
        y_edges: edges(y.binned, bins),
        values,
        colours: ColourMap::White,
        range: Some((-0.1 * highest, 1.15 * highest)),
        ..HeatMap::default()
    };
    let mut panel =
        Panel { heat: Some(heat), x_range: Some(x.shown), y_range: Some(y.shown), lines, ..Panel::default() };
    for (name, x_value, y_value, colour) in [("best fit", x.best, y.best, BEST), ("truth", x.truth, y.truth, TRUTH)] {
        let cross = [(x_value, y.shown, true), (y_value, x.shown, false)];
        for (value, (low, high), upright) in cross {
            let Some(value) = value else { continue };
            let (along, across) = (vec![low, high], vec![value; 2]);
            let (x, y) = if upright { (across, along) } else { (along, across) };
            panel.lines.push(LineSeries { name: name.to_owned(), x, y, colour, dashed: false, width: 1.2 });
        }
    }
    panel
}

/// The contours around the middles of the cells.
fn outlines(x: &Column<'_>, y: &Column<'_>, smooth: &[f64], bins: usize) -> Vec<LineSeries> {
    let middles = |(low, high): (f64, f64)| -> Vec<f64> {
        let step = (high - low) / bins as f64;
        (0..bins + 4).map(|cell| low + (cell as f64 - 1.5) * step).collect()
    };
    let (across, up) = (middles(x.binned), middles(y.binned));
    let outline = |&(name, share, width): &(&str, f64, f64)| {
        let level = enclosing_level(smooth, share)?;
        let (x, y) = contour(&across, &up, smooth, level);
        Some(LineSeries { name: name.to_owned(), x, y, colour: INK, dashed: false, width })
    };
    CONTOURS.iter().filter_map(outline).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    fn corner(samples: Vec<Vec<f64>>) -> Corner {
        let names = (0..samples.len()).map(|index| format!("quantity {index} / nm")).collect();
        Corner { title: "title".into(), names, samples, ..Corner::default() }
    }

    /// Points of a low-discrepancy sequence: the golden ratio and its square.
    fn samples(count: usize) -> Vec<Vec<f64>> {
        let golden = 0.618_033_988_749_894_9_f64;
        let column = |step: f64| (0..count).map(|i| (step * i as f64).fract()).collect();
        vec![column(golden), column(golden * golden * 3.0), column(0.414_213_562)]
    }

    #[test]
    fn every_sample_lands_in_a_bin() {
        let figure = corner_figure(&corner(samples(500))).unwrap();
        assert_eq!((figure.panels.len(), figure.panels.iter().filter(|panel| panel.blank).count()), (9, 3));
        for panel in figure.panels.iter().filter(|panel| !panel.blank) {
            let in_bars: f64 = panel.bars.iter().flat_map(|bars| &bars.heights).sum();
            let cells = panel.heat.iter().flat_map(|heat| &heat.values);
            let in_cells: f64 = cells.filter(|value| !value.is_nan()).sum();
            assert!((in_bars + in_cells - 500.0).abs() < 1e-9);
        }
    }

    #[test]
    fn names_and_marks_are_in_the_picture() {
        let marked = Corner {
            best: Some(vec![0.5; 3]),
            truths: Some(vec![0.4, 0.5, 3.0]),
            intervals: Some(vec![(0.2, 0.9); 3]),
            ..corner(samples(200))
        };
        let svg = draw(&corner_figure(&marked).unwrap()).unwrap().svg;
        for text in ["title", "quantity 0 / nm", "quantity 2 / nm", "best fit", "truth", "interval"] {
            assert!(svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(svg.contains("95 % of the samples within"));
    }

    #[test]
    fn the_interval_of_equally_spaced_samples_is_the_central_share() {
        let column = (0..10_001).map(|i| f64::from(i) / 10_000.0).collect();
        let figure = corner_figure(&corner(vec![column])).unwrap();
        let ends: Vec<f64> = figure.panels[0].vertical_lines.iter().map(|line| line.x).collect();
        assert!((ends[0] - 0.15865).abs() < 1e-9 && (ends[1] - 0.84135).abs() < 1e-9, "{ends:?}");
    }

    #[test]
    fn a_heading_has_two_figures_in_its_distances() {
        assert_eq!(spread(141.23, (139.9, 142.5)), "141.2 +1.3 −1.3");
        assert_eq!(spread(1.5e-4, (1.48e-4, 1.53e-4)), "(1.500 +0.030 −0.020) ×10⁻⁴");
        assert_eq!(spread(300.0, (275.0, 325.0)), "300 +25 −25");
        assert_eq!(spread(0.0, (0.0, 0.0)), "0.000 +0.000 +0.000");
    }

    #[test]
    fn odd_samples_are_drawn() {
        for values in [vec![2.0; 7], vec![0.0], vec![-1e300, 1e300, 0.0], vec![5e-324, 0.0], vec![1.0, 1.0 + 1e-15]] {
            let figure = corner_figure(&corner(vec![values.clone(), values])).unwrap();
            assert_eq!(draw(&figure).unwrap(), draw(&figure).unwrap());
        }
    }

    #[test]
    fn contradictions_are_errors() {
        let message = |corner: &Corner| corner_figure(corner).unwrap_err().to_string();
        assert_eq!(message(&corner(vec![])), "corner chart: 0 quantities, where 1 to 8 can be drawn");
        assert!(message(&corner(vec![vec![1.0]; 9])).contains("9 quantities"));
        assert!(matches!(corner_figure(&corner(vec![vec![]])), Err(PlotError::Count { found: 0, .. })));
        let ragged = corner(vec![vec![1.0, 2.0], vec![1.0]]);
        assert_eq!(message(&ragged), "corner chart: 1 values of quantity 1 / nm, but 2 are needed");
        let missing = corner(vec![vec![1.0, f64::NAN]]);
        assert_eq!(message(&missing), "corner chart: value 1 of quantity 0 / nm is NaN, which cannot be drawn");
        let best = Corner { best: Some(vec![]), ..corner(vec![vec![1.0]]) };
        assert!(matches!(corner_figure(&best), Err(PlotError::Unequal { .. })));
        let open = Corner { intervals: Some(vec![(0.0, f64::INFINITY)]), ..corner(vec![vec![1.0]]) };
        assert!(matches!(corner_figure(&open), Err(PlotError::Unusable { .. })));
    }
}
