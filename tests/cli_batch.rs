//! `morpho-fit batch` of the real program: the values of single fits, in one table that can be gone on with.

#[path = "support/program.rs"]
mod program;

use assert_cmd::Command;
use morpho_fit::export::{Batch, BatchRow, BatchValue};
use morpho_fit::inversion::{Standing, Status};
use program::{Ended, names, outcome, run, run_with, succeeds, write};
use std::fs;
use std::process::Stdio;
use tempfile::TempDir;

/// A spectrum along the ridges tells the two thicknesses.
const SCAN: &str = "--scan wavelength=380:740:10,omega=90";
const FIT: &str =
    "--fix delta=2.5 --fix phi_alpha=0.5 --fix a=300 --bounds d_air=60:180 --bounds d_cuticle=40:90 --no-plots";

fn simulated(folder: &TempDir, d_air: f64, seed: usize, name: &str) {
    succeeds(folder, &format!("simulate --d-air {d_air} --seed {seed} {SCAN} --out {name}"));
}

/// One file of pixels, `columns` in a row, with the columns `x` and `y`; the gap grows by 4 nm from pixel to pixel,
/// seven times.
fn map(folder: &TempDir, columns: usize, pixels: usize) {
    let mut text = String::new();
    for pixel in 0..pixels {
        let gap = 120.0 + 4.0 * (pixel % 7) as f64;
        let csv = succeeds(folder, &format!("simulate --d-air {gap} --seed {} {SCAN}", pixel + 1)).out;
        let mut rows = csv.lines().filter(|line| !line.starts_with('#'));
        let head = rows.next().unwrap();
        if pixel == 0 {
            text.push_str(&format!("{head},x,y\n"));
        }
        rows.for_each(|row| text.push_str(&format!("{row},{},{}\n", pixel % columns, pixel / columns)));
    }
    write(folder, "map.csv", &text);
}

fn batch(folder: &TempDir, place: &str) -> Batch {
    serde_json::from_slice(&fs::read(folder.path().join(place).join("batch.json")).unwrap()).unwrap()
}

fn bytes(folder: &TempDir, place: &str) -> [Vec<u8>; 2] {
    ["batch.csv", "batch.json"].map(|name| fs::read(folder.path().join(place).join(name)).unwrap())
}

fn d_air(row: &BatchRow) -> BatchValue {
    row.fit.as_ref().unwrap().values.d_air
}

#[track_caller]
fn ends(folder: &TempDir, arguments: &str, code: i32) -> Ended {
    let ended = run(folder, arguments);
    assert_eq!(ended.code, code, "{arguments}: {}", ended.err);
    ended
}

#[test]
fn each_file_has_the_values_of_its_own_fit() {
    let folder = TempDir::new().unwrap();
    let truths = [125.0, 141.0, 150.0];
    for (seed, gap) in truths.into_iter().enumerate() {
        simulated(&folder, gap, seed + 1, &format!("scale{seed}.csv"));
    }
    let said = succeeds(&folder, &format!("batch scale0.csv scale1.csv scale2.csv {FIT} --out all"));
    assert!(said.out.starts_with("3 items: 3 determined\n"), "{}", said.out);
    assert_eq!(said.err, "", "silent in a pipe");
    assert_eq!(names(&folder.path().join("all")), ["batch.csv", "batch.json"]);
    let all = batch(&folder, "all");
    let mut reader = csv::Reader::from_path(folder.path().join("all/batch.csv")).unwrap();
    let headings = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    for (index, truth) in truths.into_iter().enumerate() {
        let name = format!("scale{index}");
        succeeds(&folder, &format!("{name}.csv {FIT}"));
        let alone = outcome(&folder, &format!("fits/{name}"));
        let row = &all.items[index];
        assert_eq!((row.item.as_str(), row.sha256.as_deref()), (name.as_str(), Some(alone.data.sha256.as_str())));
        let fit = row.fit.as_ref().unwrap();
        assert_eq!((fit.verdict, fit.chi2, fit.dof), (alone.verdict, alone.chi2, alone.dof));
        assert_eq!(fit.warnings, alone.warnings);
        let sums = [("period", &alone.derived.period), ("optical_sum", &alone.derived.optical_sum)];
        let single = alone.parameters.each().into_iter().chain(sums);
        for ((name, unit, found), (expected, estimate)) in fit.values.each().into_iter().zip(single) {
            assert_eq!((name, unit), (expected, estimate.unit.as_str()));
            assert_eq!((found.value, found.sigma, found.status), (estimate.value, estimate.sigma, estimate.status));
            let cell = |heading: String| &rows[index][headings.iter().position(|head| head == heading).unwrap()];
            assert_eq!(cell(format!("{name}_{unit}")).parse().ok(), estimate.value, "{name}");
            assert_eq!(cell(format!("{name}_sigma_{unit}")).parse().ok(), estimate.sigma, "{name}");
        }
        let BatchValue { value, sigma, .. } = d_air(row);
        assert!((value.unwrap() - truth).abs() < 4.0 * sigma.unwrap(), "{value:?} ± {sigma:?}, {truth}");
    }
}

