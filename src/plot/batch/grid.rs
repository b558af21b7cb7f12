//! Columns and rows of a map from the places of its pixels.

use crate::plot::PlotError;
use crate::plot::atlas::edges_around;
use std::collections::HashSet;
use thiserror::Error;

/// Coordinates nearer than a step by this factor are one.
const NEARER: f64 = 10.0;
/// The widest column whose coordinates are still one, in steps.
const WIDEST: f64 = 0.25;
/// Groupings of the coordinates of an axis that are tried.
const GROUPINGS: usize = 8;
/// Neighbours farther apart than so many steps have empty cells between them.
const NEIGHBOURS: f64 = 1.5;

/// Why places cannot be drawn as a map.
#[derive(Debug, Error)]
pub enum MapError {
    /// Too few places for the columns and rows that they lie in.
    #[error("the places are no grid: {places} lie in {columns} columns and {rows} rows, most of whose cells are empty")]
    Sparse {
        /// Number of places.
        places: usize,
        /// Columns with a place in them.
        columns: usize,
        /// Rows with a place in them.
        rows: usize,
    },
    /// Two places would be drawn as one.
    #[error("the places are no grid: two of the {places} fall into one cell")]
    Shared {
        /// Number of places.
        places: usize,
    },
    /// The coordinates have no step.
    #[error("the places are no grid: along `{label}` neighbours are from {least} to {most} apart")]
    Uneven {
        /// Name of the coordinate.
        label: String,
        /// The smallest distance between neighbours.
        least: f64,
        /// The largest.
        most: f64,
    },
    /// What any chart may lack.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// The coarsest columns and rows that hold each place in a cell of its own and are half full at least.
pub(super) fn grid(labels: [&str; 2], sides: [&[f64]; 2], places: &[[f64; 2]]) -> Result<(Grid, Grid), MapError> {
    let [across, upwards] = [Grid::all(labels[0], sides[0])?, Grid::all(labels[1], sides[1])?];
    let mut problem = MapError::Shared { places: places.len() };
    for x in &across {
        for y in &upwards {
            let (columns, rows) = (x.starts.len(), y.starts.len());
            if columns * rows > 2 * places.len() {
                problem = MapError::Sparse { places: places.len(), columns, rows };
                continue;
            }
            let mut taken = HashSet::with_capacity(places.len());
            if columns * rows >= places.len() && places.iter().all(|&[a, b]| taken.insert((x.cell(a), y.cell(b)))) {
                return Ok((x.clone(), y.clone()));
            }
            problem = MapError::Shared { places: places.len() };
        }
    }
    Err(problem)
}

/// Cells along one side of a map.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) edges: Vec<f64>,
    /// The smallest coordinate of each column or row that has a place in it, and its cell.
    starts: Vec<(f64, usize)>,
}

impl Grid {
    /// Every grid about these coordinates, in any order, the coarsest first: where distances between neighbours drop
    /// tenfold, the smaller ones may be errors of the place.
    fn all(label: &str, coordinates: &[f64]) -> Result<Vec<Self>, MapError> {
        let mut sorted = coordinates.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        let mut gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_by(|one, other| other.total_cmp(one));
        let drops = gaps.windows(2).filter(|pair| pair[0] >= NEARER * pair[1]).map(|pair| pair[1]);
        let grids: Vec<Self> =
            drops.take(GROUPINGS).chain([0.0]).filter_map(|nearer| Self::of(&sorted, nearer)).collect();
        if grids.is_empty() {
            let (most, least) = gaps.first().copied().zip(gaps.last().copied()).unwrap_or_default();
            return Err(MapError::Uneven { label: label.to_owned(), least, most });
        }
        Ok(grids)
    }

    /// Cells about ascending coordinates, of which neighbours as near as `nearer` are one; none if they have no step.
    fn of(sorted: &[f64], nearer: f64) -> Option<Self> {
        let mut columns: Vec<(f64, f64)> = Vec::new();
        for &value in sorted {
            match columns.last_mut() {
                Some((_, end)) if value - *end <= nearer => *end = value,
                _ => columns.push((value, value)),
            }
        }
        let middles: Vec<f64> = columns.iter().map(|(start, end)| start + 0.5 * (end - start)).collect();
        let mut gaps: Vec<f64> = middles.windows(2).map(|pair| pair[1] - pair[0]).collect();
        gaps.sort_by(f64::total_cmp);
        let step = match gaps.get(gaps.len().saturating_sub(1) / 2) {
            Some(&median) => median,
            None => middles.first().map_or(1.0, |only| (only.abs() * 1e-6).max(1.0)),
        };
        let is_narrow = |&(start, end): &(f64, f64)| end - start <= WIDEST * step;
        if gaps.first().is_some_and(|least| least * NEARER < step) || !columns.iter().all(is_narrow) {
            return None;
        }
        // Between cells that are no neighbours an empty one stands.
        let (mut edges, mut starts) = (Vec::new(), Vec::with_capacity(columns.len()));
        for run in middles.chunk_by(|one, next| next - one <= NEIGHBOURS * step) {
            let before = edges.len();
            let inside = columns.iter().skip(starts.len()).take(run.len()).map(|(start, _)| *start);
            starts.extend(inside.enumerate().map(|(index, start)| (start, before + index)).collect::<Vec<_>>());
            edges.extend(around(run, step));
        }
        Some(Self { edges, starts })
    }

