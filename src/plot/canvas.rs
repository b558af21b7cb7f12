//! The sheet on which a chart is drawn: marks are noted once and then rendered as SVG and as PNG.
//!
//! Lengths are picture units: the SVG has one pixel for each, the PNG two. The origin is the upper left corner,
//! y points down. Later marks cover earlier ones.

use plotters::style::RGBColor;

use super::{PlotError, font, raster, vector};

/// Both renderers work on a grid of this many steps in a picture unit, because they take whole numbers only.
pub(super) const STEPS: u32 = 4;

/// The longest side of a picture, in picture units. Rendering time and file size grow with the area.
pub const LARGEST_SIDE: u32 = 16_000;

/// Marks farther out than this are moved here, in picture units, so that the renderers' integers cannot overflow.
const FARTHEST: f64 = 4.0 * LARGEST_SIDE as f64;

/// A finished chart in two formats with the same content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// An SVG document. Its texts are texts, in the viewer's copy of the font or one like it.
    pub svg: String,
    /// A PNG file, 8-bit RGB, two pixels for each picture unit (192 pixels per inch).
    pub png: Vec<u8>,
}

/// Which point of a text is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Anchor {
    /// Its beginning.
    #[default]
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lettering {
    /// Size of the letters (one em), in picture units.
    pub em: f64,
    /// Bold instead of regular.
    pub bold: bool,
    /// Colour of the letters.
    pub colour: RGBColor,
    /// Which point of the baseline is given.
    pub anchor: Anchor,
    /// Read upwards, as beside a y axis; then the baseline is vertical.
    pub upwards: bool,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour of the line.
    pub colour: RGBColor,
    /// Its width, in picture units.
    pub width: f64,
    /// Length of the dashes and of the gaps, in picture units; none for a solid line.
    pub dashes: Option<(f64, f64)>,
}

impl Stroke {
    /// A solid line.
    #[must_use]
    pub fn solid(colour: RGBColor, width: f64) -> Self {
        Self { colour, width, dashes: None }
    }
}

/// One thing drawn. Coordinates are finite and not farther out than [`FARTHEST`].
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    Rectangle { from: (f64, f64), to: (f64, f64), colour: RGBColor },
    Polyline { points: Vec<(f64, f64)>, colour: RGBColor, width: f64 },
    Disc { centre: (f64, f64), radius: f64, colour: RGBColor },
    Text { baseline: (f64, f64), text: String, lettering: Lettering },
}

/// The marks of one chart. A mark with a coordinate that is not finite is left out.
#[derive(Debug, Default)]
pub struct Canvas {
    pub(super) marks: Vec<Mark>,
}

impl Canvas {
    /// Fills the rectangle between two opposite corners.
    pub fn rectangle(&mut self, from: (f64, f64), to: (f64, f64), colour: RGBColor) {
        if let (Some(a), Some(b)) = (bounded(from), bounded(to)) {
            let mark = Mark::Rectangle { from: (a.0.min(b.0), a.1.min(b.1)), to: (a.0.max(b.0), a.1.max(b.1)), colour };
            self.marks.push(mark);
        }
    }

    /// Draws a line through the points; one point alone becomes a dot.
    pub fn polyline(&mut self, points: &[(f64, f64)], stroke: Stroke) {
        let points: Vec<_> = points.iter().copied().filter_map(bounded).collect();
        let Stroke { colour, width, dashes } = stroke;
        let pieces = match (points.as_slice(), dashes) {
            ([], _) => return,
            ([dot], _) => return self.disc(*dot, width / 2.0, colour),
            (_, Some((dash, gap))) if dash > 0.0 && gap > 0.0 => dashed(&points, dash, gap),
            _ => vec![points],
        };
        self.marks.extend(pieces.into_iter().map(|points| Mark::Polyline { points, colour, width }));
    }

    /// Fills a disc.
    pub fn disc(&mut self, centre: (f64, f64), radius: f64, colour: RGBColor) {
        if let Some(centre) = bounded(centre) {
            self.marks.push(Mark::Disc { centre, radius, colour });
        }
    }

    /// Writes one line of text; `baseline` is where the letters stand. Characters that the embedded font does
    /// not have are written as `?`.
    pub fn text(&mut self, baseline: (f64, f64), text: &str, lettering: Lettering) {
        if let Some(baseline) = bounded(baseline) {
            self.marks.push(Mark::Text { baseline, text: font::printable(text), lettering });
        }
    }
}

