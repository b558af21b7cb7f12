//! Words of the command line as Python strings.

use super::errors::refused;
use crate::geometry::Polarization;
use crate::optics::{Admittance, Snell};
use pyo3::PyResult;

/// The value of `word` among `choices`; `what` names the argument.
pub(crate) fn choose<T: Clone>(what: &str, word: &str, choices: &[(&str, T)]) -> PyResult<T> {
    if let Some((_, value)) = choices.iter().find(|(name, _)| *name == word) {
        return Ok(value.clone());
    }
    let names: Vec<String> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    Err(refused(format!("{what} is \"{word}\"; it must be {}", names.join(" or "))))
}

pub(crate) fn polarization(word: &str) -> PyResult<Polarization> {
    let words = [Polarization::Unpolarized, Polarization::S, Polarization::P].map(|one| (one.word(), one));
    choose("polarization", word, &words)
}

const SNELL: [(&str, Snell); 2] = [("right", Snell::Right), ("printed", Snell::Printed)];
const ADMITTANCE: [(&str, Admittance); 2] =
    [("mean", Admittance::Mean), ("per-polarization", Admittance::PerPolarization)];

pub(crate) fn snell(word: &str) -> PyResult<Snell> {
    choose("snell", word, &SNELL)
}

pub(crate) fn admittance(word: &str) -> PyResult<Admittance> {
    choose("admittance", word, &ADMITTANCE)
}

pub(crate) fn of_snell(snell: Snell) -> &'static str {
    SNELL.iter().find(|(_, one)| *one == snell).map_or("", |(word, _)| word)
}

pub(crate) fn of_admittance(admittance: Admittance) -> &'static str {
    ADMITTANCE.iter().find(|(_, one)| *one == admittance).map_or("", |(word, _)| word)
}
