//! The optics against numbers from other programs, and its own methods against each other.

mod support;

use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::multilayer::{self, Period, SAndP};
use morpho_fit::optics::{
    Admittance, BlendModel, LAMELLA, Material, OpticsError, PaperModel, ReflectivityModel, Snell, Stack, Structure,
};
use morpho_fit::units::radians;
use nalgebra::Complex;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use support::stacks::{self, BOTH, PeriodicStack, real};

/// Absolute. The tables hold 16 or 17 digits; rounding of the 60 layers of the thickest stack stays below this.
const EXACT: f64 = 1e-12;

/// Absolute. The golden numbers are printed with 12 decimals; half a unit of the last one is 5e-13.
const PRINTED: f64 = 1e-11;

fn assert_near(found: f64, expected: f64, tolerance: f64, what: &dyn std::fmt::Debug) {
    let difference = (found - expected).abs();
    assert!(difference <= tolerance, "{found:.17} is not {expected:.17}, off by {difference:e}: {what:?}");
}

fn assert_both_near(found: SAndP, expected: SAndP, tolerance: f64, what: &dyn std::fmt::Debug) {
    assert_near(found.s, expected.s, tolerance, what);
    assert_near(found.p, expected.p, tolerance, what);
}

/// R of the library's own choice of method.
fn reflectivity(stack: &PeriodicStack) -> SAndP {
    multilayer::reflectivity(&stack.media(), stack.period, stack.layers, stack.theta).expect("valid")
}

/// What the model reads off the untilted `stack` in its mirror direction, along the ridges.
fn reading(model: &dyn ReflectivityModel, stack: &PeriodicStack, polarization: Polarization) -> f64 {
    let structure =
        Structure { d_air: stack.period.gap, d_cuticle: stack.period.cuticle, delta: 0.0, ..Structure::table1() };
    let geometry = Geometry { theta: stack.theta, phi: -stack.theta, omega: radians(90.0) };
    model.reflectivity(&structure, &geometry, polarization, stack.wavelength).expect("valid")
}

fn paper(stack: Stack, admittance: Admittance) -> PaperModel {
    PaperModel { stack, admittance, ..PaperModel::default() }
}

#[test]
fn w1_checks_of_40_digits_hold_for_each_polarization() {
    let checks = stacks::w1();
    assert_eq!(checks.len(), 24);
    for check in checks {
        assert_both_near(reflectivity(&check), check.expected, EXACT, &check);
        assert_both_near(check.by_amplitudes(), check.expected, EXACT, &check);
        assert_both_near(check.by_intensities_per_polarization(), check.expected, EXACT, &check);
    }
}

#[test]
fn w1_checks_of_40_digits_hold_through_the_models() {
    for check in stacks::w1() {
        let blend = BlendModel { stack: check.stack() };
        let paper = paper(check.stack(), Admittance::PerPolarization);
        let models: [&dyn ReflectivityModel; 2] = [&blend, &paper];
        for model in models {
            assert_near(reading(model, &check, Polarization::S), check.expected.s, EXACT, &check);
            assert_near(reading(model, &check, Polarization::P), check.expected.p, EXACT, &check);
            assert_near(reading(model, &check, Polarization::Unpolarized), check.expected_unpolarized, EXACT, &check);
        }
    }
}

#[test]
fn w1_checks_of_40_digits_hold_with_the_mean_admittance() {
    for check in stacks::w1() {
        let model = paper(check.stack(), Admittance::Mean);
        let expected = check.expected_mean_admittance;
        assert_near(reading(&model, &check, Polarization::Unpolarized), expected, EXACT, &check);
        assert_near(check.by_intensities(|n, cos| 0.5 * (n * cos + n / cos)), expected, EXACT, &check);
    }
}

