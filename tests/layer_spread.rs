//! Layers that differ within one stack: against closed forms, expansions and Monte Carlo means of independent code.

mod support;

use morpho_fit::colorimetry::{Illuminant, Integration, Lab, Observer};
use morpho_fit::geometry::Polarization;
use morpho_fit::inversion::intervals::over_constant;
use morpho_fit::inversion::{Constant, FitSettings, Search, fit};
use morpho_fit::optics::multilayer::{Period, SAndP};
use morpho_fit::optics::{
    AveragedModel, Averages, BlendModel, HybridModel, Material, Media, OpticsError, PaperModel, ReflectivityModel,
    Stack, Structure,
};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use support::disorder::characteristic;

const TABLE1: Period = Period { cuticle: 100.0, gap: 135.0 };
const BLUE: Period = Period { cuticle: 62.0, gap: 141.0 };

fn with(layers: usize, averages: Averages) -> AveragedModel {
    let stack = Stack { layers, ..Stack::default() };
    AveragedModel::new(Box::new(BlendModel { stack }), averages).unwrap()
}

fn spread(layers: usize, layer_spread: f64) -> AveragedModel {
    with(layers, Averages { layer_spread, ..Averages::default() })
}

fn at(model: &AveragedModel, wavelength: f64, period: Period, angle: f64) -> SAndP {
    model.stack_reflectivity(&model.stack().media(wavelength).unwrap(), period, angle).unwrap()
}

/// Thicknesses of a stack from the light, its last gap in the base, with a deviation of each.
fn layers(media: &Media, period: Period, deviations: &[f64]) -> Vec<(f64, f64)> {
    let kinds = [(media.cuticle.re, period.cuticle), (media.gap.re, period.gap)];
    deviations.iter().zip(kinds.iter().cycle()).map(|(by, &(n, middle))| (n, (middle + by).max(0.0))).collect()
}

fn both(media: &Media, layers: &[(f64, f64)], angle: f64) -> [f64; 2] {
    [Polarization::S, Polarization::P].map(|seen| characteristic(media, layers, angle, seen))
}

/// Of one film R is known: with `rho` of an interface and the phase of a passage there and back,
///
/// ```text
/// 1 - R = (1 - rho²) / (1 + rho²) · (1 + 2 sum rho^2m cos(m phase)),   <cos(m phase)> = cos(m middle) exp(-m² sd² / 2)
/// ```
#[test]
fn one_film_is_the_closed_form() {
    for (sd, allowed) in [(5.0, 1e-5), (25.0, 1e-3)] {
        let model = spread(1, sd);
        for wavelength in [400.0, 470.0, 560.0, 700.0] {
            for angle in [0.0_f64, 0.6, 1.2] {
                let cos = (1.0 - (angle.sin() / 1.56).powi(2)).sqrt();
                let passage = 2.0 * TAU / wavelength * 1.56 * cos;
                let found = at(&model, wavelength, TABLE1, angle);
                for (found, y) in [(found.s, (angle.cos(), 1.56 * cos)), (found.p, (angle.cos(), cos / 1.56))] {
                    let rho = ((y.0 - y.1) / (y.0 + y.1)).powi(2);
                    let term = |m: i32| {
                        let m = f64::from(m);
                        rho.powf(m) * (m * passage * TABLE1.cuticle).cos() * (-0.5 * (m * passage * sd).powi(2)).exp()
                    };
                    let expected = 1.0 - (1.0 - rho) / (1.0 + rho) * (1.0 + 2.0 * (1..200).map(term).sum::<f64>());
                    assert!((found - expected).abs() < allowed, "{sd} nm, {wavelength}, {angle}: {found} {expected}");
                }
            }
        }
    }
}

