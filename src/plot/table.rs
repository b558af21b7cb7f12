//! The colours of a structure over incidence and view, plane by plane.

use super::sweep::{CELLS, Cell, coloured};
use super::{Figure, Panel, PlotError, check};

const CHART: &str = "table";
const SIZE: (f64, f64) = (330.0, 300.0);

/// One plane of a table, as a display shows it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plane {
    /// Such as `ω = 90°`.
    pub title: String,
    /// What varies across, with its unit.
    pub x_label: String,
    /// Its values, ascending, 2 to 1000.
    pub x: Vec<f64>,
    /// What varies upwards, with its unit.
    pub y_label: String,
    /// Its values, ascending, 1 to 1000.
    pub y: Vec<f64>,
    /// Colours; empty where there is none.
    pub cells: Vec<Option<Cell>>,
}

/// The planes side by side; dots and an outline named `outside` mark the colours that the display cannot show.
///
/// # Shape
/// `cells: [y][x]`, the lowest y first.
///
/// # Errors
/// [`PlotError::Count`] for too few or too many values on a side, [`PlotError::Unequal`] if there is not one colour for each
/// cell.
pub fn planes_figure(title: &str, subtitle: &str, planes: &[Plane], outside: &str) -> Result<Figure, PlotError> {
    let mut panels = Vec::with_capacity(planes.len());
    for plane in planes {
        check::count(CHART, "columns", (2, CELLS), plane.x.len())?;
        check::count(CHART, "rows", (1, CELLS), plane.y.len())?;
        check::length(CHART, "colours", plane.x.len() * plane.y.len(), plane.cells.len())?;
        panels.push(Panel {
            title: plane.title.clone(),
            x_label: plane.x_label.clone(),
            y_label: plane.y_label.clone(),
            bare_y: plane.y.len() == 1,
            ..coloured(&plane.x, &plane.y, &plane.cells, outside)
        });
    }
    let columns = Some(planes.len().max(1));
    Ok(Figure { title: title.to_owned(), subtitle: subtitle.to_owned(), panels, columns, plot_size: Some(SIZE) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    #[test]
    fn each_plane_has_its_cells() {
        let cells = vec![Some(Cell { bytes: [10, 20, 200], outside: false }), None];
        let plane = Plane { title: "ω = 90°".into(), x: vec![0.0, 1.0], y: vec![0.0], cells, ..Plane::default() };
        let svg =
            draw(&planes_figure("a table", "", std::slice::from_ref(&plane), "outside sRGB").unwrap()).unwrap().svg;
        assert!(svg.to_lowercase().contains("#0a14c8") && svg.contains("ω = 90°"));
        let short = Plane { cells: vec![None], ..plane };
        assert!(matches!(planes_figure("", "", &[short], ""), Err(PlotError::Unequal { .. })));
    }
}
