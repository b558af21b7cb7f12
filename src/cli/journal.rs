//! What a batch that was stopped has done: a line of JSON for each item, appended as it is done.

use crate::output;
use anyhow::{Context, Result};
use morpho_fit::export::{Batch, BatchRow};
use serde::{Deserialize, Serialize};
use std::collections::hash_map::DefaultHasher;
use std::collections::{HashMap, HashSet};
use std::fs::{File, OpenOptions};
use std::hash::{Hash, Hasher};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The disk itself is waited for no more often than this.
const BETWEEN_SYNCS: Duration = Duration::from_secs(1);

/// What lies in the folder of each item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Reports {
    None,
    WithoutPlots,
    WithPlots,
}

impl Reports {
    const ALL: [Self; 3] = [Self::None, Self::WithoutPlots, Self::WithPlots];

    /// The word in `batch.json`.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::WithoutPlots => "without_plots",
            Self::WithPlots => "with_plots",
        }
    }

    fn of(word: &str) -> Self {
        Self::ALL.into_iter().find(|reports| reports.word() == word).unwrap_or(Self::None)
    }
}

/// One line.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// Hash of program and settings.
    pub(crate) settings_sha256: String,
    pub(crate) reports: Reports,
    pub(crate) row: BatchRow,
}

/// Rows of earlier runs by their items; those of a journal, which are younger, go before those of a finished batch.
#[derive(Debug, Default)]
pub(crate) struct Earlier {
    rows: HashMap<String, Vec<Entry>>,
    /// Hashes of the lines of the journal.
    lines: HashSet<u64>,
}

impl Earlier {
    /// Everything that can be read; a line that was cut off, or is no line of ours, is left out.
    pub(crate) fn read(journal: &Path, finished: &Path) -> Result<Self> {
        let mut rows: HashMap<String, Vec<Entry>> = HashMap::new();
        let text = bytes(journal)?;
        let known = whole_lines(&text).map(hash).collect();
        for entry in whole_lines(&text).rev().filter_map(|line| serde_json::from_slice::<Entry>(line).ok()) {
            rows.entry(entry.row.item.clone()).or_default().push(entry);
        }
        if let Ok(batch) = serde_json::from_slice::<Batch>(&bytes(finished)?) {
            let reports = Reports::of(&batch.reports);
            for row in batch.items {
                let settings_sha256 = batch.settings_sha256.clone();
                rows.entry(row.item.clone()).or_default().push(Entry { settings_sha256, reports, row });
            }
        }
        Ok(Self { rows, lines: known })
    }

    /// The rows of an item, the youngest first.
    pub(crate) fn of(&self, item: &str) -> &[Entry] {
        self.rows.get(item).map_or(&[], Vec::as_slice)
    }
}

fn whole_lines(text: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    text.split_inclusive(|byte| *byte == b'\n').filter(|line| line.ends_with(b"\n"))
}

fn hash(line: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    line.hash(&mut hasher);
    hasher.finish()
}

fn line(entry: &Entry) -> Result<Vec<u8>> {
    let mut line = serde_json::to_vec(entry)?;
    line.push(b'\n');
    Ok(line)
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    match std::fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        other => other.with_context(|| format!("{} cannot be read", path.display())),
    }
}

/// A journal that is written to, perhaps by another run of the program at the same time.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    /// None before the first line.
    file: Option<File>,
    synced: Instant,
    /// Hashes of the lines that were there before or are of this run.
    known: HashSet<u64>,
}

impl Journal {
    /// The journal behind what is known of it.
    pub(crate) fn new(path: &Path, earlier: &Earlier) -> Self {
        Self { path: path.to_owned(), file: None, synced: Instant::now(), known: earlier.lines.clone() }
    }

    /// Appends a line; whoever ends this program from now on leaves it there.
    pub(crate) fn append(&mut self, entry: &Entry) -> Result<()> {
        let line = line(entry)?;
        self.known.insert(hash(&line));
        self.write(&line).with_context(|| format!("{} cannot be written", self.path.display()))
    }

