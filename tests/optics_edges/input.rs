//! Input that is no question.

use crate::support::stacks::real;
use crate::{NO_NUMBERS, ROUNDING, TABLE1, across, along, assert_out_of_range, in_each_plane, models, upright};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::multilayer;
use morpho_fit::optics::multilayer::Period;
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::multilayer::intensity::recurrence;
use morpho_fit::optics::{MAX_LAYERS, Material, Media, OpticsError, Stack, Structure};
use nalgebra::Complex;
use std::f64::consts::FRAC_PI_2;

#[test]
fn a_wavelength_that_is_not_above_zero_is_refused() {
    in_each_plane(|read| {
        for wavelength in [0.0, -0.0, -480.0].into_iter().chain(NO_NUMBERS) {
            assert_out_of_range(read(&upright(), wavelength), "wavelength");
        }
    });
    for wavelength in [0.0, -480.0].into_iter().chain(NO_NUMBERS) {
        assert_out_of_range(reflect_transmit(1.0, &[], real(1.5), wavelength, 0.0, Component::S), "wavelength");
        assert_out_of_range(Material::constant(1.5).index("cuticle", wavelength), "wavelength");
    }
}

#[test]
fn a_structure_out_of_its_range_is_refused_by_name() {
    in_each_plane(|read| {
        for bad in [-1.0, -5e-324].into_iter().chain(NO_NUMBERS) {
            assert_out_of_range(read(&Structure { d_air: bad, ..upright() }, 480.0), "d_air");
            assert_out_of_range(read(&Structure { d_cuticle: bad, ..upright() }, 480.0), "d_cuticle");
        }
        for bad in [0.0, -1.0].into_iter().chain(NO_NUMBERS) {
            assert_out_of_range(read(&Structure { lamella_width: bad, ..upright() }, 480.0), "lamella_width");
            assert_out_of_range(read(&Structure { phi_alpha: bad, ..upright() }, 480.0), "phi_alpha");
        }
        for bad in [FRAC_PI_2, -FRAC_PI_2].into_iter().chain(NO_NUMBERS) {
            assert_out_of_range(read(&Structure { delta: bad, ..upright() }, 480.0), "delta");
        }
    });
}

#[test]
fn degrees_in_the_place_of_radians_are_refused() {
    in_each_plane(|read| assert_out_of_range(read(&Structure { delta: 2.5, ..upright() }, 480.0), "delta"));
    for model in models(&Stack::default()) {
        for bad in [30.0, -30.0, 1.6].into_iter().chain(NO_NUMBERS) {
            let good = across(10.0, -8.0);
            for (name, geometry) in [
                ("theta", Geometry { theta: bad, ..good }),
                ("phi", Geometry { phi: bad, ..good }),
                ("omega", Geometry { omega: bad, ..good }),
            ] {
                assert_out_of_range(model.reflectivity(&upright(), &geometry, Polarization::S, 480.0), name);
            }
        }
    }
}

#[test]
fn a_stack_that_is_none_is_refused() {
    let bad_index = |n, k| Material::Constant { n, k };
    let good = Stack::default();
    let media = good.media(480.0).expect("media");
    for layers in [0, MAX_LAYERS + 1] {
        assert_out_of_range(Stack { layers, ..good.clone() }.media(480.0), "layers");
    }
    assert_out_of_range(multilayer::reflectivity(&media, TABLE1, 0, 0.0), "layers");
    for (n, k) in [(0.0, 0.0), (-1.5, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0), (1.5, -0.1), (1.5, f64::NAN)] {
        assert_out_of_range(Stack { cuticle: bad_index(n, k), ..good.clone() }.media(480.0), "cuticle");
        assert_out_of_range(Stack { gap: bad_index(n, k), ..good.clone() }.media(480.0), "gap");
        assert_out_of_range(Stack { base: bad_index(n, k), ..good.clone() }.media(480.0), "base");
        assert_out_of_range(Stack { ambient: bad_index(n, k), ..good.clone() }.media(480.0), "ambient");
        let found = reflect_transmit(1.0, &[], Complex::new(n, k), 480.0, 0.0, Component::S);
        assert!(matches!(found, Err(OpticsError::OutOfRange { .. })), "{n} {k}: {found:?}");
    }
    let absorbing = Stack { ambient: bad_index(1.0, 1e-9), ..good };
    assert_out_of_range(absorbing.media(480.0), "extinction coefficient of the ambient");
}

