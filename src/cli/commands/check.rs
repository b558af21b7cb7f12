//! `morpho-fit check`: what is in a file, and what its design of measurement can tell.

use crate::args::CheckArgs;
use crate::exit::Outcome;
use crate::options::Problem;
use crate::output::{self, WIDTH};
use crate::progress::Progress;
use anyhow::{Context, Result};
use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::geometry::Polarization;
use morpho_fit::inversion::{self, AdviceFound, Estimate, ModelChoice, expected};
use morpho_fit::report::{Align, Table, plain, terminal, with_sigma, wording};
use morpho_fit::units::degrees;
use serde::Serialize;

/// Distinct values of a coordinate that are listed instead of their range.
const LISTED: usize = 3;
/// Curves that are listed.
const CURVES: usize = 12;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report {
    file: String,
    sha256: String,
    readings: usize,
    curves: Vec<Curve>,
    coordinates: Vec<Coordinate>,
    polarizations: Vec<Polarization>,
    has_sigma: bool,
    /// Whether there are no intensities.
    plan: bool,
    notes: Vec<String>,
    planes: &'static str,
    expected: Expected,
}

/// What can be expected of a fit.
#[derive(Debug, Serialize)]
struct Expected {
    /// Structure and noise that it holds for.
    assuming: String,
    parameters: Vec<ExpectedParameter>,
    /// What is not determined, as sentences.
    undetermined: Vec<String>,
    /// Whether everything free is told, and well.
    good: bool,
    /// What to measure besides, the best first.
    advice: Vec<AdviceFound>,
}

#[derive(Debug, Serialize)]
struct ExpectedParameter {
    name: &'static str,
    unit: String,
    /// The value that the expectation is for; none for what is not determined.
    assumed: Option<f64>,
    sigma: Option<f64>,
    status: String,
    elsewhere: Elsewhere,
}

