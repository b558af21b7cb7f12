//! CSV bytes to a dataset.

use super::Dataset;
use super::cells::plain;
use super::checks::{self, hex_sha256};
use super::columns::{Given, Layout, Quantity};
use super::findings::{Collector, Column, Finding, Findings, excerpt};
use super::kind::FindingKind;
use super::options::{Constants, ReadOptions, WideHeading};
use super::records::Records;
use super::rows::Rows;
use super::text::{self, Text};
use super::wide;

/// Reads a CSV file, tidy or wide; the [module page](super) has its columns.
///
/// # Errors
/// [`Findings`]: everything that is wrong with the file, by line and column. A file that is not text or has no
/// heading line gives that one finding; the rows of any other file are all checked.
///
/// ```
/// use morpho_fit::dataset::{Constants, ReadOptions, read_csv};
///
/// let constants = Constants { theta_deg: Some(0.0), phi_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() };
/// let options = ReadOptions { constants, ..ReadOptions::default() };
/// let dataset = read_csv(b"wavelength_nm;intensity;sigma\n450,5;0,42;0,01\n", &options)?;
/// assert_eq!(dataset.readings()[0].wavelength, 450.5);
/// assert_eq!(dataset.notes(), ["semicolons separate the columns", "numbers have decimal commas"]);
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
pub fn read_csv(bytes: &[u8], options: &ReadOptions) -> Result<Dataset, Findings> {
    let mut source = text::open(bytes, options)?;
    let mut found = Collector::default();
    check_constants(&options.constants, &mut found);
    let mut records = Records::new(source.text, source.delimiter);
    let layout = match heading_line(&mut records, &[], options, &source, &mut found) {
        Ok((layout, notes)) => {
            source.notes.extend(notes);
            layout
        }
        Err(finding) => return Err(found.fail(finding)),
    };
    let mut rows = Rows::new(layout, source.decimal_commas(), found);
    while let Some(line) = records.next(&mut rows.found) {
        rows.read(line.number, &records.record);
    }
    let mut notes = source.notes;
    match records.comments() {
        0 => {}
        1 => notes.push("1 line starts with # and is a comment".to_owned()),
        count => notes.push(format!("{count} lines start with # and are comments")),
    }
    rows.finish(options, notes, hex_sha256(bytes))
}

/// Checks the names of the columns of a table that is no file, as [`read_csv`] checks a heading line: notes on what is not used.
///
/// # Errors
/// [`Findings`] for a column that is missing, given twice or misspelt; the line is 1.
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, check_headings};
/// let headings = ["wavelength_nm", "theta_deg", "phi_deg", "omega_deg", "intensity", "operator"].map(str::to_owned);
/// let notes = check_headings(headings.to_vec(), &ReadOptions::default())?;
/// assert_eq!(notes, ["column 6 `operator` is not used"]);
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
pub fn check_headings(headings: Vec<String>, options: &ReadOptions) -> Result<Vec<String>, Findings> {
    let (mut found, mut notes) = (Collector::default(), Vec::new());
    check_constants(&options.constants, &mut found);
    if let Err(last) = Layout::tidy(headings, &[], 1, options, &mut found, &mut notes) {
        return Err(found.fail(last));
    }
    found.finish().map(|()| notes)
}

pub(super) fn check_constants(constants: &Constants, found: &mut Collector) {
    let values = [
        (Quantity::Wavelength, constants.wavelength_nm.map(checks::wavelength)),
        (Quantity::Theta, constants.theta_deg.map(checks::angle_deg)),
        (Quantity::Phi, constants.phi_deg.map(checks::angle_deg)),
        (Quantity::Omega, constants.omega_deg.map(checks::angle_deg)),
        (Quantity::Sigma, constants.sigma.map(checks::sigma)),
    ];
    for (quantity, result) in values {
        if let Some(Err(kind)) = result {
            found.push(None, quantity.flag_name().map(Column::named), kind);
        }
    }
}

/// Takes the first record for the headings; columns with a heading that is `apart` are not read.
pub(super) fn heading_line(
    records: &mut Records<'_>,
    apart: &[String],
    options: &ReadOptions,
    source: &Text<'_>,
    found: &mut Collector,
) -> Result<(Layout, Vec<String>), Finding> {
    let Some(line) = records.next(found) else { return Err(Finding::on_file(FindingKind::OnlyComments)) };
    let at_line = |kind| Err(Finding::at_line(line.number, kind));
    if records.record.iter().any(|cell| cell.contains('\n')) {
        return at_line(FindingKind::LineBreakInCell);
    }
    if line.content.starts_with("sep=") {
        return at_line(FindingKind::SeparatorLine { found: excerpt(line.content) });
    }
    let headings: Vec<String> = records.record.iter().map(|cell| cell.trim().to_owned()).collect();
    if let [only] = headings.as_slice()
        && only.split_whitespace().count() > 1
    {
        return at_line(FindingKind::SpaceSeparated);
    }
    let mut notes = Vec::new();
    let apart: Vec<usize> = (0..headings.len()).filter(|&index| apart.contains(&headings[index])).collect();
    let layout = match options.wide {
        None => Layout::tidy(headings, &apart, line.number, options, found, &mut notes)?,
        Some(kind) => {
            let layout = wide::layout(headings, kind, &apart, line.number, options, source.decimal_commas(), found)?;
            notes.push(wide_note(kind, &layout));
            layout
        }
    };
    Ok((layout, notes))
}

fn wide_note(kind: WideHeading, layout: &Layout) -> String {
    let angles = layout.intensities.iter().filter_map(|(_, given)| match given {
        Given::Theta(angle) | Given::Phi(angle) => Some(*angle),
        _ => None,
    });
    let count = layout.intensities.len();
    if kind == WideHeading::Curve {
        return format!("wide table with {count} columns for as many records");
    }
    let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let (name, low, high) = (kind.quantity(), plain(low), plain(high));
    format!("wide table with {count} columns for {name} from {low} to {high} degrees")
}
