//! The rows below the heading line: cells to readings.

use std::collections::HashMap;

use csv::StringRecord;

use super::angles::note_on_angles;
use super::cells::{DecimalMark, number};
use super::checks::{self, Seen};
use super::columns::{Given, Layout, Source};
use super::findings::{Collector, Column, Findings, Place, excerpt};
use super::kind::FindingKind;
use super::options::ReadOptions;
use super::{Dataset, Reading};
use crate::geometry::{Geometry, Polarization};
use crate::units::radians;

/// Name of the only record of a file that names none.
const UNNAMED: &str = "data";

/// The rows read so far.
#[derive(Debug)]
pub(super) struct Rows {
    layout: Layout,
    decimal_commas: bool,
    pub(super) found: Collector,
    readings: Vec<Reading>,
    /// Readings that are in the file, those with a defect included.
    attempted: usize,
    curves: HashMap<String, usize>,
    seen: Seen,
    /// First line with a decimal comma and with a decimal point; the second one found ends the search.
    marks: [Option<u64>; 2],
    sigma_filled: bool,
    sigma_gaps: Vec<u64>,
}

impl Rows {
    pub(super) fn new(layout: Layout, decimal_commas: bool, found: Collector) -> Self {
        Self {
            layout,
            decimal_commas,
            found,
            readings: Vec::new(),
            attempted: 0,
            curves: HashMap::new(),
            seen: Seen::default(),
            marks: [None; 2],
            sigma_filled: false,
            sigma_gaps: Vec::new(),
        }
    }

    pub(super) fn read(&mut self, line: u64, record: &StringRecord) {
        self.attempted += self.layout.intensities.len().max(1);
        if let Some(kind) = unusable(record, self.layout.headings.len(), self.decimal_commas) {
            return self.found.at_line(line, kind);
        }
        let row = Row { line, record };
        let wavelength = self.value(&row, self.layout.wavelength, checks::wavelength);
        let theta = self.value(&row, self.layout.theta, checks::angle_deg);
        let phi = self.value(&row, self.layout.phi, checks::angle_deg);
        let omega = self.value(&row, self.layout.omega, checks::angle_deg);
        let sigma = self.sigma(&row);
        let polarization = self.polarization(&row);
        let curve = self.curve(&row);
        let columns = self.layout.intensities.len();
        for index in 0..columns.max(usize::from(self.layout.plan)) {
            let column = self.layout.intensities.get(index).copied();
            let (intensity, given) = match column {
                Some((column, given)) => (self.value(&row, Source::Column(column), checks::finite), given),
                None => (Some(0.0), Given::Nothing),
            };
            let (mut theta, mut phi, mut curve) = (theta, phi, curve);
            match given {
                Given::Nothing => {}
                Given::Unclear => continue,
                Given::Theta(angle) => theta = Some(angle),
                Given::Phi(angle) => phi = Some(angle),
                Given::Curve(index) => curve = Some(index),
            }
            if let (Some(wavelength), Some(theta), Some(phi), Some(omega)) = (wavelength, theta, phi, omega)
                && let (Some(intensity), Some(sigma), Some(polarization), Some(curve)) =
                    (intensity, sigma, polarization, curve)
            {
                let geometry = Geometry { theta: radians(theta), phi: radians(phi), omega: radians(omega) };
                let reading = Reading { wavelength, geometry, polarization, intensity, sigma, curve, line };
                if let Some(first) = self.seen.first(&reading, Place::Line(line)) {
                    let column = column.filter(|_| columns > 1).map(|(column, _)| self.column(column));
                    self.found.push(Some(Place::Line(line)), column, FindingKind::DuplicateReading { first });
                }
                self.readings.push(reading);
            }
        }
    }

    fn column(&self, index: usize) -> Column {
        let number = self.layout.cut_from.filter(|_| index == 1).unwrap_or(index);
        Column::in_file(number, self.layout.headings.get(index).map_or("", String::as_str))
    }

    fn push(&mut self, line: u64, column: usize, kind: FindingKind) {
        let column = self.column(column);
        self.found.push(Some(Place::Line(line)), Some(column), kind);
    }

    /// `None` if there is no valid value; the finding is then made, here or with the heading line.
    fn value(&mut self, row: &Row<'_>, source: Source<f64>, check: fn(f64) -> Result<(), FindingKind>) -> Option<f64> {
        let column = match source {
            Source::Missing => return None,
            Source::Constant(value) => return Some(value),
            Source::Column(column) => column,
        };
        let cell = row.cell(column);
        match number(cell, self.decimal_commas) {
            Ok((value, mark)) => {
                if let Some(mark) = mark {
                    self.compare_mark(mark, row.line, column, cell);
                }
                match check(value) {
                    Ok(()) => return Some(value),
                    Err(kind) => self.push(row.line, column, kind),
                }
            }
            Err(kind) => self.push(row.line, column, kind),
        }
        None
    }

