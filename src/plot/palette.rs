//! Colours that readers with any kind of colour vision can tell apart.
//!
//! # Source
//! Okabe and Ito, *Color Universal Design* (2008), figure 16. The order is ours: strong contrast with white comes
//! first, yellow, which has little, comes last.

use plotters::style::RGBColor;

/// The colours of the series, in the order in which they should be used.
pub const OKABE_ITO: [RGBColor; 8] = [
    RGBColor(0, 114, 178),   // blue
    RGBColor(213, 94, 0),    // vermilion
    RGBColor(0, 158, 115),   // bluish green
    RGBColor(230, 159, 0),   // orange
    RGBColor(204, 121, 167), // reddish purple
    RGBColor(86, 180, 233),  // sky blue
    RGBColor(0, 0, 0),       // black
    RGBColor(240, 228, 66),  // yellow
];

/// Viridis at 17 equal steps; between them the colours are mixed in sRGB, at most 6 of 255 in a channel from the full table.
///
/// # Source
/// Smith and van der Walt, *A better default colormap for Matplotlib* (`SciPy` 2015), the table of matplotlib, CC0.
pub const VIRIDIS: [RGBColor; 17] = [
    RGBColor(68, 1, 84),
    RGBColor(72, 24, 106),
    RGBColor(71, 45, 123),
    RGBColor(66, 64, 134),
    RGBColor(59, 82, 139),
    RGBColor(51, 99, 141),
    RGBColor(44, 114, 142),
    RGBColor(38, 129, 142),
    RGBColor(33, 144, 140),
    RGBColor(31, 159, 136),
    RGBColor(40, 174, 128),
    RGBColor(62, 188, 116),
    RGBColor(93, 201, 99),
    RGBColor(130, 211, 76),
    RGBColor(171, 220, 50),
    RGBColor(213, 226, 26),
    RGBColor(253, 231, 37),
];

/// Text and axes.
pub const INK: RGBColor = RGBColor(34, 34, 34);
/// Text of second rank: subtitle, tick labels, remarks.
pub const SOFT_INK: RGBColor = RGBColor(80, 80, 80);
/// Lines of the grid.
pub const GRID: RGBColor = RGBColor(228, 228, 228);
/// Shaded bands, lighter than the grid that crosses them.
pub const BAND: RGBColor = RGBColor(241, 241, 241);
/// Paper.
pub const PAPER: RGBColor = RGBColor(255, 255, 255);

/// Colour number `index` of the palette; after the last comes the first again.
///
/// ```
/// use morpho_fit::plot::palette::{OKABE_ITO, colour};
/// assert_eq!(colour(9), OKABE_ITO[1]);
/// ```
#[must_use]
pub fn colour(index: usize) -> RGBColor {
    OKABE_ITO[index % OKABE_ITO.len()]
}

/// The colour thinned with white: `share` 1 leaves it, 0 gives white; outside `[0, 1]` the nearest of the two.
///
/// ```
/// use morpho_fit::plot::palette::{INK, PAPER, tint};
/// assert_eq!((tint(INK, 1.0), tint(INK, 0.0)), (INK, PAPER));
/// ```
#[must_use]
pub fn tint(colour: RGBColor, share: f64) -> RGBColor {
    let share = share.clamp(0.0, 1.0);
    let thin = |channel: u8| {
        let value = 255.0 - share * (255.0 - f64::from(channel));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..=255 by the clamp above")]
        let byte = value.round() as u8;
        byte
    };
    RGBColor(thin(colour.0), thin(colour.1), thin(colour.2))
}

/// The colour of a share of the way through [`VIRIDIS`]; outside `[0, 1]` the nearest end, not a number is the low end.
///
/// ```
/// use morpho_fit::plot::palette::{VIRIDIS, viridis};
/// assert_eq!((viridis(0.0), viridis(0.5), viridis(7.0)), (VIRIDIS[0], VIRIDIS[8], VIRIDIS[16]));
/// ```
#[must_use]
pub fn viridis(share: f64) -> RGBColor {
    let steps = VIRIDIS.len() - 1;
    let place = share.clamp(0.0, 1.0) * steps as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..=16; not a number becomes 0")]
    let index = (place as usize).min(steps - 1);
    let part = if place.is_finite() { place - index as f64 } else { 0.0 };
    let mixed = |from: u8, to: u8| {
        let value = (1.0 - part) * f64::from(from) + part * f64::from(to);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
        let byte = value.round() as u8;
        byte
    };
    let (low, high) = (VIRIDIS[index], VIRIDIS[index + 1]);
    RGBColor(mixed(low.0, high.0), mixed(low.1, high.1), mixed(low.2, high.2))
}
