//! What a table is filled with: the product of the `hybrid` model at many wavelengths, or its colour.

use super::BsdfError;
use super::directions::is_unit;
use crate::colorimetry::{Illuminant, Integration, Observer, RgbSpace, RgbTransform};
use crate::geometry::Polarization;
use crate::optics::hybrid::{self, HybridNode, Shape};
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::{HybridModel, Media, ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;
use std::f64::consts::TAU;

/// A surface as a table sees it: `f cos(theta_o)` in each channel of two directions.
///
/// ```
/// use morpho_fit::bsdf::Source;
/// use morpho_fit::geometry::Polarization;
/// use morpho_fit::optics::{HybridModel, Structure};
/// let (model, blue) = (HybridModel::default(), Structure::blue());
/// let source = Source::spectra(&model, &blue, Polarization::Unpolarized, &[470.0, 600.0])?;
/// let mut values = [0.0; 2];
/// source.evaluate([0.0, 0.0, 1.0], [0.6, 0.0, 0.8], &mut values)?;
/// let f = model.brdf(&blue, [0.0, 0.0, 1.0], [0.6, 0.0, 0.8], Polarization::Unpolarized, 470.0)?;
/// assert!((values[0] - 0.8 * f).abs() < 1e-9 * f);
/// # Ok::<(), morpho_fit::bsdf::BsdfError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Source<'a> {
    model: &'a HybridModel,
    structure: Structure,
    polarization: Polarization,
    wavelengths: Vec<f64>,
    media: Vec<Media>,
    wavenumbers: Vec<f64>,
    /// Wavelengths in the ambient medium, nm.
    ambient: Vec<f64>,
    /// What each wavelength adds to red, green and blue; none for spectra.
    weights: Option<[Vec<f64>; 3]>,
}

/// Room for one direction's spectrum.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    stack: Vec<SAndP>,
    spectrum: Vec<f64>,
}

impl<'a> Source<'a> {
    /// Spectra at these wavelengths in vacuum, nm.
    ///
    /// # Errors
    /// [`BsdfError::Optics`] for a model, structure or wavelength out of range; [`BsdfError::Nodes`] without a wavelength.
    pub fn spectra(
        model: &'a HybridModel,
        structure: &Structure,
        polarization: Polarization,
        wavelengths: &[f64],
    ) -> Result<Self, BsdfError> {
        if wavelengths.is_empty() {
            return Err(BsdfError::Nodes { axis: "wavelengths", count: 0, least: 1, most: 1000 });
        }
        // A direction that is always there: what the model refuses, it refuses here.
        let up = [0.0, 0.0, 1.0];
        model.brdf(structure, up, up, polarization, wavelengths.first().copied().unwrap_or_default())?;
        let mut media = Vec::with_capacity(wavelengths.len());
        for &wavelength in wavelengths {
            media.push(model.stack.media(wavelength)?);
        }
        let ambient = media.iter().map(|media| media.wavelength / media.ambient).collect();
        Media::join(&mut media);
        Ok(Self {
            model,
            structure: *structure,
            polarization,
            wavelengths: wavelengths.to_vec(),
            wavenumbers: wavelengths.iter().map(|wavelength| TAU / wavelength).collect(),
            ambient,
            media,
            weights: None,
        })
    }

    /// Linear sRGB in D65 for the observer of 2 degrees: a perfect white diffuser has `(1, 1, 1) / pi` in each direction. Colours that sRGB
    /// cannot show have channels below 0 here.
    ///
    /// # Errors
    /// As [`Source::spectra`]; [`BsdfError::Colour`] for wavelengths that make no white.
    pub fn rgb(
        model: &'a HybridModel,
        structure: &Structure,
        polarization: Polarization,
        grid: &Wavelengths,
    ) -> Result<Self, BsdfError> {
        let integration = Integration::new(grid, Observer::Cie1931, &Illuminant::D65)?;
        let transform = RgbTransform::adapted(RgbSpace::Srgb, integration.white())?;
        let weights = Some(integration.linear_weights(&transform)?);
        Ok(Self { weights, ..Self::spectra(model, structure, polarization, &grid.iter().collect::<Vec<f64>>())? })
    }

    /// The same surface at other wavelengths.
    pub(super) fn at(&self, wavelengths: &[f64]) -> Result<Self, BsdfError> {
        Self::spectra(self.model, &self.structure, self.polarization, wavelengths)
    }

    /// Number of values for two directions.
    #[must_use]
    pub fn channels(&self) -> usize {
        if self.weights.is_some() { 3 } else { self.wavelengths.len() }
    }

    /// Wavelengths of the channels, nm; none where they are red, green and blue.
    #[must_use]
    pub fn wavelengths(&self) -> Option<&[f64]> {
        self.weights.is_none().then_some(self.wavelengths.as_slice())
    }

    /// `f cos(theta_o)` in each channel, 1/sr; 0 below the horizon.
    ///
    /// # Shape
    /// `out`: one value for each channel.
    ///
    /// # Errors
    /// [`BsdfError::Direction`] for a vector whose length is not 1, [`BsdfError::Channels`] for another number of channels.
    pub fn evaluate(&self, incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        if let Some(found) = [incoming, outgoing].into_iter().find(|vector| !is_unit(*vector)) {
            return Err(BsdfError::Direction { found });
        }
        if out.len() != self.channels() {
            return Err(BsdfError::Channels("one value is needed for each channel"));
        }
        self.fill(incoming, outgoing, &mut Scratch::default(), out)
    }

    /// Whether there is light in a direction, which does not depend on the wavelength but for zeros of the slit.
    pub(super) fn lights(&self, incoming: [f64; 3], outgoing: [f64; 3]) -> bool {
        let shape = || Shape::of(&self.structure, self.model.ridge_spacing).at(&hybrid::Pair::new(incoming, outgoing));
        incoming[2] > 0.0 && outgoing[2] > 0.0 && shape() > 0.0
    }

    /// [`Source::evaluate`] of checked input.
    pub(super) fn fill(
        &self,
        incoming: [f64; 3],
        outgoing: [f64; 3],
        scratch: &mut Scratch,
        out: &mut [f64],
    ) -> Result<(), BsdfError> {
        out.fill(0.0);
        if !self.lights(incoming, outgoing) {
            return Ok(());
        }
        let node = HybridNode::new(incoming, outgoing, 1.0);
        let (structure, spacing) = (&self.structure, self.model.ridge_spacing);
        let Scratch { stack, spectrum } = scratch;
        stack.resize(self.wavenumbers.len(), SAndP { s: 0.0, p: 0.0 });
        let period = Period::of(structure);
        self.model.stack_reflectivities(&self.media, &self.wavenumbers, period, node.angle, stack)?;
        let (s, p) = self.polarization.shares();
        let values = stack.iter().zip(&self.ambient).map(|(both, &wavelength)| {
            (s * both.s + p * both.p) * node.at_wavelength(wavelength).spread(structure, spacing) * outgoing[2]
        });
        match &self.weights {
            None => out.iter_mut().zip(values).for_each(|(out, value)| *out = value),
            Some(weights) => {
                spectrum.clear();
                spectrum.extend(values);
                for (out, weights) in out.iter_mut().zip(weights) {
                    *out = weights.iter().zip(&*spectrum).map(|(weight, value)| weight * value).sum();
                }
            }
        }
        Ok(())
    }
}
