//! Pictures as `OpenEXR`: linear light in 32 bits a channel.

use super::ExportError;
use exr::prelude::{Encoding, Image, SpecificChannels, Vec2, WritableImage};
use std::io::Cursor;

/// An `OpenEXR` file with the channels R, G, B, A: linear sRGB (Rec. 709 primaries) times alpha, as the format has it.
///
/// # Shape
/// `pixels: [height][width][red, green, blue, alpha]`, the upper row first.
///
/// # Errors
/// [`ExportError::Shape`] if the pixels are not as many as the size says, [`ExportError::Exr`] if the writer fails.
pub fn exr(width: usize, height: usize, pixels: &[[f32; 4]]) -> Result<Vec<u8>, ExportError> {
    if width == 0 || height == 0 || pixels.len() != width * height {
        return Err(ExportError::Shape { shape: vec![height, width, 4], values: 4 * pixels.len() });
    }
    let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
        let [red, green, blue, alpha] = pixels.get(at.y() * width + at.x()).copied().unwrap_or_default();
        (red, green, blue, alpha)
    });
    let image = Image::from_encoded_channels((width, height), Encoding::SMALL_LOSSLESS, channels);
    let mut file = Cursor::new(Vec::new());
    let written = image.write().non_parallel().to_buffered(&mut file);
    written.map_err(|error| ExportError::Exr { problem: error.to_string() })?;
    Ok(file.into_inner())
}
