//! Profile, bootstrap and posterior of whole fits: against closed forms of a linear problem, against each other, and at
//! the edges.

use morpho_fit::dataset::Dataset;
use morpho_fit::inversion::intervals::{
    Bootstrap, BootstrapSettings, Method, PosteriorSettings, Resampling, bootstrap, compare, posterior, profiles,
};
use morpho_fit::inversion::{Extent, Fit, FitError, FitSettings, Nuisances, Parameter, Role, fit};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, simulate};

fn quiet(_: &str) {}

fn full(noise: f64, seed: u64) -> Dataset {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, noise, seed).unwrap()
}

fn fitted(data: &Dataset) -> Fit {
    fit(data, &FitSettings::default(), &quiet).unwrap()
}

fn close(found: Option<f64>, expected: Option<f64>, tolerance: f64, what: &str) {
    let (found, expected) = (found.unwrap(), expected.unwrap());
    assert!((found - expected).abs() < tolerance, "{what}: {found} for {expected}, allowed {tolerance}");
}

/// With little noise the model is linear over an interval, so that all methods have the covariance's closed form.
#[test]
fn all_methods_agree_where_the_problem_is_linear() {
    let data = full(0.002, 3);
    let found = fitted(&data);
    let profiles = profiles(&data, &found, &quiet).unwrap();
    let residuals = bootstrap(&data, &found, &BootstrapSettings::new(Resampling::Residuals, 1), &quiet).unwrap();
    let posterior = posterior(&data, &found, &PosteriorSettings::new(1), &quiet).unwrap();
    assert!(posterior.converged && residuals.failed == 0 && profiles.lower.is_none());
    let found = compare(&found, Some(&profiles), std::slice::from_ref(&residuals), Some(&posterior));
    assert_eq!(found.quantities.len(), 7);
    for quantity in &found.quantities {
        let methods: Vec<Method> = quantity.methods.iter().map(|method| method.method).collect();
        assert_eq!(methods, [Method::Covariance, Method::Profile, Method::BootstrapResiduals, Method::Posterior]);
        let first = &quantity.methods[0];
        let sigma = first.sigma.unwrap();
        // Of 4000 effective samples an end is known to 0.025 and 0.04 sigma: four of these. The bootstrap knows the noise by the
        // residuals of one curve, of 37 readings or more: to 12 % of the distance of an end, four of these.
        for (method, tolerance) in quantity.methods[1..].iter().zip([0.03, 0.48, 0.1]) {
            let what = format!("{} by {:?}", quantity.name, method.method);
            for side in 0..2 {
                let (ours, theirs) = (method.intervals.interval_68[side], first.intervals.interval_68[side]);
                close(ours, theirs, tolerance * sigma, &what);
                let (ours, theirs) = (method.intervals.interval_95[side], first.intervals.interval_95[side]);
                close(ours, theirs, 1.96 * tolerance * sigma, &what);
            }
        }
    }
}

/// Every point of a profile is what a fit with the quantity fixed finds.
#[test]
fn a_profile_is_the_fit_with_the_parameter_fixed() {
    let data = full(0.01, 5);
    let found = fitted(&data);
    let profiles = profiles(&data, &found, &quiet).unwrap();
    let profile = profiles.quantities.iter().find(|profile| profile.name == "d_cuticle").unwrap();
    for at in [0, profile.values.len() / 3, profile.values.len() - 1] {
        let role = Role::Fixed { value: profile.values[at] };
        let settings = FitSettings::default().with_role(Parameter::DCuticle, role);
        let held = fit(&data, &settings, &quiet).unwrap();
        let excess = held.outcome.chi2 - found.outcome.chi2;
        assert!((excess - profile.excess[at]).abs() < 1e-3, "{excess} for {}", profile.excess[at]);
    }
    // The period is held by a link of the two thicknesses.
    let period = profiles.quantities.iter().find(|profile| profile.name == "period").unwrap();
    for (value, parameters) in period.values.iter().zip(&period.parameters) {
        assert!((parameters[0] + parameters[1] - value).abs() < 1e-9);
    }
}

/// What the data do not tell keeps its whole range: open ends of the profile, an even posterior.
#[test]
fn what_is_not_determined_stays_open() {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.01, 2).unwrap();
    let settings = FitSettings::default()
        .with_role(Parameter::Delta, Role::Fixed { value: blue.delta })
        .with_role(Parameter::PhiAlpha, Role::Fixed { value: blue.phi_alpha });
    let found = fit(&data, &settings, &quiet).unwrap();
    let profiles = profiles(&data, &found, &quiet).unwrap();
    let width = profiles.quantities.iter().find(|profile| profile.name == "lamella_width").unwrap();
    assert_eq!(width.intervals.interval_68, [None, None]);
    assert_eq!(width.intervals.interval_95, [None, None]);
    let posterior = posterior(&data, &found, &PosteriorSettings::new(1), &quiet).unwrap();
    let column = posterior.names.iter().position(|name| *name == "lamella_width").unwrap();
    let [low, high] = posterior.intervals[column].interval_95.map(Option::unwrap);
    // An even distribution over 100 to 600 nm: 112.5 and 587.5.
    assert!((low - 112.5).abs() < 12.0 && (high - 587.5).abs() < 12.0, "{low} {high}");
}