/// Angle in degrees, wavelength, `R_s`, `R_p` of air | 9 × 100 nm of 1.56 with 135 nm of air between | air. Two
/// transfer-matrix programs, one of them `tmm` 0.2.0, agree on them to 4e-15.
const LOSSLESS: [(f64, f64, f64, f64); 7] = [
    (0.0, 470.0, 0.187407639523, 0.187407639523),
    (0.0, 480.0, 0.409538957612, 0.409538957612),
    (0.0, 583.0, 0.998597010770, 0.998597010770),
    (30.0, 529.0, 0.999689140258, 0.992574392774),
    (45.0, 480.0, 0.999965659385, 0.895602728599),
    (60.0, 400.0, 0.999999112167, 0.216660710399),
    (75.0, 500.0, 0.999155967935, 0.002640378105),
];

/// The same two programs for cuticle of 1.56 + 0.06i: angle in degrees, wavelength, R of s and p.
const ABSORBING: [(f64, f64, f64, f64); 3] = [
    (0.0, 480.0, 0.194926989223, 0.194926989223),
    (0.0, 554.0, 0.773691501162, 0.773691501162),
    (45.0, 480.0, 0.779624181976, 0.394245701619),
];

/// And what passes: wavelength and T at normal incidence.
const TRANSMITTED: [(f64, f64); 2] = [(480.0, 0.182849791601), (554.0, 0.001522073462)];

fn table1_layers(cuticle: Complex<f64>) -> Vec<Layer> {
    let mut layers =
        [Layer { index: cuticle, thickness: 100.0 }, Layer { index: real(1.0), thickness: 135.0 }].repeat(9);
    layers.pop();
    layers
}

#[test]
fn golden_numbers_without_absorption_hold_in_every_method() {
    for golden @ (angle, wavelength, s, p) in LOSSLESS {
        let expected = SAndP { s, p };
        let stack = Stack::default();
        let media = stack.media(wavelength).expect("valid");
        let period = Period { cuticle: 100.0, gap: 135.0 };
        let found = multilayer::reflectivity(&media, period, 9, radians(angle)).expect("valid");
        assert_both_near(found, expected, PRINTED, &golden);
        for (component, expected) in BOTH.into_iter().zip([s, p]) {
            let layers = table1_layers(real(1.56));
            let found = reflect_transmit(1.0, &layers, real(1.0), wavelength, radians(angle), component);
            let found = found.expect("valid");
            assert_near(found.reflectivity, expected, PRINTED, &golden);
            assert_near(found.transmittance, 1.0 - expected, PRINTED, &golden);
        }
    }
}

#[test]
fn golden_numbers_with_absorption_hold_layer_by_layer_and_in_the_model() {
    let cuticle = Complex::new(1.56, 0.06);
    let stack = Stack { cuticle: Material::Constant { n: 1.56, k: 0.06 }, ..Stack::default() };
    let model = BlendModel { stack };
    let structure = Structure { delta: 0.0, ..Structure::table1() };
    for golden @ (angle, wavelength, s, p) in ABSORBING {
        let theta = radians(angle);
        let geometry = Geometry { theta, phi: -theta, omega: radians(90.0) };
        for (component, polarization, expected) in
            [(Component::S, Polarization::S, s), (Component::P, Polarization::P, p)]
        {
            let layers = table1_layers(cuticle);
            let found = reflect_transmit(1.0, &layers, real(1.0), wavelength, theta, component).expect("valid");
            assert_near(found.reflectivity, expected, PRINTED, &golden);
            let read = model.reflectivity(&structure, &geometry, polarization, wavelength).expect("valid");
            assert_near(read, expected, PRINTED, &golden);
        }
    }
    for golden @ (wavelength, expected) in TRANSMITTED {
        for component in BOTH {
            let layers = table1_layers(cuticle);
            let found = reflect_transmit(1.0, &layers, real(1.0), wavelength, 0.0, component).expect("valid");
            assert_near(found.transmittance, expected, PRINTED, &golden);
        }
    }
}

/// `tmm` 0.2.0 itself is within 3e-14 of 60 digits on these rows.
#[test]
fn any_list_of_layers_reflects_and_transmits_as_in_tmm() {
    let rows = stacks::general();
    assert_eq!(rows.len(), 330);
    for row in rows {
        let found = reflect_transmit(row.ambient, &row.layers, row.base, row.wavelength, row.theta, row.component);
        let found = found.expect("valid");
        assert_near(found.reflectivity, row.expected.reflectivity, EXACT, &row);
        assert_near(found.transmittance, row.expected.transmittance, EXACT, &row);
    }
}

