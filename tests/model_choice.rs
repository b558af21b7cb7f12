//! The choice among variants, on data whose maker is known.

use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{
    Extent, Fit, FitOutcome, FitSettings, ModelChoice, Nuisances, Parameter, Parts, Role, Standing, Weight, choose, fit,
};
use morpho_fit::optics::{AveragedModel, Averages, BlendModel, HybridModel, ReflectivityModel, Structure};
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;

/// Standard deviation of the noise as a share of the peak.
const NOISE: f64 = 0.01;

fn upright() -> Structure {
    Structure { delta: 0.0, ..Structure::blue() }
}

/// `scans` of `structure` with the light of `parts`, at whole planes, and a background as a share of the peak.
fn measured(structure: &Structure, scans: &[Scan], parts: Parts, background: f64, seed: u64) -> Dataset {
    let model = BlendModel::default();
    let noisy = simulate(&model, structure, scans, 1.0, NOISE, seed).unwrap();
    let plain = simulate(&model, structure, scans, 1.0, 0.0, seed).unwrap();
    let peak = plain.readings().iter().map(|reading| reading.intensity).fold(0.0, f64::max);
    let pairs = noisy.readings().iter().zip(plain.readings());
    let readings = pairs.map(|(noisy, plain)| {
        let (a, b) = parts.shares(noisy.geometry.plane_shares());
        let gone = plain.intensity * (1.0 - a - b);
        Reading { intensity: noisy.intensity - gone + background * peak, ..*noisy }
    });
    Dataset::from_readings(readings.collect(), noisy.curves().to_vec()).unwrap()
}

fn full(structure: &Structure) -> Vec<Scan> {
    Scan::full_design(&BlendModel::default(), structure).unwrap()
}

fn kept(data: &Dataset, settings: &FitSettings) -> (String, Fit) {
    kept_of(data, settings, &[])
}

fn kept_of(data: &Dataset, settings: &FitSettings, beside: &[ModelChoice]) -> (String, Fit) {
    let fit = choose(data, settings, beside, &|_| {}).unwrap().fit;
    let table = fit.outcome.choice.as_ref().unwrap();
    let kept: Vec<&str> =
        table.variants.iter().filter(|row| row.standing == Standing::Kept).map(|row| row.name.as_str()).collect();
    assert_eq!(kept.len(), 1);
    (kept[0].to_owned(), fit)
}

fn rows(fit: &Fit) -> Vec<&str> {
    fit.outcome.choice.as_ref().unwrap().variants.iter().map(|row| row.name.as_str()).collect()
}

#[test]
fn what_made_the_data_is_kept() {
    let usual = FitSettings::default();
    for (structure, parts, background, name) in [
        (Structure::blue(), Parts::Both, 0.0, "blend + tilt"),
        (Structure::blue(), Parts::Both, 0.05, "blend + tilt + background"),
        (upright(), Parts::Both, 0.0, "blend"),
        (upright(), Parts::Both, 0.05, "blend + background"),
        (Structure::blue(), Parts::Multilayer, 0.0, "multilayer + tilt"),
        (upright(), Parts::Multilayer, 0.05, "multilayer + background"),
        (Structure::blue(), Parts::Lamella, 0.05, "lamella + background"),
    ] {
        let right = (0..3_u64).filter(|&seed| {
            let data = measured(&structure, &full(&structure), parts, background, seed);
            kept(&data, &usual).0 == name
        });
        let right = right.count();
        // More than chance, less than certainty: the rates are those of `examples/model_choice.rs`.
        assert!(right >= 2, "{name}: {right} of 3");
    }
}

/// Readings between the planes see both parts: what is not there must be found missing.
#[test]
fn lamellae_that_reflect_nothing_are_left_out_between_the_planes() {
    let structure = Structure::blue();
    let model = BlendModel::default();
    let along = [Scan { phis: vec![2.0 * structure.delta], ..Scan::spectrum(90.0) }, Scan::angular(477.0, 90.0)];
    let data = simulate(&model, &structure, &along, 1.0, NOISE, 5).unwrap();
    // The multilayer alone at 45 degrees is that at 90 with half the light.
    let readings = data.readings().iter().map(|reading| {
        let mut reading = *reading;
        reading.geometry.omega = radians(45.0);
        reading
    });
    let data = Dataset::from_readings(readings.collect(), data.curves().to_vec()).unwrap();
    let (name, found) = kept(&data, &FitSettings::default());
    assert_eq!((name.as_str(), found.outcome.settings.parts), ("multilayer + tilt", Parts::Multilayer));
    let d_air = &found.outcome.parameters.d_air;
    assert!((d_air.value.unwrap() - 141.0).abs() < 4.0 * d_air.sigma.unwrap());
}

