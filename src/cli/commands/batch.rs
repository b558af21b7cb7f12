//! `morpho-fit batch`: many fits with the same settings, one table.

mod charts;
mod ending;

use self::charts::figure;
use self::ending::{code, ended};
use crate::args::{BatchArgs, BatchOutputArgs, ProblemArgs, ReadingArgs, UncertaintyArgs, UncertaintyWord};
use crate::commands::fit::{Wanted, found, work};
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage, code_of};
use crate::items::{self, Item, folder_names};
use crate::journal::{Earlier, Entry, Journal, Reports};
use crate::options::{Choices, Problem, hex_sha256};
use crate::output::{self, Folder, WIDTH};
use crate::progress::Count;
use anyhow::{Context, Result, anyhow};
use morpho_fit::dataset::Findings;
use morpho_fit::export::{BATCH_SCHEMA, Batch, BatchCounts, BatchFit, BatchRow, batch_csv, batch_json};
use morpho_fit::inversion::Fitter;
use morpho_fit::report::{batch, terminal};
use serde_json::json;
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

const TABLE: &str = "batch.csv";
const WHOLE: &str = "batch.json";
const JOURNAL: &str = "batch.journal";
/// Charts, each with the ends .svg and .png.
const PICTURES: [&str; 2] = ["items", "map"];
const PROGRAM: &str = concat!("morpho-fit ", env!("CARGO_PKG_VERSION"));
/// Items with an error that are told at once, and lines of each.
const TOLD: (usize, usize) = (5, 3);

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
    /// The folder of each item below the folder of the results.
    folders: Vec<String>,
}

/// An item that was fitted, or could not be.
struct Done {
    row: BatchRow,
    /// The exit code that it alone would have.
    code: u8,
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
    let taken: Vec<String> = pictures().chain([TABLE, WHOLE, JOURNAL].map(str::to_owned)).collect();
    let work = Work {
        choices: &choices,
        reading: &problem.reading,
        uncertainty: &uncertainty,
        reports,
        folders: folder_names(&items, &taken),
        folder: &folder,
        items: &items,
        fitter: Fitter::new(choices.settings.clone()).ok(),
    };
    let settings_sha256 = identity(&choices, &problem, &columns.by, reports, &uncertainty)?;
    let rows = work
        .refuse_to_replace(&taken, &data)
        .and_then(|()| work.rows(&settings_sha256, output.quiet))
        .inspect_err(|_| folder.abandon())?;
    let (rows, codes): (Vec<BatchRow>, Vec<u8>) = rows.into_iter().map(|done| (done.row, done.code)).unzip();
    let by: Vec<String> = by.iter().flat_map(|_| columns.by.iter().map(|name| name.trim().to_owned())).collect();
    let batch = Batch {
        schema: BATCH_SCHEMA.to_owned(),
        program: PROGRAM.to_owned(),
        settings_sha256,
        seed: choices.settings.seed,
        settings: choices.settings.clone(),
        by,
        reports: reports.word().to_owned(),
        counts: BatchCounts::of(&rows),
        items: rows,
    };
    let names = write(&batch, &folder, !output.no_plots)?;
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
    fn rows(&self, settings_sha256: &str, quiet: bool) -> Result<Vec<Done>> {
        let journal = self.folder.path().join(JOURNAL);
        let earlier = Earlier::read(&journal, &self.folder.path().join(WHOLE))?;
        let mut done: Vec<Option<Done>> = Vec::with_capacity(self.items.len());
        let (mut other, mut changed) = (0, 0);
        for (item, folder) in self.items.iter().zip(&self.folders) {
            let entries = earlier.of(&item.name);
            let sha256 = if entries.is_empty() { None } else { item.sha256() };
            let ours = |entry: &&Entry| entry.settings_sha256 == settings_sha256 && entry.reports >= self.reports;
            let same = |entry: &&Entry| {
                let row = &entry.row;
                sha256.is_some() && row.sha256 == sha256 && row.place == item.place && row.fit.is_some()
            };
            let there = |_: &&Entry| self.reports == Reports::None || self.has_report(folder, sha256.as_deref());
            let found = entries.iter().filter(ours).filter(same).find(there);
            if found.is_none() {
                changed += usize::from(entries.iter().any(|entry| ours(&entry) && entry.row.sha256 != sha256));
                other += usize::from(!entries.is_empty() && !entries.iter().any(|entry| ours(&entry)));
            }
            done.push(found.map(|entry| self.done(item, Ok(entry.row.clone()))));
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
        }
        if !open.is_empty() {
            self.fit(&open, &journal, settings_sha256, quiet, &mut done)?;
        }
        let rows: Vec<Done> = done.into_iter().flatten().collect();
        if rows.iter().all(|done| done.row.sha256.is_none())
            && let Some(first) = rows.first()
        {
            // Nothing at all could be read: there is no table to write.
            let _ = fs::remove_file(&journal);
            let text = first.row.error.clone().unwrap_or_default();
            return Err(anyhow!(text));
        }
        Ok(rows)
    }

    /// Whether the folder holds the fit of these data.
    fn has_report(&self, folder: &str, sha256: Option<&str>) -> bool {
        let file = fs::read(self.folder.path().join(folder).join("fit.json")).unwrap_or_default();
        let fit: serde_json::Value = serde_json::from_slice(&file).unwrap_or_default();
        sha256.is_some() && fit["data"]["sha256"].as_str() == sha256
    }

