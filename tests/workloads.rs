//! The fixed workloads, whose data and answers another program made: every fit reaches the known chi².
//!
//! W3 has 600 kB of data, W6 is kept with it: their tests run where `MORPHO_WORKLOADS` names the folder of the definitions.

#[path = "../examples/workload.rs"]
#[allow(dead_code, reason = "the example's main is not called")]
mod workload;

use serde_json::Value;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/workloads")
}

fn definition(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn w2_reaches_its_minimum_from_all_three_starts() {
    for start in ["mixed", "plus", "minus"] {
        let found = workload::one_fit(&definition(&folder(), "w2.json"), &folder(), start).unwrap();
        let chi2 = found["chi2"].as_f64().unwrap();
        // MINPACK's minimum is 2222.125954 to its own tolerance.
        assert!((chi2 - 2_222.125_955).abs() < 2e-6, "{start}: {chi2}");
    }
}

#[test]
fn w3b_finds_the_global_minimum_in_20_of_20() {
    let workload = definition(&folder(), "w3b.json");
    let found = workload::global_fits(&workload, &folder(), true).unwrap();
    for (case, chi2) in workload["cases"].as_array().unwrap().iter().zip(list(&found["chi2"])) {
        let truth = case["chi2_truth"].as_f64().unwrap();
        assert!(chi2 <= truth, "{chi2} for {truth}: {case}");
    }
    assert_eq!(found["successes"], 20);
    // One of them lies on both edges of its lobe, where no gradient vanishes; it is a minimum nevertheless.
    assert_eq!(found["ended"], 20);
}

#[test]
#[ignore = "600 kB of data: scripts/test runs it where MORPHO_WORKLOADS names their folder"]
fn w3_finds_the_global_minimum_in_20_of_20() {
    let folder = PathBuf::from(std::env::var_os("MORPHO_WORKLOADS").expect("MORPHO_WORKLOADS is not set"));
    let found = workload::global_fits(&definition(&folder, "w3.json"), &folder, false).unwrap();
    assert_eq!(found["successes"], 20);
}

/// Means, standard deviations and correlations of emcee with an independent model, within the Monte-Carlo error of both.
#[test]
fn w4_has_the_posterior_that_emcee_finds() {
    let found = workload::posterior_of_w2(&definition(&folder(), "w2.json"), &folder()).unwrap();
    assert_eq!(found["converged"], true);
    let (means, sds) = (list(&found["mean"]), list(&found["sd"]));
    let ours = found["effective"].as_f64().unwrap();
    let path = folder().parent().unwrap().join("posterior_w2.csv");
    let mut rows = csv::Reader::from_path(path).unwrap();
    for (place, row) in rows.records().map(Result::unwrap).enumerate() {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let (name, mean, sd, effective) = (&row[0], number(1), number(2), number(3));
        let error = (1.0 / ours + 1.0 / effective).sqrt();
        assert!((means[place] - mean).abs() < 4.0 * error * sd, "{name}: {} for {mean}", means[place]);
        assert!((sds[place] / sd - 1.0).abs() < 4.0 * error / 2.0_f64.sqrt(), "{name}: sd {} for {sd}", sds[place]);
    }
    // The best sampler in the workloads' own table makes 0.11 effective samples of an evaluation.
    let each = ours / found["evaluations"].as_f64().unwrap();
    assert!(each > 0.11, "{each} effective samples for each evaluation");
}

#[test]
fn w5_fits_all_of_1000_pixels() {
    let workload = definition(&folder(), "w5.json");
    let found = workload::pixels(&workload, &folder(), "1000").unwrap();
    assert_eq!(found["right"], 1000);
    // 2289 degrees of freedom: five standard deviations.
    assert!(found["largest_reduced_chi2"].as_f64().unwrap() < 1.15, "{}", found["largest_reduced_chi2"]);
}

/// Each value in 40 digits by another program, at the ends of the axes, on the mirror direction and anywhere.
#[test]
fn w7_is_the_table_of_another_program() {
    let once = |work: &mut dyn FnMut() -> workload::Result<()>| work().map(|()| 0.0);
    let found = workload::colour_table_values(&definition(&folder(), "w7.json"), &folder(), once);
    let (table, _) = found.unwrap();
    assert_eq!(table.len(), 91 * 181 * 46 * 3);
    let mut rows = csv::Reader::from_path(folder().parent().unwrap().join("w7_checks.csv")).unwrap();
    let mut checked = 0;
    for row in rows.deserialize::<(usize, isize, usize, f64, f64, f64)>() {
        let (theta, phi, omega, red, green, blue) = row.unwrap();
        let first = 3 * ((theta * 181 + phi.checked_add(90).unwrap().unsigned_abs()) * 46 + omega / 2);
        for (found, known) in table[first..first + 3].iter().zip([red, green, blue]) {
            assert!((found - known).abs() < 1e-12, "theta {theta}, phi {phi}, omega {omega}: {found} for {known}");
        }
        checked += 1;
    }
    assert_eq!(checked, 67);
}

#[test]
#[ignore = "scripts/test runs it where MORPHO_WORKLOADS names the folder of the definitions"]
fn w6_has_the_colours_of_the_definition() {
    let folder = PathBuf::from(std::env::var_os("MORPHO_WORKLOADS").expect("MORPHO_WORKLOADS is not set"));
    for step in ["1", "10"] {
        let found = workload::colours(&definition(&folder, "w6.json"), step).unwrap();
        assert!(found["worst_check"].as_f64().unwrap() < 1e-6, "{step} nm: {found}");
        assert_eq!(found["checked"], 6);
    }
}
