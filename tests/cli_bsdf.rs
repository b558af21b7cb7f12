//! `morpho-fit bsdf` and `import-bsdf` of the real program: there and back, and what they refuse.

#[path = "support/program.rs"]
mod program;

use morpho_fit::bsdf::{MeasuredBsdf, MeasuredFields};
use morpho_fit::dataset::{Dataset, ReadOptions, read_csv};
use morpho_fit::optics::{HybridModel, ReflectivityModel, Structure};
use program::{names, outcome, run, succeeds};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

/// A small table.
const SMALL: &str = "bsdf --tolerance 0.04 --directions 500";

fn certificate(folder: &TempDir, place: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join(place).join("certificate.json")).unwrap()).unwrap()
}

fn dataset(folder: &TempDir, name: &str) -> Dataset {
    read_csv(&fs::read(folder.path().join(name)).unwrap(), &ReadOptions::default()).unwrap()
}

#[test]
fn the_files_are_certified() {
    let folder = TempDir::new().unwrap();
    let ended = succeeds(&folder, &format!("{SMALL} --out here"));
    let expected = ["albedo.png", "albedo.svg", "certificate.json", "wing_rgb.bsdf", "wing_spectral.bsdf"];
    assert_eq!(names(&folder.path().join("here")), expected);
    let about = certificate(&folder, "here");
    assert_eq!(
        (about["schema"].as_str(), about["structure"]["d_air_nm"].as_f64()),
        (Some("morpho-fit/bsdf/1"), Some(141.0))
    );
    for (index, name) in ["wing_spectral.bsdf", "wing_rgb.bsdf"].into_iter().enumerate() {
        let (about, bytes) = (&about["files"][index], fs::read(folder.path().join("here").join(name)).unwrap());
        assert_eq!((about["file"].as_str(), about["bytes"].as_u64()), (Some(name), Some(bytes.len() as u64)));
        assert!(ended.out.contains(&bytes.len().to_string()), "{}", ended.out);
        let table = MeasuredBsdf::new(MeasuredFields::read(&bytes).unwrap()).unwrap();
        assert_eq!(table.fields().channels() as u64, about["channels"].as_u64().unwrap());
        assert!(table.fields().description.contains("d_air 141.0 nm") && !table.is_isotropic());
        let number = |path: &str| about["certificate"].pointer(path).and_then(Value::as_f64).unwrap();
        assert!(number("/reciprocity_at_nodes") <= 1e-6 && number("/error/rms") <= 0.04, "{about}");
        assert!((0.1..=1.0).contains(&number("/albedo_of_table/largest")), "{about}");
        assert!((0.1..=0.4).contains(&number("/albedo_of_model/largest")), "{about}");
    }
    assert_eq!(about["files"][0]["wavelengths_nm"][0], 360.0);
    assert!(about["files"][1]["below_zero_became_zero"]["largest_share_of_peak"].as_f64().unwrap() > 0.0);
    // The same bytes again, whatever the number of threads.
    succeeds(&folder, &format!("{SMALL} --out again --quiet"));
    for name in expected {
        let read = |place: &str| fs::read(folder.path().join(place).join(name)).unwrap();
        assert!(read("here") == read("again"), "{name}");
    }
}

