//! Intervals on the command line: their words, files and pictures, and what gets none.

#[path = "support/program.rs"]
mod program;

use program::{names, outcome, run, succeeds, with_blue, write};
use std::fs;
use tempfile::TempDir;

#[test]
fn all_intervals_are_asked_at_once_and_leave_their_numbers_and_pictures() {
    let folder = with_blue();
    let ended = succeeds(&folder, "blue.csv --uncertainty all --replicates 200 --effective 1000 --out all");
    for word in ["covariance", "profile", "bootstrap, residuals", "bootstrap, cases", "posterior", "split-R̂"] {
        assert!(ended.out.contains(word), "{word}: {}", ended.out);
    }
    let written = names(&folder.path().join("all"));
    for name in ["profile.csv", "bootstrap.csv", "posterior.csv", "profile.svg", "corner.png", "trace.svg", "atlas.svg"]
    {
        assert!(written.iter().any(|other| other == name), "{name}: {written:?}");
    }
    let found = outcome(&folder, "all").uncertainty.unwrap();
    assert_eq!(found.quantities.len(), 7);
    assert!(found.quantities.iter().all(|quantity| quantity.methods.len() == 5), "{found:?}");
    assert!(found.posterior.unwrap().converged);
    let rows = |name: &str| fs::read_to_string(folder.path().join("all").join(name)).unwrap().lines().count();
    assert_eq!(rows("bootstrap.csv"), 401);
    assert!(rows("posterior.csv") > 1000 && rows("profile.csv") > 50);
    let page = fs::read_to_string(folder.path().join("all/report.html")).unwrap();
    assert_eq!(page.matches("<figure>").count(), 7);
    assert!(page.contains("id=\"intervals\"") && page.contains("bootstrap, residuals"), "intervals in the page");
    // A later fit without intervals takes their files away: they would belong to another result.
    succeeds(&folder, "blue.csv --out all");
    assert!(!names(&folder.path().join("all")).iter().any(|name| name.starts_with("posterior")));
}

#[test]
fn each_method_has_a_word() {
    let folder = with_blue();
    for (word, file) in [("profile", "profile.csv"), ("bootstrap", "bootstrap.csv"), ("sample", "posterior.csv")] {
        let ended =
            succeeds(&folder, &format!("{word} blue.csv --no-plots --replicates 100 --effective 500 --out {word}"));
        assert!(ended.out.contains(file), "{}", ended.out);
        assert_eq!(names(&folder.path().join(word)), {
            let mut expected = vec!["curves.csv".to_owned(), "fit.json".to_owned(), file.to_owned()];
            expected.sort();
            expected
        });
    }
    let wrong = run(&folder, "blue.csv --uncertainty guess");
    assert_eq!((wrong.code, wrong.out.as_str()), (2, ""));
    assert_eq!(run(&folder, "sample blue.csv --effective 3").code, 2);
}

/// Negative controls: noise and a flat curve give no thickness, and no interval of one.
#[test]
fn noise_and_a_flat_curve_are_refused_whatever_is_asked() {
    let folder = TempDir::new().unwrap();
    let mut state = 1_u32;
    // The minimal standard generator of Park and Miller.
    let mut random = || {
        state = u32::try_from(u64::from(state) * 48_271 % 2_147_483_647).unwrap();
        f64::from(state) / 2_147_483_647.0
    };
    let noise: Vec<f64> = (0..74).map(|_| 0.5 + 0.02 * (random() + random() + random() - 1.5)).collect();
    for (name, values) in [("noise.csv", noise), ("flat.csv", vec![0.3; 74])] {
        let mut text = "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma\n".to_owned();
        for (index, value) in values.iter().enumerate() {
            let (wavelength, omega) = (380 + 10 * (index % 37), 90 * (index / 37));
            text.push_str(&format!("{wavelength},0,0,{omega},{value},0.01\n"));
        }
        write(&folder, name, &text);
        for loss in ["linear", "huber", "cauchy"] {
            let ended = run(&folder, &format!("{name} --uncertainty all --out out --loss {loss}"));
            assert!([4, 5].contains(&ended.code), "{name} {loss}: {} {}", ended.code, ended.out);
            let found = outcome(&folder, "out");
            let thickness = [&found.parameters.d_air, &found.parameters.d_cuticle, &found.derived.period];
            assert!(thickness.iter().all(|estimate| estimate.value.is_none()), "{name} {loss}");
            assert!(found.uncertainty.is_none() && !found.warnings.is_empty(), "{name} {loss}: a reason is given");
        }
    }
}
