//! Layers of any materials in any order at many wavelengths, against another program, 60 digits and closed forms.

mod support;

use morpho_fit::optics::multilayer::amplitude::Component;
use morpho_fit::optics::multilayer::general::{Film, LayeredStack};
use morpho_fit::optics::multilayer::{Period, SAndP, reflectivities, reflectivity};
use morpho_fit::optics::{Material, OpticsError, Stack};
use morpho_fit::units::radians;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, TAU};
use support::stacks;

/// Absolute; the tables hold 16 digits.
const EXACT: f64 = 1e-12;

fn material(index: Complex<f64>) -> Material {
    Material::Constant { n: index.re, k: index.im }
}

fn film(n: f64, k: f64, thickness: f64) -> Film {
    Film { material: Material::Constant { n, k }, thickness }
}

fn on(films: Vec<Film>, ambient: f64, base: Complex<f64>) -> LayeredStack {
    LayeredStack { ambient: Material::constant(ambient), films, base: material(base) }
}

fn assert_near(found: f64, expected: f64, tolerance: f64, what: &dyn std::fmt::Debug) {
    assert!((found - expected).abs() <= tolerance, "{found:.17} is not {expected:.17}: {what:?}");
}

#[test]
fn any_list_of_layers_reflects_as_in_tmm() {
    let rows = stacks::general();
    assert_eq!(rows.len(), 330);
    for row in rows {
        let films = row.layers.iter().map(|layer| film(layer.index.re, layer.index.im, layer.thickness)).collect();
        let found = on(films, row.ambient, row.base).reflectivities(&[row.wavelength], row.theta).expect("valid")[0];
        let found = if row.component == Component::S { found.s } else { found.p };
        assert_near(found, row.expected.reflectivity, EXACT, &row);
    }
}

#[test]
fn periodic_stacks_of_60_digits_hold() {
    for row in stacks::periodic() {
        let films = row.layer_list().iter().map(|layer| film(layer.index.re, 0.0, layer.thickness)).collect();
        let stack = on(films, 1.0, stacks::real(row.n_base));
        let found = stack.reflectivities(&[row.wavelength], row.theta).expect("valid")[0];
        assert_near(found.s, row.expected.s, EXACT, &row);
        assert_near(found.p, row.expected.p, EXACT, &row);
    }
}

/// `r = (r01 + r12 E2) / (1 + r01 r12 E2)` with Fresnel's coefficients and `E2 = exp(2 i kz k d)`.
fn airy(ambient: f64, film: Complex<f64>, thickness: f64, base: Complex<f64>, wavelength: f64, angle: f64) -> SAndP {
    let kz = |n: Complex<f64>| (n * n - (ambient * angle.sin()).powi(2)).sqrt();
    let outside = Complex::new(ambient, 0.0);
    let of = |weight: fn(Complex<f64>) -> Complex<f64>| {
        let y = [outside, film, base].map(|n| kz(n) * weight(n));
        let r = |a: Complex<f64>, b: Complex<f64>| (a - b) / (a + b);
        let round = (Complex::new(0.0, 2.0 * TAU / wavelength * thickness) * kz(film)).exp();
        ((r(y[0], y[1]) + r(y[1], y[2]) * round) / (1.0 + r(y[0], y[1]) * r(y[1], y[2]) * round)).norm_sqr()
    };
    SAndP { s: of(|_| Complex::new(1.0, 0.0)), p: of(|n| (n * n).inv()) }
}

#[test]
fn one_film_is_that_of_airys_sum() {
    let wavelengths: Vec<f64> = (300..=900).map(f64::from).collect();
    for (n, k) in [(1.38, 0.0), (1.56, 0.06), (0.05, 3.3), (2.2, 1e-9)] {
        for (thickness, angle) in [(0.0, 0.3), (20.0, 0.0), (150.0, 1.0), (3000.0, 1.5)] {
            let base = Complex::new(3.9, 0.02);
            let stack = on(vec![film(n, k, thickness)], 1.0, base);
            let found = stack.reflectivities(&wavelengths, angle).expect("valid");
            for (&wavelength, found) in wavelengths.iter().zip(found) {
                let expected = airy(1.0, Complex::new(n, k), thickness, base, wavelength, angle);
                assert_near(found.s, expected.s, EXACT, &(n, k, thickness, angle, wavelength));
                assert_near(found.p, expected.p, EXACT, &(n, k, thickness, angle, wavelength));
            }
        }
    }
}

#[test]
fn half_waves_vanish_and_quarter_waves_make_a_mirror() {
    // At 500 nm a half wave of 1.5 and one of 2.5 leave the bare surface, whatever stands between them.
    let films = vec![film(1.5, 0.0, 500.0 / 3.0), film(2.5, 0.0, 100.0), film(1.5, 0.0, 500.0 / 3.0)];
    let found = on(films, 1.0, stacks::real(3.5)).reflectivities(&[500.0], 0.0).expect("valid")[0];
    assert_near(found.s, (2.5_f64 / 4.5).powi(2), EXACT, &found);
    assert_near(found.p, found.s, EXACT, &found);
    // (H L)^N H on glass: admittance (nH / nL)^(2N) nH² / nglass
    for pairs in [1, 3, 8] {
        let (high, low) = (film(2.35, 0.0, 550.0 / 4.0 / 2.35), film(1.38, 0.0, 550.0 / 4.0 / 1.38));
        let mut films: Vec<Film> = (0..pairs).flat_map(|_| [high.clone(), low.clone()]).collect();
        films.push(high);
        let found = on(films, 1.0, stacks::real(1.52)).reflectivities(&[550.0], 0.0).expect("valid")[0];
        let admittance = (2.35_f64 / 1.38).powf(2.0 * pairs as f64) * 2.35 * 2.35 / 1.52;
        assert_near(found.s, ((1.0 - admittance) / (1.0 + admittance)).powi(2), EXACT, &pairs);
    }
}

