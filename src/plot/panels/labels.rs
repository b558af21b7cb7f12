//! Places of the labels: each free of the others and inside the frame. All lengths are picture units.

use std::f64::consts::TAU;

use plotters::style::RGBColor;

use super::super::canvas::{Anchor, Canvas, Lettering, Stroke};
use super::super::palette::{INK, PAPER};
use super::super::{PlotError, font};
use super::data::Plot;
use super::layout::{LEADING, Paragraph, lettering};
use super::panel::{CAPITALS, Place};
use super::{Label, LabelStyle, LineSeries};

const EM: f64 = 12.5;
/// White around a remark, and distance from its point.
const PADDING: f64 = 3.0;
const DISTANCE: f64 = 5.0;
/// The smallest badge.
const RADIUS: f64 = 9.0;
/// Free room between two labels, and between a label and the frame.
const GAP: f64 = 3.0;
/// Rings of places tried around a point, and places in a ring.
const RINGS: u32 = 12;
const DIRECTIONS: u32 = 16;
/// A remark goes no farther from its point to hide no line: there it would be taken for another point's.
const NEAR: f64 = 60.0;

/// Places close beside a point, in half widths and half heights.
const BESIDE: [(f64, f64); 6] = [(1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (-1.0, 0.0)];

/// An upright rectangle: left, upper, right, lower end.
#[derive(Debug, Clone, Copy)]
struct Block(f64, f64, f64, f64);

impl Block {
    fn around((x, y): (f64, f64), (half_width, half_height): (f64, f64)) -> Self {
        Self(x - half_width, y - half_height, x + half_width, y + half_height)
    }

    fn touches(&self, other: &Self) -> bool {
        self.0 < other.2 + GAP && other.0 < self.2 + GAP && self.1 < other.3 + GAP && other.1 < self.3 + GAP
    }

    fn is_inside(&self, place: Place) -> bool {
        self.0 >= place.left + GAP
            && self.1 >= place.top + GAP
            && self.2 <= place.right - GAP
            && self.3 <= place.bottom - GAP
    }

    /// From its nearest edge; 0 inside.
    fn distance(&self, (x, y): (f64, f64)) -> f64 {
        let beyond = |low: f64, value: f64, high: f64| (low - value).max(value - high).max(0.0);
        beyond(self.0, x, self.2).hypot(beyond(self.1, y, self.3))
    }

    /// Whether the straight line between two points passes through, by Liang and Barsky's clipping (doi:10.1145/357332.357333).
    fn is_crossed(&self, [from, to]: [(f64, f64); 2]) -> bool {
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        if ![from.0, from.1, to.0, to.1].into_iter().all(f64::is_finite) {
            return false;
        }
        let edges = [(from.0, to.0 - from.0, self.0, self.2), (from.1, to.1 - from.1, self.1, self.3)];
        for (start, step, low, high) in edges {
            if step == 0.0 {
                if start < low || start > high {
                    return false;
                }
                continue;
            }
            let (one, other) = ((low - start) / step, (high - start) / step);
            enters = enters.max(one.min(other));
            leaves = leaves.min(one.max(other));
        }
        enters <= leaves
    }
}

/// Draws a badge with a short text around a centre.
pub(super) fn badge(canvas: &mut Canvas, (x, y): (f64, f64), radius: f64, text: &str, strong: bool) {
    let (paper, ink) = if strong { (INK, PAPER) } else { (PAPER, INK) };
    canvas.disc((x, y), radius + 1.25, if strong { PAPER } else { INK });
    canvas.disc((x, y), radius, paper);
    let style = Lettering { anchor: Anchor::Middle, ..lettering(EM, true, ink) };
    canvas.text((x, y + CAPITALS / 2.0 * EM), text, style);
}

/// Radius of the badge around a text.
pub(super) fn badge_radius(text: &str) -> Result<f64, PlotError> {
    Ok(RADIUS.max(font::width(text, EM, true)? / 2.0 + PADDING))
}

/// Draws the labels, the first ones where they like best; remarks beside the lines, if there is room near their points.
pub(super) fn paint(
    canvas: &mut Canvas,
    plot: &Plot<'_>,
    labels: &[Label],
    lines: &[LineSeries],
) -> Result<(), PlotError> {
    let place = plot.place;
    let pieces = |line: &LineSeries| {
        let points: Vec<(f64, f64)> = line.x.iter().zip(&line.y).map(|(&x, &y)| plot.at(x, y)).collect();
        points.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
    };
    let pieces: Vec<[(f64, f64); 2]> = lines.iter().flat_map(pieces).collect();
    let shown = |label: &&Label| plot.x.contains(label.x) && plot.y.contains(label.y) && !label.text.trim().is_empty();
    let shown: Vec<(&Label, (f64, f64))> =
        labels.iter().filter(shown).map(|label| (label, plot.at(label.x, label.y))).collect();
    let mut taken: Vec<Block> = Vec::new();
    let mut settled = Vec::new();
    for (index, &(label, point)) in shown.iter().enumerate() {
        let is_badge = label.style != LabelStyle::Remark;
        let limit = if is_badge { f64::INFINITY } else { place.right - place.left - 2.0 * (PADDING + GAP) };
        let style = Lettering { anchor: Anchor::Middle, ..lettering(EM, false, INK) };
        let text = Paragraph::new(&label.text, style, limit)?;
        let half = if is_badge {
            let radius = badge_radius(&label.text)? + 1.25;
            (radius, radius)
        } else {
            let mut width: f64 = 0.0;
            for line in &text.lines {
                width = width.max(font::width(line, EM, false)?);
            }
            (width / 2.0 + PADDING, text.height() / 2.0 + PADDING / 2.0)
        };
        // Points of other labels stay visible.
        let others = shown.iter().enumerate().filter(|&(other, _)| other != index);
        let points: Vec<Block> = others.map(|(_, &(_, point))| Block::around(point, (2.0, 2.0))).collect();
        let free = |centre: &(f64, f64)| {
            let block = Block::around(*centre, half);
            block.is_inside(place) && !taken.iter().chain(&points).any(|other| block.touches(other))
        };
        let hides_none = |centre: &(f64, f64)| {
            let block = Block::around(*centre, half);
            block.distance(point) < NEAR && free(centre) && !pieces.iter().any(|piece| block.is_crossed(*piece))
        };
        let beside = candidates(point, half, is_badge).filter(|_| !is_badge).find(hides_none);
        if let Some(centre) = beside.or_else(|| candidates(point, half, is_badge).find(free)) {
            taken.push(Block::around(centre, half));
            settled.push((label, point, centre, half, text));
        }
    }
    // Leaders and points below all badges.
    for (label, point, centre, _, _) in &settled {
        if label.style != LabelStyle::Remark {
            for (colour, width) in [(PAPER, 3.0), (INK, 1.25)] {
                canvas.polyline(&[*point, *centre], Stroke::solid(colour, width));
            }
            canvas.disc(*point, 4.0, PAPER);
            canvas.disc(*point, 2.75, INK);
        }
    }
    for (label, _, centre, half, text) in settled {
        match label.style {
            LabelStyle::Remark => remark(canvas, centre, half, &text),
            style => badge(canvas, centre, half.0 - 1.25, &label.text, style == LabelStyle::StrongBadge),
        }
    }
    Ok(())
}

fn remark(canvas: &mut Canvas, (x, y): (f64, f64), (half_width, half_height): (f64, f64), text: &Paragraph) {
    const WHITE: RGBColor = PAPER;
    canvas.rectangle((x - half_width, y - half_height), (x + half_width, y + half_height), WHITE);
    // Paragraphs hang below their top by more than the letters need.
    let slack = (LEADING - 1.0) / 4.0 * EM;
    text.paint(canvas, (x, y - text.height() / 2.0 + slack));
}

/// Centres in the order in which they are tried: remarks close beside their point, then in rings around.
fn candidates(
    (x, y): (f64, f64),
    (half_width, half_height): (f64, f64),
    is_badge: bool,
) -> impl Iterator<Item = (f64, f64)> {
    let (far, high) = (half_width + DISTANCE, half_height + DISTANCE);
    let rings = (1..=RINGS).flat_map(move |ring| {
        (0..DIRECTIONS).map(move |direction| {
            let angle = TAU * (f64::from(direction) / f64::from(DIRECTIONS) - 0.125);
            let reach = 0.6 + 0.7 * f64::from(ring);
            (x + reach * far * angle.cos(), y + reach * high * angle.sin())
        })
    });
    let beside = BESIDE.into_iter().map(move |(right, down)| (x + right * far, y + down * high));
    beside.filter(move |_| !is_badge).chain(rings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_of_a_block_is_that_of_its_nearest_edge_or_corner() {
        let block = Block(10.0, 20.0, 30.0, 40.0);
        for (point, distance) in [((15.0, 25.0), 0.0), ((7.0, 30.0), 3.0), ((20.0, 45.0), 5.0), ((33.0, 16.0), 5.0)] {
            assert!((block.distance(point) - distance).abs() < 1e-12, "{point:?}");
        }
    }

    #[test]
    fn a_line_crosses_what_it_passes_through() {
        let block = Block(10.0, 20.0, 30.0, 40.0);
        let crossed = [
            [(0.0, 0.0), (40.0, 60.0)],
            [(20.0, 0.0), (20.0, 100.0)],
            [(15.0, 25.0), (16.0, 26.0)],
            [(0.0, 30.0), (15.0, 30.0)],
            [(20.0, 30.0), (20.0, 30.0)],
        ];
        let passed = [
            [(0.0, 0.0), (9.0, 100.0)],
            [(0.0, 30.0), (9.0, 30.0)],
            [(0.0, 45.0), (100.0, 45.0)],
            [(0.0, 60.0), (60.0, 60.0)],
            [(5.0, 40.0), (12.0, 50.0)],
            [(f64::NAN, 30.0), (9.0, 30.0)],
        ];
        for piece in crossed {
            let [from, to] = piece;
            assert!(block.is_crossed(piece) && block.is_crossed([to, from]), "{piece:?}");
        }
        for piece in passed {
            let [from, to] = piece;
            assert!(!block.is_crossed(piece) && !block.is_crossed([to, from]), "{piece:?}");
        }
    }
}
