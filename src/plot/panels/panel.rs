//! One panel: labels measured, then everything around the data drawn. All lengths are picture units.

use super::super::canvas::{Anchor, Canvas, Lettering, Stroke};
use super::super::palette::{GRID, INK, SOFT_INK};
use super::super::{PlotError, font};
use super::Panel;
use super::axis::{Axis, Tick};
use super::colours::ColourBar;
use super::data::{Plot, ranges};
use super::labels;
use super::layout::{LEADING, Paragraph, lettering};
use super::polar;

const TITLE_EM: f64 = 15.0;
pub(super) const LABEL_EM: f64 = 14.0;
pub(super) const TICK_EM: f64 = 13.0;
pub(super) const TICK_LENGTH: f64 = 5.0;
pub(super) const TICK_GAP: f64 = 4.0;
pub(super) const LABEL_GAP: f64 = 8.0;
const TITLE_GAP: f64 = 8.0;

/// Free room between two tick labels of the x axis.
const BETWEEN_LABELS: f64 = 26.0;
/// Ticks of the y axis are at least this far apart.
const BETWEEN_TICKS: f64 = 42.0;
/// Plots smaller than this have their ticks closer together, or too few would be left to read a value.
const SMALL_PLOT: f64 = 200.0;
const CLOSER: f64 = 0.6;
/// A power of ten that leaves less than this part of the width for the name of the axis stands above it.
const ENOUGH_FOR_NAME: f64 = 0.75;
/// Height of digits and capitals, in ems.
pub(super) const CAPITALS: f64 = 0.73;
const MOST_TICKS: usize = 9;
/// Ticks of an x axis of powers: their labels are short.
const POWERS: usize = 6;

const AXIS_STROKE: Stroke = Stroke { colour: INK, width: 1.0, dashes: None };

/// The rectangle of the plot, without labels, and where its y label begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) label_left: f64,
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

/// A panel whose labels have been measured.
#[derive(Debug)]
pub(super) struct Measured<'a> {
    panel: &'a Panel,
    title: Paragraph,
    x_label: Paragraph,
    y_label: Paragraph,
    ranges: Option<((f64, f64), (f64, f64))>,
    axes: Option<(Axis, Axis)>,
    y_tick_width: f64,
    colour_bar: Option<ColourBar>,
    /// How far the name of the x axis stands lower, to leave room for the power of ten.
    lowered: f64,
}

impl<'a> Measured<'a> {
    /// Measures what does not depend on the width of the plot.
    pub(super) fn new(panel: &'a Panel, plot_height: f64) -> Result<Self, PlotError> {
        let upwards = Lettering { anchor: Anchor::Middle, upwards: true, ..lettering(LABEL_EM, false, INK) };
        let ranges = ranges(panel).filter(|_| !panel.blank);
        let mut y_tick_width: f64 = 0.0;
        if let Some((_, (low, high))) = ranges.filter(|_| !panel.bare_y && !panel.polar) {
            for tick in y_axis(panel, (low, high), plot_height).ticks {
                y_tick_width = y_tick_width.max(font::width(&tick.label, TICK_EM, false)?);
            }
        }
        let heat = panel.heat.as_ref().filter(|_| ranges.is_some());
        let colour_bar = heat.map(|heat| ColourBar::new(heat, plot_height)).transpose()?.flatten();
        Ok(Self {
            panel,
            title: Paragraph::new("", lettering(TITLE_EM, true, INK), 0.0)?,
            x_label: Paragraph::new("", lettering(LABEL_EM, false, INK), 0.0)?,
            y_label: Paragraph::new(if panel.blank { "" } else { &panel.y_label }, upwards, plot_height)?,
            ranges,
            axes: None,
            y_tick_width,
            colour_bar,
            lowered: 0.0,
        })
    }

    /// Measures the rest. Labels of x ticks reach at most `overhang` beyond the plot.
    pub(super) fn fit_width(&mut self, plot_width: f64, plot_height: f64, overhang: f64) -> Result<(), PlotError> {
        if self.panel.blank {
            return Ok(());
        }
        let mut factor_width = 0.0;
        if let Some((x, y)) = self.ranges {
            let width = |label: &str| font::width(label, TICK_EM, false);
            let mut x_axis = if self.panel.x_in_powers {
                Axis::powers(x, POWERS)
            } else {
                Axis::fitting(x, plot_width, spaced(BETWEEN_LABELS, plot_width), MOST_TICKS, width)?
            };
            let mut y_axis = y_axis(self.panel, y, plot_height);
            if self.panel.bare_x {
                bare(&mut x_axis);
            }
            if self.panel.bare_y {
                bare(&mut y_axis);
            }
            // Upwards a strip of colours has no axis at all.
            if self.panel.bare_y && self.panel.colours.is_some() {
                y_axis.ticks.clear();
            }
            for tick in &mut x_axis.ticks {
                let (middle, half) = (tick.place * plot_width, width(&tick.label)? / 2.0);
                if middle - half < -overhang || middle + half > plot_width + overhang {
                    tick.label.clear();
                }
            }
            factor_width = if x_axis.factor.is_empty() { 0.0 } else { width(&x_axis.factor)? + LABEL_GAP };
            self.axes = Some((x_axis, y_axis));
        }
        self.title = Paragraph::new(&self.panel.title, self.title.lettering, plot_width)?;
        let centred = Lettering { anchor: Anchor::Middle, ..self.x_label.lettering };
        let mut limit = plot_width - 2.0 * factor_width;
        if limit < ENOUGH_FOR_NAME * plot_width {
            limit = plot_width;
            self.lowered = TICK_EM * LEADING;
        }
        self.x_label = Paragraph::new(&self.panel.x_label, centred, limit)?;
        Ok(())
    }

