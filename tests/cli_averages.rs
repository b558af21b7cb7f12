//! Averages over a cone of light, a band and spreads, through the real program. The truth is that of the simulation.

#[path = "support/program.rs"]
mod program;

use morpho_fit::inversion::FitOutcome;
use program::{outcome, run, succeeds};
use tempfile::TempDir;

const SPECTRUM: &str = "--scan wavelength=380:740:5,omega=90 --noise 0.005 --seed 6";
const KNOWN: &str = "--fix delta=2.5 --bounds d_air=100:180 --bounds d_cuticle=40:90 --no-plots";

/// Errors of gap and cuticle in nm and their standard deviations.
fn errors(found: &FitOutcome) -> [(f64, f64); 2] {
    let of = |estimate: &morpho_fit::inversion::Estimate, truth: f64| {
        ((estimate.value.unwrap() - truth).abs(), estimate.sigma.unwrap())
    };
    [of(&found.parameters.d_air, 141.0), of(&found.parameters.d_cuticle, 62.0)]
}

#[test]
fn an_average_that_is_modelled_leaves_no_bias_and_one_that_is_not_is_flagged() {
    let folder = TempDir::new().unwrap();
    for average in ["--numerical-aperture 0.6", "--bandwidth 25", "--period-spread 8", "--tilt-spread 8"] {
        succeeds(&folder, &format!("simulate {SPECTRUM} {average} --out made.csv"));
        succeeds(&folder, &format!("made.csv {KNOWN} {average} --out with"));
        for (error, sigma) in errors(&outcome(&folder, "with")) {
            assert!(error < 4.0 * sigma && sigma < 3.0, "{average}: {error} ± {sigma}");
        }
        let plain = succeeds(&folder, &format!("made.csv {KNOWN} --out without"));
        assert!(plain.out.starts_with("The model misses the data"), "{average}: {}", plain.out);
    }
    let found = outcome(&folder, "with");
    assert!((found.settings.averages.tilt_spread - 8.0_f64.to_radians()).abs() < 1e-15);
}

#[test]
fn averages_out_of_range_are_refused() {
    let folder = TempDir::new().unwrap();
    for flag in ["--numerical-aperture 1.2", "--bandwidth -3", "--tilt-spread 60", "--period-spread nan"] {
        let ended = run(&folder, &format!("simulate {flag}"));
        assert_eq!(ended.code, 2, "{flag}: {}", ended.err);
    }
    succeeds(&folder, &format!("simulate {SPECTRUM} --out made.csv"));
    succeeds(&folder, &format!("made.csv {KNOWN} --out fitted"));
    let ended = run(&folder, "sweep fitted --numerical-aperture 0.5");
    assert!(ended.code == 2 && ended.err.contains("is in the fit already"), "{}", ended.err);
}