/// `<R> = R + sd²/2 sum d²R/dd_j²` and terms of the fourth order: those in `sd⁴`, a few 1e-6 here.
#[test]
fn a_narrow_spread_is_the_second_order_of_its_layers() {
    let (sd, step) = (0.3, 0.3);
    let model = spread(9, sd);
    for (wavelength, angle) in [(430.0, 0.0), (480.0, 0.3), (560.0, 0.9), (520.0, 1.2)] {
        let media = model.stack().media(wavelength).unwrap();
        let middle = both(&media, &layers(&media, BLUE, &[0.0; 17]), angle);
        let mut expected = middle;
        for place in 0..17 {
            let moved = |by: f64| {
                let mut deviations = [0.0; 17];
                deviations[place] = by;
                both(&media, &layers(&media, BLUE, &deviations), angle)
            };
            let (above, below) = (moved(step), moved(-step));
            for seen in [0, 1] {
                let second = (above[seen] - 2.0 * middle[seen] + below[seen]) / (step * step);
                expected[seen] += 0.5 * sd * sd * second;
            }
        }
        let found = at(&model, wavelength, BLUE, angle);
        for (found, (expected, middle)) in [found.s, found.p].into_iter().zip(expected.into_iter().zip(middle)) {
            assert!((found - expected).abs() < 2e-5, "{wavelength} {angle}: {found} {expected} {middle}");
        }
    }
}

/// Means of 1e5 stacks of normal deviates by products of characteristic matrices, each with an error of 1e-3 at most. The array of
/// 961 stacks is off by 1e-3 (5 nm) to 4e-3 (25 nm) in the mean of many readings of 9 layers.
#[test]
fn wide_spreads_are_monte_carlo_means() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(20);
    for (count, sd, allowed) in [(9, 5.0, 2e-3), (9, 15.0, 4e-3), (9, 25.0, 5e-3), (20, 5.0, 4e-3), (20, 25.0, 8e-3)] {
        let model = spread(count, sd);
        let (mut squares, mut readings) = (0.0, 0.0);
        let cases = [(410.0, 0.0), (480.0, 0.7), (520.0, 1.3), (570.0, 0.4), (640.0, 1.0)];
        let media = cases.map(|(wavelength, _)| model.stack().media(wavelength).unwrap());
        let mut sums = [[0.0; 2]; 5];
        let stacks = 100_000 / count * 9;
        for _ in 0..stacks {
            let deviations: Vec<f64> = (0..2 * count - 1)
                .map(|_| {
                    let deviate: f64 = StandardNormal.sample(&mut random);
                    sd * deviate
                })
                .collect();
            for ((sum, media), (_, angle)) in sums.iter_mut().zip(&media).zip(cases) {
                for (sum, one) in sum.iter_mut().zip(both(media, &layers(media, BLUE, &deviations), angle)) {
                    *sum += one;
                }
            }
        }
        for ((wavelength, angle), sum) in cases.into_iter().zip(sums) {
            let found = at(&model, wavelength, BLUE, angle);
            for (found, sum) in [found.s, found.p].into_iter().zip(sum) {
                let off = found - sum / stacks as f64;
                assert!(off.abs() < 0.02, "{count} layers, {sd} nm, {wavelength} {angle}: {off}");
                squares += off * off;
                readings += 1.0;
            }
        }
        let off = f64::sqrt(squares / readings);
        assert!(off < allowed, "{count} layers, {sd} nm: {off}");
    }
}

/// A spread of the period over stacks of unequal layers: the mean of the means, each by all 961 stacks.
#[test]
fn beside_a_spread_of_the_period_it_is_the_mean_of_both() {
    let (alone, together) =
        (spread(9, 6.0), with(9, Averages { layer_spread: 6.0, period_spread: 8.0, ..Averages::default() }));
    let mut squares = 0.0;
    for wavelength in [420.0, 450.0, 480.0, 510.0, 560.0] {
        let (mut sum, mut whole) = (0.0, 0.0);
        for step in -40..=40 {
            let x = f64::from(step) * 0.1;
            let (share, factor) = ((-0.5 * x * x).exp(), 1.0 + 8.0 * x / (BLUE.cuticle + BLUE.gap));
            let longer = Period { cuticle: factor * BLUE.cuticle, gap: factor * BLUE.gap };
            sum += share * at(&alone, wavelength, longer, 0.3).mean();
            whole += share;
        }
        let off = at(&together, wavelength, BLUE, 0.3).mean() - sum / whole;
        assert!(off.abs() < 4e-3, "{wavelength}: {off}");
        squares += off * off / 5.0;
    }
    assert!(squares.sqrt() < 2e-3, "{}", squares.sqrt());
}

