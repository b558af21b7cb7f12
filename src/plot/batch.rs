//! The charts of many fits: values with their error bars item by item, or a map of pixels.

mod grid;

pub use grid::MapError;

use super::{Figure, HeatMap, Panel, PlotError, PointSeries, check};
use grid::grid;

const CHART: &str = "batch";
/// Items of a chart at most; more error bars cannot be told from each other.
pub const ITEMS: usize = 200;
/// Cells of a map at most; more make the SVG too large to open.
pub const CELLS: usize = 65_536;
/// The longer and the shorter side of a map, picture units.
const LONG_SIDE: f64 = 330.0;
const SHORT_SIDE: f64 = 150.0;
/// Letters of the names that a chart lists.
const NAMES: usize = 240;
/// Panels in a row.
const COLUMNS: usize = 2;

/// One quantity over all items.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BatchQuantity {
    /// Name with unit, such as `d_air / nm`.
    pub name: String,
    /// A value for each item; none where it is not determined.
    pub values: Vec<Option<f64>>,
    /// Their standard deviations; not a number where there is none.
    pub sigma: Vec<f64>,
}

impl BatchQuantity {
    fn determined(&self) -> usize {
        self.values.iter().flatten().count()
    }

    fn numbers(&self) -> Vec<f64> {
        self.values.iter().map(|value| value.unwrap_or(f64::NAN)).collect()
    }

    fn title(&self, items: &str) -> String {
        format!("{}: {} of {} {items}", self.name, self.determined(), self.values.len())
    }
}

/// A panel for each quantity: the value of each item with its standard deviation, over the number of the item.
///
/// An item without a value is left out, and the heading of the panel says how many there are. Names are listed below
/// the title where there is room.
///
/// # Shape
/// `names: [items]`; `values` and `sigma` of each quantity likewise.
///
/// # Errors
/// [`PlotError::Count`] for no item or more than [`ITEMS`], [`PlotError::Unequal`] if a quantity has another number of
/// values; [`PlotError::NoPanels`], on drawing, without a quantity.
///
/// ```
/// use morpho_fit::plot::{batch::{BatchQuantity, items_figure}, draw};
///
/// let values = vec![Some(141.0), None, Some(138.5)];
/// let d_air = BatchQuantity { name: "d_air / nm".into(), values, sigma: vec![0.4, f64::NAN, 1.2] };
/// let names = ["left", "middle", "right"].map(str::to_owned);
/// let picture = draw(&items_figure("three scales", &names, &[d_air])?)?;
/// assert!(picture.svg.contains("d_air / nm: 2 of 3 items"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
pub fn items_figure(title: &str, names: &[String], quantities: &[BatchQuantity]) -> Result<Figure, PlotError> {
    check::count(CHART, "items", (1, ITEMS), names.len())?;
    let numbers: Vec<f64> = (1..=names.len()).map(|number| number as f64).collect();
    // Five apart at least, or ticks would stand between two items.
    let range = (0.0, (names.len() as f64 + 1.0).max(5.0));
    let mut panels = Vec::with_capacity(quantities.len());
    for quantity in quantities {
        lengths(quantity, names.len())?;
        let points = PointSeries {
            x: numbers.clone(),
            y: quantity.numbers(),
            sigma: Some(quantity.sigma.clone()),
            ..PointSeries::default()
        };
        panels.push(Panel {
            title: quantity.title("items"),
            x_label: "item, in the order of the table".to_owned(),
            y_label: quantity.name.clone(),
            x_range: Some(range),
            points: vec![points],
            ..Panel::default()
        });
    }
    let list = names.iter().enumerate().map(|(index, name)| format!("{} {name}", index + 1));
    let list = list.collect::<Vec<String>>().join(", ");
    let mut subtitle = "bars are one standard deviation; what is not determined is left out".to_owned();
    if list.chars().count() <= NAMES {
        subtitle.push_str("; items: ");
        subtitle.push_str(&list);
    }
    Ok(Figure { title: title.to_owned(), subtitle, panels, columns: Some(COLUMNS), plot_size: None })
}

