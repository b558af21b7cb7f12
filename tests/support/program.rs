//! Runs the real program in a folder of its own.
#![allow(dead_code, reason = "each test file uses a part of it")]

use assert_cmd::Command;
use morpho_fit::inversion::FitOutcome;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// How a run ended.
pub(crate) struct Ended {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

/// Runs the program in `folder`; arguments are separated by spaces.
pub(crate) fn run(folder: &TempDir, arguments: &str) -> Ended {
    run_with(folder, &arguments.split_whitespace().collect::<Vec<_>>())
}

pub(crate) fn run_with(folder: &TempDir, arguments: &[&str]) -> Ended {
    let mut command = Command::cargo_bin("morpho-fit").unwrap();
    let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
    Ended {
        code: output.status.code().unwrap(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

#[track_caller]
pub(crate) fn succeeds(folder: &TempDir, arguments: &str) -> Ended {
    let ended = run(folder, arguments);
    assert_eq!(ended.code, 0, "{arguments}: {}", ended.err);
    ended
}

/// A fresh folder with `blue.csv`, the full design with noise.
pub(crate) fn with_blue() -> TempDir {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --seed 7 --out blue.csv");
    folder
}

pub(crate) fn outcome(folder: &TempDir, place: &str) -> FitOutcome {
    serde_json::from_slice(&fs::read(folder.path().join(place).join("fit.json")).unwrap()).unwrap()
}

pub(crate) fn write(folder: &TempDir, name: &str, text: &str) {
    fs::write(folder.path().join(name), text).unwrap();
}

pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
