//! `morpho-fit batch`: many fits with the same settings, one table.

mod charts;
mod ending;

use self::charts::charts;
use self::ending::{code, ended, first_lines, one_line};
use crate::args::{BatchArgs, BatchOutputArgs, ProblemArgs, ReadingArgs, UncertaintyArgs, UncertaintyWord};
use crate::commands::fit::{Wanted, is_left, outcome_alone, take_away, work};
use crate::commands::refuse_to_replace;
use crate::exit::{Outcome, Usage, code_of};
use crate::items::{self, Item, folder_names};
use crate::journal::{Earlier, Entry, Journal, Reports};
use crate::options::{Choices, Problem, hex_sha256};
use crate::output::{self, Folder, WIDTH};
use crate::progress::Count;
use anyhow::{Result, anyhow};
use morpho_fit::dataset::Findings;
use morpho_fit::export::{BATCH_SCHEMA, Batch, BatchCounts, BatchFit, BatchRow, batch_csv, batch_json};
use morpho_fit::inversion::Fitter;
use morpho_fit::numerics::side_by_side::side_by_side;
use morpho_fit::report::{batch, terminal};
use serde_json::json;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

const TABLE: &str = "batch.csv";
const WHOLE: &str = "batch.json";
const JOURNAL: &str = "batch.journal";
/// The table before, if the new one has not all of its fits.
const EARLIER: &str = "batch.earlier";
/// Charts, each with the ends .svg and .png.
const PICTURES: [&str; 2] = ["items", "map"];
const PROGRAM: &str = concat!("morpho-fit ", env!("CARGO_PKG_VERSION"));
/// Items with an error that are told at once.
const TOLD: usize = 5;

/// Everything that the fit of an item needs.
struct Work<'a> {
    choices: &'a Choices,
    reading: &'a ReadingArgs,
    uncertainty: &'a UncertaintyArgs,
    reports: Reports,
    folder: &'a Folder,
    items: &'a [Item],
    /// None where no item can be fitted so: each says why.
    fitter: Option<Fitter>,
    /// The folder of each item below the folder of the results; none without reports.
    folders: Vec<String>,
}

/// An item that was fitted, or could not be.
struct Done {
    row: BatchRow,
    /// The exit code that it alone would have.
    code: u8,
    /// What its folder holds at least.
    reports: Reports,
}

/// All items, and what is left for another run.
struct Rows {
    done: Vec<Done>,
    journal: Journal,
    /// Earlier rows of items that cannot be read now, the oldest first.
    kept: Vec<Entry>,
}

pub(crate) fn run(args: BatchArgs) -> Result<Outcome> {
    let began = Instant::now();
    let (data, columns, problem, uncertainty, output) = args.split();
    let reports = match (output.reports, output.no_plots) {
        (false, _) => Reports::None,
        (true, true) => Reports::WithoutPlots,
        (true, false) => Reports::WithPlots,
    };
    if reports == Reports::None && !uncertainty.uncertainty.is_empty() {
        return Err(Usage("--uncertainty is told in the folder of each item; add --reports".to_owned()).into());
    }
    let by = items::split_by(&columns.by)?;
    let choices = Choices::of(&problem)?;
    let items = match (&by, data.as_slice()) {
        (None, paths) => items::files(paths)?,
        (Some(by), [path]) => items::parts(path, &problem.reading, by)?,
        (Some(_), _) => return Err(Usage("--by splits one file; give one".to_owned()).into()),
    };
    let folder = Folder::open(&place(&output, &data))?;
    let taken: Vec<String> = pictures().chain([TABLE, WHOLE, JOURNAL].map(str::to_owned)).chain(earlier()).collect();
    let work = Work {
        choices: &choices,
        reading: &problem.reading,
        uncertainty: &uncertainty,
        reports,
        folders: if reports == Reports::None { Vec::new() } else { folder_names(&items, &taken) },
        folder: &folder,
        items: &items,
        fitter: Fitter::new(choices.settings.clone()).ok(),
    };
    let names: Vec<String> = columns.by.iter().map(|name| name.trim().to_owned()).collect();
    let settings_sha256 = identity(&choices, &problem, &names, reports, &uncertainty)?;
    let Rows { done, journal, kept } = work
        .refuse_to_replace(&taken, &data)
        .and_then(|()| work.rows(&settings_sha256, output.quiet))
        .inspect_err(|_| folder.abandon())?;
    // Folders that are there already hold more than this run would have made.
    let reports = done.iter().filter(|done| done.row.fit.is_some()).map(|done| done.reports).min().unwrap_or(reports);
    let (rows, codes): (Vec<BatchRow>, Vec<u8>) = done.into_iter().map(|done| (done.row, done.code)).unzip();
    let batch = Batch {
        schema: BATCH_SCHEMA.to_owned(),
        program: PROGRAM.to_owned(),
        settings_sha256,
        seed: choices.settings.seed,
        settings: choices.settings.clone(),
        compared: choices.beside.clone(),
        by: names,
        reports: reports.word().to_owned(),
        counts: BatchCounts::of(&rows),
        items: rows,
    };
    let names = write(&batch, &folder, !output.no_plots)?;
    let foreign = journal.finish(&kept)?;
    for (count, of) in [(foreign, "another run"), (kept.len(), "items that cannot be read now")] {
        if count > 0 && !output.quiet {
            output::complain(&format!("{JOURNAL} keeps rows of {of}: {count}"));
        }
    }
    if output.json {
        output::print(&batch_json(&batch)?)?;
    } else if !output.quiet {
        let seconds = began.elapsed().as_secs_f64();
        let written = format!("{}: {} ({seconds:.2} s)", folder.path().display(), names.join(" "));
        let report = format!("{}\n{}", batch::text(&batch), terminal::wrapped(&written, "  ", "    ", WIDTH));
        output::print_report(&report)?;
    }
    Ok(ended(&batch, &codes))
}

