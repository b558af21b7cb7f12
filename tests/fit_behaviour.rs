//! What a fit says when the data cannot tell, when they are bad, and when its settings are unusual.

use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{
    Extent, Fit, FitError, FitSettings, ModelChoice, Nuisances, Parameter, Role, Search, SigmaSource, Status, Verdict,
    Weight, fit,
};
use morpho_fit::optics::{BlendModel, IndexTable, Material, Stack, Structure};
use morpho_fit::optimise::{Loss, Termination};
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;

fn quiet(data: &Dataset, settings: &FitSettings) -> Fit {
    fit(data, settings, &|_| {}).unwrap()
}

fn blue(noise: f64) -> Dataset {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, noise, 5).unwrap()
}

/// The same readings, changed one by one.
fn changed(data: &Dataset, change: impl Fn(usize, &mut Reading)) -> Dataset {
    let mut readings = data.readings().to_vec();
    for (index, reading) in readings.iter_mut().enumerate() {
        change(index, reading);
    }
    Dataset::from_readings(readings, data.curves().to_vec()).unwrap()
}

fn across(scale: f64) -> Dataset {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let scans: Vec<Scan> = Scan::full_design(&model, &blue).unwrap().into_iter().take(2).collect();
    simulate(&model, &blue, &scans, scale, 0.01, 3).unwrap()
}

#[test]
fn across_the_ridges_only_the_period_is_told_and_no_thickness_is_printed() {
    let found = quiet(&across(1.0), &FitSettings::default()).outcome;
    assert_eq!(found.verdict, Verdict::PartlyDetermined);
    for estimate in [&found.parameters.d_air, &found.parameters.d_cuticle] {
        assert_eq!(estimate.status, Status::NotIdentifiable);
        assert_eq!((estimate.value, estimate.sigma, estimate.interval_95), (None, None, None));
        assert!(estimate.held_at.is_some());
    }
    for estimate in [&found.parameters.delta, &found.parameters.phi_alpha] {
        assert_eq!((estimate.status, estimate.value), (Status::Insensitive, None));
    }
    let period = &found.derived.period;
    let (value, sigma) = (period.value.unwrap(), period.sigma.unwrap());
    assert!((value - 203.0).abs() < 4.0 * sigma && sigma < 1.0, "{value} ± {sigma}");
    assert_eq!(found.derived.optical_sum.value, None);
    assert!(
        found
            .warnings
            .iter()
            .any(|warning| { warning == "only d_air + d_cuticle is determined, not d_air and d_cuticle separately" }),
        "{:?}",
        found.warnings
    );
    assert_eq!(found.identifiability.rank, 2);
}