#[test]
fn what_is_imported_is_the_model_and_its_fit_finds_the_structure() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "bsdf --wavelengths 400:650 --directions 2000 --out here --quiet");
    let numbers = &certificate(&folder, "here")["files"][0]["certificate"];
    let number = |path: &str| numbers.pointer(path).and_then(Value::as_f64).unwrap();
    let (peak, rms, worst) = (number("/peak_per_sr"), number("/error/rms"), number("/error/worst"));
    let planes = "--theta 0|20|40 --phi -60:60:5 --wavelengths 400:650";
    succeeds(&folder, &format!("import-bsdf here/wing_spectral.bsdf {planes} --out wing.csv"));
    let data = dataset(&folder, "wing.csv");
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let mut squares = 0.0;
    for reading in data.readings() {
        let expected = model.reflectivity(&blue, &reading.geometry, reading.polarization, reading.wavelength).unwrap();
        let off = (reading.intensity - expected).abs() / peak;
        assert!(off <= worst, "{reading:?}: {expected}, off by {off} of the peak, {worst} certified");
        squares += off * off;
    }
    let found = (squares / data.readings().len() as f64).sqrt();
    assert!(found <= 2.0 * rms, "{found} for {rms}");
    assert!(data.readings().iter().all(|reading| (400.0..=650.0).contains(&reading.wavelength)));
    succeeds(&folder, "fit wing.csv --model hybrid --out fit --no-plots --quiet");
    let fit = outcome(&folder, "fit");
    // What the interpolation leaves is no noise: the fit says so, and its intervals hold the truth.
    for (estimate, truth) in [(&fit.parameters.d_air, 141.0), (&fit.parameters.d_cuticle, 62.0)] {
        let (value, [low, high]) = (estimate.value.unwrap(), estimate.interval_95.unwrap().map(Option::unwrap));
        assert!((value - truth).abs() < 2.5 && low <= truth && truth <= high, "{estimate:?}");
    }
}

#[test]
fn planes_and_wavelengths_are_those_asked_for() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --wavelengths 400:700 --out here --quiet"));
    let all = succeeds(&folder, "import-bsdf here/wing_spectral.bsdf --theta 0 --phi 0:10:5").out;
    let all = read_csv(all.as_bytes(), &ReadOptions::default()).unwrap();
    let wavelengths = certificate(&folder, "here")["files"][0]["channels"].as_u64().unwrap();
    assert_eq!(all.readings().len() as u64, 2 * 3 * wavelengths);
    let one = succeeds(
        &folder,
        "import-bsdf here/wing_spectral.bsdf --theta 10 --phi -10|5 --omega 30 --wavelengths 450:470:10",
    );
    assert!(one.out.starts_with("# read by morpho-fit") && one.out.contains("anisotropic"), "{:.200}", one.out);
    let one = read_csv(one.out.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(one.readings().len(), 6);
    // The same plane by turning the axes of the file.
    let turned = succeeds(
        &folder,
        "import-bsdf here/wing_spectral.bsdf --theta 10 --phi -10|5 --omega 0 --across 30 --wavelengths 450:470:10",
    );
    let turned = read_csv(turned.out.as_bytes(), &ReadOptions::default()).unwrap();
    for (left, right) in one.readings().iter().zip(turned.readings()) {
        assert!((left.intensity - right.intensity).abs() < 1e-12 && left.intensity > 0.0);
    }
    // An isotropic file, made of the first azimuth.
    let mut fields = MeasuredFields::read(&fs::read(folder.path().join("here/wing_spectral.bsdf")).unwrap()).unwrap();
    let (keep, plane, channels) = (fields.theta_i.len(), fields.side * fields.side, fields.channels());
    fields.phi_i.truncate(1);
    fields.vndf.values.truncate(fields.vndf.size.iter().product::<usize>() * keep);
    fields.luminance.truncate(keep * plane);
    fields.spectra.truncate(keep * plane * channels);
    fs::write(folder.path().join("round.bsdf"), fields.into_bytes().unwrap()).unwrap();
    let round = succeeds(&folder, "import-bsdf round.bsdf --theta 0 --phi 5");
    assert!(round.out.contains("isotropic"));
    let round = read_csv(round.out.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(round.readings().len(), channels);
    assert!(round.readings().iter().all(|reading| reading.geometry.omega.abs() <= 0.0));
}

#[test]
fn a_broken_file_is_told_with_its_place_and_writes_nothing() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --out here --quiet"));
    let good = fs::read(folder.path().join("here/wing_spectral.bsdf")).unwrap();
    let length = good.len();
    for (name, bytes, said) in [
        ("half.bsdf", good[..length / 2].to_vec(), "is cut short"),
        ("head.bsdf", good[..100].to_vec(), "is cut short"),
        ("text.bsdf", b"wavelength_nm,theta_deg\n".to_vec(), "byte 0: this is no tensor file"),
        ("version.bsdf", [&good[..12], &[9, 9], &good[14..]].concat(), "byte 12: version 9.9"),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
        let ended = run(&folder, &format!("import-bsdf {name} --out never.csv"));
        assert_eq!(ended.code, 3, "{}", ended.err);
        assert!(ended.err.contains(name) && ended.err.contains("byte ") && ended.err.contains(said), "{}", ended.err);
    }
    let ended = run(&folder, "import-bsdf here/wing_rgb.bsdf --out never.csv");
    assert!(ended.code == 3 && ended.err.contains("import the spectral file"), "{}", ended.err);
    for (flags, code, said) in [
        ("--wavelengths 900:1000", 2, "360 to 830 nm"),
        ("--wavelengths 300:400:10", 2, "360 to 830 nm"),
        ("--wavelengths 401:402", 2, "401:402:STEP"),
        ("--theta 95", 2, "95 is not within -90 to 90"),
        ("--phi -90:90:0.0001", 2, "readings"),
        ("--phi 5|5", 3, "reading"),
    ] {
        let ended = run(&folder, &format!("import-bsdf here/wing_spectral.bsdf {flags} --out never.csv"));
        assert!(ended.code == code && ended.err.contains(said), "{flags}: {} {}", ended.code, ended.err);
    }
    assert_eq!(run(&folder, "import-bsdf missing.bsdf").code, 1);
    assert!(!folder.path().join("never.csv").exists());
}

