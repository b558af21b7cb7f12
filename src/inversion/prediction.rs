//! The fitted model at readings that need not be of the data.

use crate::dataset::{Dataset, Reading};
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::FitError;
use crate::inversion::outcome::Fit;
use crate::inversion::plan::Plan;
use crate::inversion::problem::Problem;

/// The fitted model at a reading, in the unit of the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// The sum of the three.
    pub model: f64,
    /// Model A's part, with scale and weight.
    pub lamella: f64,
    /// Model B's part, with its scale; of the `hybrid` model the whole product.
    pub multilayer: f64,
    /// The background.
    pub background: f64,
}

/// The model of `fit`, which is of `data`, at `readings`: each in a curve of `data`, whose scale and background it has.
///
/// Intensity, sigma and line of `readings` are not looked at.
///
/// # Errors
/// [`FitError::OtherData`] if `data` are not those of the fit, [`FitError::NoCurve`] for a reading of no curve of theirs,
/// [`FitError::NoScale`] for one in a plane whose scale or weight the data do not tell, and [`FitError::Optics`] or
/// [`FitError::NotFinite`] where the model has no value.
///
/// ```
/// use morpho_fit::dataset::Reading;
/// use morpho_fit::inversion::{FitSettings, fit, predict};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, blue) = (BlendModel::default(), Structure::blue());
/// let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.01, 7)?;
/// let found = fit(&data, &FitSettings::default(), &|_| {})?;
/// // Between two readings that are 10 nm apart.
/// let between = Reading { wavelength: 455.0, ..data.readings()[0] };
/// let [low, high] = [7, 8].map(|row| found.readings[row].model);
/// let there = predict(&data, &found, &[between])?[0].model;
/// assert!(there > low.min(high) && there < low.max(high));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn predict(data: &Dataset, fit: &Fit, readings: &[Reading]) -> Result<Vec<Predicted>, FitError> {
    let settings = &fit.outcome.settings;
    let model = settings.forward()?;
    let compiled = Compiled::of_fit(data, fit, model.as_ref())?;
    let curves = compiled.plan.curves;
    if let Some(reading) = readings.iter().find(|reading| reading.curve >= curves) {
        return Err(FitError::NoCurve { curve: reading.curve, curves });
    }
    let nowhere = || FitError::NotFinite { model: compiled.plan.model_name() };
    let solution = &fit.solution;
    let point = Problem::new(&compiled, &solution.space, &solution.robust)
        .evaluate(&solution.best.parameters)
        .ok_or_else(nowhere)?;
    let plan = Plan::of_readings(readings, model.as_ref(), settings.parts, curves)?;
    let terms = plan.terms(&point.values);
    let predicted = plan.readings().iter().map(|reading| {
        let (on_a, on_b, background) =
            compiled.linear.factors_anywhere(&settings.nuisances, &compiled.plan, reading.curve, &point.coefficients);
        let (a, b) = plan.parts(reading, terms.view());
        let scaled = |part: f64, share: f64, factor: Option<f64>| match factor {
            _ if share <= 0.0 => Ok(0.0),
            Some(factor) => Ok(factor * part),
            None => Err(FitError::NoScale { curve: reading.curve }),
        };
        let (lamella, multilayer) = (scaled(a, reading.share_a, on_a)?, scaled(b, reading.share_b, on_b)?);
        let model = lamella + multilayer + background;
        if model.is_finite() { Ok(Predicted { model, lamella, multilayer, background }) } else { Err(nowhere()) }
    });
    predicted.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Geometry;
    use crate::inversion::fit::fit;
    use crate::inversion::nuisance::{Extent, Nuisances, Weight};
    use crate::inversion::outcome::FittedReading;
    use crate::inversion::parameter::{Parameter, Role};
    use crate::inversion::settings::{FitSettings, ModelChoice, Search};
    use crate::optics::{BlendModel, ReflectivityModel, Structure};
    use crate::optimise::Loss;
    use crate::synthetic::{Scan, simulate};

    fn blue() -> Dataset {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 3.0, 0.02, 3).unwrap()
    }

    /// At the data it is what the fit has, whatever curve has whatever scale.
    #[test]
    fn at_the_data_it_is_the_fit() {
        let data = blue();
        let nuisances = Nuisances { scale: Extent::PerCurve, background: Extent::PerCurve, ..Nuisances::default() };
        for settings in [
            FitSettings { nuisances, search: Search::Local, ..FitSettings::default() },
            FitSettings { loss: Loss::Cauchy, search: Search::Local, ..FitSettings::default() },
            FitSettings {
                model: ModelChoice::Hybrid { ridge_spacing: 750.0 },
                search: Search::Local,
                ..FitSettings::default()
            },
        ] {
            let found = fit(&data, &settings, &|_| {}).unwrap();
            let mut backwards = data.readings().to_vec();
            backwards.reverse();
            let mut predicted = predict(&data, &found, &backwards).unwrap();
            predicted.reverse();
            for (row, own) in found.readings.iter().zip(predicted) {
                let FittedReading { model, lamella, multilayer, background, .. } = *row;
                assert_eq!(own, Predicted { model, lamella, multilayer, background });
            }
        }
    }

    /// In whatever plane a reading of whatever curve lies: three times the model, or nothing tells its scale.
    #[test]
    fn a_scale_holds_in_every_plane_that_tells_it() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let scans = Scan::full_design(&model, &blue).unwrap();
        let truth = crate::inversion::values(&blue);
        let roles = Parameter::ALL.map(|parameter| Role::Fixed { value: truth[parameter.index()] });
        // The curves, which of them are measured across the ridges, and whether the scale of the other plane is known.
        for (scans, across, scale, weight, elsewhere) in [
            (&scans[..], &[true, true, false, false][..], Extent::Shared, Weight::Fitted, true),
            (&scans[..], &[true, true, false, false], Extent::Shared, Weight::Fixed(1.0), true),
            (&scans[..], &[true, true, false, false], Extent::PerCurve, Weight::Fixed(1.0), true),
            (&scans[..], &[true, true, false, false], Extent::PerCurve, Weight::Fitted, false),
            (&scans[2..], &[false, false], Extent::Shared, Weight::Fitted, false),
            (&scans[..2], &[true, true], Extent::Shared, Weight::Fitted, false),
        ] {
            let data = simulate(&model, &blue, scans, 3.0, 0.0, 3).unwrap();
            let nuisances = Nuisances { scale, weight, background: Extent::None };
            let found = fit(&data, &FitSettings { roles, nuisances, ..FitSettings::default() }, &|_| {}).unwrap();
            for (curve, &is_across) in across.iter().enumerate() {
                for omega in [0.0_f64, 45.0, 90.0] {
                    let mut reading = Reading { curve, wavelength: 455.0, ..data.readings()[0] };
                    reading.geometry = Geometry { theta: 0.0, phi: 0.0, omega: omega.to_radians() };
                    let Reading { geometry, polarization, wavelength, .. } = reading;
                    let own = if is_across { 0.0 } else { 90.0 };
                    let predicted = predict(&data, &found, &[reading]);
                    if elsewhere || (omega - own).abs() < 1.0 {
                        let expected = 3.0 * model.reflectivity(&blue, &geometry, polarization, wavelength).unwrap();
                        let model = predicted.unwrap()[0].model;
                        assert!((model - expected).abs() < 1e-9, "{nuisances:?} {curve} {omega}: {model} {expected}");
                    } else {
                        assert_eq!(predicted, Err(FitError::NoScale { curve }), "{nuisances:?} {omega}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_has_no_model_is_an_error() {
        let data = blue();
        let found = fit(&data, &FitSettings { search: Search::Local, ..FitSettings::default() }, &|_| {}).unwrap();
        let first = data.readings()[0];
        assert!(predict(&data, &found, &[]).unwrap().is_empty());
        let elsewhere = Reading { curve: 4, ..first };
        assert_eq!(predict(&data, &found, &[elsewhere]), Err(FitError::NoCurve { curve: 4, curves: 4 }));
        let mut tilted = first;
        tilted.geometry.theta = f64::NAN;
        for without in [tilted, Reading { wavelength: f64::NAN, ..first }] {
            assert!(predict(&data, &found, &[without]).is_err(), "{without:?}");
        }
        let other = Dataset::from_readings(vec![first], vec!["one".to_owned()]).unwrap();
        assert_eq!(
            predict(&other, &found, &[first]),
            Err(FitError::OtherData { readings: 1, fitted: data.readings().len() })
        );
    }
}
