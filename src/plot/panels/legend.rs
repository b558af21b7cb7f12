//! The legend: each name once, with what it stands for.

use super::super::PlotError;
use super::super::canvas::{Canvas, Stroke};
use super::super::palette::{INK, colour};
use super::data::{line_stroke, point_colour};
use super::layout::{LEADING, Paragraph, lettering};
use super::{LineSeries, Panel};

const EM: f64 = 14.0;
/// Length of the sample line.
const SAMPLE: f64 = 30.0;
const SAMPLE_GAP: f64 = 8.0;
const ENTRY_GAP: f64 = 30.0;
const ROW_GAP: f64 = 4.0;
const DOT: f64 = 3.0;

/// What a name stands for.
#[derive(Debug)]
struct Entry {
    name: String,
    points: Option<usize>,
    line: Option<Stroke>,
}

/// The entries with their texts, broken into rows.
#[derive(Debug)]
pub(super) struct Legend {
    rows: Vec<Vec<(Entry, Paragraph, f64)>>,
}

impl Legend {
    pub(super) fn new(panels: &[Panel], width: f64) -> Result<Self, PlotError> {
        let mut rows: Vec<Vec<_>> = Vec::new();
        let mut used = f64::INFINITY;
        for entry in entries(panels) {
            let text = Paragraph::new(&entry.name, lettering(EM, false, INK), width - SAMPLE - SAMPLE_GAP)?;
            let mut text_width: f64 = 0.0;
            for line in &text.lines {
                text_width = text_width.max(super::super::font::width(line, EM, false)?);
            }
            let entry_width = SAMPLE + SAMPLE_GAP + text_width;
            if used + ENTRY_GAP + entry_width > width {
                rows.push(Vec::new());
                used = -ENTRY_GAP;
            }
            let start = used + ENTRY_GAP;
            used = start + entry_width;
            if let Some(row) = rows.last_mut() {
                row.push((entry, text, start));
            }
        }
        Ok(Self { rows })
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub(super) fn height(&self) -> f64 {
        self.rows.iter().map(|row| row_height(row)).sum()
    }

    pub(super) fn paint(&self, canvas: &mut Canvas, (left, mut top): (f64, f64)) {
        for row in &self.rows {
            for (entry, text, start) in row {
                let x = left + start;
                let middle = top + EM * LEADING / 2.0;
                if let Some(index) = entry.points {
                    canvas.disc((x + SAMPLE / 2.0, middle), DOT, point_colour(colour(index)));
                }
                if let Some(stroke) = entry.line {
                    canvas.polyline(&[(x, middle), (x + SAMPLE, middle)], stroke);
                }
                text.paint(canvas, (x + SAMPLE + SAMPLE_GAP, top));
            }
            top += row_height(row);
        }
    }
}

fn row_height(row: &[(Entry, Paragraph, f64)]) -> f64 {
    row.iter().map(|(_, text, _)| text.height()).fold(0.0, f64::max) + ROW_GAP
}

fn entries(panels: &[Panel]) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |name: &str, points: Option<usize>, line: Option<&LineSeries>| {
        if name.trim().is_empty() {
            return;
        }
        let line = line.map(line_stroke);
        if let Some(known) = entries.iter_mut().find(|entry| entry.name == name) {
            known.points = known.points.or(points);
            known.line = known.line.or(line);
        } else {
            entries.push(Entry { name: name.to_owned(), points, line });
        }
    };
    for panel in panels {
        panel.points.iter().for_each(|series| add(&series.name, Some(series.colour), None));
        panel.lines.iter().for_each(|series| add(&series.name, None, Some(series)));
    }
    entries
}
