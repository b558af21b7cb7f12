//! The data of one panel: their ranges, and how they are drawn. All lengths are picture units.

use plotters::style::RGBColor;

use super::super::canvas::{Canvas, Stroke};
use super::super::palette::{BAND, GRID, SOFT_INK, colour, tint};
use super::axis::{Axis, is_drawable, range_of, widened};
use super::heat;
use super::panel::Place;
use super::polar;
use super::{BarSeries, LineSeries, Panel, PointSeries, VerticalLine};

/// Air around the data, as parts of their range.
const AIR_X: f64 = 0.03;
const AIR_Y: f64 = 0.06;

const BAR_WIDTH: f64 = 1.0;
const LEVEL: Stroke = Stroke { colour: SOFT_INK, width: 1.0, dashes: Some((3.0, 3.0)) };
const DASHES: (f64, f64) = (7.0, 4.5);

/// The discs of points, paler than the line of the same colour, which is drawn above them.
pub(super) fn point_colour(colour: RGBColor) -> RGBColor {
    tint(colour, 0.6)
}

/// Error bars and the bars of histograms.
pub(super) fn bar_colour(colour: RGBColor) -> RGBColor {
    tint(colour, 0.5)
}

/// How a line series is drawn, in its panel and in the legend.
pub(super) fn line_stroke(line: &LineSeries) -> Stroke {
    Stroke { colour: colour(line.colour), width: line.width, dashes: line.dashed.then_some(DASHES) }
}

/// How an upright line is drawn.
pub(super) fn vertical_stroke(line: &VerticalLine) -> Stroke {
    Stroke { colour: colour(line.colour), width: 1.4, dashes: line.dashed.then_some(DASHES) }
}

/// Points of a crowded panel are drawn smaller.
fn radius(points: usize) -> f64 {
    match points {
        0..=300 => 2.75,
        301..=1500 => 2.0,
        _ => 1.25,
    }
}

fn vertices<'a>(x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    x.iter().copied().zip(y.iter().copied())
}

/// The standard deviation of point `i`, if it can be drawn.
fn sigma_of(series: &PointSeries, i: usize) -> Option<f64> {
    let sigma = series.sigma.as_ref()?.get(i).copied()?;
    (is_drawable(sigma) && sigma > 0.0).then_some(sigma)
}

/// The ranges of x and y that the panel shows; none if it has no drawable value.
pub(super) fn ranges(panel: &Panel) -> Option<((f64, f64), (f64, f64))> {
    // Lowest and highest value at each drawable place.
    let mut drawable = Vec::new();
    for series in &panel.points {
        for (i, (x, y)) in vertices(&series.x, &series.y).enumerate() {
            let sigma = sigma_of(series, i).unwrap_or(0.0);
            drawable.push((x, y, sigma));
        }
    }
    for series in &panel.lines {
        drawable.extend(vertices(&series.x, &series.y).map(|(x, y)| (x, y, 0.0)));
    }
    for bars in &panel.bars {
        for (ends, &height) in bars.edges.windows(2).zip(&bars.heights) {
            drawable.extend(ends.iter().flat_map(|&x| [(x, height, 0.0), (x, 0.0, 0.0)]));
        }
    }
    drawable.extend(panel.labels.iter().map(|label| (label.x, label.y, 0.0)));
    let heat = panel.heat.as_ref().map(|heat| (&heat.x_edges, &heat.y_edges));
    let edges = heat.or(panel.colours.as_ref().map(|grid| (&grid.x_edges, &grid.y_edges)));
    let heat = edges.and_then(|(x_edges, y_edges)| {
        drawable.extend(x_edges.iter().zip(y_edges).map(|(&x, &y)| (x, y, 0.0)));
        Some((range_of(x_edges.iter().copied(), 0.0)?, range_of(y_edges.iter().copied(), 0.0)?))
    });
    drawable.retain(|&(x, y, _)| is_drawable(x) && is_drawable(y));
    let upright = panel.vertical_lines.iter().map(|line| line.x);
    let x = requested(panel.x_range)
        .or(heat.map(|(x, _)| x))
        .or_else(|| range_of(drawable.iter().map(|&(x, _, _)| x).chain(upright), AIR_X))?;
    let shown = |&&(value, _, _): &&(f64, f64, f64)| (x.0..=x.1).contains(&value);
    let heights = drawable.iter().filter(shown).flat_map(|&(_, y, sigma)| [y - sigma, y, y + sigma]);
    let marks = panel.horizontal_lines.iter().copied().chain(panel.bands.iter().flat_map(|&(low, high)| [low, high]));
    let heights: Vec<f64> = heights.chain(marks).collect();
    let mut y = requested(panel.y_range)
        .or(heat.map(|(_, y)| y))
        .or_else(|| range_of(heights.iter().copied(), AIR_Y))
        .unwrap_or((0.0, 1.0));
    if panel.polar {
        let radius = drawable.iter().map(|&(x, y, _)| x.hypot(y)).fold(0.0, f64::max);
        return (radius > 0.0).then(|| polar::ranges(radius));
    }
    // Bars stand on the axis, without air below.
    let standing = !panel.bars.is_empty() && !heights.iter().any(|&height| height < 0.0);
    if standing && requested(panel.y_range).is_none() && y.1 > 0.0 {
        y.0 = y.0.max(0.0);
    }
    (!drawable.is_empty()).then_some((x, y))
}

