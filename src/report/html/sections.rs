//! What the parts of the page hold; an empty text where there is nothing to tell.

use super::markup::{element, escape, facts, list, scrolled, table};
use crate::inversion::{Estimate, FitOutcome, SigmaSource, Status};
use crate::report::digits::{plain, with_sigma};
use crate::report::rows::{self, NONE};
use crate::report::table::Align::{self, Left, Right};
use crate::report::uncertainty::{self, Remark};
use crate::report::{choice as choosing, wording};

/// Correlations from which a cell is shaded, and from which one of the two is all but told by the other.
const SHADED: [f64; 2] = [0.5, 0.9];

const ESTIMATE: [(&str, Align); 7] = [
    ("quantity", Left),
    ("value", Right),
    ("sigma", Left),
    ("unit", Left),
    ("68 % interval", Left),
    ("95 % interval", Left),
    ("status", Left),
];

/// All warnings but those that [`undetermined`] tells.
pub(super) fn warnings(outcome: &FitOutcome) -> String {
    let told_below = &outcome.identifiability.undetermined;
    let others: Vec<&String> = outcome.warnings.iter().filter(|warning| !told_below.contains(warning)).collect();
    list("ul", &others)
}

pub(super) fn parameters(outcome: &FitOutcome) -> String {
    let parameters = outcome.parameters.each();
    let rows = parameters.map(|(name, estimate)| rows::estimate(name, estimate));
    let mut statuses: Vec<Status> = Vec::new();
    for (_, estimate) in parameters {
        if !statuses.contains(&estimate.status) {
            statuses.push(estimate.status);
        }
    }
    // With the names, for a screen that is too narrow for the table's last column.
    let word = |status: &Status| {
        let of = |(name, estimate): (&'static str, &Estimate)| (estimate.status == *status).then_some(name);
        let names: Vec<&str> = parameters.into_iter().filter_map(of).collect();
        let meaning = format!("{}: {}", wording::list(&names), wording::meaning(*status));
        format!("<dt>{}</dt><dd>{}</dd>\n", escape(status.phrase()), escape(&meaning))
    };
    let words: String = statuses.iter().map(word).collect();
    let mut html = table("Parameters", &ESTIMATE, &rows);
    html.push_str(&format!("<dl class=\"words\">\n{words}</dl>\n"));
    let stiffness = wording::stiffness(outcome);
    if !stiffness.is_empty() {
        html.push_str(&element("p", &format!("{}.", wording::capitalised(&stiffness))));
    }
    html
}

pub(super) fn undetermined(outcome: &FitOutcome) -> String {
    list("ul", &outcome.identifiability.undetermined)
}

pub(super) fn sums(outcome: &FitOutcome) -> String {
    let rows = rows::sums(outcome).map(|(name, estimate): (&str, &Estimate)| rows::estimate(name, estimate));
    let words = "The optical sum is n_gap·d_air + n_cuticle·d_cuticle at the middle wavelength of the data, half the Bragg \
                 wavelength. Both have errors of their own, often much smaller than those of the split.";
    format!("{}{}", table("Sums of the thicknesses", &ESTIMATE, &rows), element("p", words))
}

pub(super) fn minima(outcome: &FitOutcome) -> String {
    let estimates = &outcome.parameters;
    let told = estimates.d_air.value.is_some() || estimates.d_cuticle.value.is_some();
    if outcome.minima.is_empty() {
        return String::new();
    }
    if !wording::answers(outcome) || !told {
        return element("p", "The data tell neither d_air nor d_cuticle, so that minima of chi² are no answers.");
    }
    if outcome.minima.len() == 1 {
        return element("p", "The search found no minimum beside the best.");
    }
    let columns = [
        ("minimum", Left),
        ("d_air / nm", Right),
        ("d_cuticle / nm", Right),
        ("delta / deg", Right),
        ("phi_alpha / rad", Right),
        ("lamella_width / nm", Right),
        ("delta chi²", Right),
        ("weight", Right),
        ("fits as well", Left),
        ("relation to the best", Left),
    ];
    let row = |(place, found)| {
        let mut row: Vec<String> = rows::minimum(place, found, outcome).into();
        row.insert(row.len() - 1, if found.fits { "yes" } else { "no" }.to_owned());
        row
    };
    let rows: Vec<Vec<String>> = outcome.minima.iter().enumerate().map(row).collect();
    let words = format!(
        "A minimum within delta chi² {} of the best fits as well; the weight is its share of the posterior by depth and \
         curvature.",
        outcome.settings.level
    );
    format!("{}{}", table("Minima of chi²", &columns, &rows), element("p", &words))
}

pub(super) fn intervals(outcome: &FitOutcome) -> String {
    let Some(found) = &outcome.uncertainty else { return String::new() };
    let columns = [
        ("quantity", Left),
        ("unit", Left),
        ("method", Left),
        ("68 % interval", Left),
        ("95 % interval", Left),
        ("against the covariance", Left),
    ];
    let mut html = table("Intervals of all methods", &columns, &uncertainty::rows(found));
    for remark in uncertainty::remarks(found) {
        html.push_str(&match remark {
            Remark::Warning(sentence) => format!("<p><b>Note:</b> {}.</p>\n", escape(&sentence)),
            Remark::Note(sentence) => element("p", &format!("{}.", wording::capitalised(&sentence))),
        });
    }
    html
}

pub(super) fn choice(outcome: &FitOutcome) -> String {
    let Some(found) = &outcome.choice else { return String::new() };
    let mut columns = choosing::COLUMNS;
    columns[columns.len() - 1].0 = "standing";
    format!("{}{}", table("Choice of the model", &columns, &choosing::rows(found)), element("p", &found.rule))
}

pub(super) fn advice(outcome: &FitOutcome) -> String {
    let sentences: Vec<String> =
        outcome.advice.iter().map(|one| format!("{}.", wording::capitalised(&wording::advice(one)))).collect();
    let mut html = list("ol", &sentences);
    if let Some(first) = outcome.advice.first().filter(|first| wording::forecasts(first)) {
        let columns = [("quantity", Left), ("sigma now", Right), ("with the first", Right), ("unit", Left)];
        let rows: Vec<[String; 4]> = first
            .expected
            .iter()
            .map(|one| {
                let digits = |sigma: f64| with_sigma(0.0, sigma).1;
                [wording::quantity(&one.name).to_owned(), digits(one.before), digits(one.after), one.unit.clone()]
            })
            .collect();
        html.push_str(&table("Standard deviations to expect", &columns, &rows));
    }
    html
}

pub(super) fn goodness(outcome: &FitOutcome) -> String {
    let or_none = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), plain);
    let mut all = vec![
        ("chi²", plain(outcome.chi2)),
        ("degrees of freedom", outcome.dof.to_string()),
        ("AICc", or_none(outcome.aicc)),
        ("BIC", plain(outcome.bic)),
        ("readings", outcome.data.readings.to_string()),
        ("correlation of neighbouring residuals", plain(outcome.residual_correlation)),
    ];
    if let Some(cost) = outcome.robust_cost {
        all.insert(1, ("sum of the robust loss", plain(cost)));
    }
    if outcome.sigma_source == SigmaSource::Widened {
        all.push(("widened by", plain(outcome.widened_by)));
    }
    all.push(("end of the search", outcome.termination.phrase().to_owned()));
    let columns =
        [("curve", Left), ("readings", Right), ("chi²", Right), ("correlation", Right), ("runs, in deviations", Right)];
    let rows: Vec<[String; 5]> = outcome
        .curve_residuals
        .iter()
        .map(|one| {
            let (readings, runs) = (one.readings.to_string(), or_none(one.runs_z));
            [one.curve.clone(), readings, plain(one.chi2), plain(one.correlation), runs]
        })
        .collect();
    let sentence = element("p", &format!("{}.", wording::capitalised(&wording::goodness(outcome))));
    format!("{sentence}{}{}", facts("Goodness of fit", &all), table("Residuals of each curve", &columns, &rows))
}

