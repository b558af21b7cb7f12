//! The head of the page: the verdict with a mark that is told apart by its shape and its word, not by its colour alone.

use super::markup::element;
use crate::inversion::{FitOutcome, SigmaSource, Verdict};
use crate::report::wording;

const TICK: &str = "<circle cx=\"12\" cy=\"12\" r=\"11\" fill=\"#0072b2\"/>\
    <path d=\"M6 12.5l4 4 8-9\" fill=\"none\" stroke=\"#fff\" stroke-width=\"2.6\"/>";
const HALF: &str = "<circle cx=\"12\" cy=\"12\" r=\"10\" fill=\"#fff\" stroke=\"#e69f00\" stroke-width=\"2.4\"/>\
    <path d=\"M12 2a10 10 0 0 0 0 20z\" fill=\"#e69f00\"/>";
const SIGN: &str = "<path d=\"M12 1.5L23 22H1z\" fill=\"#e69f00\"/>\
    <path d=\"M12 8v7m0 2.4v2.4\" fill=\"none\" stroke=\"#222\" stroke-width=\"2.4\"/>";
const CROSS: &str = "<circle cx=\"12\" cy=\"12\" r=\"11\" fill=\"#d55e00\"/>\
    <path d=\"M7.5 7.5l9 9m0-9l-9 9\" fill=\"none\" stroke=\"#fff\" stroke-width=\"2.6\"/>";

/// Mark, verdict, and what was fitted.
pub(super) fn header(outcome: &FitOutcome, file: &str) -> String {
    let misses = outcome.sigma_source == SigmaSource::Widened;
    let (class, mark, word) = match (outcome.verdict, misses) {
        (Verdict::NotConverged, _) => ("none", CROSS, "No result"),
        (Verdict::NoThickness, _) => ("none", CROSS, "No thickness"),
        (Verdict::Given, true) => ("none", CROSS, "Given, and misses the data"),
        (Verdict::Given, false) => ("part", HALF, "Given, and not contradicted"),
        (_, true) => ("part", SIGN, "With care: the model misses the data"),
        (Verdict::Determined, false) => ("good", TICK, "Determined"),
        (Verdict::PartlyDetermined, false) => ("part", HALF, "Determined in part"),
    };
    let mark = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 24 24\" width=\"48\" height=\"48\" aria-hidden=\"true\">{mark}</svg>"
    );
    let verdict = element("h1", &wording::capitalised(&wording::verdict(outcome)));
    let (readings, curves) = (outcome.data.readings, outcome.data.curves.len());
    let plural = if curves == 1 { "curve" } else { "curves" };
    let source = element("span", &format!("{file}: {readings} readings, {curves} {plural}; {}", outcome.program));
    format!(
        "<header class=\"verdict {class}\">\n{mark}\n<div>\n<p class=\"word\">{word}</p>\n{verdict}\
         <p class=\"source\">{source}</p>\n</div>\n</header>\n"
    )
}