    pub(super) fn cells(&self) -> usize {
        self.edges.len().saturating_sub(1)
    }

    /// The cell of one of the coordinates.
    pub(super) fn cell(&self, coordinate: f64) -> usize {
        let behind = self.starts.partition_point(|(start, _)| *start <= coordinate);
        self.starts.get(behind.saturating_sub(1)).map_or(0, |(_, cell)| *cell)
    }

    pub(super) fn length(&self) -> f64 {
        self.edges.last().zip(self.edges.first()).map_or(1.0, |(last, first)| last - first)
    }
}

/// Ends of cells that touch, about these middles.
fn around(middles: &[f64], step: f64) -> Vec<f64> {
    match middles {
        [only] => vec![only - 0.5 * step, only + 0.5 * step],
        more => edges_around(more),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::batch::{BatchQuantity, maps_figure};
    use crate::plot::draw;

    fn quantity(values: &[Option<f64>]) -> BatchQuantity {
        BatchQuantity { name: "d_air / nm".into(), values: values.to_vec(), sigma: vec![1.0; values.len()] }
    }

    #[test]
    fn cells_lie_about_their_coordinates_and_leave_gaps_open() {
        let finest = |values: &[f64]| Grid::all("x", values).unwrap().pop().unwrap();
        let grid = finest(&[2.0, 0.0, 1.0, 5.0, 1.0]);
        assert_eq!(grid.edges, [-0.5, 0.5, 1.5, 2.5, 4.5, 5.5]);
        assert_eq!([0.0, 1.0, 2.0, 5.0].map(|x| grid.cell(x)), [0, 1, 2, 4]);
        assert_eq!(finest(&[7.0, 7.0]).edges, [6.5, 7.5]);
        // A cell of one unit is none there: neighbours of 1e17 are 16 apart.
        assert_eq!(finest(&[1e17]).edges, [1e17 - 5e10, 1e17 + 5e10]);
        // Steps that rounding makes differ are one step.
        assert_eq!(finest(&[0.1, 0.2, 0.1 + 0.2, 0.3]).cells(), 3);
    }

    /// A raster of `side` by `side` pixels 10 apart, each off its place by at most `error`, as a stage has it.
    fn raster(side: u32, error: f64) -> Vec<[f64; 2]> {
        let off = |pixel: u32, by: u32| error * (f64::from(pixel * by % 101) / 50.0 - 1.0);
        let place =
            |pixel: u32| [(pixel % side, 37), (pixel / side, 59)].map(|(at, by)| 10.0 * f64::from(at) + off(pixel, by));
        (0..side * side).map(place).collect()
    }

    #[test]
    fn places_that_are_a_little_off_fill_their_cells() {
        for error in [0.0, 1e-12, 0.05, 0.4] {
            let places = raster(10, error);
            let values: Vec<Option<f64>> = (0..100).map(|pixel| Some(f64::from(pixel))).collect();
            let figure = maps_figure("", ["x", "y"], &places, &[quantity(&values)]).unwrap();
            let heat = figure.panels[0].heat.as_ref().unwrap();
            // The raster goes row by row, as the cells do.
            assert_eq!(heat.values, (0..100).map(f64::from).collect::<Vec<f64>>(), "{error}");
            assert!(heat.x_edges.windows(2).all(|ends| (ends[1] - ends[0] - 10.0).abs() <= 2.0 * error + 1e-9));
        }
    }

    #[test]
    fn a_small_part_of_a_large_range_is_a_grid_of_its_own() {
        // Two rasters of a step of 1, far apart: a tolerance that is a part of the range would make one of each.
        let near = raster(3, 0.0).into_iter().map(|place| place.map(|at| at / 10.0));
        let places: Vec<[f64; 2]> = near.clone().chain(near.map(|[x, y]| [x + 1e7, y])).collect();
        let figure = maps_figure("", ["x", "y"], &places, &[quantity(&[Some(1.0); 18])]).unwrap();
        let heat = figure.panels[0].heat.as_ref().unwrap();
        assert_eq!(heat.values.iter().filter(|value| value.is_finite()).count(), 18);
        draw(&figure).unwrap();
    }

    #[test]
    fn places_that_are_no_grid_are_told() {
        let drawn = |places: &[[f64; 2]]| maps_figure("", ["x", "y"], places, &[]).unwrap_err();
        // The golden angle puts no two points on one line.
        let spiral: Vec<[f64; 2]> = (1..50)
            .map(|n| (f64::from(n).sqrt(), 2.399_963 * f64::from(n)))
            .map(|(radius, angle)| [radius * angle.cos(), radius * angle.sin()])
            .collect();
        assert!(matches!(drawn(&spiral), MapError::Uneven { .. } | MapError::Sparse { .. }), "{}", drawn(&spiral));
        let diagonal: Vec<[f64; 2]> = (0..1000).map(|x| [f64::from(x); 2]).collect();
        assert!(matches!(drawn(&diagonal), MapError::Sparse { places: 1000, columns: 1000, rows: 1000 }));
        assert!(matches!(drawn(&[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), MapError::Shared { places: 3 }));
        // Two places a millionth of a step apart are two measurements.
        let near = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.000_001, 0.0]];
        assert!(matches!(drawn(&near), MapError::Shared { places: 4 }));
        assert!(drawn(&spiral).to_string().starts_with("the places are no grid: "));
    }
}
