//! Where everything goes. All lengths are picture units.
//!
//! The plots of a column share their left and right ends, those of a row their upper and lower ends.

use super::super::canvas::{Anchor, Canvas, Lettering};
use super::super::palette::{INK, SOFT_INK};
use super::super::{PlotError, font};
use super::Figure;
use super::legend::Legend;
use super::panel::{Measured, Place};

/// Width of a panel with its labels; more if the labels leave less than [`NARROWEST_PLOT`].
const PANEL_WIDTH: f64 = 520.0;
/// Height of a plot, which makes a panel with its labels about 340 high.
const PLOT_HEIGHT: f64 = 254.0;
/// The same for a figure with one panel only.
const SINGLE_PANEL: (f64, f64) = (720.0, 370.0);

const NARROWEST_PLOT: f64 = 320.0;
/// Right of each plot: room for half of the last tick label.
const RIGHT: f64 = 22.0;
const MARGIN: f64 = 24.0;
const COLUMN_GAP: f64 = 14.0;
const ROW_GAP: f64 = 24.0;
/// The room between plots of a requested size, which stand closer.
const CLOSE: f64 = 10.0;

/// Distance of baselines, in ems.
pub(super) const LEADING: f64 = 1.35;
/// Height of the letters above the baseline, in ems: accents on capitals included.
const ASCENT: f64 = 0.95;

/// A block of text with its style.
#[derive(Debug)]
pub(super) struct Paragraph {
    pub(super) lines: Vec<String>,
    pub(super) lettering: Lettering,
}

impl Paragraph {
    /// Breaks the text so that no line is wider than `limit`.
    pub(super) fn new(text: &str, lettering: Lettering, limit: f64) -> Result<Self, PlotError> {
        Ok(Self { lines: font::wrap(text, lettering.em, lettering.bold, limit)?, lettering })
    }

    /// From the upper to the lower edge (from the left to the right one, if it reads upwards); 0 if it is empty.
    pub(super) fn height(&self) -> f64 {
        self.lines.len() as f64 * self.lettering.em * LEADING
    }

    /// Writes the lines below `top` (right of `top`, if they read upwards).
    pub(super) fn paint(&self, canvas: &mut Canvas, (x, y): (f64, f64)) {
        let em = self.lettering.em;
        for (i, line) in self.lines.iter().enumerate() {
            let down = em * (ASCENT + LEADING * i as f64);
            let baseline = if self.lettering.upwards { (x + down, y) } else { (x, y + down) };
            canvas.text(baseline, line, self.lettering);
        }
    }
}

/// A figure with all places fixed.
#[derive(Debug)]
pub(super) struct Layout<'a> {
    pub(super) width: f64,
    pub(super) height: f64,
    title: Paragraph,
    subtitle: Paragraph,
    panels: Vec<(Measured<'a>, Place)>,
    legend: Legend,
    legend_top: f64,
}

impl<'a> Layout<'a> {
    pub(super) fn of(figure: &'a Figure) -> Result<Self, PlotError> {
        let count = figure.panels.len();
        let columns = figure.columns.unwrap_or_else(|| usual_columns(count)).clamp(1, count.max(1));
        let (panel_width, usual_height) = if count == 1 { SINGLE_PANEL } else { (PANEL_WIDTH, PLOT_HEIGHT) };
        let plot_height = figure.plot_size.map_or(usual_height, |(_, height)| height);
        let (column_gap, row_gap) = if figure.plot_size.is_some() { (0.0, CLOSE) } else { (COLUMN_GAP, ROW_GAP) };

        let mut panels =
            figure.panels.iter().map(|panel| Measured::new(panel, plot_height)).collect::<Result<Vec<_>, _>>()?;

        let mut column_ends = Vec::with_capacity(columns); // of the labels and of the plot
        let mut width = MARGIN;
        for column in 0..columns {
            let labels = panels.iter().skip(column).step_by(columns).map(Measured::left).fold(0.0, f64::max);
            let bars = panels.iter().skip(column).step_by(columns).map(Measured::right).fold(0.0, f64::max);
            let room = RIGHT.max(bars + RIGHT / 2.0);
            let left = width + labels;
            let usual = (panel_width - labels - room).max(NARROWEST_PLOT);
            let right = left + figure.plot_size.map_or(usual, |(width, _)| width);
            column_ends.push((width, left, right));
            width = right + room + column_gap;
        }
        width += MARGIN - column_gap - RIGHT / 2.0;

        let text_width = width - 2.0 * MARGIN;
        let title = Paragraph::new(&figure.title, lettering(20.0, true, INK), text_width)?;
        let subtitle = Paragraph::new(&figure.subtitle, lettering(14.0, false, SOFT_INK), text_width)?;
        let legend = Legend::new(&figure.panels, text_width)?;

        let mut top = MARGIN;
        for paragraph in [&title, &subtitle] {
            top += paragraph.height();
        }
        if top > MARGIN {
            top += 14.0;
        }
        // Labels of neighbours must not meet, where no y labels keep them apart.
        let overhang = if figure.plot_size.is_some() { CLOSE } else { RIGHT };
        let mut places = Vec::with_capacity(count);
        for row in panels.chunks_mut(columns) {
            for (panel, (_, left, right)) in row.iter_mut().zip(&column_ends) {
                panel.fit_width(right - left, plot_height, overhang)?;
            }
            let plot_top = top + row.iter().map(Measured::header).fold(0.0, f64::max);
            let bottom = plot_top + plot_height;
            places.extend(row.iter().zip(&column_ends).map(|(_, &(label_left, left, right))| Place {
                label_left,
                left,
                right,
                top: plot_top,
                bottom,
            }));
            top = bottom + row.iter().map(Measured::footer).fold(0.0, f64::max) + row_gap;
        }
        let legend_top = top - row_gap + if legend.is_empty() { 0.0 } else { 16.0 };
        let height = legend_top + legend.height() + MARGIN - 6.0;
        let panels = panels.into_iter().zip(places).collect();
        Ok(Self { width, height, title, subtitle, panels, legend, legend_top })
    }

    pub(super) fn paint(&self, canvas: &mut Canvas) -> Result<(), PlotError> {
        self.title.paint(canvas, (MARGIN, MARGIN));
        self.subtitle.paint(canvas, (MARGIN, MARGIN + self.title.height()));
        for (panel, place) in &self.panels {
            panel.paint(canvas, *place)?;
        }
        self.legend.paint(canvas, (MARGIN, self.legend_top));
        Ok(())
    }
}

/// Letters that start at the given point.
pub(super) fn lettering(em: f64, bold: bool, colour: plotters::style::RGBColor) -> Lettering {
    Lettering { em, bold, colour, anchor: Anchor::Start, upwards: false }
}

/// Panels in a row, such that the figure is about as wide as high and not wider than a page can show.
fn usual_columns(panels: usize) -> usize {
    match panels {
        0..=3 => panels.max(1),
        4 => 2,
        5..=12 => 3,
        _ => 4,
    }
}