    /// Room left of the plot.
    pub(super) fn left(&self) -> f64 {
        let label = self.y_label.height();
        TICK_LENGTH + TICK_GAP + self.y_tick_width + if label > 0.0 { label + LABEL_GAP } else { 0.0 }
    }

    /// Room right of the plot.
    pub(super) fn right(&self) -> f64 {
        self.colour_bar.as_ref().map_or(0.0, ColourBar::width)
    }

    /// Room above the plot: heading and the power of ten of the y axis.
    pub(super) fn header(&self) -> f64 {
        let factor = self.axes.as_ref().is_some_and(|(_, y)| !y.factor.is_empty());
        let factor_height = if factor { TICK_EM * LEADING } else { 0.0 };
        let factor_height = self.colour_bar.as_ref().map_or(0.0, ColourBar::factor_height).max(factor_height);
        self.title.height() + factor_height + TITLE_GAP
    }

    /// Room below the plot: tick labels, name of the axis, its power of ten.
    pub(super) fn footer(&self) -> f64 {
        let factor = self.axes.as_ref().is_some_and(|(x, _)| !x.factor.is_empty());
        let factor_height = if factor { TICK_EM * LEADING } else { 0.0 };
        self.footer_of_ticks() + (self.lowered + self.x_label.height()).max(factor_height)
    }

    fn footer_of_ticks(&self) -> f64 {
        let bare = self.panel.bare_x || self.panel.blank || self.panel.polar;
        TICK_LENGTH + if bare { 0.0 } else { TICK_GAP + TICK_EM * LEADING }
    }

    /// Draws the panel around the place of its plot.
    pub(super) fn paint(&self, canvas: &mut Canvas, place: Place) -> Result<(), PlotError> {
        if self.panel.blank {
            return Ok(());
        }
        let Place { label_left, left, right, top, bottom } = place;
        let (across, down) = ((left + right) / 2.0, (top + bottom) / 2.0);
        let under_ticks = bottom + self.footer_of_ticks();
        if let Some((x, y)) = &self.axes {
            Plot { place, x, y }.paint(canvas, self.panel);
            if self.panel.polar {
                polar::numbers(canvas, &Plot { place, x, y });
            } else {
                ticks(canvas, place, x, y);
            }
            let factor = lettering(TICK_EM, false, SOFT_INK);
            canvas.text((left, top - TITLE_GAP), &y.factor, factor);
            let factor = Lettering { anchor: Anchor::End, ..factor };
            canvas.text((right, under_ticks + TICK_EM), &x.factor, factor);
        } else {
            for (from, to) in [((left, top), (right, top)), ((right, top), (right, bottom))] {
                canvas.polyline(&[from, to], Stroke::solid(GRID, 1.0));
            }
            let remark = Lettering { anchor: Anchor::Middle, ..lettering(LABEL_EM, false, SOFT_INK) };
            canvas.text((across, down), "no finite values", remark);
        }
        if !self.panel.polar {
            canvas.polyline(&[(left, top), (left, bottom)], AXIS_STROKE);
            canvas.polyline(&[(left, bottom), (right, bottom)], AXIS_STROKE);
        }
        if let Some(bar) = &self.colour_bar {
            bar.paint(canvas, place, TITLE_GAP);
        }
        self.title.paint(canvas, (left, top - self.header()));
        self.x_label.paint(canvas, (across, under_ticks + self.lowered));
        self.y_label.paint(canvas, (label_left, down));
        match &self.axes {
            Some((x, y)) => labels::paint(canvas, &Plot { place, x, y }, &self.panel.labels, &self.panel.lines),
            None => Ok(()),
        }
    }
}

/// Takes the numbers of an axis away.
fn bare(axis: &mut Axis) {
    axis.factor.clear();
    axis.ticks.iter_mut().for_each(|Tick { label, .. }| label.clear());
}

/// The distance of ticks in a plot with the given side.
fn spaced(distance: f64, side: f64) -> f64 {
    if side < SMALL_PLOT { CLOSER * distance } else { distance }
}

fn y_axis(panel: &Panel, (low, high): (f64, f64), plot_height: f64) -> Axis {
    let intervals = y_intervals(plot_height);
    if panel.y_in_powers { Axis::powers((low, high), intervals) } else { Axis::new(low, high, intervals) }
}

fn y_intervals(plot_height: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "plot heights are small constants")]
    let intervals = (plot_height / spaced(BETWEEN_TICKS, plot_height)) as usize;
    intervals
}

/// Draws the ticks with their labels.
fn ticks(canvas: &mut Canvas, place: Place, x: &Axis, y: &Axis) {
    let Place { left, right, top, bottom, .. } = place;
    let style = lettering(TICK_EM, false, SOFT_INK);
    for tick in &x.ticks {
        let at = left + tick.place * (right - left);
        canvas.polyline(&[(at, bottom), (at, bottom + TICK_LENGTH)], AXIS_STROKE);
        let baseline = bottom + TICK_LENGTH + TICK_GAP + CAPITALS * TICK_EM;
        canvas.text((at, baseline), &tick.label, Lettering { anchor: Anchor::Middle, ..style });
    }
    for tick in &y.ticks {
        let at = bottom - tick.place * (bottom - top);
        canvas.polyline(&[(left - TICK_LENGTH, at), (left, at)], AXIS_STROKE);
        let baseline = at + CAPITALS / 2.0 * TICK_EM;
        canvas.text((left - TICK_LENGTH - TICK_GAP, baseline), &tick.label, Lettering { anchor: Anchor::End, ..style });
    }
}
