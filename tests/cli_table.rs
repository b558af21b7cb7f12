//! `morpho-fit table` of the real program: what it writes, what stands in it, and what it refuses.

#[path = "support/program.rs"]
mod program;

use morpho_fit::colorimetry::{Illuminant, Integration, Observer, RgbSpace, RgbTransform};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::units::radians;
use program::{names, run, run_with, succeeds};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A small table: few angles, few wavelengths.
const SMALL: &str = "table --theta 0:30 --phi -40:40 --tolerance 3 --wavelengths 20";

fn json(folder: &TempDir, place: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join(place).join("table.json")).unwrap()).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

fn axes(about: &Value) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|axis| list(&about["axes"][axis]["values"]))
}

/// The values of an NPY file, read by the rules of `numpy.lib.format`, with the shape that its head tells.
fn npy(folder: &TempDir, place: &str) -> (Vec<usize>, Vec<f32>) {
    let file = fs::read(folder.path().join(place)).unwrap();
    assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
    let head = std::str::from_utf8(&file[10..10 + length]).unwrap();
    assert!(head.contains("'descr': '<f4'") && head.contains("'fortran_order': False") && head.ends_with('\n'));
    let tuple = head.split(['(', ')']).nth(1).unwrap().split(',').map(str::trim);
    let shape: Vec<usize> = tuple.filter(|text| !text.is_empty()).map(|text| text.parse().unwrap()).collect();
    let values: Vec<f32> =
        file[10 + length..].chunks(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect();
    assert_eq!(values.len(), shape.iter().product::<usize>());
    (shape, values)
}

#[test]
fn the_file_has_the_colours_of_the_model_at_its_nodes() {
    let folder = TempDir::new().unwrap();
    let ended = succeeds(&folder, &format!("{SMALL} --preset table1 --out here"));
    assert_eq!(names(&folder.path().join("here")), ["table.json", "table.npy", "table.png", "table.svg"]);
    let (about, (shape, values)) = (json(&folder, "here"), npy(&folder, "here/table.npy"));
    let [thetas, across, omegas] = axes(&about);
    assert_eq!(shape, [thetas.len(), across.len(), omegas.len(), 3]);
    assert_eq!(list(&about["shape"]), shape.iter().map(|&length| length as f64).collect::<Vec<_>>());
    assert_eq!((omegas.as_slice(), &about["quantity"]), (&[0.0, 90.0][..], &Value::from("linear sRGB")));
    assert_eq!(about["structure"]["d_air_nm"], 135.0);
    assert!(about["error"]["worst"].as_f64().unwrap() <= 3.0 && ended.out.contains("3 allowed"), "{}", ended.out);
    assert_eq!(about["bytes"].as_u64().unwrap(), 4 * values.len() as u64);
    let grid = Wavelengths::visible(20.0).unwrap();
    let integration = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65).unwrap();
    let transform = RgbTransform::adapted(RgbSpace::Srgb, integration.white()).unwrap();
    let mut checked = 0;
    for (i, &theta) in thetas.iter().enumerate() {
        for (j, &mirror) in across.iter().enumerate().filter(|(_, mirror)| (*mirror - theta).abs() <= 40.0) {
            for (k, &omega) in omegas.iter().enumerate() {
                let [theta, phi, omega] = [theta, mirror - theta, omega].map(radians);
                let seen = Geometry { theta, phi, omega };
                let read = |w| {
                    let model = BlendModel::default();
                    model.reflectivity(&Structure::table1(), &seen, Polarization::Unpolarized, w).unwrap()
                };
                let spectrum: Vec<f64> = grid.iter().map(read).collect();
                let expected = transform.linear(integration.xyz(&spectrum).unwrap()).unwrap();
                let first = 3 * ((i * across.len() + j) * omegas.len() + k);
                for (found, expected) in values[first..first + 3].iter().zip(expected) {
                    assert!((f64::from(*found) - expected).abs() < 1e-6, "{seen:?}: {found} for {expected}");
                }
                checked += 1;
            }
        }
    }
    assert!(checked > 100);
}

#[test]
fn text_has_the_same_values() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --out here"));
    let (_, values) = npy(&folder, "here/table.npy");
    // The other format takes the place of the first.
    succeeds(&folder, &format!("{SMALL} --out here --format csv --quiet"));
    assert_eq!(names(&folder.path().join("here")), ["table.csv", "table.json", "table.png", "table.svg"]);
    let text = fs::read_to_string(folder.path().join("here/table.csv")).unwrap();
    assert!(text.starts_with("theta_deg,theta_plus_phi_deg,omega_deg,red,green,blue\n0,-40,0,"), "{text:.100}");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let cells = reader
        .records()
        .flat_map(|row| row.unwrap().iter().skip(3).map(|cell| cell.parse::<f32>().unwrap()).collect::<Vec<_>>());
    assert_eq!(cells.collect::<Vec<_>>(), values);
}

