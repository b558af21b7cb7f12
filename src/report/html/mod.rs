//! One page for each fit, `report.html`: everything in `fit.json` that a reader wants, with the charts in it.
//!
//! The page needs no network, no script and no other file. It is XML as well as HTML, so that a program can read it, and equal
//! input gives equal bytes. Rows and sentences are those of the terminal's report.

mod chart;
mod markup;
mod sections;
mod settings;
#[cfg(test)]
mod tests;
mod verdict;

pub use chart::{Chart, Swatch};

use super::wording;
use crate::inversion::FitOutcome;
use markup::{element, escape, section};

/// How the page looks; no file of it is needed beside the page.
const STYLE: &str = include_str!("style.css");

/// The page of a fit.
///
/// What matters most comes first: verdict, warnings, parameters and what is not determined; then charts, other minima,
/// intervals and what to measure next; then how the fit was made. What has nothing to say is left out.
///
/// - `file`: name of the data, for the reader.
/// - `charts`: pictures in the order in which they are shown.
/// - `swatches`: colours, none for no such part.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, Search, fit};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::report::html::page;
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, truth) = (BlendModel::default(), Structure::blue());
/// let data = simulate(&model, &truth, &Scan::full_design(&model, &truth)?, 1.0, 0.01, 1)?;
/// let local = FitSettings { search: Search::Local, ..FitSettings::default() };
/// let html = page(&fit(&data, &local, &|_| {})?.outcome, "<mine>.csv", &[], &[]);
/// assert!(html.starts_with("<!DOCTYPE html>") && html.contains("&lt;mine&gt;.csv"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn page(outcome: &FitOutcome, file: &str, charts: &[Chart<'_>], swatches: &[Swatch]) -> String {
    let parts = [
        ("warnings", "Warnings", sections::warnings(outcome)),
        ("parameters", "Parameters", sections::parameters(outcome)),
        ("undetermined", "Not determined, and why", sections::undetermined(outcome)),
        ("sums", "Sums of the thicknesses", sections::sums(outcome)),
        ("colours", "Colours", colours(swatches)),
        ("charts", "Charts", charts.iter().map(Chart::figure).collect()),
        ("minima", "Minima of chi²", sections::minima(outcome)),
        ("intervals", "Intervals of all methods", sections::intervals(outcome)),
        ("choice", "Choice of the model", sections::choice(outcome)),
        ("advice", "What to measure next", sections::advice(outcome)),
        ("goodness", "How well the model meets the data", sections::goodness(outcome)),
        ("nuisances", "Scale, weight and background", sections::nuisances(outcome)),
        ("correlations", "Correlations", sections::correlations(outcome)),
        ("settings", "Settings", settings::settings(&outcome.settings)),
        ("source", "Data and program", sections::source(outcome, file)),
    ];
    let told = || parts.iter().filter(|(_, _, body)| !body.is_empty());
    let links: String =
        told().map(|(id, heading, _)| format!("<li><a href=\"#{id}\">{}</a></li>\n", escape(heading))).collect();
    let body: String = told().map(|(id, heading, body)| section(id, heading, body)).collect();
    let title = element("title", &format!("{file}: {}", wording::verdict(outcome)));
    let header = verdict::header(outcome, file);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\" xmlns=\"http://www.w3.org/1999/xhtml\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n{title}<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<main>\n{header}<nav aria-label=\"Parts of the page\">\n<ul>\n{links}</ul>\n</nav>\n{body}</main>\n</body>\n\
         </html>\n"
    )
}

/// The parts of the page that a notebook shows under a cell: verdict, warnings, parameters, what is not determined, sums of
/// the thicknesses, and what to measure next.
///
/// - `file`: name of the data, for the reader.
///
/// It brings no style: the notebook has its own.
#[must_use]
pub fn fragment(outcome: &FitOutcome, file: &str) -> String {
    let (readings, program) = (outcome.data.readings, &outcome.program);
    let verdict = element("p", &wording::capitalised(&wording::verdict(outcome)));
    let source = element("p", &format!("{file}: {readings} readings; {program}"));
    let (warnings, undetermined) = (sections::warnings(outcome), sections::undetermined(outcome));
    let (parameters, sums, advice) =
        (sections::parameters(outcome), sections::sums(outcome), sections::advice(outcome));
    format!("<div class=\"morpho-fit\">\n{verdict}{warnings}{parameters}{undetermined}{sums}{advice}{source}</div>\n")
}

fn colours(swatches: &[Swatch]) -> String {
    if swatches.is_empty() {
        return String::new();
    }
    let items: String = swatches.iter().map(Swatch::item).collect();
    let seen = element(
        "p",
        "As the CIE 1931 2° observer sees them in daylight (D65), mirrored by the layers themselves; Y is 1 for a perfect white. \
         How sure they are is from the covariance: a difference ΔE₀₀ of 1 is just seen.",
    );
    format!("{seen}<ul class=\"swatches\">\n{items}</ul>\n")
}
