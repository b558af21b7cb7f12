//! Imports run downwards: a module names only lower floors.

use std::path::{Path, PathBuf};

/// Modules by floor, the ground floor first. `cli` is a crate root of its own: the compiler keeps it out of the rest.
const FLOORS: [&[&str]; 9] = [
    &["units", "numerics"],
    &["geometry", "spectrum"],
    &["optics", "colorimetry", "dataset", "optimise"],
    &["uncertainty", "synthetic", "sweep", "table", "bsdf"],
    &["inversion", "render"],
    &["tradeoff"],
    &["plot", "export"],
    &["report"],
    &["python"],
];

fn floor(module: &str) -> Option<usize> {
    FLOORS.iter().position(|modules| modules.contains(&module))
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect()
}

/// `(module, modules that it names as crate::module)` of every file but the crate's root.
fn imports() -> Vec<(PathBuf, String, Vec<String>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let name = |path: &Path| path.strip_prefix(&root).unwrap().components().next().unwrap().as_os_str().to_owned();
    sources(&root)
        .into_iter()
        .map(|path| {
            let module = name(&path).to_str().unwrap().trim_end_matches(".rs").to_owned();
            let text = std::fs::read_to_string(&path).unwrap();
            let named = text.match_indices("crate::").map(|(at, found)| {
                let rest = &text[at + found.len()..];
                rest.chars().take_while(|letter| letter.is_ascii_lowercase() || *letter == '_').collect()
            });
            (path, module, named.filter(|named: &String| !named.is_empty()).collect())
        })
        .filter(|(_, module, _)| module != "lib" && module != "cli")
        .collect()
}

#[test]
fn every_module_has_a_floor_and_names_only_lower_ones() {
    for (path, module, named) in imports() {
        let own = floor(&module).unwrap_or_else(|| panic!("{} is on no floor", path.display()));
        for other in named.iter().filter(|other| **other != module) {
            let lower = floor(other).is_some_and(|other| other < own);
            assert!(lower, "{} names {other}", path.display());
        }
    }
}

#[test]
fn no_module_but_the_program_touches_files_terminal_or_clock() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for path in sources(&root).into_iter().filter(|path| !path.starts_with(root.join("cli"))) {
        let text = std::fs::read_to_string(&path).unwrap();
        for word in ["std::fs", "std::io::std", "println!", "std::time", "std::env::"] {
            assert!(!text.contains(word), "{} uses {word}", path.display());
        }
    }
}

#[test]
fn no_file_is_longer_than_a_reader_can_hold() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for path in ["src", "tests", "examples", "benches"].into_iter().flat_map(|folder| sources(&root.join(folder))) {
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= 450, "{}: {lines} lines", path.display());
    }
}
