//! Cells of heat maps and of grids of colours. All lengths are picture units.

use plotters::style::RGBColor;

use super::super::canvas::Canvas;
use super::colours::Colours;
use super::data::Plot;
use super::panel::Place;
use super::{ColourGrid, HeatMap};

/// Cells reach so far under the next ones, so that no paper shows between them where edges fall between two pixels.
const UNDERLAP: f64 = 0.75;

/// Draws a heat map inside the frame.
pub(super) fn paint(canvas: &mut Canvas, plot: &Plot<'_>, heat: &HeatMap) {
    let Some(colours) = Colours::of(heat) else { return };
    let cells: Vec<_> = heat.values.iter().map(|&value| colours.number(value).map(|n| colours.colour(n))).collect();
    cells_inside(canvas, plot, (&heat.x_edges, &heat.y_edges), &cells);
}

/// Draws a grid of colours inside the frame.
pub(super) fn paint_colours(canvas: &mut Canvas, plot: &Plot<'_>, grid: &ColourGrid) {
    let cells: Vec<_> = grid.colours.iter().map(|cell| cell.map(|[r, g, b]| RGBColor(r, g, b))).collect();
    cells_inside(canvas, plot, (&grid.x_edges, &grid.y_edges), &cells);
}

/// Draws cells; neighbours in a row with one colour become one rectangle.
fn cells_inside(
    canvas: &mut Canvas,
    plot: &Plot<'_>,
    (x_edges, y_edges): (&[f64], &[f64]),
    cells: &[Option<RGBColor>],
) {
    let columns = x_edges.len().saturating_sub(1);
    if columns == 0 {
        return;
    }
    let Place { left, right, top, bottom, .. } = plot.place;
    let rows: Vec<&[Option<RGBColor>]> = cells.chunks(columns).collect();
    // From the top down, as the underlap reaches downwards.
    for (row, (ends, cells)) in y_edges.windows(2).zip(&rows).enumerate().rev() {
        let &[low, high] = ends else { continue };
        let (head, foot) = (plot.up(high).clamp(top, bottom), plot.up(low).clamp(top, bottom));
        let below = row.checked_sub(1).and_then(|row| rows.get(row));
        let mut column = 0;
        while let Some(&cell) = cells.get(column) {
            let end = column + cells.iter().skip(column).take_while(|&&other| other == cell).count();
            if let (Some(colour), Some(&from), Some(&to)) = (cell, x_edges.get(column), x_edges.get(end)) {
                let covered = |next: Option<&Option<RGBColor>>| next.is_some_and(Option::is_some);
                let hidden = below.is_some_and(|below| (column..end).all(|column| covered(below.get(column))));
                let down = if hidden { UNDERLAP } else { 0.0 };
                let across = if covered(cells.get(end)) { UNDERLAP } else { 0.0 };
                let (from, to) = (plot.across(from).clamp(left, right), plot.across(to).clamp(left, right));
                if to > from && foot > head {
                    let corner = ((to + across).min(right), (foot + down).min(bottom));
                    canvas.rectangle((from, head), corner, colour);
                }
            }
            column = end;
        }
    }
}
