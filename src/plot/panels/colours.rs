//! Values of a heat map to colours, and the colour bar that explains them. All lengths are picture units.

use plotters::style::RGBColor;

use super::super::canvas::{Anchor, Canvas, Lettering, Stroke};
use super::super::palette::{INK, OKABE_ITO, SOFT_INK, tint, viridis};
use super::super::{PlotError, font};
use super::axis::{Axis, Tick, is_drawable, range_of, ratio_ticks, widened};
use super::layout::{LEADING, Paragraph, lettering};
use super::panel::{CAPITALS, LABEL_EM, LABEL_GAP, Place, TICK_EM, TICK_GAP, TICK_LENGTH};
use super::{ColourMap, ColourScale, HeatMap};

/// Different colours in a map. More make the SVG larger: neighbours of one colour are drawn as one.
const COLOURS: f64 = 96.0;
/// Room between the plot and the bar, and width of the bar.
const BAR_GAP: f64 = 12.0;
const BAR_WIDTH: f64 = 16.0;
/// How much higher than that of an axis the power of ten stands: the uppermost tick label is below it.
const ABOVE_TICK: f64 = 5.0;
/// Ticks of the bar are at least this far apart.
const BETWEEN_TICKS: f64 = 36.0;

/// How the values of one map become colours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Colours {
    map: ColourMap,
    scale: ColourScale,
    low: f64,
    high: f64,
}

impl Colours {
    /// The requested range, or that of the values; none if there is no value with a colour.
    pub(super) fn of(heat: &HeatMap) -> Option<Self> {
        let coloured = |value: &f64| heat.scale == ColourScale::Linear || *value > 0.0;
        let range = heat.range.or_else(|| range_of(heat.values.iter().copied().filter(coloured), 0.0))?;
        let (low, high) = match heat.scale {
            ColourScale::Linear => widened(range.0, range.1),
            // A ratio that cannot be told from one.
            ColourScale::Logarithmic if range.1 / range.0 < 1.0 + 1e-6 => (range.0 / 2.0, range.1 * 2.0),
            ColourScale::Logarithmic => range,
        };
        Some(Self { map: heat.colours, scale: heat.scale, low, high })
    }

    /// The number of the colour of a value, from 0; none for one that is not a number.
    pub(super) fn number(&self, value: f64) -> Option<u32> {
        if value.is_nan() {
            return None;
        }
        let share = match self.scale {
            ColourScale::Linear => (value.clamp(self.low, self.high) - self.low) / (self.high - self.low),
            ColourScale::Logarithmic => {
                let value = value.clamp(self.low, self.high);
                (value.log10() - self.low.log10()) / (self.high.log10() - self.low.log10())
            }
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..COLOURS by the clamp")]
        let number = (share.clamp(0.0, 1.0) * COLOURS).min(COLOURS - 1.0) as u32;
        Some(number)
    }

    /// The colour of a number.
    pub(super) fn colour(&self, number: u32) -> RGBColor {
        let share = f64::from(number) / (COLOURS - 1.0);
        match self.map {
            ColourMap::Viridis => viridis(share),
            ColourMap::ViridisReversed => viridis(1.0 - share),
            ColourMap::White => tint(OKABE_ITO[0], share),
        }
    }

    /// Ticks of the bar and their common power of ten; a tick at an end beyond which there are values says so.
    fn ticks(&self, values: &[f64], most: usize) -> (Vec<Tick>, String) {
        let (mut ticks, factor) = match self.scale {
            ColourScale::Linear => {
                let axis = Axis::new(self.low, self.high, most);
                (axis.ticks, axis.factor)
            }
            ColourScale::Logarithmic => (ratio_ticks(self.low, self.high, most), String::new()),
        };
        let (below, above) =
            (values.iter().any(|&value| value < self.low), values.iter().any(|&value| value > self.high));
        for tick in &mut ticks {
            if below && tick.place < 1e-6 {
                tick.label = format!("≤ {}", tick.label);
            } else if above && tick.place > 1.0 - 1e-6 {
                tick.label = format!("≥ {}", tick.label);
            }
        }
        (ticks, factor)
    }
}

/// The bar beside a heat map.
#[derive(Debug)]
pub(super) struct ColourBar {
    colours: Colours,
    ticks: Vec<Tick>,
    factor: String,
    tick_width: f64,
    label: Paragraph,
}

impl ColourBar {
    /// The bar of a map with a label; none if it has no label or no value.
    pub(super) fn new(heat: &HeatMap, plot_height: f64) -> Result<Option<Self>, PlotError> {
        let Some(colours) = Colours::of(heat).filter(|_| !heat.label.trim().is_empty()) else { return Ok(None) };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "plots are at most 16000 high")]
        let most = (plot_height / BETWEEN_TICKS) as usize;
        let drawn: Vec<f64> = heat.values.iter().copied().filter(|&value| is_drawable(value)).collect();
        let (ticks, factor) = colours.ticks(&drawn, most);
        let mut tick_width = font::width(&factor, TICK_EM, false)? - TICK_LENGTH - TICK_GAP;
        for tick in &ticks {
            tick_width = tick_width.max(font::width(&tick.label, TICK_EM, false)?);
        }
        let upwards = Lettering { anchor: Anchor::Middle, upwards: true, ..lettering(LABEL_EM, false, INK) };
        let label = Paragraph::new(&heat.label, upwards, plot_height)?;
        Ok(Some(Self { colours, ticks, factor, tick_width, label }))
    }

    /// Room right of the plot.
    pub(super) fn width(&self) -> f64 {
        BAR_GAP + BAR_WIDTH + TICK_LENGTH + TICK_GAP + self.tick_width + LABEL_GAP + self.label.height()
    }

    /// True if a power of ten stands above the bar.
    pub(super) fn has_factor(&self) -> bool {
        !self.factor.is_empty()
    }

    pub(super) fn paint(&self, canvas: &mut Canvas, place: Place, factor_gap: f64) {
        let Place { right, top, bottom, .. } = place;
        let (from, to) = (right + BAR_GAP, right + BAR_GAP + BAR_WIDTH);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small constant")]
        let count = COLOURS as u32;
        for number in 0..count {
            let foot = bottom - (bottom - top) * f64::from(number) / COLOURS;
            // Up to the top, so that no seam shows; the next ones cover it.
            canvas.rectangle((from, foot), (to, top), self.colours.colour(number));
        }
        let outline = [(from, top), (to, top), (to, bottom), (from, bottom), (from, top)];
        canvas.polyline(&outline, Stroke::solid(INK, 1.0));
        let style = lettering(TICK_EM, false, SOFT_INK);
        for tick in &self.ticks {
            let at = bottom - tick.place * (bottom - top);
            canvas.polyline(&[(to, at), (to + TICK_LENGTH, at)], Stroke::solid(INK, 1.0));
            let baseline = at + CAPITALS / 2.0 * TICK_EM;
            canvas.text((to + TICK_LENGTH + TICK_GAP, baseline), &tick.label, style);
        }
        canvas.text((to, top - factor_gap - ABOVE_TICK), &self.factor, style);
        let label_left = to + TICK_LENGTH + TICK_GAP + self.tick_width + LABEL_GAP;
        self.label.paint(canvas, (label_left, f64::midpoint(top, bottom)));
    }

    /// Height of the power of ten above the bar.
    pub(super) fn factor_height(&self) -> f64 {
        if self.has_factor() { TICK_EM * LEADING + ABOVE_TICK } else { 0.0 }
    }
}