/// Fits take slopes by differences: those of a hair's breadth and of a fifth of a nanometre agree, as the stacks are the same.
#[test]
fn the_mean_is_smooth_in_the_structure() {
    let averages = Averages { layer_spread: 5.0, ..Averages::default() };
    for averages in
        [averages, Averages { period_spread: 4.0, ..averages }, Averages { numerical_aperture: 0.3, ..averages }]
    {
        let model = with(9, averages);
        for wavelength in [430.0, 470.0, 500.0] {
            let slope = |cuticle: f64, gap: f64| {
                let moved = |by: f64| Period { cuticle: BLUE.cuticle + by * cuticle, gap: BLUE.gap + by * gap };
                let p = |by: f64| at(&model, wavelength, moved(by), 0.25).p;
                (p(1.0) - p(-1.0)) / (2.0 * (cuticle + gap))
            };
            for (near, far) in [(slope(1e-3, 0.0), slope(0.2, 0.0)), (slope(0.0, 1e-3), slope(0.0, 0.2))] {
                assert!((near - far).abs() < 1e-5, "{averages:?} {wavelength}: {near} {far}");
            }
        }
    }
}

/// A lossy stack too is off from that of equal layers by some hundredths, and neither has exact slopes.
#[test]
fn absorbing_layers_have_values_and_leave_slopes_to_differences() {
    let stack = Stack { cuticle: Material::Constant { n: 1.56, k: 0.06 }, ..Stack::default() };
    let averages = Averages { layer_spread: 5.0, ..Averages::default() };
    let model = AveragedModel::new(Box::new(BlendModel { stack }), averages).unwrap();
    let media = model.stack().media(500.0).unwrap();
    let mut slopes = [morpho_fit::optics::multilayer::StackSlopes::default()];
    assert!(!model.stack_slopes(&[media], &[TAU / 500.0], BLUE, 0.3, &mut slopes));
    let found = model.stack_reflectivity(&media, BLUE, 0.3).unwrap();
    let plain = BlendModel { stack: model.stack().clone() }.stack_reflectivity(&media, BLUE, 0.3).unwrap();
    assert!(found.s > 0.0 && found.s < 1.0 && (found.s - plain.s).abs() > 1e-4 && (found.s - plain.s).abs() < 0.1);
}

/// No spread is the model itself, bit for bit.
#[test]
fn no_spread_changes_no_bit() {
    let (none, plain) = (spread(9, 0.0), BlendModel::default());
    for angle in [0.0, 0.4, 1.3, 1.7] {
        let media = plain.stack().media(480.0).unwrap();
        let wavenumbers: Vec<f64> = (0..40).map(|step| TAU / (380.0 + 9.0 * f64::from(step))).collect();
        let found = [&none as &dyn ReflectivityModel, &plain].map(|model| {
            let mut out = vec![SAndP::default(); 40];
            model.stack_reflectivities(&[media], &wavenumbers, BLUE, angle, &mut out).unwrap();
            out.iter().flat_map(|both| [both.s.to_bits(), both.p.to_bits()]).collect::<Vec<u64>>()
        });
        assert_eq!(found[0], found[1]);
    }
}

/// At grazing incidence R is 1, beyond it 0; printed formulas know equal layers only; thousands of layers are refused.
#[test]
fn edges_are_guarded() {
    let averages = Averages { layer_spread: 5.0, ..Averages::default() };
    let model = spread(9, 5.0);
    assert_eq!(at(&model, 480.0, BLUE, 1.6), SAndP::default());
    assert!(at(&model, 480.0, BLUE, std::f64::consts::FRAC_PI_2 - 1e-7).s > 0.999);
    let nothing = Period { cuticle: 0.0, gap: 0.0 };
    assert!(at(&model, 480.0, nothing, 0.2).s.is_finite());
    let huge = at(&model, 480.0, Period { cuticle: 1e6, gap: 1e6 }, 0.2);
    assert!(huge.s > 0.0 && huge.s < 1.0);
    let refused = |model: Box<dyn ReflectivityModel>, said: &str| {
        let error = AveragedModel::new(model, averages).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    };
    refused(Box::<PaperModel>::default(), "printed formulas");
    refused(Box::new(BlendModel { stack: Stack { layers: 1001, ..Stack::default() } }), "1000 layers");
    assert!(AveragedModel::new(Box::<HybridModel>::default(), averages).is_ok());
    assert!(Averages { layer_spread: f64::NAN, ..averages }.validate().is_err());
    assert!(Averages { layer_spread: 201.0, ..averages }.validate().is_err());
}

/// The mean over stacks of normal deviates, by products of characteristic matrices.
#[derive(Debug)]
struct Drawn {
    stack: Stack,
    deviations: Vec<Vec<f64>>,
}

