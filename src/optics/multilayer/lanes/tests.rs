//! The closed form in lanes against the scalar form and against differences.

use super::slopes::steepness_of_both;
use super::*;
use crate::optics::Stack;
use crate::optics::multilayer::{StackSlopes, THICKNESSES, periodic, spectra, unpolarized_spectra};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A random stack and the angle it is lit at, the edges of the domain among them: normal and grazing incidence, no
/// layer at all, no contrast.
fn drawn(case: usize, random: &mut Xoshiro256PlusPlus) -> (Media, Period, f64) {
    let angle = match case % 5 {
        0 => 0.0,
        1 => 89.9_f64.to_radians(),
        _ => random.random_range(0.0..1.55),
    };
    let mut thickness =
        || if random.random_bool(0.03) { *THICKNESSES.start() } else { random.random_range(0.0..400.0) };
    let period = Period { cuticle: thickness(), gap: thickness() };
    let mut media = Stack::default().media(500.0).unwrap();
    media.cuticle.re = if case.is_multiple_of(50) { 1.0 } else { random.random_range(1.0..2.6) };
    if case % 4 == 3 {
        media.ambient = random.random_range(1.0..1.6);
    }
    media.base.re = if case.is_multiple_of(2) { 1.0 } else { random.random_range(1.0..3.0) };
    (media, period, angle)
}

/// Thicknesses of whole half waves at `wavelength`: every sine of a phase is 0 there and the trace of a period is 2 or -2.
fn half_waves(media: &Media, angle: f64, wavelength: f64, orders: [u32; 2]) -> Option<Period> {
    let cosines = Incidence::refracted(media, angle)?.cosines;
    let [cuticle, gap] = [(media.cuticle.re * cosines.cuticle, orders[0]), (media.gap.re * cosines.gap, orders[1])]
        .map(|(along, order)| 0.5 * f64::from(order) * wavelength / along);
    Some(Period { cuticle, gap })
}

fn wavenumbers(count: u32) -> Vec<f64> {
    (0..count).map(|nm| std::f64::consts::TAU / (380.0 + f64::from(nm))).collect()
}

#[test]
fn a_million_random_values_are_those_of_the_scalar_form() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut worst, mut compared) = (0.0_f64, 0);
    let visible = wavenumbers(401);
    for case in 0..2700 {
        let layers = if case % 100 == 99 { 1000 } else { [1, 2, 3, 5, 9, 16, 17, 40][case % 8] };
        let (mut media, mut period, angle) = drawn(case, &mut random);
        // Far ultraviolet, radio waves; and a comb whose orders fall on the grid.
        let shorter = [20.0, 1e-3, 1.0, 1.0, 1.0, 1.0, 1.0][case % 7];
        let wavenumbers: Vec<f64> = visible.iter().map(|k| k * shorter).collect();
        if case % 11 == 7 && angle < 1.5 {
            let wavelength = std::f64::consts::TAU / wavenumbers[20];
            period = half_waves(&media, angle, wavelength, [1 + random.random_range(0..2), 1]).unwrap_or(period);
        }
        // From a dense medium past the critical angle no wave travels: that is the amplitudes' part.
        let Some(incidence) = Incidence::refracted(&media, angle) else { continue };
        compared += wavenumbers.len();
        let mut found = vec![SAndP::both(0.0); wavenumbers.len()];
        values(&[media], &[incidence], period, layers, Rules::Each, &wavenumbers, &mut found);
        let mut steep = vec![StackSlopes::default(); wavenumbers.len()];
        slopes(&[media], &[incidence], period, layers, Rules::Each, &wavenumbers, &mut steep);
        for ((&k, found), steep) in wavenumbers.iter().zip(&found).zip(&steep) {
            media.wavelength = std::f64::consts::TAU / k;
            let scalar = periodic::exact(&media, &incidence.cosines, period, layers);
            // Near grazing, resonances turn what rounding does to a thickness, 1e-12 nm, into more than 1e-11; where the
            // trace of a period is near 2, M periods turn its own rounding into M² times as much.
            let rounded = (layers * layers) as f64 * f64::EPSILON;
            let of = |part: fn(&SAndP) -> f64| {
                let off = (part(&scalar) - part(found)).abs();
                let allowed = 1e-11 + rounded + 1e-12 * (part(&steep.cuticle).abs() + part(&steep.gap).abs());
                assert!(off <= allowed, "{layers} layers, {} nm, {angle}: {scalar:?} {found:?}", media.wavelength);
                off
            };
            worst = worst.max(of(|both| both.s)).max(of(|both| both.p));
        }
    }
    assert!(worst > 0.0, "the two forms round differently");
    assert!(compared > 950_000, "{compared}");
}

