//! Every committed result in `fits/` is what this program makes of its file in `data/`.

use morpho_fit::dataset::{Constants, Dataset, ReadOptions, WideHeading, read_csv};
use morpho_fit::inversion::{Estimate, FitOutcome, fit};
use std::path::{Path, PathBuf};

/// Shares of a standard deviation that another machine's sine may move a result by.
const SAME: f64 = 1e-4;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn data(path: &Path) -> Dataset {
    let wide = path.ends_with("wide.csv");
    let constants = Constants { phi_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() };
    let options = if wide {
        ReadOptions { wide: Some(WideHeading::Theta), constants, ..ReadOptions::default() }
    } else {
        ReadOptions::default()
    };
    read_csv(&std::fs::read(path).unwrap(), &options).unwrap()
}

/// Value, sigma and status agree.
fn assert_same(name: &str, old: &Estimate, new: &Estimate) {
    assert_eq!(old.status, new.status, "{name}");
    assert_eq!(old.value.is_some(), new.value.is_some(), "{name}");
    if let (Some(old_value), Some(new_value), Some(sigma)) = (old.value, new.value, old.sigma) {
        assert!((old_value - new_value).abs() <= SAME * sigma, "{name}: {old_value} became {new_value}");
        assert!((new.sigma.unwrap() / sigma - 1.0).abs() <= SAME, "{name}: sigma {sigma} became {:?}", new.sigma);
    }
}

#[test]
fn each_committed_fit_is_made_again_from_its_own_settings() {
    let mut seen = 0;
    for entry in std::fs::read_dir(root().join("data")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "csv") {
            continue;
        }
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let json = std::fs::read_to_string(root().join("fits").join(&name).join("fit.json")).unwrap();
        let old: FitOutcome = serde_json::from_str(&json).unwrap();
        let data = data(&path);
        assert_eq!(old.data.sha256, data.sha256(), "{name}: data and fit do not belong together");
        let new = fit(&data, &old.settings, &|_| {}).unwrap().outcome;
        assert_eq!((old.verdict, &old.warnings, old.dof), (new.verdict, &new.warnings, new.dof), "{name}");
        assert!((old.chi2 - new.chi2).abs() <= 1e-9 * old.chi2, "{name}: chi² {} became {}", old.chi2, new.chi2);
        for ((parameter, old), (_, new)) in old.parameters.each().into_iter().zip(new.parameters.each()) {
            assert_same(&format!("{name}: {parameter}"), old, new);
        }
        assert_same(&format!("{name}: period"), &old.derived.period, &new.derived.period);
        assert_same(&format!("{name}: optical sum"), &old.derived.optical_sum, &new.derived.optical_sum);
        seen += 1;
    }
    assert!(seen >= 7, "{seen} files in data/");
}

#[test]
fn the_simulated_files_hold_their_truth_within_three_standard_deviations() {
    for name in ["blue_morpho", "along_ridges", "without_sigma", "polarized", "wide"] {
        let json = std::fs::read_to_string(root().join("fits").join(name).join("fit.json")).unwrap();
        let found: FitOutcome = serde_json::from_str(&json).unwrap();
        for ((parameter, estimate), truth) in found.parameters.each().into_iter().zip([141.0, 62.0, 2.5, 0.5, 300.0]) {
            if let (Some(value), Some(sigma)) = (estimate.value, estimate.sigma) {
                assert!((value - truth).abs() <= 3.0 * sigma, "{name}: {parameter} {value} ± {sigma}");
            }
        }
    }
}

#[test]
fn the_committed_page_of_the_paper_is_what_the_formulas_give() {
    let page = morpho_fit::report::paper::page().unwrap();
    let committed = std::fs::read_to_string(root().join("fits/paper/README.md")).unwrap();
    assert!(page.text == committed, "fits/paper/README.md is not of this program: run scripts/refit");
    let colours = std::fs::read_to_string(root().join("fits/paper/colours.csv")).unwrap();
    assert!(page.colours == colours, "fits/paper/colours.csv is not of this program: run scripts/refit");
    for (name, _) in page.figures {
        assert!(page.text.contains(&format!("{name}.svg")) && root().join(format!("fits/paper/{name}.svg")).is_file());
    }
}
