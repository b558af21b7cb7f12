//! Refractive indices from CSV files: `wavelength_nm, n[, k]`, or other columns of a table with several media.

use crate::exit::{BadData, Usage};
use crate::output;
use crate::values::{Index, nearest};
use anyhow::Result;
use csv::{ReaderBuilder, StringRecord, Trim};
use morpho_fit::optics::{IndexTable, Material, OpticsError};
use std::path::Path;

/// Defects of a table that are told; the rest is counted.
const SHOWN: usize = 20;
/// Tables in micrometres end below this, tables in nanometres begin above it.
const MICROMETRES: f64 = 20.0;

/// The material that an index on the command line stands for; `flag` names it in messages.
pub(crate) fn material(index: &Index, flag: &str) -> Result<Material> {
    match index {
        Index::Known(material) => Ok(material.clone()),
        Index::Table { path, n, k } => {
            if !path.exists() {
                let path = path.display();
                return Err(Usage(format!(
                    "{flag}: `{path}` is neither an index (1.56, 1.56+0.06i, cauchy:A,B) nor a file that exists"
                ))
                .into());
            }
            let bytes = output::read(path)?;
            table(&bytes, path, n.as_deref(), k.as_deref()).map(Material::Table)
        }
    }
}

fn table(bytes: &[u8], path: &Path, n: Option<&str>, k: Option<&str>) -> Result<IndexTable> {
    let file = path.display();
    let bad = |problem: String| BadData(format!("{file}:{problem}"));
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let delimiter = if first_line(bytes).contains(&b';') { b';' } else { b',' };
    let mut reader =
        ReaderBuilder::new().comment(Some(b'#')).delimiter(delimiter).flexible(true).trim(Trim::All).from_reader(bytes);
    let headings = reader.headers().map_err(|error| bad(format!(" {error}")))?.clone();
    let column = |name: &str| headings.iter().position(|heading| heading == name);
    let required = |name: &str| {
        column(name).ok_or_else(|| {
            let names: Vec<&str> = headings.iter().collect();
            let meant = nearest(name, &names).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
            bad(format!("1: column `{name}` is missing; there are {}{meant}", names.join(", ")))
        })
    };
    let columns = (
        required("wavelength_nm")?,
        required(n.unwrap_or("n"))?,
        match (n, k) {
            (_, Some(k)) => Some(required(k)?),
            (None, None) => column("k"),
            (Some(_), None) => None,
        },
    );
    let mut defects = Vec::new();
    let mut rows: Vec<([f64; 3], u64)> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| bad(format!(" {error}")))?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut cell =
            |index: usize| number(&record, index, &headings, line).map_err(|defect| defects.push(defect)).ok();
        let values = [cell(columns.0), cell(columns.1), columns.2.map_or(Some(0.0), &mut cell)];
        if let [Some(wavelength), Some(n), Some(k)] = values {
            rows.push(([wavelength, n, k], line));
        }
    }
    if !defects.is_empty() {
        let more = defects.len().saturating_sub(SHOWN);
        let mut lines: Vec<String> = defects.iter().take(SHOWN).map(|defect| format!("{file}:{defect}")).collect();
        lines.extend((more > 0).then(|| format!("and {more} more")));
        return Err(BadData(lines.join("\n")).into());
    }
    if !rows.is_empty() && rows.iter().all(|([wavelength, ..], _)| *wavelength <= MICROMETRES) {
        return Err(bad(" `wavelength_nm` looks like micrometres; give nanometres".to_owned()).into());
    }
    // Some tables run from long to short waves.
    rows.sort_by(|([left, ..], _), ([right, ..], _)| left.total_cmp(right));
    let found = IndexTable::new(rows.iter().map(|(values, _)| *values).collect());
    found.map_err(|error| match error {
        OpticsError::BadTable { problem, row } => {
            let line = row.checked_sub(1).and_then(|row| rows.get(row)).map_or(1, |(_, line)| *line);
            bad(format!("{line}: the table has {problem}")).into()
        }
        other => other.into(),
    })
}

fn first_line(bytes: &[u8]) -> &[u8] {
    let mut lines = bytes.split(|byte| *byte == b'\n');
    lines.find(|line| !line.starts_with(b"#") && !line.trim_ascii().is_empty()).unwrap_or_default()
}

fn number(record: &StringRecord, index: usize, headings: &StringRecord, line: u64) -> Result<f64, String> {
    let name = headings.get(index).unwrap_or_default();
    let place = format!("{line}: column {} `{name}`", index + 1);
    match record.get(index).unwrap_or_default() {
        "" => Err(format!("{place}: the cell is empty; every row needs a value")),
        text => match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => Err(format!("{place}: `{text}` is not finite")),
            Err(_) => Err(format!("{place}: `{text}` is not a number; write it like 0.25 or 2.5e-1")),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, n: Option<&str>, k: Option<&str>) -> Result<Vec<[f64; 3]>, String> {
        table(text.as_bytes(), Path::new("nk.csv"), n, k)
            .map(|table| table.rows().to_vec())
            .map_err(|error| error.to_string())
    }

    #[test]
    fn columns_are_found_by_name() {
        let csv = "# source\nwavelength_nm,n_film,k_film,n\n500,2.0,0.1,1.5\n400,2.1,0.2,1.6\n";
        assert_eq!(read(csv, None, None), Ok(vec![[400.0, 1.6, 0.0], [500.0, 1.5, 0.0]]));
        let film = Ok(vec![[400.0, 2.1, 0.2], [500.0, 2.0, 0.1]]);
        assert_eq!(read(csv, Some("n_film"), Some("k_film")), film);
        let missing = read(csv, Some("n_flim"), None).unwrap_err();
        assert!(missing.starts_with("nk.csv:1: column `n_flim` is missing"), "{missing}");
        assert!(missing.ends_with("did you mean `n_film`?"), "{missing}");
    }

    #[test]
    fn every_defect_of_a_table_has_its_place() {
        assert_eq!(
            read("wavelength_nm,n\n400,x\n500,\n", None, None).unwrap_err(),
            "nk.csv:2: column 2 `n`: `x` is not a number; write it like 0.25 or 2.5e-1\n\
             nk.csv:3: column 2 `n`: the cell is empty; every row needs a value"
        );
        assert!(read("wavelength_nm,n\n0.4,1.5\n", None, None).unwrap_err().contains("micrometres"));
        let twice = read("wavelength_nm,n\n400,1.5\n500,1.4\n400,1.5\n", None, None).unwrap_err();
        assert!(twice.starts_with("nk.csv:4: the table has a wavelength"), "{twice}");
    }
}