pub(super) fn nuisances(outcome: &FitOutcome) -> String {
    if !wording::answers(outcome) {
        return String::new();
    }
    let rows: Vec<[String; 3]> = outcome.nuisance.iter().map(rows::nuisance).collect();
    table("Scale, weight and background", &[("name", Left), ("value", Right), ("sigma", Left)], &rows)
}

pub(super) fn correlations(outcome: &FitOutcome) -> String {
    let matrix = &outcome.correlation;
    if matrix.names.len() < 2 {
        return String::new();
    }
    let heads: String = matrix.names.iter().map(|name| format!("<th scope=\"col\">{}</th>", escape(name))).collect();
    let row = |(place, (name, row)): (usize, (&String, &Vec<f64>))| {
        let cell = |(column, value): (usize, &f64)| {
            let class = match value.abs() {
                _ if column == place => "number",
                size if size >= SHADED[1] => "number strong",
                size if size >= SHADED[0] => "number some",
                _ => "number",
            };
            // -0.00 is 0.00
            format!("<td class=\"{class}\">{:.2}</td>", (100.0 * value).round() / 100.0 + 0.0)
        };
        let cells: String = row.iter().enumerate().map(cell).collect();
        format!("<tr><th scope=\"row\">{}</th>{cells}</tr>\n", escape(name))
    };
    let rows: String = matrix.names.iter().zip(&matrix.rows).enumerate().map(row).collect();
    let table = format!("<table>\n<thead><tr><td></td>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n");
    let mut html = scrolled("scroll", "Correlations", &table);
    if outcome.nuisance.iter().any(|nuisance| nuisance.conditional) {
        let words = "Where other values of what is held fit, the parameters allow for them, the scales do not.";
        html.push_str(&element("p", words));
    }
    html
}

pub(super) fn source(outcome: &FitOutcome, file: &str) -> String {
    let data = &outcome.data;
    let all = [
        ("file", file.to_owned()),
        ("SHA-256", data.sha256.clone()),
        ("readings", data.readings.to_string()),
        ("curves", data.curves.join(", ")),
        ("notes", if data.notes.is_empty() { "none".to_owned() } else { data.notes.join("; ") }),
        ("program", outcome.program.clone()),
        ("seed", outcome.seed.to_string()),
    ];
    facts("Data and program", &all)
}
