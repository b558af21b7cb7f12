//! An image in memory, and PNG files to images.

use super::error::RenderError;
use png::{ColorType, Decoder, Limits, Transformations};
use std::io::Cursor;

/// Pixels each way at most.
pub const MOST_SIDE: usize = 16_384;
/// Pixels of an image at most: maps of this size take 5 GB (75 bytes a pixel, measured), and 3 GB when they are ready for rays.
pub const MOST_PIXELS: usize = 1 << 26;

/// Values from 0 to 1 at the pixels of an image, the upper row first.
///
/// # Shape
/// `values: [height][width][channels]`, with 1 (grey), 2 (grey, alpha), 3 (RGB) or 4 (RGB, alpha) channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    width: usize,
    height: usize,
    channels: usize,
    values: Vec<f32>,
}

impl Raster {
    /// # Errors
    /// [`RenderError::Size`] for no pixels or too many, [`RenderError::Values`] for a number of values that does not fit, or
    /// one that is not finite.
    ///
    /// ```
    /// use morpho_fit::render::Raster;
    /// let grey = Raster::new(2, 1, 1, vec![0.0, 1.0])?;
    /// assert_eq!((grey.width(), grey.height(), grey.at(1, 0, 0)), (2, 1, 1.0));
    /// # Ok::<(), morpho_fit::render::RenderError>(())
    /// ```
    pub fn new(width: usize, height: usize, channels: usize, values: Vec<f32>) -> Result<Self, RenderError> {
        size(width, height)?;
        let fits = (1..=4).contains(&channels) && values.len() == width * height * channels;
        if !fits || values.iter().any(|value| !value.is_finite()) {
            return Err(RenderError::Values { width, height, channels });
        }
        Ok(Self { width, height, channels, values })
    }

    /// The image of a PNG file: 8 or 16 bits, grey, RGB or a palette, with alpha or without. Of an animated one it is the
    /// first frame. A palette becomes RGB, levels of fewer bits are spread over 0 to 1.
    ///
    /// # Errors
    /// [`RenderError::Png`] for bytes that are no PNG, or a broken one; [`RenderError::Size`] for one that is too large.
    pub fn from_png(file: &[u8]) -> Result<Self, RenderError> {
        let broken = |error: png::DecodingError| RenderError::Png { problem: problem(&error).to_owned() };
        let mut decoder = Decoder::new_with_limits(Cursor::new(file), Limits { bytes: usize::MAX });
        decoder.set_transformations(Transformations::EXPAND);
        // Neither is used, and a few bytes of either can unpack to a gigabyte.
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let info = decoder.read_header_info().map_err(broken)?;
        let pixels = |side: u32| usize::try_from(side).unwrap_or(usize::MAX);
        let (width, height) = (pixels(info.width), pixels(info.height));
        size(width, height)?;
        let mut reader = decoder.read_info().map_err(broken)?;
        let length = reader.output_buffer_size().ok_or(RenderError::Size { width, height })?;
        let mut bytes = vec![0; length];
        let frame = reader.next_frame(&mut bytes).map_err(broken)?;
        if (pixels(frame.width), pixels(frame.height)) != (width, height) {
            return Err(RenderError::Png { problem: "its first frame is not the whole image".to_owned() });
        }
        let channels = match frame.color_type {
            ColorType::Grayscale => 1,
            ColorType::GrayscaleAlpha => 2,
            ColorType::Rgb | ColorType::Indexed => 3,
            ColorType::Rgba => 4,
        };
        let bytes = bytes.get(..frame.buffer_size()).unwrap_or_default();
        let values: Vec<f32> = match frame.bit_depth {
            png::BitDepth::Sixteen => bytes.as_chunks().0.iter().map(|pair| level16(*pair)).collect(),
            _ => bytes.iter().map(|&byte| f32::from(byte) / f32::from(u8::MAX)).collect(),
        };
        Self::new(width, height, channels, values)
    }

    /// Pixels across.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels upwards.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Values of a pixel.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// All values, row by row.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// A value of the pixel in a column from the left and a row from the top; beyond the image that of its edge.
    #[must_use]
    pub fn at(&self, column: usize, row: usize, channel: usize) -> f32 {
        let pixel = row.min(self.height - 1) * self.width + column.min(self.width - 1);
        self.values.get(pixel * self.channels + channel.min(self.channels - 1)).copied().unwrap_or_default()
    }

    /// The mean of its colours, alpha left out.
    #[must_use]
    pub fn grey(&self, column: usize, row: usize) -> f32 {
        if self.channels < 3 {
            return self.at(column, row, 0);
        }
        (self.at(column, row, 0) + self.at(column, row, 1) + self.at(column, row, 2)) / 3.0
    }

    /// Alpha; none for an image without.
    #[must_use]
    pub fn alpha(&self, column: usize, row: usize) -> Option<f32> {
        self.channels.is_multiple_of(2).then(|| self.at(column, row, self.channels - 1))
    }

    /// Whether its colours are more than greys.
    #[must_use]
    pub fn is_coloured(&self) -> bool {
        #[allow(clippy::float_cmp, reason = "levels of a file, the same or not")]
        let differs = |pixel: &[f32]| pixel[0] != pixel[1] || pixel[1] != pixel[2];
        self.channels >= 3 && self.values.chunks_exact(self.channels).any(differs)
    }

    /// The linear light of an image whose colours are encoded as sRGB's, IEC 61966-2-1; alpha stays.
    #[must_use]
    pub fn linear(self) -> Self {
        self.recoloured(decoded)
    }

    /// The image with the encoding of sRGB on its linear light; alpha stays.
    #[must_use]
    pub fn encoded(self) -> Self {
        self.recoloured(
            |value| {
                if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 }
            },
        )
    }

    fn recoloured(mut self, of: impl Fn(f32) -> f32) -> Self {
        let colours = if self.channels.is_multiple_of(2) { self.channels - 1 } else { self.channels };
        for pixel in self.values.chunks_exact_mut(self.channels) {
            for value in pixel.iter_mut().take(colours) {
                *value = of(*value);
            }
        }
        self
    }
}

/// What is wrong with a file; the decoder's own words are for programmers.
fn problem(error: &png::DecodingError) -> &'static str {
    let words = error.to_string();
    let begins = |with: &str| words.starts_with(with);
    match error {
        png::DecodingError::IoError(_) => "damaged: it is cut short",
        png::DecodingError::LimitsExceeded => "it needs more memory than there is",
        _ if begins("Invalid PNG signature") => "it does not begin as a PNG does",
        _ if begins("CRC error") => "damaged: a checksum does not match",
        _ if begins("Corrupt deflate stream") => "damaged: its pixels cannot be unpacked",
        _ if begins("IDAT or f") || begins("Unexpected end") => "damaged: it is cut short",
        _ => "damaged: its parts do not fit together",
    }
}

/// Linear light of an encoded channel of sRGB.
pub(super) fn decoded(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn level16(pair: [u8; 2]) -> f32 {
    f32::from(u16::from_be_bytes(pair)) / f32::from(u16::MAX)
}

/// Checks the size of an image.
pub(super) fn size(width: usize, height: usize) -> Result<(), RenderError> {
    let fits = |side: usize| (1..=MOST_SIDE).contains(&side);
    if fits(width) && fits(height) && width * height <= MOST_PIXELS {
        Ok(())
    } else {
        Err(RenderError::Size { width, height })
    }
}
