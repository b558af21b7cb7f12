//! Model A at its singular points.

use crate::{LOOSE, ROUNDING, across, assert_near, assert_out_of_range, models, of_layers, read, upright};
use morpho_fit::geometry::Polarization;
use morpho_fit::optics::ReflectivityModel;
use morpho_fit::optics::lamella::array_factor;
use morpho_fit::optics::{LamellaUnit, PaperModel, Stack, Structure};
use morpho_fit::units::radians;
use nalgebra::Complex;
use std::f64::consts::TAU;

#[test]
fn in_the_mirror_direction_the_slit_factor_is_one() {
    for model in models(&Stack::default()) {
        for angle in [0.0_f64, 1e-9, 7.0, 30.0, 45.0, 61.3, 89.0] {
            // M equal phasors, added one by one: an array factor without a ratio.
            let step = TAU / 480.0 * 235.0 * 2.0 * radians(angle).cos();
            let phasors = (0..9).map(|layer| Complex::cis(f64::from(layer) * step)).sum::<Complex<f64>>();
            let expected = phasors.norm_sqr() / 81.0 * radians(angle).cos().powi(2);
            assert_near(read(&*model, &upright(), &across(angle, -angle), 480.0), expected, ROUNDING);
            assert_near(read(&*model, &upright(), &across(-angle, angle), 480.0), expected, ROUNDING);
            let beside = read(&*model, &upright(), &across(angle, -angle + 1e-9), 480.0);
            assert_near(beside, expected, 1e-7);
        }
    }
}

#[test]
fn a_lamella_without_width_scatters_evenly_and_a_width_of_zero_is_refused() {
    let geometry = across(20.0, 35.0);
    for model in models(&Stack::default()) {
        let even = read(&*model, &Structure { lamella_width: 1e-6, ..upright() }, &geometry, 480.0);
        for lamella_width in [1e-9, 1e-300, f64::MIN_POSITIVE, 5e-324] {
            let narrow = Structure { lamella_width, ..upright() };
            assert_near(read(&*model, &narrow, &geometry, 480.0), even, ROUNDING);
        }
        for lamella_width in [0.0, -0.0, -300.0] {
            let none = Structure { lamella_width, ..upright() };
            let found = model.reflectivity(&none, &geometry, Polarization::Unpolarized, 480.0);
            assert_out_of_range(found, "lamella_width");
        }
    }
}

#[test]
fn along_the_surface_both_ways_nothing_is_seen_though_all_lamellae_are_in_phase() {
    assert_near(array_factor(0.0, 9), 1.0, 0.0);
    for model in models(&Stack::default()) {
        for (theta, phi) in [(90.0, 90.0), (90.0, -90.0), (-90.0, 90.0), (-90.0, -90.0)] {
            assert_near(read(&*model, &upright(), &across(theta, phi), 480.0), 0.0, 1e-30);
        }
    }
}

#[test]
fn lamellae_without_a_period_add_up_to_the_peak() {
    for layers in [1, 9, 17, 3000] {
        for model in models(&of_layers(layers)) {
            for (d_air, d_cuticle) in [(0.0, 0.0), (1e-300, 0.0), (0.0, 5e-324)] {
                let structure = Structure { d_air, d_cuticle, ..upright() };
                assert_near(read(&*model, &structure, &across(0.0, 0.0), 480.0), 1.0, ROUNDING);
            }
        }
    }
}

#[test]
fn on_each_order_of_a_wavelength_grid_the_comb_is_at_its_peak() {
    for layers in [1, 2, 9, 16, 17, 30, 1000, 3000] {
        for model in models(&of_layers(layers)) {
            for period in [200.0, 235.0, 480.0, 1111.0] {
                for order in 1..=8 {
                    let structure = Structure { d_air: period, d_cuticle: 0.0, ..upright() };
                    let wavelength: f64 = 2.0 * period / f64::from(order);
                    // The neighbours as floating-point numbers are 0/0 in all but name.
                    for wavelength in [wavelength, wavelength.next_up(), wavelength.next_down()] {
                        assert_near(read(&*model, &structure, &across(0.0, 0.0), wavelength), 1.0, LOOSE);
                    }
                }
            }
        }
    }
}

#[test]
fn the_printed_comb_peaks_at_the_square_of_the_layers() {
    // I_A = a²/2 · M² · N on an order, at normal incidence.
    let model = PaperModel { lamella_unit: LamellaUnit::Printed { ridges: 50.0 }, ..PaperModel::default() };
    let found = read(&model, &upright(), &across(0.0, 0.0), 470.0);
    assert_near(found / (300.0 * 300.0 / 2.0 * 81.0 * 50.0), 1.0, ROUNDING);
}

#[test]
fn a_lamella_unit_that_is_no_number_is_refused() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0] {
        for lamella_unit in [LamellaUnit::Reference { width: value }, LamellaUnit::Printed { ridges: value }] {
            let model = PaperModel { lamella_unit, ..PaperModel::default() };
            let found = model.reflectivity(&upright(), &across(0.0, 0.0), Polarization::Unpolarized, 470.0);
            assert!(found.is_err(), "{lamella_unit:?}: {found:?}");
        }
    }
    // So small or large that the factor would be infinite.
    for lamella_unit in [LamellaUnit::Reference { width: 1e-300 }, LamellaUnit::Printed { ridges: f64::MAX }] {
        let model = PaperModel { lamella_unit, ..PaperModel::default() };
        let found = model.reflectivity(&upright(), &across(0.0, 0.0), Polarization::Unpolarized, 470.0);
        assert!(found.is_err(), "{lamella_unit:?}: {found:?}");
    }
}
