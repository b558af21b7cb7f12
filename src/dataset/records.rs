//! Records of the text, each with the physical line it starts at.
//!
//! The CSV reader's own position is where its search for a record began, before the comments and blank lines in
//! between; a message must name the line that the user sees.

use csv::{Reader, ReaderBuilder, StringRecord};

use super::findings::Collector;
use super::kind::FindingKind;

/// The records of the text with the lines they start at.
#[derive(Debug)]
pub(super) struct Records<'a> {
    reader: Reader<&'a [u8]>,
    pub(super) record: StringRecord,
    lines: Lines<'a>,
}

impl<'a> Records<'a> {
    pub(super) fn new(text: &'a str, delimiter: u8) -> Self {
        let reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        Self { reader, record: StringRecord::new(), lines: Lines::new(text) }
    }

    /// The line at which the record starts.
    pub(super) fn line(&self) -> u64 {
        self.lines.line
    }

    /// The record as it stands in the text, without its line end.
    pub(super) fn source(&self) -> &'a str {
        let end = usize::try_from(self.reader.position().byte()).unwrap_or(usize::MAX).min(self.lines.text.len());
        self.lines.text.get(self.lines.byte..end).unwrap_or_default().trim_end_matches(['\r', '\n'])
    }

    /// Comment lines passed so far.
    pub(super) fn comments(&self) -> u64 {
        self.lines.comments
    }

    /// Moves on to the next record that is not a blank line and gives the line it starts at.
    pub(super) fn next(&mut self, found: &mut Collector) -> Option<Line<'a>> {
        loop {
            let read = self.reader.read_record(&mut self.record);
            let start = self.record.position().map_or(0, csv::Position::byte);
            let line = self.lines.content_from(start, |line| {
                if let Some(error) = spreadsheet_error(line.content) {
                    let kind = FindingKind::SpreadsheetError { found: error.to_owned() };
                    found.at_line(line.number, kind);
                }
            });
            match (read, line) {
                (Ok(false), _) => return None,
                (Ok(true), Some(line)) if line.content.trim().is_empty() => {}
                (Ok(true), Some(line)) => return Some(line),
                _ => {
                    found.at_line(self.lines.line, FindingKind::Malformed);
                    return None;
                }
            }
        }
    }
}

/// A lost first cell makes its row look like a comment.
fn spreadsheet_error(line: &str) -> Option<&'static str> {
    const ERRORS: [&str; 8] = ["#N/A", "#DIV/0!", "#VALUE!", "#REF!", "#NAME?", "#NUM!", "#NULL!", "#SPILL!"];
    ERRORS.into_iter().find(|error| line.starts_with(error))
}

/// Walks through the text along with the CSV reader.
#[derive(Debug)]
struct Lines<'a> {
    text: &'a str,
    byte: usize,
    line: u64,
    comments: u64,
}

/// A line of the text without its line end.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) number: u64,
    pub(super) content: &'a str,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self { text, byte: 0, line: 1, comments: 0 }
    }

    /// The first line from `byte` on that is neither empty nor a comment. Comments on the way go to `comment`.
    fn content_from(&mut self, byte: u64, mut comment: impl FnMut(Line<'a>)) -> Option<Line<'a>> {
        let target = usize::try_from(byte).unwrap_or(usize::MAX).min(self.text.len());
        if let Some(passed) = self.text.as_bytes().get(self.byte..target) {
            self.line += passed.iter().filter(|byte| **byte == b'\n').count() as u64;
            self.byte = target;
        }
        loop {
            let rest = self.text.get(self.byte..).filter(|rest| !rest.is_empty())?;
            let length = rest.find('\n').map_or(rest.len(), |end| end + 1);
            let content = rest.get(..length)?.trim_end_matches(['\r', '\n']);
            let line = Line { number: self.line, content };
            if content.starts_with('#') {
                self.comments += 1;
                comment(line);
            } else if !content.is_empty() {
                return Some(line);
            }
            self.byte += length;
            self.line += 1;
        }
    }
}
