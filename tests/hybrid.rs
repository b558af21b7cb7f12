//! The `hybrid` model: reciprocity, energy, limits; and what it tells of data that `blend` cannot.

use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::inversion::{FitSettings, ModelChoice, Nuisances, Parts, SettingsError, Status, Weight, fit};
use morpho_fit::optics::{BlendModel, HybridModel, Material, OpticsError, ReflectivityModel, Stack, Structure};
use morpho_fit::synthetic::{Scan, simulate};
use morpho_fit::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{FRAC_PI_2, PI};

const EACH: [Polarization; 3] = [Polarization::Unpolarized, Polarization::S, Polarization::P];
const SPACING: f64 = HybridModel::RIDGE_SPACING;

fn direction(theta: f64, azimuth: f64) -> [f64; 3] {
    [theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos()]
}

/// A smooth dense surface, which reflects at every angle.
fn mirror() -> HybridModel {
    let stack = Stack { cuticle: Material::constant(1.0), base: Material::constant(50.0), ..Stack::default() };
    HybridModel { stack, ..HybridModel::default() }
}

/// f without its stack: as if R were 1.
fn white(model: &HybridModel, of: &Structure, incoming: [f64; 3], outgoing: [f64; 3], wavelength: f64) -> f64 {
    let f = model.brdf(of, incoming, outgoing, Polarization::S, wavelength).unwrap();
    if f <= 0.0 {
        return 0.0;
    }
    let angle = (0.5 * (incoming[2] + outgoing[2])).min(1.0).acos();
    let media = model.stack.media(wavelength).unwrap();
    let period = morpho_fit::optics::multilayer::Period { cuticle: of.d_cuticle, gap: of.d_air };
    f / model.stack_reflectivity(&media, period, angle).unwrap().s
}

/// Middles of `steps` slices of `[low, high]`, and the width of one.
fn middles(low: f64, high: f64, steps: u32) -> (impl Iterator<Item = f64>, f64) {
    let step = (high - low) / f64::from(steps);
    ((0..steps).map(move |slice| low + (f64::from(slice) + 0.5) * step), step)
}

/// `∫ f cos_o dΩ` of a white stack, as `∫∫ f dx dy` over the unit disk: rows of `y` over the support of P, which for layers
/// without tilt is `|y + y_i| < 2 sin(phi_alpha / 2)`, and `x = sqrt(1 - y²) sin(t)`.
fn albedo(model: &HybridModel, of: &Structure, incoming: [f64; 3], wavelength: f64, rows: u32, steps: u32) -> f64 {
    let half_width = if of.delta == 0.0 { 2.0 * (0.5 * of.phi_alpha).sin() } else { 2.0 };
    let (low, high) = ((-incoming[1] - half_width).max(-1.0), (-incoming[1] + half_width).min(1.0));
    let (rows, height) = middles(low, high, rows);
    rows.map(|y| {
        let reach = (1.0 - y * y).max(0.0).sqrt();
        let (columns, width) = middles(-FRAC_PI_2, FRAC_PI_2, steps);
        let row = columns.map(|t| {
            let outgoing = [reach * t.sin(), y, reach * t.cos()];
            white(model, of, incoming, outgoing, wavelength) * reach * t.cos() * width
        });
        row.sum::<f64>() * height
    })
    .sum()
}

#[test]
fn exchanging_source_and_detector_changes_nothing() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut bright = 0;
    for _ in 0..20_000 {
        let structure = Structure {
            d_air: random.random_range(20.0..300.0),
            d_cuticle: random.random_range(20.0..300.0),
            delta: random.random_range(-1.57..1.57),
            phi_alpha: random.random_range(0.1..PI),
            lamella_width: random.random_range(50.0..SPACING),
        };
        let mut any = || direction(random.random_range(0.0..FRAC_PI_2), random.random_range(0.0..2.0 * PI));
        let (one, other) = (any(), any());
        let model = HybridModel::default();
        let wavelength = random.random_range(380.0..740.0);
        let [mean, s, p] = EACH.map(|polarization| {
            let there = model.brdf(&structure, one, other, polarization, wavelength).unwrap();
            let back = model.brdf(&structure, other, one, polarization, wavelength).unwrap();
            assert!((there - back).abs() <= 1e-12 * there.abs().max(1.0), "{structure:?} {one:?} {other:?}");
            there
        });
        assert!((mean - 0.5 * (s + p)).abs() <= 1e-12 * mean.max(1.0));
        bright += u32::from(mean > 1e-6);
    }
    assert!(bright > 5000, "{bright}");
}