/// Central differences of the values, of fourth order.
fn differences(value: impl Fn(f64) -> Vec<SAndP>, at: f64, step: f64) -> Vec<SAndP> {
    let [far_below, below, above, far_above] = [-2.0, -1.0, 1.0, 2.0].map(|steps| value(at + steps * step));
    let of = |i: usize, part: fn(&SAndP) -> f64| {
        (8.0 * (part(&above[i]) - part(&below[i])) - (part(&far_above[i]) - part(&far_below[i]))) / (12.0 * step)
    };
    (0..below.len()).map(|i| SAndP { s: of(i, |both| both.s), p: of(i, |both| both.p) }).collect()
}

#[test]
fn slopes_are_differences_of_the_values() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let wavenumbers = wavenumbers(21);
    for case in 0..400 {
        let layers = [1, 2, 3, 9, 16, 17][case % 6];
        let rules = if case.is_multiple_of(3) { Rules::Mean } else { Rules::Each };
        let (media, mut period, angle) = drawn(case, &mut random);
        (period.cuticle, period.gap) = (period.cuticle.max(1.0), period.gap.max(1.0));
        let angle = angle.min(1.4);
        // At the critical angle the slope by the angle is infinite.
        if media.ambient > 1.0 && media.ambient * angle.sin() > 0.95 {
            continue;
        }
        let at = |period: Period, angle: f64| {
            let mut out = vec![SAndP::default(); wavenumbers.len()];
            let incidence = Incidence::refracted(&media, angle).unwrap();
            values(&[media], &[incidence], period, layers, rules, &wavenumbers, &mut out);
            out
        };
        let mut found = vec![StackSlopes::default(); wavenumbers.len()];
        let incidence = Incidence::refracted(&media, angle).unwrap();
        slopes(&[media], &[incidence], period, layers, rules, &wavenumbers, &mut found);
        // Steps so small that a resonance is smooth within them.
        let steepest = |part: fn(&StackSlopes) -> &SAndP| {
            found.iter().map(|slopes| part(slopes).s.abs().max(part(slopes).p.abs())).fold(1.0, f64::max)
        };
        let step = 2e-3 / steepest(|slopes| &slopes.cuticle).max(steepest(|slopes| &slopes.gap));
        let cuticle = differences(|cuticle| at(Period { cuticle, ..period }, angle), period.cuticle, step);
        let gap = differences(|gap| at(Period { gap, ..period }, angle), period.gap, step);
        let turned = differences(|angle| at(period, angle), angle, 2e-4 / steepest(|slopes| &slopes.angle));
        for (i, found) in found.iter().enumerate() {
            for (name, found, expected, within) in [
                ("cuticle", found.cuticle, cuticle[i], 1e-6),
                ("gap", found.gap, gap[i], 1e-6),
                ("angle", found.angle, turned[i], 1e-5),
            ] {
                let off = (found.s - expected.s).abs().max((found.p - expected.p).abs());
                let size = 1.0 + expected.s.abs().max(expected.p.abs());
                assert!(off < within * size, "case {case}, by {name}: {found:?} {expected:?}");
            }
        }
    }
}