fn place(output: &BatchOutputArgs, data: &[PathBuf]) -> PathBuf {
    output.out.clone().unwrap_or_else(|| match data {
        [only] if only != Path::new("-") => {
            let stem = only.file_stem().map_or("data".into(), |stem| stem.to_string_lossy());
            Path::new("fits").join(stem.as_ref()).join("batch")
        }
        _ => Path::new("fits").join("batch"),
    })
}

fn pictures() -> impl Iterator<Item = String> {
    PICTURES.iter().flat_map(|name| [format!("{name}.svg"), format!("{name}.png")])
}

/// Hash of everything that decides what a fit finds, the data apart.
fn identity(
    choices: &Choices,
    problem: &ProblemArgs,
    by: &[String],
    reports: Reports,
    uncertainty: &UncertaintyArgs,
) -> Result<String> {
    let mut settings = choices.settings.clone();
    // What is required decides how the program ends, not what it finds.
    settings.required.clear();
    let read = &problem.reading;
    let UncertaintyArgs { uncertainty: methods, replicates, effective, max_evaluations } = uncertainty;
    let asked = (reports != Reports::None && !methods.is_empty())
        .then(|| json!([format!("{methods:?}"), replicates, effective, max_evaluations]));
    let whole = json!({
        "program": PROGRAM,
        "settings": settings,
        "compared": choices.beside,
        "constants": [read.wavelength, read.theta, read.phi, read.omega, read.sigma],
        "polarization": read.polarization.map(|word| word.value().word()),
        "wide": read.wide.map(|word| format!("{word:?}")),
        "intensity_column": read.intensity_column,
        "by": by,
        "intervals": asked,
    });
    Ok(hex_sha256(&serde_json::to_vec(&whole)?))
}

