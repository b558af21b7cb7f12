//! Marks to PNG.
//!
//! The bitmap renderer of the drawing library knows whole pixels and has rough edges. So the marks are drawn on a grid
//! twice as fine as the picture's pixels, and each pixel is the mean of four. The picture is made in strips,
//! which keeps the memory small whatever its size.

use plotters::prelude::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, RGBColor};

use super::PlotError;
use super::canvas::{Mark, STEPS, steps};
use super::font::EMS_PER_LINE;
use super::vector::{style, text_top};

/// Pixels for each picture unit.
pub(super) const PIXELS: u32 = 2;

/// Grid steps for each pixel, in both directions.
const OVERSAMPLING: u32 = STEPS / PIXELS;

/// Height of a strip in pixels. Lower strips repeat more work at their edges, higher ones take more memory.
const STRIP: u32 = 256;

/// The bitmap renderer puts the baseline of a text anchored at its top half a line below the given point.
const RENDERER_BASELINE: f64 = EMS_PER_LINE / 2.0;

/// So that programs show the picture in its own size: 96 picture units per inch, here in pixels per metre.
const PIXELS_PER_METRE: u32 = 96 * PIXELS * 10_000 / 254;

/// A PNG file of a picture with the given size in picture units, on white.
pub(super) fn render(marks: &[Mark], width: u32, height: u32) -> Result<Vec<u8>, PlotError> {
    let encoding = |source: png::EncodingError| PlotError::Encoding { source: Box::new(source) };
    let (columns, rows) = (width * PIXELS, height * PIXELS);
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let density = PIXELS_PER_METRE;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: density, yppu: density, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header().map_err(encoding)?;
    let mut stream = writer.stream_writer().map_err(encoding)?;
    let mut first = 0;
    while first < rows {
        let strip_rows = STRIP.min(rows - first);
        let pixels = strip(marks, columns, first, strip_rows)?;
        std::io::Write::write_all(&mut stream, &pixels)
            .map_err(|source| PlotError::Encoding { source: Box::new(source) })?;
        first += strip_rows;
    }
    stream.finish().map_err(encoding)?;
    writer.finish().map_err(encoding)?;
    Ok(file)
}

/// The pixels of the rows from `first` on, three bytes each.
fn strip(marks: &[Mark], columns: u32, first: u32, rows: u32) -> Result<Vec<u8>, PlotError> {
    let (fine_columns, fine_rows) = (columns * OVERSAMPLING, rows * OVERSAMPLING);
    let row_bytes = 3 * fine_columns as usize;
    let mut fine = vec![255; row_bytes * fine_rows as usize];
    let top = f64::from(first) / f64::from(PIXELS);
    let bottom = f64::from(first + rows) / f64::from(PIXELS);
    {
        let mut backend = BitMapBackend::with_buffer(&mut fine, (fine_columns, fine_rows));
        for mark in marks {
            let (highest, lowest) = vertical_extent(mark);
            if lowest >= top && highest <= bottom {
                paint(&mut backend, mark, top)?;
            }
        }
    }
    Ok(averaged(&fine, row_bytes))
}

/// The mean of each square of `OVERSAMPLING` by `OVERSAMPLING` points.
fn averaged(fine: &[u8], row_bytes: usize) -> Vec<u8> {
    const SIDE: usize = OVERSAMPLING as usize;
    const AREA: u32 = OVERSAMPLING * OVERSAMPLING;
    let mut pixels = Vec::with_capacity(fine.len() / (SIDE * SIDE));
    for rows in fine.chunks_exact(SIDE * row_bytes) {
        for column in (0..row_bytes).step_by(3 * SIDE) {
            for channel in column..column + 3 {
                let points = (0..SIDE * SIDE).map(|i| (i / SIDE) * row_bytes + channel + 3 * (i % SIDE));
                let sum: u32 = points.filter_map(|point| rows.get(point)).map(|&byte| u32::from(byte)).sum();
                pixels.push(u8::try_from((sum + AREA / 2) / AREA).unwrap_or(u8::MAX));
            }
        }
    }
    pixels
}

/// Upper and lower end of a mark, generously, in picture units.
fn vertical_extent(mark: &Mark) -> (f64, f64) {
    match mark {
        Mark::Rectangle { from, to, .. } => (from.1 - 1.0, to.1 + 1.0),
        Mark::Polyline { points, width, .. } => {
            let (low, high) = points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), point| (low.min(point.1), high.max(point.1)));
            (low - width - 1.0, high + width + 1.0)
        }
        Mark::Disc { centre, radius, .. } => (centre.1 - radius - 1.0, centre.1 + radius + 1.0),
        Mark::Text { baseline, text, lettering } => {
            let letters = if lettering.upwards { text.chars().count() as f64 } else { 1.0 };
            let reach = 1.5 * lettering.em * letters.max(1.0);
            (baseline.1 - reach, baseline.1 + reach)
        }
    }
}

fn failed(source: impl std::error::Error + Send + Sync + 'static) -> PlotError {
    PlotError::Drawing { format: "PNG", source: Box::new(source) }
}

