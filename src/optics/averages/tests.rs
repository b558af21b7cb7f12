//! Averages against fine sums, differences and symmetries.

use super::*;
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, HybridModel, Structure};
use approx::assert_abs_diff_eq;
use std::f64::consts::PI;

const PERIOD: Period = Period { cuticle: 62.0, gap: 141.0 };

fn averaged(averages: Averages) -> AveragedModel {
    AveragedModel::new(Box::new(BlendModel::default()), averages).unwrap()
}

fn mean_of(averages: Averages, wavelength: f64, angle: f64) -> f64 {
    let model = averaged(averages);
    model.stack_reflectivity(&model.stack().media(wavelength).unwrap(), PERIOD, angle).unwrap().mean()
}

#[test]
fn no_average_changes_nothing() {
    for angle in [0.0, 0.4] {
        assert_abs_diff_eq!(
            mean_of(Averages::default(), 480.0, angle),
            plain(9, 480.0, PERIOD, angle),
            epsilon = 1e-14
        );
    }
    assert!(Averages::default().is_none());
}

/// The largest error over 380 to 740 nm of an average of a stack of `layers`, against `fine`.
fn worst(layers: usize, averages: Averages, angle: f64, fine: &dyn Fn(f64) -> f64) -> f64 {
    let stack = Stack { layers, ..Stack::default() };
    let model = AveragedModel::new(Box::new(BlendModel { stack }), averages).unwrap();
    let at = |wavelength: f64| {
        let media = model.stack().media(wavelength).unwrap();
        let found = model.stack_reflectivity(&media, PERIOD, angle).unwrap().mean();
        (found - fine(wavelength)).abs()
    };
    (0..73).map(|step| at(380.0 + 5.0 * f64::from(step))).fold(0.0, f64::max)
}

fn plain(layers: usize, wavelength: f64, period: Period, angle: f64) -> f64 {
    let model = BlendModel { stack: Stack { layers, ..Stack::default() } };
    model.stack_reflectivity(&model.stack.media(wavelength).unwrap(), period, angle).unwrap().mean()
}

/// The mean over 4001 places of the normal distribution to six deviations.
fn normal_mean(function: impl Fn(f64) -> f64) -> f64 {
    let places = (-2000..=2000).map(|i| f64::from(i) * 3e-3);
    let (sum, weight) = places.fold((0.0, 0.0), |(sum, weight), x| {
        let own = (-0.5 * x * x).exp();
        (sum + own * function(x), weight + own)
    });
    sum / weight
}

#[test]
fn bands_and_spreads_are_those_of_a_fine_sum() {
    for (layers, width) in [(9, 3.0), (9, 10.0), (20, 5.0)] {
        let spread = Averages { period_spread: width, ..Averages::default() };
        let fine = |wavelength: f64| normal_mean(|x| plain(layers, wavelength, longer(PERIOD, width * x).0, 0.2));
        let off = worst(layers, spread, 0.2, &fine);
        assert!(off < 1e-3, "period, {layers} layers, {width} nm: {off}");
    }
    for width in [5.0, 25.0] {
        let band = Averages { bandwidth: width, ..Averages::default() };
        let fine = |wavelength: f64| normal_mean(|x| plain(9, wavelength + x * width / WIDTH, PERIOD, 0.2));
        let off = worst(9, band, 0.2, &fine);
        assert!(off < 1e-3, "band, {width} nm: {off}");
    }
    for (width, angle) in [(3.0_f64, 0.0), (3.0, 1.0), (8.0, 0.5)] {
        let tilt = Averages { tilt_spread: width.to_radians(), ..Averages::default() };
        let fine = |wavelength: f64| normal_mean(|x| plain(9, wavelength, PERIOD, angle - width.to_radians() * x));
        let off = worst(9, tilt, angle, &fine);
        assert!(off < 1e-3, "tilt, {width} degrees at {angle}: {off}");
    }
}

