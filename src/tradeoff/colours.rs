//! The colour of a spectrum, and how far two are apart.

use crate::colorimetry::{ColourError, Illuminant, Integration, Lab, Observer};
use crate::spectrum::Wavelengths;

/// The 1931 observer in daylight D65, for one grid of wavelengths.
pub(crate) struct Eye(Integration);

impl Eye {
    pub(crate) fn new(wavelengths: &Wavelengths) -> Result<Self, ColourError> {
        Integration::new(wavelengths, Observer::Cie1931, &Illuminant::D65).map(Self)
    }

    /// Luminance of a spectrum, that of its grid's own white being 1.
    pub(crate) fn luminance(&self, spectrum: &[f64]) -> Result<f64, ColourError> {
        Ok(self.0.xyz(spectrum)?.y / self.0.white().y)
    }

    /// CIELAB of a spectrum, its grid's own white being white.
    pub(crate) fn lab(&self, spectrum: &[f64]) -> Result<Lab, ColourError> {
        Lab::new(self.0.xyz(spectrum)?, self.0.white())
    }
}

/// The value below which a share of the sorted `values` lie; 0 of none.
pub(crate) fn quantile(values: &mut [f64], percent: usize) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (values.len().saturating_sub(1) * percent).div_ceil(100);
    values.get(place).copied().unwrap_or(0.0)
}