    fn write(&mut self, line: &[u8]) -> std::io::Result<()> {
        if self.file.is_none() {
            let mut file = OpenOptions::new().append(true).create(true).open(&self.path)?;
            // A line that was cut off is ended, not taken away: it may be one that another run is about to end.
            if std::fs::read(&self.path)?.last().is_some_and(|byte| *byte != b'\n') {
                file.write_all(b"\n")?;
            }
            self.file = Some(file);
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        file.write_all(line)?;
        if self.synced.elapsed() > BETWEEN_SYNCS {
            file.sync_data()?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    /// Leaves what is to be kept, the oldest first, and nothing else; no file if that is nothing. Rows of another
    /// run, which writes at the same time, stay: their number is returned.
    pub(crate) fn finish(mut self, kept: &[Entry]) -> Result<usize> {
        let text = bytes(&self.path)?;
        let is_foreign =
            |line: &&[u8]| !self.known.contains(&hash(line)) && serde_json::from_slice::<Entry>(line).is_ok();
        let foreign = whole_lines(&text).filter(is_foreign).count();
        let kept = kept.iter().map(line).collect::<Result<Vec<Vec<u8>>>>()?;
        if foreign > 0 {
            let there: HashSet<u64> = whole_lines(&text).map(hash).collect();
            for line in kept.iter().filter(|line| !there.contains(&hash(line))) {
                self.write(line).with_context(|| format!("{} cannot be written", self.path.display()))?;
            }
        } else if kept.is_empty() {
            let _ = std::fs::remove_file(&self.path);
        } else {
            output::write(&self.path, &kept.concat())?;
        }
        Ok(foreign)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(item: &str, settings: &str) -> Entry {
        let row =
            BatchRow { item: item.to_owned(), place: None, sha256: None, report_sha256: None, fit: None, error: None };
        Entry { settings_sha256: settings.to_owned(), reports: Reports::None, row }
    }

    #[test]
    fn a_line_that_was_cut_off_is_left_out() {
        let folder = tempfile::TempDir::new().unwrap();
        let (path, none) = (folder.path().join("journal"), folder.path().join("none"));
        let mut journal = Journal::new(&path, &Earlier::default());
        journal.append(&entry("a", "old")).unwrap();
        journal.append(&entry("b", "old")).unwrap();
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 7]).unwrap();
        let earlier = Earlier::read(&path, &none).unwrap();
        assert_eq!((earlier.of("a").len(), earlier.of("b").len()), (1, 0));
        let mut journal = Journal::new(&path, &earlier);
        journal.append(&entry("a", "new")).unwrap();
        let earlier = Earlier::read(&path, &none).unwrap();
        let settings: Vec<&str> = earlier.of("a").iter().map(|entry| entry.settings_sha256.as_str()).collect();
        assert_eq!(settings, ["new", "old"], "the youngest first");
        assert!(std::fs::read(&path).unwrap().starts_with(&whole[..whole.len() / 2]));
    }

    #[test]
    fn a_journal_ends_with_what_is_kept_and_with_what_another_run_wrote() {
        let folder = tempfile::TempDir::new().unwrap();
        let (path, none) = (folder.path().join("journal"), folder.path().join("none"));
        let written = |items: &[&str], earlier: &Earlier| {
            let mut journal = Journal::new(&path, earlier);
            items.iter().for_each(|item| journal.append(&entry(item, "s")).unwrap());
            journal
        };
        // Known and own rows go.
        written(&["a"], &Earlier::default());
        let journal = written(&["b"], &Earlier::read(&path, &none).unwrap());
        assert_eq!(journal.finish(&[]).unwrap(), 0);
        assert!(!path.exists());
        // What is kept stays alone.
        assert_eq!(written(&["a", "b"], &Earlier::default()).finish(&[entry("b", "s")]).unwrap(), 0);
        let left = Earlier::read(&path, &none).unwrap();
        assert_eq!((left.of("a").len(), left.of("b").len()), (0, 1));
        // Two runs at once: the first to end leaves the rows of the other.
        let one = written(&["c"], &left);
        let other = written(&["d", "e"], &left);
        assert_eq!(one.finish(&[]).unwrap(), 2);
        assert_eq!(Earlier::read(&path, &none).unwrap().of("e").len(), 1);
        assert_eq!(other.finish(&[]).unwrap(), 1, "the row of the first is in no table that the second knows");
        assert!(Journal::new(&path, &Earlier::read(&path, &none).unwrap()).finish(&[]).is_ok() && !path.exists());
    }

    #[test]
    fn words_of_reports_are_those_of_the_journal() {
        for reports in Reports::ALL {
            assert_eq!(serde_json::to_value(reports).unwrap(), reports.word());
            assert_eq!(Reports::of(reports.word()), reports);
        }
    }
}