    /// Fits the items that are open, each on one thread where there are as many; each row goes into the journal as it is done.
    fn fit(
        &self,
        open: &[usize],
        journal: &Path,
        settings_sha256: &str,
        quiet: bool,
        done: &mut [Option<Done>],
    ) -> Result<()> {
        let mut journal = Journal::open(journal)?;
        let threads = rayon::current_num_threads();
        let workers = threads.min(open.len()).max(1);
        // A fit within a pool of its own waits for no other: rayon would begin another item while one waits for its parts.
        let pool = || rayon::ThreadPoolBuilder::new().num_threads((threads / workers).max(1)).build();
        let pools = (0..workers).map(|_| pool()).collect::<Result<Vec<_>, _>>();
        let pools = pools.context("the threads cannot be started")?;
        let next = AtomicUsize::new(0);
        let count = Count::new(open.len(), quiet);
        let (sender, receiver) = mpsc::channel();
        thread::scope(|scope| {
            for pool in pools {
                let (sender, next) = (sender.clone(), &next);
                scope.spawn(move || {
                    while let Some(&index) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
                        if sender.send((index, pool.install(|| self.one(index)))).is_err() {
                            return;
                        }
                    }
                });
            }
            drop(sender);
            let mut told = 0;
            for (index, found) in receiver {
                if let Some(error) = &found.row.error {
                    told += 1;
                    if told <= TOLD.0 {
                        count.aside(|| output::complain(&format!("item {}: {}", found.row.item, first_lines(error))));
                    }
                }
                let row = BatchRow { error: found.row.error.as_deref().map(one_line), ..found.row };
                if row.fit.is_some() {
                    let settings_sha256 = settings_sha256.to_owned();
                    journal.append(&Entry { settings_sha256, reports: self.reports, row: row.clone() })?;
                }
                if let Some(place) = done.get_mut(index) {
                    *place = Some(Done { row, ..found });
                }
                count.one_more();
            }
            Ok(())
        })
    }

    fn one(&self, index: usize) -> Done {
        let item = &self.items[index];
        let found = self.fitted(item, &self.folders[index]);
        self.done(item, found)
    }

    fn fitted(&self, item: &Item, folder: &str) -> Result<BatchRow> {
        let (data, sha256) = item.read(self.reading)?;
        let Choices { settings, beside } = self.choices.clone();
        let problem = Problem { file: item.file.clone(), data, settings, beside, sha256 };
        let outcome = if self.reports == Reports::None {
            found(&problem, self.fitter.as_ref(), &|_| {})?.outcome
        } else {
            let folder = Folder::open(&self.folder.path().join(folder))?;
            let wanted = Wanted {
                name: &item.name,
                uncertainty: self.uncertainty,
                command: UncertaintyWord::Covariance,
                plots: self.reports == Reports::WithPlots,
            };
            work(&problem, &folder, &wanted, &|_| {}).inspect_err(|_| folder.abandon())?.fit.outcome
        };
        let sha256 = Some(outcome.data.sha256.clone());
        Ok(BatchRow {
            item: item.name.clone(),
            place: item.place,
            sha256,
            fit: Some(BatchFit::of(&outcome)),
            error: None,
        })
    }

    /// The row with the exit code that it would have.
    fn done(&self, item: &Item, found: Result<BatchRow>) -> Done {
        match found {
            Ok(row) => {
                let code = row.fit.as_ref().map_or(0, |fit| code(fit, &self.choices.settings.required));
                Done { row, code }
            }
            Err(error) => {
                let findings = error.chain().find_map(|cause| cause.downcast_ref::<Findings>());
                let text = findings.map_or_else(|| format!("{error:#}"), ToString::to_string);
                let (name, place, sha256) = (item.name.clone(), item.place, item.sha256());
                let row = BatchRow { item: name, place, sha256, fit: None, error: Some(text) };
                Done { row, code: code_of(&error) }
            }
        }
    }
}

fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<&str>>().join("; ")
}

fn first_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let more = lines.len().saturating_sub(TOLD.1);
    let shown = lines.iter().take(TOLD.1).copied().collect::<Vec<&str>>().join("\n");
    if more > 0 { format!("{shown}\nand more: `error` in {TABLE}") } else { shown }
}

/// Writes table, JSON and charts, and takes the journal away.
fn write(batch: &Batch, folder: &Folder, plots: bool) -> Result<Vec<String>> {
    let mut files = vec![(TABLE.to_owned(), batch_csv(batch)?), (WHOLE.to_owned(), batch_json(batch)?)];
    if plots && let Some((name, figure)) = figure(batch)? {
        files.extend(chart_files(&drawn(vec![(name, figure)])?));
    }
    let is_ours = folder.path().join(WHOLE).is_file();
    folder.write(&files)?;
    let names: Vec<String> = files.into_iter().map(|(name, _)| name).collect();
    if is_ours {
        folder.remove_stale(&pictures().filter(|name| !names.contains(name)).collect::<Vec<String>>());
    }
    folder.remove_stale(&[JOURNAL.to_owned()]);
    Ok(names)
}
