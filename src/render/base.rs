//! What lies below the scales: a Lambertian base, which is not from the paper.

use crate::colorimetry::{ColourError, RgbSpace, Xyz};

/// Linear sRGB of a brown of melanin, of luminance 1 for a reflectance of 1.
///
/// Melanin absorbs more towards violet; the ratios are chosen by eye, not measured.
pub const BROWN: [f64; 3] = [1.75, 0.83, 0.46];

/// The matrix, by rows, from linear sRGB of a reflectance to its XYZ in light of this white.
///
/// Each of X, Y and Z goes with that of the white: exact for greys and for D65.
pub(super) fn to_xyz(white: Xyz) -> Result<[[f64; 3]; 3], ColourError> {
    let of = |linear| RgbSpace::Srgb.xyz(linear).map(Xyz::to_array);
    let columns = [of([1.0, 0.0, 0.0])?, of([0.0, 1.0, 0.0])?, of([0.0, 0.0, 1.0])?];
    let white = white.to_array();
    Ok(std::array::from_fn(|row| {
        let of_grey: f64 = columns.iter().map(|column| column[row]).sum();
        std::array::from_fn(|column| columns[column][row] * white[row] / of_grey)
    }))
}