fn requested(range: Option<(f64, f64)>) -> Option<(f64, f64)> {
    range.filter(|&(low, high)| is_drawable(low) && is_drawable(high)).map(|(low, high)| widened(low, high))
}

/// The inside of a panel.
#[derive(Debug)]
pub(super) struct Plot<'a> {
    pub(super) place: Place,
    pub(super) x: &'a Axis,
    pub(super) y: &'a Axis,
}

impl Plot<'_> {
    /// Draws, from back to front: bands, grid or heat map, bars, levels, error bars, points, lines, upright lines.
    pub(super) fn paint(&self, canvas: &mut Canvas, panel: &Panel) {
        let Place { left, right, top, bottom, .. } = self.place;
        for &(low, high) in panel.bands.iter().filter(|(low, high)| is_drawable(*low) && is_drawable(*high)) {
            let (low, high) = (self.up(low).clamp(top, bottom), self.up(high).clamp(top, bottom));
            canvas.rectangle((left, low), (right, high), BAND);
        }
        if let Some(heat) = &panel.heat {
            heat::paint(canvas, self, heat);
        } else if let Some(grid) = &panel.colours {
            heat::paint_colours(canvas, self, grid);
        } else if panel.polar {
            polar::grid(canvas, self);
        } else {
            self.grid(canvas);
        }
        panel.bars.iter().for_each(|series| self.columns(canvas, series));
        for &level in panel.horizontal_lines.iter().filter(|&&level| self.y.contains(level)) {
            canvas.polyline(&[(left, self.up(level)), (right, self.up(level))], LEVEL);
        }
        panel.points.iter().for_each(|series| self.bars(canvas, series));
        let radius = radius(panel.points.iter().map(|series| series.x.len()).sum());
        for series in &panel.points {
            let colour = point_colour(colour(series.colour));
            for (x, y) in vertices(&series.x, &series.y).filter(|&(x, y)| self.x.contains(x) && self.y.contains(y)) {
                canvas.disc(self.at(x, y), radius, colour);
            }
        }
        panel.lines.iter().for_each(|series| self.line(canvas, series));
        for line in panel.vertical_lines.iter().filter(|line| self.x.contains(line.x)) {
            let x = self.across(line.x);
            canvas.polyline(&[(x, bottom), (x, top)], vertical_stroke(line));
        }
    }

    fn grid(&self, canvas: &mut Canvas) {
        let Place { left, right, top, bottom, .. } = self.place;
        for tick in &self.x.ticks {
            let at = left + tick.place * (right - left);
            canvas.polyline(&[(at, top), (at, bottom)], Stroke::solid(GRID, 1.0));
        }
        for tick in &self.y.ticks {
            let at = bottom - tick.place * (bottom - top);
            canvas.polyline(&[(left, at), (right, at)], Stroke::solid(GRID, 1.0));
        }
    }

    /// Draws the bars of a histogram, cut off at the frame.
    fn columns(&self, canvas: &mut Canvas, series: &BarSeries) {
        let Place { left, right, top, bottom, .. } = self.place;
        let filling = bar_colour(colour(series.colour));
        for (ends, &height) in series.edges.windows(2).zip(&series.heights) {
            let &[from, to] = ends else { continue };
            let (from, to) = (self.across(from).clamp(left, right), self.across(to).clamp(left, right));
            let (foot, head) = (self.up(0.0).clamp(top, bottom), self.up(height).clamp(top, bottom));
            if is_drawable(height) && (foot - head).abs() > 0.0 && to > from {
                canvas.rectangle((from, foot), (to, head), filling);
            }
        }
    }

    pub(super) fn across(&self, x: f64) -> f64 {
        self.place.left + self.x.place(x) * (self.place.right - self.place.left)
    }

    pub(super) fn up(&self, y: f64) -> f64 {
        self.place.bottom - self.y.place(y) * (self.place.bottom - self.place.top)
    }

    pub(super) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.across(x), self.up(y))
    }

    /// Draws the error bars, cut off at the frame.
    fn bars(&self, canvas: &mut Canvas, series: &PointSeries) {
        let stroke = Stroke::solid(bar_colour(colour(series.colour)), BAR_WIDTH);
        for (i, (x, y)) in vertices(&series.x, &series.y).enumerate() {
            let Some(sigma) = sigma_of(series, i).filter(|_| self.x.contains(x) && is_drawable(y)) else { continue };
            let ends = (self.at(x, y - sigma), self.at(x, y + sigma));
            if let Some((from, to)) = clipped(ends.0, ends.1, self.place) {
                canvas.polyline(&[from, to], stroke);
            }
        }
    }

    /// Draws a line: interrupted at values that cannot be drawn, cut off at the frame.
    fn line(&self, canvas: &mut Canvas, series: &LineSeries) {
        let stroke = line_stroke(series);
        let drawable = |&(x, y): &(f64, f64)| is_drawable(x) && is_drawable(y);
        let vertices: Vec<_> = vertices(&series.x, &series.y).collect();
        for run in vertices.split(|vertex| !drawable(vertex)) {
            if let &[(x, y)] = run {
                if self.x.contains(x) && self.y.contains(y) {
                    canvas.polyline(&[self.at(x, y)], stroke);
                }
                continue;
            }
            let mut visible: Vec<(f64, f64)> = Vec::with_capacity(run.len());
            for (&from, &to) in run.iter().zip(run.iter().skip(1)) {
                let Some((start, end)) = clipped(self.at(from.0, from.1), self.at(to.0, to.1), self.place) else {
                    continue;
                };
                if visible.last().is_some_and(|&(x, y)| (x - start.0).hypot(y - start.1) > 1e-6) {
                    canvas.polyline(&visible, stroke);
                    visible.clear();
                }
                if visible.is_empty() {
                    visible.push(start);
                }
                visible.push(end);
            }
            canvas.polyline(&visible, stroke);
        }
    }
}