#[test]
fn a_finished_batch_fits_nothing_and_gives_the_same_bytes() {
    let folder = TempDir::new().unwrap();
    simulated(&folder, 130.0, 1, "a.csv");
    simulated(&folder, 140.0, 2, "b.csv");
    let command = format!("batch a.csv b.csv {FIT} --json --out all");
    let first = succeeds(&folder, &command);
    let before = bytes(&folder, "all");
    assert_eq!(first.out.as_bytes(), before[1]);
    let again = succeeds(&folder, &command);
    assert!(again.err.contains("2 of 2 items are fitted already; 0 to do"), "{}", again.err);
    assert_eq!((again.out, bytes(&folder, "all")), (first.out, before));
    // One file more, and another with other data: two fits, and the row of the third as it was.
    simulated(&folder, 150.0, 3, "c.csv");
    simulated(&folder, 145.0, 4, "b.csv");
    let more = succeeds(&folder, &format!("batch a.csv b.csv c.csv {FIT} --out all"));
    assert!(more.err.contains("1 of 3 items are fitted already; 2 to do"), "{}", more.err);
    assert!(more.err.contains("rows in all of other data are not used: 1"), "{}", more.err);
    succeeds(&folder, &format!("batch a.csv b.csv c.csv {FIT} --out fresh"));
    assert_eq!(bytes(&folder, "all"), bytes(&folder, "fresh"));
}

#[test]
fn a_batch_that_was_killed_goes_on_and_mixes_in_nothing_of_another() {
    let folder = TempDir::new().unwrap();
    map(&folder, 10, 60);
    let command = format!("batch map.csv --by x,y {FIT} --threads 1");
    succeeds(&folder, &format!("{command} --out whole"));
    let journal = folder.path().join("cut/batch.journal");
    let rows = || fs::read(&journal).unwrap_or_default().iter().filter(|byte| **byte == b'\n').count();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("morpho-fit"))
        .current_dir(folder.path())
        .args(command.split_whitespace().chain(["--out", "cut"]))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while rows() < 4 && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let done = rows();
    assert!((4..60).contains(&done), "{done} rows were done before the end");
    assert_eq!(names(&folder.path().join("cut")), ["batch.journal"], "no table of a half");
    // The last line was cut off by what killed it, and one is no line of ours.
    let mut text = fs::read(&journal).unwrap();
    text.truncate(text.iter().rposition(|byte| *byte == b'\n').unwrap() + 1);
    let whole = text.clone();
    text.extend_from_slice(b"rubbish\n");
    text.extend_from_slice(&whole[..whole.len() / done / 2]);
    fs::write(&journal, &text).unwrap();
    fs::create_dir(folder.path().join("other")).unwrap();
    fs::copy(&journal, folder.path().join("other/batch.journal")).unwrap();

    let ended = succeeds(&folder, &format!("{command} --out cut"));
    let expected = format!("{done} of 60 items are fitted already; {} to do", 60 - done);
    assert!(ended.err.contains(&expected), "{}", ended.err);
    assert_eq!(bytes(&folder, "cut"), bytes(&folder, "whole"));
    assert_eq!(names(&folder.path().join("cut")), ["batch.csv", "batch.json"], "no journal is left");

    let ended = succeeds(&folder, &format!("{command} --loss huber --out other"));
    let expected = format!("rows in other of other settings or of another version are not used: {done}");
    assert!(ended.err.contains(&expected) && !ended.err.contains("already"), "{}", ended.err);
    succeeds(&folder, &format!("{command} --loss huber --out huber"));
    assert_eq!(bytes(&folder, "other"), bytes(&folder, "huber"));
    assert_ne!(bytes(&folder, "other")[0], bytes(&folder, "whole")[0]);
}

