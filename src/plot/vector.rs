//! Marks to SVG.

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, RGBColor, ShapeStyle, TextStyle};

use super::canvas::{Anchor, Lettering, Mark, STEPS, steps};
use super::{PlotError, font};

/// The SVG writer divides a font size by this to get ems.
const WRITER_EMS: f64 = 1.24;

/// The SVG writer puts the baseline of a text anchored at its top this many ems below the given point.
const WRITER_BASELINE: f64 = 0.76;

/// An SVG document of the given size in picture units, on white.
pub(super) fn render(marks: &[Mark], width: u32, height: u32) -> Result<String, PlotError> {
    let mut written = String::new();
    let mut backend = SVGBackend::with_string(&mut written, (width * STEPS, height * STEPS));
    for mark in marks {
        write(&mut backend, mark)?;
    }
    backend.present().map_err(failed)?;
    drop(backend);
    // The writer's first line is the opening tag, with the grid steps as the size. Ours states the picture's own size
    // and rounds the corners of the lines.
    let body = written.split_once('\n').map_or("", |(_, body)| body);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" \
         stroke-linejoin=\"round\">\n<rect width=\"100%\" height=\"100%\" fill=\"#FFFFFF\"/>\n{body}",
        width * STEPS,
        height * STEPS,
    ))
}

fn failed(source: impl std::error::Error + Send + Sync + 'static) -> PlotError {
    PlotError::Drawing { format: "SVG", source: Box::new(source) }
}

fn write(backend: &mut SVGBackend<'_>, mark: &Mark) -> Result<(), PlotError> {
    match mark {
        Mark::Rectangle { from, to, colour } => backend.draw_rect(place(*from), place(*to), colour, true),
        Mark::Polyline { points, colour, width } => {
            backend.draw_path(points.iter().copied().map(place), &stroke(*colour, *width))
        }
        Mark::Disc { centre, radius, colour } => {
            backend.draw_circle(place(*centre), steps(*radius).unsigned_abs(), colour, true)
        }
        Mark::Text { baseline, text, lettering } => {
            let top = text_top(*baseline, lettering, WRITER_BASELINE);
            backend.draw_text(text, &style(lettering, WRITER_EMS), top)
        }
    }
    .map_err(failed)
}

fn place((x, y): (f64, f64)) -> (i32, i32) {
    (steps(x), steps(y))
}

fn stroke(colour: RGBColor, width: f64) -> ShapeStyle {
    colour.stroke_width(steps(width).unsigned_abs().max(1))
}

/// Where the renderers want a text whose baseline they put `drop` ems below (right of, if it runs upwards) that point.
pub(super) fn text_top((x, y): (f64, f64), lettering: &Lettering, drop: f64) -> (i32, i32) {
    let drop = drop * lettering.em;
    place(if lettering.upwards { (x - drop, y) } else { (x, y - drop) })
}

/// The lettering for a renderer in whose sizes an em is `ems` high.
pub(super) fn style(lettering: &Lettering, ems: f64) -> TextStyle<'static> {
    let horizontal = match lettering.anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
        Anchor::End => HPos::Right,
    };
    let font = font::description(lettering.em * ems * f64::from(STEPS), lettering.bold);
    let font = if lettering.upwards { font.transform(FontTransform::Rotate270) } else { font };
    TextStyle { font, color: lettering.colour.to_backend_color(), pos: Pos::new(horizontal, VPos::Top) }
}
