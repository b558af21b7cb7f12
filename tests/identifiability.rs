//! What each design of measurement can tell (the table of the physics notes): the blue preset, 1 % noise.

use morpho_fit::inversion::{
    FitOutcome, FitSettings, MinimumFound, Parameter, Relation, Role, Status, Verdict, chi_square_map, fit,
};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;

fn outcome(scans: &[Scan]) -> FitOutcome {
    let data = simulate(&BlendModel::default(), &Structure::blue(), scans, 1.0, 0.01, 4).unwrap();
    fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome
}

fn statuses(outcome: &FitOutcome) -> [Status; 5] {
    outcome.parameters.each().map(|(_, estimate)| estimate.status)
}

fn scan_at(wavelengths: &[f64], omega_deg: f64) -> Vec<Scan> {
    wavelengths.iter().map(|&wavelength| Scan::angular(wavelength, omega_deg)).collect()
}

/// A status that stands for a value.
const TOLD: [Status; 4] = [Status::Ok, Status::Correlated, Status::OneSided, Status::Ambiguous];

/// Which of `d_air, d_cuticle, delta, phi_alpha, lamella_width` are told.
fn told(outcome: &FitOutcome) -> [bool; 5] {
    statuses(outcome).map(|status| TOLD.contains(&status))
}

#[test]
fn scans_across_the_ridges_tell_the_period_and_the_width() {
    let found = outcome(&scan_at(&[400.0, 420.0, 440.0, 460.0, 480.0], 0.0));
    assert_eq!(told(&found), [false, false, false, false, true]);
    assert_eq!(found.identifiability.rank, 2);
    assert_eq!(found.derived.period.status, Status::Ok);
    assert_eq!(found.derived.optical_sum.status, Status::NotIdentifiable);
    assert!(found.warnings[0].starts_with("only d_air + d_cuticle is determined"), "{:?}", found.warnings);
    let fitting = found.minima.iter().filter(|minimum| minimum.fits).count();
    assert_eq!(fitting, 1, "minima along the undetermined direction are one answer");
}

#[test]
fn one_scan_along_the_ridges_tells_the_lobe_alone() {
    let found = outcome(&scan_at(&[480.0], 90.0));
    assert_eq!(told(&found), [false, false, true, true, false]);
    assert_eq!(found.identifiability.rank, 2);
    assert_eq!((found.verdict, found.derived.period.value), (Verdict::NoThickness, None));
}

#[test]
fn scans_at_several_wavelengths_along_the_ridges_tell_all_but_the_width_up_to_the_swap_alias() {
    let found = outcome(&scan_at(&linspace(420.0, 540.0, 7), 90.0));
    assert_eq!(told(&found), [true, true, true, true, false]);
    assert_eq!(found.identifiability.rank, 4);
    // (141, 62) and (n·62, 141/n) = (97, 90): seven wavelengths inside the stop band do not tell them apart.
    assert_eq!(statuses(&found)[..2], [Status::Ambiguous, Status::Ambiguous]);
    assert_eq!(found.derived.period.status, Status::Ambiguous);
    assert_eq!(found.derived.optical_sum.status, Status::Ok);
    let near = |d_air: f64, d_cuticle: f64| {
        found.minima.iter().any(|m| (m.values[0] - d_air).abs() < 3.0 && (m.values[1] - d_cuticle).abs() < 3.0)
    };
    assert!(near(141.0, 62.0) && near(96.7, 90.4), "{:?}", found.minima);
}

#[test]
fn a_spectrum_along_the_ridges_tells_the_thicknesses_and_not_the_sign_of_the_tilt() {
    let found = outcome(&[Scan::spectrum(90.0)]);
    assert_eq!(told(&found), [true, true, statuses(&found)[2] == Status::Ambiguous, false, false]);
    assert!(found.parameters.d_air.sigma.unwrap() < 3.0);
}

