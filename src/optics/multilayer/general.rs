//! A stack of layers of any materials and thicknesses, in any order, at many wavelengths and angles.

use crate::optics::error::{OpticsError, require};
use crate::optics::material::{Material, WAVELENGTHS};
use crate::optics::multilayer::amplitude::{self, Component, Layer};
use crate::optics::multilayer::fields::{self, Layers};
use crate::optics::multilayer::{SAndP, wavenumbers};
use crate::optics::stack::MAX_LAYERS;
use nalgebra::Complex;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

/// One layer of a [`LayeredStack`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Film {
    /// What it is made of; it may absorb.
    pub material: Material,
    /// Thickness, nm, 0 to 1e9.
    pub thickness: f64,
}

/// `ambient | films | base`, the first film met by the light first.
///
/// ```
/// use morpho_fit::optics::{Material, multilayer::general::{Film, LayeredStack}};
/// let film = Film { material: Material::constant(1.38), thickness: 99.6 };
/// let coated = LayeredStack { ambient: Material::constant(1.0), films: vec![film], base: Material::constant(1.52) };
/// let found = coated.reflectivities(&[550.0, 1100.0], 0.0)?;
/// assert!((found[0].s - 0.01260).abs() < 1e-5); // ((1.52 - 1.38²) / (1.52 + 1.38²))²
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayeredStack {
    /// Medium of the incident light; must not absorb.
    pub ambient: Material,
    /// The layers, at most 200,000.
    pub films: Vec<Film>,
    /// Medium behind the last layer.
    pub base: Material,
}

impl LayeredStack {
    /// Reflectivity for s and p at each of `wavelengths` (nm) for light at `angle` (rad) in the ambient medium, by the amplitude
    /// recurrence in vector registers: that of [`reflect_transmit`](amplitude::reflect_transmit), and the same to 1e-11.
    ///
    /// What layers of the same material and thickness have in common is computed once. At grazing incidence it is 1.
    ///
    /// # Errors
    /// [`OpticsError`] for a wavelength outside 10 to 1e6 nm, a thickness or index out of range, an angle beyond 90°, an ambient
    /// medium that absorbs, or a material without an index at a wavelength.
    pub fn reflectivities(&self, wavelengths: &[f64], angle: f64) -> Result<Vec<SAndP>, OpticsError> {
        self.spectra(wavelengths, &[angle])
    }

    /// [`LayeredStack::reflectivities`] at many angles.
    ///
    /// # Shape
    /// `[angles][wavelengths]`, one spectrum after the other.
    ///
    /// # Errors
    /// As [`LayeredStack::reflectivities`].
    pub fn spectra(&self, wavelengths: &[f64], angles: &[f64]) -> Result<Vec<SAndP>, OpticsError> {
        for &angle in angles {
            require(angle.abs() <= std::f64::consts::FRAC_PI_2, "angle", angle, "rad", "at most pi/2 in size")?;
        }
        let wavenumbers = wavenumbers(wavelengths)?;
        let indices = Indices::new(self, wavelengths)?;
        let mut found = vec![SAndP::default(); wavelengths.len() * angles.len()];
        for (&angle, found) in angles.iter().zip(found.chunks_exact_mut(wavelengths.len().max(1))) {
            indices.reflectivities(&wavenumbers, angle, found);
        }
        Ok(found)
    }
}

/// The indices of a stack at all wavelengths, each material's once.
struct Indices {
    ambient: Vec<Complex<f64>>,
    base: Vec<Complex<f64>>,
    media: Vec<Vec<Complex<f64>>>,
    /// Medium and thickness of each kind of layer.
    kinds: Vec<(usize, f64)>,
    /// Kinds from the base to the light.
    order: Vec<usize>,
}