impl Drawn {
    fn new(sd: f64, stacks: usize, seed: u64) -> Self {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut one = || StandardNormal.sample_iter(&mut random).take(17).map(|deviate: f64| sd * deviate).collect();
        Self { stack: Stack::default(), deviations: (0..stacks).map(|_| one()).collect() }
    }
}

impl ReflectivityModel for Drawn {
    fn name(&self) -> &'static str {
        "drawn"
    }

    fn stack(&self) -> &Stack {
        &self.stack
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        let each = self.deviations.iter().map(|deviations| both(media, &layers(media, period, deviations), angle));
        let [s, p] = each.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        let count = self.deviations.len() as f64;
        Ok(SAndP { s: s / count, p: p / count })
    }
}

/// The spread of 3000 drawn stacks of independent layers, with 1 % noise, and the thicknesses under it lie within their intervals;
/// without a spread the model misses the data.
#[test]
fn the_spread_of_drawn_layers_is_found() {
    let scan = |omega: f64| Scan {
        name: format!("omega {omega}"),
        wavelengths: linspace(420.0, 660.0, 16),
        thetas: vec![0.0],
        phis: linspace(-40_f64.to_radians(), 40_f64.to_radians(), 9),
        omegas: vec![omega.to_radians()],
        polarization: Polarization::Unpolarized,
    };
    let drawn = Drawn::new(8.0, 3000, 77);
    let data = simulate(&drawn, &Structure::blue(), &[scan(20.0), scan(75.0)], 1.0, 0.01, 5).unwrap();
    let start = [138.0, 64.0, 2.5_f64.to_radians(), 0.5, 300.0].map(Some);
    let settings = FitSettings { search: Search::Local, start, ..FitSettings::default() };
    let found = over_constant(&data, &settings, Constant::LayerSpread, [0.0, 20.0], &|_| {}).unwrap();
    let [low, high] = found.intervals.interval_95.map(Option::unwrap);
    assert!(low < 8.0 && 8.0 < high && high - low < 4.0, "{} {:?}", found.best, found.intervals);
    for (name, truth) in [("d_air", 141.0), ("d_cuticle", 62.0)] {
        let quantity = found.quantities.iter().find(|quantity| quantity.name == name).unwrap();
        let [low, high] = quantity.intervals.interval_95.map(Option::unwrap);
        assert!(low < truth && truth < high, "{name} {quantity:?}");
    }
    let plain = fit(&data, &settings, &|_| {}).unwrap().outcome;
    assert!(
        plain.chi2 > 1.5 * plain.dof as f64 && found.fit.outcome.chi2 < 1.3 * found.fit.outcome.dof as f64,
        "{} {}",
        plain.chi2,
        found.fit.outcome.chi2
    );
}

/// At normal incidence ΔE₀₀ 1.7 by another program, and by 20,000 stacks of normal deviates.
#[test]
fn five_nanometres_change_the_colour_of_table_1_as_much_as_other_programs_say() {
    let grid = Wavelengths::new(380.0, 780.0, 5.0).unwrap();
    let eye = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65).unwrap();
    let lab = |spectrum: &[f64]| Lab::new(eye.xyz(spectrum).unwrap(), eye.white()).unwrap();
    let (plain, model) = (BlendModel::default(), spread(9, 5.0));
    let media: Vec<Media> = grid.iter().map(|at| plain.stack().media(at).unwrap()).collect();
    let of = |model: &dyn ReflectivityModel| {
        let each = media.iter().map(|media| model.stack_reflectivity(media, TABLE1, 0.0).unwrap().s);
        lab(&each.collect::<Vec<f64>>())
    };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(21);
    let mut mean = vec![0.0; media.len()];
    for _ in 0..20_000 {
        let deviations: Vec<f64> =
            StandardNormal.sample_iter(&mut random).take(17).map(|deviate: f64| 5.0 * deviate).collect();
        for (mean, media) in mean.iter_mut().zip(&media) {
            *mean += characteristic(media, &layers(media, TABLE1, &deviations), 0.0, Polarization::S) / 20_000.0;
        }
    }
    let without = of(&plain);
    let (found, drawn) = (of(&model).difference(without), lab(&mean).difference(without));
    assert!((found - drawn).abs() < 0.05 && (found - 1.7).abs() < 0.15, "{found} {drawn}");
}