#[test]
fn a_flat_line_and_pure_noise_give_no_thickness() {
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    let data = blue(0.01);
    let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(9);
    let noise: Vec<f64> = (0..data.readings().len()).map(|_| StandardNormal.sample(&mut random)).collect();
    let flat = changed(&data, |_, reading| reading.intensity = 0.0);
    let noisy = changed(&data, |index, reading| {
        reading.intensity = noise[index];
        reading.sigma = Some(1.0);
    });
    for data in [flat, noisy] {
        let found = quiet(&data, &FitSettings::default()).outcome;
        assert!(matches!(found.verdict, Verdict::NoThickness | Verdict::NotConverged), "{:?}", found.verdict);
        for (name, estimate) in found.parameters.each() {
            assert!(!estimate.status.is_determined(), "{name}: {estimate:?}");
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let data = blue(0.01);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| quiet(&data, &FitSettings::default()))
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(format!("{one:?}"), format!("{three:?}"));
}

#[test]
fn a_scale_changes_nothing_but_the_scale() {
    let (small, large) = (across(1e-3), across(1e3));
    let periods =
        [small, large].map(|data| quiet(&data, &FitSettings::default()).outcome.derived.period.value.unwrap());
    assert!((periods[0] - periods[1]).abs() < 1e-4, "{periods:?}");
}

#[test]
fn without_sigma_the_scatter_stands_in_for_it() {
    let stated = quiet(&blue(0.01), &FitSettings::default()).outcome;
    let silent = quiet(&changed(&blue(0.01), |_, reading| reading.sigma = None), &FitSettings::default()).outcome;
    assert_eq!((stated.sigma_source, silent.sigma_source), (SigmaSource::Stated, SigmaSource::Scatter));
    let ratio = silent.parameters.d_air.sigma.unwrap() / stated.parameters.d_air.sigma.unwrap();
    // The scatter of 172 readings is known to 5 %.
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
    assert!(silent.sigma_ratio.is_none());
}

#[test]
fn a_sigma_that_is_too_small_widens_the_errors_and_is_said_first() {
    let data = changed(&blue(0.01), |_, reading| reading.sigma = reading.sigma.map(|sigma| sigma / 3.0));
    let (honest, found) =
        (quiet(&blue(0.01), &FitSettings::default()).outcome, quiet(&data, &FitSettings::default()).outcome);
    assert_eq!(found.sigma_source, SigmaSource::Widened);
    assert!(found.warnings[0].starts_with("the model misses the data by 3."), "{:?}", found.warnings);
    let ratio = found.parameters.d_air.sigma.unwrap() / honest.parameters.d_air.sigma.unwrap();
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
}

#[test]
fn residuals_far_below_the_stated_noise_widen_nothing() {
    let exact = changed(&blue(0.0), |_, reading| reading.sigma = Some(0.01));
    let found = quiet(&exact, &FitSettings::default()).outcome;
    assert_eq!((found.sigma_source, found.widened_by.to_bits()), (SigmaSource::Stated, 1.0_f64.to_bits()));
    let noisy = quiet(&blue(0.01), &FitSettings::default()).outcome;
    let ratio = found.parameters.d_air.sigma.unwrap() / noisy.parameters.d_air.sigma.unwrap();
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Three times the noise is stated, and a little more than it, and with the noise left out.
#[test]
fn a_sigma_that_is_too_large_is_said() {
    for (noise, stated, expected) in [(0.01, 0.03, Some("scatter by 0.3")), (0.01, 0.012, None), (0.0, 0.03, None)] {
        let data = changed(&blue(noise), |_, reading| reading.sigma = Some(stated));
        let found = quiet(&data, &FitSettings::default()).outcome;
        let said = found.warnings.iter().find(|warning| warning.contains("of the stated sigma"));
        assert_eq!(said.is_some(), expected.is_some(), "{noise} {stated}: {:?}", found.warnings);
        assert!(said.zip(expected).is_none_or(|(said, text)| said.contains(text)), "{said:?}");
        assert_eq!(found.verdict, Verdict::Determined);
    }
}

#[test]
fn neighbouring_residuals_that_agree_widen_the_errors_with_and_without_sigma() {
    // A slow wave of three times the noise, as a misaligned instrument adds it.
    let wave = |index: usize| 0.03 * (index as f64 / 9.0).sin();
    for stated in [true, false] {
        let data = changed(&blue(0.003), |index, reading| {
            reading.intensity += wave(index);
            reading.sigma = stated.then_some(0.02);
        });
        let found = quiet(&data, &FitSettings::default()).outcome;
        assert!(found.residual_correlation > 0.8 && found.widened_by > 3.0, "{}", found.residual_correlation);
        assert_eq!(found.sigma_source, SigmaSource::Widened);
        assert!(found.warnings[0].contains("neighbouring residuals agree"), "{:?}", found.warnings);
    }
}

#[test]
fn one_bad_reading_is_named() {
    let data = changed(&blue(0.01), |index, reading| {
        if index == 7 {
            reading.intensity = 5.0;
        }
    });
    let found = quiet(&data, &FitSettings::default()).outcome;
    let named = found.warnings.iter().any(|warning| warning.contains("reading 8") || warning.contains("line 8"));
    assert!(named, "{:?}", found.warnings);
}

#[test]
fn outliers_pull_the_plain_fit_and_not_a_robust_one() {
    let truth = Structure::blue();
    // One reading in twelve is off by thirty standard deviations.
    let data = changed(&blue(0.01), |index, reading| {
        if index % 12 == 5 {
            reading.intensity += 0.3;
        }
    });
    let error = |loss| {
        let found = quiet(&data, &FitSettings { loss, ..FitSettings::default() }).outcome;
        (found.parameters.d_air.value.or(found.parameters.d_air.held_at).unwrap() - truth.d_air).abs()
    };
    let plain = error(Loss::Linear);
    for loss in [Loss::SoftL1, Loss::Huber, Loss::Cauchy] {
        assert!(error(loss) < 1.0 && error(loss) < plain, "{loss:?}: {} for {plain}", error(loss));
    }
}

#[test]
fn fixed_and_linked_parameters_keep_their_relation() {
    let fixed = FitSettings::default().with_role(Parameter::DCuticle, Role::Fixed { value: 62.0 });
    let found = quiet(&blue(0.01), &fixed).outcome;
    assert_eq!((found.parameters.d_cuticle.status, found.parameters.d_cuticle.value), (Status::Fixed, Some(62.0)));
    assert!((found.parameters.d_air.value.unwrap() - 141.0).abs() < 1.0);
    let link = Role::Linked { other: Parameter::DAir, factor: -1.0, constant: 203.0 };
    let found = quiet(&blue(0.01), &FitSettings::default().with_role(Parameter::DCuticle, link)).outcome;
    let (d_air, d_cuticle) = (&found.parameters.d_air, &found.parameters.d_cuticle);
    assert_eq!(d_cuticle.status, Status::Linked);
    assert!((d_air.value.unwrap() + d_cuticle.value.unwrap() - 203.0).abs() < 1e-9);
    assert!((d_air.sigma.unwrap() - d_cuticle.sigma.unwrap()).abs() < 1e-9, "a link carries its uncertainty");
}

#[test]
fn a_link_carries_what_the_data_cannot_tell_and_what_it_fixes() {
    // Across the ridges d_air and d_cuticle enter as their sum, which the link makes a constant.
    let link = Role::Linked { other: Parameter::DAir, factor: -1.0, constant: 203.0 };
    let found = quiet(&across(1.0), &FitSettings::default().with_role(Parameter::DCuticle, link)).outcome;
    for estimate in [&found.parameters.d_air, &found.parameters.d_cuticle] {
        assert_eq!((estimate.value, estimate.sigma), (None, None), "{estimate:?}");
    }
    assert_eq!((found.derived.period.status, found.derived.period.sigma), (Status::Fixed, None));
    // What follows a fixed parameter is as fixed.
    let fixed = FitSettings::default()
        .with_role(Parameter::DAir, Role::Fixed { value: 141.0 })
        .with_role(Parameter::DCuticle, link);
    let d_cuticle = quiet(&blue(0.01), &fixed).outcome.parameters.d_cuticle;
    assert_eq!((d_cuticle.status, d_cuticle.value, d_cuticle.sigma), (Status::Fixed, Some(62.0), None));
}

#[test]
fn a_thickness_at_its_bound_is_no_missing_thickness() {
    let settings = FitSettings::default()
        .with_role(Parameter::DCuticle, Role::Fixed { value: 62.0 })
        .with_role(Parameter::DAir, Role::Free { lower: 50.0, upper: 139.0 });
    let found = quiet(&blue(0.01), &settings).outcome;
    assert_eq!((found.verdict, found.parameters.d_air.status), (Verdict::PartlyDetermined, Status::AtBound));
}

/// Where every angle is 0 a tilt on its bound says nothing of signs.
#[test]
fn signs_are_asked_about_only_where_there_are_any() {
    let tilted = Structure { delta: radians(5.0), ..Structure::blue() };
    let nuisances = Nuisances { scale: Extent::None, ..Nuisances::default() };
    let settings = FitSettings { nuisances, ..FitSettings::default() }
        .with_role(Parameter::PhiAlpha, Role::Fixed { value: tilted.phi_alpha })
        .with_role(Parameter::Delta, Role::Free { lower: radians(-1.0), upper: radians(1.0) });
    let spectrum = || Scan::spectrum(90.0);
    for (scans, asked) in [(vec![spectrum()], false), (vec![spectrum(), Scan::angular(470.0, 90.0)], true)] {
        let data = simulate(&BlendModel::default(), &tilted, &scans, 1.0, 0.01, 1).unwrap();
        let found = quiet(&data, &settings).outcome;
        assert_eq!(found.parameters.delta.status, Status::AtBound);
        let hint = found.warnings.iter().any(|warning| warning.contains("the other way round"));
        assert_eq!(hint, asked, "{:?}", found.warnings);
    }
}

/// The minimum lies on the edge of the lobe, along which no step finds an end: it was reported as none.
#[test]
fn a_minimum_on_a_kink_is_one() {
    let delta = radians(2.950_528_305_599_594_3);
    let (d_air, d_cuticle, lamella_width) = (104.681_356_790_100_38, 148.270_416_437_266_22, 308.772_638_924_993_95);
    let truth = Structure { d_air, d_cuticle, delta, phi_alpha: 0.407_519_093_743_043_24, lamella_width };
    let scans = [Scan::spectrum(90.0), Scan::angular(400.0, 45.0)];
    let data = simulate(&BlendModel::default(), &truth, &scans, 1.0, 0.01, 54).unwrap();
    let found = quiet(&data, &FitSettings::default()).outcome;
    assert_eq!((found.verdict, found.termination), (Verdict::Determined, Termination::Kink));
    let off = (found.parameters.d_air.value.unwrap() - d_air).abs();
    assert!(off < 3.0 * found.parameters.d_air.sigma.unwrap(), "{off}");
}

#[test]
fn one_direction_without_a_scale_is_warned_of() {
    let nuisances = Nuisances { scale: Extent::None, ..Nuisances::default() };
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.01, 1).unwrap();
    let found = quiet(&data, &FitSettings { nuisances, ..FitSettings::default() }).outcome;
    assert!(found.warnings.iter().any(|warning| warning.contains("acts as a scale, although")), "{:?}", found.warnings);
}

#[test]
fn each_curve_may_have_its_own_scale_and_background() {
    let data = changed(&blue(0.003), |_, reading| {
        let (scale, background) = [(1.0, 0.1), (50.0, 0.0), (0.02, 0.3), (7.0, 2.0)][reading.curve];
        reading.intensity = scale * reading.intensity + background;
        reading.sigma = reading.sigma.map(|sigma| scale * sigma);
    });
    let nuisances = Nuisances { scale: Extent::PerCurve, weight: Weight::Fitted, background: Extent::PerCurve };
    let found = quiet(&data, &FitSettings { nuisances, ..FitSettings::default() }).outcome;
    for (estimate, truth) in [(&found.parameters.d_air, 141.0), (&found.parameters.d_cuticle, 62.0)] {
        let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
        assert!((value - truth).abs() < 4.0 * sigma, "{value} ± {sigma} for {truth}");
    }
    let of = |name: &str| found.nuisance.iter().find(|nuisance| nuisance.name.starts_with(name)).unwrap();
    assert!((of("scale of").value - 0.02).abs() < 0.002, "{:?}", found.nuisance);
    assert!(found.nuisance.iter().filter(|nuisance| nuisance.name.starts_with("background of")).count() == 4);
}

#[test]
fn a_film_over_a_gap_on_a_plate_is_the_same_program() {
    // One film with dispersion over an air gap on glass, absolute reflectance at normal incidence.
    let film =
        Material::Table(IndexTable::new(vec![[400.0, 2.46, 0.0], [500.0, 2.43, 0.0], [900.0, 2.39, 0.0]]).unwrap());
    let stack = Stack { cuticle: film, base: Material::constant(1.52), layers: 1, ..Stack::default() };
    let model = BlendModel { stack: stack.clone() };
    let truth = Structure { d_air: 60.0, d_cuticle: 287.0, delta: 0.0, ..Structure::table1() };
    let scan = Scan { wavelengths: linspace(400.0, 850.0, 226), ..Scan::spectrum(90.0) };
    let data = simulate(&model, &truth, &[scan], 1.0, 0.01, 2).unwrap();
    let nuisances = Nuisances { scale: Extent::None, ..Nuisances::default() };
    let settings = FitSettings { stack, nuisances, ..FitSettings::default() }
        .with_role(Parameter::DAir, Role::Free { lower: 0.0, upper: 200.0 })
        .with_role(Parameter::DCuticle, Role::Free { lower: 200.0, upper: 400.0 })
        .with_role(Parameter::Delta, Role::Fixed { value: 0.0 });
    let found = quiet(&data, &settings).outcome;
    assert!(!found.warnings.iter().any(|warning| warning.contains("acts as a scale")), "{:?}", found.warnings);
    for (estimate, truth) in [(&found.parameters.d_air, 60.0), (&found.parameters.d_cuticle, 287.0)] {
        let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
        assert!((value - truth).abs() < 4.0 * sigma && sigma < 2.0, "{value} ± {sigma} for {truth}");
    }
}

#[test]
fn the_paper_model_ends_where_its_printed_law_has_no_ray() {
    let model = ModelChoice::Paper {
        snell: morpho_fit::optics::Snell::Printed,
        admittance: morpho_fit::optics::Admittance::Mean,
        lamella_unit: morpho_fit::optics::LamellaUnit::Peak,
    };
    let steep = Scan { thetas: vec![radians(60.0)], phis: vec![radians(-60.0)], ..Scan::spectrum(90.0) };
    let data = simulate(&BlendModel::default(), &Structure::blue(), &[steep], 1.0, 0.01, 1).unwrap();
    let outcome = fit(&data, &FitSettings { model, ..FitSettings::default() }, &|_| {});
    assert_eq!(outcome.unwrap_err(), FitError::NowhereFinite { model: "paper" });
}

#[test]
fn fewer_readings_than_unknowns_are_refused() {
    let few = blue(0.01).readings()[..5].to_vec();
    let data = Dataset::from_readings(few, blue(0.01).curves()[..1].to_vec()).unwrap();
    assert!(matches!(fit(&data, &FitSettings::default(), &|_| {}), Err(FitError::TooFewReadings { readings: 5, .. })));
}

#[test]
fn intensities_whose_squares_overflow_are_refused() {
    for size in [1e200, 1e-200] {
        let data = changed(&blue(0.01), |_, reading| {
            reading.intensity *= size;
            reading.sigma = Some(size);
        });
        assert!(matches!(fit(&data, &FitSettings::default(), &|_| {}), Err(FitError::Unit { .. })));
    }
}

#[test]
fn a_local_search_stays_where_it_began() {
    // One spectrum along the ridges: the swap alias is a minimum of its own.
    let (model, structure) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &structure, &[Scan::spectrum(90.0)], 1.0, 0.01, 5).unwrap();
    let mut settings = FitSettings::default().with_role(Parameter::Delta, Role::Fixed { value: structure.delta });
    for (parameter, value) in [(Parameter::PhiAlpha, 0.5), (Parameter::LamellaWidth, 300.0)] {
        settings = settings.with_role(parameter, Role::Fixed { value });
    }
    let local =
        FitSettings { search: Search::Local, start: [Some(98.0), Some(89.0), None, None, None], ..settings.clone() };
    let (near, global) = (quiet(&data, &local).outcome, quiet(&data, &settings).outcome);
    assert!(global.chi2 < near.chi2, "the swap alias is a local minimum");
    assert_eq!(near.minima.len(), 1);
    let found = near.minima[0].values;
    assert!((found[0] - 98.0).abs() < 10.0 && (found[1] - 89.0).abs() < 10.0, "{found:?}");
}