/// Draws one mark on a sheet whose upper edge is at `top`.
fn paint(backend: &mut BitMapBackend<'_>, mark: &Mark, top: f64) -> Result<(), PlotError> {
    let place = |(x, y): (f64, f64)| (steps(x), steps(y - top));
    match mark {
        Mark::Rectangle { from, to, colour } => {
            backend.draw_rect(place(*from), place(*to), colour, true).map_err(failed)
        }
        Mark::Polyline { points, colour, width } => {
            let points: Vec<_> = points.iter().copied().map(place).collect();
            polyline(backend, &points, steps(*width).max(1), *colour)
        }
        Mark::Disc { centre, radius, colour } => {
            backend.draw_circle(place(*centre), steps(*radius).unsigned_abs(), colour, true).map_err(failed)
        }
        Mark::Text { baseline: (x, y), text, lettering } => {
            let position = text_top((*x, *y - top), lettering, RENDERER_BASELINE);
            backend.draw_text(text, &style(lettering, EMS_PER_LINE), position).map_err(failed)
        }
    }
}

/// Draws each straight piece as a filled box and rounds the corners with discs. (The library's own wide lines show
/// holes where they turn sharply.)
fn polyline(
    backend: &mut BitMapBackend<'_>,
    points: &[(i32, i32)],
    width: i32,
    colour: RGBColor,
) -> Result<(), PlotError> {
    for (&from, &to) in points.iter().zip(points.iter().skip(1)) {
        segment(backend, from, to, width, colour)?;
    }
    for &corner in points.iter().skip(1).take(points.len().saturating_sub(2)) {
        backend.draw_circle(corner, (width / 2).unsigned_abs(), &colour, true).map_err(failed)?;
    }
    Ok(())
}

fn segment(
    backend: &mut BitMapBackend<'_>,
    from: (i32, i32),
    to: (i32, i32),
    width: i32,
    colour: RGBColor,
) -> Result<(), PlotError> {
    if from == to {
        return Ok(());
    }
    if from.0 == to.0 || from.1 == to.1 {
        // Upright and level lines are rectangles, sharp at the pixel's edge.
        let (before, after) = (width / 2, width - width / 2);
        let (low, high) = ((from.0.min(to.0), from.1.min(to.1)), (from.0.max(to.0), from.1.max(to.1)));
        return if from.0 == to.0 {
            backend.draw_rect((low.0 - before, low.1), (high.0 + after, high.1), &colour, true)
        } else {
            backend.draw_rect((low.0, low.1 - before), (high.0, high.1 + after), &colour, true)
        }
        .map_err(failed);
    }
    let (along_x, along_y) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
    let half = f64::from(width) / 2.0 / along_x.hypot(along_y);
    #[allow(clippy::cast_possible_truncation, reason = "canvas coordinates are bounded")]
    let shifted = |(x, y): (i32, i32), sign: f64| {
        let moved = (f64::from(x) - sign * half * along_y, f64::from(y) + sign * half * along_x);
        (moved.0.round() as i32, moved.1.round() as i32)
    };
    let corners = [shifted(from, 1.0), shifted(to, 1.0), shifted(to, -1.0), shifted(from, -1.0)];
    backend.fill_polygon(corners, &colour.filled()).map_err(failed)
}

/// Width, height and pixels of a PNG file.
#[cfg(test)]
pub(super) fn decode(file: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((frame.color_type, frame.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (frame.width, frame.height, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_decodes_to_two_pixels_a_unit() {
        let colour = RGBColor(10, 20, 30);
        let mark = Mark::Rectangle { from: (0.0, 0.0), to: (5.0, 300.0), colour };
        let (width, height, pixels) = decode(&render(&[mark], 10, 300).unwrap());
        assert_eq!((width, height, pixels.len()), (20, 600, 3 * 20 * 600));
        for (i, pixel) in pixels.chunks(3).enumerate() {
            let expected = if i % 20 < 10 { [10, 20, 30] } else { [255, 255, 255] };
            assert_eq!(pixel, expected, "row {}, column {}", i / 20, i % 20);
        }
    }

    #[test]
    fn strips_join_without_a_seam() {
        let colour = RGBColor(0, 0, 0);
        let centre = (20.0, f64::from(STRIP / PIXELS));
        let (width, _, pixels) = decode(&render(&[Mark::Disc { centre, radius: 15.0, colour }], 40, 256).unwrap());
        let rows: Vec<&[u8]> = pixels.chunks(3 * width as usize).collect();
        let seam = STRIP as usize;
        let black = rows[seam].iter().filter(|&&byte| byte == 0).count() / 3;
        assert!((58..=60).contains(&black), "{black} black pixels across");
        for offset in 0..25 {
            let difference = rows[seam - 1 - offset].iter().zip(rows[seam + offset]).filter(|(a, b)| a != b).count();
            assert!(difference <= 3 * 8, "rows {offset} from the seam differ in {difference} bytes");
        }
    }
}
