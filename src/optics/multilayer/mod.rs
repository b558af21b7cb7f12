//! Model B's stack: reflectivity of `ambient | (cuticle, gap) × layers | base` (paper section 2.3).
//!
//! Three forms of the same physics. [`intensity`] is the paper's recurrence as printed, for real indices. [`periodic`] is the
//! closed form of the periodic stack, for real indices and any number of layers at the same cost; [`reflectivities`] is the
//! same for a whole spectrum at once, in vector code. [`amplitude`] carries the complex fields through any list of layers,
//! [`general`] at many wavelengths at once. [`reflectivity`] picks the cheapest that holds.

pub mod amplitude;
pub(crate) mod fields;
pub mod general;
pub mod intensity;
pub(crate) mod lanes;
pub mod periodic;

use crate::optics::error::{OpticsError, require};
use crate::optics::material::WAVELENGTHS;
use crate::optics::stack::{MAX_LAYERS, Media};
use crate::optics::structure::Structure;
use amplitude::Layer;
use fields::Layers;
use fields::pairs::SomePairs;
pub(crate) use lanes::Rules;
use nalgebra::Complex;
use periodic::{Cosines, Incidence};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// One value for each linear polarization.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SAndP {
    /// Electric field across the plane of incidence.
    pub s: f64,
    /// Electric field in the plane of incidence.
    pub p: f64,
}

impl SAndP {
    /// `(s + p) / 2`.
    #[must_use]
    pub fn mean(self) -> f64 {
        0.5 * (self.s + self.p)
    }

    /// The same value for both.
    #[must_use]
    pub fn both(value: f64) -> Self {
        Self { s: value, p: value }
    }
}

/// Thickness of a layer of a period, nm. With the shortest wavelength it keeps the phases of Model A below 2^20 half
/// turns, where its sines are reduced exactly; a larger one would give noise, and far larger ones infinity.
pub(crate) const THICKNESSES: RangeInclusive<f64> = 0.0..=1e6;

/// Thickness of the two layers of a period, nm, 0 to 1e6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Period {
    /// Thickness of the cuticle layer, nm.
    pub cuticle: f64,
    /// Thickness of the gap, nm.
    pub gap: f64,
}

impl Period {
    /// The layers of a structure.
    #[must_use]
    pub fn of(structure: &Structure) -> Self {
        Self { cuticle: structure.d_cuticle, gap: structure.d_air }
    }

    pub(crate) fn validate(self) -> Result<(), OpticsError> {
        require(THICKNESSES.contains(&self.cuticle), "d_cuticle", self.cuticle, "nm", "0 to 1e6")?;
        require(THICKNESSES.contains(&self.gap), "d_air", self.gap, "nm", "0 to 1e6")
    }
}

/// Derivatives of a reflectivity, for each linear polarization.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StackSlopes {
    /// By the thickness of the cuticle, 1/nm.
    pub cuticle: SAndP,
    /// By the thickness of the gap, 1/nm.
    pub gap: SAndP,
    /// By the angle in the ambient medium, 1/rad.
    pub angle: SAndP,
}

/// Reflectivity of the stack for light at `angle` (rad) from the normal of the layers, exact for s and p.
///
/// The closed form where every wave in the stack travels, the amplitude recurrence where a medium absorbs or a wave is
/// evanescent. A stack turned past grazing (`|angle| > 90°`) is in its own shadow and reflects 0; at grazing it
/// reflects 1.
///
/// # Errors
/// [`OpticsError::OutOfRange`] for a thickness out of range, no layers or too many, or media out of range.
///
/// ```
/// use morpho_fit::optics::{Stack, multilayer::{Period, reflectivity}};
/// let stack = Stack::default();
/// let r = reflectivity(&stack.media(583.0)?, Period { cuticle: 100.0, gap: 135.0 }, stack.layers, 0.0)?;
/// assert!((r.s - 0.998597010770).abs() < 1e-11);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn reflectivity(media: &Media, period: Period, layers: usize, angle: f64) -> Result<SAndP, OpticsError> {
    validate(media, period, layers)?;
    require(angle.is_finite(), "angle", angle, "rad", "finite")?;
    Ok(reflectivity_unchecked(media, period, layers, angle))
}

fn validate(media: &Media, period: Period, layers: usize) -> Result<(), OpticsError> {
    media.validate()?;
    period.validate()?;
    #[allow(clippy::cast_precision_loss, reason = "for a message")]
    let count = layers as f64;
    require((1..=MAX_LAYERS).contains(&layers), "layers", count, "", "1 to 100000")
}