#[test]
fn a_broken_item_stops_no_other_and_is_told_by_its_line() {
    let folder = TempDir::new().unwrap();
    simulated(&folder, 130.0, 1, "good.csv");
    write(&folder, "bad.csv", "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,x\n460,0,95,90,1\n");
    write(&folder, "few.csv", "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,0.1\n");
    let ended = ends(&folder, &format!("batch bad.csv few.csv good.csv {FIT} --out all"), 3);
    assert!(ended.err.contains("item bad: bad.csv:2: column 5 `intensity`: `x` is not a number"), "{}", ended.err);
    assert!(ended.err.contains("bad.csv:3: column 3 `phi_deg`") && ended.err.contains("few.csv: too few readings, 1,"));
    assert!(ended.err.contains("an error in 2 of 3 items"), "{}", ended.err);
    let all = batch(&folder, "all");
    assert_eq!((all.counts.errors, all.counts.determined), (2, 1));
    assert!(all.items[0].error.as_ref().unwrap().contains("bad.csv:3:") && all.items[0].fit.is_none());
    assert!(all.items[0].sha256.is_some());
    // Items with an error are tried again, the others are not.
    let again = ends(&folder, &format!("batch bad.csv few.csv good.csv {FIT} --out all"), 3);
    assert!(again.err.contains("1 of 3 items are fitted already; 2 to do"), "{}", again.err);
    // What cannot be read goes before what cannot be used, and that before what is not determined.
    assert!(ends(&folder, &format!("batch bad.csv missing.csv good.csv {FIT}"), 1).err.contains("missing.csv"));
    ends(&folder, &format!("batch bad.csv good.csv {FIT} --require a"), 3);
    succeeds(&folder, "simulate --scan wavelength=380:740:10 --out across.csv");
    let fit = "--fix delta=2.5 --fix phi_alpha=0.5 --no-plots";
    let ended = ends(&folder, &format!("batch good.csv across.csv {fit} --require d_air --require a"), 5);
    assert!(ended.err.contains("d_air required but not determined in 1 of 2 items"), "{}", ended.err);
}

