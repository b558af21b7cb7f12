//! Numbers of the paper's structure: peaks and lobes.

use crate::geometry::{Geometry, Polarization};
use crate::optics::{OpticsError, ReflectivityModel, Structure};
use crate::synthetic::linspace;
use crate::units::{degrees, radians};
use std::f64::consts::FRAC_PI_2;

/// Thicknesses of the gap in the table of peaks, nm, with the cuticle 235 nm less.
pub const GAPS: [f64; 8] = [35.0, 60.0, 85.0, 110.0, 135.0, 160.0, 185.0, 200.0];
/// Wavelengths of Model A's lobes, nm, about the peak of Table 1.
pub(super) const LAMELLA_WAVELENGTHS: [f64; 7] = [400.0, 420.0, 440.0, 460.0, 470.0, 480.0, 500.0];
/// `d_air + d_cuticle` of the paper, nm.
pub const PERIOD: f64 = 235.0;

/// Where a curve is largest and where it has fallen to half of that, beyond its maximum away from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Angle of the maximum at positive angles, degrees; 0 if that is the middle.
    pub maximum: f64,
    /// Angle at half of the maximum, degrees; none if it stays above up to 90°.
    pub half: Option<f64>,
}

/// Table 1 with another gap and the paper's rule for the cuticle (section 4.4), on layers without tilt.
#[must_use]
pub fn untilted(gap: f64) -> Structure {
    Structure { d_air: gap, d_cuticle: PERIOD - gap, delta: 0.0, ..Structure::table1() }
}

/// Table 1 along the ridges, met at `angle` from the normal of its tilted layers and seen in their mirror direction, rad:
/// `θ = δ + angle`, `φ = δ − angle`.
#[must_use]
pub fn mirrored(angle: f64) -> Geometry {
    let delta = Structure::table1().delta;
    Geometry { theta: delta + angle, phi: delta - angle, omega: FRAC_PI_2 }
}

/// Wavelength at which a structure reflects most, nm, between 380 and 780 by 0.1.
///
/// # Errors
/// [`OpticsError`] if the model has no value.
pub fn peak(model: &dyn ReflectivityModel, structure: &Structure, geometry: &Geometry) -> Result<f64, OpticsError> {
    let mut best = (f64::NEG_INFINITY, 0.0);
    for wavelength in linspace(380.0, 780.0, 4001) {
        let value = model.reflectivity(structure, geometry, Polarization::Unpolarized, wavelength)?;
        if value > best.0 {
            best = (value, wavelength);
        }
    }
    Ok(best.1)
}

/// The lobe of the lamellae of Table 1 at normal incidence.
///
/// # Errors
/// [`OpticsError`] if the model has no value.
pub fn lobe(model: &dyn ReflectivityModel, wavelength: f64) -> Result<Lobe, OpticsError> {
    let angles = linspace(0.0, 90.0, 9001);
    let at = |angle: &f64| {
        let geometry = Geometry { theta: 0.0, phi: radians(*angle), omega: 0.0 };
        model.reflectivity(&Structure::table1(), &geometry, Polarization::Unpolarized, wavelength)
    };
    let values = angles.iter().map(at).collect::<Result<Vec<f64>, _>>()?;
    let top = (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j]).then(j.cmp(&i))).unwrap_or(0);
    let half = (top..values.len()).find(|&i| values[i] < 0.5 * values[top]).map(|i| angles[i]);
    Ok(Lobe { maximum: angles[top], half })
}

/// The angle beyond which Snell's law as printed has no ray in the cuticle, degrees from the normal of the layers.
///
/// ```
/// assert!((morpho_fit::report::paper::no_ray_beyond(1.56) - 39.87).abs() < 0.005);
/// ```
#[must_use]
pub fn no_ray_beyond(n_cuticle: f64) -> f64 {
    degrees((1.0 / n_cuticle).clamp(-1.0, 1.0).asin())
}
