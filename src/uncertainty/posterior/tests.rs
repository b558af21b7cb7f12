//! The sampler on densities whose moments are known.

use super::*;
use rayon::ThreadPoolBuilder;

/// Deviations that a moment may be off its closed form, in Monte-Carlo standard errors: chance exceeds it once in 16,000.
const SIGMAS: f64 = 4.0;

fn wanting(effective: f64) -> SamplerSettings {
    SamplerSettings { effective, seed: 5, ..SamplerSettings::default() }
}

fn mode(centre: &[f64], deviations: &[f64], log_weight: f64) -> Mode {
    let variances = DVector::from_iterator(deviations.len(), deviations.iter().map(|sd| sd * sd));
    Mode { centre: DVector::from_column_slice(centre), covariance: DMatrix::from_diagonal(&variances), log_weight }
}

/// Mean and its standard error of a function of the samples.
fn mean(found: &Posterior, of: impl Fn(&[f64]) -> f64) -> (f64, f64) {
    let values: Vec<f64> = found.samples.row_iter().map(|row| of(&row.iter().copied().collect::<Vec<_>>())).collect();
    let length = values.len() / found.chains;
    let convergence = Convergence::of(&values.chunks(length).collect::<Vec<_>>()).unwrap();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // Of a rare event the ranks are ties, whose effective size is no worse a guess than that of the tails.
    (mean, (variance / convergence.bulk.min(convergence.tail)).sqrt())
}

fn assert_mean(found: &Posterior, expected: f64, of: impl Fn(&[f64]) -> f64) {
    let (mean, error) = mean(found, of);
    assert!((mean - expected).abs() < SIGMAS * error, "{mean} ± {error}, not {expected}");
}

/// Covariance with deviations 1, 10, 0.1, 1, 100 and correlation 0.9^|i - j|, whose inverse is in closed form.
fn correlated() -> DMatrix<f64> {
    let deviations = [1.0, 10.0, 0.1, 1.0, 100.0];
    DMatrix::from_fn(5, 5, |i, j| deviations[i] * deviations[j] * 0.9_f64.powf(i.abs_diff(j) as f64))
}

#[test]
fn a_correlated_normal_in_five_dimensions_has_its_moments_at_little_cost() {
    let covariance = correlated();
    let precision = covariance.clone().try_inverse().unwrap();
    let centre = DVector::from_vec(vec![1.0, -20.0, 0.3, 0.0, 1000.0]);
    let bounds = Bounds::new(&[-1e4; 5], &[1e4; 5]).unwrap();
    let target = |x: &DVector<f64>| -0.5 * ((x - &centre).transpose() * &precision * (x - &centre))[0];
    let modes = [Mode { centre: centre.clone(), covariance: covariance.clone(), log_weight: 0.0 }];
    let found = sample(target, &bounds, &modes, &wanting(4000.0), &|_| {}).unwrap();
    assert_eq!(found.stopped, Stopped::Converged);
    for i in 0..5 {
        assert_mean(&found, centre[i], |x| x[i]);
        for j in 0..=i {
            let unit = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
            assert_mean(&found, covariance[(i, j)] / unit, |x| (x[i] - centre[i]) * (x[j] - centre[j]) / unit);
        }
    }
    // Measured over ten seeds: 0.60 and 0.42.
    let effective = found.effective().unwrap();
    assert!(effective / (found.evaluations - found.warm_up_evaluations) as f64 > 0.5);
    assert!(effective / found.evaluations as f64 > 0.3);
}

