//! Constants of the model fitted beside the parameters: against the covariance of all unknowns together, and against truths.

use morpho_fit::dataset::Dataset;
use morpho_fit::geometry::Polarization;
use morpho_fit::inversion::intervals::{ConstantProfile, over_constant};
use morpho_fit::inversion::{Constant, FitError, FitSettings, Objective, Parameter};
use morpho_fit::optics::{AveragedModel, Averages, BlendModel, Material, ReflectivityModel, Stack, Structure};
use morpho_fit::optimise::Loss;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use nalgebra::{DMatrix, DVector};

/// Readings across and along the ridges, with 1 % noise.
fn measured(model: &dyn ReflectivityModel, seed: u64) -> Dataset {
    let scan = |omega: f64| Scan {
        name: format!("omega {omega}"),
        wavelengths: linspace(420.0, 660.0, 9),
        thetas: vec![0.0],
        phis: linspace(-40_f64.to_radians(), 40_f64.to_radians(), 21),
        omegas: vec![omega.to_radians()],
        polarization: Polarization::Unpolarized,
    };
    simulate(model, &Structure::blue(), &[scan(20.0), scan(75.0)], 1.0, 0.01, seed).unwrap()
}

fn with_cuticle(n: f64, k: f64) -> BlendModel {
    BlendModel { stack: Stack { cuticle: Material::Constant { n, k }, ..Stack::default() } }
}

fn within(found: &ConstantProfile, truth: f64) -> bool {
    let [low, high] = found.intervals.interval_95;
    low.is_none_or(|low| low < truth) && high.is_none_or(|high| truth < high)
}

/// The residuals' derivatives by a constant and the five parameters give the covariance of all six; Gauss and Newton's is that
/// of the profile where the problem is as good as linear, as it is for so much data.
#[test]
fn intervals_are_those_of_all_unknowns_together() {
    let data = measured(&with_cuticle(1.56, 0.0), 3);
    let (settings, constant) = (FitSettings::default(), Constant::NCuticle);
    let found = over_constant(&data, &settings, constant, [1.4, 1.75], &|_| {}).unwrap();
    let point: Vec<f64> = found.fit.outcome.minima[0].values.to_vec();
    let inside: Vec<f64> =
        Parameter::ALL.iter().zip(&point).map(|(parameter, value)| parameter.inside(*value)).collect();
    let at = |value: f64| {
        let settings = constant.set(&settings, value).unwrap();
        Objective::new(&data, &settings).unwrap()
    };
    let step = 1e-5;
    let own: DVector<f64> = (at(found.best + step).residuals(&inside).unwrap()
        - at(found.best - step).residuals(&inside).unwrap())
        / (2.0 * step);
    let five = at(found.best).jacobian(&inside).unwrap();
    let all = DMatrix::from_fn(own.len(), 6, |i, j| if j == 5 { own[i] } else { five[(i, j)] });
    let covariance = (all.transpose() * &all).try_inverse().unwrap();
    let half = |[low, high]: [Option<f64>; 2]| 0.5 * (high.unwrap() - low.unwrap());
    let sigma = covariance[(5, 5)].sqrt();
    assert!((half(found.intervals.interval_68) / sigma - 1.0).abs() < 0.03, "{:?} {sigma}", found.intervals);
    for (place, parameter) in Parameter::ALL.into_iter().enumerate() {
        let quantity = found.quantities.iter().find(|quantity| quantity.name == parameter.name()).unwrap();
        let sigma = parameter.outside(covariance[(place, place)].sqrt());
        let ours = half(quantity.intervals.interval_68);
        assert!((ours / sigma - 1.0).abs() < 0.05, "{parameter}: {ours} {sigma}");
    }
    // The thicknesses pay for the index, the tilt does not.
    let widened = |name: &str| {
        let quantity = found.quantities.iter().find(|quantity| quantity.name == name).unwrap();
        half(quantity.intervals.interval_68) / quantity.sigma_known
    };
    assert!(widened("d_cuticle") > 2.0 && widened("delta") < 1.05);
}

#[test]
fn truths_lie_within_their_intervals() {
    let spread = Averages { period_spread: 6.0, ..Averages::default() };
    let spread = AveragedModel::new(Box::new(BlendModel::default()), spread).unwrap();
    let settings = FitSettings::default();
    let cases: [(&dyn ReflectivityModel, Constant, f64, [f64; 2]); 2] = [
        (&with_cuticle(1.56, 0.04), Constant::KCuticle, 0.04, [0.0, 0.12]),
        (&spread, Constant::PeriodSpread, 6.0, [0.0, 15.0]),
    ];
    for (model, constant, truth, limits) in cases {
        let found = over_constant(&measured(model, 3), &settings, constant, limits, &|_| {}).unwrap();
        assert!(within(&found, truth) && !found.at_end, "{constant}: {:?}", found.intervals);
        assert!((found.best - truth).abs() < 0.05 * (limits[1] - limits[0]), "{constant} {}", found.best);
        for (name, truth) in [("d_air", 141.0), ("d_cuticle", 62.0), ("lamella_width", 300.0)] {
            let quantity = found.quantities.iter().find(|quantity| quantity.name == name).unwrap();
            let [low, high] = quantity.intervals.interval_95.map(Option::unwrap);
            let room = 0.6 * (high - low);
            assert!((quantity.value - truth).abs() < room, "{constant}: {name} {quantity:?}");
        }
    }
}

