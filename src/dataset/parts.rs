//! A file with several measurements in it, such as the pixels of a map: its rows told apart by a column.

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use csv::{ReaderBuilder, StringRecord};

use super::Dataset;
use super::cells::{number, plain};
use super::checks::{curve_name, hex_sha256};
use super::columns::{Given, Layout, Quantity, Source};
use super::findings::{Collector, Column, Finding, Findings, Place, excerpt};
use super::kind::FindingKind;
use super::options::{ReadOptions, WideHeading};
use super::read::{check_constants, heading_line};
use super::records::Records;
use super::rows::{Rows, unusable};
use super::text::{self, Text};

/// Headings that a message lists.
const LISTED: usize = 20;

/// What tells the rows of a file apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SplitBy {
    /// Each text of this column is a part. `curve` is the column of that name, or the headings of a table that is
    /// [`WideHeading::Curve`].
    Column(String),
    /// Each pair of numbers of these columns is a part: the pixels of a map.
    Place([String; 2]),
}

impl SplitBy {
    fn columns(&self) -> &[String] {
        match self {
            Self::Column(name) => std::slice::from_ref(name),
            Self::Place(names) => names,
        }
    }
}

/// One measurement of several in a file, not yet read.
#[derive(Debug, Clone)]
pub struct Part {
    name: String,
    place: Option<[f64; 2]>,
    /// Its rows, each ended by a line feed.
    rows: String,
    /// Their lines in the file.
    lines: Vec<u64>,
    /// Record whose column it is, in a wide table of records.
    record: Option<usize>,
    sha256: String,
    shared: Arc<Shared>,
}

/// A part while its rows are gathered.
#[derive(Debug, Default)]
struct Rough {
    name: String,
    place: Option<[f64; 2]>,
    rows: String,
    lines: Vec<u64>,
}

/// What the parts of a file have in common.
#[derive(Debug)]
struct Shared {
    layout: Layout,
    delimiter: u8,
    options: ReadOptions,
    notes: Vec<String>,
}

/// Splits a CSV file into the measurements that are in it, in the order in which they begin.
///
/// A part is read by itself with [`Part::read`], so that a defect spoils one part and not the others. The columns of
/// `by` are not read as data, but for `curve`. The file is gone through once; parts hold their rows as text.
///
/// # Errors
/// [`Findings`] if the heading line cannot be used, a column of `by` is missing or holds data, a row cannot belong to
/// a part (it has too few or too many cells, or its cell of `by` is empty or no number where it must be one), or no
/// row is there.
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, SplitBy, split_csv};
///
/// let csv = b"pixel,wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n\
///             a,450,0,30,90,0.42\n\
///             b,450,0,30,90,x\n\
///             a,460,0,30,90,0.47\n";
/// let parts = split_csv(csv, &ReadOptions::default(), &SplitBy::Column("pixel".to_owned()))?;
/// assert_eq!((parts.len(), parts[0].name()), (2, "a"));
/// assert_eq!(parts[0].read()?.readings()[1].line, 4);
/// let findings = parts[1].read().unwrap_err();
/// assert_eq!(findings.as_slice()[0].line(), Some(3));
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
pub fn split_csv(bytes: &[u8], options: &ReadOptions, by: &SplitBy) -> Result<Vec<Part>, Findings> {
    let source = text::open(bytes, options)?;
    let mut found = Collector::default();
    check_constants(&options.constants, &mut found);
    let mut records = Records::new(source.text, source.delimiter);
    let apart: Vec<String> = by.columns().iter().filter(|name| data_of(name).is_none()).cloned().collect();
    if options.wide.is_some() {
        known_columns(&source, by)?;
    }
    let (mut layout, notes) = match heading_line(&mut records, &apart, options, &source, &mut found) {
        Ok(read) => read,
        Err(finding) => return Err(found.fail(finding)),
    };
    let notes = [source.notes.clone(), notes].concat();
    let heading = format!("{}\n", records.source());
    let line = records.line();
    let curve = Quantity::Curve.name();
    let of_records = options.wide == Some(WideHeading::Curve);
    if of_records && by.columns() == [curve] && layout.headings.iter().all(|heading| heading != curve) {
        return by_record(records, layout, &source, options, notes, found);
    }
    let columns: Vec<Option<usize>> =
        by.columns().iter().map(|name| column(&layout.headings, name, line, &mut found)).collect();
    // Defects of the heading line are those of every part: without this, each row would be told besides.
    found.finish()?;
    let mut found = Collector::default();
    if by.columns() == [curve] && !of_records {
        layout.curve = columns.first().copied().flatten();
    }
    let columns: Vec<usize> = columns.into_iter().flatten().collect();
    let mut parts: Vec<Rough> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    let decimal_commas = source.decimal_commas();
    while let Some(line) = records.next(&mut found) {
        if let Some(kind) = unusable(&records.record, layout.headings.len(), decimal_commas) {
            found.at_line(line.number, kind);
            continue;
        }
        let cell =
            |index: usize| columns.get(index).and_then(|&column| records.record.get(column)).unwrap_or("").trim();
        let told = match by {
            SplitBy::Column(_) if cell(0).is_empty() => Err((0, FindingKind::EmptyCell)),
            SplitBy::Column(_) => curve_name(cell(0)).map(|()| None).map_err(|kind| (0, kind)),
            SplitBy::Place(_) => place([cell(0), cell(1)], decimal_commas).map(Some),
        };
        let place = match told {
            Ok(place) => place,
            Err((index, kind)) => {
                let column = columns.get(index).copied().unwrap_or_default();
                let name = layout.headings.get(column).map_or("", String::as_str);
                found.push(Some(Place::Line(line.number)), Some(Column::in_file(column, name)), kind);
                continue;
            }
        };
        let pair = place.map(|[x, y]| format!("{},{}", plain(x), plain(y)));
        let name = pair.as_deref().unwrap_or_else(|| cell(0));
        let index = match known.get(name) {
            Some(index) => *index,
            None => {
                known.insert(name.to_owned(), parts.len());
                parts.push(Rough { name: name.to_owned(), place, ..Rough::default() });
                parts.len() - 1
            }
        };
        if let Some(Rough { rows, lines, .. }) = parts.get_mut(index) {
            rows.push_str(records.source());
            rows.push('\n');
            lines.push(line.number);
        }
    }
    found.finish()?;
    if parts.is_empty() {
        return Err(Collector::default().fail(Finding::on_file(FindingKind::NoReadings)));
    }
    let shared = Arc::new(Shared { layout, delimiter: source.delimiter, options: *options, notes });
    let part = |Rough { name, place, rows, lines }: Rough| {
        let sha256 = hex_sha256(&[heading.as_bytes(), rows.as_bytes()].concat());
        Part { name, place, rows, lines, record: None, sha256, shared: Arc::clone(&shared) }
    };
    Ok(parts.into_iter().map(part).collect())
}

