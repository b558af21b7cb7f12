//! Model B at grazing incidence and past it.

use crate::support::stacks::{BOTH, real};
use crate::{ROUNDING, TABLE1, along, assert_near, assert_out_of_range, models, of_layers, read, stack_reflectivity};
use morpho_fit::optics::multilayer::SAndP;
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::multilayer::intensity::recurrence;
use morpho_fit::optics::{Material, Stack, Structure};
use morpho_fit::units::radians;
use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI};

#[test]
fn at_grazing_incidence_the_stack_reflects_all() {
    for layers in [1, 2, 9, 1000] {
        for angle in [FRAC_PI_2, radians(90.0), -FRAC_PI_2] {
            for wavelength in [380.0, 470.0, 583.0, 740.0] {
                for base in [1.0, 1.3, 1.56] {
                    let stack = Stack { base: Material::constant(base), ..of_layers(layers) };
                    let found = stack_reflectivity(&stack, TABLE1, wavelength, angle);
                    assert_near(found.s, 1.0, ROUNDING);
                    assert_near(found.p, 1.0, ROUNDING);
                    for model in models(&stack) {
                        let media = model.stack().media(wavelength).expect("media");
                        let found = model.stack_reflectivity(&media, TABLE1, angle).expect("an answer");
                        assert_near(found.mean(), 1.0, ROUNDING);
                    }
                }
            }
        }
    }
}

#[test]
fn at_grazing_incidence_layer_by_layer_all_is_reflected_and_nothing_passes() {
    let film = [Layer { index: Complex::new(1.56, 0.06), thickness: 100.0 }];
    for component in BOTH {
        for layers in [&film[..], &[]] {
            let found = reflect_transmit(1.0, layers, real(1.56), 480.0, FRAC_PI_2, component).expect("an answer");
            assert_near(found.reflectivity, 1.0, ROUNDING);
            assert_near(found.transmittance, 0.0, ROUNDING);
        }
    }
}

#[test]
fn the_recurrence_refuses_a_cosine_of_exactly_zero_and_is_one_beside_it() {
    // n cos = 0 for s, n / cos = inf for p: 0/0 in the printed form.
    for grazing in [0.0, f64::INFINITY] {
        assert_out_of_range(recurrence(&[1.0, 1.2, grazing], &[1.0]), "admittance");
        assert_out_of_range(recurrence(&[grazing, 1.2, grazing], &[1.0]), "admittance");
    }
    let cos = FRAC_PI_2.cos();
    for grazing in [cos, 1.0 / cos] {
        assert_near(recurrence(&[1.56, 1.2, grazing], &[1.0]).expect("an answer"), 1.0, ROUNDING);
        assert_near(recurrence(&[grazing, 1.2, grazing], &[1.0]).expect("an answer"), 1.0, ROUNDING);
    }
}

#[test]
fn towards_grazing_the_reflectivity_rises_to_one_without_a_step() {
    let mut before = SAndP::default();
    for exponent in 2..=15 {
        let found = stack_reflectivity(&Stack::default(), TABLE1, 480.0, FRAC_PI_2 - 10.0_f64.powi(-exponent));
        assert!(found.s >= before.s - ROUNDING && found.p >= before.p - ROUNDING, "{exponent}: {found:?}");
        before = found;
    }
    assert_near(before.s, 1.0, ROUNDING);
    assert_near(before.p, 1.0, ROUNDING);
}

#[test]
fn a_stack_turned_past_grazing_is_in_its_own_shadow() {
    for model in models(&Stack::default()) {
        for (theta, delta) in [(75.0, -30.0), (-75.0, 30.0), (90.0, -1e-6), (90.0, -89.0)] {
            let structure = Structure { delta: radians(delta), phi_alpha: 3.0, ..Structure::table1() };
            for phi in [-90.0, -30.0, 0.0, 30.0, 90.0] {
                assert_near(read(&*model, &structure, &along(theta, phi), 480.0), 0.0, 0.0);
            }
        }
    }
    for angle in [FRAC_PI_2 + 1e-9, 2.0, PI, -2.0] {
        assert_near(stack_reflectivity(&Stack::default(), TABLE1, 480.0, angle).mean(), 0.0, 0.0);
        let layer_by_layer = reflect_transmit(1.0, &[], real(1.5), 480.0, angle, Component::S);
        assert_out_of_range(layer_by_layer, "angle");
    }
}