#[test]
fn a_layer_too_thick_for_light_to_return_is_its_bare_surface() {
    let (angle, index) = (1.1, Complex::new(1.7, 0.4));
    for thickness in [1e5, 1e9] {
        let films = vec![film(1.7, 0.4, thickness), film(1.3, 0.0, 50.0), film(2.0, 2.0, thickness)];
        let found = on(films, 1.0, stacks::real(1.0)).reflectivities(&[10.0, 480.0], angle).expect("valid");
        let expected = airy(1.0, index, 0.0, index, 480.0, angle);
        for found in found {
            assert_near(found.s, expected.s, EXACT, &thickness);
            assert_near(found.p, expected.p, EXACT, &thickness);
        }
    }
}

#[test]
fn grazing_light_and_light_past_the_critical_angle_are_reflected() {
    let films = || vec![film(1.7, 0.4, 90.0), film(1.3, 0.0, 50.0)];
    let grazing = on(films(), 1.0, stacks::real(1.5)).reflectivities(&[480.0, 500.0], FRAC_PI_2).expect("valid");
    assert!(grazing.iter().all(|found| (found.s - 1.0).abs() < EXACT && (found.p - 1.0).abs() < EXACT));
    // From 1.6 into air no wave leaves above 38.7°; lossless films, some of which carry a wave, change nothing.
    let lossless = vec![film(1.4, 0.0, 90.0), film(1.0, 0.0, 300.0), film(1.6, 0.0, 50.0)];
    let critical = (1.0_f64 / 1.6).asin();
    let spectra = on(lossless, 1.6, stacks::real(1.0)).spectra(&[480.0, 700.0], &[critical + 1e-9, 0.8, 1.0, 1.5]);
    for found in spectra.expect("valid") {
        assert_near(found.s, 1.0, 1e-11, &found);
        assert_near(found.p, 1.0, 1e-11, &found);
    }
}

#[test]
fn dispersion_gives_each_wavelength_its_own_index() {
    let chitin = Material::Cauchy { a: 1.517, b: 8.80e3 };
    let air = Material::constant(1.0);
    let layer = |thickness| Film { material: chitin.clone(), thickness };
    let films = vec![layer(90.0), Film { material: air.clone(), thickness: 120.0 }, layer(70.0)];
    let stack = LayeredStack { ambient: air.clone(), films, base: chitin.clone() };
    let wavelengths: Vec<f64> = (380..=740).step_by(7).map(f64::from).collect();
    let angles = [0.0, 0.7];
    let spectra = stack.spectra(&wavelengths, &angles).expect("valid");
    for (place, found) in spectra.into_iter().enumerate() {
        let (angle, wavelength) = (angles[place / wavelengths.len()], wavelengths[place % wavelengths.len()]);
        let n = 1.517 + 8.80e3 / (wavelength * wavelength);
        let films = vec![film(n, 0.0, 90.0), film(1.0, 0.0, 120.0), film(n, 0.0, 70.0)];
        let expected = on(films, 1.0, stacks::real(n)).reflectivities(&[wavelength], angle).expect("valid")[0];
        assert_near(found.s, expected.s, EXACT, &wavelength);
        assert_near(found.p, expected.p, EXACT, &wavelength);
    }
}

#[test]
fn an_absorbing_periodic_stack_is_the_same_at_once_and_one_by_one() {
    let stack = Stack { cuticle: Material::Constant { n: 1.56, k: 0.06 }, ..Stack::default() };
    let wavelengths: Vec<f64> = (380..=740).map(f64::from).collect();
    let (media, period) = (stack.media(500.0).expect("valid"), Period { cuticle: 100.0, gap: 135.0 });
    for angle in [0.0, radians(45.0), radians(89.0)] {
        let found = reflectivities(&media, &wavelengths, period, 9, angle).expect("valid");
        for (&wavelength, found) in wavelengths.iter().zip(found) {
            let expected = reflectivity(&stack.media(wavelength).expect("valid"), period, 9, angle).expect("valid");
            assert_near(found.s, expected.s, EXACT, &wavelength);
            assert_near(found.p, expected.p, EXACT, &wavelength);
        }
    }
}

#[test]
fn what_is_no_stack_is_refused() {
    let good = || on(vec![film(1.5, 0.0, 100.0)], 1.0, stacks::real(1.5));
    let refused = |stack: LayeredStack, wavelength: f64, angle: f64, name: &str| {
        let error = stack.reflectivities(&[500.0, wavelength], angle).expect_err(name);
        assert!(matches!(error, OpticsError::OutOfRange { .. }), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    };
    refused(good(), 0.5, 0.0, "wavelength");
    refused(good(), f64::NAN, 0.0, "wavelength");
    refused(good(), 500.0, 1.6, "angle");
    refused(on(vec![film(1.5, 0.0, -1.0)], 1.0, stacks::real(1.5)), 500.0, 0.0, "thickness");
    refused(on(vec![film(1.5, -0.1, 1.0)], 1.0, stacks::real(1.5)), 500.0, 0.0, "layer");
    refused(LayeredStack { ambient: Material::Constant { n: 1.0, k: 0.1 }, ..good() }, 500.0, 0.0, "ambient");
    assert_eq!(good().reflectivities(&[], 0.0), Ok(Vec::new()));
}