#[test]
fn a_normal_cut_by_the_box_is_the_truncated_normal() {
    // Of N(0, 1) above 1: mean m = phi(1)/Q(1), variance 1 + m - m².
    let hazard = 0.241_970_724_519_143_37 / 0.158_655_253_931_457_05;
    let bounds = Bounds::new(&[1.0, -10.0], &[f64::INFINITY, 10.0]).unwrap();
    let found =
        sample(|x| -0.5 * x.norm_squared(), &bounds, &[mode(&[0.0; 2], &[1.0; 2], 0.0)], &wanting(4000.0), &|_| {});
    let found = found.unwrap();
    assert_eq!(found.stopped, Stopped::Converged);
    assert_mean(&found, hazard, |x| x[0]);
    assert_mean(&found, 1.0 + hazard - hazard * hazard, |x| (x[0] - hazard).powi(2));
    assert_mean(&found, 0.0, |x| x[1]);
    assert!(found.samples.column(0).min() >= 1.0);
}

#[test]
fn two_modes_get_their_weights_whatever_was_said_of_them() {
    // 0.8 N(0, 1) + 0.2 N(30, 0.25) in each of three dimensions; 26 standard deviations apart.
    let log = |x: &DVector<f64>, centre: f64, sd: f64, weight: f64| {
        weight.ln() - 3.0 * sd.ln() - 0.5 * x.iter().map(|v| ((v - centre) / sd).powi(2)).sum::<f64>()
    };
    let target = |x: &DVector<f64>| {
        let (a, b) = (log(x, 0.0, 1.0, 0.8), log(x, 30.0, 0.5, 0.2));
        a.max(b) + (-(a - b).abs()).exp().ln_1p()
    };
    let bounds = Bounds::new(&[-100.0; 3], &[100.0; 3]).unwrap();
    for wrong in [-20.0, 0.0, 20.0] {
        let modes = [mode(&[0.0; 3], &[1.5; 3], wrong), mode(&[30.0; 3], &[0.4; 3], 0.0)];
        let found = sample(target, &bounds, &modes, &wanting(2000.0), &|_| {}).unwrap();
        assert_eq!(found.stopped, Stopped::Converged);
        assert_mean(&found, 6.0, |x| x[0]);
        assert_mean(&found, 0.2, |x| f64::from(u8::from(x[0] > 15.0)));
    }
}

#[test]
fn a_banana_has_its_moments_from_one_poor_normal() {
    // x ~ N(0, 1), y | x ~ N(x² - 1, 0.25): E y = 0, var y = 2 + 0.25, E x² y = 2.
    let target = |p: &DVector<f64>| -0.5 * (p[0] * p[0] + ((p[1] - p[0] * p[0] + 1.0) / 0.5).powi(2));
    let bounds = Bounds::none(2);
    let found = sample(target, &bounds, &[mode(&[0.5, -0.75], &[0.3, 0.6], 0.0)], &wanting(4000.0), &|_| {}).unwrap();
    assert_eq!(found.stopped, Stopped::Converged);
    assert_mean(&found, 0.0, |p| p[0]);
    assert_mean(&found, 1.0, |p| p[0] * p[0]);
    assert_mean(&found, 0.0, |p| p[1]);
    assert_mean(&found, 2.25, |p| p[1] * p[1]);
    assert_mean(&found, 2.0, |p| p[0] * p[0] * p[1]);
}

#[test]
fn samples_repeat_whatever_the_number_of_threads() {
    let target = |x: &DVector<f64>| -0.5 * x.norm_squared() - 0.1 * x[0].powi(4);
    let modes = [mode(&[0.0; 3], &[1.0; 3], 0.0)];
    let with = |threads: usize, seed: u64| {
        let settings = SamplerSettings { seed, ..wanting(1000.0) };
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sample(target, &Bounds::none(3), &modes, &settings, &|_| {})).unwrap()
    };
    let one = with(1, 5);
    assert_eq!(one, with(2, 5));
    assert_ne!(one.samples, with(1, 6).samples);
    assert_eq!(one.traces(2).len(), one.chains);
    assert_eq!(one.traces(2).concat(), one.samples.column(2).iter().copied().collect::<Vec<_>>());
    assert!(one.traces(3).is_empty());
}

