//! What a batch that was stopped has done: a line of JSON for each item, appended as it is done.

use anyhow::{Context, Result};
use morpho_fit::export::{Batch, BatchRow};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
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
pub(crate) struct Earlier(HashMap<String, Vec<Entry>>);

impl Earlier {
    /// Everything that can be read; a line that was cut off, or is no line of ours, is left out.
    pub(crate) fn read(journal: &Path, finished: &Path) -> Result<Self> {
        let mut rows: HashMap<String, Vec<Entry>> = HashMap::new();
        let text = bytes(journal)?;
        let lines = text.split_inclusive(|byte| *byte == b'\n').rev().filter(|line| line.ends_with(b"\n"));
        for entry in lines.filter_map(|line| serde_json::from_slice::<Entry>(line).ok()) {
            rows.entry(entry.row.item.clone()).or_default().push(entry);
        }
        if let Ok(batch) = serde_json::from_slice::<Batch>(&bytes(finished)?) {
            let reports = Reports::of(&batch.reports);
            for row in batch.items {
                let settings_sha256 = batch.settings_sha256.clone();
                rows.entry(row.item.clone()).or_default().push(Entry { settings_sha256, reports, row });
            }
        }
        Ok(Self(rows))
    }

    /// The rows of an item, the youngest first.
    pub(crate) fn of(&self, item: &str) -> &[Entry] {
        self.0.get(item).map_or(&[], Vec::as_slice)
    }
}

fn bytes(path: &Path) -> Result<Vec<u8>> {
    match std::fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        other => other.with_context(|| format!("{} cannot be read", path.display())),
    }
}

/// A journal that is written to.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    synced: Instant,
}

impl Journal {
    /// Opens the journal behind its last whole line.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let unwritable = || format!("{} cannot be written", path.display());
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = file.with_context(unwritable)?;
        let mut text = Vec::new();
        file.read_to_end(&mut text).with_context(unwritable)?;
        let whole = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1) as u64;
        file.set_len(whole).and_then(|()| file.seek(SeekFrom::Start(whole))).with_context(unwritable)?;
        Ok(Self { path: path.to_owned(), file, synced: Instant::now() })
    }

    /// Appends a line; whoever ends this program from now on leaves it there.
    pub(crate) fn append(&mut self, entry: &Entry) -> Result<()> {
        let mut line = serde_json::to_vec(entry)?;
        line.push(b'\n');
        let mut written = self.file.write_all(&line);
        if self.synced.elapsed() > BETWEEN_SYNCS {
            written = written.and_then(|()| self.file.sync_data());
            self.synced = Instant::now();
        }
        written.with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(item: &str, settings: &str) -> Entry {
        let row = BatchRow { item: item.to_owned(), place: None, sha256: None, fit: None, error: None };
        Entry { settings_sha256: settings.to_owned(), reports: Reports::None, row }
    }

    #[test]
    fn a_line_that_was_cut_off_is_dropped_and_written_over() {
        let folder = tempfile::TempDir::new().unwrap();
        let (path, none) = (folder.path().join("journal"), folder.path().join("none"));
        let mut journal = Journal::open(&path).unwrap();
        journal.append(&entry("a", "old")).unwrap();
        journal.append(&entry("b", "old")).unwrap();
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() - 7]).unwrap();
        let earlier = Earlier::read(&path, &none).unwrap();
        assert_eq!((earlier.of("a").len(), earlier.of("b").len()), (1, 0));
        let mut journal = Journal::open(&path).unwrap();
        journal.append(&entry("a", "new")).unwrap();
        let earlier = Earlier::read(&path, &none).unwrap();
        let settings: Vec<&str> = earlier.of("a").iter().map(|entry| entry.settings_sha256.as_str()).collect();
        assert_eq!(settings, ["new", "old"], "the youngest first");
        assert!(std::fs::read(&path).unwrap().starts_with(&whole[..whole.len() / 2]));
    }

    #[test]
    fn words_of_reports_are_those_of_the_journal() {
        for reports in Reports::ALL {
            assert_eq!(serde_json::to_value(reports).unwrap(), reports.word());
            assert_eq!(Reports::of(reports.word()), reports);
        }
    }
}