/// Against 200 × 200 even places of the pupil.
#[test]
fn cones_are_those_of_a_fine_sum() {
    for (aperture, angle) in [(0.75, 0.0), (0.75, 0.5_f64), (0.3, 1.0), (0.75, 1.0)] {
        let cone = Averages { numerical_aperture: aperture, ..Averages::default() };
        let fine = |wavelength: f64| {
            let mut sum = 0.0;
            for ring in 0..200 {
                let sin = aperture * ((f64::from(ring) + 0.5) / 200.0).sqrt();
                for step in 0..200 {
                    let azimuth = PI * (f64::from(step) + 0.5) / 200.0;
                    let cos = angle.cos() * (1.0 - sin * sin).sqrt() + angle.sin() * sin * azimuth.cos();
                    sum += plain(9, wavelength, PERIOD, cos.acos()) / 40_000.0;
                }
            }
            sum
        };
        let stack = averaged(cone);
        for wavelength in [390.0, 430.0, 480.0, 520.0, 650.0] {
            let found = stack.stack_reflectivity(&stack.stack().media(wavelength).unwrap(), PERIOD, angle).unwrap();
            let off = (found.mean() - fine(wavelength)).abs();
            assert!(off < 1e-3, "{aperture} at {angle}, {wavelength} nm: {off}");
        }
    }
}

#[test]
fn a_cone_about_the_normal_sees_no_polarization_and_a_narrow_one_that_of_its_axis() {
    let wide = averaged(Averages { numerical_aperture: 0.75, ..Averages::default() });
    let media = wide.stack().media(480.0).unwrap();
    let found = wide.stack_reflectivity(&media, PERIOD, 0.0).unwrap();
    assert_abs_diff_eq!(found.s, found.p, epsilon = 1e-14);
    // The rings' shortcut is the limit of the whole cone.
    let beside = wide.stack_reflectivity(&media, PERIOD, 1e-9).unwrap();
    assert_abs_diff_eq!(beside.s, found.s, epsilon = 1e-4);
    assert_abs_diff_eq!(beside.p, found.p, epsilon = 1e-4);
    let narrow = averaged(Averages { numerical_aperture: 1e-3, ..Averages::default() });
    let (found, plane) = (
        narrow.stack_reflectivity(&media, PERIOD, 0.9).unwrap(),
        BlendModel::default().stack_reflectivity(&media, PERIOD, 0.9).unwrap(),
    );
    assert_abs_diff_eq!(found.s, plane.s, epsilon = 1e-4);
    assert_abs_diff_eq!(found.p, plane.p, epsilon = 1e-4);
}

#[test]
fn slopes_are_differences_of_the_means() {
    for averages in [
        Averages { numerical_aperture: 0.4, bandwidth: 4.0, ..Averages::default() },
        Averages { period_spread: 5.0, tilt_spread: 0.03, ..Averages::default() },
    ] {
        slopes_are_differences(averages);
    }
}

fn slopes_are_differences(averages: Averages) {
    let model = averaged(averages);
    let media = model.stack().media(480.0).unwrap();
    let wavenumbers = [TAU / 470.0, TAU / 500.0];
    let at = |period: Period, angle: f64| {
        let mut out = [SAndP::default(); 2];
        model.stack_reflectivities(&[media], &wavenumbers, period, angle, &mut out).unwrap();
        out
    };
    let mut found = [StackSlopes::default(); 2];
    assert!(model.stack_slopes(&[media], &wavenumbers, PERIOD, 0.25, &mut found));
    let step = 1e-3;
    let moved = |cuticle, gap| Period { cuticle: PERIOD.cuticle + cuticle, gap: PERIOD.gap + gap };
    for (i, found) in found.iter().enumerate() {
        let slope = |above: [SAndP; 2], below: [SAndP; 2], step: f64| (above[i].p - below[i].p) / (2.0 * step);
        let cuticle = slope(at(moved(step, 0.0), 0.25), at(moved(-step, 0.0), 0.25), step);
        let gap = slope(at(moved(0.0, step), 0.25), at(moved(0.0, -step), 0.25), step);
        let angle = slope(at(PERIOD, 0.25 + 1e-5), at(PERIOD, 0.25 - 1e-5), 1e-5);
        assert_abs_diff_eq!(found.cuticle.p, cuticle, epsilon = 1e-7);
        assert_abs_diff_eq!(found.gap.p, gap, epsilon = 1e-7);
        assert_abs_diff_eq!(found.angle.p, angle, epsilon = 1e-6);
    }
}

#[test]
fn widths_out_of_range_are_errors() {
    for averages in [
        Averages { numerical_aperture: 1.2, ..Averages::default() },
        Averages { bandwidth: -1.0, ..Averages::default() },
        Averages { period_spread: f64::NAN, ..Averages::default() },
        Averages { tilt_spread: 1.0, ..Averages::default() },
        Averages { tilt_spread: 0.1, numerical_aperture: 0.2, ..Averages::default() },
    ] {
        assert!(averages.validate().is_err(), "{averages:?}");
    }
}

