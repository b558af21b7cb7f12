//! The chart of a batch.

use super::TABLE;
use crate::output;
use anyhow::Result;
use morpho_fit::export::{Batch, BatchRow, BatchValue};
use morpho_fit::plot::batch::{BatchQuantity, CELLS, ITEMS, items_figure, maps_figure};
use morpho_fit::plot::{Figure, PlotError};
use morpho_fit::report::batch;

/// Quantities that are drawn.
const DRAWN: [&str; 4] = ["d_air", "d_cuticle", "period", "lamella_width"];

/// The map of the pixels, or the values item by item; none, and that is told, where there is nothing to draw or too much.
pub(super) fn figure(batch: &Batch) -> Result<Option<(&'static str, Figure)>> {
    let quantities: Vec<BatchQuantity> = DRAWN.iter().filter_map(|name| quantity(batch, name)).collect();
    if quantities.is_empty() {
        output::complain("no chart is drawn: no item has a thickness that was fitted and is determined");
        return Ok(None);
    }
    let title = batch::summary(&batch.counts);
    if let [x, y] = batch.by.as_slice() {
        let places: Vec<[f64; 2]> = batch.items.iter().filter_map(|row| row.place).collect();
        return match maps_figure(&title, [x, y], &places, &quantities) {
            Ok(figure) => Ok(Some(("map", figure))),
            Err(error @ PlotError::Count { .. }) => {
                output::complain(&format!("no map is drawn, {CELLS} cells are the most: {error}"));
                Ok(None)
            }
            Err(error) => Err(error.into()),
        };
    }
    if batch.items.len() > ITEMS {
        output::complain(&format!("no chart is drawn of more than {ITEMS} items; {TABLE} has them all"));
        return Ok(None);
    }
    let names: Vec<String> = batch.items.iter().map(|row| row.item.clone()).collect();
    Ok(Some(("items", items_figure(&title, &names, &quantities)?)))
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
