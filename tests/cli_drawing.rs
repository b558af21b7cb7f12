//! The drawing commands of the real program: what they write, their numbers, and what they refuse.

#[path = "support/program.rs"]
mod program;

use morpho_fit::colorimetry::Lab;
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::sweep::{View, Viewing, colours};
use morpho_fit::units::radians;
use program::{names, run, run_with, succeeds, write};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const CURVES: [&str; 7] =
    ["angular.png", "angular.svg", "model.csv", "polar.png", "polar.svg", "spectra.png", "spectra.svg"];
const SWEEP: [&str; 5] = ["strip.png", "strip.svg", "sweep.csv", "sweep.png", "sweep.svg"];

/// A file or folder of the repository.
fn of_repository(place: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(place).to_string_lossy().into_owned()
}

fn empty() -> TempDir {
    TempDir::new().unwrap()
}

/// Columns by name of a table that was written.
fn column(folder: &TempDir, file: &str, name: &str) -> Vec<String> {
    let bytes = fs::read(folder.path().join(file)).unwrap();
    let mut reader = csv::Reader::from_reader(bytes.as_slice());
    let place = reader.headers().unwrap().iter().position(|heading| heading == name).unwrap();
    reader.records().map(|record| record.unwrap()[place].to_owned()).collect()
}

fn numbers(folder: &TempDir, file: &str, name: &str) -> Vec<f64> {
    column(folder, file, name).iter().map(|cell| cell.parse().unwrap()).collect()
}

/// Fails with the code and says all of `said`; the folder that it would have written to is not there.
#[track_caller]
fn fails(folder: &TempDir, arguments: &[&str], code: i32, said: &[&str]) {
    let before = names(folder.path());
    let ended = run_with(folder, arguments);
    assert_eq!(ended.code, code, "{arguments:?}: {}", ended.err);
    assert!(!ended.err.contains("panicked"), "{}", ended.err);
    for words in said {
        assert!(ended.err.contains(words), "{arguments:?}: {}", ended.err);
    }
    assert_eq!(names(folder.path()), before, "{arguments:?} left something");
}

#[test]
fn each_command_works_without_arguments() {
    let folder = empty();
    succeeds(&folder, "curves");
    succeeds(&folder, "sweep");
    assert_eq!(names(&folder.path().join("fits/blue/curves")), CURVES);
    assert_eq!(names(&folder.path().join("fits/blue/sweep")), SWEEP);
    succeeds(&folder, "paper --quiet");
    let page = fs::read_to_string(folder.path().join("fits/paper/README.md")).unwrap();
    let pictures: Vec<String> =
        names(&folder.path().join("fits/paper")).into_iter().filter(|name| name.ends_with(".svg")).collect();
    assert_eq!(pictures.len(), 6);
    assert!(pictures.iter().all(|name| page.contains(&format!("![]({name})"))), "{page}");
    let ended = succeeds(&folder, "curves --preset table1 --out here --quiet");
    assert_eq!((ended.out.as_str(), names(&folder.path().join("here"))), ("", CURVES.map(str::to_owned).to_vec()));
}

#[test]
fn a_fit_is_drawn_with_its_data_and_its_marks() {
    let folder = empty();
    let (fit, other) = (of_repository("fits/blue_morpho"), of_repository("fits/table1/fit.json"));
    let data = of_repository("data/blue_morpho.csv");
    assert_eq!(run_with(&folder, &["curves", &fit, "--data", &data, "--out", "here"]).code, 0);
    assert_eq!(names(&folder.path().join("here")), CURVES);
    let swept = run_with(&folder, &["sweep", &fit, "--mark", &other, "--out", "there"]);
    assert_eq!(swept.code, 0, "{}", swept.err);
    assert_eq!(names(&folder.path().join("there")), SWEEP);
    let chart = fs::read_to_string(folder.path().join("there/sweep.svg")).unwrap();
    assert!(chart.contains("fit blue_morpho: 141.") && chart.contains("fit table1: 13"), "the marks have names");
    // Its readings fix neither thickness: the curves say so.
    let open = run_with(&folder, &["curves", &of_repository("fits/across_ridges"), "--out", "open"]);
    assert!(open.code == 0 && open.out.contains("not determined by the fit"), "{}", open.out);
}

