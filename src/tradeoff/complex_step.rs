//! The `blend` model in complex numbers, and its derivatives by the complex step.
//!
//! ```text
//! df/dx = Im f(x + i h) / h,   h = 1e-30
//! ```
//!
//! No difference is formed, so nothing cancels and the error is that of the formula. Every formula of the model is
//! analytic for real indices; the squared sizes of complex fields are not, so the sums of squares of the closed form stand in.
//! Two ways through the model share no recurrence: each tells the other's rounding.
//!
//! # Source
//! Squire and Trapp 1998, DOI 10.1137/S003614459631241X.

use nalgebra::{Complex, ComplexField, DMatrix};
use std::f64::consts::{FRAC_PI_2, TAU};

type C = Complex<f64>;

const STEP: f64 = 1e-30;
/// Cuticle of the default stack, in air.
const INDEX: f64 = 1.56;
const LAYERS: usize = 9;

/// How powers and sums are formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// Chebyshev recurrences, as the library does.
    Chebyshev,
    /// One matrix for each layer, and a mean of cosines.
    Product,
}

/// Readings at normal incidence: every plane (rad), wavelength (nm) and view (rad), the last fastest.
#[derive(Debug, Clone)]
pub(crate) struct Design {
    pub(crate) planes: Vec<f64>,
    pub(crate) wavelengths: Vec<f64>,
    pub(crate) views: Vec<f64>,
}

/// Derivatives of the readings by `d_air`, `d_cuticle`, `delta`, `phi_alpha`, `lamella_width`.
pub(crate) fn jacobian(design: &Design, values: &[f64; 5], way: Way) -> DMatrix<f64> {
    let columns: Vec<Vec<f64>> = (0..5)
        .map(|moved| {
            let at = |j: usize| C::new(values[j], if j == moved { STEP } else { 0.0 });
            readings(design, std::array::from_fn(at), way).into_iter().map(|value| value.im / STEP).collect()
        })
        .collect();
    DMatrix::from_fn(columns[0].len(), 5, |row, column| columns[column][row])
}

fn readings(design: &Design, [d_air, d_cuticle, delta, phi_alpha, width]: [C; 5], way: Way) -> Vec<C> {
    let lobes: Vec<C> = design.views.iter().map(|&view| lobe(view, delta, phi_alpha)).collect();
    let stack: Vec<C> = (design.wavelengths.iter())
        .map(|&wavelength| reflectivity((INDEX, LAYERS), TAU / wavelength, d_air, d_cuticle, -delta, way))
        .collect();
    let mut lamellae = Vec::new();
    for &wavelength in &design.wavelengths {
        for &view in &design.views {
            let half_k = 0.5 * TAU / wavelength;
            let array = array_factor((d_air + d_cuticle) * (half_k * (1.0 + view.cos())), way);
            let slit = slit_factor(width * (half_k * view.sin()));
            lamellae.push(array * array * slit * slit);
        }
    }
    let mut readings = Vec::with_capacity(design.planes.len() * lamellae.len());
    for plane in &design.planes {
        let (share_b, share_a) = (plane.sin().powi(2), plane.cos().powi(2));
        for (row, &r) in stack.iter().enumerate() {
            for (view, &lobe) in lobes.iter().enumerate() {
                readings.push(lamellae[row * lobes.len() + view] * share_a + r * lobe * share_b);
            }
        }
    }
    readings
}

/// The lobe at normal incidence.
fn lobe(view: f64, delta: C, phi_alpha: C) -> C {
    let offset = C::new(view, 0.0) - delta * 2.0;
    if offset.re.abs() < phi_alpha.re { ComplexField::cos(offset / phi_alpha * FRAC_PI_2) } else { C::new(0.0, 0.0) }
}

fn slit_factor(y: C) -> C {
    if y.re.abs() < f64::MIN_POSITIVE { C::new(1.0, 0.0) } else { ComplexField::sin(y) / y }
}

/// `sin(M x) / (M sin x)`.
#[allow(clippy::cast_precision_loss, reason = "nine layers")]
fn array_factor(x: C, way: Way) -> C {
    let count = LAYERS as f64;
    match way {
        Way::Chebyshev => chebyshev(ComplexField::cos(x) * 2.0, LAYERS).0 / count,
        Way::Product => {
            let cosine = |layer: usize| ComplexField::cos(x * (count - 1.0 - 2.0 * layer as f64));
            (0..LAYERS).map(cosine).sum::<C>() / count
        }
    }
}