/// One curve of four with 1.7 times its noise: the chi² of all hides it, its own does not.
#[test]
fn one_curve_beyond_its_noise_is_named_and_widens_the_intervals() {
    let data = blue(0.01);
    let loud = changed(&data, |index, reading| {
        if reading.curve == 0 {
            // No pattern that neighbours share: + + - + - - and so on, from the golden ratio.
            let sign = if (0.618_033_988_749_895 * (index + 1) as f64).fract() < 0.5 { 1.0 } else { -1.0 };
            reading.intensity += 1.4 * sign * reading.sigma.unwrap();
        }
    });
    let (quiet_one, found) =
        (quiet(&data, &FitSettings::default()).outcome, quiet(&loud, &FitSettings::default()).outcome);
    assert_eq!(quiet_one.sigma_source, SigmaSource::Stated);
    let named = format!("the model misses the data in curve {}", data.curves()[0]);
    assert!(found.warnings[0].starts_with(&named), "{:?}", found.warnings);
    assert_eq!(found.sigma_source, SigmaSource::Widened);
    // The chi² of all readings alone would not have been flagged: 3.7 deviations of 166 degrees of freedom are 239.
    assert!(found.chi2 < 239.0 && found.widened_by > 1.0, "{} {}", found.chi2, found.widened_by);
}

#[test]
fn settings_that_cannot_be_are_named() {
    let bounds = FitSettings::default().with_role(Parameter::DAir, Role::Free { lower: 200.0, upper: 100.0 });
    assert_eq!(
        bounds.validate().unwrap_err().to_string(),
        "bounds of d_air: 200 to 100 nm must rise and lie within 0 to 1000000 nm"
    );
    let twice = FitSettings::default()
        .with_role(Parameter::DAir, Role::Linked { other: Parameter::DCuticle, factor: 1.0, constant: 0.0 })
        .with_role(Parameter::DCuticle, Role::Linked { other: Parameter::DAir, factor: 1.0, constant: 0.0 });
    assert_eq!(
        twice.validate().unwrap_err().to_string(),
        "d_air cannot be linked to d_cuticle, which is itself linked"
    );
}