/// Here the last gap is left out before the base, which the library's stack has: the two are one where the base is
/// the medium of the gaps. The others are held to the table layer by layer.
#[test]
fn periodic_stacks_of_60_digits_hold_in_every_method() {
    let rows = stacks::periodic();
    assert_eq!(rows.len(), 200);
    assert!(rows.iter().filter(|row| row.is_ours()).count() >= 50);
    for row in rows {
        assert_both_near(row.by_amplitudes(), row.expected, EXACT, &row);
        assert_both_near(row.by_intensities_per_polarization(), row.expected, EXACT, &row);
        if row.is_ours() {
            assert_both_near(reflectivity(&row), row.expected, EXACT, &row);
        }
    }
}

#[test]
fn mean_admittance_of_60_digits_holds_in_the_recurrence_and_in_the_paper_model() {
    let rows = stacks::mean_admittance();
    assert_eq!(rows.len(), 200);
    for row in rows {
        let expected = row.expected_mean_admittance;
        assert_near(row.by_intensities(|n, cos| 0.5 * (n * cos + n / cos)), expected, EXACT, &row);
        assert_both_near(row.by_amplitudes(), row.expected, EXACT, &row);
        if row.is_ours() {
            let model = paper(row.stack(), Admittance::Mean);
            assert_near(reading(&model, &row, Polarization::Unpolarized), expected, EXACT, &row);
        }
    }
}

/// Absolute. The array factor's phase is near 1e3 in the thickest rows, where a double keeps 1e-13 of it.
const LAMELLA_ROUNDING: f64 = 1e-12;

#[test]
fn lamellae_of_60_digits_hold_in_both_models_also_at_every_singular_point() {
    let rows = stacks::lamellae();
    assert_eq!(rows.len(), 200);
    for row in rows {
        let stack = Stack { layers: row.layers, ..Stack::default() };
        let (blend, paper) = (BlendModel { stack: stack.clone() }, paper(stack, Admittance::Mean));
        let models: [&dyn ReflectivityModel; 2] = [&blend, &paper];
        // Model A knows the sum of the two thicknesses only.
        let structure =
            Structure { d_air: row.period, d_cuticle: 0.0, lamella_width: row.width, ..Structure::table1() };
        let geometry = Geometry { theta: row.theta, phi: row.phi, omega: 0.0 };
        for model in models {
            let terms = model.contributions(&structure, &geometry, Polarization::Unpolarized, row.wavelength);
            let terms = terms.expect("valid");
            assert_eq!(terms[0].name, LAMELLA);
            assert_near(terms[0].intensity, row.expected, LAMELLA_ROUNDING, &row);
            assert_near(terms[1].intensity, 0.0, 0.0, &row);
        }
    }
}

/// 1 to 30 layers, seen from air at 0 to 89°, no wave evanescent.
fn random_lossless(source: &mut Xoshiro256PlusPlus) -> PeriodicStack {
    PeriodicStack {
        wavelength: source.random_range(300.0..1000.0),
        theta: radians(source.random_range(0.0..89.0)),
        period: Period { cuticle: source.random_range(20.0..300.0), gap: source.random_range(20.0..300.0) },
        n_cuticle: source.random_range(1.3..2.2),
        n_gap: source.random_range(1.0..1.4),
        n_base: [1.0, 1.333, 1.52, 1.56, 3.5][source.random_range(0..5)],
        layers: source.random_range(1..=30),
        last_gap: true,
        expected: SAndP::default(),
        expected_unpolarized: f64::NAN,
        expected_mean_admittance: f64::NAN,
    }
}