/// A parameter pressed to its bound: closed on the inner side, open at the bound.
#[test]
fn an_interval_is_open_at_a_bound() {
    let data = full(0.01, 6);
    let settings = FitSettings::default().with_role(Parameter::DAir, Role::Free { lower: 20.0, upper: 140.9 });
    let found = fit(&data, &settings, &quiet).unwrap();
    let profiles = profiles(&data, &found, &quiet).unwrap();
    let profile = profiles.quantities.iter().find(|profile| profile.name == "d_air").unwrap();
    let [low, high] = profile.intervals.interval_95;
    assert!(low.is_some_and(|low| low > 139.0 && low < 140.9) && high.is_none(), "{low:?} {high:?}");
}

/// Two aliases that fit: the posterior sits on both, with the weights of their depths.
#[test]
fn the_posterior_visits_the_swap_alias() {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.08, 1).unwrap();
    let settings = FitSettings::default()
        .with_role(Parameter::Delta, Role::Fixed { value: blue.delta })
        .with_role(Parameter::PhiAlpha, Role::Fixed { value: blue.phi_alpha })
        .with_role(Parameter::LamellaWidth, Role::Fixed { value: blue.lamella_width });
    let found = fit(&data, &settings, &quiet).unwrap();
    let posterior = posterior(&data, &found, &PosteriorSettings::new(1), &quiet).unwrap();
    assert!(posterior.converged);
    let column = posterior.names.iter().position(|name| *name == "d_air").unwrap();
    let share = |low: f64, high: f64| {
        posterior.samples.iter().filter(|row| (low..high).contains(&row[column])).count() as f64
            / posterior.samples.len() as f64
    };
    // By the sum over a fine grid of exp(-chi²/2) with the scale at its best.
    let grid = grid_share(&data, &blue);
    assert!((share(119.0, 300.0) - grid).abs() < 0.04, "{} for {grid}", share(119.0, 300.0));
    assert!(share(80.0, 119.0) > 0.05);
}

/// Share of the posterior with `d_air` above 119 nm, by brute force.
fn grid_share(data: &Dataset, blue: &Structure) -> f64 {
    use morpho_fit::optics::ReflectivityModel;
    let model = BlendModel::default();
    let mut sums = [0.0, 0.0];
    let mut logs = Vec::new();
    for i in 0..180 {
        for j in 0..160 {
            let (d_air, d_cuticle) = (70.0 + 0.5 * f64::from(i), 50.0 + 0.375 * f64::from(j));
            let structure = Structure { d_air, d_cuticle, ..*blue };
            let (mut mm, mut my, mut yy) = (0.0, 0.0, 0.0);
            for reading in data.readings() {
                let value = model
                    .reflectivity(&structure, &reading.geometry, reading.polarization, reading.wavelength)
                    .unwrap();
                let weight = reading.sigma.unwrap().powi(-2);
                mm += weight * value * value;
                my += weight * value * reading.intensity;
                yy += weight * reading.intensity * reading.intensity;
            }
            logs.push((d_air, -0.5 * (yy - my * my / mm)));
        }
    }
    let most = logs.iter().map(|log| log.1).fold(f64::NEG_INFINITY, f64::max);
    for (d_air, log) in logs {
        sums[usize::from(d_air >= 119.0)] += (log - most).exp();
    }
    sums[1] / (sums[0] + sums[1])
}

#[test]
fn the_same_seed_gives_the_same_samples_on_any_number_of_threads() {
    let data = full(0.01, 7);
    let found = fitted(&data);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let settings = BootstrapSettings { replicates: 120, ..BootstrapSettings::new(Resampling::Cases, 4) };
            let sampling = PosteriorSettings { effective: 300, ..PosteriorSettings::new(4) };
            (
                bootstrap(&data, &found, &settings, &quiet).unwrap(),
                posterior(&data, &found, &sampling, &quiet).unwrap(),
                profiles(&data, &found, &quiet).unwrap(),
            )
        })
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one.0, two.0);
    assert_eq!(one.1, two.1);
    assert_eq!(one.2, two.2);
}

/// Without sigma the scatter takes its place: Student's t in profile and covariance, sigma integrated over in the posterior.
#[test]
fn the_methods_agree_without_a_stated_sigma() {
    let readings =
        full(0.01, 8).readings().iter().map(|r| morpho_fit::dataset::Reading { sigma: None, ..*r }).collect();
    let data = Dataset::from_readings(readings, full(0.01, 8).curves().to_vec()).unwrap();
    let found = fitted(&data);
    let profiles = profiles(&data, &found, &quiet).unwrap();
    let posterior = posterior(&data, &found, &PosteriorSettings::new(2), &quiet).unwrap();
    let table = compare(&found, Some(&profiles), &[], Some(&posterior));
    for quantity in &table.quantities {
        assert!(quantity.methods.iter().all(|method| !method.parts()), "{quantity:?}");
    }
}

