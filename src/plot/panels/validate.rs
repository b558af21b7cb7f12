//! What a figure must not contradict.

use super::super::PlotError;
use super::super::canvas::LARGEST_SIDE;
use super::axis::is_drawable;
use super::{BarSeries, ColourScale, Figure, HeatMap, Label, LabelStyle, Panel};

/// The shortest side of a plot, in picture units: two tick labels and the air between them.
const SHORTEST_SIDE: f64 = 60.0;
/// A longer text would need a badge that covers the chart.
const BADGE_LENGTH: usize = 3;

/// Checks the figure against the descriptions of its fields.
pub(super) fn validate(figure: &Figure) -> Result<(), PlotError> {
    if figure.panels.is_empty() {
        return Err(PlotError::NoPanels { figure: figure.title.clone() });
    }
    if figure.columns == Some(0) {
        return Err(PlotError::NoColumns { figure: figure.title.clone() });
    }
    if let Some((width, height)) = figure.plot_size {
        let (shortest, longest) = (SHORTEST_SIDE, f64::from(LARGEST_SIDE));
        if ![width, height].iter().all(|side| (shortest..=longest).contains(side)) {
            return Err(PlotError::PlotSize { figure: figure.title.clone(), width, height, shortest, longest });
        }
    }
    figure.panels.iter().try_for_each(panel)
}

fn panel(panel: &Panel) -> Result<(), PlotError> {
    for (axis, range) in [("x", panel.x_range), ("y", panel.y_range)] {
        if let Some((low, high)) = range.filter(|(low, high)| low.is_finite() && high.is_finite() && low > high) {
            return Err(PlotError::ReversedRange { panel: panel.title.clone(), axis, low, high });
        }
    }
    let paired = |series: &str, what, x: usize, found: usize| {
        let mismatch =
            PlotError::LengthMismatch { panel: panel.title.clone(), series: series.to_owned(), what, x, found };
        if x == found { Ok(()) } else { Err(mismatch) }
    };
    for points in &panel.points {
        paired(&points.name, "y", points.x.len(), points.y.len())?;
        if let Some(sigma) = &points.sigma {
            paired(&points.name, "sigma", points.x.len(), sigma.len())?;
        }
    }
    for line in &panel.lines {
        paired(&line.name, "y", line.x.len(), line.y.len())?;
        if !(line.width.is_finite() && line.width > 0.0) {
            let (panel, series) = (panel.title.clone(), line.name.clone());
            return Err(PlotError::LineWidth { panel, series, width: line.width });
        }
    }
    let long = |label: &&Label| label.style != LabelStyle::Remark && label.text.chars().count() > BADGE_LENGTH;
    if let Some(label) = panel.labels.iter().find(long) {
        let (panel, text) = (panel.title.clone(), label.text.clone());
        return Err(PlotError::BadgeLength { panel, text, most: BADGE_LENGTH });
    }
    panel.bars.iter().try_for_each(|series| bars(&panel.title, series))?;
    panel.heat.iter().try_for_each(|map| heat(&panel.title, map))?;
    panel.colours.iter().try_for_each(|grid| {
        edges(&panel.title, "colours", &grid.x_edges)?;
        edges(&panel.title, "colours", &grid.y_edges)?;
        cells(&panel.title, "colours", (grid.x_edges.len() - 1) * (grid.y_edges.len() - 1), grid.colours.len())
    })
}

fn bars(panel: &str, bars: &BarSeries) -> Result<(), PlotError> {
    edges(panel, &bars.name, &bars.edges)?;
    cells(panel, &bars.name, bars.edges.len() - 1, bars.heights.len())
}

fn heat(panel: &str, heat: &HeatMap) -> Result<(), PlotError> {
    edges(panel, &heat.label, &heat.x_edges)?;
    edges(panel, &heat.label, &heat.y_edges)?;
    cells(panel, &heat.label, heat.columns().saturating_mul(heat.rows()), heat.values.len())?;
    let Some((low, high)) = heat.range else { return Ok(()) };
    let positive = heat.scale == ColourScale::Linear || low > 0.0;
    if is_drawable(low) && is_drawable(high) && low < high && positive {
        return Ok(());
    }
    Err(PlotError::ColourRange { panel: panel.to_owned(), series: heat.label.clone(), low, high })
}

/// At least two edges, each a drawable number above the one before.
fn edges(panel: &str, series: &str, edges: &[f64]) -> Result<(), PlotError> {
    let ascending = edges.iter().zip(edges.iter().skip(1)).all(|(low, high)| low < high);
    if edges.len() >= 2 && ascending && edges.iter().all(|&edge| is_drawable(edge)) {
        return Ok(());
    }
    Err(PlotError::Edges { panel: panel.to_owned(), series: series.to_owned(), found: edges.len() })
}

fn cells(panel: &str, series: &str, cells: usize, found: usize) -> Result<(), PlotError> {
    if cells == found {
        return Ok(());
    }
    Err(PlotError::CellCount { panel: panel.to_owned(), series: series.to_owned(), cells, found })
}
