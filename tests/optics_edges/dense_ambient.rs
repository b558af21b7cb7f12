//! Light from a dense medium, past the critical angle.

use crate::support::stacks::{BOTH, real};
use crate::{LOOSE, ROUNDING, TABLE1, assert_near, read, stack_reflectivity, upright};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::ReflectivityModel;
use morpho_fit::optics::multilayer::Period;
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::{Admittance, BlendModel, Material, OpticsError, PaperModel, Snell, Stack};
use morpho_fit::units::radians;
use std::f64::consts::{FRAC_PI_2, TAU};

#[test]
fn past_the_critical_angle_of_the_base_all_is_reflected() {
    let dense = Material::constant(1.56);
    let stack = Stack { ambient: dense.clone(), ..Stack::default() };
    let critical = (1.0_f64 / 1.56).asin();
    for angle in [critical + 1e-9, critical + 1e-3, 0.8, 1.2, 1.5] {
        let found = stack_reflectivity(&stack, TABLE1, 480.0, angle);
        assert_near(found.s, 1.0, ROUNDING);
        assert_near(found.p, 1.0, ROUNDING);
        for component in BOTH {
            let found = reflect_transmit(1.56, &[], real(1.0), 480.0, angle, component).expect("an answer");
            assert_near(found.reflectivity, 1.0, ROUNDING);
            assert_near(found.transmittance, 0.0, ROUNDING);
        }
        let model = BlendModel { stack: stack.clone() };
        let geometry = Geometry { theta: angle, phi: -angle, omega: FRAC_PI_2 };
        assert_near(read(&model, &upright(), &geometry, 480.0), 1.0, ROUNDING);
        // The printed formulas know no evanescent wave.
        for admittance in [Admittance::Mean, Admittance::PerPolarization] {
            for snell in [Snell::Right, Snell::Printed] {
                let model = PaperModel { stack: stack.clone(), snell, admittance, ..PaperModel::default() };
                let found = model.reflectivity(&upright(), &geometry, Polarization::Unpolarized, 480.0);
                match (snell, found) {
                    (Snell::Right, found) => {
                        assert!(matches!(found, Err(OpticsError::NoRefractedRay { .. })), "{found:?}");
                    }
                    (Snell::Printed, Ok(value)) => assert!((0.0..=1.0).contains(&value), "{value}"),
                    (Snell::Printed, Err(_)) => {}
                }
            }
        }
    }
}

/// Some numbers around `angle`, neighbours in floating point among them: the cosine inside is exactly 0 at one of them.
fn around(angle: f64) -> Vec<f64> {
    let (mut up, mut down, mut angles) = (angle, angle, vec![angle]);
    for _ in 0..40 {
        (up, down) = (up.next_up(), down.next_down());
        angles.extend([up, down]);
    }
    angles
}

#[test]
fn exactly_at_the_critical_angle_of_a_layer_the_tunnelling_formula_holds() {
    // A gap of index 1 in a medium of index 2, at 30°: inside, the field is a straight line. From the matrix
    // [[1, -i k d], [0, 1]] for s, [[1, -i k d n²], [0, 1]] for p: R = t² / (1 + t²), t = k d y / 2.
    let (wavelength, thickness) = (480.0, 50.0);
    for angle in around(radians(30.0)) {
        for (component, y) in [(Component::S, 2.0 * angle.cos()), (Component::P, angle.cos() / 2.0)] {
            let t = TAU / wavelength * thickness * y / 2.0;
            let expected = t * t / (1.0 + t * t);
            let layer = [Layer { index: real(1.0), thickness }];
            let found = reflect_transmit(2.0, &layer, real(2.0), wavelength, angle, component).expect("an answer");
            assert_near(found.reflectivity, expected, LOOSE);
            assert_near(found.transmittance, 1.0 - expected, LOOSE);
            // The same slab as the cuticle layer of a stack in the dense medium.
            let dense = Material::constant(2.0);
            let stack = Stack {
                ambient: dense.clone(),
                cuticle: Material::constant(1.0),
                gap: dense.clone(),
                base: dense,
                layers: 1,
                filling: None,
            };
            let period = Period { cuticle: thickness, gap: 70.0 };
            let both = stack_reflectivity(&stack, period, wavelength, angle);
            assert_near(if component == Component::S { both.s } else { both.p }, expected, LOOSE);
        }
    }
}

#[test]
fn exactly_at_the_critical_angle_of_the_base_all_is_reflected() {
    for angle in around(radians(30.0)) {
        let stack = Stack {
            ambient: Material::constant(2.0),
            cuticle: Material::constant(1.56),
            gap: Material::constant(1.3),
            ..Stack::default()
        };
        let found = stack_reflectivity(&stack, TABLE1, 480.0, angle);
        // On the near side 1 - R falls as the square root of the distance, here 1e-15.
        assert_near(found.s, 1.0, 1e-6);
        assert_near(found.p, 1.0, 1e-6);
        assert!(found.s <= 1.0 + ROUNDING && found.p <= 1.0 + ROUNDING);
    }
}

#[test]
fn at_the_critical_angle_every_layer_of_a_stack_may_be_singular_at_once() {
    let dense = Material::constant(2.0);
    let stack = Stack {
        ambient: dense.clone(),
        cuticle: dense.clone(),
        gap: Material::constant(1.0),
        base: dense,
        layers: 30,
        filling: None,
    };
    for angle in around(radians(30.0)) {
        let found = stack_reflectivity(&stack, TABLE1, 480.0, angle);
        for value in [found.s, found.p] {
            assert!((0.0..=1.0 + ROUNDING).contains(&value), "{value}");
        }
    }
}
