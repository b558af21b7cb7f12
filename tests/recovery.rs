//! Known structures, simulated with noise, must come back: the global minimum, and truths inside the stated errors.

use morpho_fit::inversion::{FitOutcome, FitSettings, Parameter, Verdict, fit, structure, values};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::optimise::Bounds;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;
use rayon::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Truths drawn over the whole default box.
const TRUTHS: usize = 1000;

fn truths(count: usize, seed: u64) -> Vec<Structure> {
    let (lower, upper): (Vec<f64>, Vec<f64>) =
        Parameter::ALL.iter().map(|parameter| parameter.default_bounds()).unzip();
    let points = Bounds::new(&lower, &upper).unwrap().latin_hypercube(count, seed);
    points.iter().map(|point| structure(&[point[0], point[1], point[2], point[3], point[4]])).collect()
}

/// chi² of the truth with the best non-negative nuisances: that of a fit in which everything is fixed at it.
fn chi2_of(truth: &Structure, data: &morpho_fit::dataset::Dataset) -> f64 {
    let values = values(truth);
    let roles = Parameter::ALL.map(|p| morpho_fit::inversion::Role::Fixed { value: values[p.index()] });
    fit(data, &FitSettings { roles, ..FitSettings::default() }, &|_| {}).unwrap().outcome.chi2
}

struct Case {
    truth: Structure,
    outcome: FitOutcome,
    chi2_truth: f64,
}

fn cases(count: usize) -> Vec<Case> {
    let model = BlendModel::default();
    truths(count, 11)
        .into_par_iter()
        .enumerate()
        .map(|(case, truth)| {
            let data =
                simulate(&model, &truth, &Scan::full_design(&model, &truth).unwrap(), 1.0, 0.01, case as u64).unwrap();
            let outcome = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
            Case { truth, chi2_truth: chi2_of(&truth, &data), outcome }
        })
        .collect()
}

#[test]
fn the_full_design_recovers_what_it_determines() {
    let cases = cases(TRUTHS);
    let missed: Vec<_> = cases.iter().filter(|case| case.outcome.chi2 > case.chi2_truth * (1.0 + 1e-9)).collect();
    for case in &missed {
        println!("missed: {:?} {} for {}", case.truth, case.outcome.chi2, case.chi2_truth);
    }
    let mut counts = [[0; 4]; 5];
    for case in &cases {
        let truth = values(&case.truth);
        for (j, (_, estimate)) in case.outcome.parameters.each().into_iter().enumerate() {
            let Some((value, sigma)) = estimate.value.zip(estimate.sigma).filter(|_| estimate.status.is_determined())
            else {
                counts[j][3] += 1;
                continue;
            };
            counts[j][0] += 1;
            let off = (value - Parameter::ALL[j].outside(truth[j])).abs() / sigma;
            counts[j][1] += usize::from(off <= 3.0);
            counts[j][2] += usize::from(off <= 1.0);
            if off > 3.0 {
                println!("{} off {off:.1} sigma {sigma:.3}: {:?} {:?}", Parameter::ALL[j], case.truth, estimate);
            }
        }
    }
    println!("identified, within 3 sigma, within 1 sigma, not identified: {counts:?}");
    let verdicts = |verdict| cases.iter().filter(|case| case.outcome.verdict == verdict).count();
    println!(
        "determined {} partly {} not converged {}",
        verdicts(Verdict::Determined),
        verdicts(Verdict::PartlyDetermined),
        verdicts(Verdict::NotConverged)
    );
    assert!(missed.len() <= TRUTHS * 5 / 1000, "{} of {TRUTHS} global minima missed", missed.len());
    assert!(verdicts(Verdict::NotConverged) <= TRUTHS * 5 / 1000);
    for (j, [identified, within, ..]) in counts.iter().enumerate() {
        // The design tells most of the box: a program that calls nothing determined must not pass.
        assert!(identified * 100 >= TRUTHS * 80, "{}: {identified} of {TRUTHS}", Parameter::ALL[j]);
        assert!(within * 100 >= identified * 99, "{}: {within} of {identified}", Parameter::ALL[j]);
    }
}

#[test]
fn scans_of_any_length_are_searched_as_well() {
    // 320 wavelengths by 9 angles: thinning by a fixed stride of 9 would keep one angle of them all.
    let (model, truth) =
        (BlendModel::default(), Structure { d_air: 200.0, d_cuticle: 150.0, delta: 0.0, ..Structure::table1() });
    for angles in [7, 8, 9, 15] {
        let scan = Scan {
            wavelengths: linspace(400.0, 719.0, 320),
            phis: linspace(-60.0, 60.0, angles).into_iter().map(radians).collect(),
            ..Scan::spectrum(90.0)
        };
        let data = simulate(&model, &truth, &[scan], 1.0, 0.01, 4).unwrap();
        let found = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
        let truth_chi2 = chi2_of(&truth, &data);
        assert!(found.chi2 <= truth_chi2, "{angles} angles: {} for {truth_chi2}", found.chi2);
    }
}