#[test]
fn what_cannot_begin_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    map(&folder, 2, 2);
    let before = names(folder.path());
    for (arguments, code, words) in [
        ("batch nowhere.csv neither.csv", 1, "nowhere.csv"),
        ("batch map.csv --by pixel", 3, "map.csv:1: there is no column `pixel`; there are wavelength_nm, theta_deg"),
        (
            "batch map.csv --wide theta --omega 90 --phi 0 --by nope",
            3,
            "map.csv:1: there is no column `nope`; there are",
        ),
        ("batch map.csv --by phi_deg", 3, "map.csv:1: column 3 `phi_deg`: `phi_deg` is data"),
        ("batch map.csv --by x,y,z", 2, "one column, or two for a map"),
        ("batch map.csv map.csv", 2, "map.csv is given twice"),
        ("batch map.csv other.csv --by x,y", 2, "--by splits one file"),
        ("batch map.csv --by x,y --uncertainty profile", 2, "add --reports"),
        ("batch map.csv --by x,y --fix d_ari=3", 2, "did you mean `d_air`?"),
        ("batch map.csv .", 2, "is a folder; name the files in it"),
        ("batch", 2, "DATA.csv"),
        ("bacth", 2, "did you mean `morpho-fit batch`?"),
    ] {
        let ended = ends(&folder, arguments, code);
        assert!(ended.err.contains(words), "{arguments}: {}", ended.err);
    }
    assert_eq!(names(folder.path()), before);
    let text = fs::read_to_string(folder.path().join("map.csv")).unwrap();
    write(&folder, "batch.csv", &text);
    assert!(ends(&folder, "batch batch.csv --by x,y --out .", 2).err.contains("batch.csv of this folder was read"));
    write(&folder, "gap.csv", &text.replacen(",0,0\n", ",,0\n", 1).replacen(",1,0\n", ",one,0\n", 1));
    let ended = ends(&folder, "batch gap.csv --by x,y", 3);
    assert!(ended.err.contains("gap.csv:2: column 7 `x`: the cell is empty"), "{}", ended.err);
    assert!(ended.err.contains(": column 7 `x`: `one` is not a number"), "{}", ended.err);
    assert!(succeeds(&folder, "batch --help").out.contains("--by <COLUMN[,COLUMN]>"));
}

#[test]
fn the_table_does_not_depend_on_the_number_of_threads() {
    let folder = TempDir::new().unwrap();
    map(&folder, 3, 7);
    for threads in ["1", "2", "5"] {
        let mut command = Command::cargo_bin("morpho-fit").unwrap();
        let arguments = format!("batch map.csv --by x,y {FIT} --out {threads}");
        command.current_dir(folder.path()).args(arguments.split_whitespace()).env("RAYON_NUM_THREADS", threads);
        command.assert().success();
    }
    assert_eq!(bytes(&folder, "1"), bytes(&folder, "2"));
    assert_eq!(bytes(&folder, "1"), bytes(&folder, "5"));
}