#[test]
fn indices_that_change_along_the_spectrum_give_each_wavelength_its_own() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(23);
    let wavenumbers = wavenumbers(75);
    for case in 0..200 {
        let layers = [1, 2, 9, 17][case % 4];
        let rules = if case.is_multiple_of(3) { Rules::Mean } else { Rules::Each };
        let (first, period, angle) = drawn(case, &mut random);
        let angle = angle.min(1.2);
        let dispersed = |place: usize| {
            let mut media = first;
            let by = 1e-3 * place as f64;
            media.cuticle.re += by;
            (media.gap.re, media.base.re) = (media.gap.re + 0.3 * by, media.base.re + 0.5 * by);
            media
        };
        let media: Vec<Media> = (0..wavenumbers.len()).map(dispersed).collect();
        let Some(incidences) = media.iter().map(|media| Incidence::refracted(media, angle)).collect::<Option<Vec<_>>>()
        else {
            continue;
        };
        let (mut found, mut steep) = ([SAndP::default(); 75], [StackSlopes::default(); 75]);
        values(&media, &incidences, period, layers, rules, &wavenumbers, &mut found);
        slopes(&media, &incidences, period, layers, rules, &wavenumbers, &mut steep);
        for (place, (media, incidence)) in media.iter().zip(&incidences).enumerate() {
            let (mut one, mut one_steep) = ([SAndP::default()], [StackSlopes::default()]);
            let k = &wavenumbers[place..=place];
            values(&[*media], &[*incidence], period, layers, rules, k, &mut one);
            slopes(&[*media], &[*incidence], period, layers, rules, k, &mut one_steep);
            let near = |a: SAndP, b: SAndP, within: f64| {
                let off = (a.s - b.s).abs().max((a.p - b.p).abs());
                assert!(off < within * (1.0 + b.s.abs().max(b.p.abs())), "case {case}, {place}: {a:?} {b:?}");
            };
            near(found[place], one[0], 1e-12);
            near(steep[place].cuticle, one_steep[0].cuticle, 1e-10);
            near(steep[place].gap, one_steep[0].gap, 1e-10);
            near(steep[place].angle, one_steep[0].angle, 1e-10);
        }
    }
}

#[test]
fn a_mirror_of_thousands_of_layers_has_no_slope_and_no_nan() {
    let media = Stack::default().media(500.0).unwrap();
    let incidence = Incidence::refracted(&media, 0.3).unwrap();
    let period = Period { cuticle: 90.0, gap: 120.0 };
    let wavenumbers = wavenumbers(401);
    let mut found = vec![StackSlopes::default(); 401];
    slopes(&[media], &[incidence], period, 100_000, Rules::Each, &wavenumbers, &mut found);
    assert!(found.iter().all(|slopes| [slopes.cuticle.s, slopes.gap.p, slopes.angle.s].iter().all(|x| x.is_finite())));
    assert!(found.iter().any(|slopes| slopes.cuticle == SAndP::both(0.0)));
}

#[test]
fn deep_in_the_gap_and_on_an_order_the_two_forms_agree() {
    let mut media = Stack::default().media(500.0).unwrap();
    // 583 nm is the middle of Table 1's band, where thousands of layers overflow; at 2 d/m the period has a whole phase.
    let period = Period { cuticle: 100.0, gap: 135.0 };
    let optical = period.gap + media.cuticle.re * period.cuticle;
    for layers in [9, 300, 1000, 3000, 100_000] {
        let lines: Vec<f64> = [583.0, 0.5 * optical, optical, 2.0 * optical / 3.0].to_vec();
        let wavenumbers: Vec<f64> = lines.iter().map(|line| std::f64::consts::TAU / line).collect();
        let incidence = Incidence::refracted(&media, 0.0).unwrap();
        let mut found = vec![SAndP::default(); lines.len()];
        values(&[media], &[incidence], period, layers, Rules::Each, &wavenumbers, &mut found);
        for (line, found) in lines.into_iter().zip(found) {
            media.wavelength = line;
            let scalar = periodic::exact(&media, &incidence.cosines, period, layers);
            let allowed = if line < 580.0 && layers > 1000 { 1e-8 } else { 1e-11 };
            assert!((scalar.s - found.s).abs() < allowed, "{layers} layers, {line} nm: {scalar:?} {found:?}");
            assert!(layers < 1000 || line < 580.0 || (found.s - 1.0).abs() < 1e-15, "{layers}: {found:?}");
        }
    }
}

