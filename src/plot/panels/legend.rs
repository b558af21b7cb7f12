//! The legend: each name once, with what it stands for.

use super::super::PlotError;
use super::super::canvas::{Canvas, Stroke};
use super::super::palette::{INK, colour};
use super::data::{bar_colour, line_stroke, point_colour, vertical_stroke};
use super::labels::{badge, badge_radius};
use super::layout::{LEADING, Paragraph, lettering};
use super::{LabelStyle, Panel};

const EM: f64 = 14.0;
/// Length of the sample line.
const SAMPLE: f64 = 30.0;
const SAMPLE_GAP: f64 = 8.0;
const ENTRY_GAP: f64 = 30.0;
const ROW_GAP: f64 = 4.0;
const DOT: f64 = 3.0;
/// Half the height of a sample bar.
const BAR: f64 = 5.0;

/// What a name stands for.
#[derive(Debug, Default)]
struct Entry {
    name: String,
    points: Option<usize>,
    line: Option<Stroke>,
    bars: Option<usize>,
    /// Text, radius, and whether it is the strong one.
    badge: Option<(String, f64, bool)>,
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
        for entry in entries(panels)? {
            let sample = entry.badge_size().max(SAMPLE);
            let text = Paragraph::new(&entry.name, lettering(EM, false, INK), width - sample - SAMPLE_GAP)?;
            let mut text_width: f64 = 0.0;
            for line in &text.lines {
                text_width = text_width.max(super::super::font::width(line, EM, false)?);
            }
            let entry_width = sample + SAMPLE_GAP + text_width;
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
                let sample = entry.badge_size().max(SAMPLE);
                let middle = top + EM * LEADING / 2.0 + raised(entry);
                if let Some(index) = entry.bars {
                    let (from, to) = ((x + SAMPLE / 4.0, middle - BAR), (x + 0.75 * SAMPLE, middle + BAR));
                    canvas.rectangle(from, to, bar_colour(colour(index)));
                }
                if let Some(index) = entry.points {
                    canvas.disc((x + SAMPLE / 2.0, middle), DOT, point_colour(colour(index)));
                }
                if let Some(stroke) = entry.line {
                    canvas.polyline(&[(x, middle), (x + SAMPLE, middle)], stroke);
                }
                if let Some((text, radius, strong)) = &entry.badge {
                    badge(canvas, (x + sample / 2.0, middle), *radius, text, *strong);
                }
                text.paint(canvas, (x + sample + SAMPLE_GAP, top + raised(entry)));
            }
            top += row_height(row);
        }
    }
}

impl Entry {
    /// Room that the badge takes in both directions; 0 if there is none.
    fn badge_size(&self) -> f64 {
        self.badge.as_ref().map_or(0.0, |(_, radius, _)| 2.0 * radius + 3.0)
    }
}

/// How much lower the text stands so that a badge higher than a line has room above.
fn raised(entry: &Entry) -> f64 {
    ((entry.badge_size() - EM * LEADING) / 2.0).max(0.0)
}

fn row_height(row: &[(Entry, Paragraph, f64)]) -> f64 {
    let height = |(entry, text, _): &(Entry, Paragraph, f64)| (text.height() + raised(entry)).max(entry.badge_size());
    row.iter().map(height).fold(0.0, f64::max) + ROW_GAP
}

fn entries(panels: &[Panel]) -> Result<Vec<Entry>, PlotError> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |name: &str, sample: Entry| {
        if name.trim().is_empty() {
            return;
        }
        let known = entries.iter_mut().find(|entry| entry.name == name && entry.badge == sample.badge);
        if let Some(known) = known {
            known.points = known.points.or(sample.points);
            known.line = known.line.or(sample.line);
            known.bars = known.bars.or(sample.bars);
        } else {
            entries.push(Entry { name: name.to_owned(), ..sample });
        }
    };
    for panel in panels.iter().filter(|panel| !panel.blank) {
        for series in &panel.points {
            add(&series.name, Entry { points: Some(series.colour), ..Entry::default() });
        }
        for series in &panel.bars {
            add(&series.name, Entry { bars: Some(series.colour), ..Entry::default() });
        }
        for series in &panel.lines {
            add(&series.name, Entry { line: Some(line_stroke(series)), ..Entry::default() });
        }
        for line in &panel.vertical_lines {
            add(&line.name, Entry { line: Some(vertical_stroke(line)), ..Entry::default() });
        }
        for label in panel.labels.iter().filter(|label| label.style != LabelStyle::Remark) {
            let badge = (label.text.clone(), badge_radius(&label.text)?, label.style == LabelStyle::StrongBadge);
            add(&label.name, Entry { badge: Some(badge), ..Entry::default() });
        }
    }
    Ok(entries)
}