#[test]
fn media_that_are_no_numbers_are_refused() {
    let good = Stack::default().media(480.0).expect("media");
    for bad in [0.0, -1.0].into_iter().chain(NO_NUMBERS) {
        for media in [
            Media { wavelength: bad, ..good },
            Media { ambient: bad, ..good },
            Media { cuticle: real(bad), ..good },
            Media { gap: real(bad), ..good },
            Media { base: real(bad), ..good },
        ] {
            let found = multilayer::reflectivity(&media, TABLE1, 9, 0.3);
            assert!(matches!(found, Err(OpticsError::OutOfRange { .. })), "{media:?}: {found:?}");
        }
    }
}

#[test]
fn thicknesses_and_angles_out_of_range_are_refused_without_a_model() {
    let media = Stack::default().media(480.0).expect("media");
    for bad in [-1.0].into_iter().chain(NO_NUMBERS) {
        assert_out_of_range(multilayer::reflectivity(&media, Period { cuticle: bad, gap: 1.0 }, 9, 0.0), "d_cuticle");
        assert_out_of_range(multilayer::reflectivity(&media, Period { cuticle: 1.0, gap: bad }, 9, 0.0), "d_air");
        let layer = [Layer { index: real(1.5), thickness: bad }];
        assert_out_of_range(reflect_transmit(1.0, &layer, real(1.0), 480.0, 0.0, Component::P), "thickness");
    }
    for bad in NO_NUMBERS {
        assert_out_of_range(multilayer::reflectivity(&media, TABLE1, 9, bad), "angle");
        assert_out_of_range(reflect_transmit(1.0, &[], real(1.0), 480.0, bad, Component::P), "angle");
        assert_out_of_range(recurrence(&[1.0, 1.5, 1.0], &[bad]), "phase");
    }
    for bad in [0.0, -1.0].into_iter().chain(NO_NUMBERS) {
        assert_out_of_range(recurrence(&[1.0, bad, 1.0], &[1.0]), "admittance");
        assert_out_of_range(reflect_transmit(bad, &[], real(1.0), 480.0, 0.0, Component::P), "index of the ambient");
    }
    for (admittances, phases) in [(&[][..], &[][..]), (&[1.0], &[]), (&[1.0, 1.5, 1.0], &[]), (&[1.0, 1.5], &[1.0])] {
        assert_out_of_range(recurrence(admittances, phases), "number of admittances");
    }
}

#[test]
fn a_wavelength_written_in_micrometres_or_metres_is_refused() {
    in_each_plane(|read| {
        for wavelength in [0.48, 4.8e-7] {
            assert_out_of_range(read(&upright(), wavelength), "wavelength");
        }
    });
}

#[test]
fn a_length_in_the_wrong_unit_never_gives_more_than_all_the_light() {
    let (metre, micrometre) = (1e9, 1e-3);
    for model in models(&Stack::default()) {
        for geometry in [across(10.0, -8.0), along(10.0, -8.0)] {
            // A wavelength of 480 nm written in m and in µm; a structure written in fm, pm, µm and m.
            let wavelengths = [480.0 / metre, 480.0 * micrometre, 480.0, 480.0 * metre];
            for wavelength in wavelengths {
                for unit in [1.0 / metre, micrometre, 1.0, 1e3, 1e6, metre] {
                    let Structure { d_air, d_cuticle, lamella_width, .. } = upright();
                    let structure = Structure {
                        d_air: d_air * unit,
                        d_cuticle: d_cuticle * unit,
                        lamella_width: lamella_width * unit,
                        ..upright()
                    };
                    let found = model.reflectivity(&structure, &geometry, Polarization::Unpolarized, wavelength);
                    let holds = found.as_ref().map_or(true, |value| (0.0..=1.0 + ROUNDING).contains(value));
                    assert!(holds, "{wavelength} nm, {structure:?}: {found:?}");
                }
            }
        }
    }
}
