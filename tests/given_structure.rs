//! A structure that is known from elsewhere, beside the data: nothing is free.

use approx::assert_relative_eq;
use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{
    Extent, FitOutcome, FitSettings, Nuisances, Role, SigmaSource, Status, Verdict, Weight, fit,
};
use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
use morpho_fit::report::wording::verdict;
use morpho_fit::synthetic::{Scan, simulate};
use morpho_fit::units::radians;

fn given(data: &Dataset, d_air: f64, scale: Extent) -> FitOutcome {
    let values = [d_air, 62.0, radians(2.5), 0.5, 300.0];
    let nuisances = Nuisances { scale, weight: Weight::Fixed(1.0), ..Nuisances::default() };
    let settings =
        FitSettings { roles: values.map(|value| Role::Fixed { value }), nuisances, ..FitSettings::default() };
    fit(data, &settings, &|_| {}).unwrap().outcome
}

fn measured() -> Dataset {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.01, 7).unwrap()
}

/// chi² is that of the model's own values.
#[test]
fn it_is_judged_and_not_fitted() {
    let data = measured();
    let (true_one, other) = (given(&data, 141.0, Extent::None), given(&data, 150.0, Extent::None));
    let square = |reading: &Reading| {
        let model = BlendModel::default();
        let value = model.reflectivity(&Structure::blue(), &reading.geometry, reading.polarization, reading.wavelength);
        ((reading.intensity - value.unwrap()) / reading.sigma.unwrap()).powi(2)
    };
    assert_relative_eq!(true_one.chi2, data.readings().iter().map(square).sum::<f64>(), max_relative = 1e-9);
    assert_eq!((true_one.verdict, true_one.dof, true_one.warnings.len()), (Verdict::Given, data.readings().len(), 0));
    assert_eq!(verdict(&true_one), "nothing was free; the given structure is not contradicted by the data");
    assert_eq!((other.verdict, other.sigma_source), (Verdict::Given, SigmaSource::Widened));
    assert_eq!(verdict(&other), "nothing was free; the given structure misses the data");
    assert!(other.warnings[0].starts_with("the given structure misses the data by"), "{:?}", other.warnings);
    assert!(true_one.advice.is_empty() && true_one.covariance.names.is_empty());
}

/// It stays what it was, however little of the data it explains, and by how much it misses is told.
#[test]
fn a_structure_that_explains_nothing_keeps_its_sums() {
    let bright = measured().readings().iter().map(|reading| Reading { intensity: 5.0, ..*reading }).collect();
    let data = Dataset::from_readings(bright, measured().curves().to_vec()).unwrap();
    let found = given(&data, 141.0, Extent::Shared);
    assert_eq!(found.derived.period.status, Status::Fixed);
    assert_eq!(found.derived.period.value, Some(203.0));
    let told = |start: &str| found.warnings.iter().any(|warning| warning.starts_with(start));
    assert!(told("a constant describes the data better than the given structure"), "{:?}", found.warnings);
    assert!(told("the given structure misses the data by"), "{:?}", found.warnings);
}
