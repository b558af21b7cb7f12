//! How a batch ends: the code of each item, and of all.

use super::TABLE;
use crate::commands::fit::is_told;
use crate::exit::Outcome;
use morpho_fit::export::{Batch, BatchCounts, BatchFit};
use morpho_fit::inversion::{Parameter, Verdict};
use morpho_fit::report::wording;

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
    let fits = || batch.items.iter().filter_map(|row| row.fit.as_ref());
    let required = &batch.settings.required;
    let lacking = fits().filter(|fit| unknown(fit, required).next().is_some()).count();
    let names: Vec<&str> = required.iter().map(|parameter| parameter.name()).collect();
    let parts = [
        count(errors, "an error"),
        count(not_converged, "no minimum"),
        count(no_thickness, "no thickness is determined"),
        count(lacking, &format!("{} required but not determined", wording::list(&names))),
    ];
    Outcome::Partly(code, format!("{}; see {TABLE}", parts.into_iter().flatten().collect::<Vec<String>>().join(", ")))
}
