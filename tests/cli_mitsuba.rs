//! `morpho-fit render --write-mitsuba` of the real program: the scene's files, and what it refuses.

#[path = "support/program.rs"]
mod program;

use morpho_fit::export::png16;
use morpho_fit::render::{Mesh, Raster};
use program::{Ended, names, run, succeeds};
use roxmltree::{Document, Node};
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A small wing, and a coarse table of its surface.
const SMALL: &str = "render --size 64x48 --map-size 48x48 --samples 3 --wavelengths 20 --tolerance 3 --write-mitsuba --bsdf-tolerance 0.1";
const FILES: [&str; 11] = [
    "angle.png",
    "base.png",
    "certificate.json",
    "coverage.png",
    "render.py",
    "scene.xml",
    "share.png",
    "turned.py",
    "wing.ply",
    "wing_rgb.bsdf",
    "wing_spectral.bsdf",
];

/// [`SMALL`] with maps that are given.
fn given() -> String {
    SMALL.replace("--map-size 48x48", "")
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

fn map(folder: &Path, name: &str) -> Raster {
    Raster::from_png(&fs::read(folder.join(name)).unwrap()).unwrap()
}

/// Vertices and triangles of a binary PLY file, read by its own head.
fn parsed(path: &Path) -> (Vec<HashMap<String, f32>>, Vec<[u32; 3]>) {
    let bytes = fs::read(path).unwrap();
    let end = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let head = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(head.starts_with("ply\nformat binary_little_endian 1.0\n"), "{head}");
    let count = |of: &str| -> usize {
        let start = format!("element {of} ");
        head.lines().find_map(|line| line.strip_prefix(&start)).unwrap().parse().unwrap()
    };
    let properties: Vec<&str> = head.lines().filter_map(|line| line.strip_prefix("property float ")).collect();
    let (vertices, faces) = bytes[end..].split_at(4 * properties.len() * count("vertex"));
    let four = |bytes: &[u8]| <[u8; 4]>::try_from(bytes).unwrap();
    let vertex = |bytes: &[u8]| {
        let values = bytes.chunks_exact(4).map(|value| f32::from_le_bytes(four(value)));
        properties.iter().map(|name| (*name).to_owned()).zip(values).collect()
    };
    assert_eq!(faces.len(), 13 * count("face"));
    let face = |bytes: &[u8]| {
        assert_eq!(bytes[0], 3);
        [1, 5, 9].map(|at| u32::from_le_bytes(four(&bytes[at..at + 4])))
    };
    let vertices = vertices.chunks_exact(4 * properties.len()).map(vertex).collect();
    (vertices, faces.chunks_exact(13).map(face).collect())
}

/// The value of the first element with this name.
fn value<'a>(scene: &'a Document<'_>, name: &str) -> &'a str {
    let named = |node: &Node<'_, '_>| node.attribute("name") == Some(name);
    scene.descendants().find(named).unwrap_or_else(|| panic!("{name}")).attribute("value").unwrap()
}

#[test]
fn the_scene_holds_camera_and_sun_of_the_pictures() {
    let folder = TempDir::new().unwrap();
    let ended = succeeds(&folder, &format!("{SMALL} --view 25,-40 --light 30,90 --exposure 0.5 --mesh 9 --out here"));
    let here = folder.path().join("here/mitsuba");
    assert_eq!(names(&here), FILES);
    assert!(ended.out.contains("render.py -e 0.5 25 -40"), "{}", ended.out);
    let xml = text(&here.join("scene.xml"));
    let scene = Document::parse(&xml).unwrap();
    assert!(xml.contains("render.py -e 0.5 25 -40"), "the head names the command");
    let number = |name: &str| value(&scene, name).parse::<f64>().unwrap();
    for (name, expected) in [("view", 25.0), ("width", 64.0), ("height", 48.0), ("samples", 9.0), ("fov", 20.0)] {
        assert!((number(name) - expected).abs() < 1e-12, "{name}");
    }
    assert_eq!((value(&scene, "material"), value(&scene, "fov_axis")), ("wing_spectral.bsdf", "smaller"));
    let node = |tag: &str| scene.descendants().find(|node| node.has_tag_name(tag)).unwrap();
    assert_eq!(node("lookat").attribute("origin"), Some("0, 0, 6"));
    assert_eq!((node("rotate").attribute("x"), node("rotate").attribute("angle")), (Some("1"), Some("$view")));
    // Light travels from the sun at 30 degrees above the upper edge down to the wing.
    let travels = ["x", "y", "z"].map(|axis| node("vector").attribute(axis).unwrap().parse::<f64>().unwrap());
    for (found, expected) in travels.into_iter().zip([0.0, -0.5, -(0.75_f64.sqrt())]) {
        assert!((found - expected).abs() < 1e-12, "{travels:?}");
    }
    assert!((number("scale") - std::f64::consts::PI).abs() < 1e-12, "a white diffuser is 1");
    // Every file that the scene names is there.
    let files = scene.descendants().filter(|node| node.attribute("name") == Some("filename"));
    let files: Vec<&str> =
        files.filter_map(|node| node.attribute("value")).filter(|name| *name != "$material").collect();
    assert_eq!(files, ["wing.ply", "coverage.png", "angle.png", "share.png", "base.png"]);
    assert!(files.iter().all(|name| here.join(name).exists()));
}

/// A ramp to the right: its slope and its ends are known.
#[test]
fn the_mesh_is_the_displaced_map() {
    let folder = TempDir::new().unwrap();
    let ramp: Vec<f32> = (0..32 * 32).map(|pixel| (pixel % 32) as f32 / 31.0).collect();
    fs::write(folder.path().join("ramp.png"), png16(32, 32, 1, &ramp).unwrap()).unwrap();
    succeeds(
        &folder,
        &format!("{} --plain --height-map ramp.png --relief 0.2 --mesh 17 --view 10 --out here", given()),
    );
    let (vertices, triangles) = parsed(&folder.path().join("here/mitsuba/wing.ply"));
    assert_eq!((vertices.len(), triangles.len()), (17 * 17, 2 * 16 * 16));
    for vertex in &vertices {
        let at = |name: &str| vertex[name];
        assert!((at("u") - 0.5 - 0.5 * at("x")).abs() < 1e-6 && (at("v") - 0.5 + 0.5 * at("y")).abs() < 1e-6);
        // 0.2 sides are 0.4 half sides, over the 31 steps between 32 pixels; the map is held beyond the middle of its outer ones.
        let place = (at("x") * 32.0 / 31.0).clamp(-1.0, 1.0);
        assert!((at("z") - 0.2 * place).abs() < 1e-4, "{vertex:?}");
        let slope = -at("nx") / at("nz");
        assert!((slope - 0.2 * 32.0 / 31.0).abs() < 1e-3 && at("ny").abs() < 1e-6, "{vertex:?}");
    }
    for triangle in triangles {
        let [a, b, c] = triangle.map(|vertex| ["x", "y"].map(|axis| vertices[vertex as usize][axis]));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!((area - 4.0 / 256.0).abs() < 1e-6, "counterclockwise, half a cell: {area}");
    }
}

#[test]
fn a_plain_wing_is_a_rectangle_with_even_maps() {
    let folder = TempDir::new().unwrap();
    // A quarter turn, grey as in the paper, and a mask without alpha.
    fs::write(folder.path().join("quarter.png"), png16(4, 4, 1, &[0.25; 16]).unwrap()).unwrap();
    fs::write(folder.path().join("half.png"), png16(4, 4, 1, &[0.5; 16]).unwrap()).unwrap();
    succeeds(&folder, &format!("{} --plain --angle-map quarter.png --mask half.png --view 10 --out here", given()));
    let here = folder.path().join("here/mitsuba");
    let (vertices, triangles) = parsed(&here.join("wing.ply"));
    assert_eq!((vertices.len(), triangles.len()), (4, 2));
    for vertex in vertices {
        let off = [vertex["z"], vertex["nz"] - 1.0, vertex["x"].abs() - 1.0, vertex["y"].abs() - 1.0];
        assert!(off.iter().all(|value| value.abs() < 1e-6), "{vertex:?}");
    }
    for (name, expected) in [
        ("angle.png", [0.5, 1.0, 0.0].as_slice()),
        ("coverage.png", &[0.5]),
        ("share.png", &[1.0]),
        // The brown of melanin, 0.03 times 1.75, 0.83, 0.46, in the encoding of sRGB.
        ("base.png", &[0.2540, 0.1715, 0.1221]),
    ] {
        let map = map(&here, name);
        for (channel, expected) in expected.iter().enumerate() {
            assert!((map.at(2, 1, channel) - expected).abs() < 1e-4, "{name}: {}", map.at(2, 1, channel));
        }
    }
}

/// The pictures are what they are without the scene.
#[test]
fn the_pictures_do_not_change() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, &format!("{SMALL} --mesh 33 --view 30 --out with"));
    let without = SMALL.replace("--write-mitsuba --bsdf-tolerance 0.1", "");
    succeeds(&folder, &format!("{without} --view 30 --out without"));
    let read = |place: &str| fs::read(folder.path().join(place)).unwrap();
    assert!(read("with/view_30.png") == read("without/view_30.png"));
    assert!(!folder.path().join("without/mitsuba").exists());
}