/// In whole planes the parts have no reading in common, so that one alone meets the other's readings with nothing.
#[test]
fn a_part_left_out_reflects_nothing() {
    let structure = Structure::blue();
    let data = measured(&structure, &full(&structure), Parts::Both, 0.0, 2);
    let only = |omega: f64| -> Vec<Reading> {
        data.readings()
            .iter()
            .filter(|reading| (reading.geometry.omega - radians(omega)).abs() < 0.1)
            .copied()
            .collect()
    };
    let square = |readings: &[Reading]| readings.iter().map(|r| (r.intensity / r.sigma.unwrap()).powi(2)).sum::<f64>();
    for (parts, own, other) in [(Parts::Lamella, 0.0, 90.0), (Parts::Multilayer, 90.0, 0.0)] {
        let names = vec!["spectrum".to_owned(), "scan".to_owned()];
        let readings = only(own).into_iter().map(|r| Reading { curve: r.curve % 2, ..r }).collect();
        let alone = Dataset::from_readings(readings, names).unwrap();
        let of_own = fit(&alone, &FitSettings::default(), &|_| {}).unwrap().outcome.chi2;
        let of_all = fit(&data, &FitSettings { parts, ..FitSettings::default() }, &|_| {}).unwrap().outcome.chi2;
        let expected = of_own + square(&only(other));
        assert!((of_all - expected).abs() < 1e-7 * expected, "{parts:?}: {of_all} {expected}");
    }
}

#[test]
fn what_the_user_chose_stays_in_every_variant() {
    let structure = Structure::blue();
    let data = measured(&structure, &full(&structure), Parts::Both, 0.0, 2);
    let fixed = FitSettings::default().with_role(Parameter::Delta, Role::Fixed { value: radians(2.5) });
    let (_, found) = kept(&data, &fixed);
    assert_eq!(rows(&found).len(), 6, "{:?}", rows(&found));
    assert_eq!(found.outcome.settings.roles[2], Role::Fixed { value: radians(2.5) });

    let nuisances =
        Nuisances { background: Extent::PerCurve, weight: Weight::Fixed(1.0), ..FitSettings::default().nuisances };
    let given = FitSettings { nuisances, ..FitSettings::default() };
    let (_, found) = kept(&data, &given);
    assert_eq!(rows(&found), ["blend + background", "blend + tilt + background"]);
    assert_eq!(found.outcome.settings.nuisances.background, Extent::PerCurve);

    let required = FitSettings { required: vec![Parameter::Delta], ..FitSettings::default() };
    let (_, found) = kept(&data, &required);
    assert!(rows(&found).iter().all(|name| name.starts_with("lamella") || name.contains("tilt")));
}

#[test]
fn one_plane_has_no_variants_of_the_other() {
    let model = BlendModel::default();
    let scan = |omega: f64| simulate(&model, &upright(), &[Scan::spectrum(omega)], 1.0, NOISE, 4).unwrap();
    let (_, found) = kept(&scan(0.0), &FitSettings::default());
    assert_eq!(rows(&found), ["lamella", "lamella + background"]);
    let thetas = linspace(0.0, 40.0, 5).into_iter().map(radians).collect();
    let scans =
        [Scan { thetas, phis: linspace(-40.0, 40.0, 5).into_iter().map(radians).collect(), ..Scan::spectrum(90.0) }];
    let data = simulate(&model, &upright(), &scans, 1.0, NOISE, 4).unwrap();
    let (name, found) = kept(&data, &FitSettings::default());
    let all = ["multilayer", "multilayer + background", "multilayer + tilt", "multilayer + tilt + background"];
    assert_eq!((rows(&found), name.as_str()), (all.to_vec(), "multilayer"));
}