/// The mean alone against that of both: at all angles, past grazing and past the critical angle, absorbing, too thick to compute,
/// and for spectra shorter than a block.
#[test]
fn unpolarized_spectra_are_the_mean_of_both() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(31);
    for case in 0..400 {
        let (mut media, period, angle) = drawn(case, &mut random);
        let layers = [1, 2, 9, 17, 3000][case % 5];
        if case % 7 == 3 {
            media.cuticle.im = 0.06;
        }
        let wavelengths: Vec<f64> = (0..1 + case % 45).map(|i| 400.0 + 7.0 * i as f64).collect();
        let angles = [angle, -angle, 1.6, std::f64::consts::FRAC_PI_2];
        let both = spectra(&media, &wavelengths, period, layers, &angles).unwrap();
        let mean = unpolarized_spectra(&media, &wavelengths, period, layers, &angles).unwrap();
        assert_eq!(both.len(), mean.len());
        for (both, mean) in both.iter().zip(&mean) {
            assert!((both.mean() - mean).abs() < 1e-15, "case {case}: {both:?} {mean}");
        }
        let Some(incidence) = Incidence::refracted(&media, angle).filter(|_| media.absorbing().is_none()) else {
            continue;
        };
        let rule = |rule| Fixed::new(&Admittances::each(&media, &incidence.cosines, rule));
        let row = [Row { y: [rule(Rule::S), rule(Rule::P)], paths: Paths::new(&media, &incidence, period) }];
        let wavenumbers: Vec<f64> = wavelengths.iter().map(|nm| std::f64::consts::TAU / nm).collect();
        let mut portable = vec![f64::NAN; wavelengths.len()];
        values_of_both::<false>(&row, &wavenumbers, layers, &mut portable);
        let rounded = (layers * layers) as f64 * f64::EPSILON;
        for (portable, mean) in portable.iter().zip(&mean) {
            assert!((portable - mean).abs() < 1e-10 + rounded, "case {case}: {portable} {mean}");
        }
    }
}

/// What a machine without vector instructions or fused multiply-add gets, beside what this one does.
#[test]
fn the_portable_form_gives_the_same() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let wavenumbers = wavenumbers(101);
    for case in 0..300 {
        let layers = [1, 2, 3, 9, 16, 17][case % 6];
        let (media, period, angle) = drawn(case, &mut random);
        let Some(incidence) = Incidence::refracted(&media, angle.min(1.5)) else { continue };
        let rule = |rule| {
            let y = Admittances::each(&media, &incidence.cosines, rule);
            (Fixed::new(&y), Fixed::slopes(&y, &incidence.admittance_slopes(&media, rule)))
        };
        let [s, p] = [rule(Rule::S), rule(Rule::P)];
        let paths = Paths::new(&media, &incidence, period);
        let (rows, steep_rows) = ([Row { y: [s.0, p.0], paths }], [Row { y: [s, p], paths }]);
        let (mut found, mut expected) = ([SAndP::default(); 101], [SAndP::default(); 101]);
        values(&[media], &[incidence], period, layers, Rules::Each, &wavenumbers, &mut found);
        values_of_both::<false>(&rows, &wavenumbers, layers, &mut expected);
        let (mut steep, mut expected_steep) = ([StackSlopes::default(); 101], [StackSlopes::default(); 101]);
        slopes(&[media], &[incidence], period, layers, Rules::Each, &wavenumbers, &mut steep);
        steepness_of_both::<false>(&steep_rows, &wavenumbers, layers, &mut expected_steep);
        for i in 0..101 {
            let (found, expected) = (found[i], expected[i]);
            assert!((found.s - expected.s).abs().max((found.p - expected.p).abs()) < 1e-11, "{found:?} {expected:?}");
            let parts = |slopes: &StackSlopes| {
                [slopes.cuticle.s, slopes.cuticle.p, slopes.gap.s, slopes.gap.p, slopes.angle.s, slopes.angle.p]
            };
            for (found, expected) in parts(&steep[i]).into_iter().zip(parts(&expected_steep[i])) {
                assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "case {case}: {found} {expected}");
            }
        }
    }
}