/// Albedos of a narrow lobe by an independent program.
#[test]
fn the_albedo_of_a_white_stack_is_the_golden_one() {
    let structure = Structure { delta: 0.0, phi_alpha: 1e-3, lamella_width: 300.0, ..Structure::blue() };
    for (theta, azimuth, golden) in
        [(0.0, 0.0, 0.3547), (40.0, 0.0, 0.2798), (40.0, 90.0, 0.3224), (75.0, 0.0, 0.2516), (75.0, 90.0, 0.1392)]
    {
        let incoming = direction(radians(theta), radians(azimuth));
        let found = albedo(&mirror(), &structure, incoming, 470.0, 64, 2000);
        assert!((found - golden).abs() < 0.002, "{theta}, {azimuth}: {found} is not {golden}");
    }
}

/// Up to the horizon, where the slit alone would give back `1/cos_i`.
#[test]
fn a_narrow_lobe_reflects_no_more_than_the_lamellae_fill() {
    let mut largest = 0.0_f64;
    for width in [20.0, 60.0, 150.0, 240.0, 300.0, 450.0, SPACING] {
        let structure = Structure { delta: 0.0, phi_alpha: 1e-3, lamella_width: width, ..Structure::blue() };
        for wavelength in [380.0, 470.0, 740.0] {
            for theta in [0.0, 20.0, 40.0, 60.0, 70.0, 80.0, 82.0, 83.0, 84.0, 86.0, 88.0, 89.0, 89.9, 89.999] {
                for azimuth in [0.0, 30.0, 60.0, 90.0] {
                    let incoming = direction(radians(theta), radians(azimuth));
                    let found = albedo(&mirror(), &structure, incoming, wavelength, 16, 400) * SPACING / width;
                    assert!(found <= 1.0, "{width} nm, {wavelength} nm, {theta}, {azimuth}: {found}");
                    largest = largest.max(found);
                }
            }
        }
    }
    assert!(largest > 0.9, "{largest}");
}

/// Of a white stack as a share of what the lamellae fill, at `theta` degrees and `azimuth` degrees.
fn filled(model: &HybridModel, of: &Structure, [theta, azimuth]: [f64; 2], wavelength: f64, rows: u32) -> f64 {
    let incoming = direction(radians(theta), radians(azimuth));
    albedo(model, of, incoming, wavelength, rows, 300) * model.ridge_spacing / of.lamella_width
}

#[test]
fn no_lobe_reflects_more_than_the_lamellae_fill() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(2);
    let mut largest = 0.0_f64;
    for case in 0..1500 {
        let tilt = [0.0, 9.0, 89.9][case % 3] * random.random_range(-1.0..1.0);
        let structure = Structure {
            delta: radians(tilt),
            phi_alpha: 10.0_f64.powf(random.random_range(-1.2..0.497)),
            lamella_width: if case % 2 == 0 { SPACING } else { random.random_range(20.0..SPACING) },
            ..Structure::blue()
        };
        let theta = match case % 4 {
            0 => 90.0 - 10.0_f64.powf(random.random_range(-3.0..1.5)),
            _ => random.random_range(0.0..90.0),
        };
        let azimuth = if case % 5 < 2 { 90.0 } else { random.random_range(0.0..360.0) };
        let wavelength = random.random_range(300.0..800.0);
        let found = filled(&mirror(), &structure, [theta, azimuth], wavelength, 300);
        assert!(found <= 1.0, "{structure:?} {theta} {azimuth} {wavelength}: {found}");
        largest = largest.max(found);
    }
    assert!(largest > 0.9, "{largest}");
}

/// Where an independent program found the most of products whose limit was too high: lobes along the ridges, a little wider than
/// tilted (up to 1.15), wide ones at normal incidence (1.01), and steep layers when light grazes (1.6).
#[test]
fn where_lobes_reflect_most_they_reflect_no_more_than_the_lamellae_fill() {
    let at = |wavelengths: f64, phi_alpha: f64, tilt: f64, theta: f64| {
        let structure =
            Structure { delta: radians(tilt), phi_alpha, lamella_width: 470.0 * wavelengths, ..Structure::blue() };
        let model = HybridModel { ridge_spacing: 1e6, ..mirror() };
        let found = filled(&model, &structure, [theta, 90.0], 470.0, 800);
        assert!(found <= 1.0, "{wavelengths} wavelengths, lobe {phi_alpha}, {tilt}°, {theta}: {found}");
        found
    };
    let cases = [
        (1.6, 0.32, 6.3, 50.0),
        (1.97, 0.335, 6.56, 49.75),
        (2.5, 0.287, 5.85, 52.93),
        (4.0, 0.24, 5.2, 56.0),
        (10.0, 0.16, 4.0, 63.0),
        (8.0, 1.1, 0.0, 0.0),
        (16.0, 1.1, 0.0, 0.0),
        (0.638, 0.96, 89.73, 89.99),
        (1.25, 0.97, 89.2, 89.99),
        (1.25, 0.54, 60.0, 89.99),
    ];
    let largest = cases.into_iter().map(|(q, lobe, tilt, theta)| at(q, lobe, tilt, theta)).fold(0.0, f64::max);
    assert!(largest > 0.9, "{largest}");
    for lobe in [0.1, 0.2, 0.4, 0.8, 1.1_f64] {
        for tilt in [0.7, 1.3].map(|share| share * 0.2 * lobe.sqrt().to_degrees()) {
            for theta in [0.0, 30.0, 50.0, 65.0, 80.0, 89.0] {
                for wavelengths in [1.5, 8.0] {
                    at(wavelengths, lobe, tilt, theta);
                    at(wavelengths, lobe, -tilt, theta);
                }
            }
        }
    }
}