/// The part of a straight line inside the plot, if there is one.
///
/// # Source
/// Liang and Barsky, *A new concept and method for line clipping*, ACM Trans. Graph. 3 (1984).
fn clipped(from: (f64, f64), to: (f64, f64), place: Place) -> Option<((f64, f64), (f64, f64))> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let sides = [
        (-dx, from.0 - place.left),
        (dx, place.right - from.0),
        (-dy, from.1 - place.top),
        (dy, place.bottom - from.1),
    ];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (outwards, room) in sides {
        if outwards < 0.0 {
            enter = enter.max(room / outwards);
        } else if outwards > 0.0 {
            leave = leave.min(room / outwards);
        } else if room < 0.0 {
            return None;
        }
    }
    let at = |part: f64| {
        if part <= 0.0 {
            from
        } else if part >= 1.0 {
            to
        } else {
            (from.0 + part * dx, from.1 + part * dy)
        }
    };
    (enter <= leave).then(|| (at(enter), at(leave)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACE: Place = Place { label_left: 0.0, left: 0.0, right: 10.0, top: 0.0, bottom: 10.0 };

    #[test]
    fn lines_are_cut_at_the_frame() {
        assert_eq!(clipped((1.0, 1.0), (9.0, 9.0), PLACE), Some(((1.0, 1.0), (9.0, 9.0))));
        assert_eq!(clipped((-5.0, 5.0), (15.0, 5.0), PLACE), Some(((0.0, 5.0), (10.0, 5.0))));
        assert_eq!(clipped((5.0, 5.0), (5.0, 25.0), PLACE), Some(((5.0, 5.0), (5.0, 10.0))));
        assert_eq!(clipped((-5.0, 4.0), (4.0, -5.0), PLACE), None);
        assert_eq!(clipped((11.0, 0.0), (11.0, 10.0), PLACE), None);
    }

    #[test]
    fn the_range_of_y_is_that_of_the_visible_points() {
        let points = PointSeries { x: vec![1.0, 2.0, 3.0], y: vec![0.0, 1.0, 500.0], ..PointSeries::default() };
        let panel = Panel { x_range: Some((0.0, 2.5)), points: vec![points], ..Panel::default() };
        assert_eq!(ranges(&panel), Some(((0.0, 2.5), (-AIR_Y, 1.0 + AIR_Y))));
    }

    #[test]
    fn values_that_are_not_finite_do_not_count() {
        let points = PointSeries {
            x: vec![1.0, 2.0, f64::NAN, 4.0],
            y: vec![0.0, 1.0, 7.0, f64::INFINITY],
            sigma: Some(vec![f64::NAN, -3.0, 1.0, 1.0]),
            ..PointSeries::default()
        };
        let panel = Panel { y_range: Some((f64::NAN, 3.0)), points: vec![points], ..Panel::default() };
        assert_eq!(ranges(&panel), Some(((1.0 - AIR_X, 2.0 + AIR_X), (-AIR_Y, 1.0 + AIR_Y))));
    }
}
