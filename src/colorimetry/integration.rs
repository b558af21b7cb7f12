//! From a reflectance spectrum to XYZ, one or many at a time.

use super::encoding::clip_and_encode;
use super::error::ColourError;
use super::illuminant::Illuminant;
use super::observer::Observer;
use super::rgb::RgbTransform;
use super::tristimulus::Xyz;
use crate::spectrum::Wavelengths;
use multiversion::multiversion;

/// Partial sums of one integral, added at its end: as many as a vector register holds.
const LANES: usize = 4;
/// Spectra whose linear values are encoded together, while they are near the processor.
const BLOCK: usize = 256;

/// The weights by which a spectrum on a grid becomes a colour.
///
/// ```text
/// X = sum_i R_i S_i x̄_i / sum_i S_i ȳ_i, and so on with ȳ, z̄;   a perfect white has Y = 1
/// ```
///
/// # Source
/// CIE 15:2018, section 7, with `k` for a white of 1; ASTM E308's weights for coarse grids are not used.
///
/// ```
/// use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
/// use morpho_fit::spectrum::Wavelengths;
///
/// let daylight = Integration::new(&Wavelengths::visible(1.0)?, Observer::Cie1931, &Illuminant::D65)?;
/// let grey = daylight.xyz(&[0.18; 401])?;
/// assert!((grey.y - 0.18).abs() < 1e-12);
/// let white = daylight.white().chromaticity().unwrap();
/// assert!((white.x - 0.3127).abs() < 1e-4 && (white.y - 0.3290).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Integration {
    /// Of X, Y and Z, each `[wavelength]`.
    weights: [Vec<f64>; 3],
    white: Xyz,
}

impl Integration {
    /// Weights for spectra at `wavelengths`, as `observer` sees them in the light of `illuminant`.
    ///
    /// # Errors
    /// [`ColourError::OutsideTable`] if a measured illuminant does not cover the wavelengths, [`ColourError::NoLight`]
    /// if one of X, Y, Z of a perfect white would be 0 there.
    pub fn new(wavelengths: &Wavelengths, observer: Observer, illuminant: &Illuminant) -> Result<Self, ColourError> {
        illuminant.covers(wavelengths)?;
        let power: Vec<f64> = wavelengths.iter().map(|wavelength| illuminant.power(wavelength)).collect();
        // A lamp in any unit: the largest power is made 1, so that no sum of them overflows.
        let largest = power.iter().copied().fold(0.0, f64::max);
        let mut weights: [Vec<f64>; 3] = std::array::from_fn(|_| Vec::with_capacity(power.len()));
        for (wavelength, power) in wavelengths.iter().zip(power) {
            let matching = observer.matching(wavelength);
            for (of_one, matching) in weights.iter_mut().zip(matching) {
                of_one.push(power / largest * matching);
            }
        }
        let luminance: f64 = weights[1].iter().sum();
        for weight in weights.iter_mut().flatten() {
            *weight /= luminance;
        }
        let white = Xyz::from_array(weighted(&weights, &vec![1.0; wavelengths.len()]));
        if white.as_white().is_err() {
            return Err(ColourError::NoLight { first: wavelengths.first(), last: wavelengths.last() });
        }
        Ok(Self { weights, white })
    }

    /// Wavelengths of one spectrum.
    #[must_use]
    pub fn wavelengths(&self) -> usize {
        self.weights[1].len()
    }

    /// XYZ of a perfect white, Y = 1: what [`super::Lab::new`] and [`RgbTransform::adapted`] take for white.
    #[must_use]
    pub fn white(&self) -> Xyz {
        self.white
    }

    /// What each wavelength adds to X, Y and Z, those of a perfect white being 1, 1, 1: X/Xn, Y/Yn, Z/Zn for [`super::Lab::new`]
    /// under a white of ones.
    ///
    /// # Shape
    /// The result: `[X, Y, Z][wavelength]`.
    #[must_use]
    pub fn relative_weights(&self) -> [Vec<f64>; 3] {
        let mut weights = self.weights.clone();
        for (of_one, white) in weights.iter_mut().zip(self.white.to_array()) {
            of_one.iter_mut().for_each(|weight| *weight /= white);
        }
        weights
    }

    /// What each wavelength adds to linear red, green and blue.
    ///
    /// # Shape
    /// The result: `[red, green, blue][wavelength]`.
    ///
    /// # Errors
    /// As [`RgbTransform::linear`].
    pub fn linear_weights(&self, transform: &RgbTransform) -> Result<[Vec<f64>; 3], ColourError> {
        let [x, y, z] = &self.weights;
        let mut weights: [Vec<f64>; 3] = Default::default();
        for ((&x, &y), &z) in x.iter().zip(y).zip(z) {
            for (of_one, channel) in weights.iter_mut().zip(transform.linear(Xyz { x, y, z })?) {
                of_one.push(channel);
            }
        }
        Ok(weights)
    }

    /// XYZ of one spectrum of reflectances (fractions; below 0 and above 1 are let through).
    ///
    /// # Shape
    /// `reflectances: [wavelength]`.
    ///
    /// # Errors
    /// [`ColourError::Length`], [`ColourError::NotFinite`] with the index of the reflectance.
    pub fn xyz(&self, reflectances: &[f64]) -> Result<Xyz, ColourError> {
        if reflectances.len() != self.wavelengths() {
            return Err(self.wrong_length(reflectances));
        }
        let colour = Xyz::from_array(weighted(&self.weights, reflectances));
        colour.finite().map_err(|error| not_finite(reflectances).unwrap_or(error))
    }