#[test]
fn the_settings_of_the_kept_fit_make_it_again_whatever_the_threads() {
    let structure = Structure::blue();
    let bare = measured(&structure, &full(&structure), Parts::Both, 0.05, 6);
    let readings = bare.readings().iter().map(|reading| Reading { sigma: None, ..*reading }).collect();
    let without_sigma = Dataset::from_readings(readings, bare.curves().to_vec()).unwrap();
    for data in [bare, without_sigma] {
        let (name, mut found) = kept(&data, &FitSettings::default());
        assert_eq!(name, "blend + tilt + background");
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(|| kept(&data, &FitSettings::default())).1.outcome, found.outcome);
        found.outcome.choice = None;
        let again = fit(&data, &found.outcome.settings, &|_| {}).unwrap().outcome;
        assert_eq!(again, found.outcome);
        assert_eq!(again.chi2.to_bits(), found.outcome.chi2.to_bits());
    }
}

#[test]
fn settings_of_earlier_files_see_both_parts() {
    let mut json = serde_json::to_value(FitSettings::default()).unwrap();
    assert_eq!(json.as_object_mut().unwrap().remove("parts"), Some("both".into()));
    let read: FitSettings = serde_json::from_value(json).unwrap();
    assert_eq!(read, FitSettings::default());
}

/// The model that made the data is told from the other by the rule, which knows no order of the two.
#[test]
fn of_two_models_the_one_that_made_the_data_is_kept() {
    let blue = Structure::blue();
    let (blend, hybrid) = (BlendModel::default(), HybridModel::default());
    let beside = [ModelChoice::Hybrid { ridge_spacing: hybrid.ridge_spacing }];
    for (made, name) in [(&blend as &dyn ReflectivityModel, "blend + tilt"), (&hybrid, "hybrid + tilt")] {
        let data = simulate(made, &blue, &Scan::full_design(made, &blue).unwrap(), 1.0, NOISE, 11).unwrap();
        let (kept, found) = kept_of(&data, &FitSettings::default(), &beside);
        assert_eq!((kept.as_str(), rows(&found).len()), (name, 14));
        let FitOutcome { settings, parameters, .. } = &found.outcome;
        assert_eq!(settings.forward().unwrap().name(), made.name());
        let d_air = &parameters.d_air;
        assert!((d_air.value.unwrap() - blue.d_air).abs() < 4.0 * d_air.sigma.unwrap(), "{name}: {d_air:?}");
    }
}

/// A spectrum over a wide cone, or of layers that differ, and one in a plane wave, each fitted with that average on trial.
#[test]
fn averages_are_kept_where_the_data_are_averaged() {
    let blue = upright();
    let plane = BlendModel::default();
    let scans = [Scan { wavelengths: linspace(380.0, 740.0, 37), ..Scan::spectrum(90.0) }];
    let names =
        ["multilayer", "multilayer + background", "multilayer + averages", "multilayer + background + averages"];
    for averages in [
        Averages { numerical_aperture: 0.6, ..Averages::default() },
        Averages { layer_spread: 12.0, ..Averages::default() },
    ] {
        let averaged = AveragedModel::new(Box::new(BlendModel::default()), averages).unwrap();
        let settings = FitSettings { averages, ..FitSettings::default() }
            .with_role(Parameter::DAir, Role::Free { lower: 110.0, upper: 170.0 })
            .with_role(Parameter::DCuticle, Role::Free { lower: 40.0, upper: 90.0 })
            .with_role(Parameter::Delta, Role::Fixed { value: 0.0 })
            .with_role(Parameter::PhiAlpha, Role::Fixed { value: blue.phi_alpha });
        for (made, expected, averages) in
            [(&averaged as &dyn ReflectivityModel, names[2], averages), (&plane, names[0], Averages::default())]
        {
            let data = simulate(made, &blue, &scans, 1.0, 0.005, 6).unwrap();
            let (name, found) = kept(&data, &settings);
            assert_eq!((name.as_str(), rows(&found)), (expected, names.to_vec()));
            assert_eq!(found.outcome.settings.averages, averages);
            let d_air = &found.outcome.parameters.d_air;
            assert!((d_air.value.unwrap() - blue.d_air).abs() < 4.0 * d_air.sigma.unwrap(), "{name}: {d_air:?}");
        }
    }
}