/// A background that is not there lies at its bound 0; the posterior of the structure knows it cannot be negative.
#[test]
fn a_background_at_zero_does_not_disturb() {
    let data = full(0.01, 9);
    let nuisances = Nuisances { background: Extent::Shared, ..Nuisances::default() };
    let found = fit(&data, &FitSettings { nuisances, ..FitSettings::default() }, &quiet).unwrap();
    let posterior = posterior(&data, &found, &PosteriorSettings::new(3), &quiet).unwrap();
    assert!(posterior.converged);
    let table = compare(&found, None, &[], Some(&posterior));
    let width = table.quantities.iter().find(|quantity| quantity.name == "d_air").unwrap();
    assert!(!width.methods[1].parts(), "{width:?}");
}

#[test]
fn other_data_are_refused() {
    let found = fitted(&full(0.01, 1));
    let other = simulate(&BlendModel::default(), &Structure::blue(), &[Scan::spectrum(90.0)], 1.0, 0.01, 1).unwrap();
    let refused = FitError::OtherData { readings: 37, fitted: 172 };
    assert_eq!(profiles(&other, &found, &quiet).unwrap_err(), refused);
    assert_eq!(posterior(&other, &found, &PosteriorSettings::new(1), &quiet).unwrap_err(), refused);
    let settings = BootstrapSettings::new(Resampling::Cases, 1);
    assert_eq!(bootstrap(&other, &found, &settings, &quiet).unwrap_err(), refused);
}

/// Cases and residuals of well-specified data: spreads that agree with the covariance within what 172 readings allow.
#[test]
fn the_bootstrap_of_cases_has_the_right_size() {
    let data = full(0.01, 12);
    let found = fitted(&data);
    let settings = BootstrapSettings { replicates: 400, ..BootstrapSettings::new(Resampling::Cases, 2) };
    let cases: Bootstrap = bootstrap(&data, &found, &settings, &quiet).unwrap();
    assert_eq!((cases.replicates.len(), cases.failed, cases.block), (400, 0, 1));
    let table = compare(&found, None, std::slice::from_ref(&cases), None);
    for quantity in &table.quantities {
        let ratio = quantity.methods[1].sigma.unwrap() / quantity.methods[0].sigma.unwrap();
        assert!((0.4..2.5).contains(&ratio), "{}: {ratio}", quantity.name);
    }
}

/// A spectrum at normal incidence is even in the tilt: the derivative vanishes at no tilt, and yet the thicknesses depend
/// on it by its cosine. They must not be called surer than that.
#[test]
fn a_tilt_that_the_data_are_even_in_is_in_the_intervals_of_the_others() {
    let (model, blue) = (BlendModel::default(), Structure { delta: 8.0_f64.to_radians(), ..Structure::blue() });
    let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.01, 4).unwrap();
    let found = fitted(&data).outcome;
    for (estimate, truth) in [
        (&found.derived.optical_sum, 141.0 + 1.56 * 62.0),
        (&found.derived.period, 203.0),
        (&found.parameters.d_air, 141.0),
    ] {
        let [low, high] = estimate.interval_95.unwrap();
        assert!(low.is_none_or(|low| low < truth) && high.is_none_or(|high| truth < high), "{truth}: {estimate:?}");
    }
}

/// Under a robust loss profile and posterior of clean data are those of least squares, and the bootstrap is refused.
#[test]
fn a_robust_loss_does_not_bend_the_intervals_of_clean_data() {
    let data = full(0.01, 5);
    let settings = FitSettings { loss: morpho_fit::optimise::Loss::Huber, ..FitSettings::default() };
    let found = fit(&data, &settings, &quiet).unwrap();
    let profiles = profiles(&data, &found, &quiet).unwrap();
    assert!(profiles.lower.is_none());
    let posterior = posterior(&data, &found, &PosteriorSettings::new(1), &quiet).unwrap();
    let table = compare(&found, Some(&profiles), &[], Some(&posterior));
    for quantity in &table.quantities {
        assert!(quantity.methods.iter().all(|method| !method.parts()), "{quantity:?}");
    }
    let settings = BootstrapSettings::new(Resampling::Cases, 1);
    assert_eq!(bootstrap(&data, &found, &settings, &quiet).unwrap_err(), FitError::RobustBootstrap);
}

/// A period that cannot be held, because a third parameter follows the cuticle, has no profile; the others have theirs.
#[test]
fn a_sum_that_a_link_depends_on_is_left_out() {
    let data = full(0.01, 5);
    let role = Role::Linked { other: Parameter::DCuticle, factor: 5.0, constant: -10.0 };
    let found = fit(&data, &FitSettings::default().with_role(Parameter::LamellaWidth, role), &quiet).unwrap();
    let names: Vec<&str> = profiles(&data, &found, &quiet).unwrap().quantities.iter().map(|one| one.name).collect();
    assert!(names.contains(&"d_air") && names.contains(&"d_cuticle") && !names.contains(&"period"), "{names:?}");
}