    /// XYZ of many spectra, each the same bits as by [`Integration::xyz`].
    ///
    /// # Shape
    /// `reflectances: [spectrum][wavelength]`, row by row; the result: `[spectrum]`.
    ///
    /// # Errors
    /// As [`Integration::xyz`]; the index counts through all spectra.
    pub fn xyz_of_many(&self, reflectances: &[f64]) -> Result<Vec<Xyz>, ColourError> {
        self.whole_spectra(reflectances)?;
        let colours = weighted_many(&self.weights, reflectances);
        match colours.iter().find_map(|colour| colour.finite().err()) {
            Some(error) => Err(not_finite(reflectances).unwrap_or(error)),
            None => Ok(colours),
        }
    }

    /// Encoded RGB of many spectra, clipped to 0 to 1, by the fastest way.
    ///
    /// Each is the same bits as `transform.encoded` of [`Integration::xyz`] where that lies within 0 to 1. Nothing says which
    /// were clipped; [`super::show`] does, and moves colours into the gamut at their hue.
    ///
    /// # Shape
    /// `reflectances: [spectrum][wavelength]`, row by row; the result: `[spectrum][red, green, blue]`.
    ///
    /// # Errors
    /// As [`Integration::xyz_of_many`].
    ///
    /// ```
    /// use morpho_fit::colorimetry::{Illuminant, Integration, Observer, RgbSpace, RgbTransform};
    /// use morpho_fit::spectrum::Wavelengths;
    ///
    /// let grid = Wavelengths::paper();
    /// let daylight = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?;
    /// let transform = RgbTransform::adapted(RgbSpace::Srgb, daylight.white())?;
    /// let colours = daylight.encoded_of_many(&[1.0; 2 * 37], &transform)?;
    /// assert!(colours.iter().flatten().all(|channel| (channel - 1.0).abs() < 1e-11));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn encoded_of_many(
        &self,
        reflectances: &[f64],
        transform: &RgbTransform,
    ) -> Result<Vec<[f64; 3]>, ColourError> {
        self.whole_spectra(reflectances)?;
        let wavelengths = self.wavelengths();
        let mut colours = vec![[0.0; 3]; reflectances.len() / wavelengths];
        for (block, spectra) in colours.chunks_mut(BLOCK).zip(reflectances.chunks(BLOCK * wavelengths)) {
            if !linear_block(&self.weights, transform, spectra, block) {
                self.xyz_of_many(reflectances)?;
                // XYZ are finite, and so large that RGB are not.
                return Err(ColourError::NotFinite { quantity: "linear RGB channel", index: 0, found: f64::INFINITY });
            }
            clip_and_encode(transform.space().transfer(), block.as_flattened_mut());
        }
        Ok(colours)
    }

    fn whole_spectra(&self, reflectances: &[f64]) -> Result<(), ColourError> {
        if reflectances.len().is_multiple_of(self.wavelengths()) {
            Ok(())
        } else {
            Err(self.wrong_length(reflectances))
        }
    }

    fn wrong_length(&self, reflectances: &[f64]) -> ColourError {
        ColourError::Length { wavelengths: self.wavelengths(), found: reflectances.len() }
    }
}

/// The error of the first reflectance that is not finite.
fn not_finite(reflectances: &[f64]) -> Option<ColourError> {
    let (index, &found) = reflectances.iter().enumerate().find(|(_, value)| !value.is_finite())?;
    Some(ColourError::NotFinite { quantity: "reflectance", index, found })
}

/// The three weighted sums of one spectrum. Wherever this is inlined it adds in the same order and fuses nothing.
#[inline(always)]
fn weighted(weights: &[Vec<f64>; 3], reflectances: &[f64]) -> [f64; 3] {
    let (spectrum, spectrum_rest) = reflectances.as_chunks::<LANES>();
    let [(x, x_rest), (y, y_rest), (z, z_rest)] = weights.each_ref().map(|of_one| of_one.as_chunks::<LANES>());
    let mut sums = [[0.0; LANES]; 3];
    for (((reflectance, x), y), z) in spectrum.iter().zip(x).zip(y).zip(z) {
        for (sum, weight) in sums.iter_mut().zip([x, y, z]) {
            for lane in 0..LANES {
                sum[lane] += weight[lane] * reflectance[lane];
            }
        }
    }
    let mut totals = sums.map(|[a, b, c, d]| (a + c) + (b + d));
    for (((reflectance, x), y), z) in spectrum_rest.iter().zip(x_rest).zip(y_rest).zip(z_rest) {
        for (total, weight) in totals.iter_mut().zip([x, y, z]) {
            *total += weight * reflectance;
        }
    }
    totals
}

#[multiversion(targets("x86_64+avx2"))]
fn weighted_many(weights: &[Vec<f64>; 3], reflectances: &[f64]) -> Vec<Xyz> {
    reflectances.chunks_exact(weights[1].len()).map(|spectrum| Xyz::from_array(weighted(weights, spectrum))).collect()
}

/// Linear RGB of the spectra of one block; false if one is not finite.
#[multiversion(targets("x86_64+avx2"))]
fn linear_block(weights: &[Vec<f64>; 3], transform: &RgbTransform, spectra: &[f64], linear: &mut [[f64; 3]]) -> bool {
    let mut finite = true;
    for (spectrum, linear) in spectra.chunks_exact(weights[1].len()).zip(linear) {
        *linear = transform.apply(weighted(weights, spectrum));
        finite &= (linear[0] + linear[1] + linear[2]).is_finite();
    }
    finite
}
