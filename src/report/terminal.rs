//! The report of a fit for a terminal: one screen, what matters most first.

use super::choice;
use super::digits::{plain, with_sigma};
use super::table::{Align, Table};
use super::wording;
use crate::inversion::{AdviceFound, Estimate, Fit, FitOutcome, NuisanceFound, SigmaSource, Verdict};

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
    let mut report = wrapped(&capitalised(&wording::verdict(outcome)), "", "", width);
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
    let nuisance = if answers(outcome) { nuisances(&outcome.nuisance) } else { String::new() };
    for line in [stiffness(outcome), nuisance, goodness(outcome), data(outcome)] {
        report.push_str(&wrapped(&line, "  ", "    ", width));
    }
    report.push_str(&rivals(outcome, width));
    if let Some(found) = &outcome.choice {
        report.push_str(&format!("\n{}", choice::table(found)));
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
    for (name, estimate) in outcome.parameters.each() {
        table.row(row(name, estimate));
    }
    table.row([""; 6]);
    table.row(row("d_air + d_cuticle", &outcome.derived.period));
    table.row(row("optical sum", &outcome.derived.optical_sum));
    table.to_string()
}

fn row(name: &str, estimate: &Estimate) -> [String; 6] {
    let (value, sigma) = match (estimate.value, estimate.sigma) {
        (None, _) => ("—".to_owned(), String::new()),
        (Some(value), None) => (plain(value), String::new()),
        (Some(value), Some(sigma)) => {
            let (value, sigma) = with_sigma(value, sigma);
            (value, format!("± {sigma}"))
        }
    };
    [name.to_owned(), value, sigma, estimate.unit.clone(), wording::interval(estimate), wording::status(estimate)]
}

/// The best and the worst known combination of parameters.
fn stiffness(outcome: &FitOutcome) -> String {
    let all = &outcome.identifiability.combinations;
    let (Some(stiff), Some(sloppy), true) = (all.first(), all.last(), all.len() > 1) else { return String::new() };
    // Where the model misses the data these are not what is known.
    if !answers(outcome) || outcome.sigma_source == SigmaSource::Widened {
        return String::new();
    }
    format!("stiffest: {}; sloppiest: {}", wording::combination(stiff), wording::combination(sloppy))
}

fn nuisances(found: &[NuisanceFound]) -> String {
    let one = |nuisance: &NuisanceFound| match nuisance.sigma {
        Some(sigma) => {
            let (value, sigma) = with_sigma(nuisance.value, sigma);
            format!("{} {value} ± {sigma}", nuisance.name)
        }
        None if nuisance.conditional => {
            format!("{} {} for the held values only", nuisance.name, plain(nuisance.value))
        }
        None => format!("{} {}", nuisance.name, plain(nuisance.value)),
    };
    let mut texts: Vec<String> = found.iter().take(NUISANCES).map(one).collect();
    let more = found.len().saturating_sub(NUISANCES);
    texts.extend((more > 0).then(|| format!("and {more} more in fit.json")));
    texts.join(", ")
}

fn goodness(outcome: &FitOutcome) -> String {
    let source = wording::sigma_source(outcome.sigma_source);
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let per = outcome.chi2 / outcome.dof as f64;
    if outcome.dof == 0 {
        return format!("chi² {} without degrees of freedom; {source}", plain(outcome.chi2));
    }
    let (chi2, dof) = (plain(outcome.chi2), outcome.dof);
    let scatter = outcome.sigma_ratio.is_none();
    if scatter {
        return format!("scatter {} with {dof} degrees of freedom; {source}", plain(per.sqrt()));
    }
    format!("chi² {chi2} for {dof} degrees of freedom, {} each; {source}", plain(per))
}

/// Whether the fit tells a thickness, so that there is something to compare with.
fn answers(outcome: &FitOutcome) -> bool {
    !matches!(outcome.verdict, Verdict::NotConverged | Verdict::NoThickness)
}

/// The number without what rounding left of a zero.
fn settled(value: f64) -> f64 {
    if value.abs() < 1e-6 { 0.0 } else { value }
}

/// The rivals: in a line if none fits, as a table with the best if one does.
fn rivals(outcome: &FitOutcome, width: usize) -> String {
    if !answers(outcome) {
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
    for (place, minimum) in outcome.minima.iter().filter(|minimum| minimum.fits).take(RIVALS).enumerate() {
        let [d_air, d_cuticle, delta, ..] = minimum.values.map(|value| plain(settled(value)));
        let (chi2, weight) = (plain(settled(minimum.delta_chi2)), format!("{:.0} %", 100.0 * minimum.weight));
        table.row([(place + 1).to_string(), d_air, d_cuticle, delta, chi2, weight, minimum.relation.phrase()]);
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

fn capitalised(text: &str) -> String {
    // A parameter's name keeps its small letter.
    if text.split(' ').next().is_some_and(|word| word.contains('_') || word.trim_end_matches(',') == "delta") {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
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