#[test]
fn three_methods_agree_on_20000_random_lossless_stacks() {
    let mut source = Xoshiro256PlusPlus::seed_from_u64(20_260_101);
    for _ in 0..20_000 {
        let stack = random_lossless(&mut source);
        let closed = reflectivity(&stack);
        assert_both_near(stack.by_amplitudes(), closed, EXACT, &stack);
        assert_both_near(stack.by_intensities_per_polarization(), closed, EXACT, &stack);
    }
}

#[test]
fn mean_admittance_recurrence_is_the_closed_form_on_20000_random_lossless_stacks() {
    let mut source = Xoshiro256PlusPlus::seed_from_u64(20_260_102);
    for _ in 0..20_000 {
        let stack = random_lossless(&mut source);
        let model = paper(stack.stack(), Admittance::Mean);
        let recurrence = stack.by_intensities(|n, cos| 0.5 * (n * cos + n / cos));
        let closed = reading(&model, &stack, Polarization::Unpolarized);
        assert_near(recurrence, closed, EXACT, &stack);
    }
}

/// Wavelength, angle in degrees, `R_s` of Table 1's stack on cuticle in 40 digits, from the characteristic matrix in
/// `mpmath` 1.4.1: the two places where the printed sums round most, by 2.6e-11 and 2.2e-11, on a grid of 1 nm and half a degree.
const WORST_OF_THE_RECURRENCE: [(f64, f64, f64); 2] =
    [(653.0, 86.5, 0.815_561_140_540_900_8), (696.0, 89.0, 0.943_358_528_380_186_8)];

/// Table 1's stack with its last gap, on cuticle.
fn table1_on_cuticle(wavelength: f64, angle: f64) -> PeriodicStack {
    PeriodicStack {
        wavelength,
        theta: radians(angle),
        period: Period { cuticle: 100.0, gap: 135.0 },
        n_cuticle: 1.56,
        n_gap: 1.0,
        n_base: 1.56,
        layers: 9,
        last_gap: true,
        expected: SAndP::default(),
        expected_unpolarized: f64::NAN,
        expected_mean_admittance: f64::NAN,
    }
}

#[test]
fn near_grazing_the_recurrence_keeps_its_digits_where_the_printed_sums_lose_half() {
    for (wavelength, angle, expected) in WORST_OF_THE_RECURRENCE {
        let stack = table1_on_cuticle(wavelength, angle);
        assert_near(reflectivity(&stack).s, expected, EXACT, &"closed form");
        assert_near(stack.by_amplitudes().s, expected, EXACT, &"amplitudes");
        assert_near(stack.by_intensities_per_polarization().s, expected, EXACT, &"intensities");
    }
    for wavelength in (380..=740).map(f64::from) {
        for angle in [85.0, 88.0, 88.5, 89.0] {
            let stack = table1_on_cuticle(wavelength, angle);
            let closed = reflectivity(&stack);
            assert_both_near(stack.by_amplitudes(), closed, EXACT, &stack);
            assert_both_near(stack.by_intensities_per_polarization(), closed, EXACT, &stack);
        }
    }
}

/// R of Table 1's stack, unpolarized, in the model.
fn table1_reflectivity(model: &PaperModel, angle: f64, wavelength: f64) -> Result<f64, OpticsError> {
    let media = model.stack.media(wavelength)?;
    Ok(model.stack_reflectivity(&media, Period { cuticle: 100.0, gap: 135.0 }, angle)?.mean())
}

/// The wavelength of the largest value on a grid of 0.1 nm.
fn peak(first: u32, last: u32, value: impl Fn(f64) -> f64) -> f64 {
    let grid = (10 * first..=10 * last).map(|tenths| f64::from(tenths) / 10.0);
    grid.max_by(|a, b| value(*a).total_cmp(&value(*b))).expect("a grid")
}

