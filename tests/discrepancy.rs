//! When the model is wrong the fit says so first, and its intervals hold the truth of period and optical sum as often as
//! they say. `cargo run --release --example misses` is the same with 200 cases of every source and design.

mod support;

use support::misses::{Case, Design, Source, cases, coverage, is_flagged};

/// Largest number of `cases` that a share of `outside` leaves, but for one run in two hundred: the mean and 2.6 standard
/// deviations of the binomial.
fn most(cases: usize, outside: f64) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a small count")]
    let cases = cases as f64;
    (cases * outside + 2.6 * (cases * outside * (1.0 - outside)).sqrt()).floor()
}

/// No interval of period and optical sum leaves out the truth more often than it says.
fn assert_held(name: &str, cases: &[&Case], least: usize) {
    for found in &coverage(cases)[..2] {
        println!("{name}: {found:?}");
        assert!(found.printed >= least, "{name}: {found:?}");
        for (within, share) in [(found.within_68, 0.683), (found.within_95, 0.95)] {
            #[allow(clippy::cast_precision_loss, reason = "a small count")]
            let left_out = (found.printed - within) as f64;
            assert!(left_out <= most(found.printed, 1.0 - share), "{name}: {found:?}");
        }
    }
}

#[test]
fn the_mean_admittance_at_steep_angles_is_flagged_and_period_and_sum_are_held() {
    let cases = cases(Source::Paper, Design::Angles, 24);
    let flagged: Vec<&Case> = cases.iter().filter(|case| is_flagged(case)).collect();
    assert!(flagged.len() >= 20, "{} of 24 flagged", flagged.len());
    assert_held("paper", &flagged, 16);
}

#[test]
fn layers_that_differ_are_flagged_and_period_and_sum_are_held() {
    // Spectra of thick layers have fringes narrower than their steps, whose residuals look like noise.
    let studies =
        [(Source::Ensemble, Design::Full), (Source::Single, Design::Full), (Source::Ensemble, Design::Angles)];
    for (source, design) in studies {
        let count = 24;
        let cases = cases(source, design, count);
        let flagged: Vec<&Case> = cases.iter().filter(|case| is_flagged(case)).collect();
        assert!(flagged.len() >= count * 2 / 3, "{source:?}, {design:?}: {} of {count} flagged", flagged.len());
        assert_held(&format!("{source:?}, {design:?}"), &flagged, count / 2);
    }
}

#[test]
fn data_of_the_model_itself_are_not_widened() {
    let cases = cases(Source::Blend, Design::Full, 100);
    let widened: Vec<f64> = cases.iter().map(|case| case.outcome.widened_by).filter(|by| *by > 1.0).collect();
    assert!(widened.len() <= 1, "{widened:?}");
    for case in &cases {
        assert!(!is_flagged(case) || case.outcome.widened_by > 1.0);
        // Runs of noise are nearly normal: 4.5 deviations are one in 150,000, of 400 curves.
        for curve in &case.outcome.curve_residuals {
            assert!(curve.runs_z.is_some_and(|z| z.abs() < 4.5), "{curve:?}");
        }
    }
    let chi2 = |case: &Case| case.outcome.curve_residuals.iter().map(|curve| curve.chi2).sum::<f64>();
    assert!(cases.iter().all(|case| (chi2(case) - case.outcome.chi2).abs() < 1e-9 * case.outcome.chi2));
}
