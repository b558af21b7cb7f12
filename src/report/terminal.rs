//! The report of a fit for a terminal: one screen, what matters most first.

use super::choice;
use super::digits::plain;
use super::rows;
use super::table::{Align, Table};
use super::wording;
use crate::inversion::{AdviceFound, ChoiceFound, Estimate, Fit, FitOutcome, NuisanceFound};

/// Warnings that are told; all of them are in `fit.json`.
const WARNINGS: usize = 6;
/// Nuisances that are told.
const NUISANCES: usize = 6;
/// Curves that are named.
const CURVES: usize = 4;
/// Notes on the data that are told.
const NOTES: usize = 6;
/// Minima that are told.
const RIVALS: usize = 8;
/// Narrowest screen that is filled.
const NARROWEST: usize = 60;

/// The report: verdict, warnings, parameters, what follows from them, and how well the model meets the data.
///
/// - `width`: of the screen, in characters; sentences are wrapped, the table is about 90 wide.
#[must_use]
pub fn text(fit: &Fit, width: usize) -> String {
    let (outcome, width) = (&fit.outcome, width.max(NARROWEST));
    let mut report = wrapped(&wording::capitalised(&wording::verdict(outcome)), "", "", width);
    report.push('\n');
    for warning in outcome.warnings.iter().take(WARNINGS) {
        report.push_str(&wrapped(warning, "! ", "  ", width));
    }
    match outcome.warnings.len().saturating_sub(WARNINGS) {
        0 => {}
        more => report.push_str(&format!("! and {more} more in fit.json\n")),
    }
    if !outcome.warnings.is_empty() {
        report.push('\n');
    }
    report.push_str(&parameters(outcome));
    report.push('\n');
    let nuisance = if wording::answers(outcome) { nuisances(&outcome.nuisance) } else { String::new() };
    let (stiffness, averages) = (wording::stiffness(outcome), wording::averages(outcome));
    let exact = wording::taken_as_exact(outcome);
    for line in [stiffness, nuisance, averages, wording::goodness(outcome), exact, data(outcome)] {
        report.push_str(&wrapped(&line, "  ", "    ", width));
    }
    report.push_str(&rivals(outcome, width));
    if let Some(found) = &outcome.choice {
        report.push_str(&format!("\n{}", choice_table(found)));
        report.push_str(&wrapped(&found.rule, "  ", "  ", width));
    }
    let next = advice(&outcome.advice, width);
    if !next.is_empty() {
        report.push('\n');
        report.push_str(&next);
    }
    report
}

/// What to measure next, as lines: the best advice, and the next best scan for whoever cannot take it. Empty without any.
///
/// - `width`: of the screen, in characters.
#[must_use]
pub fn advice(advice: &[AdviceFound], width: usize) -> String {
    let heads = ["Measure next: ", "Or: "];
    let lines = advice.iter().zip(heads).map(|(one, head)| wrapped(&wording::advice(one), head, "  ", width));
    lines.collect()
}

fn parameters(outcome: &FitOutcome) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("", Align::Left),
        ("value", right),
        ("", Align::Left),
        ("unit", Align::Left),
        ("95 % interval", Align::Left),
        ("status", Align::Left),
    ]);
    let told = |(name, estimate): (&str, &Estimate)| {
        let [name, value, sigma, unit, _, interval_95, status] = rows::estimate(name, estimate);
        [name, value, sigma, unit, interval_95, status]
    };
    for parameter in outcome.parameters.each() {
        table.row(told(parameter));
    }
    table.row([""; 6]);
    for sum in rows::sums(outcome) {
        table.row(told(sum));
    }
    table.to_string()
}

fn nuisances(found: &[NuisanceFound]) -> String {
    let one = |nuisance: &NuisanceFound| rows::nuisance(nuisance).into_iter().filter(|text| !text.is_empty());
    let one = |nuisance: &NuisanceFound| one(nuisance).collect::<Vec<String>>().join(" ");
    let mut texts: Vec<String> = found.iter().take(NUISANCES).map(one).collect();
    let more = found.len().saturating_sub(NUISANCES);
    texts.extend((more > 0).then(|| format!("and {more} more in fit.json")));
    texts.join(", ")
}

/// What a choice of the model was made from.
fn choice_table(found: &ChoiceFound) -> Table {
    let mut table = Table::new(&choice::COLUMNS);
    for row in choice::rows(found) {
        table.row(row);
    }
    table
}

/// The rivals: in a line if none fits, as a table with the best if one does.
fn rivals(outcome: &FitOutcome, width: usize) -> String {
    if !wording::answers(outcome) {
        return String::new();
    }
    let [_, second, ..] = outcome.minima.as_slice() else { return String::new() };
    // Where a combination alone is determined the minima lie along it and are one answer.
    if !second.fits && !outcome.identifiability.undetermined.is_empty() {
        return String::new();
    }
    if !second.fits {
        let [d_air, d_cuticle, ..] = second.values.map(plain);
        let line = format!(
            "next best: d_air {d_air} nm, d_cuticle {d_cuticle} nm ({}), delta chi² {}",
            second.relation.phrase(),
            plain(second.delta_chi2)
        );
        return wrapped(&line, "  ", "    ", width);
    }
    let right = Align::Right;
    let mut table = Table::new(&[
        ("", Align::Left),
        ("d_air nm", right),
        ("d_cuticle nm", right),
        ("delta deg", right),
        ("delta chi²", right),
        ("weight", right),
        ("", Align::Left),
    ]);
    let mut is_told = false;
    for (place, minimum) in outcome.minima.iter().filter(|minimum| minimum.fits).take(RIVALS).enumerate() {
        let [number, d_air, d_cuticle, delta, _, _, chi2, weight, relation] = rows::minimum(place, minimum, outcome);
        is_told |= [&d_air, &d_cuticle, &delta].into_iter().any(|cell| cell != rows::NONE);
        table.row([number, d_air, d_cuticle, delta, chi2, weight, relation]);
    }
    if !is_told {
        return String::new();
    }
    let more = outcome.minima.iter().filter(|minimum| minimum.fits).count().saturating_sub(RIVALS);
    let more = if more > 0 { format!("  and {more} more in fit.json\n") } else { String::new() };
    format!("\n{table}{more}")
}

fn data(outcome: &FitOutcome) -> String {
    let curves = &outcome.data.curves;
    let readings = outcome.data.readings;
    let mut text = match curves.as_slice() {
        [_] => format!("{readings} readings"),
        named if named.len() <= CURVES => {
            format!("{readings} readings in {} curves: {}", named.len(), named.join(", "))
        }
        named => format!("{readings} readings in {} curves", named.len()),
    };
    for note in outcome.data.notes.iter().take(NOTES) {
        text.push_str("; ");
        text.push_str(note);
    }
    match outcome.data.notes.len().saturating_sub(NOTES) {
        0 => {}
        more => text.push_str(&format!("; and {more} more notes in fit.json")),
    }
    text
}

/// Words of `text` in lines of at most `width` characters, the first after `first`, the others after `next`.
#[must_use]
pub fn wrapped(text: &str, first: &str, next: &str, width: usize) -> String {
    if text.is_empty() {
        return String::new();
    }
    let mut lines = String::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.chars().count() + 1 + word.chars().count() > width {
            lines.push_str(&line);
            lines.push('\n');
            line = next.to_owned();
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    lines.push_str(&line);
    lines.push('\n');
    lines
}
