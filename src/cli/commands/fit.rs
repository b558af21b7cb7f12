//! `morpho-fit DATA.csv`: fit, report, files.

use crate::args::{FitArgs, OutputArgs, UncertaintyArgs, UncertaintyWord};
use crate::commands::intervals::{FILES, Intervals, Methods};
use crate::commands::{chart_files, drawn, sweep};
use crate::exit::{Outcome, Usage};
use crate::options::{Problem, hex_sha256};
use crate::output::{self, Folder, WIDTH};
use crate::progress::Progress;
use anyhow::{Context, Result};
use morpho_fit::dataset::Dataset;
use morpho_fit::export::{curves_csv, fit_json};
use morpho_fit::inversion::{
    Ask, Fit, FitOutcome, Fitter, Parameter, Search, SigmaSource, Status, Verdict, advise, chi_square_map, choose, fit,
};
use morpho_fit::plot::fit::{curves_figure, residuals_figure};
use morpho_fit::plot::intervals::map_figure;
use morpho_fit::plot::{Figure, Picture};
use morpho_fit::report::html::{Chart, page};
use morpho_fit::report::swatches::swatches;
use morpho_fit::report::{terminal, uncertainty, wording};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Fits; `command` is the method whose word the command line began with.
pub(crate) fn run(args: &FitArgs, command: UncertaintyWord) -> Result<Outcome> {
    let began = Instant::now();
    let problem = Problem::read_for_any(&args.problem)?;
    let place = place(&args.output, &problem.file);
    if let Some(name) = written_over(&problem.file, &place) {
        let message = format!("the results would replace the data: {name} is a name of a result; give another --out");
        return Err(Usage(message).into());
    }
    let folder = Folder::open(&place)?;
    let OutputArgs { quiet, no_plots, .. } = args.output;
    let name = file_name(&problem.file);
    let wanted = Wanted { name: &name, uncertainty: &args.uncertainty, command, plots: !no_plots };
    let progress = Progress::new(quiet);
    let found = work(&problem, &folder, &wanted, &|what| progress.tell(what)).inspect_err(|_| folder.abandon())?;
    drop(progress);
    let Files { fit, json, names } = found;
    if args.output.json {
        output::print(&json)?;
    } else if !args.output.quiet {
        let mut report = terminal::text(&fit, WIDTH);
        if fit.outcome.uncertainty.is_none() && Methods::of(&args.uncertainty, command).any() {
            let why =
                if fit.outcome.verdict == Verdict::Given { "nothing is free" } else { "the fit determines nothing" };
            report.push_str(&format!("\n! there is no interval: {why}\n"));
        }
        if let Some(found) = &fit.outcome.uncertainty {
            report.push_str(&format!("\n{}", uncertainty::text(found, WIDTH)));
        }
        let seconds = began.elapsed().as_secs_f64();
        let written = format!("{}: {} ({seconds:.2} s)", folder.path().display(), names.join(" "));
        report.push('\n');
        report.push_str(&terminal::wrapped(&written, "  ", "    ", WIDTH));
        output::print_report(&report)?;
    }
    Ok(outcome(&fit.outcome))
}

/// The name of the data if a result in `folder` would have it.
fn written_over(file: &str, folder: &Path) -> Option<String> {
    let file = Path::new(file);
    let name = file.file_name()?.to_string_lossy().into_owned();
    let same =
        fs::canonicalize(file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new(".")))
            .ok()
            .zip(fs::canonicalize(folder).ok())
            .is_some_and(|(ours, theirs)| ours == theirs);
    let is_result = ["fit.json", "curves.csv", PAGE].contains(&name.as_str()) || FILES.contains(&name.as_str());
    (same && is_result).then_some(name)
}

/// `fits/<name of the data>`, unless another folder is named.
fn place(args: &OutputArgs, file: &str) -> PathBuf {
    args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(file).file_stem().map_or("data".into(), |stem| stem.to_string_lossy());
        Path::new("fits").join(stem.as_ref())
    })
}

