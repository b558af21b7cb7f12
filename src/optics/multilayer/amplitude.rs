//! The general stack: complex indices, any list of layers, base plate, incidence from a dense medium.
//!
//! The tangential field amplitudes `(e, h)` are carried from the base to the light. For s they are E and H with
//! `Y = kz`, for p they change places and `Y = kz / n²`, `kz = sqrt(n² - (n_ambient sin)²)` in units of `2 pi / wavelength`:
//!
//! ```text
//! e' = e (1 + E2)/2 + h (1 - E2)/(2 Y),   h' = h (1 + E2)/2 + e Y (1 - E2)/2,   E2 = exp(2 i kz k d)
//! ```
//!
//! which is the characteristic matrix times `exp(i kz k d)`. Since `|E2| <= 1` nothing overflows however thick or
//! absorbing a layer is (products of matrices do), and `(1 - E2)/Y` is finite where `kz = 0`, at the critical angle of a
//! layer, where the form with Fresnel coefficients of each interface is 0/0.
//!
//! # Source
//! Abelès's method, Born and Wolf §1.6; the scaling is that of Parratt 1954, DOI 10.1103/PhysRev.95.359.

use crate::optics::error::{OpticsError, require};
use crate::optics::material::{INDICES, WAVELENGTHS, require_index};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// A homogeneous layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Complex index `n + i k`, `k >= 0`.
    pub index: Complex<f64>,
    /// Thickness, nm, at least 0.
    pub thickness: f64,
}

/// A linear polarization.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// Electric field across the plane of incidence.
    S,
    /// Electric field in the plane of incidence.
    P,
}

/// Power shares of a stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Reflected share.
    pub reflectivity: f64,
    /// Share that enters the base.
    pub transmittance: f64,
}

/// Reflectivity and transmittance of `layers` (first one met by the light first) between `ambient` and `base`.
///
/// - `wavelength` in vacuum, nm; `angle` of incidence in the ambient medium, rad.
///
/// At grazing incidence it is `(1, 0)`.
///
/// # Errors
/// [`OpticsError::OutOfRange`] for n outside 0.001 to 1000, k outside 0 to 1000, a wavelength outside 10 to 1e6 nm, a
/// thickness outside 0 to 1e9 nm, or an angle beyond 90°.
///
/// ```
/// use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
/// use nalgebra::Complex;
/// let film = [Layer { index: Complex::new(1.38, 0.0), thickness: 99.6 }];
/// let coated = reflect_transmit(1.0, &film, Complex::new(1.52, 0.0), 550.0, 0.0, Component::S)?;
/// assert!((coated.reflectivity - 0.01260).abs() < 1e-5); // ((1.52 - 1.38²) / (1.52 + 1.38²))²
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn reflect_transmit(
    ambient: f64,
    layers: &[Layer],
    base: Complex<f64>,
    wavelength: f64,
    angle: f64,
    component: Component,
) -> Result<Shares, OpticsError> {
    require(INDICES.contains(&ambient), "index of the ambient", ambient, "", "0.001 to 1000")?;
    require(WAVELENGTHS.contains(&wavelength), "wavelength", wavelength, "nm", "10 to 1e6")?;
    require(angle.abs() <= std::f64::consts::FRAC_PI_2, "angle", angle, "rad", "at most pi/2 in size")?;
    for index in layers.iter().map(|layer| layer.index).chain([base]) {
        require_index("index n + i k", index)?;
    }
    for layer in layers {
        require((0.0..=1e9).contains(&layer.thickness), "thickness", layer.thickness, "nm", "0 to 1e9")?;
    }
    Ok(from_base(ambient, layers.iter().rev().copied(), base, wavelength, angle, component))
}

/// [`reflect_transmit`] for checked input and layers counted from the base.
pub(crate) fn from_base(
    ambient: f64,
    layers: impl Iterator<Item = Layer>,
    base: Complex<f64>,
    wavelength: f64,
    angle: f64,
    component: Component,
) -> Shares {
    let cos = angle.cos();
    if cos <= 0.0 {
        return Shares { reflectivity: 1.0, transmittance: 0.0 };
    }
    // n² - n_ambient² sin² without the cancellation at grazing in the ambient's own medium.
    let kz = |n: Complex<f64>| upper_root((n - ambient) * (n + ambient) + ambient * ambient * cos * cos);
    let weight = |n: Complex<f64>| match component {
        Component::S => Complex::new(1.0, 0.0),
        Component::P => (n * n).inv(),
    };
    let outside = ambient * cos * weight(Complex::new(ambient, 0.0)).re;
    let inside = kz(base) * weight(base);
    let (mut e, mut h) = (Complex::new(1.0, 0.0), inside);
    let mut log_scale = 0.0;
    for layer in layers {
        let (kz, weight) = (kz(layer.index), weight(layer.index));
        let path = Complex::new(0.0, 2.0 * TAU / wavelength * layer.thickness);
        let exponent = path * kz;
        let sum = 0.5 * (exponent.exp() + 1.0);
        // (1 - E2) / 2 = -kz · slope, with slope finite at kz = 0
        let slope = 0.5 * path * exprel(exponent);
        (e, h) = (e * sum - h * slope / weight, h * sum - e * kz * kz * weight * slope);
        let size = e.norm().max(h.norm());
        e /= size;
        h /= size;
        log_scale += 0.5 * exponent.re - size.ln();
    }
    let (incident, reflected) = (outside * e + h, outside * e - h);
    let denominator = incident.norm_sqr();
    if denominator <= 0.0 {
        return Shares { reflectivity: 1.0, transmittance: 0.0 };
    }
    Shares {
        reflectivity: reflected.norm_sqr() / denominator,
        transmittance: 4.0 * outside * inside.re * (2.0 * log_scale).exp() / denominator,
    }
}

/// The square root in the upper half plane: the wave that decays away from the light.
fn upper_root(value: Complex<f64>) -> Complex<f64> {
    let root = value.sqrt();
    if root.im < 0.0 { -root } else { root }
}

/// `(exp(z) - 1) / z`, by its series where the difference would cancel.
fn exprel(z: Complex<f64>) -> Complex<f64> {
    if z.norm_sqr() < 1e-4 {
        let mut term = Complex::new(1.0, 0.0);
        let mut sum = term;
        for order in 2..=9 {
            term = term * z / f64::from(order);
            sum += term;
        }
        sum
    } else {
        (z.exp() - 1.0) / z
    }
}