/// An error if a column is missing: other headings of a wide table would be told as what they are not.
fn known_columns(source: &Text<'_>, by: &SplitBy) -> Result<(), Findings> {
    let mut records = Records::new(source.text, source.delimiter);
    let Some(line) = records.next(&mut Collector::default()) else { return Ok(()) };
    let headings: Vec<String> = records.record.iter().map(|cell| cell.trim().to_owned()).collect();
    let mut found = Collector::default();
    for name in by.columns().iter().filter(|name| *name != Quantity::Curve.name() && !headings.contains(name)) {
        column(&headings, name, line.number, &mut found);
    }
    found.finish()
}

/// The column of a heading that is there once and holds no data.
fn column(headings: &[String], name: &str, line: u64, found: &mut Collector) -> Option<usize> {
    let mut places = (0..headings.len()).filter(|&index| headings.get(index).is_some_and(|heading| heading == name));
    let Some(first) = places.next() else {
        let mut there: Vec<String> = headings.iter().take(LISTED).map(|heading| excerpt(heading)).collect();
        if headings.len() > LISTED {
            there.push("…".to_owned());
        }
        found.at_line(line, FindingKind::NoSuchColumn { name: excerpt(name), there: there.join(", ") });
        return None;
    };
    if let Some(second) = places.next() {
        let kind = FindingKind::DuplicateColumn { first: first + 1 };
        found.push(Some(Place::Line(line)), Some(Column::in_file(second, name)), kind);
    }
    if let Some(name) = data_of(name) {
        found.push(Some(Place::Line(line)), Some(Column::in_file(first, name)), FindingKind::HoldsData { name });
    }
    Some(first)
}

/// The heading as that of a column of data, but for the name of the record.
fn data_of(heading: &str) -> Option<&'static str> {
    let data = Quantity::ALL.into_iter().filter(|quantity| *quantity != Quantity::Curve);
    data.map(Quantity::name).find(|name| *name == heading)
}

/// Two numbers; adding 0 turns -0 into 0.
fn place(cells: [&str; 2], decimal_commas: bool) -> Result<[f64; 2], (usize, FindingKind)> {
    let [x, y] = cells.map(|cell| number(cell, decimal_commas).map(|(value, _)| value + 0.0));
    Ok([x.map_err(|kind| (0, kind))?, y.map_err(|kind| (1, kind))?])
}

