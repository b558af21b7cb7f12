//! What each design of measurement can tell (the table of the physics notes): the blue preset, 1 % noise.

use morpho_fit::inversion::{FitOutcome, FitSettings, Status, Verdict, fit};
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
    assert_eq!(found.derived.period.status, Status::Ok);
    assert_eq!(found.derived.optical_sum.status, Status::NotIdentifiable);
    assert!(found.warnings[0].starts_with("only d_air + d_cuticle is determined"), "{:?}", found.warnings);
    assert_eq!(found.minima.len(), 1, "minima along the undetermined direction are one answer");
}

#[test]
fn one_scan_along_the_ridges_tells_the_lobe_alone() {
    let found = outcome(&scan_at(&[480.0], 90.0));
    assert_eq!(told(&found), [false, false, true, true, false]);
    assert_eq!((found.verdict, found.derived.period.value), (Verdict::NoThickness, None));
}

#[test]
fn scans_at_several_wavelengths_along_the_ridges_tell_all_but_the_width_up_to_the_swap_alias() {
    let found = outcome(&scan_at(&linspace(420.0, 540.0, 7), 90.0));
    assert_eq!(told(&found), [true, true, true, true, false]);
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
}

#[test]
fn a_spectrum_and_a_scan_in_each_plane_tell_everything() {
    let found = outcome(&Scan::full_design(&BlendModel::default(), &Structure::blue()).unwrap());
    assert_eq!(statuses(&found), [Status::Ok; 5]);
    assert_eq!(found.verdict, Verdict::Determined);
    let condition = found.identifiability.condition.unwrap();
    assert!((100.0..500.0).contains(&condition), "the physics notes have 250: {condition}");
}