/// [`reflectivity`] at many wavelengths (nm) of one angle, in media whose indices are those of `media` at all of them.
///
/// Where every wave travels and nothing absorbs this is the closed form in vector registers, ten times as fast as one by one
/// and the same to 1e-11.
///
/// # Errors
/// As [`reflectivity`], and [`OpticsError::OutOfRange`] for a wavelength out of range.
///
/// ```
/// use morpho_fit::optics::{Stack, multilayer::{Period, reflectivities}};
/// let stack = Stack::default();
/// let period = Period { cuticle: 100.0, gap: 135.0 };
/// let found = reflectivities(&stack.media(500.0)?, &[480.0, 583.0], period, stack.layers, 0.0)?;
/// assert!((found[0].s - 0.409538957612).abs() < 1e-11 && (found[1].p - 0.998597010770).abs() < 1e-11);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn reflectivities(
    media: &Media,
    wavelengths: &[f64],
    period: Period,
    layers: usize,
    angle: f64,
) -> Result<Vec<SAndP>, OpticsError> {
    spectra(media, wavelengths, period, layers, &[angle])
}

/// [`reflectivities`] at many angles (rad): the fastest way to fill a chart of wavelengths and angles.
///
/// # Shape
/// `[angles][wavelengths]`, one spectrum after the other.
///
/// # Errors
/// As [`reflectivities`].
///
/// ```
/// use morpho_fit::optics::{Stack, multilayer::{Period, spectra}};
/// let stack = Stack::default();
/// let period = Period { cuticle: 100.0, gap: 135.0 };
/// let found = spectra(&stack.media(500.0)?, &[480.0, 583.0], period, stack.layers, &[0.0, 30_f64.to_radians()])?;
/// assert!((found[0].s - 0.409538957612).abs() < 1e-11 && (found[2].s - 0.998360050717).abs() < 1e-11);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn spectra(
    media: &Media,
    wavelengths: &[f64],
    period: Period,
    layers: usize,
    angles: &[f64],
) -> Result<Vec<SAndP>, OpticsError> {
    let wavenumbers = checked(media, wavelengths, period, layers, angles)?;
    let mut found = vec![SAndP::both(0.0); wavelengths.len() * angles.len()];
    for (&angle, found) in angles.iter().zip(found.chunks_exact_mut(wavelengths.len().max(1))) {
        reflectivities_unchecked(&[*media], &wavenumbers, period, layers, angle, found);
    }
    Ok(found)
}

/// The mean of s and p that [`spectra`] gives, for unpolarized light, in less time.
///
/// # Shape
/// `[angles][wavelengths]`, one spectrum after the other.
///
/// # Errors
/// As [`reflectivities`].
///
/// ```
/// use morpho_fit::optics::{Stack, multilayer::{Period, unpolarized_spectra}};
/// let stack = Stack::default();
/// let period = Period { cuticle: 100.0, gap: 135.0 };
/// let found = unpolarized_spectra(&stack.media(500.0)?, &[480.0, 583.0], period, stack.layers, &[0.0])?;
/// assert!((found[0] - 0.409538957612).abs() < 1e-11 && (found[1] - 0.998597010770).abs() < 1e-11);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn unpolarized_spectra(
    media: &Media,
    wavelengths: &[f64],
    period: Period,
    layers: usize,
    angles: &[f64],
) -> Result<Vec<f64>, OpticsError> {
    let wavenumbers = checked(media, wavelengths, period, layers, angles)?;
    let mut found = vec![0.0; wavelengths.len() * angles.len()];
    let mut both = Vec::new();
    for (&angle, found) in angles.iter().zip(found.chunks_exact_mut(wavelengths.len().max(1))) {
        if let Some([incidence]) = traveling(&[*media], angle).as_deref() {
            lanes::means(media, incidence, period, layers, &wavenumbers, found);
            continue;
        }
        both.resize(wavelengths.len(), SAndP::both(0.0));
        reflectivities_unchecked(&[*media], &wavenumbers, period, layers, angle, &mut both);
        found.iter_mut().zip(&both).for_each(|(mean, both)| *mean = both.mean());
    }
    Ok(found)
}

/// Wavenumbers of what [`spectra`] is asked for, if all of it is in range.
fn checked(
    media: &Media,
    wavelengths: &[f64],
    period: Period,
    layers: usize,
    angles: &[f64],
) -> Result<Vec<f64>, OpticsError> {
    let first = wavelengths.first().copied().unwrap_or(media.wavelength);
    validate(&Media { wavelength: first, ..*media }, period, layers)?;
    for &angle in angles {
        require(angle.is_finite(), "angle", angle, "rad", "finite")?;
    }
    wavenumbers(wavelengths)
}