#[test]
fn spectra_at_several_incidences_tell_the_thicknesses_and_the_tilt() {
    let spectrum = |theta: f64| Scan {
        name: format!("theta {theta}"),
        thetas: vec![radians(theta)],
        phis: vec![radians(-theta)],
        ..Scan::spectrum(90.0)
    };
    let found = outcome(&[0.0, 10.0, 20.0, 30.0, 40.0].map(spectrum));
    assert_eq!(told(&found), [true, true, true, false, false]);
    assert_eq!(found.identifiability.rank, 3);
}

#[test]
fn a_spectrum_and_a_scan_in_each_plane_tell_everything() {
    let found = outcome(&Scan::full_design(&BlendModel::default(), &Structure::blue()).unwrap());
    assert_eq!(statuses(&found), [Status::Ok; 5]);
    assert_eq!(found.identifiability.rank, 5);
    assert_eq!(found.verdict, Verdict::Determined);
    let condition = found.identifiability.condition.unwrap();
    assert!((100.0..500.0).contains(&condition), "the physics notes have 250: {condition}");
}

/// The swap alias of the blue preset at normal incidence, (141, 62) and (98, 89): listed and named whether it fits or not.
#[test]
fn the_swap_alias_of_one_spectrum_is_in_the_atlas_and_named() {
    for (noise, fits) in [(0.01, false), (0.08, true)] {
        let data =
            simulate(&BlendModel::default(), &Structure::blue(), &[Scan::spectrum(90.0)], 1.0, noise, 1).unwrap();
        let blue = Structure::blue();
        let settings = FitSettings::default()
            .with_role(Parameter::Delta, Role::Fixed { value: blue.delta })
            .with_role(Parameter::PhiAlpha, Role::Fixed { value: blue.phi_alpha });
        let found = fit(&data, &settings, &|_| {}).unwrap().outcome;
        let near = |d_air: f64, d_cuticle: f64| {
            let is = |m: &&MinimumFound| (m.values[0] - d_air).abs() < 5.0 && (m.values[1] - d_cuticle).abs() < 3.0;
            found.minima.iter().find(is).unwrap_or_else(|| panic!("{d_air}: {:?}", found.minima))
        };
        assert_eq!((near(141.0, 62.0).relation, near(141.0, 62.0).fits), (Relation::Best, true));
        assert_eq!((near(98.5, 89.0).relation, near(98.5, 89.0).fits), (Relation::Swap, fits));
        let weights: f64 = found.minima.iter().map(|minimum| minimum.weight).sum();
        assert!((weights - 1.0).abs() < 1e-9 && (near(98.5, 89.0).weight > 0.01) == fits, "{:?}", found.minima);
        if fits {
            let [low, high] = found.parameters.d_air.interval_95.unwrap().map(Option::unwrap);
            assert!(low < 98.5 && high > 141.0, "the interval spans both: {low} to {high}");
        }
    }
}

/// The map of chi² is lowest at the minimum and shows the valley of the optical sum.
#[test]
fn the_map_is_lowest_where_the_minimum_is() {
    let data = simulate(&BlendModel::default(), &Structure::blue(), &[Scan::spectrum(90.0)], 1.0, 0.05, 1).unwrap();
    let found = fit(&data, &FitSettings::default(), &|_| {}).unwrap();
    let map = chi_square_map(&data, &found, 28).unwrap().unwrap();
    assert_eq!((map.d_air_edges.len(), map.excess.len(), map.excess[0].len()), (29, 28, 28));
    let cell = |edges: &[f64], value: f64| edges.partition_point(|edge| *edge <= value) - 1;
    let best = found.outcome.minima[0].values;
    let at = map.excess[cell(&map.d_cuticle_edges, best[1])][cell(&map.d_air_edges, best[0])];
    let least = map.excess.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    assert!(at < 0.1 && least < 0.1, "{at} {least}");
    assert!(map.excess[27][27] > 100.0);
    let fixed = FitSettings::default().with_role(Parameter::DAir, Role::Fixed { value: 141.0 });
    let held = fit(&data, &fixed, &|_| {}).unwrap();
    assert_eq!(chi_square_map(&data, &held, 28).unwrap(), None);
}