/// Peak over `phi` of what is read along the ridges of a white stack.
#[test]
fn the_layers_mirror_at_twice_the_tilt_less_the_incidence() {
    for (theta, delta) in [(0.0, 2.5), (20.0, -4.0), (-45.0, 6.0), (60.0, 10.0)] {
        let structure = Structure { delta: radians(delta), phi_alpha: 0.01, ..Structure::blue() };
        let of = |phi: f64| {
            white(&mirror(), &structure, direction(radians(theta), FRAC_PI_2), direction(phi, FRAC_PI_2), 500.0)
        };
        let mirrored = radians(2.0 * delta - theta);
        let at = of(mirrored);
        assert!(at > 1.0, "{theta}, {delta}: {at}");
        for off in [-0.002, 0.002] {
            assert!(of(mirrored + off) < at, "{theta}, {delta}, {off}");
        }
        // The edges of a narrow lobe lie alike to either side.
        let edges =
            [-1.0, 1.0].map(|side| (1..400).map(f64::from).find(|step| of(mirrored + side * 5e-5 * step) <= 0.0));
        let [below, above] = edges.map(|edge| edge.unwrap());
        assert!((below - above).abs() < 0.04 * below, "{theta}, {delta}: {below} {above}");
    }
}

#[test]
fn a_reading_is_the_share_that_a_detector_of_one_steradian_takes() {
    let model = HybridModel::default();
    for (theta, phi, omega) in [(0.0, 10.0, 0.0), (30.0, -25.0, 90.0), (-20.0, 35.0, 30.0), (70.0, 60.0, 10.0)] {
        let geometry = Geometry { theta: radians(theta), phi: radians(phi), omega: radians(omega) };
        let [incoming, outgoing] = [geometry.theta, geometry.phi].map(|angle| direction(angle, geometry.omega));
        for polarization in EACH {
            let read = model.reflectivity(&Structure::blue(), &geometry, polarization, 450.0).unwrap();
            let f = model.brdf(&Structure::blue(), incoming, outgoing, polarization, 450.0).unwrap();
            assert!((read - f * outgoing[2]).abs() <= 1e-12, "{geometry:?}: {read} {f}");
        }
    }
}

/// Along the ridges of white untilted layers seen in the mirror direction every factor has its closed form.
#[test]
fn the_mirror_direction_has_its_closed_form() {
    let structure = Structure { delta: 0.0, ..Structure::blue() };
    for theta in [0.0, 30.0, 60.0_f64] {
        let [incoming, outgoing] = [theta, -theta].map(|angle| direction(radians(angle), FRAC_PI_2));
        let found = white(&mirror(), &structure, incoming, outgoing, 500.0);
        let compensation = 1.0 + 500.0 / (20.0 * PI * PI * 300.0);
        let expected = compensation * 300.0 * 300.0 / (500.0 * SPACING) * PI / (8.0 * 0.25_f64.sin());
        assert!((found - expected).abs() < 1e-12, "{theta}: {found} {expected}");
    }
}

#[test]
fn edges_have_their_limits_and_nonsense_its_error() {
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let f = |incoming, outgoing| model.brdf(&blue, incoming, outgoing, Polarization::Unpolarized, 450.0);
    let up = [0.0, 0.0, 1.0];
    assert!(f(up, direction(radians(100.0), 0.3)).unwrap().abs() <= 0.0, "below the horizon");
    for azimuth in [0.0, 0.3, FRAC_PI_2, 2.0, PI] {
        let [x, y, _] = direction(FRAC_PI_2, azimuth);
        let grazing = [x, y, 0.0];
        for other in [up, grazing, [-x, -y, 0.0], direction(0.5, 1.0)] {
            for (one, two) in [(grazing, other), (other, grazing)] {
                let value = f(one, two).unwrap();
                assert!(value.is_finite() && value >= 0.0, "{one:?} {two:?}: {value}");
            }
            // The limit from above; where both graze it depends on the way.
            let near = direction(FRAC_PI_2 - 1e-11, azimuth);
            let (limit, value) = (f(near, other).unwrap(), f(grazing, other).unwrap());
            assert!(
                (limit - value).abs() < 1e-3 * value.max(1e-3) || other[2] <= 0.0,
                "{azimuth} {other:?}: {limit} {value}"
            );
        }
    }
    for bad in [[0.0, 0.0, 0.9], [f64::NAN, 0.0, 1.0], [0.0, 0.0, f64::INFINITY]] {
        assert!(matches!(f(bad, up), Err(OpticsError::OutOfRange { .. })), "{bad:?}");
        assert!(matches!(f(up, bad), Err(OpticsError::OutOfRange { .. })), "{bad:?}");
    }
    let wide = Structure { lamella_width: 751.0, ..blue };
    let geometry = Geometry::default();
    assert!(model.reflectivity(&wide, &geometry, Polarization::S, 450.0).is_err());
    for ridge_spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let model = HybridModel { ridge_spacing, ..HybridModel::default() };
        assert!(model.reflectivity(&blue, &geometry, Polarization::S, 450.0).is_err(), "{ridge_spacing}");
    }
}

