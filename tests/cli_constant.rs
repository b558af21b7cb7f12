//! `morpho-fit constant` of the real program: what it writes and what it refuses.

#[path = "support/program.rs"]
mod program;

use program::{names, run, succeeds};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

/// A little data file with an index of 1.5 in its cuticle.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    succeeds(
        &folder,
        "simulate --n-cuticle 1.5 --scan wavelength=420:640:20,theta=0,phi=-30:30:4,omega=20|75 --seed 4 --out d.csv",
    );
    folder
}

#[test]
fn the_constant_and_what_it_costs_are_written_and_told() {
    let folder = folder();
    let said = succeeds(&folder, "constant d.csv --vary n_cuticle=1.4:1.7 --out out").out;
    for words in ["n_cuticle 1.", "the fit was told 1.56", "± with n_cuticle known", "d_cuticle", "optical sum"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(names(&folder.path().join("out")), ["constant.csv", "constant.json", "constant.png", "constant.svg"]);
    let file: Value = serde_json::from_slice(&fs::read(folder.path().join("out/constant.json")).unwrap()).unwrap();
    assert_eq!((&file["schema"], &file["constant"]), (&"morpho-fit/constant/1".into(), &"n_cuticle".into()));
    let ends: Vec<f64> = file["interval_95"].as_array().unwrap().iter().map(|end| end.as_f64().unwrap()).collect();
    assert!(ends[0] < 1.5 && 1.5 < ends[1], "{ends:?}");
    // The fit in it is the fit at the best value, as `fit` gives it.
    let best = file["value"].as_f64().unwrap();
    succeeds(&folder, &format!("d.csv --n-cuticle {best} --no-plots --out fit"));
    let fit: Value = serde_json::from_slice(&fs::read(folder.path().join("fit/fit.json")).unwrap()).unwrap();
    assert_eq!(file["fit"]["chi2"], fit["chi2"]);
    let table = fs::read_to_string(folder.path().join("out/constant.csv")).unwrap();
    assert!(table.starts_with("n_cuticle,delta_chi2,d_air_nm,"));
    assert!(table.lines().count() > 5);
}

#[test]
fn a_range_beside_the_truth_is_an_exit_code_of_its_own() {
    let found = run(&folder(), "constant d.csv --vary n_cuticle=1.6:1.7 --no-plots --out out");
    assert_eq!(found.code, 5);
    assert!(found.out.contains("an end of the range"), "{}", found.out);
}

#[test]
fn what_cannot_be_is_refused_before_the_work() {
    let folder = folder();
    for (arguments, words) in [
        ("--vary n_cutcle=1.4:1.7", "did you mean `n_cuticle`?"),
        ("--vary n_cuticle=1.4", "write it like n_cuticle=1.45:1.65"),
        ("--vary n_cuticle=1.7:1.4", "the range must rise"),
        ("--vary k_cuticle=-1:1", "within 0 to 1000"),
        ("--vary n_cuticle=1.4:1.7 --vary k_cuticle=0:1", "one constant is fitted at a time"),
        ("--vary ridge_spacing=600:800", "`hybrid` model"),
        ("--vary n_cuticle=1.4:1.7 --n-cuticle cauchy:1.5,8800", "a formula or a table"),
        ("", "--vary"),
    ] {
        let found = run(&folder, &format!("constant d.csv {arguments} --out none"));
        assert_eq!(found.code, 2, "{arguments}: {}", found.err);
        assert!(found.err.contains(words), "{arguments}: {}", found.err);
        assert!(!folder.path().join("none").exists(), "{arguments}");
    }
}
