//! What is advised to measure next, held to the fit of data that were measured so: the blue preset, 1 % noise.

use morpho_fit::dataset::Dataset;
use morpho_fit::inversion::{
    AdviceError, Ask, Extent, Fit, FitSettings, Nuisances, Parameter, Role, Search, advise, expected, fit,
};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::optimise::Loss;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;

fn measured(scans: &[Scan], noise: f64, seed: u64) -> Dataset {
    simulate(&BlendModel::default(), &Structure::blue(), scans, 1.0, noise, seed).unwrap()
}

fn fitted(data: &Dataset) -> Fit {
    fit(data, &FitSettings::default(), &|_| {}).unwrap()
}

fn full() -> Vec<Scan> {
    Scan::full_design(&BlendModel::default(), &Structure::blue()).unwrap()
}

fn angular(lines: &[f64], omega_deg: f64) -> Vec<Scan> {
    lines.iter().map(|&line| Scan::angular(line, omega_deg)).collect()
}

/// The rows of the table in the physics notes that lack something.
fn lacking() -> Vec<(&'static str, Vec<Scan>)> {
    let at = |theta: f64| Scan {
        name: format!("theta {theta}"),
        thetas: vec![radians(theta)],
        phis: vec![radians(-theta)],
        ..Scan::spectrum(90.0)
    };
    vec![
        ("phi scans across the ridges", angular(&[400.0, 420.0, 440.0, 460.0, 480.0], 0.0)),
        ("one phi scan along them", angular(&[480.0], 90.0)),
        ("phi scans along them", angular(&linspace(420.0, 540.0, 7), 90.0)),
        ("a spectrum along them", vec![Scan::spectrum(90.0)]),
        ("spectra along them", [0.0, 10.0, 20.0, 30.0, 40.0].map(at).to_vec()),
    ]
}

fn with(scans: &[Scan], more: &[Scan]) -> Vec<Scan> {
    scans.iter().chain(more).cloned().collect()
}

/// The judge is the fit of data simulated with the advised scans, for three sets of noise.
#[test]
fn the_advised_scans_make_every_lacking_design_determine_everything() {
    for (name, scans) in lacking() {
        for seed in 1..4 {
            let data = measured(&scans, 0.01, seed);
            let advice = advise(&data, &fitted(&data), Ask::IfNeeded).unwrap();
            let best = &advice[0];
            println!("{name} {seed}: {:?} {:?}", best.found.scans, best.found.expected);
            let again = fitted(&measured(&with(&scans, &best.scans), 0.01, 10 + seed)).outcome;
            for (parameter, estimate) in again.parameters.each() {
                println!("    {parameter} {:?} {:?} {:?}", estimate.status, estimate.value, estimate.sigma);
            }
            assert!(best.found.enough, "{name}: {:?}", best.found);
            for (parameter, estimate) in again.parameters.each() {
                assert!(estimate.status.is_determined(), "{name}, {:?}: {parameter} {estimate:?}", best.found.scans);
            }
        }
    }
}

/// Before any measurement the same holds: the design is a file of geometries, and the structure is the assumed one.
#[test]
fn a_checked_design_with_the_advised_scans_lacks_nothing() {
    for (name, scans) in lacking() {
        let design = expected(&measured(&scans, 0.01, 1), &FitSettings::default(), &|_| {}).unwrap();
        println!("{name}: {:?}", design.advice.first().map(|a| &a.scans));
        assert!(!design.good && design.advice[0].enough, "{name}: {:?}", design.advice);
    }
    let design = expected(&measured(&full(), 0.01, 1), &FitSettings::default(), &|_| {}).unwrap();
    assert!(design.good && design.advice.is_empty());
}

#[test]
fn the_expected_standard_deviations_are_those_of_the_fit_that_follows() {
    let data = measured(&full(), 0.01, 1);
    let found = fitted(&data);
    assert!(advise(&data, &found, Ask::IfNeeded).unwrap().is_empty(), "nothing more is needed");
    for proposal in advise(&data, &found, Ask::Always).unwrap() {
        let again = fitted(&measured(&with(&full(), &proposal.scans), 0.01, 2)).outcome;
        let (now, then) = (found.outcome.parameters.each(), again.parameters.each());
        for (expected, ((_, now), (_, then))) in proposal.found.expected.iter().zip(now.into_iter().zip(then)) {
            let (now, then) = (now.sigma.unwrap(), then.sigma.unwrap());
            println!("{expected:?} {now} {then}");
            assert!((expected.before / now - 1.0).abs() < 0.02, "{expected:?} {now}");
            assert!((expected.after / then - 1.0).abs() < 0.3, "{:?}: {expected:?} {then}", proposal.found.scans);
        }
    }
}

