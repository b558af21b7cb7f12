//! `morpho-fit constant`: a fit with a constant of the model fitted too.

use crate::args::ConstantArgs;
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage};
use crate::options::Problem;
use crate::output::{self, Folder, WIDTH};
use crate::progress::Progress;
use anyhow::{Context, Result};
use morpho_fit::export::{constant_csv, constant_json};
use morpho_fit::inversion::Verdict;
use morpho_fit::inversion::intervals::{ConstantProfile, over_constant};
use morpho_fit::plot::intervals::constant_figure;
use morpho_fit::report::{constant, terminal, wording};
use std::path::{Path, PathBuf};

type Files = Vec<(String, Vec<u8>)>;

pub(crate) fn run(args: &ConstantArgs) -> Result<Outcome> {
    let problem = Problem::read(&args.problem)?;
    let stem = Path::new(&problem.file).file_stem().map_or("data".into(), |stem| stem.to_string_lossy().into_owned());
    let place = args.output.out.clone().unwrap_or_else(|| Path::new("fits").join(stem).join("constant"));
    let folder = Folder::open(&place)?;
    let (found, json, files) = work(args, &problem, &folder).inspect_err(|_| folder.abandon())?;
    if args.output.json {
        output::print(&json)?;
    } else if !args.output.quiet {
        let verdict = wording::verdict(&found.fit.outcome);
        let mut report = format!("{}: {verdict}\n\n{}\n", problem.file, constant::text(&found, WIDTH));
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        let written = format!("{}: {}", folder.path().display(), names.join(" "));
        report.push_str(&terminal::wrapped(&written, "  ", "    ", WIDTH));
        output::print_report(&report)?;
    }
    let name = found.constant;
    Ok(if found.fit.outcome.verdict == Verdict::NotConverged {
        Outcome::NotConverged
    } else if found.at_end || found.intervals.interval_95 == [None, None] {
        Outcome::NotIdentifiable(format!("{name} is not determined within its range"))
    } else {
        Outcome::Done
    })
}

fn work(args: &ConstantArgs, problem: &Problem, folder: &Folder) -> Result<(ConstantProfile, Vec<u8>, Files)> {
    let [varied] = args.vary.as_slice() else {
        return Err(Usage("one constant is fitted at a time: give one --vary".to_owned()).into());
    };
    let progress = Progress::new(args.output.quiet);
    let tell = |what: &str| progress.tell(what);
    let mut found = over_constant(&problem.data, &problem.settings, varied.constant, varied.limits, &tell)
        .with_context(|| problem.file.clone())?;
    if let Some(sha256) = &problem.sha256 {
        found.fit.outcome.data.sha256.clone_from(sha256);
    }
    let json = constant_json(&found)?;
    let mut files =
        vec![("constant.json".to_owned(), json.clone()), ("constant.csv".to_owned(), constant_csv(&found)?)];
    if !args.output.no_plots {
        let file = Path::new(&problem.file);
        let name = file.file_name().map_or(problem.file.clone().into(), |name| name.to_string_lossy());
        let title = format!("{name}: {} fitted too", found.constant);
        files.extend(chart_files(&drawn(vec![("constant", constant_figure(&found, &title)?)])?));
    }
    refuse_to_replace(folder, &files, [PathBuf::from(&problem.file)])?;
    folder.write(&files)?;
    Ok((found, json, files))
}
