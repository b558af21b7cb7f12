//! Few readings of layers with a narrow lobe: many structures fit alike, and intervals hold those that do.

use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{FitOutcome, FitSettings, Search, Status, fit, values};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

const SETS: u64 = 200;
/// Of chi²: what fits so much worse than the best fits as well (`--level`).
const LEVEL: f64 = 9.0;

/// A spectrum by 20 or 40 nm and a scan by 5 or 10° along the ridges, for half of the sets one across them; noise of 0.5 to 10 %
/// that is not stated.
fn few(random: &mut Xoshiro256PlusPlus, seed: u64) -> (Structure, Dataset) {
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    let truth = Structure {
        d_air: between(50.0, 220.0),
        d_cuticle: between(35.0, 150.0),
        delta: radians(between(5.0, 9.9)) * if between(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 },
        phi_alpha: between(0.105, 0.2),
        lamella_width: between(150.0, 500.0),
    };
    let noise = 10.0_f64.powf(between(-2.3, -1.0));
    let line = between(410.0, 560.0).round();
    let [coarse, wide, across] = [0, 1, 2].map(|_| between(0.0, 1.0) < 0.5);
    let phis = linspace(-60.0, 60.0, if wide { 13 } else { 25 }).into_iter().map(radians).collect();
    let spectrum = Scan { wavelengths: linspace(380.0, 740.0, if coarse { 10 } else { 19 }), ..Scan::spectrum(90.0) };
    let mut scans = vec![spectrum, Scan { phis, ..Scan::angular(line, 90.0) }];
    scans.extend(across.then(|| Scan::angular(470.0, 0.0)));
    let data = simulate(&BlendModel::default(), &truth, &scans, 3.0, noise, seed).unwrap();
    let readings = data.readings().iter().map(|reading| Reading { sigma: None, ..*reading }).collect();
    (truth, Dataset::from_readings(readings, data.curves().to_vec()).unwrap())
}

/// Half widths of an interval by which the farthest of what `outcome` tells leaves out `truth`.
fn left_out(outcome: &FitOutcome, truth: &Structure) -> f64 {
    let [d_air, d_cuticle, delta, phi_alpha, width] = values(truth);
    let truths = [d_air, d_cuticle, delta.to_degrees(), phi_alpha, width, d_air + d_cuticle, d_air + 1.56 * d_cuticle];
    let sums = [&outcome.derived.period, &outcome.derived.optical_sum];
    let estimates = outcome.parameters.each().map(|(_, estimate)| estimate).into_iter().chain(sums);
    let of = |(estimate, truth): (&morpho_fit::inversion::Estimate, f64)| {
        let (Some(value), Some([low, high])) = (estimate.value, estimate.interval_95) else { return 0.0 };
        let half = match (low, high) {
            _ if estimate.status == Status::Fixed => return 0.0,
            (Some(low), Some(high)) => 0.5 * (high - low),
            (Some(end), None) | (None, Some(end)) => (value - end).abs(),
            (None, None) => return 0.0,
        };
        low.map_or(0.0, |low| low - truth).max(high.map_or(0.0, |high| truth - high)).max(0.0) / half
    };
    estimates.zip(truths).map(of).fold(0.0, f64::max)
}

/// The truth is known, and so is the minimum next to it: where that fits as well as what was found, or better, intervals should hold
/// the truth. Of these 200 sets 15 left it out by 1.5 half widths of an interval and more as one look at the grid has it.
#[test]
fn a_structure_that_fits_as_well_is_not_left_out() {
    let missed: u32 = (0..SETS)
        .into_par_iter()
        .map(|seed| {
            let (truth, data) = few(&mut Xoshiro256PlusPlus::seed_from_u64(seed), seed);
            let found = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
            let from_truth =
                FitSettings { search: Search::Local, start: values(&truth).map(Some), ..FitSettings::default() };
            let near = fit(&data, &from_truth, &|_| {}).unwrap().outcome;
            #[allow(clippy::cast_precision_loss, reason = "a count of readings")]
            let variance = near.chi2.min(found.chi2) / near.dof as f64;
            let is_rival = (near.chi2 - found.chi2) / variance < LEVEL;
            let off = left_out(&found, &truth);
            if is_rival && off > 1.5 {
                println!("{seed}: left out by {off}, chi² {} and {} next to the truth", found.chi2, near.chi2);
            }
            u32::from(is_rival && off > 1.5)
        })
        .sum();
    println!("{missed} of {SETS}");
    assert!(missed <= 7, "{missed} of {SETS}");
}