impl Work<'_> {
    /// An error if a result would take the place of data.
    fn refuse_to_replace(&self, taken: &[String], data: &[PathBuf]) -> Result<()> {
        let files: Vec<(String, Vec<u8>)> = taken.iter().map(|name| (name.clone(), Vec::new())).collect();
        refuse_to_replace(self.folder, &files, data.iter().cloned())?;
        if self.reports == Reports::None {
            return Ok(());
        }
        let parents: HashSet<PathBuf> =
            data.iter().filter_map(|path| path.canonicalize().ok()?.parent().map(Path::to_owned)).collect();
        let folders = self.folders.iter().map(|name| self.folder.path().join(name));
        match folders.filter_map(|folder| folder.canonicalize().ok()).find(|folder| parents.contains(folder)) {
            Some(folder) => {
                let folder = folder.display();
                Err(Usage(format!("{folder} has data in it and would get results; give another --out")).into())
            }
            None => Ok(()),
        }
    }

    /// The rows of all items, in their order: those that are there already, and the others fitted.
    fn rows(&self, settings_sha256: &str, quiet: bool) -> Result<Rows> {
        let path = self.folder.path().join(JOURNAL);
        let earlier = Earlier::read(&path, &self.folder.path().join(WHOLE))?;
        let mut done: Vec<Option<Done>> = Vec::with_capacity(self.items.len());
        let (mut other, mut changed, mut missing) = (0, 0, 0);
        for (index, item) in self.items.iter().enumerate() {
            let entries = earlier.of(&item.name);
            let sha256 = if entries.is_empty() { None } else { item.sha256() };
            let ours = |entry: &&Entry| entry.settings_sha256 == settings_sha256 && entry.reports >= self.reports;
            let same = |entry: &&Entry| {
                let row = &entry.row;
                sha256.is_some() && row.sha256 == sha256 && row.place == item.place && row.fit.is_some()
            };
            let found = entries.iter().filter(ours).filter(same).find(|entry| self.has_report(index, &entry.row));
            if found.is_none() {
                let lacks = entries.iter().any(|entry| ours(&entry) && same(&entry));
                let differs = |entry: &Entry| ours(&entry) && entry.row.sha256 != sha256;
                missing += usize::from(lacks);
                changed += usize::from(!lacks && sha256.is_some() && entries.iter().any(differs));
                other += usize::from(!entries.is_empty() && !entries.iter().any(|entry| ours(&entry)));
            }
            done.push(found.map(|entry| self.done(item, entry.reports, Ok(entry.row.clone()))));
        }
        let open: Vec<usize> = (0..done.len()).filter(|&index| done[index].is_none()).collect();
        if !quiet {
            let (there, all) = (done.len() - open.len(), done.len());
            let place = self.folder.path().display();
            if there > 0 {
                output::complain(&format!("{there} of {all} items are fitted already; {} to do", open.len()));
            }
            for (count, what) in [(other, "other settings or of another version"), (changed, "other data")] {
                if count > 0 {
                    output::complain(&format!("rows in {place} of {what} are not used: {count}"));
                }
            }
            if missing > 0 {
                output::complain(&format!("folders in {place} that are missing or hold another fit: {missing}"));
            }
        }
        let mut journal = Journal::new(&path, &earlier);
        if !open.is_empty() {
            self.fit(&open, &mut journal, settings_sha256, quiet, &mut done)?;
        }
        let done: Vec<Done> = done.into_iter().flatten().collect();
        let unreadable = || done.iter().map(|done| &done.row).filter(|row| row.sha256.is_none());
        if unreadable().count() == done.len()
            && let Some(first) = unreadable().next()
        {
            // There is no table to write, and what an earlier run left stays as it is.
            let text = first.error.clone().unwrap_or_default();
            return Err(anyhow!(text));
        }
        let finished = |entry: &&Entry| entry.row.fit.is_some();
        let kept = unreadable().flat_map(|row| earlier.of(&row.item).iter().rev().filter(finished)).cloned().collect();
        Ok(Rows { done, journal, kept })
    }

    /// The folder of an item where each has one.
    fn place_of(&self, index: usize) -> Option<PathBuf> {
        self.folders.get(index).map(|name| self.folder.path().join(name))
    }

    /// Whether the folder of the item holds what the fit of this row left there, if it is to have one.
    fn has_report(&self, index: usize, row: &BatchRow) -> bool {
        let Some(folder) = self.place_of(index) else { return true };
        let plots = self.reports == Reports::WithPlots;
        row.report_sha256.as_deref().is_some_and(|sha256| is_left(&folder, sha256, plots))
    }

    /// Fits the items that are open, each on one thread where there are as many; each row goes into the journal as it
    /// is done.
    fn fit(
        &self,
        open: &[usize],
        journal: &mut Journal,
        settings_sha256: &str,
        quiet: bool,
        done: &mut [Option<Done>],
    ) -> Result<()> {
        let count = Count::new(open.len(), quiet);
        let mut told = 0;
        let take = |place: usize, found: Done| {
            if let Some(error) = &found.row.error {
                told += 1;
                if told <= TOLD {
                    count.aside(|| output::complain(&format!("item {}: {}", found.row.item, first_lines(error))));
                } else if told == TOLD + 1 {
                    count.aside(|| output::complain(&format!("and more items with errors: `error` in {TABLE}")));
                }
            }
            let row = BatchRow { error: found.row.error.as_deref().map(one_line), ..found.row };
            if row.fit.is_some() {
                let settings_sha256 = settings_sha256.to_owned();
                journal.append(&Entry { settings_sha256, reports: self.reports, row: row.clone() })?;
            }
            if let Some(place) = done.get_mut(open[place]) {
                *place = Some(Done { row, ..found });
            }
            count.one_more();
            Ok(())
        };
        side_by_side(open.len(), |place| self.one(open[place]), take)
    }

    fn one(&self, index: usize) -> Done {
        let item = &self.items[index];
        let folder = self.place_of(index);
        let found = self.fitted(item, folder.as_deref());
        let done = self.done(item, self.reports, found);
        // Results of other data beside a row that says there are none; what cannot be read now may come back.
        if let (None, Some(_), Some(folder)) = (&done.row.fit, &done.row.sha256, &folder) {
            take_away(folder);
        }
        done
    }

    fn fitted(&self, item: &Item, folder: Option<&Path>) -> Result<BatchRow> {
        let (data, sha256) = item.read(self.reading)?;
        let Choices { settings, beside } = self.choices.clone();
        let problem = Problem { file: item.file.clone(), data, settings, beside, sha256 };
        let (outcome, report_sha256) = if let Some(folder) = folder {
            let folder = Folder::open(folder)?;
            let wanted = Wanted {
                name: &item.name,
                uncertainty: self.uncertainty,
                command: UncertaintyWord::Covariance,
                plots: self.reports == Reports::WithPlots,
            };
            let files = work(&problem, &folder, &wanted, &|_| {}).inspect_err(|_| folder.abandon())?;
            (files.fit.outcome, Some(hex_sha256(&files.json)))
        } else {
            (outcome_alone(&problem, self.fitter.as_ref())?, None)
        };
        let sha256 = Some(outcome.data.sha256.clone());
        Ok(BatchRow {
            item: item.name.clone(),
            place: item.place,
            sha256,
            report_sha256,
            fit: Some(BatchFit::of(&outcome)),
            error: None,
        })
    }

    /// The row with the exit code that it would have.
    fn done(&self, item: &Item, reports: Reports, found: Result<BatchRow>) -> Done {
        match found {
            Ok(row) => {
                let code = row.fit.as_ref().map_or(0, |fit| code(fit, &self.choices.settings.required));
                Done { row, code, reports }
            }
            Err(error) => {
                let findings = error.chain().find_map(|cause| cause.downcast_ref::<Findings>());
                let text = findings.map_or_else(|| format!("{error:#}"), ToString::to_string);
                let (name, place, sha256) = (item.name.clone(), item.place, item.sha256());
                let row = BatchRow { item: name, place, sha256, report_sha256: None, fit: None, error: Some(text) };
                Done { row, code: code_of(&error), reports }
            }
        }
    }
}