    /// In a file with both marks one of them may group thousands, and which is anybody's guess.
    fn compare_mark(&mut self, mark: DecimalMark, line: u64, column: usize, cell: &str) {
        let [comma, point] = &mut self.marks;
        let (own, other) = match mark {
            DecimalMark::Comma => (comma, *point),
            DecimalMark::Point => (point, *comma),
        };
        if own.is_none() {
            *own = Some(line);
            if let (Some(first_line), true) = (other, self.decimal_commas) {
                self.push(line, column, FindingKind::MixedDecimalMarks { found: excerpt(cell), first_line });
            }
        }
    }

    /// Outer `None` after a finding, inner `None` without a sigma.
    #[allow(clippy::option_option, reason = "the two absences differ: a bad sigma, and none")]
    fn sigma(&mut self, row: &Row<'_>) -> Option<Option<f64>> {
        match self.layout.sigma {
            Source::Missing => Some(None),
            Source::Column(column) if row.cell(column).is_empty() => {
                self.sigma_gaps.push(row.line);
                Some(None)
            }
            source => {
                self.sigma_filled = true;
                self.value(row, source, checks::sigma).map(Some)
            }
        }
    }

    fn polarization(&mut self, row: &Row<'_>) -> Option<Polarization> {
        let column = match self.layout.polarization {
            Source::Missing => return Some(Polarization::default()),
            Source::Constant(polarization) => return Some(polarization),
            Source::Column(column) => column,
        };
        let cell = row.cell(column);
        let kind = match cell.to_ascii_lowercase().as_str() {
            "s" => return Some(Polarization::S),
            "p" => return Some(Polarization::P),
            "unpolarized" | "unpolarised" => return Some(Polarization::Unpolarized),
            "" => FindingKind::EmptyCell,
            _ => FindingKind::UnknownPolarization { found: excerpt(cell) },
        };
        self.push(row.line, column, kind);
        None
    }

    /// Number of the record the row belongs to, by the first appearance of its name.
    fn curve(&mut self, row: &Row<'_>) -> Option<usize> {
        let Some(column) = self.layout.curve else { return Some(0) };
        let name = row.cell(column);
        let kind = if name.is_empty() { Err(FindingKind::EmptyCell) } else { checks::curve_name(name) };
        if let Err(kind) = kind {
            self.push(row.line, column, kind);
            return None;
        }
        if let Some(index) = self.curves.get(name) {
            return Some(*index);
        }
        let index = self.layout.curves.len();
        self.layout.curves.push(name.to_owned());
        self.curves.insert(name.to_owned(), index);
        Some(index)
    }

    /// All readings, if nothing was found.
    pub(super) fn finish(
        mut self,
        options: &ReadOptions,
        mut notes: Vec<String>,
        sha256: String,
    ) -> Result<Dataset, Findings> {
        if let Source::Column(column) = self.layout.sigma {
            if self.sigma_filled {
                for line in std::mem::take(&mut self.sigma_gaps) {
                    self.push(line, column, FindingKind::SigmaIncomplete);
                }
            } else if !self.sigma_gaps.is_empty() {
                notes.push(format!("{} is empty in every row and not used", self.column(column)));
            }
        }
        if self.attempted == 0 {
            self.found.on_file(FindingKind::NoReadings);
        } else if self.attempted < options.required_readings {
            let (readings, required) = (self.attempted, options.required_readings);
            self.found.on_file(FindingKind::TooFewReadings { readings, required });
        }
        self.found.finish()?;
        if self.marks[0].is_some() {
            notes.push("numbers have decimal commas".to_owned());
        }
        notes.extend(note_on_angles(&self.readings));
        let mut curves = self.layout.curves;
        if curves.is_empty() {
            curves.push(UNNAMED.to_owned());
        }
        Ok(Dataset::checked(self.readings, curves, notes, sha256))
    }
}

/// What is wrong with a row as a whole.
pub(super) fn unusable(record: &StringRecord, expected: usize, decimal_commas: bool) -> Option<FindingKind> {
    if record.iter().any(|cell| cell.contains('\n')) {
        return Some(FindingKind::LineBreakInCell);
    }
    if record.iter().all(|cell| cell.trim().is_empty()) {
        return Some(FindingKind::EmptyRow);
    }
    let found = record.len();
    let decimal_commas = !decimal_commas && found > expected;
    (found != expected).then_some(FindingKind::Ragged { found, expected, decimal_commas })
}

/// A row with as many cells as there are headings.
struct Row<'a> {
    line: u64,
    record: &'a StringRecord,
}

impl<'a> Row<'a> {
    fn cell(&self, index: usize) -> &'a str {
        self.record.get(index).unwrap_or_default().trim()
    }
}