/// What the same design tells of structures drawn evenly from the bounds.
#[derive(Debug, Serialize)]
struct Elsewhere {
    structures: usize,
    /// Of how many the parameter is told.
    told: usize,
    /// Standard deviations of the middle half of these, least and largest.
    sigma_middle_half: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct Curve {
    name: String,
    readings: usize,
}

#[derive(Debug, Serialize)]
struct Coordinate {
    name: &'static str,
    unit: &'static str,
    lowest: f64,
    highest: f64,
    values: usize,
    #[serde(skip)]
    first: Vec<f64>,
}

pub(crate) fn run(args: &CheckArgs) -> Result<Outcome> {
    let problem = Problem::read_plan(&args.problem)?;
    let data = &problem.data;
    let progress = Progress::new(false);
    let expected =
        expected(data, &problem.settings, &|what| progress.tell(what)).with_context(|| problem.file.clone())?;
    drop(progress);
    let report = Report {
        sha256: problem.sha256.clone().unwrap_or_else(|| data.sha256().to_owned()),
        file: problem.file,
        readings: data.readings().len(),
        curves: curves(data),
        coordinates: coordinates(data),
        polarizations: polarizations(data),
        has_sigma: data.has_sigma(),
        plan: data.is_plan(),
        notes: data.notes().to_vec(),
        planes: planes(data, problem.settings.model),
        expected: of(expected),
    };
    if args.json {
        let mut bytes = serde_json::to_vec_pretty(&report)?;
        bytes.push(b'\n');
        output::print(&bytes)?;
    } else {
        output::print_report(&text(&report))?;
    }
    Ok(Outcome::Done)
}

fn of(found: inversion::Expected) -> Expected {
    let parameter =
        |((name, estimate), elsewhere): ((&'static str, &Estimate), &inversion::Elsewhere)| ExpectedParameter {
            name,
            elsewhere: Elsewhere {
                structures: elsewhere.structures,
                told: elsewhere.told,
                sigma_middle_half: elsewhere.middle,
            },
            unit: estimate.unit.clone(),
            assumed: estimate.value,
            sigma: estimate.sigma,
            status: wording::status(estimate),
        };
    Expected {
        parameters: found.each().into_iter().zip(&found.elsewhere).map(parameter).collect(),
        assuming: found.assuming,
        undetermined: found.outcome.identifiability.undetermined,
        good: found.good,
        advice: found.advice,
    }
}

fn curves(data: &Dataset) -> Vec<Curve> {
    let count = |index: usize| data.readings().iter().filter(|reading| reading.curve == index).count();
    let curve = |(index, name): (usize, &String)| Curve { name: name.clone(), readings: count(index) };
    data.curves().iter().enumerate().map(curve).collect()
}

fn coordinates(data: &Dataset) -> Vec<Coordinate> {
    type Of = fn(&Reading) -> f64;
    let all: [(&'static str, &'static str, Of); 4] = [
        ("wavelength", "nm", |reading| reading.wavelength),
        ("theta", "deg", |reading| degrees(reading.geometry.theta)),
        ("phi", "deg", |reading| degrees(reading.geometry.phi)),
        ("omega", "deg", |reading| degrees(reading.geometry.omega)),
    ];
    let coordinate = |(name, unit, of): (&'static str, &'static str, Of)| {
        // Without the last digits of the conversion to radians and back.
        let clean = |reading: &Reading| (of(reading) * 1e9).round() / 1e9 + 0.0;
        let mut values: Vec<f64> = data.readings().iter().map(clean).collect();
        values.sort_by(f64::total_cmp);
        values.dedup_by(|left, right| left.total_cmp(right).is_eq());
        let (lowest, highest) = (values.first().copied(), values.last().copied());
        Coordinate {
            name,
            unit,
            lowest: lowest.unwrap_or_default(),
            highest: highest.unwrap_or_default(),
            values: values.len(),
            first: values.into_iter().take(LISTED).collect(),
        }
    };
    all.into_iter().map(coordinate).collect()
}

fn polarizations(data: &Dataset) -> Vec<Polarization> {
    let seen = |polarization: &Polarization| data.readings().iter().any(|r| r.polarization == *polarization);
    [Polarization::Unpolarized, Polarization::S, Polarization::P].into_iter().filter(seen).collect()
}

fn planes(data: &Dataset, model: ModelChoice) -> &'static str {
    let product = matches!(model, ModelChoice::Hybrid { .. });
    let shares = data.readings().iter().map(|reading| reading.geometry.plane_shares());
    match shares.fold((false, false), |seen, (a, b)| (seen.0 || a > 0.0, seen.1 || b > 0.0)) {
        (true, false) if product => "only the plane across the ridges (omega 0) is seen",
        (false, true) if product => "only the plane along the ridges (omega 90) is seen",
        (true, true) if product => "both planes are seen: across the ridges (omega 0) and along them (omega 90)",
        (true, true) => "both planes are seen: lamella diffraction across the ridges and the multilayer along them",
        (true, false) => "only the plane across the ridges (omega 0) is seen: lamella diffraction, no multilayer",
        (false, true) => "only the plane along the ridges (omega 90) is seen: the multilayer, no lamella diffraction",
        (false, false) => "no plane is seen",
    }
}

fn text(report: &Report) -> String {
    let state = if report.plan { "planned" } else { "ready to fit" };
    let mut text = format!("{}: {} readings, {state}\n\n", report.file, report.readings);
    let mut table = Table::new(&[("", Align::Left), ("", Align::Left), ("", Align::Left)]);
    for coordinate in &report.coordinates {
        let Coordinate { name, unit, lowest, highest, values, first } = coordinate;
        let numbers = if *values <= LISTED {
            let numbers: Vec<String> = first.iter().map(|value| format!("{value}")).collect();
            format!("{} {unit}", wording::list(&numbers.iter().map(String::as_str).collect::<Vec<_>>()))
        } else {
            format!("{lowest} to {highest} {unit}")
        };
        let count = if *values > LISTED { format!("{values} values") } else { String::new() };
        table.row([(*name).to_owned(), numbers, count]);
    }
    let words: Vec<&str> = report.polarizations.iter().map(|polarization| polarization.word()).collect();
    table.row(["polarization", &wording::list(&words), ""]);
    table.row(["sigma", if report.has_sigma { "stated" } else { "not stated" }, ""]);
    if report.curves.len() > 1 {
        for (index, curve) in report.curves.iter().take(CURVES).enumerate() {
            let head = if index == 0 { "curves" } else { "" };
            table.row([head.to_owned(), curve.name.clone(), format!("{} readings", curve.readings)]);
        }
        let more = report.curves.len().saturating_sub(CURVES);
        if more > 0 {
            table.row(["".to_owned(), format!("and {more} more"), String::new()]);
        }
    }
    text.push_str(&table.to_string());
    for note in &report.notes {
        text.push_str(&format!("  note: {note}\n"));
    }
    text.push_str(&format!("\n  {}\n\n", report.planes));
    text.push_str(&expectation(&report.expected));
    text
}

fn expectation(expected: &Expected) -> String {
    let mut text = format!("What a fit of such data can tell {}:\n\n", expected.assuming);
    let mut table = Table::new(&[
        ("", Align::Left),
        ("assumed", Align::Right),
        ("expected", Align::Left),
        ("elsewhere", Align::Left),
        ("unit", Align::Left),
        ("status", Align::Left),
    ]);
    let digits = |sigma: f64| with_sigma(0.0, sigma).1;
    for parameter in &expected.parameters {
        let assumed = parameter.assumed.map_or_else(|| "—".to_owned(), plain);
        let sigma = parameter.sigma.map_or_else(String::new, |sigma| format!("± {}", digits(sigma)));
        let elsewhere = parameter.elsewhere.sigma_middle_half;
        let elsewhere = elsewhere.map_or_else(String::new, |[least, most]| {
            let few = if parameter.elsewhere.told < parameter.elsewhere.structures {
                format!(" in {}", parameter.elsewhere.told)
            } else {
                String::new()
            };
            format!("{} to {}{few}", digits(least), digits(most))
        });
        let (unit, status) = (parameter.unit.clone(), parameter.status.clone());
        table.row([parameter.name.to_owned(), assumed, sigma, elsewhere, unit, status]);
    }
    text.push_str(&table.to_string());
    let others = expected.parameters.iter().map(|parameter| parameter.elsewhere.structures).max().unwrap_or(0);
    if others > 0 {
        let what = format!(
            "elsewhere: what the same data would tell of {others} other structures within the bounds, the middle half of their \
             standard deviations; \"in 20\": only 20 of them are told"
        );
        text.push_str(&terminal::wrapped(&what, "  ", "    ", WIDTH));
        if !expected.undetermined.is_empty() {
            text.push('\n');
        }
    }
    for sentence in &expected.undetermined {
        text.push_str(&terminal::wrapped(sentence, "! ", "  ", WIDTH));
    }
    text.push('\n');
    if expected.good {
        text.push_str("Nothing more is needed.\n");
    }
    text.push_str(&terminal::advice(&expected.advice, WIDTH));
    text
}