/// Names of all charts, each with the ends .svg and .png.
const PICTURES: [&str; 7] = ["curves", "residuals", "atlas", "sweep", "profile", "corner", "trace"];
/// The page that shows the fit with its charts.
const PAGE: &str = "report.html";
/// Cells of the map of chi², each way.
const MAP_CELLS: usize = 56;

/// What to make of a fit beside `fit.json` and `curves.csv`.
pub(crate) struct Wanted<'a> {
    /// Name of the data in titles.
    pub(crate) name: &'a str,
    pub(crate) uncertainty: &'a UncertaintyArgs,
    /// The method whose word the command line began with.
    pub(crate) command: UncertaintyWord,
    pub(crate) plots: bool,
}

/// What was found and written.
pub(crate) struct Files {
    pub(crate) fit: Fit,
    /// What `fit.json` holds.
    pub(crate) json: Vec<u8>,
    names: Vec<String>,
}

/// The name of a file without its folder.
fn file_name(file: &str) -> String {
    Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy()).into_owned()
}

/// Fits, by one model or by the one that is chosen.
fn found(problem: &Problem, tell: &(dyn Fn(&str) + Sync)) -> Result<Fit> {
    let Problem { file, data, settings, beside, .. } = problem;
    let found = match beside {
        Some(beside) => choose(data, settings, beside, tell).map(|choice| choice.fit),
        None => fit(data, settings, tell),
    };
    let mut fit = found.with_context(|| file.clone())?;
    problem.name_data(&mut fit.outcome);
    Ok(fit)
}

/// The fit without its curves.
///
/// - `fitter`: of the problem's own settings; none where it could not be made, which the fit by itself says why.
pub(crate) fn outcome_alone(problem: &Problem, fitter: Option<&Fitter>) -> Result<FitOutcome> {
    let Some(fitter) = fitter.filter(|_| problem.beside.is_none()) else {
        return Ok(found(problem, &|_| {})?.outcome);
    };
    let mut outcome = fitter.outcome(&problem.data, &|_| {}).with_context(|| problem.file.clone())?;
    problem.name_data(&mut outcome);
    Ok(outcome)
}

/// Fits, and leaves everything in the folder.
pub(crate) fn work(
    problem: &Problem,
    folder: &Folder,
    wanted: &Wanted<'_>,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<Files> {
    let Problem { file, data, .. } = problem;
    let Wanted { name, uncertainty, command, plots } = *wanted;
    let mut fit = found(problem, tell)?;
    // More data do not mend a model that misses those there are.
    if fit.outcome.sigma_source != SigmaSource::Widened {
        tell("asking what to measure next");
        let advice = advise(data, &fit, Ask::IfNeeded).with_context(|| file.clone())?;
        fit.outcome.advice = advice.into_iter().map(|proposal| proposal.found).collect();
    }
    let title = format!("{name}: {}", wording::verdict(&fit.outcome));
    let mut files = vec![("curves.csv".to_owned(), curves_csv(data, &fit)?)];
    let mut pictures = Vec::new();
    if plots {
        tell("drawing the charts");
        pictures = drawn(figures(data, &fit, name, &title)?)?;
        files.push((PAGE.to_owned(), report(&fit, name, &pictures)));
        files.extend(chart_files(&pictures));
    }
    let mut names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
    let mut json = fit_json(&fit.outcome)?;
    files.push(("fit.json".to_owned(), json.clone()));
    // What stands is written before the long work begins, and what belongs to an earlier fit is taken away.
    let is_ours = folder.path().join("fit.json").is_file();
    folder.write(&files)?;
    if is_ours {
        let pictures = PICTURES.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]);
        let all = pictures.chain(FILES.map(str::to_owned)).chain([PAGE.to_owned()]);
        folder.remove_stale(&all.filter(|name| !names.contains(name)).collect::<Vec<String>>());
    }
    let methods = Methods::of(uncertainty, command);
    if let Some(intervals) = Intervals::ask(methods, uncertainty, data, &fit, tell)? {
        fit.outcome.uncertainty = Some(intervals.compared(&fit));
        json = fit_json(&fit.outcome)?;
        let mut files = intervals.files()?;
        if plots {
            let more = drawn(intervals.figures(&fit.outcome, &title)?)?;
            files.extend(chart_files(&more));
            pictures.extend(more);
        }
        names.extend(files.iter().map(|(name, _)| name.clone()));
        if plots {
            files.push((PAGE.to_owned(), report(&fit, name, &pictures)));
        }
        files.push(("fit.json".to_owned(), json.clone()));
        folder.write(&files)?;
    }
    names.insert(0, "fit.json".to_owned());
    Ok(Files { fit, json, names })
}