/// `U_(M-1)` and `U_(M-2)` for a trace.
fn chebyshev(trace: C, layers: usize) -> (C, C) {
    let (mut u, mut v) = (C::new(1.0, 0.0), C::new(0.0, 0.0));
    for _ in 1..layers {
        (u, v) = (trace * u - v, u);
    }
    (u, v)
}

/// A matrix `[a, i b; i c, d]` as `[a, b, c, d]`.
type Matrix = [C; 4];

fn product([a, b, c, d]: Matrix, [e, f, g, h]: Matrix) -> Matrix {
    [a * e - b * g, a * f + b * h, c * e + d * g, d * h - c * f]
}

/// `dR/dd_cuticle` at normal incidence of `layers` layers of `index` in air.
pub(crate) fn slope(index: f64, layers: usize, wavelength: f64, d_air: f64, d_cuticle: f64) -> f64 {
    let (gap, cuticle) = (C::new(d_air, 0.0), C::new(d_cuticle, STEP));
    let normal = C::new(0.0, 0.0);
    reflectivity((index, layers), TAU / wavelength, gap, cuticle, normal, Way::Chebyshev).im / STEP
}

/// Mean of `R_s` and `R_p` in air.
fn reflectivity((index, layers): (f64, usize), k: f64, d_air: C, d_cuticle: C, angle: C, way: Way) -> C {
    let (sin, cos) = (ComplexField::sin(angle), ComplexField::cos(angle));
    let cos_inside = ComplexField::sqrt(C::new(1.0, 0.0) - sin * sin / (index * index));
    let phases = [d_cuticle * cos_inside * (index * k), d_air * cos * k];
    // For p the impedance stands in for the admittance: the same R.
    let each = [(cos, cos_inside * index), (cos, cos_inside / index)].map(|(outside, inside)| {
        let layer = |phase: C, y: C| {
            let (sin, cos) = (ComplexField::sin(phase), ComplexField::cos(phase));
            [cos, sin / y, sin * y, cos]
        };
        let period = product(layer(phases[0], inside), layer(phases[1], outside));
        let one = C::new(1.0, 0.0);
        let zero = C::new(0.0, 0.0);
        let [a, b, c, d] = match way {
            Way::Product => (0..layers).fold([one, zero, zero, one], |sum, _| product(sum, period)),
            Way::Chebyshev => {
                let (u, v) = chebyshev(period[0] + period[3], layers);
                [u * period[0] - v, u * period[1], u * period[2], u * period[3] - v]
            }
        };
        let (real, imaginary) = (outside * (a - d), outside * outside * b - c);
        let numerator = real * real + imaginary * imaginary;
        numerator / (numerator + outside * outside * 4.0)
    });
    (each[0] + each[1]) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Polarization};
    use crate::inversion::structure;
    use crate::optics::{BlendModel, ReflectivityModel};

    #[test]
    fn its_real_part_is_the_model_and_both_ways_agree() {
        let values = [141.0, 62.0, 0.04, 0.5, 300.0];
        let design = Design { planes: vec![0.3], wavelengths: vec![440.0, 530.0], views: vec![-0.5, 0.0, 0.2, 1.2] };
        let complex = values.map(|value| C::new(value, 0.0));
        for way in [Way::Chebyshev, Way::Product] {
            let mut found = readings(&design, complex, way).into_iter();
            for &wavelength in &design.wavelengths {
                for &phi in &design.views {
                    let geometry = Geometry { theta: 0.0, phi, omega: 0.3 };
                    let expected = BlendModel::default()
                        .reflectivity(&structure(&values), &geometry, Polarization::Unpolarized, wavelength)
                        .unwrap();
                    assert!((found.next().unwrap().re - expected).abs() < 1e-13);
                }
            }
        }
        let (one, other) = (jacobian(&design, &values, Way::Chebyshev), jacobian(&design, &values, Way::Product));
        assert!((&one - &other).norm() < 1e-12 * one.norm());
    }
}
