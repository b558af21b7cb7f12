//! The `hybrid` model through the real program: simulated, checked, fitted, drawn.

#[path = "support/program.rs"]
mod program;

use morpho_fit::inversion::{ModelChoice, Status};
use program::{outcome, run, succeeds};
use std::fs;
use tempfile::TempDir;

#[test]
fn data_of_the_hybrid_model_are_checked_fitted_and_drawn() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --model hybrid --ridge-spacing 700 --filling 0.9 --seed 4 --out made.csv");
    let model = "--model hybrid --ridge-spacing 700 --filling 0.9";
    let checked = succeeds(&folder, &format!("check made.csv {model}"));
    assert!(checked.out.ends_with("Nothing more is needed.\n"), "{}", checked.out);
    let fitted = succeeds(&folder, &format!("made.csv {model}"));
    assert!(fitted.out.starts_with("All five parameters are determined"), "{}", fitted.out);
    let found = outcome(&folder, "fits/made");
    assert_eq!(found.settings.model, ModelChoice::Hybrid { ridge_spacing: 700.0 });
    assert_eq!(found.settings.stack.filling, Some(0.9));
    for ((name, estimate), truth) in found.parameters.each().into_iter().zip([141.0, 62.0, 2.5, 0.5, 300.0]) {
        let (value, sigma) = (estimate.value.unwrap(), estimate.sigma.unwrap());
        assert!((value - truth).abs() < 4.0 * sigma, "{name}: {value} ± {sigma} is not {truth}");
    }
    let page = fs::read_to_string(folder.path().join("fits/made/report.html")).unwrap();
    assert!(page.contains("hybrid") && page.contains("filling of the layers"));
    succeeds(&folder, "curves fits/made --data made.csv --quiet");
    let sweep = succeeds(&folder, "sweep fits/made");
    assert!(sweep.out.contains("model hybrid"), "{}", sweep.out);
}

#[test]
fn scans_across_the_ridges_tell_both_thicknesses() {
    let folder = TempDir::new().unwrap();
    let scan = "--scan wavelength=400:540:20,phi=-60:60:2.5,omega=0";
    succeeds(&folder, &format!("simulate --model hybrid --seed 2 --out across.csv {scan}"));
    let checked = succeeds(&folder, "check across.csv --model hybrid");
    assert!(checked.out.contains("only the plane across the ridges (omega 0) is seen\n"), "{}", checked.out);
    succeeds(&folder, "across.csv --model hybrid --no-plots --require d_air,d_cuticle");
    let found = outcome(&folder, "fits/across").parameters;
    for (estimate, truth) in [(found.d_air, 141.0), (found.d_cuticle, 62.0)] {
        assert!((estimate.value.unwrap() - truth).abs() < 4.0 * estimate.sigma.unwrap());
        assert_ne!(estimate.status, Status::Ambiguous);
    }
    assert_eq!(found.phi_alpha.value, None, "it is a scale there");
}

#[test]
fn choices_that_do_not_fit_the_hybrid_model_are_refused() {
    let folder = program::with_blue();
    for (arguments, says) in [
        ("blue.csv --model hybrid --weight 0.5", "one product"),
        ("blue.csv --ridge-spacing 700", "add --model hybrid"),
        ("blue.csv --model hybrid --snell printed", "add --model paper"),
        ("blue.csv --model hybrid --ridge-spacing 0", "ridge spacing is 0 nm"),
        ("blue.csv --filling 1.2", "--filling 1.2"),
        ("blue.csv --model hybrid --ridge-spacing 300 --fix lamella_width=400", "ridges are 300 nm apart"),
        ("blue.csv --model hybrid --tilt-spread 2", "tilt of the hybrid model"),
    ] {
        let ended = run(&folder, arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(says), "{arguments}: {}", ended.err);
    }
}

#[test]
fn model_auto_holds_the_hybrid_beside_the_blend() {
    let folder = TempDir::new().unwrap();
    let model = "--ridge-spacing 700";
    succeeds(&folder, &format!("simulate --model hybrid {model} --seed 4 --out made.csv"));
    let auto = succeeds(&folder, &format!("made.csv --model auto {model}"));
    assert!(auto.out.contains("hybrid + tilt + background") && auto.out.contains("multilayer"), "{}", auto.out);
    let page = fs::read_to_string(folder.path().join("fits/made/report.html")).unwrap();
    assert!(page.contains("hybrid + tilt"));
    // The kept variant is the hybrid itself, whose own fit has no table.
    let mut found = outcome(&folder, "fits/made");
    assert_eq!(found.choice.take().unwrap().variants.len(), 14);
    succeeds(&folder, &format!("made.csv --model hybrid {model} --out plain --no-plots --quiet"));
    assert_eq!(found, outcome(&folder, "plain"));

    // One that cannot hold what is asked for is left out, unless it is asked for too.
    succeeds(&folder, "made.csv --model auto --weight 0.5 --out weighted --no-plots --quiet");
    let names: Vec<String> =
        outcome(&folder, "weighted").choice.unwrap().variants.into_iter().map(|row| row.name).collect();
    assert_eq!(names, ["blend", "blend + background", "blend + tilt", "blend + tilt + background"]);
    for (arguments, says) in [
        ("--ridge-spacing 700 --weight 0.5", "one product"),
        ("--ridge-spacing 300 --fix lamella_width=400", "ridges are 300 nm apart"),
        ("--ridge-spacing 0", "ridge spacing is 0 nm"),
    ] {
        let ended = run(&folder, &format!("made.csv --model auto {arguments}"));
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(says), "{arguments}: {}", ended.err);
    }
}