#[test]
fn spectra_and_views_and_the_hybrid_are_tabled_too() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --spectra --out spectra"));
    let (about, (shape, values)) = (json(&folder, "spectra"), npy(&folder, "spectra/table.npy"));
    assert_eq!((shape[3], list(&about["axes"][3]["values"]).len()), (21, 21));
    assert!(values.iter().all(|value| (0.0..=1.0001).contains(value)));
    let narrow = "table --theta 0:10 --phi -20:0 --tolerance 5 --wavelengths 20";
    succeeds(&folder, &format!("{narrow} --across view --out view"));
    let about = json(&folder, "view");
    let [_, phis, _] = axes(&about);
    assert_eq!((about["axes"][1]["name"].as_str(), phis[0], phis[phis.len() - 1]), (Some("phi"), -20.0, 0.0));
    succeeds(&folder, &format!("{narrow} --model hybrid --out hybrid"));
    let about = json(&folder, "hybrid");
    assert!(axes(&about)[2].len() > 2 && about["between_nodes"].as_str().unwrap().ends_with("in omega"));
}

#[test]
fn wavelengths_are_a_part_of_the_tolerance() {
    let folder = TempDir::new().unwrap();
    let fit = Path::new(env!("CARGO_MANIFEST_DIR")).join("fits/blue_morpho").to_string_lossy().into_owned();
    let line = ["table", &fit, "--theta", "0:20", "--phi", "-30:30", "--tolerance", "2", "--out", "here"];
    let ended = run_with(&folder, &line);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(ended.out.contains("wavelengths by 1 nm"), "{}", ended.out);
    let about = json(&folder, "here");
    assert!(
        about["wavelengths_nm"]["step"].as_f64().unwrap() > 1.0 && about["error"]["worst"].as_f64().unwrap() <= 2.0
    );
    assert_eq!(about["error"]["reference_wavelengths_nm"]["step"], 1.0);
    let strip = succeeds(&folder, "table --theta 30:30 --phi -60:0 --omega 90:90 --wavelengths 20 --out strip");
    assert!(strip.out.starts_with("d_air 141"), "{}", strip.out);
    assert_eq!(json(&folder, "strip")["shape"][0], 1);
}

#[test]
fn what_cannot_be_tabled_is_refused_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    for (flags, code, said) in [
        ("--theta 30:0", 2, "30 is above 0"),
        ("--theta 0:95", 2, "95 is not within -90 to 90"),
        ("--phi 0:10:1", 2, "chooses its nodes itself"),
        ("--omega -10:90", 2, "mirror images"),
        ("--tolerance 0", 2, "not above 0"),
        ("--max-nodes 500 --wavelengths 20", 4, "raise --tolerance or --max-nodes"),
        // Refused before anything is computed, however little is asked of the colours.
        ("--max-nodes 100 --tolerance 90 --wavelengths 20", 4, "100 are allowed"),
        // A jump, which no number of nodes can hold.
        ("--delta=-10 --wavelengths 20", 2, "fall into their own shadow"),
        ("--model paper --snell printed --wavelengths 20", 2, "no refracted ray"),
        ("--format npz", 2, "possible values"),
        ("nothing.json", 1, "cannot be read"),
    ] {
        let ended = run(&folder, &format!("table --out here {flags}"));
        assert_eq!(ended.code, code, "{flags}: {}", ended.err);
        assert!(ended.err.contains(said) && !ended.err.contains("panicked"), "{flags}: {}", ended.err);
        assert!(names(folder.path()).is_empty(), "{flags} left {:?}", names(folder.path()));
    }
}

/// Plane waves where they are enough: a band of 1 nm moves no colour, a period that varies by 20 nm does.
#[test]
fn averages_are_computed_where_the_tolerance_needs_them() {
    let folder = TempDir::new().unwrap();
    for (flags, computed) in [("--bandwidth 1", false), ("--period-spread 20", true)] {
        let told = succeeds(&folder, &format!("{SMALL} {flags} --out out"));
        let about = json(&folder, "out");
        let averages = &about["averages"];
        assert_eq!(averages["computed"], computed, "{flags}: {averages}");
        let missed = averages["difference_of_plane_waves"].as_f64().unwrap();
        assert_eq!(missed > 2.7, computed, "{flags}: {missed}");
        // What the table is judged by is the averaged model in either case.
        assert!(about["error"]["worst"].as_f64().unwrap() <= 3.0);
        let out = told.out.split_whitespace().collect::<Vec<&str>>().join(" ");
        assert!(out.contains(if computed { "so they are computed" } else { "and stand for them" }), "{out}");
    }
    succeeds(&folder, &format!("{SMALL} --out plain"));
    assert!(json(&folder, "plain")["averages"].is_null());
}
