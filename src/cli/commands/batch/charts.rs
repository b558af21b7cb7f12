//! The chart of a batch.

use super::TABLE;
use crate::commands::{chart_files, drawn};
use crate::output;
use anyhow::Result;
use morpho_fit::export::{Batch, BatchRow, BatchValue};
use morpho_fit::plot::Figure;
use morpho_fit::plot::batch::{BatchQuantity, ITEMS, items_figure, maps_figure};
use morpho_fit::report::batch;

/// Quantities that are drawn.
const DRAWN: [&str; 4] = ["d_air", "d_cuticle", "period", "lamella_width"];

/// The map of the pixels, or the values item by item, as files; none, and that is told, where there is nothing to draw
/// or it cannot be drawn: the table stands without a chart.
pub(super) fn charts(batch: &Batch) -> Vec<(String, Vec<u8>)> {
    let quantities: Vec<BatchQuantity> = DRAWN.iter().filter_map(|name| quantity(batch, name)).collect();
    if quantities.is_empty() {
        output::complain("no chart is drawn: no item has a thickness that was fitted and is determined");
        return Vec::new();
    }
    let is_map = batch.by.len() == 2;
    if is_map {
        match map(batch, &quantities).and_then(|figure| files("map", figure)) {
            Ok(files) => return files,
            Err(error) => output::complain(&format!("no map is drawn: {error:#}")),
        }
    }
    if batch.items.len() > ITEMS {
        if !is_map {
            output::complain(&format!("no chart is drawn of more than {ITEMS} items; {TABLE} has them all"));
        }
        return Vec::new();
    }
    let names: Vec<String> = batch.items.iter().map(|row| row.item.clone()).collect();
    let figure = items_figure(&batch::summary(&batch.counts), &names, &quantities).map_err(anyhow::Error::from);
    figure.and_then(|figure| files("items", figure)).unwrap_or_else(|error| {
        output::complain(&format!("no chart is drawn: {error:#}"));
        Vec::new()
    })
}

fn map(batch: &Batch, quantities: &[BatchQuantity]) -> Result<Figure> {
    let labels = [0, 1].map(|axis| batch.by.get(axis).map_or("", String::as_str));
    let places: Vec<[f64; 2]> = batch.items.iter().filter_map(|row| row.place).collect();
    Ok(maps_figure(&batch::summary(&batch.counts), labels, &places, quantities)?)
}

fn files(name: &'static str, figure: Figure) -> Result<Vec<(String, Vec<u8>)>> {
    Ok(chart_files(&drawn(vec![(name, figure)])?))
}

/// A quantity over all items where it is determined; none where it nowhere is.
fn quantity(batch: &Batch, name: &str) -> Option<BatchQuantity> {
    let found = |row: &BatchRow| -> Option<BatchValue> {
        let each = row.fit.as_ref()?.values.each();
        each.iter().find(|(of, _, _)| *of == name).map(|(_, _, found)| **found)
    };
    let found = batch.items.iter().map(|row| found(row).filter(|found| found.status.is_determined()));
    let (values, sigma): (Vec<Option<f64>>, Vec<f64>) = found
        .map(|found| (found.and_then(|found| found.value), found.and_then(|found| found.sigma).unwrap_or(f64::NAN)))
        .unzip();
    let name = if name == "period" { "d_air + d_cuticle" } else { name };
    values.iter().any(Option::is_some).then(|| BatchQuantity { name: format!("{name} / nm"), values, sigma })
}
