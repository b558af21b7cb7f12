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
    let averages =
        ["--numerical-aperture 0.6", "--bandwidth 25", "--period-spread 8", "--layer-spread 8", "--tilt-spread 8"];
    for average in averages {
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

/// The data are a mean over 401 plane-wave simulations, made here: the program's own nodes have no part in them.
#[test]
fn the_mean_of_many_stacks_is_fitted_with_the_spread_of_its_period() {
    use morpho_fit::dataset::{Dataset, Reading, to_csv};
    use morpho_fit::optics::{BlendModel, Structure};
    use morpho_fit::synthetic::{Scan, linspace, simulate};
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;
    let scan = Scan { wavelengths: linspace(380.0, 740.0, 73), ..Scan::spectrum(90.0) };
    let (model, blue, spread) = (BlendModel::default(), Structure::blue(), 5.0);
    let (mut sums, mut whole) = (vec![0.0; 73], 0.0);
    for step in -200..=200 {
        let x = f64::from(step) * 0.025;
        let (share, factor) = ((-0.5 * x * x).exp(), 1.0 + spread * x / blue.period());
        let one = Structure { d_air: factor * blue.d_air, d_cuticle: factor * blue.d_cuticle, ..blue };
        let data = simulate(&model, &one, std::slice::from_ref(&scan), 1.0, 0.0, 1).unwrap();
        whole += share;
        for (sum, reading) in sums.iter_mut().zip(data.readings()) {
            *sum += share * reading.intensity;
        }
    }
    let data = simulate(&model, &blue, std::slice::from_ref(&scan), 1.0, 0.0, 1).unwrap();
    let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(9);
    let readings = data.readings().iter().zip(sums).map(|(reading, sum)| {
        let noise: f64 = random.sample(StandardNormal);
        Reading { intensity: sum / whole + 0.005 * noise, sigma: Some(0.005), ..*reading }
    });
    let data = Dataset::from_readings(readings.collect(), data.curves().to_vec()).unwrap();
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("mean.csv"), to_csv(&data, &[])).unwrap();
    succeeds(&folder, &format!("mean.csv {KNOWN} --period-spread 5 --out with"));
    let found = outcome(&folder, "with");
    assert!(found.widened_by < 1.01 && found.chi2 < 130.0, "{}", found.chi2);
    for (error, sigma) in errors(&found) {
        assert!(error < 4.0 * sigma && sigma < 1.0, "{error} ± {sigma}");
    }
    let plain = succeeds(&folder, &format!("mean.csv {KNOWN} --out without"));
    assert!(plain.out.starts_with("The model misses the data"), "{}", plain.out);
}

#[test]
fn averages_out_of_range_are_refused() {
    let folder = TempDir::new().unwrap();
    for flag in [
        "--numerical-aperture 1.2",
        "--bandwidth -3",
        "--tilt-spread 60",
        "--period-spread nan",
        "--layer-spread -2",
        "--model paper --layer-spread 5",
        "--layers 2000 --layer-spread 5",
        "--numerical-aperture 0.3 --tilt-spread 2",
        "--model hybrid --tilt-spread 2",
    ] {
        let ended = run(&folder, &format!("simulate {flag}"));
        assert_eq!(ended.code, 2, "{flag}: {}", ended.err);
    }
    succeeds(&folder, &format!("simulate {SPECTRUM} --out made.csv"));
    succeeds(&folder, &format!("made.csv {KNOWN} --out fitted"));
    let ended = run(&folder, "sweep fitted --numerical-aperture 0.5");
    assert!(ended.code == 2 && ended.err.contains("is in the fit already"), "{}", ended.err);
}