impl Indices {
    fn new(stack: &LayeredStack, wavelengths: &[f64]) -> Result<Self, OpticsError> {
        #[allow(clippy::cast_precision_loss, reason = "for a message")]
        let count = stack.films.len() as f64;
        require(stack.films.len() <= 2 * MAX_LAYERS, "number of layers", count, "", "at most 200000")?;
        let ambient = row(&stack.ambient, "ambient", wavelengths)?;
        for n in &ambient {
            require(n.im <= 0.0, "extinction coefficient of the ambient", n.im, "", "0")?;
        }
        let base = row(&stack.base, "base", wavelengths)?;
        let (mut materials, mut media) = (Vec::<&Material>::new(), Vec::new());
        let (mut kinds, mut known, mut order) = (Vec::new(), FxHashMap::default(), Vec::new());
        for film in stack.films.iter().rev() {
            require((0.0..=1e9).contains(&film.thickness), "thickness", film.thickness, "nm", "0 to 1e9")?;
            let medium = match materials.iter().position(|known| **known == film.material) {
                Some(medium) => medium,
                None => {
                    media.push(row(&film.material, "layer", wavelengths)?);
                    materials.push(&film.material);
                    media.len() - 1
                }
            };
            order.push(*known.entry((medium, film.thickness.to_bits())).or_insert_with(|| {
                kinds.push((medium, film.thickness));
                kinds.len() - 1
            }));
        }
        Ok(Self { ambient, base, media, kinds, order })
    }

    fn reflectivities(&self, wavenumbers: &[f64], angle: f64, out: &mut [SAndP]) {
        let media: Vec<&[Complex<f64>]> = self.media.iter().map(Vec::as_slice).collect();
        let layers = Layers {
            ambient: &self.ambient,
            base: &self.base,
            media: &media,
            kinds: &self.kinds,
            order: &self.order,
            repeats: 1,
            stacks: 1,
            pairs: None,
        };
        reflectivities_unchecked(&layers, wavenumbers, angle, out);
    }
}

/// The index at each wavelength, or the one that all have.
fn row(material: &Material, name: &'static str, wavelengths: &[f64]) -> Result<Vec<Complex<f64>>, OpticsError> {
    if matches!(material, Material::Constant { .. }) {
        return Ok(vec![material.index(name, *WAVELENGTHS.start())?]);
    }
    wavelengths.iter().map(|&wavelength| material.index(name, wavelength)).collect()
}

/// R of checked layers; past grazing the stack is in its own shadow and reflects 0, at grazing it reflects 1.
pub(crate) fn reflectivities_unchecked(layers: &Layers<'_>, wavenumbers: &[f64], angle: f64, out: &mut [SAndP]) {
    let cos = angle.cos();
    if cos <= 0.0 {
        out.fill(SAndP::both(if cos < 0.0 { 0.0 } else { 1.0 }));
    } else if layers.has_short_phases(wavenumbers.iter().copied().fold(0.0, f64::max)) {
        fields::values(layers, cos, wavenumbers, out);
    } else {
        for (place, (out, &wavenumber)) in out.iter_mut().zip(wavenumbers).enumerate() {
            *out = one_by_one(layers, place, wavenumber, angle);
        }
    }
}

/// The scalar form, whose phases may be of any size.
fn one_by_one(layers: &Layers<'_>, place: usize, wavenumber: f64, angle: f64) -> SAndP {
    let at = |row: &[Complex<f64>]| row.get(place).or(row.first()).copied().unwrap_or_default();
    let one = |order, component| {
        let films = std::iter::repeat_n(order, layers.repeats).flatten().map(|&kind: &usize| {
            let (medium, thickness) = layers.kinds[kind];
            Layer { index: at(layers.media[medium]), thickness }
        });
        let wavelength = std::f64::consts::TAU / wavenumber;
        amplitude::from_base(at(layers.ambient).re, films, at(layers.base), wavelength, angle, component).reflectivity
    };
    #[allow(clippy::cast_precision_loss, reason = "a count of stacks is small")]
    let of = |component| layers.each().map(|order| one(order, component)).sum::<f64>() / layers.stacks as f64;
    SAndP { s: of(Component::S), p: of(Component::P) }
}
