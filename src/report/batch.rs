//! Many fits in words: how they ended, and the thicknesses of the first of them as a table.

use super::digits::{plain, with_sigma};
use super::rows::NONE;
use super::table::{Align, Table};
use crate::export::{Batch, BatchCounts, BatchRow, BatchValue};
use crate::inversion::{Status, Verdict};

/// Items in the table.
const SHOWN: usize = 24;
/// Letters of a name in it.
const NAME: usize = 24;
/// Quantities in it.
const QUANTITIES: [&str; 4] = ["d_air", "d_cuticle", "period", "lamella_width"];

/// How many items ended how, in one line without a full stop.
///
/// ```
/// use morpho_fit::{export::BatchCounts, report::batch::summary};
/// let counts = BatchCounts { items: 3, determined: 2, errors: 1, missed: 1, ..BatchCounts::default() };
/// assert_eq!(summary(&counts), "3 items: 2 determined, 1 with an error; the model misses the data of 1");
/// ```
#[must_use]
pub fn summary(counts: &BatchCounts) -> String {
    let parts = [
        (counts.determined, "determined"),
        (counts.partly_determined, "in part"),
        (counts.no_thickness, "without a thickness"),
        (counts.not_converged, "without a minimum"),
        (counts.given, "given"),
        (counts.errors, "with an error"),
    ];
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}")).collect();
    let items = if counts.items == 1 { "item" } else { "items" };
    let missed = match counts.missed {
        0 => String::new(),
        missed => format!("; the model misses the data of {missed}"),
    };
    format!("{} {items}: {}{missed}", counts.items, parts.join(", "))
}

/// The summary, and a table with the thicknesses of the first items.
#[must_use]
pub fn text(batch: &Batch) -> String {
    let mut table = Table::new(&[
        ("item", Align::Left),
        ("d_air / nm", Align::Left),
        ("d_cuticle / nm", Align::Left),
        ("period / nm", Align::Left),
        ("lamella_width / nm", Align::Left),
        ("verdict", Align::Left),
    ]);
    for row in batch.items.iter().take(SHOWN) {
        table.row(cells(row));
    }
    let mut text = format!("{}\n\n{table}", summary(&batch.counts));
    match batch.items.len().saturating_sub(SHOWN) {
        0 => {}
        more => text.push_str(&format!("  and {more} more in batch.csv\n")),
    }
    text
}

fn cells(row: &BatchRow) -> Vec<String> {
    let mut name: String = row.item.chars().take(NAME).collect();
    if name.len() < row.item.len() {
        name.push('…');
    }
    let mut cells = vec![name];
    match &row.fit {
        None => {
            cells.extend(QUANTITIES.map(|_| NONE.to_owned()));
            cells.push("error".to_owned());
        }
        Some(fit) => {
            let each = fit.values.each();
            cells.extend(each.iter().filter(|(name, _, _)| QUANTITIES.contains(name)).map(|(_, _, found)| cell(found)));
            // The order of the columns is that of the values, but for the width, which comes last here.
            cells.swap(3, 4);
            let verdict = match fit.verdict {
                Verdict::Determined => "determined",
                Verdict::PartlyDetermined => "in part",
                Verdict::NoThickness => "no thickness",
                Verdict::NotConverged => "no minimum",
                Verdict::Given => "given",
            };
            cells.push(if fit.misses() { format!("{verdict}; the model misses") } else { verdict.to_owned() });
        }
    }
    cells
}

/// The value with its standard deviation, and with its status where that is not the usual one.
fn cell(found: &BatchValue) -> String {
    let value = match (found.value, found.sigma) {
        (None, _) => return NONE.to_owned(),
        (Some(value), None) => plain(value),
        (Some(value), Some(sigma)) => {
            let (value, sigma) = with_sigma(value, sigma);
            format!("{value} ± {sigma}")
        }
    };
    if found.status == Status::Ok { value } else { format!("{value} {}", found.status.phrase()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{BATCH_SCHEMA, BatchFit, BatchValues};
    use crate::inversion::{FitSettings, SigmaSource};

    #[test]
    fn each_item_has_its_values_under_their_headings() {
        let value = |value: f64, status| BatchValue { value: Some(value), sigma: Some(0.5), interval_95: None, status };
        let ok = |number| value(number, Status::Ok);
        let values = BatchValues {
            d_air: ok(141.0),
            d_cuticle: value(62.0, Status::Ambiguous),
            delta: ok(2.5),
            phi_alpha: ok(0.5),
            lamella_width: BatchValue { value: None, sigma: None, interval_95: None, status: Status::Insensitive },
            period: ok(203.0),
            optical_sum: ok(237.7),
        };
        let (verdict, warnings) = (Verdict::PartlyDetermined, Vec::new());
        let fit = BatchFit {
            model: "blend".into(),
            verdict,
            chi2: 1.0,
            dof: 1,
            sigma_source: SigmaSource::Widened,
            values,
            warnings,
        };
        let (item, fit) = ("left".into(), Some(fit));
        let row = BatchRow { item, place: None, sha256: None, report_sha256: None, fit, error: None };
        let items = vec![row; SHOWN + 2];
        let batch = Batch {
            schema: BATCH_SCHEMA.into(),
            program: String::new(),
            settings_sha256: String::new(),
            settings: FitSettings::default(),
            compared: None,
            seed: 1,
            by: Vec::new(),
            reports: "none".into(),
            counts: BatchCounts::of(&items),
            items,
        };
        let text = text(&batch);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "26 items: 26 in part; the model misses the data of 26");
        let place = |words: &str| lines[2].find(words).unwrap();
        for (heading, cell) in [
            ("d_air", "141.00 ± 0.50"),
            ("d_cuticle", "62.00 ± 0.50 ambiguous"),
            ("period", "203.00 ± 0.50"),
            ("lamella_width", "—"),
            ("verdict", "in part; the model misses"),
        ] {
            let cells: String = lines[3].chars().skip(lines[2][..place(heading)].chars().count()).collect();
            assert!(cells.starts_with(cell), "{heading}: {cells}");
        }
        assert!(text.ends_with("and 2 more in batch.csv\n"), "{text}");
    }
}
