//! Few readings with much noise: chi² rises more slowly than the curvature at the minimum says, and intervals reach as far as it lets
//! them.

use morpho_fit::dataset::Dataset;
use morpho_fit::inversion::{Estimate, FitOutcome, FitSettings, Parameter, Role, Search, fit, values};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

/// Ten readings of a spectrum and nine of a scan, along the ridges.
fn few(seed: u64) -> Dataset {
    let spectrum = Scan { wavelengths: linspace(380.0, 740.0, 10), ..Scan::spectrum(90.0) };
    let scan = Scan {
        name: "scan".to_owned(),
        wavelengths: vec![450.0],
        thetas: vec![radians(30.0)],
        phis: linspace(-60.0, 60.0, 9).into_iter().map(radians).collect(),
        ..Scan::spectrum(90.0)
    };
    simulate(&BlendModel::default(), &Structure::blue(), &[spectrum, scan], 1.0, 0.03, seed).unwrap()
}

fn told(data: &Dataset, settings: &FitSettings) -> FitOutcome {
    fit(data, settings, &|_| {}).unwrap().outcome
}

fn is_told(estimate: &Estimate) -> bool {
    estimate.status.is_determined()
}

/// By the covariance alone 91 % of 400 intervals of 95 % held the period.
#[test]
fn intervals_hold_the_truth_where_chi2_is_no_parabola() {
    let truth = Structure::blue();
    let (period, sum) = (truth.d_air + truth.d_cuticle, truth.d_air + 1.56 * truth.d_cuticle);
    let held: Vec<[Option<bool>; 2]> = (0..400_u64)
        .into_par_iter()
        .map(|seed| {
            let found = told(&few(seed), &FitSettings::default()).derived;
            [(found.period, period), (found.optical_sum, sum)].map(|(estimate, truth)| {
                let [low, high] = estimate.interval_95?;
                Some(low.is_none_or(|low| low <= truth) && high.is_none_or(|high| truth <= high))
            })
        })
        .collect();
    for quantity in [0, 1] {
        let told: Vec<bool> = held.iter().filter_map(|held| held[quantity]).collect();
        let share = told.iter().filter(|held| **held).count() as f64 / told.len() as f64;
        println!("{}: {:.1} % of {}", ["period", "optical sum"][quantity], 100.0 * share, told.len());
        // 95 % less two standard deviations of so many.
        let allowed = 0.95 - 2.0 * (0.95 * 0.05 / told.len() as f64).sqrt();
        assert!(told.len() >= 390 && share >= allowed, "{quantity}: {share} of {}", told.len());
    }
}

/// At the end of an interval of 95 % the best of everything else has a chi² that is 3.84 higher, nearly or more: by fits that hold
/// the parameter there.
#[test]
fn chi2_has_risen_at_every_end() {
    let (mut ends, mut moved) = (0, 0);
    for seed in 0..60 {
        let data = few(seed);
        let found = told(&data, &FitSettings::default());
        for parameter in [Parameter::DAir, Parameter::DCuticle, Parameter::Delta, Parameter::PhiAlpha] {
            let (name, estimate) = found.parameters.each()[parameter.index()];
            let Some(interval) = estimate.interval_95.filter(|_| is_told(estimate)) else { continue };
            let [low, high] = interval.map(Option::unwrap_or_default);
            let lopsided = (high + low - 2.0 * estimate.value.unwrap()).abs() > 1e-6 * (high - low);
            moved += usize::from(lopsided && interval.iter().all(Option::is_some));
            for end in interval.into_iter().flatten() {
                let mut settings = FitSettings { search: Search::Local, ..FitSettings::default() };
                for (place, (_, other)) in found.parameters.each().into_iter().enumerate() {
                    let start = other.value.or(other.held_at).unwrap();
                    settings.start[place] = Some(Parameter::ALL[place].inside(start));
                }
                settings.roles[parameter.index()] = Role::Fixed { value: parameter.inside(end) };
                settings.start[parameter.index()] = None;
                let risen = told(&data, &settings).chi2 - found.chi2;
                assert!(risen > 0.85 * 3.84, "{seed} {name} at {end}: {risen}");
                ends += 1;
            }
        }
    }
    assert!(ends > 250 && moved > 10, "{ends} {moved}");
}

/// With many readings and little noise chi² is a parabola, and the intervals are those of the covariance.
#[test]
fn nothing_moves_where_chi2_is_a_parabola() {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.001, 5).unwrap();
    let found = told(&data, &FitSettings::default());
    for ((name, estimate), truth) in found.parameters.each().into_iter().zip(values(&blue)) {
        let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
        let [Some(low), Some(high)] = estimate.interval_95.unwrap() else { panic!("{name} is open") };
        assert!((high - value - 1.959_964 * sigma).abs() < 1e-6 * sigma, "{name}: {high} {truth}");
        assert!((value - low - 1.959_964 * sigma).abs() < 1e-6 * sigma, "{name}: {low}");
        let row = found.covariance.names.iter().position(|own| own == name).unwrap();
        assert!((found.covariance.rows[row][row].sqrt() / sigma - 1.0).abs() < 1e-9, "{name}");
    }
}
