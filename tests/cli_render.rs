//! `morpho-fit render` of the real program: what it writes, what stands in it, and what it refuses.

#[path = "support/program.rs"]
mod program;

use morpho_fit::export::png16;
use morpho_fit::render::Raster;
use program::{Ended, names, run, succeeds, with_blue};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Small pictures of a small butterfly, few wavelengths.
const SMALL: &str = "render --size 64x48 --map-size 96 --samples 2 --wavelengths 20 --tolerance 3";
/// The same with maps that are given.
const GIVEN: &str = "render --size 64x48 --samples 2 --wavelengths 20 --tolerance 3";

fn json(folder: &TempDir, place: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.path().join(place).join("render.json")).unwrap()).unwrap()
}

fn picture(folder: &TempDir, place: &str) -> Raster {
    Raster::from_png(&fs::read(folder.path().join(place)).unwrap()).unwrap()
}

/// Mean of blue over the pixels of wing.
fn blueness(raster: &Raster) -> f32 {
    let (mut sum, mut count) = (0.0, 0.0);
    for row in 0..raster.height() {
        for column in 0..raster.width() {
            if raster.alpha(column, row).is_none_or(|alpha| alpha > 0.5) {
                sum += raster.at(column, row, 2) - raster.at(column, row, 0);
                count += 1.0;
            }
        }
    }
    sum / count
}

#[test]
fn the_four_views_of_the_paper_are_written_and_are_blue() {
    let folder = TempDir::new().unwrap();
    let ended = succeeds(&folder, &format!("{SMALL} --out here"));
    let here = folder.path().join("here");
    let mut expected: Vec<String> =
        [10, 30, 50, 60].iter().flat_map(|view| [format!("view_{view}.exr"), format!("view_{view}.png")]).collect();
    expected.extend(["render.json".to_owned(), "views.png".to_owned()]);
    expected.sort();
    assert_eq!(names(&here), expected);
    let first = picture(&folder, "here/view_10.png");
    assert_eq!((first.width(), first.height(), first.channels()), (64, 48, 4));
    assert!(blueness(&first) > 0.2, "{}", blueness(&first));
    let all = picture(&folder, "here/views.png");
    assert_eq!((all.width(), all.height()), (64, 4 * 48));
    let upper = &all.values()[..first.values().len()];
    assert_eq!(upper, first.values(), "the first view stands at the top");
    let about = json(&folder, "here");
    assert_eq!(about["schema"], "morpho-fit/render/1");
    assert_eq!((&about["model"], &about["structure"]["d_air_nm"]), (&"hybrid".into(), &141.0.into()));
    assert_eq!(about["pictures"][3]["view_deg"], 60.0);
    assert!(about["colours"]["error"]["worst"].as_f64().unwrap() <= 3.0);
    let exposure = about["exposure"]["factor"].as_f64().unwrap();
    assert!(exposure > 0.0 && ended.out.contains(&format!("exposure {exposure}")), "{}", ended.out);
}

/// The bytes that an exposure brought about come back when it is given, and a second run repeats the first.
#[test]
fn the_same_settings_give_the_same_bytes_on_any_number_of_threads() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --view 20,40 --out one --threads 1"));
    let factor = json(&folder, "one")["exposure"]["factor"].as_f64().unwrap();
    succeeds(&folder, &format!("{SMALL} --view 20,40 --out two --threads 3 --exposure {factor}"));
    let read = |place: &str| fs::read(folder.path().join(place)).unwrap();
    for name in ["view_20.png", "view_40.exr", "views.png"] {
        assert!(read(&format!("one/{name}")) == read(&format!("two/{name}")), "{name}");
    }
}

#[cfg(feature = "cli")]
#[test]
fn the_exr_holds_linear_light_without_the_exposure() {
    let folder = TempDir::new().unwrap();
    let flat = "--plain --base 0.2 --mask black.png";
    // No structural colour, all wing: the base alone, in a vertical sun. Its red is 1.75 times its reflectance.
    let black = png16(8, 8, 2, &[0.0, 1.0].repeat(64)).unwrap();
    fs::write(folder.path().join("black.png"), black).unwrap();
    succeeds(&folder, &format!("{GIVEN} {flat} --view 0 --exposure 0.5 --out here"));
    let file = folder.path().join("here/view_0.exr");
    let pixels = |size: exr::math::Vec2<usize>, _: &_| vec![[0.0_f32; 4]; size.0 * size.1];
    let set = |pixels: &mut Vec<[f32; 4]>, at: exr::math::Vec2<usize>, rgba: (f32, f32, f32, f32)| {
        pixels[at.1 * 64 + at.0] = rgba.into();
    };
    let image = exr::prelude::read_first_rgba_layer_from_file(file, pixels, set).unwrap();
    let [red, green, blue, alpha] = image.layer_data.channel_data.pixels[24 * 64 + 32];
    for (found, expected) in [(red, 0.35), (green, 0.166), (blue, 0.092), (alpha, 1.0)] {
        assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
    }
    // The PNG has it: half of 0.35 is 116.6 of 255 in sRGB.
    let shown = picture(&folder, "here/view_0.png");
    assert!((shown.at(32, 24, 0) * 255.0 - 117.0).abs() <= 1.0, "{}", shown.at(32, 24, 0) * 255.0);
}

