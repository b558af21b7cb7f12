//! The sheets of `morpho-fit tradeoff` as CSV.

use super::ExportError;
use super::curves::number;
use crate::tradeoff::{Map, Sheet};

/// What was measured in one study, a point or a cell a row, after a comment that says where.
///
/// - `about`: machine and version, one line.
///
/// Points: `diagram, method, setting, x_quantity, x, y_quantity, y`. Cells of the stability map: `map, input, expected, form,
/// guarded, found`.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn tradeoff_csv(sheet: &Sheet, about: &str) -> Result<Vec<u8>, ExportError> {
    let about: String = about.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
    let mut writer = csv::Writer::from_writer(format!("# {about}\n").into_bytes());
    if !sheet.diagrams.is_empty() {
        writer.write_record(["diagram", "method", "setting", "x_quantity", "x", "y_quantity", "y"])?;
    }
    for diagram in &sheet.diagrams {
        for series in &diagram.series {
            for point in &series.points {
                let (x, y) = (number(point.x), number(point.y));
                let [title, x_label, y_label] = [&diagram.title, &diagram.x_label, &diagram.y_label];
                writer.write_record([title, &series.method, &point.setting, x_label, &x, y_label, &y])?;
            }
        }
    }
    if !sheet.maps.is_empty() {
        writer.write_record(["map", "input", "expected", "form", "guarded", "found"])?;
    }
    sheet.maps.iter().try_for_each(|map| cells(&mut writer, map))?;
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}

fn cells(writer: &mut csv::Writer<Vec<u8>>, map: &Map) -> Result<(), ExportError> {
    for row in &map.rows {
        for (form, found) in map.forms.iter().zip(&row.cells) {
            let guarded = form.guarded.to_string();
            writer.write_record([&map.title, &row.input, &row.expected, &form.name, &guarded, found.word()])?;
        }
    }
    Ok(())
}