#[test]
fn a_mode_without_density_is_left_and_nothing_at_all_is_said() {
    let bounds = Bounds::new(&[-50.0; 2], &[50.0; 2]).unwrap();
    let modes = [mode(&[-20.0; 2], &[1.0; 2], 5.0), mode(&[20.0; 2], &[1.0; 2], 0.0)];
    let half = |x: &DVector<f64>| if x[0] > 0.0 { -0.5 * x.add_scalar(-20.0).norm_squared() } else { f64::NAN };
    let found = sample(half, &bounds, &modes, &wanting(1000.0), &|_| {}).unwrap();
    assert_eq!(found.stopped, Stopped::Converged);
    assert_mean(&found, 20.0, |x| x[0]);
    for nothing in [f64::NAN, f64::NEG_INFINITY, f64::INFINITY] {
        let found = sample(|_| nothing, &bounds, &modes, &wanting(1000.0), &|_| {}).unwrap();
        assert_eq!(found.stopped, Stopped::NoStart);
        assert_eq!((found.samples.shape(), found.effective()), ((0, 2), None));
        assert!(found.traces(0).is_empty());
    }
}

#[test]
fn the_budget_is_kept_and_told() {
    let modes = [mode(&[0.0; 2], &[1.0; 2], 0.0)];
    for max_evaluations in [0, 1, 50, 100, 200, 1000, 3000] {
        let settings = SamplerSettings { max_evaluations, ..wanting(1e9) };
        let calls = std::sync::atomic::AtomicUsize::new(0);
        let target = |x: &DVector<f64>| {
            calls.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            -x.norm()
        };
        let found = sample(target, &Bounds::none(2), &modes, &settings, &|_| {}).unwrap();
        assert!(matches!(found.stopped, Stopped::Budget | Stopped::NoStart));
        assert_eq!(found.evaluations, calls.into_inner());
        assert!(found.evaluations <= max_evaluations, "{} of {max_evaluations}", found.evaluations);
        assert!(found.samples.iter().chain(&found.log_densities).all(|value| value.is_finite()));
    }
}

#[test]
fn modes_that_cannot_be_used_are_refused_and_thin_ones_are_not() {
    let bounds = Bounds::none(2);
    let run = |modes: &[Mode]| sample(|x| -x.norm_squared(), &bounds, modes, &wanting(500.0), &|_| {});
    assert_eq!(run(&[]), Err(SamplerError::Empty));
    assert!(matches!(run(&[mode(&[0.0; 3], &[1.0; 3], 0.0)]), Err(SamplerError::Dimension { mode: 0, .. })));
    for bad in [
        mode(&[f64::NAN, 0.0], &[1.0; 2], 0.0),
        mode(&[0.0; 2], &[1.0, f64::INFINITY], 0.0),
        mode(&[0.0; 2], &[1.0, 0.0], 0.0),
        mode(&[0.0; 2], &[1.0; 2], f64::NEG_INFINITY),
    ] {
        assert_eq!(run(&[mode(&[0.0; 2], &[1.0; 2], 0.0), bad]), Err(SamplerError::Mode { mode: 1 }));
    }
    // Singular, and with a correlation above 1.
    for correlation in [1.0, -3.0] {
        let covariance = DMatrix::from_row_slice(2, 2, &[1.0, correlation, correlation, 1.0]);
        let found = run(&[Mode { centre: DVector::zeros(2), covariance, log_weight: 0.0 }]).unwrap();
        assert_eq!(found.stopped, Stopped::Converged);
        assert_mean(&found, 0.5, |x| x[0] * x[0]);
    }
    let none = SamplerSettings { ensembles: 0, ..wanting(1.0) };
    let modes = [mode(&[0.0; 2], &[1.0; 2], 0.0)];
    assert!(sample(|x| -x.norm(), &bounds, &modes, &none, &|_| {}).is_err());
    assert!(sample(|x| -x.norm(), &bounds, &modes, &wanting(f64::NAN), &|_| {}).is_err());
}
