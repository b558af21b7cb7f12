//! Solvers: the share of problems with a known answer that each has solved after a time, starting anew from random points.
//!
//! A problem is solved at the first point inside the bounds with `chi² <= 1.05 chi²(truth)`. A local method starts again
//! when it ends, from the next of the starts that all methods share, until its time is spent.

pub(super) mod problems;
pub(super) mod rivals;
pub(super) mod watched;

use crate::inversion::{Compiled, FitSettings, Problem, Search, Space, fit};
use crate::tradeoff::{Clock, Diagram, Point, Series, Settings, TradeoffError};
use problems::Known;
use rivals::Rival;
use watched::Watched;

/// What counts as solved, in `chi²(truth)`.
const SOLVED: f64 = 1.05;
/// Seconds for each problem and method.
const BUDGET: f64 = 0.256;
const QUICK_BUDGET: f64 = 0.128;
/// The least budget of the curves; the others are doubles of it.
const FIRST_BUDGET: f64 = 0.001;
/// Problems of a quick run.
const QUICK_PROBLEMS: usize = 3;
/// Starts that all methods share; more than any can use.
const STARTS: usize = 4096;
/// Name of the search that a user gets.
pub(crate) const GLOBAL: &str = "ours, global";

pub(super) fn diagrams(
    settings: &Settings,
    clock: Clock<'_>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Diagram>, TradeoffError> {
    let mut diagrams = Vec::new();
    let much = problems::much_data(settings.seed)?;
    for (title, problems) in [
        ("much data, known scale: 2294 readings", much),
        ("little data, unknown scale: 310 readings", problems::little_data()?),
    ] {
        let count = if settings.quick { QUICK_PROBLEMS } else { problems.len() };
        let mut times: Vec<Vec<Option<f64>>> = vec![Vec::new(); Rival::ALL.len() + 1];
        for (index, known) in problems.iter().take(count).enumerate() {
            progress(&format!("solver: problem {} of {count}, {title}", index + 1));
            for (times, found) in times.iter_mut().zip(race(settings, clock, known, index)?) {
                times.push(found);
            }
        }
        let names = Rival::ALL.iter().map(|rival| rival.name()).chain([GLOBAL]);
        let series = names.zip(&times).map(|(name, times)| curve(name, times, budget(settings))).collect();
        diagrams.push(Diagram {
            title: title.to_owned(),
            x_label: "time for each problem / s".to_owned(),
            y_label: format!("share solved of {count}"),
            y_in_powers: false,
            series,
        });
    }
    Ok(diagrams)
}

fn budget(settings: &Settings) -> f64 {
    if settings.quick { QUICK_BUDGET } else { BUDGET }
}

/// Seconds until each method, and the global search at last, has solved a problem.
fn race(settings: &Settings, clock: Clock<'_>, known: &Known, index: usize) -> Result<Vec<Option<f64>>, TradeoffError> {
    let model = known.settings.model.build(known.settings.stack.clone());
    let compiled = Compiled::new(&known.data, &known.settings, model.as_ref())?;
    let space = Space::new(&known.settings.roles)?;
    let problem = Problem::new(&compiled, &space, &[]);
    let starts = space.bounds.latin_hypercube(STARTS, settings.seed.wrapping_add(index as u64));
    let mut found = Vec::new();
    for rival in Rival::ALL {
        let watched = Watched::new(&problem, &space, rival.difference(), clock)
            .for_seconds(budget(settings))
            .until(SOLVED * known.chi2_truth);
        for (turn, start) in starts.iter().enumerate() {
            if watched.is_over() {
                break;
            }
            rival.descend(&watched, start, settings.seed.wrapping_add(turn as u64));
        }
        found.push(watched.seconds_until_solved());
    }
    let began = clock();
    let global = fit(&known.data, &FitSettings { search: Search::Global, ..known.settings.clone() }, &|_| {})?;
    let seconds = clock() - began;
    found.push((global.outcome.chi2 <= SOLVED * known.chi2_truth).then_some(seconds));
    Ok(found)
}

/// The share solved within each budget.
fn curve(name: &str, times: &[Option<f64>], most: f64) -> Series {
    let mut points = Vec::new();
    let mut budget = FIRST_BUDGET;
    while budget < 1.01 * most {
        let solved = times.iter().flatten().filter(|&&time| time <= budget).count();
        #[allow(clippy::cast_precision_loss, reason = "counts of problems are small")]
        let y = solved as f64 / times.len().max(1) as f64;
        points.push(Point { setting: format!("{budget} s"), x: budget, y });
        budget *= 2.0;
    }
    Series { method: name.to_owned(), points }
}