/// Takes away what an earlier fit left in the folder, and the folder if nothing else is in it.
pub(crate) fn take_away(folder: &Path) {
    if !folder.join("fit.json").is_file() {
        return;
    }
    let pictures = PICTURES.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")]);
    let others = FILES.into_iter().chain([PAGE, "curves.csv", "fit.json"]).map(str::to_owned);
    pictures.chain(others).for_each(|name| drop(fs::remove_file(folder.join(name))));
    let _ = fs::remove_dir(folder);
}

/// Whether the folder holds these bytes as `fit.json`, by their hash, and the page where there are plots.
pub(crate) fn is_left(folder: &Path, sha256: &str, plots: bool) -> bool {
    let found = fs::read(folder.join("fit.json")).is_ok_and(|bytes| hex_sha256(&bytes) == sha256);
    found && (!plots || folder.join(PAGE).is_file())
}

/// The charts that every fit has.
fn figures(data: &Dataset, fit: &Fit, name: &str, title: &str) -> Result<Vec<(&'static str, Figure)>> {
    let values = wording::values(&fit.outcome);
    let mut figures = vec![
        ("curves", curves_figure(data, fit, title, &values)),
        ("residuals", residuals_figure(data, fit, title, &values)),
    ];
    if fit.outcome.settings.search == Search::Global
        && let Some(map) = chi_square_map(data, fit, MAP_CELLS)?
    {
        figures.push(("atlas", map_figure(&map, &fit.outcome, title)?));
    }
    // Colours are an extra: where the model has none, as beyond a table of indices, the fit stands.
    match sweep::of_fit(name, &fit.outcome) {
        Ok(figure) => figures.extend(figure.map(|figure| ("sweep", figure))),
        Err(error) => output::complain(&format!("no colours are drawn: {error:#}")),
    }
    Ok(figures)
}

/// The page with all pictures there are.
fn report(fit: &Fit, file: &str, pictures: &[(&'static str, Picture)]) -> Vec<u8> {
    let charts: Vec<Chart<'_>> = pictures.iter().map(|(name, picture)| Chart::named(name, &picture.svg)).collect();
    page(&fit.outcome, file, &charts, &swatches(&fit.outcome).unwrap_or_default()).into_bytes()
}

fn outcome(found: &FitOutcome) -> Outcome {
    if found.verdict == Verdict::NotConverged {
        return Outcome::NotConverged;
    }
    let unknown: Vec<&str> =
        found.settings.required.iter().filter(|parameter| !is_known(found, **parameter)).map(|p| p.name()).collect();
    if !unknown.is_empty() {
        let (names, verb) = (wording::list(&unknown), if unknown.len() == 1 { "is" } else { "are" });
        return Outcome::NotIdentifiable(format!("{names} {verb} required but not determined by these data"));
    }
    if found.verdict == Verdict::NoThickness {
        return Outcome::NotIdentifiable("the data determine no thickness".to_owned());
    }
    Outcome::Done
}

fn is_known(found: &FitOutcome, parameter: Parameter) -> bool {
    let estimates = found.parameters.each();
    let estimate = estimates[parameter.index()].1;
    is_told(estimate.status, estimate.sigma)
}

/// Whether a parameter that is required is there.
pub(crate) fn is_told(status: Status, sigma: Option<f64>) -> bool {
    match status {
        Status::Fixed => true,
        Status::Linked => sigma.is_some(),
        status => status.is_determined(),
    }
}