#[test]
fn the_table_of_a_sweep_has_the_colours_of_the_library() {
    let folder = empty();
    succeeds(&folder, "sweep --preset table1 --vary d_air=35:235 --columns 3 --angles 0|30 --out here");
    let file = "here/sweep.csv";
    let d_air = numbers(&folder, file, "d_air_nm");
    // Two rows of the chart and the strip.
    assert_eq!(d_air, [35.0, 135.0, 235.0].repeat(3));
    assert_eq!(numbers(&folder, file, "theta_deg"), [0.0, 0.0, 0.0, 30.0, 30.0, 30.0, 0.0, 0.0, 0.0]);
    let view = |gap: f64, theta: f64| View {
        structure: Structure { d_air: gap, d_cuticle: 235.0 - gap, ..Structure::table1() },
        geometry: Geometry { theta: radians(theta), phi: radians(-theta), omega: radians(90.0) },
    };
    let angles = [0.0, 30.0, 0.0];
    let views: Vec<View> = angles.iter().flat_map(|&theta| [35.0, 135.0, 235.0].map(|gap| view(gap, theta))).collect();
    let found = colours(&BlendModel::default(), &views, Polarization::Unpolarized, &Viewing::default()).unwrap();
    let columns = ["X", "Y", "Z", "L", "a", "b"].map(|name| numbers(&folder, file, name));
    for (row, colour) in found.colours.iter().enumerate() {
        let colour = colour.unwrap();
        let lab = Lab::new(colour, found.white).unwrap();
        let expected = [100.0 * colour.x, 100.0 * colour.y, 100.0 * colour.z, lab.l, lab.a, lab.b];
        for (column, expected) in columns.iter().zip(expected) {
            assert!((column[row] - expected).abs() < 1e-6, "row {row}: {} for {expected}", column[row]);
        }
    }
}

#[test]
fn light_observer_and_gamut_change_what_they_should() {
    let folder = empty();
    let small = "sweep --columns 12 --angles 0:60:15 --wavelengths 5";
    for (name, flags) in [
        ("usual", ""),
        ("wide", "--observer 1964"),
        ("lamp", "--illuminant A"),
        ("clip", "--gamut clip"),
        ("paper", "--wavelengths paper"),
    ] {
        let line = format!("{small} {flags} --out {name}")
            .replace(if name == "paper" { "--wavelengths 5" } else { "--none" }, "");
        succeeds(&folder, &line);
    }
    let of = |name: &str, heading: &str| column(&folder, &format!("{name}/sweep.csv"), heading);
    assert_eq!(of("usual", "X").len(), 12 * 6);
    for other in ["wide", "lamp", "paper"] {
        assert_ne!(of("usual", "X"), of(other, "X"), "{other}");
    }
    assert_eq!(of("usual", "X"), of("clip", "X"));
    let outside = of("usual", "outside_srgb");
    assert!(outside.iter().any(|cell| cell == "true") && outside.iter().any(|cell| cell == "false"));
    let mut differ = 0;
    for heading in ["red", "green", "blue"] {
        for ((one, other), outside) in of("usual", heading).iter().zip(&of("clip", heading)).zip(&outside) {
            assert!(one == other || outside == "true", "{heading}: {one} {other}");
            differ += usize::from(one != other);
        }
    }
    assert!(differ > 0);
}