#[test]
fn a_flip_book_is_one_animated_file() {
    let folder = TempDir::new().unwrap();
    let turn = "--turn light --frames 5 --frames-png --d-air-spread 6";
    let ended = succeeds(&folder, &format!("{SMALL} {turn} --out here"));
    let expected: Vec<String> = (1..=5).map(|frame| format!("frame_000{frame}.png")).collect();
    let found = names(&folder.path().join("here"));
    assert_eq!(found[..5], expected);
    assert_eq!(found[5..], ["render.json", "turn.png"]);
    let file = fs::read(folder.path().join("here/turn.png")).unwrap();
    let reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
    assert_eq!(reader.info().animation_control.unwrap().num_frames, 5);
    // The first frame is the picture of the sun at 0.
    assert_eq!(picture(&folder, "here/turn.png"), picture(&folder, "here/frame_0001.png"));
    assert!(ended.out.contains("the sun swings from -60° to 60° in the azimuth -90°, seen from 10°"), "{}", ended.out);
    // The gaps of the map are those of its wing, not of its range.
    let [low, high] = [0, 1].map(|end| json(&folder, "here")["gaps_nm"][end].as_f64().unwrap());
    assert!((126.0..=130.0).contains(&low) && (152.0..=156.0).contains(&high), "{low} to {high}");
    assert!(ended.out.contains(&format!("d_air from {low:.1} to {high:.1} nm")), "{}", ended.out);
}

#[test]
fn a_fit_is_drawn_with_its_structure_by_the_hybrid_model() {
    let folder = with_blue();
    succeeds(&folder, "blue.csv --quiet --no-plots");
    let ended = succeeds(&folder, &format!("{SMALL} fits/blue --view 10"));
    assert!(ended.out.contains("drawn by the model hybrid"), "{}", ended.out);
    let about = json(&folder, "fits/blue/wing");
    assert!((about["structure"]["d_air_nm"].as_f64().unwrap() - 141.0).abs() < 1.0);
    assert_eq!(about["model"], "hybrid");
    // What changes from run to run stands on the terminal alone.
    assert!(about.get("seconds").is_none() && ended.out.contains(" s: maps "), "{}", ended.out);
}

/// What an instrument averages is no part of the wing.
#[test]
fn the_averages_of_a_fit_that_are_the_instruments_are_left_out() {
    let folder = with_blue();
    // Data of another model, which the hybrid misses; it is drawn all the same.
    let fitted = run(&folder, "blue.csv --quiet --no-plots --model hybrid --fix d_air=141 --out plain");
    assert_eq!(fitted.code, 0);
    let file = folder.path().join("plain/fit.json");
    let mut fit: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    fit["settings"]["averages"] = serde_json::json!({ "bandwidth": 10.0, "period_spread": 5.0, "layer_spread": 3.0 });
    fs::create_dir(folder.path().join("averaged")).unwrap();
    fs::write(folder.path().join("averaged/fit.json"), fit.to_string()).unwrap();
    let values = "--d-air 141 --d-cuticle 62 --lamella-width 300 --delta 0 --phi-alpha 0.2 --view 30 --exposure 1";
    let draws = |place: &str| succeeds(&folder, &format!("{SMALL} {place} {values}")).out;
    draws("plain");
    let told = draws("averaged");
    assert!(
        told.contains("left out: bandwidth (the instrument's)") && told.contains("period varies by 5 nm"),
        "{told}"
    );
    assert!(told.contains("each layer varies by 3 nm"), "{told}");
    assert!(picture(&folder, "plain/wing/view_30.png") != picture(&folder, "averaged/wing/view_30.png"));
    let spread = succeeds(&folder, &format!("{SMALL} --period-spread 5 --layer-spread 3 {values} --out spread"));
    assert!(!spread.out.contains("left out"), "{}", spread.out);
    assert_eq!(picture(&folder, "spread/view_30.png"), picture(&folder, "averaged/wing/view_30.png"));
}

