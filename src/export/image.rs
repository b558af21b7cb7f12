//! Pictures as bytes: PNG, animated PNG, and `OpenEXR`.

use super::ExportError;
use std::num::NonZero;

/// A picture of 8 bits a channel.
///
/// # Shape
/// `bytes: [height][width][red, green, blue, alpha]`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels across.
    pub width: usize,
    /// Pixels upwards.
    pub height: usize,
    /// sRGB and alpha.
    pub bytes: Vec<u8>,
}

impl Pixels {
    /// Pictures of the same width under each other, from the first at the top; none of no pictures or of different widths.
    #[must_use]
    pub fn stacked(pictures: &[Self]) -> Option<Self> {
        let width = pictures.first()?.width;
        let fits = pictures.iter().all(|picture| picture.width == width);
        let height = pictures.iter().map(|picture| picture.height).sum();
        fits.then(|| Self {
            width,
            height,
            bytes: pictures.iter().flat_map(|picture| &picture.bytes).copied().collect(),
        })
    }

    fn side(side: usize) -> u32 {
        u32::try_from(side).unwrap_or(u32::MAX)
    }

    fn encoder<'a>(&self, file: &'a mut Vec<u8>, colour: png::ColorType) -> png::Encoder<'a, &'a mut Vec<u8>> {
        let mut encoder = png::Encoder::new(file, Self::side(self.width), Self::side(self.height));
        encoder.set_color(colour);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Balanced);
        encoder
    }

    /// The bytes, without alpha where every pixel is opaque.
    fn packed(&self) -> (png::ColorType, Vec<u8>) {
        let pixels = self.bytes.as_chunks::<4>().0;
        if pixels.iter().all(|pixel| pixel[3] == u8::MAX) {
            return (
                png::ColorType::Rgb,
                pixels.iter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]).collect(),
            );
        }
        (png::ColorType::Rgba, self.bytes.clone())
    }
}

/// A PNG file; without an alpha channel where every pixel is opaque.
///
/// # Errors
/// [`ExportError::Png`] for a picture without pixels, or whose bytes do not fit its size.
pub fn png(picture: &Pixels) -> Result<Vec<u8>, ExportError> {
    let mut file = Vec::new();
    let (colour, bytes) = picture.packed();
    let mut writer = picture.encoder(&mut file, colour).write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

/// An animated PNG of `count` frames, which begins again for ever. Frames are taken one by one, so that few are in memory.
///
/// - `frames_per_second`: how fast they are shown.
///
/// # Shape
/// A frame: `[height][width][red, green, blue, alpha]`.
///
/// # Errors
/// That of a frame; as [`png()`]; and for no frames, or another number of them than `count`.
pub fn animated_png<E: From<ExportError>>(
    (width, height): (usize, usize),
    count: usize,
    frames_per_second: NonZero<u16>,
    frames: impl Iterator<Item = Result<Vec<u8>, E>>,
) -> Result<Vec<u8>, E> {
    let mut file = Vec::new();
    let broken = |error: png::EncodingError| E::from(ExportError::from(error));
    let mut encoder = Pixels { width, height, bytes: Vec::new() }.encoder(&mut file, png::ColorType::Rgba);
    encoder.set_animated(Pixels::side(count), 0).map_err(broken)?;
    encoder.validate_sequence(true);
    encoder.set_frame_delay(1, frames_per_second.get()).map_err(broken)?;
    let mut writer = encoder.write_header().map_err(broken)?;
    for frame in frames {
        writer.write_image_data(&frame?).map_err(broken)?;
    }
    writer.finish().map_err(broken)?;
    Ok(file)
}

/// A map as a PNG of 16 bits: grey, grey and alpha, RGB, or RGB and alpha.
///
/// # Shape
/// `values: [height][width][channels]`, from 0 to 1; what lies beyond is cut.
///
/// # Errors
/// As [`png()`].
pub fn png16(width: usize, height: usize, channels: usize, values: &[f32]) -> Result<Vec<u8>, ExportError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, Pixels::side(width), Pixels::side(height));
    encoder.set_color(match channels {
        1 => png::ColorType::Grayscale,
        2 => png::ColorType::GrayscaleAlpha,
        3 => png::ColorType::Rgb,
        _ => png::ColorType::Rgba,
    });
    encoder.set_depth(png::BitDepth::Sixteen);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 65535")]
    let level = |value: &f32| (f32::from(u16::MAX) * value.clamp(0.0, 1.0)).round() as u16;
    let bytes: Vec<u8> = values.iter().flat_map(|value| level(value).to_be_bytes()).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: NonZero<u16> = NonZero::new(10).unwrap();

    fn plain(width: usize, height: usize, pixel: [u8; 4]) -> Pixels {
        Pixels { width, height, bytes: pixel.repeat(width * height) }
    }

    #[test]
    fn an_opaque_picture_has_no_alpha() {
        let decoded = |file: Vec<u8>| crate::render::Raster::from_png(&file).unwrap();
        let opaque = decoded(png(&plain(3, 2, [255, 0, 51, 255])).unwrap());
        assert_eq!((opaque.width(), opaque.height(), opaque.values()), (3, 2, &[1.0, 0.0, 0.2].repeat(6)[..]));
        let clear = decoded(png(&plain(3, 2, [255, 0, 51, 102])).unwrap());
        assert_eq!((clear.channels(), clear.alpha(2, 1)), (4, Some(0.4)));
    }

    #[test]
    fn pictures_are_stacked_if_they_have_the_same_width() {
        let stacked = Pixels::stacked(&[plain(2, 1, [1; 4]), plain(2, 3, [2; 4])]).unwrap();
        assert_eq!((stacked.width, stacked.height), (2, 4));
        assert_eq!((stacked.bytes[7], stacked.bytes[8]), (1, 2));
        assert!(Pixels::stacked(&[plain(2, 1, [1; 4]), plain(3, 1, [2; 4])]).is_none());
        assert!(Pixels::stacked(&[]).is_none());
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert!(png(&Pixels { bytes: vec![0; 7], ..plain(1, 2, [0; 4]) }).is_err());
        assert!(png(&plain(0, 2, [0; 4])).is_err());
        let animated = |count, given: usize| {
            let frames = (0..given).map(|_| Ok(vec![9; 16]));
            animated_png::<ExportError>((2, 2), count, RATE, frames)
        };
        assert!(animated(2, 2).is_ok());
        for (count, given) in [(0, 0), (2, 1)] {
            assert!(animated(count, given).is_err(), "{given} of {count} frames");
        }
    }
}