/// Of 60 seeds 43 and 55 lie within the intervals of 68.3 and 95 %, as do 55 of the air gaps within theirs (binomial: 41 ± 3.6
/// and 57 ± 1.7); here are eight.
#[test]
fn intervals_hold_the_index_as_often_as_they_say() {
    let (settings, model) = (FitSettings::default(), with_cuticle(1.52, 0.0));
    let found: Vec<ConstantProfile> = (0..8)
        .map(|seed| {
            over_constant(&measured(&model, seed), &settings, Constant::NCuticle, [1.4, 1.75], &|_| {}).unwrap()
        })
        .collect();
    assert!(found.iter().all(|found| found.intervals.interval_95.iter().all(Option::is_some)));
    let held = found.iter().filter(|found| within(found, 1.52)).count();
    assert!(held >= 6, "{held} of 8"); // fewer has a probability of 0.6 %
}

#[test]
fn a_constant_at_zero_closes_the_other_intervals_and_a_range_beside_the_truth_is_told() {
    let (data, settings) = (measured(&BlendModel::default(), 9), FitSettings::default());
    let none = over_constant(&data, &settings, Constant::KCuticle, [0.0, 0.1], &|_| {}).unwrap();
    assert!(none.intervals.interval_95[1].unwrap() < 0.01 && within(&none, 0.0));
    assert!(!none.at_end); // k ends at 0 of itself
    assert!(none.quantities.iter().all(|quantity| quantity.intervals.interval_95.iter().all(Option::is_some)));
    let beside = over_constant(&data, &settings, Constant::NCuticle, [1.6, 1.7], &|_| {}).unwrap();
    assert!(beside.at_end && (beside.best - 1.6).abs() < 1e-3, "{}", beside.best);
}

/// Outliers, which move the index of least squares by two standard deviations, leave that of a robust loss where it was.
#[test]
fn a_robust_loss_has_its_own_profile() {
    let clean = measured(&with_cuticle(1.52, 0.0), 3);
    let mut readings = clean.readings().to_vec();
    for (row, reading) in readings.iter_mut().enumerate() {
        if row % 23 == 5 {
            reading.intensity += 0.5;
        }
    }
    let spoilt = Dataset::from_readings(readings, clean.curves().to_vec()).unwrap();
    let moved = |loss: Loss| {
        let settings = FitSettings { loss, ..FitSettings::default() };
        let [clean, spoilt] = [&clean, &spoilt].map(|data| {
            let found = over_constant(data, &settings, Constant::NCuticle, [1.4, 1.75], &|_| {}).unwrap();
            assert!(found.excess.iter().all(|excess| *excess > -0.01));
            found.best
        });
        (spoilt - clean).abs()
    };
    let (robust, plain) = (moved(Loss::Cauchy), moved(Loss::Linear));
    assert!(robust < 0.003 && plain > 0.02, "{robust} {plain}");
}

/// A range beside the truth moves thicknesses, not the tilt: its interval stays.
#[test]
fn what_does_not_move_with_the_constant_is_not_open() {
    let (data, settings) = (measured(&BlendModel::default(), 9), FitSettings::default());
    let beside = over_constant(&data, &settings, Constant::NCuticle, [1.6, 1.62], &|_| {}).unwrap();
    let quantity = |name: &str| beside.quantities.iter().find(|quantity| quantity.name == name).unwrap();
    assert!(quantity("delta").intervals.interval_68.iter().all(Option::is_some));
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let (data, settings) = (measured(&BlendModel::default(), 9), FitSettings::default());
    let refused = |constant, limits| over_constant(&data, &settings, constant, limits, &|_| {}).unwrap_err();
    assert!(matches!(refused(Constant::RidgeSpacing, [500.0, 900.0]), FitError::NoConstant { .. }));
    assert!(matches!(refused(Constant::NCuticle, [1.6, 1.5]), FitError::ConstantRange { .. }));
    assert!(matches!(refused(Constant::NCuticle, [f64::NAN, 1.5]), FitError::ConstantRange { .. }));
    assert!(matches!(refused(Constant::NumericalAperture, [0.0, 1.4]), FitError::ConstantRange { .. }));
    assert!(matches!(refused(Constant::Filling, [1.0, 3.0]), FitError::ConstantRange { .. }));
}
