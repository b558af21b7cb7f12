//! Model B without contrast, thickness or reflection.

use crate::support::stacks::real;
use crate::{ROUNDING, TABLE1, along, assert_near, fresnel, models, of_layers, read, stack_reflectivity, upright};
use morpho_fit::optics::multilayer::Period;
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::multilayer::intensity::recurrence;
use morpho_fit::optics::{Material, Stack, Structure};
use morpho_fit::units::radians;
use std::f64::consts::TAU;

#[test]
fn without_contrast_the_stack_is_its_base() {
    for n_base in [1.0, 1.33, 1.56, 4.0] {
        let air = Material::constant(1.0);
        let stack = Stack { cuticle: air, base: Material::constant(n_base), ..Stack::default() };
        for angle in [0.0, 20.0, 57.3, 89.0].map(radians) {
            let (found, expected) = (stack_reflectivity(&stack, TABLE1, 480.0, angle), fresnel(n_base, angle));
            assert_near(found.s, expected.s, ROUNDING);
            assert_near(found.p, expected.p, ROUNDING);
            let phases = [0.3; 18];
            let mut admittances = [angle.cos(); 20];
            admittances[0] = (n_base * n_base - angle.sin().powi(2)).sqrt();
            assert_near(recurrence(&admittances, &phases).expect("an answer"), expected.s, ROUNDING);
        }
    }
}

#[test]
fn without_cuticle_or_without_any_thickness_the_stack_is_its_base() {
    for n_base in [1.0, 1.33, 1.56, 4.0] {
        let stack = Stack { base: Material::constant(n_base), ..Stack::default() };
        for (cuticle, gap) in [(0.0, 135.0), (0.0, 0.0), (1e-300, 135.0), (5e-324, 5e-324)] {
            for angle in [0.0, 20.0, 57.3, 89.0].map(radians) {
                let found = stack_reflectivity(&stack, Period { cuticle, gap }, 480.0, angle);
                let expected = fresnel(n_base, angle);
                assert_near(found.s, expected.s, ROUNDING);
                assert_near(found.p, expected.p, ROUNDING);
            }
        }
    }
}

#[test]
fn without_cuticle_the_models_along_the_ridges_are_dark() {
    for model in models(&Stack::default()) {
        let structure = Structure { d_cuticle: 0.0, ..upright() };
        for angle in [0.0, 20.0, 57.3, 89.0] {
            assert_near(read(&*model, &structure, &along(angle, -angle), 480.0), 0.0, ROUNDING);
        }
    }
}

#[test]
fn without_gaps_the_layers_are_one_thick_film() {
    let stack = of_layers(9);
    for angle in [0.0, 40.0, 80.0].map(radians) {
        let found = stack_reflectivity(&stack, Period { cuticle: 50.0, gap: 0.0 }, 480.0, angle);
        let film = stack_reflectivity(&of_layers(1), Period { cuticle: 450.0, gap: 0.0 }, 480.0, angle);
        assert_near(found.s, film.s, ROUNDING);
        assert_near(found.p, film.p, ROUNDING);
    }
}

#[test]
fn a_half_wave_layer_reflects_nothing_and_its_slope_is_finite() {
    // n d = 1.5 · 156 = 234 = λ/2: R = 0, where the phase and the slope of sqrt(R) are undefined.
    let stack = Stack { cuticle: Material::constant(1.5), ..of_layers(1) };
    let at = |thickness: f64| stack_reflectivity(&stack, Period { cuticle: thickness, gap: 0.0 }, 468.0, 0.0);
    // R = 4 r² sin²β / ((1 - r²)² + 4 r² sin²β) with r = 0.2 (Airy): R is 0.1736 δβ² beside its zero.
    let curvature = 4.0 * 0.04 / (0.96 * 0.96);
    for step in [0.0, 1e-9, 1e-6, 1e-3] {
        for sign in [-1.0, 1.0] {
            let beta = TAU * 1.5 * step / 468.0;
            let found = at(156.0 + sign * step).s;
            assert!(found >= 0.0);
            assert_near(found, curvature * beta * beta, ROUNDING * beta + 1e-31);
        }
    }
    let slope = (at(156.0 + 1e-6).s - at(156.0 - 1e-6).s) / 2e-6;
    assert_near(slope, 0.0, ROUNDING);
    assert_near(recurrence(&[1.0, 1.5, 1.0], &[TAU]).expect("an answer"), 0.0, ROUNDING);
    let layer = [Layer { index: real(1.5), thickness: 156.0 }];
    let found = reflect_transmit(1.0, &layer, real(1.0), 468.0, 0.0, Component::S).expect("an answer");
    assert_near(found.reflectivity, 0.0, 1e-30);
}
