//! Many layers, thick layers, absorption, narrow lobes.

use crate::support::stacks::{BOTH, real};
use crate::{
    POLARIZATIONS, ROUNDING, TABLE1, along, assert_near, assert_out_of_range, models, of_layers, read,
    stack_reflectivity, upright,
};
use morpho_fit::geometry::Polarization;
use morpho_fit::optics::ReflectivityModel;
use morpho_fit::optics::multilayer;
use morpho_fit::optics::multilayer::amplitude::{Layer, reflect_transmit};
use morpho_fit::optics::{MAX_LAYERS, Material, Media, OpticsError, PaperModel, Snell, Stack, Structure};
use morpho_fit::units::radians;
use nalgebra::Complex;

#[test]
fn thousands_of_layers_deep_in_the_gap_are_a_mirror() {
    for layers in [1000, 2000, 3000, MAX_LAYERS] {
        for base in [1.0, 1.56] {
            let stack = Stack { base: Material::constant(base), ..of_layers(layers) };
            let found = stack_reflectivity(&stack, TABLE1, 583.0, 0.0);
            assert_near(found.s, 1.0, ROUNDING);
            assert_near(found.p, 1.0, ROUNDING);
            for model in models(&stack) {
                assert_near(read(&*model, &upright(), &along(0.0, 0.0), 583.0), 1.0, ROUNDING);
            }
        }
    }
}

#[test]
fn thousands_of_layers_agree_with_the_layer_by_layer_method_inside_and_beside_the_gap() {
    for layers in [1000, 3000] {
        let list = [Layer { index: real(1.56), thickness: 100.0 }, Layer { index: real(1.0), thickness: 135.0 }]
            .repeat(layers);
        for wavelength in [400.0, 470.0, 500.0, 520.0, 583.0, 640.0, 660.0, 740.0] {
            for angle in [0.0, 45.0, 85.0].map(radians) {
                let found = stack_reflectivity(&of_layers(layers), TABLE1, wavelength, angle);
                for (component, value) in BOTH.into_iter().zip([found.s, found.p]) {
                    let expected = reflect_transmit(1.0, &list, real(1.0), wavelength, angle, component);
                    assert_near(value, expected.expect("an answer").reflectivity, 1e-8);
                }
            }
        }
    }
}

#[test]
fn a_lobe_narrowed_to_nothing_is_its_mirror_direction() {
    for model in models(&Stack::default()) {
        for phi_alpha in [1e-9, 1e-300, f64::MIN_POSITIVE, 5e-324] {
            let structure = Structure { phi_alpha, ..upright() };
            let wide = read(&*model, &upright(), &along(20.0, -20.0), 583.0);
            assert_near(read(&*model, &structure, &along(20.0, -20.0), 583.0), wide, ROUNDING);
            for phi in [-20.1, -19.9, 0.0, 90.0] {
                assert_near(read(&*model, &structure, &along(20.0, phi), 583.0), 0.0, 0.0);
            }
        }
        let none = Structure { phi_alpha: 0.0, ..upright() };
        let found = model.reflectivity(&none, &along(20.0, -20.0), Polarization::S, 583.0);
        assert_out_of_range(found, "phi_alpha");
    }
}

#[test]
fn a_very_thick_absorbing_layer_is_a_half_space() {
    for index in [Complex::new(1.56, 0.06), Complex::new(0.05, 4.0), Complex::new(2.0, 1e-3)] {
        // From 2 mm on: 25 nepers and more even for k = 1e-3, up to where exp(-2 k d) is 0.
        for thickness in [2e6, 1e7, 1e9] {
            for angle in [0.0, 45.0, 89.0].map(radians) {
                for component in BOTH {
                    let surface = reflect_transmit(1.0, &[], index, 480.0, angle, component).expect("an answer");
                    let layer = [Layer { index, thickness }];
                    let found = reflect_transmit(1.0, &layer, real(1.5), 480.0, angle, component).expect("an answer");
                    assert_near(found.reflectivity, surface.reflectivity, ROUNDING);
                    assert_near(found.transmittance, 0.0, ROUNDING);
                }
            }
        }
    }
}

#[test]
fn a_hundred_thousand_absorbing_periods_reflect_as_a_thousand_do() {
    let absorbing = |layers| Stack { cuticle: Material::Constant { n: 1.56, k: 0.06 }, ..of_layers(layers) };
    for wavelength in [400.0, 554.0, 740.0] {
        let few = stack_reflectivity(&absorbing(1000), TABLE1, wavelength, 0.5);
        let many = stack_reflectivity(&absorbing(MAX_LAYERS), TABLE1, wavelength, 0.5);
        assert_near(many.s, few.s, ROUNDING);
        assert_near(many.p, few.p, ROUNDING);
    }
}

#[test]
fn one_absorbing_medium_of_the_stack_is_enough_to_leave_the_real_closed_form() {
    let absorbing = |n| Material::Constant { n, k: 0.06 };
    let stacks = [
        ("cuticle", Stack { cuticle: absorbing(1.56), ..Stack::default() }),
        ("gap", Stack { gap: absorbing(1.0), ..Stack::default() }),
        ("base", Stack { base: absorbing(1.56), ..Stack::default() }),
    ];
    for (medium, stack) in stacks {
        let media = stack.media(470.0).expect("media");
        let list =
            [Layer { index: media.cuticle, thickness: 100.0 }, Layer { index: media.gap, thickness: 135.0 }].repeat(9);
        for angle in [0.0, 0.2, 1.5] {
            let found = stack_reflectivity(&stack, TABLE1, 470.0, angle);
            for (component, value) in BOTH.into_iter().zip([found.s, found.p]) {
                let expected = reflect_transmit(1.0, &list, media.base, 470.0, angle, component);
                assert_near(value, expected.expect("an answer").reflectivity, ROUNDING);
            }
            let transparent =
                Media { cuticle: real(media.cuticle.re), gap: real(media.gap.re), base: real(media.base.re), ..media };
            let lossless = multilayer::reflectivity(&transparent, TABLE1, 9, angle).expect("an answer");
            assert!((found.mean() - lossless.mean()).abs() > 1e-4, "{medium}: absorption is not seen");
        }
        for snell in [Snell::Right, Snell::Printed] {
            let model = PaperModel { stack: stack.clone(), snell, ..PaperModel::default() };
            let found = model.reflectivity(&upright(), &along(0.0, 0.0), Polarization::Unpolarized, 470.0);
            let expected = OpticsError::Absorbing { model: "paper", medium, k: 0.06 };
            assert_eq!(found, Err(expected));
        }
    }
}

#[test]
fn absorption_sets_in_without_a_step() {
    for wavelength in [480.0, 554.0, 583.0] {
        let clear = stack_reflectivity(&Stack::default(), TABLE1, wavelength, 0.4);
        for k in [f64::MIN_POSITIVE, 1e-300, 1e-15] {
            let stack = Stack { cuticle: Material::Constant { n: 1.56, k }, ..Stack::default() };
            let found = stack_reflectivity(&stack, TABLE1, wavelength, 0.4);
            assert_near(found.s, clear.s, ROUNDING);
            assert_near(found.p, clear.p, ROUNDING);
        }
    }
}

#[test]
fn each_polarization_is_a_share_of_the_unpolarized_reading() {
    for model in models(&Stack::default()) {
        let [unpolarized, s, p] = POLARIZATIONS.map(|polarization| {
            model.reflectivity(&upright(), &along(50.0, -50.0), polarization, 480.0).expect("an answer")
        });
        assert_near(unpolarized, 0.5 * (s + p), ROUNDING);
    }
}
