//! Structures at or beyond the bounds of the search: what depends on the bound is not told as if it did not.

use morpho_fit::inversion::{Estimate, FitOutcome, FitSettings, Parameter, Status, fit, values};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, simulate};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// The lower bound of `d_cuticle`, nm.
const BOUND: f64 = 20.0;

fn found(truth: &Structure, scans: &[Scan], noise: f64, seed: u64) -> FitOutcome {
    let data = simulate(&BlendModel::default(), truth, scans, 3.0, noise, seed).unwrap();
    fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome
}

/// The truth is known, and lies beyond a bound: of what is told all the same, little may be off by four standard deviations. As the
/// covariance at the bound has it, 20 of 85 are.
#[test]
fn what_moves_with_a_value_on_a_bound_is_not_told() {
    let (mut told, mut off, mut moving) = (0, 0, 0);
    for seed in 0..40 {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut between = |low: f64, high: f64| random.random_range(low..high);
        let truth = Structure {
            d_air: between(60.0, 200.0),
            d_cuticle: between(10.0, 18.0),
            delta: between(-0.14, 0.14),
            phi_alpha: between(0.15, 0.8),
            lamella_width: between(150.0, 480.0),
        };
        let scans = Scan::full_design(&BlendModel::default(), &truth).unwrap();
        let outcome = found(&truth, &scans, 0.07, seed);
        for ((estimate, truth), parameter) in
            outcome.parameters.each().into_iter().zip(values(&truth)).zip(Parameter::ALL)
        {
            let Estimate { value: Some(value), sigma, status, with, .. } = estimate.1 else { continue };
            moving += u32::from(*status == Status::AtBound && !with.is_empty());
            assert!(*status != Status::AtBound || sigma.is_none() && estimate.1.interval_95.is_none(), "{estimate:?}");
            if parameter != Parameter::DCuticle && status.is_determined() {
                let deviations = (parameter.inside(*value) - truth).abs() / parameter.inside(sigma.unwrap());
                println!("{seed}: {} {value} is {deviations} deviations off", estimate.0);
                (told, off) = (told + 1, off + u32::from(deviations > 4.0));
            }
        }
    }
    println!("{off} of {told} are off, {moving} move with a bound");
    assert!(told > 40 && moving > 10 && off * 20 <= told, "{off} of {told}, {moving}");
}

/// The truth lies just inside. Where noise drives the value onto the bound, chi² rises slowly from there: `d_cuticle` is told on one
/// side, and `d_air`, which moves with it, no better than where the value stays inside.
#[test]
fn a_bound_that_costs_nothing_is_no_knowledge() {
    let truth = Structure { d_cuticle: BOUND + 0.3, ..Structure::blue() };
    let (mut on_bound, mut held, mut driven) = ([0, 0], [0, 0], 0);
    for seed in 0..100 {
        let outcome = found(&truth, &[Scan::spectrum(90.0)], 0.03, seed);
        let [d_air, d_cuticle] = [&outcome.parameters.d_air, &outcome.parameters.d_cuticle];
        let on = d_cuticle.value.is_some_and(|value| value <= BOUND);
        if on && d_cuticle.status == Status::AtBound {
            driven += 1;
            continue;
        }
        if on {
            assert_eq!(d_cuticle.status, Status::OneSided, "{d_cuticle:?}");
            assert!(matches!(d_cuticle.interval_95, Some([None, Some(_)])), "{d_cuticle:?}");
        }
        if let Some([low, high]) = d_air.interval_95 {
            let holds = low.is_none_or(|low| low <= truth.d_air) && high.is_none_or(|high| truth.d_air <= high);
            on_bound[usize::from(on)] += 1;
            held[usize::from(on)] += u32::from(holds);
        }
    }
    println!("held {held:?} of {on_bound:?}, {driven} driven onto it");
    // Noise of two standard deviations asks for more.
    assert!(driven <= 6, "{driven}");
    assert!(on_bound[1] > 20 && f64::from(held[1]) > 0.9 * f64::from(on_bound[1]), "{held:?} of {on_bound:?}");
}