/// A map for each quantity, with a colour bar; a pixel without a value is empty, and the heading says how many have
/// one.
///
/// Coordinates nearer to each other than a tenth of a step are one column or row, as those of a stage that misses its
/// place by a little; a cell is bounded half-way to its neighbours, and where a column or row is missing the map is
/// empty. Two places are never drawn as one.
///
/// - `labels`: names of the two coordinates.
/// - `places`: coordinates of each pixel, all different.
///
/// # Shape
/// `places: [pixels]`; `values` of each quantity likewise.
///
/// # Errors
/// [`MapError::Sparse`], [`MapError::Shared`] or [`MapError::Uneven`] if the places are no grid. As
/// [`MapError::Plot`]: [`PlotError::Count`] for no pixel, or a grid of more than [`CELLS`]; [`PlotError::Unequal`] if
/// a quantity has another number of values; [`PlotError::Unusable`] if a coordinate is not finite or too large;
/// [`PlotError::NoPanels`], on drawing, without a quantity.
///
/// ```
/// use morpho_fit::plot::{batch::{BatchQuantity, maps_figure}, draw};
///
/// let values = vec![Some(141.0), None, Some(138.5)];
/// let d_air = BatchQuantity { name: "d_air / nm".into(), values, sigma: vec![0.4, f64::NAN, 1.2] };
/// let places = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
/// let picture = draw(&maps_figure("a wing", ["x", "y"], &places, &[d_air])?)?;
/// assert!(picture.svg.contains("d_air / nm: 2 of 3 pixels"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn maps_figure(
    title: &str,
    labels: [&str; 2],
    places: &[[f64; 2]],
    quantities: &[BatchQuantity],
) -> Result<Figure, MapError> {
    check::count(CHART, "pixels", (1, CELLS), places.len())?;
    let side = |axis: usize| places.iter().map(|place| place[axis]).collect::<Vec<f64>>();
    let [across, upwards] = [side(0), side(1)];
    check::drawable(CHART, labels[0], &across)?;
    check::drawable(CHART, labels[1], &upwards)?;
    let (x, y) = grid(labels, [&across, &upwards], places)?;
    check::count(CHART, "cells of the map", (1, CELLS), x.cells().saturating_mul(y.cells()))?;
    let cells: Vec<usize> = places.iter().map(|place| y.cell(place[1]) * x.cells() + x.cell(place[0])).collect();
    let mut panels = Vec::with_capacity(quantities.len());
    for quantity in quantities {
        lengths(quantity, places.len())?;
        let mut values = vec![f64::NAN; x.cells() * y.cells()];
        for (&cell, value) in cells.iter().zip(quantity.numbers()) {
            if let Some(place) = values.get_mut(cell) {
                *place = value;
            }
        }
        let heat = HeatMap {
            x_edges: x.edges.clone(),
            y_edges: y.edges.clone(),
            values,
            label: quantity.name.clone(),
            ..HeatMap::default()
        };
        panels.push(Panel {
            title: quantity.title("pixels"),
            x_label: labels[0].to_owned(),
            y_label: labels[1].to_owned(),
            heat: Some(heat),
            ..Panel::default()
        });
    }
    Ok(Figure {
        title: title.to_owned(),
        subtitle: "empty: the value is not determined there, or there are no data".to_owned(),
        panels,
        columns: Some(COLUMNS),
        plot_size: Some(sides(x.length(), y.length())),
    })
}

fn lengths(quantity: &BatchQuantity, items: usize) -> Result<(), PlotError> {
    check::length(CHART, &quantity.name, items, quantity.values.len())?;
    check::length(CHART, &quantity.name, items, quantity.sigma.len())
}

/// Sides of a plot in which cells of one unit both ways are square, unless it would be too narrow.
fn sides(x: f64, y: f64) -> (f64, f64) {
    let side = |own: f64, other: f64| (LONG_SIDE * (own / other).min(1.0)).max(SHORT_SIDE);
    (side(x, y), side(y, x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    fn quantity(values: &[Option<f64>]) -> BatchQuantity {
        BatchQuantity { name: "d_air / nm".into(), values: values.to_vec(), sigma: vec![1.0; values.len()] }
    }

    #[test]
    fn a_pixel_without_a_value_is_empty() {
        let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let map = quantity(&[Some(1.0), None, Some(2.0), Some(3.0)]);
        let figure = maps_figure("", ["x", "y"], &places, &[map]).unwrap();
        let heat = figure.panels[0].heat.as_ref().unwrap();
        assert_eq!(heat.values.len(), 4);
        assert!(heat.values[1].is_nan(), "{:?}", heat.values);
        let told: Vec<f64> = heat.values.iter().copied().filter(|value| value.is_finite()).collect();
        assert_eq!(told, [1.0, 2.0, 3.0]);
        assert!(draw(&figure).unwrap().svg.contains("d_air / nm: 3 of 4 pixels"));
    }

    #[test]
    fn pixels_are_square_unless_the_map_is_a_strip() {
        assert_eq!(sides(10.0, 10.0), (LONG_SIDE, LONG_SIDE));
        assert_eq!(sides(20.0, 10.0), (LONG_SIDE, LONG_SIDE / 2.0));
        assert_eq!(sides(1.0, 1000.0), (SHORT_SIDE, LONG_SIDE));
        let strip: Vec<[f64; 2]> = (0..50).map(|x| [f64::from(x), 3.0]).collect();
        draw(&maps_figure("", ["x", "y"], &strip, &[quantity(&[Some(1.0); 50])]).unwrap()).unwrap();
    }

    #[test]
    fn contradictions_and_crowds_are_errors() {
        let names = vec!["a".to_owned(); ITEMS + 1];
        assert!(matches!(items_figure("", &names, &[]), Err(PlotError::Count { found: 201, .. })));
        assert!(matches!(items_figure("", &names[..2], &[quantity(&[None])]), Err(PlotError::Unequal { .. })));
        for wrong in [f64::NAN, 1e308] {
            let found = maps_figure("", ["x", "y"], &[[0.0, wrong]], &[]);
            assert!(matches!(found, Err(MapError::Plot(PlotError::Unusable { .. }))), "{found:?}");
        }
        let crowd: Vec<[f64; 2]> =
            (0..257 * 256).map(|pixel| [f64::from(pixel % 257), f64::from(pixel / 257)]).collect();
        let found = maps_figure("", ["x", "y"], &crowd, &[]);
        assert!(matches!(found, Err(MapError::Plot(PlotError::Count { .. }))), "{found:?}");
        let nothing = quantity(&[None, None]);
        let figure = items_figure("", &names[..2], &[nothing]).unwrap();
        assert!(draw(&figure).unwrap().svg.contains("no finite values"));
    }
}
