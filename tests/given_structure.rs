//! A structure that is known from elsewhere, beside the data: nothing is free.

use approx::assert_relative_eq;
use morpho_fit::dataset::Reading;
use morpho_fit::inversion::{Extent, FitSettings, Nuisances, Role, SigmaSource, Verdict, Weight, fit};
use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
use morpho_fit::synthetic::{Scan, simulate};
use morpho_fit::units::radians;

/// A structure from elsewhere beside the data: chi² by the model's own values, and a verdict that claims no fit.
#[test]
fn a_given_structure_is_judged_and_not_fitted() {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.01, 7).unwrap();
    let at = |d_air: f64| {
        let values = [d_air, 62.0, radians(2.5), 0.5, 300.0];
        let nuisances = Nuisances { scale: Extent::None, weight: Weight::Fixed(1.0), ..Nuisances::default() };
        let settings =
            FitSettings { roles: values.map(|value| Role::Fixed { value }), nuisances, ..FitSettings::default() };
        fit(&data, &settings, &|_| {}).unwrap().outcome
    };
    let (given, other) = (at(141.0), at(150.0));
    let square = |reading: &Reading| {
        let value = model.reflectivity(&blue, &reading.geometry, reading.polarization, reading.wavelength);
        ((reading.intensity - value.unwrap()) / reading.sigma.unwrap()).powi(2)
    };
    assert_relative_eq!(given.chi2, data.readings().iter().map(square).sum::<f64>(), max_relative = 1e-9);
    assert_eq!((given.verdict, given.dof, given.warnings.len()), (Verdict::Given, data.readings().len(), 0));
    assert_eq!((other.verdict, other.sigma_source), (Verdict::Given, SigmaSource::Widened));
    assert!(other.warnings[0].starts_with("the given structure misses the data by"), "{:?}", other.warnings);
}