/// Names of the table before and of all of it.
fn earlier() -> [String; 2] {
    ["csv", "json"].map(|end| format!("{EARLIER}.{end}"))
}

/// The table that is there, under other names, if it has fits of other settings or of items that the new one has not.
fn set_aside(batch: &Batch, folder: &Folder) -> Vec<(String, Vec<u8>)> {
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap_or_default();
    let (table, whole) = (bytes(TABLE), bytes(WHOLE));
    let Ok(old) = serde_json::from_slice::<Batch>(&whole) else { return Vec::new() };
    let items: HashSet<&str> = batch.items.iter().map(|row| row.item.as_str()).collect();
    let other = old.settings_sha256 != batch.settings_sha256;
    let is_lost = |row: &BatchRow| row.fit.is_some() && (other || !items.contains(row.item.as_str()));
    if !old.items.iter().any(is_lost) {
        return Vec::new();
    }
    output::complain(&format!(
        "the table that was there has other settings or items; it is kept in {EARLIER}.csv and {EARLIER}.json"
    ));
    earlier().into_iter().zip([table, whole]).collect()
}

/// Writes table, JSON and charts.
fn write(batch: &Batch, folder: &Folder, plots: bool) -> Result<Vec<String>> {
    let mut files = vec![(TABLE.to_owned(), batch_csv(batch)?), (WHOLE.to_owned(), batch_json(batch)?)];
    if plots {
        files.extend(charts(batch));
    }
    let is_ours = folder.path().join(WHOLE).is_file();
    files.extend(set_aside(batch, folder));
    folder.write(&files)?;
    let names: Vec<String> = files.into_iter().map(|(name, _)| name).collect();
    if is_ours {
        folder.remove_stale(&pictures().filter(|name| !names.contains(name)).collect::<Vec<String>>());
    }
    Ok(names)
}