#[test]
fn what_a_scene_cannot_hold_is_refused_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    for (arguments, code, words) in [
        ("--turn light", 2, "cannot be used with"),
        ("--d-air-spread 5", 2, "cannot be used with"),
        ("--mesh 1", 2, "2..=2048"),
        ("--illuminant A", 2, "D65"),
        ("--observer 1964", 2, "1931"),
        ("--numerical-aperture 0.1 --model hybrid", 2, "averages"),
        ("--bsdf-tolerance 0.0001", 4, "raise --bsdf-tolerance"),
    ] {
        let Ended { code: found, err, .. } = run(&folder, &format!("{SMALL} {arguments} --out refused"));
        assert_eq!(found, code, "{arguments}: {err}");
        assert!(err.contains(words), "{arguments}: `{words}` is not in {err}");
        assert!(!folder.path().join("refused").exists(), "{arguments}: something was written");
    }
    let Ended { code, err, .. } = run(&folder, "render --mesh 64 --out refused");
    assert!(code == 2 && err.contains("--write-mitsuba"), "{err}");
    // A file where the folder should be: the pictures are not written either.
    fs::create_dir(folder.path().join("taken")).unwrap();
    fs::write(folder.path().join("taken/mitsuba"), "a file").unwrap();
    let Ended { code, .. } = run(&folder, &format!("{SMALL} --view 10 --mesh 9 --out taken"));
    assert_eq!((code, names(&folder.path().join("taken"))), (1, vec!["mitsuba".to_owned()]));
}

#[test]
fn a_mesh_of_bad_numbers_is_refused() {
    let flat = Raster::new(2, 2, 1, vec![0.5; 4]).unwrap();
    for (relief, side) in [(f64::NAN, 4), (1.5, 4), (0.1, 1), (0.1, 4096)] {
        assert!(Mesh::new(&flat, relief, side).is_err(), "{relief} {side}");
    }
}