/// Full-wave light sees 1.25 to 1.37 for n = 1.56 and a filling of 0.4; the formula gives sqrt(1 + 0.4 (1.56² - 1)).
#[test]
fn wide_light_sees_an_effective_index() {
    let of = |filling| Stack { filling: Some(filling), ..Stack::default() }.media(500.0).map(|media| media.cuticle.re);
    assert!((of(0.4).unwrap() - 1.573_44_f64.sqrt()).abs() < 1e-15);
    assert!((of(1.0).unwrap() - 1.56).abs() < 1e-15);
    for filling in [0.0, -0.1, 1.1, f64::NAN] {
        assert!(of(filling).is_err(), "{filling}");
    }
}

fn hybrid() -> FitSettings {
    FitSettings { model: ModelChoice::Hybrid { ridge_spacing: SPACING }, ..FitSettings::default() }
}

/// Phi scans at several wavelengths, across the ridges alone.
fn across() -> Vec<Scan> {
    [400.0, 420.0, 440.0, 460.0, 480.0, 500.0, 530.0].map(|wavelength| Scan::angular(wavelength, 0.0)).to_vec()
}

#[test]
fn across_the_ridges_alone_hybrid_tells_both_thicknesses_and_blend_does_not() {
    for (truth, seed) in [(Structure::blue(), 1), (Structure::table1(), 2)] {
        let data = simulate(&HybridModel::default(), &truth, &across(), 1.0, 0.01, seed).unwrap();
        let found = fit(&data, &hybrid(), &|_| {}).unwrap().outcome;
        for (estimate, truth) in
            [(&found.parameters.d_air, truth.d_air), (&found.parameters.d_cuticle, truth.d_cuticle)]
        {
            let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
            println!("{value} ± {sigma} ({truth}) {:?}", estimate.status);
            assert!((value - truth).abs() < 4.0 * sigma && sigma < 3.0, "{value} ± {sigma} is not {truth}");
        }
        let blend = BlendModel::default();
        let data = simulate(&blend, &truth, &across(), 1.0, 0.01, seed).unwrap();
        let found = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
        for estimate in [&found.parameters.d_air, &found.parameters.d_cuticle] {
            assert_eq!(estimate.status, Status::NotIdentifiable);
            assert!(estimate.value.is_none());
        }
    }
}

#[test]
fn the_full_design_tells_everything() {
    let (model, truth) = (HybridModel::default(), Structure::blue());
    let scans = Scan::full_design(&model, &truth).unwrap();
    let data = simulate(&model, &truth, &scans, 3.0, 0.01, 5).unwrap();
    let found = fit(&data, &hybrid(), &|_| {}).unwrap().outcome;
    let expected = morpho_fit::inversion::values(&truth);
    for ((name, estimate), expected) in found.parameters.each().into_iter().zip(expected) {
        let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
        let expected = if name == "delta" { expected.to_degrees() } else { expected };
        println!("{name} {value} ± {sigma} ({expected}) {:?}", estimate.status);
        assert!((value - expected).abs() < 4.0 * sigma, "{name}: {value} ± {sigma} is not {expected}");
    }
    let names: Vec<&str> = found.nuisance.iter().map(|nuisance| nuisance.name.as_ref()).collect();
    assert_eq!(names, ["scale"], "a product has no weight");
}

#[test]
fn a_product_has_no_weight_and_no_parts() {
    let weighed =
        FitSettings { nuisances: Nuisances { weight: Weight::Fixed(0.5), ..Nuisances::default() }, ..hybrid() };
    let parted = FitSettings { parts: Parts::Lamella, ..hybrid() };
    for settings in [weighed, parted] {
        assert!(matches!(settings.validate(), Err(SettingsError::OneProduct { .. })));
    }
    hybrid().validate().unwrap();
}