/// (141, 62) and its alias (98, 89) fit a noisy spectrum alike. With the advised scan the alias is no minimum any more: a
/// free fit from it ends at the truth. So the judge is the least chi² within 5 nm of it, less that of the best. It lies at
/// the edge of this box and depends on its size; the expansion behind the expected value does not know the edge. The two
/// are held to a factor of 2.5 only.
#[test]
fn the_advised_scan_rules_out_the_swap_alias() {
    let blue = Structure::blue();
    let settings = FitSettings::default()
        .with_role(Parameter::Delta, Role::Fixed { value: blue.delta })
        .with_role(Parameter::PhiAlpha, Role::Fixed { value: blue.phi_alpha })
        .with_role(Parameter::LamellaWidth, Role::Fixed { value: blue.lamella_width });
    let mut split = 0;
    for seed in 1..6 {
        let scans = [Scan::spectrum(90.0)];
        let data = measured(&scans, 0.12, seed);
        let found = fit(&data, &settings, &|_| {}).unwrap();
        let Some(best) = advise(&data, &found, Ask::IfNeeded).unwrap().into_iter().next() else { continue };
        let alias = best.found.splits.iter().find(|split| (split.values[0] - split.values[1]).abs() < 30.0);
        let Some(alias) = alias else { continue };
        let more = measured(&with(&scans, &best.scans), 0.12, seed);
        let near = |values: [f64; 5]| {
            let mut settings = FitSettings { search: Search::Local, ..settings.clone() };
            for (place, value) in values.into_iter().enumerate().take(2) {
                settings.roles[place] = Role::Free { lower: value - 5.0, upper: value + 5.0 };
                settings.start[place] = Some(value);
            }
            fit(&more, &settings, &|_| {}).unwrap().outcome.minima[0].clone()
        };
        let (there, here) = (near(alias.values), near(found.outcome.minima[0].values));
        let actual = there.chi2 - here.chi2;
        println!("{seed}: {:?} {alias:?} {:?} {:?} {actual}", best.found.scans, there.values, here.values);
        assert!(alias.chi2_now < 9.0 && alias.chi2_expected > 25.0, "{alias:?}");
        assert!(actual > 25.0, "{actual}");
        let ratio = alias.chi2_expected / actual;
        assert!((0.4..2.5).contains(&ratio), "{alias:?} {actual}");
        split += 1;
    }
    assert!(split >= 3, "{split}");
}

#[test]
fn advice_is_the_same_with_any_number_of_threads_and_for_any_kind_of_data() {
    let scans = [Scan::spectrum(90.0), Scan::spectrum(0.0)];
    let per_curve = Nuisances { scale: Extent::PerCurve, background: Extent::Shared, ..Nuisances::default() };
    for (noise, nuisances, loss) in
        [(0.01, Nuisances::default(), Loss::Linear), (0.02, per_curve, Loss::Huber), (0.0, per_curve, Loss::Linear)]
    {
        let settings = FitSettings { nuisances, loss, ..FitSettings::default() };
        let data = measured(&scans, noise, 3);
        let found = fit(&data, &settings, &|_| {}).unwrap();
        let threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
            pool.install(|| advise(&data, &found, Ask::Always).unwrap())
        };
        let advice = threads(1);
        assert_eq!(advice, threads(3));
        let finite = |value: f64| value.is_finite() && value > 0.0;
        println!("{noise} {loss:?} {nuisances:?}: {advice:?}");
        let numbers = advice.iter().flat_map(|one| &one.found.expected);
        assert!(numbers.clone().count() > 0 && numbers.clone().all(|one| finite(one.before) && finite(one.after)));
    }
}

#[test]
fn a_fit_of_other_data_is_refused() {
    let found = fitted(&measured(&[Scan::spectrum(90.0)], 0.01, 1));
    let other = measured(&full(), 0.01, 1);
    let refused = advise(&other, &found, Ask::Always);
    assert_eq!(refused.unwrap_err(), AdviceError::OtherData { readings: 172, fitted: 37 });
}