#[test]
fn a_map_shows_its_pixels_and_leaves_out_what_is_not_told() {
    let folder = TempDir::new().unwrap();
    map(&folder, 3, 6);
    let text = fs::read_to_string(folder.path().join("map.csv")).unwrap();
    // Across the ridges a spectrum tells the sum of the thicknesses only; and a pixel has a defect.
    let across = succeeds(&folder, "simulate --scan wavelength=380:740:10 --seed 9").out;
    let across = across.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
    let kept = text.lines().filter(|line| !line.ends_with(",1,0")).map(|line| match line.strip_suffix(",2,1") {
        Some(row) => format!("{},2,1", row.replacen(",90,", ",90,x", 1)),
        None => line.to_owned(),
    });
    let rows = kept.chain(across.map(|row| format!("{row},1,0")));
    write(&folder, "map.csv", &rows.map(|row| row + "\n").collect::<String>());
    let fit = FIT.replace(" --no-plots", "");
    let ended = ends(&folder, &format!("batch map.csv --by x,y {fit} --out out"), 3);
    assert!(ended.err.contains("item 2,1: map.csv:150: column 5 `intensity`: `x"), "{}", ended.err);
    assert_eq!(names(&folder.path().join("out")), ["batch.csv", "batch.json", "map.png", "map.svg"]);
    let svg = fs::read_to_string(folder.path().join("out/map.svg")).unwrap();
    for words in ["d_air / nm: 4 of 6 pixels", "d_cuticle / nm: 4 of 6 pixels", "d_air + d_cuticle / nm: 5 of 6 pixels"]
    {
        assert!(svg.contains(words), "{words}");
    }
    assert!(!svg.contains("lamella_width"), "what was fixed has no map");
    assert!(fs::read(folder.path().join("out/map.png")).unwrap().starts_with(b"\x89PNG"));
    let all = batch(&folder, "out");
    assert_eq!(all.by, ["x", "y"]);
    let places: Vec<[f64; 2]> = all.items.iter().map(|row| row.place.unwrap()).collect();
    assert_eq!(places, [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [1.0, 0.0]]);
    let truth = |row: &BatchRow| row.place.map(|[x, y]| 120.0 + 4.0 * (x + 3.0 * y)).unwrap();
    for row in all.items.iter().take(4) {
        let BatchValue { value, sigma, .. } = d_air(row);
        assert!((value.unwrap() - truth(row)).abs() < 4.0 * sigma.unwrap(), "{value:?} ± {sigma:?}, {}", row.item);
    }
    assert_eq!((d_air(&all.items[5]).value, d_air(&all.items[5]).status), (None, Status::NotIdentifiable));
    let csv = fs::read_to_string(folder.path().join("out/batch.csv")).unwrap();
    assert!(
        csv.starts_with("x,y,model,verdict,chi2,dof,sigma_source,d_air_nm,d_air_sigma_nm,d_air_status,")
            && csv.contains("\n2,1,,")
    );
    // A chart of an earlier run does not stay beside a table without one.
    ends(&folder, &format!("batch map.csv --by x,y {FIT} --out out"), 3);
    assert_eq!(names(&folder.path().join("out")), ["batch.csv", "batch.json"]);
    // By one column the row of pixels is one item, and the other column is not used.
    ends(&folder, &format!("batch map.csv --by y {fit} --out rows"), 3);
    assert_eq!(batch(&folder, "rows").items.len(), 2);
}

#[test]
fn curves_of_tidy_and_of_wide_tables_are_items() {
    let folder = TempDir::new().unwrap();
    let scans = ["left", "right"].map(|name| format!("wavelength=380:740:10,omega=90,name={name}"));
    let scans = ["--scan", &scans[0], "--scan", &scans[1], "--no-sigma", "--seed", "5"];
    let simulate = |more: &[&str]| {
        let ended = run_with(&folder, &[&["simulate"][..], &scans, more].concat());
        assert_eq!(ended.code, 0, "{}", ended.err);
    };
    simulate(&["--out", "tidy.csv"]);
    simulate(&["--wide", "curve", "--out", "wide.csv"]);
    write(&folder, "by.toml", "by = 'curve'\nwide = 'curve'\ntheta = 0\nphi = 0\nomega = 90\n");
    succeeds(&folder, &format!("batch tidy.csv --by curve {FIT} --out tidy"));
    succeeds(&folder, &format!("batch wide.csv --settings by.toml {FIT} --out wide"));
    let [tidy, wide] = ["tidy", "wide"].map(|place| batch(&folder, place));
    assert_eq!(tidy.items.iter().map(|row| row.item.as_str()).collect::<Vec<_>>(), ["left", "right"]);
    for (tidy, wide) in tidy.items.iter().zip(&wide.items) {
        assert_eq!((&tidy.item, &tidy.fit), (&wide.item, &wide.fit));
    }
}

