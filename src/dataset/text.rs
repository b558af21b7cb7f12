//! From bytes to text that can be split into cells, or the reason why not.

use super::findings::{Collector, Finding, Findings};
use super::kind::FindingKind;
use super::options::ReadOptions;

/// Checked text: UTF-8, no NUL, every line ended by a line feed, at least a heading line.
#[derive(Debug)]
pub(super) struct Text<'a> {
    pub(super) text: &'a str,
    pub(super) delimiter: u8,
    pub(super) notes: Vec<String>,
}

impl Text<'_> {
    /// A comma can be a decimal mark only where it does not separate cells.
    pub(super) fn decimal_commas(&self) -> bool {
        self.delimiter != b','
    }
}

pub(super) fn open<'a>(bytes: &'a [u8], options: &ReadOptions) -> Result<Text<'a>, Findings> {
    let fail = |kind| Err(Collector::default().fail(Finding::on_file(kind)));
    let size = bytes.len() as u64;
    if size > options.max_bytes {
        return fail(FindingKind::TooLarge { bytes: size, max_bytes: options.max_bytes });
    }
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return fail(FindingKind::Utf16);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return fail(FindingKind::Workbook);
    }
    let whole = clean(bytes)?;
    let text = whole.trim_start_matches('\u{FEFF}');
    if text.trim().is_empty() {
        return fail(FindingKind::Empty);
    }
    let Some(heading) = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')) else {
        return fail(FindingKind::OnlyComments);
    };
    let delimiter = delimiter(heading);
    let mut notes = Vec::new();
    if text.len() < whole.len() {
        notes.push("the file starts with a byte order mark".to_owned());
    }
    if text.contains("\r\n") {
        notes.push("lines end in CRLF".to_owned());
    }
    match delimiter {
        b';' => notes.push("semicolons separate the columns".to_owned()),
        b'\t' => notes.push("tabs separate the columns".to_owned()),
        _ => {}
    }
    Ok(Text { text, delimiter, notes })
}

/// Text without bytes that a CSV file cannot have; otherwise a finding for each line and sort of defect.
fn clean(bytes: &[u8]) -> Result<&str, Findings> {
    let mut found = Collector::default();
    let mut offset = 0_u64;
    for (line, bytes) in (1..).zip(bytes.split_inclusive(|byte| *byte == b'\n')) {
        let byte = |index: usize| offset + index as u64 + 1;
        if let Some(index) = bytes.iter().position(|byte| *byte == 0) {
            found.at_line(line, FindingKind::NulByte { byte: byte(index) });
        }
        if let Err(error) = std::str::from_utf8(bytes) {
            let index = error.valid_up_to();
            let value = bytes.get(index).copied().unwrap_or_default();
            found.at_line(line, FindingKind::NotUtf8 { byte: byte(index), value });
        }
        if bytes.strip_suffix(b"\r\n").unwrap_or(bytes).contains(&b'\r') {
            found.at_line(line, FindingKind::LoneCarriageReturn);
        }
        offset += bytes.len() as u64;
    }
    found.finish()?;
    // Cannot fail here: a line feed is never part of a longer character, so that good lines make a good text.
    std::str::from_utf8(bytes).map_err(|error| {
        let (byte, value) = (error.valid_up_to() as u64 + 1, 0);
        Collector::default().fail(Finding::on_file(FindingKind::NotUtf8 { byte, value }))
    })
}

/// Semicolons before tabs before commas: a heading line with decimal commas has commas as well.
fn delimiter(heading: &str) -> u8 {
    let mut quoted = false;
    let mut best = b',';
    for byte in heading.bytes() {
        match byte {
            b'"' => quoted = !quoted,
            b';' if !quoted => return b';',
            b'\t' if !quoted => best = b'\t',
            _ => {}
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_heading_line_decides_what_separates_cells() {
        assert_eq!(delimiter("wavelength_nm;30,5;45"), b';');
        assert_eq!(delimiter("wavelength_nm\t30,5"), b'\t');
        assert_eq!(delimiter("wavelength_nm,\"a;b\""), b',');
    }
}
