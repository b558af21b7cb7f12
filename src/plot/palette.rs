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
