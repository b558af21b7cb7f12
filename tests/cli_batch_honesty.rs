//! `morpho-fit batch`: a model that misses the data is said first, and no table is lost to another.

#[path = "support/program.rs"]
mod program;

use morpho_fit::export::Batch;
use program::{names, succeeds};
use std::fs;
use tempfile::TempDir;

const FIT: &str =
    "--fix delta=2.5 --fix phi_alpha=0.5 --fix a=300 --bounds d_air=60:180 --bounds d_cuticle=40:90 --no-plots";

fn batch(folder: &TempDir, name: &str) -> Batch {
    serde_json::from_slice(&fs::read(folder.path().join("all").join(name)).unwrap()).unwrap()
}

/// Readings of unequal layers, fitted as equal ones, and of equal ones.
#[test]
fn what_the_model_misses_is_counted_and_told_in_its_row() {
    let folder = TempDir::new().unwrap();
    let scan = "--scan wavelength=380:740:5,omega=90 --noise 0.005 --seed 6";
    succeeds(&folder, &format!("simulate {scan} --layer-spread 12 --out unequal.csv"));
    succeeds(&folder, &format!("simulate {scan} --out equal.csv"));
    let said = succeeds(&folder, &format!("batch unequal.csv equal.csv {FIT} --out all"));
    let first = said.out.lines().next().unwrap();
    assert!(first.ends_with("; the model misses the data of 1"), "{first}");
    let missing = |line: &&str| line.contains("the model misses") && line.trim_start().starts_with("unequal");
    assert_eq!(said.out.lines().filter(missing).count(), 1, "{}", said.out);
    let misses: Vec<bool> =
        batch(&folder, "batch.json").items.iter().map(|row| row.fit.as_ref().unwrap().misses()).collect();
    assert_eq!(misses, [true, false]);
    let table = fs::read_to_string(folder.path().join("all/batch.csv")).unwrap();
    let sources: Vec<bool> = table.lines().skip(1).map(|line| line.contains(",widened,")).collect();
    assert_eq!(sources, [true, false]);
}

#[test]
fn a_table_of_other_items_or_settings_is_kept_beside_the_new_one() {
    let folder = TempDir::new().unwrap();
    for (seed, name) in ["a", "b", "c"].into_iter().enumerate() {
        succeeds(&folder, &format!("simulate --scan wavelength=380:740:10,omega=90 --seed {seed} --out {name}.csv"));
    }
    let rows = |name: &str| batch(&folder, name).items.into_iter().map(|row| row.item).collect::<Vec<String>>();
    succeeds(&folder, &format!("batch a.csv b.csv {FIT} --out all"));
    // All of it is in the new one: nothing to keep.
    succeeds(&folder, &format!("batch a.csv b.csv c.csv {FIT} --out all"));
    assert_eq!(names(&folder.path().join("all")), ["batch.csv", "batch.json"]);
    let said = succeeds(&folder, &format!("batch c.csv {FIT} --out all"));
    assert!(said.err.contains("kept in batch.earlier.csv"), "{}", said.err);
    assert_eq!((rows("batch.earlier.json").len(), rows("batch.json")), (3, vec!["c".to_owned()]));
    succeeds(&folder, &format!("batch c.csv {FIT} --loss huber --out all"));
    assert_eq!(rows("batch.earlier.json"), ["c"]);
}
