//! The layer stack of Model B: `ambient | (cuticle, gap) × layers | base`.

use crate::optics::error::{OpticsError, require};
use crate::optics::material::{Material, WAVELENGTHS, require_index};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

/// The largest number of layers; beyond it a mistyped count is likelier than a stack.
pub const MAX_LAYERS: usize = 100_000;

/// Media and layer count of `ambient | (cuticle, gap) × layers | base`, counted from the light.
///
/// Where the base is the gap's medium the last gap is a part of the base: its thickness changes nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// Medium of the incident light; must not absorb.
    pub ambient: Material,
    /// Medium of the layers.
    pub cuticle: Material,
    /// Medium between the layers.
    pub gap: Material,
    /// Medium behind the last gap.
    pub base: Material,
    /// Number of cuticle layers M, 1 to [`MAX_LAYERS`].
    pub layers: usize,
    /// Effective index: the share `f` of a layer that is cuticle, between ridges of the ambient medium; above 0, at most 1.
    /// Light that is wider than a lamella sees `n_eff² = n_ambient² + f (n² - n_ambient²)`, in air
    /// `sqrt(1 + f (n² - 1))`. `None` takes the layers as whole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filling: Option<f64>,
}

impl Default for Stack {
    /// Air | 9 × cuticle 1.56 with air gaps | air: Table 1 of the paper.
    fn default() -> Self {
        let air = Material::constant(1.0);
        Self {
            ambient: air.clone(),
            cuticle: Material::constant(1.56),
            gap: air.clone(),
            base: air,
            layers: 9,
            filling: None,
        }
    }
}

/// The indices of a [`Stack`] at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Media {
    /// Vacuum wavelength, nm.
    pub wavelength: f64,
    /// Real index of the incident medium.
    pub ambient: f64,
    /// Index of the cuticle.
    pub cuticle: Complex<f64>,
    /// Index of the gaps.
    pub gap: Complex<f64>,
    /// Index of the base.
    pub base: Complex<f64>,
}

impl Media {
    /// Checks every value, for media that no [`Stack`] has made.
    pub(crate) fn validate(&self) -> Result<(), OpticsError> {
        require(WAVELENGTHS.contains(&self.wavelength), "wavelength", self.wavelength, "nm", "10 to 1e6")?;
        require_index("ambient", Complex::new(self.ambient, 0.0))?;
        require_index("cuticle", self.cuticle)?;
        require_index("gap", self.gap)?;
        require_index("base", self.base)
    }

    /// Keeps one of media whose indices are all the same.
    pub(crate) fn join(media: &mut Vec<Self>) {
        let Some(&first) = media.first() else { return };
        if media.iter().all(|media| Self { wavelength: first.wavelength, ..*media } == first) {
            media.truncate(1);
        }
    }

    /// The first absorbing medium and its `k`, if there is one.
    #[must_use]
    pub fn absorbing(&self) -> Option<(&'static str, f64)> {
        [("cuticle", self.cuticle.im), ("gap", self.gap.im), ("base", self.base.im)].into_iter().find(|(_, k)| *k > 0.0)
    }
}

impl Stack {
    /// The indices at `wavelength` nm.
    ///
    /// # Errors
    /// [`OpticsError`] if a material has no valid index there, if the ambient medium absorbs, or if the layer count
    /// is out of range.
    pub fn media(&self, wavelength: f64) -> Result<Media, OpticsError> {
        #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
        let layers = self.layers as f64;
        require((1..=MAX_LAYERS).contains(&self.layers), "layers", layers, "", "1 to 100000")?;
        let ambient = self.ambient.index("ambient", wavelength)?;
        require(ambient.im <= 0.0, "extinction coefficient of the ambient", ambient.im, "", "0")?;
        let mut cuticle = self.cuticle.index("cuticle", wavelength)?;
        if let Some(filling) = self.filling {
            require(filling > 0.0 && filling <= 1.0, "filling", filling, "", "above 0, at most 1")?;
            let around = ambient.re * ambient.re;
            cuticle = ((cuticle * cuticle - around) * filling + around).sqrt();
            require_index("cuticle", cuticle)?;
        }
        Ok(Media {
            wavelength,
            ambient: ambient.re,
            cuticle,
            gap: self.gap.index("gap", wavelength)?,
            base: self.base.index("base", wavelength)?,
        })
    }
}