/// Readings together against one by one: cuticle that absorbs and that does not, s and p, gap and cuticle of one thickness, both
/// joins, and each average but the band, whose steps follow the shortest wavelength.
#[test]
fn readings_together_are_those_one_by_one() {
    let lossy = crate::optics::Material::Constant { n: 1.56, k: 0.06 };
    for averages in [
        Averages { layer_spread: 8.0, ..Averages::default() },
        Averages { numerical_aperture: 0.5, layer_spread: 3.0, ..Averages::default() },
        Averages { numerical_aperture: 0.3, period_spread: 2.0, ..Averages::default() },
        Averages::default(),
    ] {
        for cuticle in [Stack::default().cuticle, lossy.clone()] {
            let stack = Stack { cuticle, layers: 4, ..Stack::default() };
            let models: [Box<dyn ReflectivityModel>; 2] = [
                Box::new(BlendModel { stack: stack.clone() }),
                Box::new(HybridModel { stack, ..HybridModel::default() }),
            ];
            for model in models {
                let model = AveragedModel::new(model, averages).unwrap();
                together(&model, &Structure::blue());
                together(&model, &Structure { d_air: 100.0, d_cuticle: 100.0, ..Structure::blue() });
            }
        }
    }
}

fn together(model: &AveragedModel, structure: &Structure) {
    let mut readings = Vec::new();
    for (theta, phi, omega) in
        [(0.0, 0.1, 1.2), (0.4, -0.4, 1.2), (0.4, -0.3, 0.3), (0.4, -0.3, PI / 2.0), (0.4, 0.2, 0.0)]
    {
        for wavelength in [420.0, 480.0, 480.0, 610.0] {
            readings.push((Geometry { theta, phi, omega }, wavelength));
        }
    }
    // Out of range: an error of its own, which takes nothing from the others.
    readings.push((Geometry { theta: 2.0, phi: 0.0, omega: 0.0 }, 480.0));
    for light in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
        let all = model.contributions_at(structure, light, &readings).unwrap();
        assert_eq!(all.len(), readings.len());
        assert!(all[readings.len() - 1].is_err());
        for (found, (geometry, wavelength)) in all.iter().zip(&readings).take(readings.len() - 1) {
            let alone = model.contributions(structure, geometry, light, *wavelength).unwrap();
            for (one, other) in found.as_ref().unwrap().iter().zip(alone) {
                assert_eq!(one.name, other.name);
                assert_abs_diff_eq!(one.intensity, other.intensity, epsilon = 1e-14);
            }
        }
    }
}

/// Media of another stack: one without layers has nothing to spread, and is the interface of air and glass, (0.5 / 2.5)².
#[test]
fn a_spread_of_no_layers_is_the_interface() {
    let stack = Stack { layers: 0, ..Stack::default() };
    let model = BlendModel { stack };
    let model = AveragedModel::new(Box::new(model), Averages { layer_spread: 5.0, ..Averages::default() }).unwrap();
    let media = Media { base: 1.5.into(), ..Stack::default().media(480.0).unwrap() };
    let found = model.stack_reflectivity(&media, PERIOD, 0.0).unwrap();
    assert_abs_diff_eq!(found.s, 0.04, epsilon = 1e-12);
    assert_abs_diff_eq!(found.p, 0.04, epsilon = 1e-12);
}

/// The same bits from memory, after other questions, as from a model that was never asked.
#[test]
fn what_is_remembered_is_what_is_computed() {
    let averages = Averages { layer_spread: 5.0, ..Averages::default() };
    let (used, media) = (averaged(averages), Stack::default().media(480.0).unwrap());
    let ask = |model: &AveragedModel, angle: f64| model.stack_reflectivity(&media, PERIOD, angle).unwrap();
    let first = ask(&used, 0.2);
    for step in 0..20 {
        ask(&used, 0.03 * f64::from(step));
    }
    assert_eq!((ask(&used, 0.2), ask(&averaged(averages), 0.2)), (first, first));
    assert_eq!(format!("{used:?}"), format!("{:?}", averaged(averages)));
}

#[test]
fn averages_are_told_in_the_units_of_the_user() {
    let tilt_spread = 3.0_f64.to_radians();
    let all = Averages { bandwidth: 10.0, layer_spread: 2.5, tilt_spread, ..Averages::default() };
    assert_eq!(all.to_string(), "band 10 nm, each layer ± 2.5 nm, tilt ± 3°");
    assert_eq!(Averages::default().to_string(), "plane waves on equal layers");
}