#[test]
fn reports_are_those_of_single_fits() {
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("old")).unwrap();
    simulated(&folder, 130.0, 1, "a.csv");
    simulated(&folder, 140.0, 2, "old/a.csv");
    let command = format!("batch a.csv old/a.csv {FIT} --reports --out all");
    let ended = succeeds(&folder, &command);
    assert!(ended.out.contains("  old/a  "), "{}", ended.out);
    assert_eq!(names(&folder.path().join("all")), ["a", "batch.csv", "batch.json", "old_a"]);
    succeeds(&folder, &format!("old/a.csv {FIT} --out alone"));
    for file in ["fit.json", "curves.csv"] {
        let read = |place: &str| fs::read(folder.path().join(place).join(file)).unwrap();
        assert_eq!(read("all/old_a"), read("alone"), "{file}");
    }
    // A folder that is gone is made again, the other is left alone.
    fs::remove_dir_all(folder.path().join("all/a")).unwrap();
    let again = succeeds(&folder, &command);
    assert!(again.err.contains("1 of 2 items are fitted already; 1 to do"), "{}", again.err);
    assert_eq!(names(&folder.path().join("all/a")), ["curves.csv", "fit.json"]);
    // Charts were not asked for before.
    let charts = succeeds(&folder, &command.replace(" --no-plots", ""));
    assert!(!charts.err.contains("already"), "{}", charts.err);
    assert!(names(&folder.path().join("all/a")).contains(&"report.html".to_owned()));
    assert!(names(&folder.path().join("all")).contains(&"items.svg".to_owned()));
}

#[test]
fn a_folder_with_another_fit_of_the_same_data_is_made_again() {
    let folder = TempDir::new().unwrap();
    simulated(&folder, 130.0, 1, "a.csv");
    simulated(&folder, 140.0, 2, "b.csv");
    let command = format!("batch a.csv b.csv {FIT} --reports --out all");
    succeeds(&folder, &command);
    let of = |place: &str| fs::read(folder.path().join(place).join("fit.json")).unwrap();
    let (first, table) = (of("all/a"), bytes(&folder, "all"));
    // As a batch of other settings that was killed leaves it.
    succeeds(&folder, &format!("a.csv {FIT} --loss huber --out all/a"));
    assert_ne!(of("all/a"), first);
    let again = succeeds(&folder, &command);
    assert!(again.err.contains("1 of 2 items are fitted already; 1 to do"), "{}", again.err);
    assert!(again.err.contains("folders in all that are missing or hold another fit: 1"), "{}", again.err);
    assert_eq!((of("all/a"), bytes(&folder, "all")), (first.clone(), table.clone()));
    // As one that ended leaves it.
    succeeds(&folder, &format!("{command} --loss huber"));
    assert_ne!(of("all/a"), first);
    let again = succeeds(&folder, &command);
    assert!(!again.err.contains("already"), "{}", again.err);
    assert_eq!((of("all/a"), bytes(&folder, "all")), (first.clone(), table.clone()));
    // A table alone takes nothing away: the folders are still there for the next.
    succeeds(&folder, &command.replace("--reports ", ""));
    assert_eq!(bytes(&folder, "all"), table);
    // Data that became useless leave no results of earlier ones beside their error.
    write(&folder, "a.csv", "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,x\n");
    ends(&folder, &command, 3);
    let left = ["b", "batch.csv", "batch.earlier.csv", "batch.earlier.json", "batch.json"];
    assert_eq!(names(&folder.path().join("all")), left);
}

#[test]
fn a_table_stands_without_a_map() {
    let folder = TempDir::new().unwrap();
    map(&folder, 1, 4);
    let text = fs::read_to_string(folder.path().join("map.csv")).unwrap();
    let fit = FIT.replace(" --no-plots", "");
    let place = |line: &str, x: &str| match line.rsplitn(3, ',').collect::<Vec<_>>().as_slice() {
        [y, _, row] if *y != "y" => format!("{row},{x},{y}\n"),
        _ => format!("{line}\n"),
    };
    for (x, picture) in [("1e17", "map"), ("1e308", "items")] {
        write(&folder, "far.csv", &text.lines().map(|line| place(line, x)).collect::<String>());
        let ended = succeeds(&folder, &format!("batch far.csv --by x,y {fit} --out {picture}"));
        let files = names(&folder.path().join(picture));
        assert_eq!(files, ["batch.csv", "batch.json", &format!("{picture}.png"), &format!("{picture}.svg")]);
        let told = ended.err.matches("no map is drawn: ").count();
        assert_eq!(told, usize::from(picture == "items"), "{}", ended.err);
    }
    // Scattered places are shown one by one.
    map(&folder, 2, 4);
    let text = fs::read_to_string(folder.path().join("map.csv")).unwrap();
    let place = |line: &str| match line.rsplitn(3, ',').collect::<Vec<_>>().as_slice() {
        [y, x, row] if *y != "y" => format!("{row},{0},{0}\n", x.parse::<u8>().unwrap() + 2 * y.parse::<u8>().unwrap()),
        _ => format!("{line}\n"),
    };
    write(&folder, "far.csv", &text.lines().map(place).collect::<String>());
    let ended = succeeds(&folder, &format!("batch far.csv --by x,y {fit} --out scattered"));
    let words = "no map is drawn: the places are no grid: 4 lie in 4 columns and 4 rows";
    assert!(ended.err.contains(words), "{}", ended.err);
    assert!(names(&folder.path().join("scattered")).contains(&"items.svg".to_owned()));
}