#[test]
fn what_is_no_fit_is_refused() {
    let folder = empty();
    let fit = fs::read_to_string(of_repository("fits/table1/fit.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&fit).unwrap();
    let schema = found["schema"].as_str().unwrap();
    write(&folder, "other.json", "{\"a\": 1}");
    write(&folder, "later.json", &fit.replace(schema, "morpho-fit/99"));
    write(&folder, "cut.json", &fit[..200]);
    for command in ["curves", "sweep"] {
        let refuse = |file: &str, code, said: &[&str]| {
            fails(&folder, &[command, file, "--out", "new/folder"], code, said);
        };
        refuse("missing.json", 1, &["missing.json cannot be read"]);
        refuse("other.json", 3, &["other.json", "no result of a fit"]);
        refuse("later.json", 3, &["later.json", "morpho-fit/99"]);
        refuse("cut.json", 3, &["cut.json"]);
        refuse(".", 1, &["fit.json cannot be read"]);
    }
    fails(&folder, &["sweep", "--mark", "other.json", "--out", "new"], 3, &["other.json", "no result of a fit"]);
    fails(&folder, &["sweep", "--mark", "missing.json", "--out", "new"], 1, &["missing.json"]);
    let fit = of_repository("fits/table1");
    for (flag, value) in [("--model", "paper"), ("--n-cuticle", "1.5"), ("--layers", "7"), ("--preset", "blue")] {
        fails(&folder, &["sweep", &fit, flag, value, "--out", "new"], 2, &[flag, "fit"]);
    }
}

#[test]
fn what_cannot_be_drawn_is_a_fault_of_the_flag() {
    let folder = empty();
    let cases: [(&str, &[&str]); 19] = [
        ("sweep --vary d_air=200:35", &["200 is not below the upper bound 35"]),
        ("sweep --vary d_air=35", &["two numbers with a colon"]),
        ("sweep --vary d_air=35:300", &["at d_air = 203.6364 nm", "d_cuticle is -0.6", "narrow --vary"]),
        ("sweep --vary d_air=35:500 --keep optical-sum", &["at d_air = 2", "d_cuticle is -", "narrow --vary"]),
        ("sweep --link d_cuticle=100-d_air", &["at d_air = 101", "d_cuticle is -1 nm"]),
        ("sweep --link d_air=2*d_cuticle", &["only d_air varies"]),
        ("sweep --columns 1", &["2..=1000"]),
        ("sweep --angles 5", &["2 to 1000 rows, here are 1"]),
        ("sweep --angles 75:0:-1", &["74 is not above 75"]),
        ("sweep --angles 0:120:5", &["95 is not within -90 to 90 degrees"]),
        ("sweep --angles 0:75:0.01", &["2 to 1000 rows, here are 7501"]),
        ("sweep --strip 95", &["95 is not within -90 to 90 degrees"]),
        ("sweep --wavelengths 0", &["--wavelengths", "above 0"]),
        ("sweep --wavelengths 300", &["more than 40 nm"]),
        ("sweep --wavelengths abc", &["`abc` is not a number", "`auto` or `paper`"]),
        ("sweep --illuminant F11", &["`F11` is neither D65, A, E nor a file"]),
        ("curves --theta 95", &["95 is not within -90 to 90 degrees"]),
        ("curves --wavelength 400:500:10", &["--wavelength names 11 values; at most 8"]),
        ("curves --wavelength 0", &["wavelength is 0 nm"]),
    ];
    for (line, said) in cases {
        let arguments: Vec<&str> = line.split(' ').chain(["--out", "new/folder"]).collect();
        fails(&folder, &arguments, 2, said);
    }
    succeeds(&folder, "sweep --turn phi --at 30 --angles -60:60:20 --columns 5 --out here");
}

#[test]
fn a_light_that_cannot_be_used_is_a_fault_of_its_file() {
    let folder = empty();
    for (name, rows, said) in [
        ("column.csv", "wavelength_nm,watt\n380,1\n780,1\n", "column.csv:1: column `power` is missing"),
        ("text.csv", "wavelength_nm,power\n380,1\n500,bright\n780,1\n", "text.csv:3:2: `bright` is not a number"),
        ("gap.csv", "wavelength_nm,power\n400,1\n780,1\n", "gap.csv: the illuminant's table covers 400 to 780 nm"),
        ("twice.csv", "wavelength_nm,power\n380,1\n380,2\n780,1\n", "twice.csv"),
        ("dark.csv", "wavelength_nm,power\n380,0\n780,0\n", "dark.csv"),
        ("empty.csv", "", "empty.csv:1"),
    ] {
        write(&folder, name, rows);
        fails(&folder, &["sweep", "--illuminant", name, "--out", "new"], 3, &[said]);
    }
    // Equal power from a file is the illuminant E.
    write(&folder, "equal.csv", "wavelength_nm,power\n380,2\n780,2\n");
    let small = "sweep --columns 5 --angles 0|30 --wavelengths 10";
    succeeds(&folder, &format!("{small} --illuminant equal.csv --out one"));
    succeeds(&folder, &format!("{small} --illuminant E --out other"));
    for heading in ["X", "Y", "Z"] {
        let (one, other) = (numbers(&folder, "one/sweep.csv", heading), numbers(&folder, "other/sweep.csv", heading));
        assert!(one.iter().zip(&other).all(|(one, other)| (one - other).abs() < 1e-9), "{heading}");
    }
}

#[test]
fn data_that_cannot_be_read_are_refused() {
    let folder = empty();
    write(&folder, "none.csv", "a,b\n1,2\n");
    fails(&folder, &["curves", "--data", "missing.csv", "--out", "new"], 1, &["missing.csv cannot be read"]);
    fails(&folder, &["curves", "--data", "none.csv", "--out", "new"], 3, &["none.csv:1: column `wavelength_nm`"]);
    write(&folder, "file", "");
    fails(&folder, &["paper", "--out", "file"], 1, &["file"]);
    assert_eq!(run(&folder, "paper --colour").code, 2);
}

#[test]
fn nothing_that_was_read_or_is_of_someone_else_is_replaced() {
    let folder = empty();
    fs::copy(of_repository("data/blue_morpho.csv"), folder.path().join("model.csv")).unwrap();
    let before = fs::read(folder.path().join("model.csv")).unwrap();
    let ended = run(&folder, "curves --data model.csv --out .");
    assert!(ended.code == 2 && ended.err.contains("model.csv"), "{}", ended.err);
    assert_eq!(fs::read(folder.path().join("model.csv")).unwrap(), before);
    fs::write(folder.path().join("README.md"), "# Mine").unwrap();
    let ended = run(&folder, "paper --out .");
    assert!(ended.code == 2 && ended.err.contains("README.md"), "{}", ended.err);
    assert_eq!(fs::read_to_string(folder.path().join("README.md")).unwrap(), "# Mine");
}

#[test]
fn a_fit_beyond_its_table_of_indices_stands_without_colours() {
    let folder = empty();
    fs::write(folder.path().join("n.csv"), "wavelength_nm,n,k\n400,1.56,0\n700,1.56,0\n").unwrap();
    succeeds(&folder, "simulate --scan wavelength=400:700:10,theta=0|30,omega=90 --out s.csv");
    let ended = run(&folder, "s.csv --n-cuticle n.csv");
    assert!(ended.code == 0 && ended.err.contains("no colours are drawn"), "{}", ended.err);
    let files = names(&folder.path().join("fits/s"));
    assert!(files.contains(&"fit.json".to_owned()) && !files.contains(&"sweep.svg".to_owned()), "{files:?}");
    assert_eq!(run(&folder, "sweep fits/s --wavelengths 400:700:5 --columns 5 --angles 0|30").code, 0);
    assert_eq!(run(&folder, "curves fits/s").code, 0);
}

#[test]
fn a_page_shows_no_colour_of_thicknesses_that_are_not_determined() {
    let page = |name: &str| {
        let folder = empty();
        succeeds(&folder, &format!("{} --out here", of_repository(&format!("data/{name}.csv"))));
        fs::read_to_string(folder.path().join("here/report.html")).unwrap()
    };
    assert!(page("blue_morpho").contains("along the ridges, θ = 0°, mirrored"));
    let across = page("across_ridges");
    assert!(across.contains("across the ridges, θ = 0°") && !across.contains("along the ridges"), "{across}");
}

#[test]
fn tradeoff_leaves_a_table_a_chart_and_conclusions_of_each_study() {
    let folder = TempDir::new().unwrap();
    assert_eq!(run(&folder, "tradeoff --quick --only wavelength,stability --out t").code, 0);
    let expected: Vec<String> = ["stability", "wavelength"]
        .into_iter()
        .flat_map(|name| ["csv", "png", "svg"].map(|kind| format!("{name}.{kind}")))
        .collect();
    let found = names(&folder.path().join("t"));
    assert_eq!(
        found.iter().filter(|name| *name != "README.md").collect::<Vec<_>>(),
        expected.iter().collect::<Vec<_>>()
    );
    let csv = fs::read_to_string(folder.path().join("t/stability.csv")).unwrap();
    assert!(csv.starts_with("# ") && csv.lines().next().unwrap().contains("morpho-fit"), "the machine is named");
    assert_eq!(run(&folder, "tradeoff --only speed").code, 2);
    // Text that is not of this command is not replaced.
    fs::write(folder.path().join("t/README.md"), "mine").unwrap();
    assert_eq!(run(&folder, "tradeoff --quick --only wavelength --out t").code, 2);
}
