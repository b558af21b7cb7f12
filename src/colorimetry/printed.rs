//! The colour sum as the paper prints it.

use super::error::ColourError;
use super::tristimulus::Xyz;

/// Red, green and blue by the paper's sum (section 3), for a perfect white 1, 1, 1: linear, and below 0 for many colours.
///
/// ```text
/// R = k sum_λ I(λ) r̄(λ), and so on with ḡ, b̄
/// ```
///
/// The sum has no illuminant, and its primaries are those of CIE 1931 RGB (700, 546.1 and 435.8 nm), which no display has:
/// shown as they are the colours are wrong. `k` is free in the paper; here it makes white white.
///
/// - `colour`: the colour under [`Illuminant::E`](super::Illuminant::E), whose sum it is in other primaries.
///
/// # Source
/// CIE 15:2018, appendix B: `X = (0.49 R + 0.31 G + 0.20 B)/0.17697` and so on; the factor goes into `k`.
///
/// # Errors
/// [`ColourError`] if a value is not finite.
///
/// ```
/// use morpho_fit::colorimetry::{Xyz, printed_rgb};
/// let white = printed_rgb(Xyz { x: 1.0, y: 1.0, z: 1.0 })?;
/// assert!(white.iter().all(|channel| (channel - 1.0).abs() < 1e-12));
/// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
/// ```
pub fn printed_rgb(colour: Xyz) -> Result<[f64; 3], ColourError> {
    let Xyz { x, y, z } = colour.finite()?;
    let [to_x, to_y, to_z] = TO_XYZ;
    let determinant = triple(to_x, to_y, to_z);
    // Cramer's rule: the columns of the matrix in turn replaced by the colour.
    let with = |column: usize| {
        let mut rows = [to_x, to_y, to_z];
        for (row, value) in rows.iter_mut().zip([x, y, z]) {
            row[column] = value;
        }
        triple(rows[0], rows[1], rows[2]) / determinant
    };
    Ok([with(0), with(1), with(2)])
}

/// CIE RGB to XYZ, without the factor 1/0.17697.
const TO_XYZ: [[f64; 3]; 3] = [[0.49, 0.31, 0.20], [0.17697, 0.812_40, 0.010_63], [0.0, 0.01, 0.99]];

fn triple(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colorimetry::Observer;

    #[test]
    fn each_primary_is_matched_by_itself() {
        // CIE 15: at 546.1 nm red and blue are 0, at 700 nm green and blue, at 435.8 nm red and green.
        for (wavelength, own) in [(700.0, 0), (546.1, 1), (435.8, 2)] {
            let rgb = printed_rgb(Xyz::from_array(Observer::Cie1931.matching(wavelength))).unwrap();
            for (channel, value) in rgb.iter().enumerate().filter(|(channel, _)| *channel != own) {
                assert!(value.abs() < 6e-3 * rgb[own], "{wavelength} nm, channel {channel}: {rgb:?}");
            }
        }
        assert!(printed_rgb(Xyz { x: f64::NAN, y: 0.0, z: 0.0 }).is_err());
    }
}