#[test]
fn snell_as_printed_has_no_solution_beyond_39_87_degrees() {
    let printed = PaperModel { snell: Snell::Printed, ..PaperModel::default() };
    for angle in [0.0_f64, 20.0, 39.86] {
        for sign in [-1.0, 1.0] {
            let found = table1_reflectivity(&printed, radians(sign * angle), 480.0).expect("a refracted ray");
            assert!((0.0..=1.0).contains(&found), "{angle}: {found}");
        }
    }
    for angle in [39.87, 45.0, 89.0] {
        for sign in [-1.0, 1.0] {
            let found = table1_reflectivity(&printed, radians(sign * angle), 480.0);
            assert!(matches!(found, Err(OpticsError::NoRefractedRay { .. })), "{angle}: {found:?}");
            assert!(table1_reflectivity(&PaperModel::default(), radians(sign * angle), 480.0).is_ok());
        }
    }
}

/// The two wavelengths are from independent code.
#[test]
fn snell_as_printed_moves_the_peak_at_30_degrees_from_531_to_429_nm() {
    let printed = PaperModel { snell: Snell::Printed, ..PaperModel::default() };
    let of = |model: &PaperModel| {
        peak(380, 740, |wavelength| table1_reflectivity(model, radians(30.0), wavelength).expect("valid"))
    };
    assert_near(of(&printed), 429.0, 1.0, &"printed");
    let right = PaperModel { admittance: Admittance::PerPolarization, ..PaperModel::default() };
    assert_near(of(&right), 531.0, 1.0, &"right");
}

/// Where the mean admittances of air and cuticle meet, from independent code: index and angle in degrees.
const FALSE_ZEROS: [(f64, f64); 4] = [(1.40, 66.55), (1.50, 68.44), (1.56, 69.44), (1.70, 71.43)];

#[test]
fn mean_admittance_has_a_false_zero_at_every_wavelength() {
    for (n, angle) in FALSE_ZEROS {
        let stack = Stack { cuticle: Material::constant(n), ..Stack::default() };
        let (mean, exact) = (paper(stack.clone(), Admittance::Mean), paper(stack, Admittance::PerPolarization));
        for wavelength in (380..=740).map(f64::from) {
            let false_value = table1_reflectivity(&mean, radians(angle), wavelength).expect("valid");
            assert!(false_value < 1e-4, "n {n}, {wavelength} nm: {false_value}");
        }
        let true_values = (380..=740)
            .map(|wavelength| table1_reflectivity(&exact, radians(angle), f64::from(wavelength)).expect("valid"));
        let mean_of_true = true_values.sum::<f64>() / 361.0;
        assert!(mean_of_true > 0.2, "n {n}: {mean_of_true}");
    }
}

/// One thin film has no zero but the one of its admittance, so the least R shows the angle.
#[test]
fn mean_admittance_vanishes_at_the_angle_known_to_a_hundredth_of_a_degree() {
    for (n, angle) in FALSE_ZEROS {
        let stack = Stack { cuticle: Material::constant(n), layers: 1, ..Stack::default() };
        let model = paper(stack, Admittance::Mean);
        let media = model.stack.media(500.0).expect("valid");
        let at = |angle: f64| {
            let period = Period { cuticle: 40.0, gap: 0.0 };
            model.stack_reflectivity(&media, period, radians(angle)).expect("valid").s
        };
        let angles = (-500..=500).map(|step| angle + f64::from(step) / 1000.0);
        let zero = angles.min_by(|a, b| at(*a).total_cmp(&at(*b))).expect("angles");
        assert_near(zero, angle, 0.006, &n);
    }
}

/// Peaks at normal incidence from independent code, to 1 nm, for a period of 235 nm.
#[test]
fn peaks_at_normal_incidence_follow_the_optical_path() {
    for (d_air, wavelength) in [
        (35.0, 718.0),
        (60.0, 683.0),
        (85.0, 649.0),
        (110.0, 615.0),
        (135.0, 583.0),
        (160.0, 553.0),
        (185.0, 527.0),
        (200.0, 511.0),
    ] {
        let period = Period { cuticle: 235.0 - d_air, gap: d_air };
        let found = peak(380, 780, |wavelength| {
            let media = Stack::default().media(wavelength).expect("valid");
            multilayer::reflectivity(&media, period, 9, 0.0).expect("valid").mean()
        });
        assert_near(found, wavelength, 1.0, &d_air);
    }
}
