//! How a batch ends: the code of each item, and of all; errors in words.

use super::TABLE;
use crate::commands::fit::is_told;
use crate::exit::Outcome;
use morpho_fit::export::{Batch, BatchCounts, BatchFit};
use morpho_fit::inversion::{Parameter, Verdict};

/// Lines of an error that are told at once.
const LINES: usize = 3;

/// The exit code that a fit alone would have.
pub(super) fn code(fit: &BatchFit, required: &[Parameter]) -> u8 {
    let ended = match fit.verdict {
        Verdict::NotConverged => Outcome::NotConverged,
        verdict if verdict == Verdict::NoThickness || unknown(fit, required).next().is_some() => {
            Outcome::NotIdentifiable(String::new())
        }
        _ => Outcome::Done,
    };
    ended.code()
}

/// Those of the required parameters that the fit does not tell.
fn unknown<'a>(fit: &'a BatchFit, required: &'a [Parameter]) -> impl Iterator<Item = Parameter> + 'a {
    let told = |parameter: &Parameter| {
        let each = fit.values.each();
        each.iter().any(|(name, _, found)| *name == parameter.name() && is_told(found.status, found.sigma))
    };
    required.iter().copied().filter(move |parameter| !told(parameter))
}

/// The first cause among the items, in the order of the codes, and what it is about.
pub(super) fn ended(batch: &Batch, codes: &[u8]) -> Outcome {
    let Some(code) = codes.iter().copied().filter(|code| *code > 0).min() else { return Outcome::Done };
    let BatchCounts { items, errors, not_converged, no_thickness, .. } = batch.counts;
    let count = |count: usize, what: &str| (count > 0).then(|| format!("{what} in {count} of {items} items"));
    // What has no minimum is told as such, whatever was required of it.
    let fits = batch.items.iter().filter_map(|row| row.fit.as_ref());
    let minima: Vec<&BatchFit> = fits.filter(|fit| fit.verdict != Verdict::NotConverged).collect();
    let lacking = batch.settings.required.iter().map(|parameter| {
        let lacking = minima.iter().filter(|fit| unknown(fit, &[*parameter]).next().is_some()).count();
        count(lacking, &format!("{parameter} required but not determined"))
    });
    let parts = [
        count(errors, "an error"),
        count(not_converged, "no minimum"),
        count(no_thickness, "no thickness is determined"),
    ];
    let parts: Vec<String> = parts.into_iter().chain(lacking).flatten().collect();
    Outcome::Partly(code, format!("{}; see {TABLE}", parts.join(", ")))
}

/// An error as one line.
pub(super) fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<&str>>().join("; ")
}

/// The first lines of an error, and where the others are.
pub(super) fn first_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let more = lines.len().saturating_sub(LINES);
    let shown = lines.iter().take(LINES).copied().collect::<Vec<&str>>().join("\n");
    if more > 0 { format!("{shown}\nand more: `error` in {TABLE}") } else { shown }
}