/// Draws a picture of the given size, in picture units (fractions are rounded up), in both formats on white.
///
/// ```
/// use morpho_fit::plot::{canvas::Stroke, palette, picture};
///
/// let cross = picture(40.0, 20.0, |canvas| {
///     let stroke = Stroke::solid(palette::INK, 2.0);
///     canvas.polyline(&[(2.0, 2.0), (38.0, 18.0)], stroke);
///     canvas.polyline(&[(2.0, 18.0), (38.0, 2.0)], stroke);
///     Ok(())
/// })?;
/// assert!(cross.svg.starts_with("<svg"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
///
/// # Errors
/// Those of `draw`; [`PlotError::PictureSize`] unless both sides are in `(0, LARGEST_SIDE]`;
/// [`PlotError::Font`], [`PlotError::Drawing`] or [`PlotError::Encoding`] if the libraries below fail.
pub fn picture(
    width: f64,
    height: f64,
    draw: impl FnOnce(&mut Canvas) -> Result<(), PlotError>,
) -> Result<Picture, PlotError> {
    let (Some(columns), Some(rows)) = (side(width), side(height)) else {
        return Err(PlotError::PictureSize { width, height, largest: LARGEST_SIDE });
    };
    font::register()?;
    let mut canvas = Canvas::default();
    draw(&mut canvas)?;
    Ok(Picture {
        svg: vector::render(&canvas.marks, columns, rows)?,
        png: raster::render(&canvas.marks, columns, rows)?,
    })
}

fn side(length: f64) -> Option<u32> {
    if !(length > 0.0 && length <= f64::from(LARGEST_SIDE)) {
        return None;
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "in 1..=LARGEST_SIDE by the check above"
    )]
    let whole = length.ceil() as u32;
    Some(whole)
}

/// A length in grid steps.
pub(super) fn steps(length: f64) -> i32 {
    #[allow(clippy::cast_possible_truncation, reason = "canvas coordinates are bounded; a cast saturates anyway")]
    let whole = (length * f64::from(STEPS)).round() as i32;
    whole
}

fn bounded((x, y): (f64, f64)) -> Option<(f64, f64)> {
    let inside = |value: f64| value.clamp(-FARTHEST, FARTHEST);
    (x.is_finite() && y.is_finite()).then(|| (inside(x), inside(y)))
}

/// The pieces of a line that the dashes cover; the pattern runs on around the corners.
fn dashed(points: &[(f64, f64)], dash: f64, gap: f64) -> Vec<Vec<(f64, f64)>> {
    let Some(&first) = points.first() else { return Vec::new() };
    let mut pieces = Vec::new();
    let mut piece = vec![first];
    let mut left = dash; // of the dash if `piece` has points, else of the gap
    for (&from, &to) in points.iter().zip(points.iter().skip(1)) {
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let at = |done: f64| (from.0 + (to.0 - from.0) * done / length, from.1 + (to.1 - from.1) * done / length);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            if piece.is_empty() {
                piece.push(at(done));
                left = dash;
            } else {
                piece.push(at(done));
                pieces.push(std::mem::take(&mut piece));
                left = gap;
            }
        }
        left -= length - done;
        if !piece.is_empty() {
            piece.push(to);
        }
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::palette::INK;

    #[test]
    fn dashes_run_around_corners() {
        let pieces = dashed(&[(0.0, 0.0), (3.0, 0.0), (3.0, 7.0)], 4.0, 2.0);
        assert_eq!(pieces, [vec![(0.0, 0.0), (3.0, 0.0), (3.0, 1.0)], vec![(3.0, 3.0), (3.0, 7.0)]]);
    }

    #[test]
    fn sizes_that_cannot_be_drawn_are_errors() {
        for (width, height) in [(0.0, 10.0), (10.0, -1.0), (f64::NAN, 10.0), (10.0, 1e9), (f64::INFINITY, 1.0)] {
            let outcome = picture(width, height, |_| Ok(()));
            assert!(matches!(outcome, Err(PlotError::PictureSize { .. })), "{width} x {height}");
        }
    }

    #[test]
    fn marks_off_the_sheet_or_without_place_do_no_harm() {
        let stroke = Stroke::solid(INK, 2.0);
        picture(30.0, 30.0, |canvas| {
            canvas.polyline(&[(-1e300, 5.0), (1e300, 6.0), (f64::NAN, 0.0)], stroke);
            canvas.polyline(&[], stroke);
            canvas.polyline(&[(5.0, 5.0), (5.0, 5.0)], Stroke { dashes: Some((1.0, 0.0)), ..stroke });
            canvas.rectangle((-5.0, 40.0), (90.0, 20.0), INK);
            canvas.rectangle((5.0, 5.0), (5.0, 5.0), INK);
            canvas.disc((29.0, 29.0), 1e6, INK);
            canvas.disc((f64::INFINITY, 29.0), f64::NAN, INK);
            Ok(())
        })
        .unwrap();
    }

    #[test]
    fn the_same_drawing_gives_the_same_bytes() {
        let dot = |canvas: &mut Canvas| {
            canvas.disc((10.0, 10.0), 4.0, INK);
            Ok(())
        };
        assert_eq!(picture(50.0, 20.0, dot).unwrap(), picture(50.0, 20.0, dot).unwrap());
    }
}
