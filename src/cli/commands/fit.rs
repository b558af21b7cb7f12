//! `morpho-fit DATA.csv`: fit, report, files.

use crate::args::{FitArgs, ModelWord, OutputArgs};
use crate::exit::Outcome;
use crate::options::Problem;
use crate::output::{self, Folder};
use crate::progress::Progress;
use anyhow::{Context, Result};
use morpho_fit::dataset::Dataset;
use morpho_fit::export::{curves_csv, fit_json};
use morpho_fit::inversion::{Fit, FitOutcome, Parameter, Status, Verdict, choose, fit};
use morpho_fit::plot::fit::{curves_figure, residuals_figure};
use morpho_fit::plot::{Figure, draw};
use morpho_fit::report::{terminal, wording};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Characters in a line of the report.
const WIDTH: usize = 100;

pub(crate) fn run(args: &FitArgs) -> Result<Outcome> {
    let began = Instant::now();
    let problem = Problem::read_for_any(&args.problem)?;
    let folder = Folder::open(&place(&args.output, &problem.file))?;
    let found = work(&problem, &folder, args).inspect_err(|_| folder.abandon())?;
    let Files { fit, json, names } = found;
    if args.output.json {
        output::print(&json)?;
    } else if !args.output.quiet {
        let mut report = terminal::text(&fit, WIDTH);
        let seconds = began.elapsed().as_secs_f64();
        report.push_str(&format!("\n  {}: {} ({seconds:.2} s)\n", folder.path().display(), names.join(" ")));
        output::print_report(&report)?;
    }
    Ok(outcome(&fit.outcome))
}

/// `fits/<name of the data>`, unless another folder is named.
fn place(args: &OutputArgs, file: &str) -> PathBuf {
    args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(file).file_stem().map_or("data".into(), |stem| stem.to_string_lossy());
        Path::new("fits").join(stem.as_ref())
    })
}

/// The charts of a fit.
const PICTURES: [&str; 4] = ["curves.svg", "curves.png", "residuals.svg", "residuals.png"];

/// What was found and written.
struct Files {
    fit: Fit,
    json: Vec<u8>,
    names: Vec<&'static str>,
}

fn work(problem: &Problem, folder: &Folder, args: &FitArgs) -> Result<Files> {
    let Problem { file, data, settings, .. } = problem;
    let progress = Progress::new(args.output.quiet);
    let tell = |what: &str| progress.tell(what);
    let found = match args.problem.model.model {
        ModelWord::Auto => choose(data, settings, &tell).map(|choice| choice.fit),
        ModelWord::Blend | ModelWord::Paper => fit(data, settings, &tell),
    };
    let mut fit = found.with_context(|| file.clone())?;
    if let Some(sha256) = &problem.sha256 {
        fit.outcome.data.sha256.clone_from(sha256);
    }
    progress.tell("writing the results");
    let json = fit_json(&fit.outcome)?;
    let mut files = vec![("fit.json", json.clone()), ("curves.csv", curves_csv(data, &fit)?)];
    if !args.output.no_plots {
        files.extend(plots(file, data, &fit)?);
    }
    folder.write(&files)?;
    if args.output.no_plots {
        folder.remove_stale(&PICTURES);
    }
    Ok(Files { fit, json, names: files.into_iter().map(|(name, _)| name).collect() })
}

fn plots(file: &str, data: &Dataset, fit: &Fit) -> Result<Vec<(&'static str, Vec<u8>)>> {
    let name = Path::new(file).file_name().map_or(file.into(), |name| name.to_string_lossy());
    let title = format!("{name}: {}", wording::verdict(&fit.outcome));
    let values = wording::values(&fit.outcome);
    let picture = |figure: Figure, svg, png| -> Result<[(&'static str, Vec<u8>); 2]> {
        let picture = draw(&figure)?;
        Ok([(svg, picture.svg.into_bytes()), (png, picture.png)])
    };
    let curves = picture(curves_figure(data, fit, &title, &values), PICTURES[0], PICTURES[1])?;
    let residuals = picture(residuals_figure(data, fit, &title, &values), PICTURES[2], PICTURES[3])?;
    Ok(curves.into_iter().chain(residuals).collect())
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
    match estimate.status {
        Status::Fixed => true,
        Status::Linked => estimate.sigma.is_some(),
        status => status.is_determined(),
    }
}