/// Written maps, read again, make the picture that they were written with.
#[test]
fn maps_come_back_as_they_were_written() {
    let folder = TempDir::new().unwrap();
    let more = "--view 30 --exposure 1 --no-exr";
    succeeds(&folder, &format!("{SMALL} {more} --write-maps --out one"));
    let maps = "--height-map one/height.png --angle-map one/angle.png --mask one/mask.png --base-map one/base.png";
    succeeds(&folder, &format!("{GIVEN} {more} {maps} --out two"));
    let (one, two) = (picture(&folder, "one/view_30.png"), picture(&folder, "two/view_30.png"));
    let differences = one.values().iter().zip(two.values()).map(|(a, b)| 255.0 * (a - b).abs());
    // 16 bits of height are a slope of 0.0001.
    assert!(differences.fold(0.0, f32::max) <= 3.5);
    assert!(json(&folder, "two")["maps"]["mask"].as_str().unwrap().ends_with("mask.png"));
}

#[track_caller]
fn refused(folder: &TempDir, arguments: &str, code: i32, words: &[&str]) {
    let Ended { code: found, err, .. } = run(folder, &format!("{GIVEN} {arguments} --out refused"));
    assert_eq!(found, code, "{arguments}: {err}");
    for word in words {
        assert!(err.contains(word), "{arguments}: `{word}` is not in {err}");
    }
    assert!(!folder.path().join("refused").exists(), "{arguments}: something was written");
}

#[test]
fn broken_maps_are_refused_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let whole = png16(32, 32, 1, &vec![0.5; 1024]).unwrap();
    write("whole.png", &whole);
    write("small.png", &png16(16, 8, 1, &vec![0.5; 128]).unwrap());
    write("cut.png", &whole[..whole.len() / 2]);
    write("empty.png", b"");
    // The last byte of the checksum of its pixels.
    let mut bent = whole.clone();
    let at = bent.len() - 13;
    bent[at] ^= 1;
    write("bent.png", &bent);
    write("none.png", &png16(4, 4, 2, &[1.0, 0.0].repeat(16)).unwrap());
    write("text.png", b"wavelength_nm,theta_deg\n");
    // A head that tells of 20000 columns, with its right checksum: the size is refused before any pixel is read.
    let mut wide = Vec::new();
    png::Encoder::new(&mut wide, 20_000, 1).write_header().unwrap();
    write("wide.png", &wide);
    for (name, words) in [
        ("cut.png", "cut.png: not a PNG that can be read: damaged: it is cut short"),
        ("bent.png", "bent.png: not a PNG that can be read: damaged: a checksum does not match"),
        ("empty.png", "empty.png: not a PNG that can be read"),
        ("text.png", "text.png: not a PNG that can be read"),
        ("wide.png", "wide.png: 20000 × 1 pixels; allowed: 1 to 16384"),
    ] {
        refused(&folder, &format!("--mask {name}"), 3, &[words]);
        refused(&folder, &format!("--height-map {name}"), 3, &[words]);
    }
    let sizes = "the angle map is 16 × 8 pixels, the height map 32 × 32";
    refused(&folder, "--height-map whole.png --angle-map small.png", 3, &[sizes]);
    refused(&folder, "--height-map absent.png", 1, &["absent.png"]);
    refused(&folder, "--mask small.png", 3, &["16 × 8 pixels", "as wide as high"]);
    refused(&folder, "--mask none.png", 3, &["no wing anywhere"]);
    refused(&folder, "--mask whole.png --map-size 64", 2, &["cannot be used with"]);
    fs::create_dir(folder.path().join("folder")).unwrap();
    refused(&folder, "--mask folder", 2, &["is a folder; give the name of a file"]);
}

#[test]
fn settings_that_cannot_be_are_refused_with_what_can() {
    let folder = TempDir::new().unwrap();
    refused(&folder, "--model paper", 2, &["leave it out"]);
    refused(&folder, "--model blend", 2, &["leave it out"]);
    refused(&folder, "--view 10,20,10.0", 2, &["10 stands there twice"]);
    refused(&folder, "--map-size 64x32", 2, &["no square"]);
    refused(&folder, "--view 95", 2, &["-89 to 89"]);
    refused(&folder, "--exposure 0", 2, &["above 0"]);
    refused(&folder, "--background pink", 2, &["six digits"]);
    refused(&folder, "--light 20,x", 2, &["not a number"]);
    refused(&folder, "--base 0.6", 2, &["0 to 0.571"]);
    refused(&folder, "--relief 3", 2, &["-1 to 1"]);
    refused(&folder, "--d-air-map a.png", 2, &["--d-air-range"]);
    refused(&folder, "--frames-png", 2, &["--turn"]);
    refused(&folder, "--plain --d-air-spread 5", 2, &["cannot be used with"]);
    refused(&folder, "--d-air-spread 100", 2, &["0 to 0.4 of the gap"]);
    refused(&folder, "--a 900", 2, &["at most the spacing"]);
    refused(&folder, "--tolerance 0.000001", 4, &["asked for"]);
    assert!(!Path::new(folder.path()).join("fits").exists());
}
