//! The cells of a heat map. All lengths are picture units.

use super::super::canvas::Canvas;
use super::HeatMap;
use super::colours::Colours;
use super::data::Plot;
use super::panel::Place;

/// Cells reach so far under the next ones, so that no paper shows between them where edges fall between two pixels.
const UNDERLAP: f64 = 0.75;

/// Draws the cells inside the frame; neighbours in a row with one colour become one rectangle.
pub(super) fn paint(canvas: &mut Canvas, plot: &Plot<'_>, heat: &HeatMap) {
    let Some(colours) = Colours::of(heat).filter(|_| heat.columns() > 0) else { return };
    let Place { left, right, top, bottom, .. } = plot.place;
    let numbers: Vec<Option<u32>> = heat.values.iter().map(|&value| colours.number(value)).collect();
    let rows: Vec<&[Option<u32>]> = numbers.chunks(heat.columns()).collect();
    // From the top down, as the underlap reaches downwards.
    for (row, (ends, cells)) in heat.y_edges.windows(2).zip(&rows).enumerate().rev() {
        let &[low, high] = ends else { continue };
        let (head, foot) = (plot.up(high).clamp(top, bottom), plot.up(low).clamp(top, bottom));
        let below = row.checked_sub(1).and_then(|row| rows.get(row));
        let mut column = 0;
        while let Some(&cell) = cells.get(column) {
            let end = column + cells.iter().skip(column).take_while(|&&other| other == cell).count();
            if let (Some(number), Some(&from), Some(&to)) = (cell, heat.x_edges.get(column), heat.x_edges.get(end)) {
                let covered = |next: Option<&Option<u32>>| next.is_some_and(Option::is_some);
                let hidden = below.is_some_and(|below| (column..end).all(|column| covered(below.get(column))));
                let down = if hidden { UNDERLAP } else { 0.0 };
                let across = if covered(cells.get(end)) { UNDERLAP } else { 0.0 };
                let (from, to) = (plot.across(from).clamp(left, right), plot.across(to).clamp(left, right));
                if to > from && foot > head {
                    let corner = ((to + across).min(right), (foot + down).min(bottom));
                    canvas.rectangle((from, head), corner, colours.colour(number));
                }
            }
            column = end;
        }
    }
}