/// The columns of a wide table of records, each with the wavelengths.
fn by_record(
    mut records: Records<'_>,
    layout: Layout,
    source: &Text<'_>,
    options: &ReadOptions,
    notes: Vec<String>,
    found: Collector,
) -> Result<Vec<Part>, Findings> {
    found.finish()?;
    let mut found = Collector::default();
    let wavelength = match layout.wavelength {
        Source::Column(column) => column,
        _ => 0,
    };
    let separator = char::from(source.delimiter);
    let named = |&(column, given): &(usize, Given)| match given {
        Given::Curve(record) => Some((record, column)),
        _ => None,
    };
    let named: Vec<(usize, usize)> = layout.intensities.iter().filter_map(named).collect();
    let mut texts = vec![String::new(); named.len()];
    let mut lines = Vec::new();
    while let Some(line) = records.next(&mut found) {
        if let Some(kind) = unusable(&records.record, layout.headings.len(), source.decimal_commas()) {
            found.at_line(line.number, kind);
            continue;
        }
        lines.push(line.number);
        let cell = |column: usize| quoted(records.record.get(column).unwrap_or_default().trim(), separator);
        let first = cell(wavelength);
        for (text, (_, column)) in texts.iter_mut().zip(&named) {
            text.extend([&first, separator.encode_utf8(&mut [0; 4]) as &str, &cell(*column), "\n"]);
        }
    }
    found.finish()?;
    if lines.is_empty() {
        return Err(Collector::default().fail(Finding::on_file(FindingKind::NoReadings)));
    }
    let shared = Arc::new(Shared { layout, delimiter: source.delimiter, options: *options, notes });
    let part = |((record, _), rows): (&(usize, usize), String)| {
        let name = shared.layout.curves.get(*record).cloned().unwrap_or_default();
        let heading = format!("{}{separator}{}\n", Quantity::Wavelength.name(), quoted(&name, separator));
        let sha256 = hex_sha256(&[heading.as_bytes(), rows.as_bytes()].concat());
        let (lines, shared) = (lines.clone(), Arc::clone(&shared));
        Part { name, place: None, rows, lines, record: Some(*record), sha256, shared }
    };
    Ok(named.iter().zip(texts).map(part).collect())
}

/// The cell as it can stand in a row.
fn quoted(cell: &str, separator: char) -> String {
    if cell.contains([separator, '"']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

impl Part {
    /// The text of its cells in the column, or both numbers with a comma between them.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it lies in the map; none unless the file was split by [`SplitBy::Place`].
    #[must_use]
    pub fn place(&self) -> Option<[f64; 2]> {
        self.place
    }

    /// SHA-256 of the heading line and the rows of the part, each ended by a line feed: of the file that would hold
    /// this part alone. For a column of a wide table, of the wavelengths and that column.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Reads the rows of the part, as [`read_csv`](super::read_csv) reads a file.
    ///
    /// # Errors
    /// [`Findings`]: everything that is wrong with the part, by line and column of the whole file.
    pub fn read(&self) -> Result<Dataset, Findings> {
        let Shared { layout, delimiter, options, notes } = self.shared.as_ref();
        let layout = self.record.and_then(|record| of_record(layout, record)).unwrap_or_else(|| layout.clone());
        let mut rows = Rows::new(layout, *delimiter != b',', Collector::default());
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(*delimiter)
            .from_reader(self.rows.as_bytes());
        let mut record = StringRecord::new();
        for &line in &self.lines {
            // What the whole file's reader could split into cells, this one can.
            if !matches!(reader.read_record(&mut record), Ok(true)) {
                return Err(Collector::default().fail(Finding::at_line(line, FindingKind::Malformed)));
            }
            rows.read(line, &record);
        }
        rows.finish(options, notes.clone(), self.sha256.clone())
    }
}

/// The layout of the wavelengths and one column of a wide table.
fn of_record(whole: &Layout, record: usize) -> Option<Layout> {
    let (column, _) = whole.intensities.iter().find(|(_, given)| *given == Given::Curve(record))?;
    let name = whole.curves.get(record)?.clone();
    Some(Layout {
        headings: vec![Quantity::Wavelength.name().to_owned(), name.clone()],
        wavelength: Source::Column(0),
        intensities: vec![(1, Given::Curve(0))],
        curves: vec![name],
        plan: false,
        cut_from: Some(*column),
        theta: whole.theta,
        phi: whole.phi,
        omega: whole.omega,
        sigma: whole.sigma,
        polarization: whole.polarization,
        curve: None,
    })
}