/// `2 pi / wavelength` of checked wavelengths.
fn wavenumbers(wavelengths: &[f64]) -> Result<Vec<f64>, OpticsError> {
    for &wavelength in wavelengths {
        require(WAVELENGTHS.contains(&wavelength), "wavelength", wavelength, "nm", "10 to 1e6")?;
    }
    Ok(wavelengths.iter().map(|wavelength| TAU / wavelength).collect())
}

/// [`reflectivities`] for inputs that were checked before, by `2 pi / wavelength`; `media` are one for all or one for each.
pub(crate) fn reflectivities_unchecked(
    media: &[Media],
    wavenumbers: &[f64],
    period: Period,
    layers: usize,
    angle: f64,
    out: &mut [SAndP],
) {
    if media.is_empty() {
        return;
    }
    if let Some(incidences) = traveling(media, angle) {
        lanes::values(media, &incidences, period, layers, Rules::Each, wavenumbers, out);
        return;
    }
    let order = Order {
        kinds: &[(GAP, period.gap), (CUTICLE, period.cuticle)],
        order: &[0, 1],
        repeats: layers,
        stacks: 1,
        pairs: None,
    };
    ordered_unchecked(media, wavenumbers, order, angle, out);
}

/// The gap among the media of [`Order`].
pub(crate) const GAP: usize = 0;
/// The cuticle.
pub(crate) const CUTICLE: usize = 1;

/// Layers of gap and cuticle in any order, as those of [`Layers`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Order<'a> {
    /// [`GAP`] or [`CUTICLE`], and thickness (nm), of each kind of layer.
    pub(crate) kinds: &'a [(usize, f64)],
    pub(crate) order: &'a [usize],
    pub(crate) repeats: usize,
    pub(crate) stacks: usize,
    pub(crate) pairs: Option<SomePairs<'a>>,
}

/// [`reflectivities_unchecked`] of layers in any order; of several stacks the mean.
pub(crate) fn ordered_unchecked(
    media: &[Media],
    wavenumbers: &[f64],
    layers: Order<'_>,
    angle: f64,
    out: &mut [SAndP],
) {
    let row = |index: fn(&Media) -> Complex<f64>| media.iter().map(index).collect::<Vec<_>>();
    let Order { kinds, order, repeats, stacks, pairs } = layers;
    let layers = Layers {
        ambient: &row(|media| Complex::new(media.ambient, 0.0)),
        base: &row(|media| media.base),
        media: &[&row(|media| media.gap), &row(|media| media.cuticle)],
        kinds,
        order,
        repeats,
        stacks,
        pairs,
    };
    general::reflectivities_unchecked(&layers, wavenumbers, angle, out);
}

/// [`reflectivities_unchecked`] with their derivatives; `false`, and nothing written, where a medium absorbs or a wave does not
/// travel.
pub(crate) fn slopes_unchecked(
    media: &[Media],
    wavenumbers: &[f64],
    period: Period,
    layers: usize,
    angle: f64,
    slopes: &mut [StackSlopes],
) -> bool {
    let incidences = if media.is_empty() { None } else { traveling(media, angle) };
    if let Some(incidences) = &incidences {
        lanes::slopes(media, incidences, period, layers, Rules::Each, wavenumbers, slopes);
    }
    incidences.is_some()
}

/// The cosines where every wave of the stack travels and none is absorbed, in all media.
fn traveling(media: &[Media], angle: f64) -> Option<Vec<Incidence>> {
    let (sin, cos) = angle.sin_cos();
    let one = |media: &Media| media.absorbing().is_none().then(|| Incidence::of(media, (sin, cos))).flatten();
    if cos > 0.0 { media.iter().map(one).collect() } else { None }
}

/// [`reflectivity`] for inputs that were checked before: the inner loop of a fit.
#[inline]
pub(crate) fn reflectivity_unchecked(media: &Media, period: Period, layers: usize, angle: f64) -> SAndP {
    let cos = angle.cos();
    if cos <= 0.0 {
        return SAndP::both(if cos < 0.0 { 0.0 } else { 1.0 });
    }
    if media.absorbing().is_none()
        && let Some(cosines) = Cosines::refracted(media, angle)
    {
        return periodic::exact(media, &cosines, period, layers);
    }
    let of = |polarization| {
        let layers = (0..layers).flat_map(|_| {
            [
                Layer { index: media.gap, thickness: period.gap },
                Layer { index: media.cuticle, thickness: period.cuticle },
            ]
        });
        amplitude::from_base(media.ambient, layers, media.base, media.wavelength, angle, polarization).reflectivity
    };
    SAndP { s: of(amplitude::Component::S), p: of(amplitude::Component::P) }
}