/// Colours are those of all that eyes see, whatever the wavelengths of the spectral file.
#[test]
fn the_file_of_colours_does_not_go_by_the_range_of_the_spectral_one() {
    let folder = TempDir::new().unwrap();
    let straight = |place: &str, flags: &str| {
        succeeds(&folder, &format!("{SMALL} {flags} --out {place} --quiet"));
        let fields = MeasuredFields::read(&fs::read(folder.path().join(place).join("wing_rgb.bsdf")).unwrap()).unwrap();
        let mut rgb = [0.0; 3];
        let table = MeasuredBsdf::new(fields).unwrap();
        table.evaluate([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], &mut rgb).unwrap();
        rgb
    };
    let (whole, narrow, infrared) =
        (straight("a", ""), straight("b", "--wavelengths 500:600"), straight("c", "--wavelengths 1000:1200"));
    assert!(whole[2] > 0.1, "{whole:?}");
    for found in [narrow, infrared] {
        assert!(found.iter().zip(whole).all(|(found, whole)| (found - whole).abs() < 1e-5), "{found:?} for {whole:?}");
    }
}

/// A fit whose model holds in single planes is told as what it is drawn by.
#[test]
fn a_fit_of_another_model_becomes_a_file_by_hybrid() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --seed 7 --out blue.csv");
    succeeds(&folder, "blue.csv --quiet --no-plots");
    let ended = succeeds(&folder, &format!("{SMALL} fits/blue"));
    assert!(ended.out.contains("drawn by the model hybrid with ridges 750 nm apart: blend"), "{}", ended.out);
    assert!(folder.path().join("fits/blue/bsdf/wing_spectral.bsdf").exists());
}

#[test]
fn what_is_no_surface_is_refused_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    for (flags, code, said) in [
        ("--model blend", 2, "leave --model out"),
        ("--model paper", 2, "leave --model out"),
        ("--max-bytes 100000", 4, "raise --tolerance or --max-bytes"),
        ("--tolerance 0", 2, "not above 0"),
        ("--wavelengths 700:400", 2, "is not below"),
        ("--bandwidth 10", 2, "leave the averages"),
        ("--layer-spread 5", 2, "leave the averages"),
        ("--lamella-width 900", 2, "lamella_width"),
    ] {
        let ended = run(&folder, &format!("bsdf --out here --tolerance 0.04 --directions 100 {flags}"));
        assert!(ended.code == code && ended.err.contains(said), "{flags}: {} {}", ended.code, ended.err);
        assert!(names(folder.path()).is_empty(), "{flags}: {:?}", names(folder.path()));
    }
}