#[test]
fn a_model_that_was_chosen_is_in_each_row() {
    let folder = TempDir::new().unwrap();
    simulated(&folder, 130.0, 1, "a.csv");
    let fit = FIT.replace("--fix delta=2.5 ", "--model auto ");
    succeeds(&folder, &format!("batch a.csv {fit} --out all"));
    succeeds(&folder, &format!("a.csv {fit} --out alone"));
    let alone = outcome(&folder, "alone");
    let kept: Vec<String> =
        alone.choice.unwrap().variants.into_iter().filter(|v| v.standing == Standing::Kept).map(|v| v.name).collect();
    let all = batch(&folder, "all");
    let fit = all.items[0].fit.as_ref().unwrap();
    assert_eq!((&[fit.model.clone()][..], fit.chi2), (&kept[..], alone.chi2));
    assert_eq!(all.compared.unwrap().len(), 1);
    let csv = fs::read_to_string(folder.path().join("all/batch.csv")).unwrap();
    assert!(csv.starts_with("item,model,verdict,") && csv.contains(&format!("\na,{},", kept[0])), "{csv}");
    succeeds(&folder, &format!("batch a.csv {FIT} --out one"));
    let one = batch(&folder, "one");
    assert_eq!((one.items[0].fit.as_ref().unwrap().model.as_str(), one.compared), ("blend", None));
}

#[test]
fn rows_of_what_cannot_be_read_now_are_not_lost() {
    let folder = TempDir::new().unwrap();
    simulated(&folder, 130.0, 1, "a.csv");
    simulated(&folder, 140.0, 2, "b.csv");
    let command = format!("batch a.csv b.csv {FIT} --out all");
    succeeds(&folder, &command);
    let table = bytes(&folder, "all");
    let journal = folder.path().join("all/batch.journal");
    let away = |name: &str| fs::rename(folder.path().join(name), folder.path().join(format!("{name}.away"))).unwrap();
    let back = |name: &str| fs::rename(folder.path().join(format!("{name}.away")), folder.path().join(name)).unwrap();
    // Nothing can be read: table and journal of a batch that was stopped stay.
    fs::write(&journal, "a line\n").unwrap();
    away("a.csv");
    away("b.csv");
    ends(&folder, &command, 1);
    assert_eq!((bytes(&folder, "all"), fs::read_to_string(&journal).unwrap()), (table.clone(), "a line\n".to_owned()));
    // One can: the row of the other waits in the journal.
    back("a.csv");
    let ended = ends(&folder, &command, 1);
    assert!(ended.err.contains("batch.journal keeps rows of items that cannot be read now: 1"), "{}", ended.err);
    assert_eq!(batch(&folder, "all").counts.errors, 1);
    back("b.csv");
    let ended = succeeds(&folder, &command);
    assert!(ended.err.contains("2 of 2 items are fitted already; 0 to do"), "{}", ended.err);
    assert_eq!(bytes(&folder, "all"), table);
    assert!(!journal.exists());
}
