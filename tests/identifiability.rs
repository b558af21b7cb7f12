//! What each design of measurement can tell (the table of the physics notes): the blue preset, 1 % noise.

use morpho_fit::inversion::{FitOutcome, FitSettings, Status, fit};
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

#[test]
fn tmp_print() {
    let spectra: Vec<Scan> = [0.0, 10.0, 20.0, 30.0, 40.0].iter().map(|&theta| Scan {
        name: format!("theta {theta}"), thetas: vec![radians(theta)], phis: vec![radians(-theta)], ..Scan::spectrum(90.0)
    }).collect();
    for (name, scans) in [
        ("phi scans w0", scan_at(&[400.0, 420.0, 440.0, 460.0, 480.0], 0.0)),
        ("phi scan one, w90", scan_at(&[480.0], 90.0)),
        ("phi scans several w90", scan_at(&linspace(420.0, 540.0, 7), 90.0)),
        ("spectrum w90", vec![Scan::spectrum(90.0)]),
        ("spectra thetas", spectra),
        ("full", Scan::full_design(&BlendModel::default(), &Structure::blue()).unwrap()),
    ] {
        let o = outcome(&scans);
        println!("== {name}: {:?} rank {} cond {:?}\n {:?}\n {:?}", o.verdict, o.identifiability.rank, o.identifiability.condition, statuses(&o), o.warnings);
        println!(" {:?} period {:?} opt {:?}", o.parameters.each().map(|(_, e)| (e.value, e.sigma)), (o.derived.period.value,o.derived.period.sigma), (o.derived.optical_sum.value, o.derived.optical_sum.sigma));
        println!(" minima {:?}", o.minima.iter().map(|m| (m.chi2, m.values)).collect::<Vec<_>>());
    }
}
