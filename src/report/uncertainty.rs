//! The intervals of several methods in one table.

use super::digits::plain;
use super::table::{Align, Table};
use super::terminal::wrapped;
use super::wording;
use crate::inversion::intervals::{IntervalsFound, Method, MethodIntervals, Resampling, UncertaintyFound};

/// The headings of [`rows`].
pub(super) const COLUMNS: [(&str, Align); 6] = [
    ("", Align::Left),
    ("unit", Align::Left),
    ("method", Align::Left),
    ("68 % interval", Align::Left),
    ("95 % interval", Align::Left),
    ("", Align::Left),
];

/// How many times as many evaluations are proposed where those allowed did not do.
const MORE: usize = 4;

/// A sentence below the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Remark {
    /// Something to act on.
    Warning(String),
    /// How the work went.
    Note(String),
}

/// The table, and below it how bootstrap and sampling went, in lines of `width` characters.
///
/// A method that parts from the covariance by more than a fifth is marked with by how much.
#[must_use]
pub fn text(found: &UncertaintyFound, width: usize) -> String {
    let mut table = Table::new(&COLUMNS);
    let mut last = String::new();
    for mut row in rows(found) {
        // The name stands once.
        if row[0] == last {
            (row[0], row[1]) = (String::new(), String::new());
        } else {
            last.clone_from(&row[0]);
        }
        table.row(row);
    }
    let mut text = table.to_string();
    for remark in remarks(found) {
        text.push_str(&match remark {
            Remark::Warning(sentence) => wrapped(&sentence, "! ", "  ", width),
            Remark::Note(sentence) => wrapped(&sentence, "  ", "    ", width),
        });
    }
    text
}

/// A row for each method of each quantity: name, unit, method, both intervals, and where it parts from the covariance.
pub(super) fn rows(found: &UncertaintyFound) -> Vec<[String; 6]> {
    let of = |quantity: &IntervalsFound, method: &MethodIntervals| {
        [
            wording::quantity(&quantity.name).to_owned(),
            quantity.unit.clone(),
            method.method.phrase().to_owned(),
            ends(method, method.intervals.interval_68),
            ends(method, method.intervals.interval_95),
            parting(method),
        ]
    };
    found
        .quantities
        .iter()
        .flat_map(|quantity| quantity.methods.iter().map(move |method| of(quantity, method)))
        .collect()
}

/// Where methods part, what failed, and how the sampling went.
pub(super) fn remarks(found: &UncertaintyFound) -> Vec<Remark> {
    let mut remarks = Vec::new();
    let parted = |bent: bool| {
        let of = |method: Method| matches!(method, Method::Profile | Method::Posterior) == bent;
        found.quantities.iter().flat_map(|quantity| &quantity.methods).any(|m| of(m.method) && m.parts())
    };
    let mut say = |sentence: &str| remarks.push(Remark::Warning(sentence.to_owned()));
    if parted(true) {
        say("profile or posterior part from the covariance by more than 20 %: trust them, the problem is not linear");
    }
    if parted(false) {
        say(
            "a bootstrap parts from the covariance by more than 20 %: the noise is not what sigma says, few readings carry the \
             answer, or the curves are short (40 readings know their own scatter to 11 %)",
        );
    }
    for bootstrap in &found.bootstraps {
        if bootstrap.failed > 0 {
            let (failed, all) = (bootstrap.failed, bootstrap.replicates + bootstrap.failed);
            let what = match bootstrap.resampling {
                Resampling::Residuals => "residuals",
                Resampling::Cases => "cases",
            };
            say(&format!("{failed} of {all} replicates of the bootstrap of {what} found no minimum and are left out"));
        }
    }
    if let Some(values) = found.lower_minimum {
        let values: Vec<String> = values.iter().map(|value| plain(*value)).collect();
        say(&format!("a profile met a lower minimum, at {}: fit again with --start there", values.join(", ")));
    }
    if let Some(posterior) = &found.posterior {
        let number = |value: Option<f64>| value.map_or_else(|| "unknown".to_owned(), plain);
        let (r_hat, effective) = (number(posterior.r_hat), number(posterior.effective));
        let evaluations = posterior.evaluations;
        let more = MORE * evaluations;
        if posterior.samples == 0 {
            say(&format!("the posterior has no samples after {evaluations} evaluations"));
        } else if !posterior.converged {
            say(&format!(
                "the posterior is not sampled enough: split-R̂ {r_hat}, {effective} effective samples; try \
                 --max-evaluations {more}"
            ));
        }
        if posterior.samples > 0 {
            remarks.push(Remark::Note(format!(
                "posterior: {} samples in {} chains, at least {effective} effective, split-R̂ {r_hat}, {evaluations} \
                 evaluations",
                posterior.samples, posterior.chains
            )));
        }
    }
    remarks
}

fn parting(method: &MethodIntervals) -> String {
    match method.parting.filter(|_| method.parts()) {
        Some(parting) if parting > 0.0 => format!("{:.0} % wider", 100.0 * parting),
        Some(parting) => format!("{:.0} % narrower", -100.0 * parting),
        None => String::new(),
    }
}

/// An interval with the digits that its width asks for; an open end is a bound.
fn ends(method: &MethodIntervals, interval: [Option<f64>; 2]) -> String {
    let width = match method.intervals.interval_68 {
        [Some(low), Some(high)] => Some(0.5 * (high - low)),
        _ => method.sigma,
    };
    wording::ends(interval, width)
}
