//! Outlines of a butterfly's wings, and how far points are from them.

use rayon::prelude::*;

/// Pieces of a curve between two of its points.
const PIECES: usize = 12;

/// Points of the right forewing from its root along the leading edge, the outer margin and back; x to the right of the body,
/// y upwards, in half sides of the square. Drawn by eye after spread *Morpho* males.
pub(super) const FOREWING: [[f64; 2]; 13] = [
    [0.035, 0.13],
    [0.22, 0.34],
    [0.48, 0.58],
    [0.74, 0.755],
    [0.905, 0.79],
    [0.965, 0.70],
    [0.925, 0.52],
    [0.875, 0.32],
    [0.845, 0.14],
    [0.785, 0.0],
    [0.60, -0.055],
    [0.30, -0.03],
    [0.05, 0.02],
];
/// The outer margin of [`FOREWING`].
pub(super) const FOREWING_MARGIN: std::ops::Range<usize> = 3..10;

/// Points of the right hindwing from its root along the front, the outer margin and back along the body.
pub(super) const HINDWING: [[f64; 2]; 13] = [
    [0.03, 0.06],
    [0.30, 0.10],
    [0.60, 0.06],
    [0.765, -0.06],
    [0.805, -0.24],
    [0.775, -0.42],
    [0.70, -0.58],
    [0.585, -0.71],
    [0.45, -0.79],
    [0.32, -0.80],
    [0.21, -0.70],
    [0.115, -0.46],
    [0.04, -0.16],
];
/// The outer margin of [`HINDWING`].
pub(super) const HINDWING_MARGIN: std::ops::Range<usize> = 2..10;

/// A smooth closed curve through points (Catmull–Rom), as short straight pieces.
pub(super) fn closed(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    curve(points, 0..points.len())
}

/// The part of the same curve from the first to the last of some points.
pub(super) fn part(points: &[[f64; 2]], range: std::ops::Range<usize>) -> Vec<[f64; 2]> {
    curve(points, range.start..range.end - 1)
}

fn curve(points: &[[f64; 2]], from: std::ops::Range<usize>) -> Vec<[f64; 2]> {
    let count = points.len();
    let mut drawn = Vec::with_capacity(PIECES * from.len() + 1);
    for piece in from.start * PIECES..=from.end * PIECES {
        let (index, step) = (piece / PIECES, piece % PIECES);
        #[allow(clippy::cast_precision_loss, reason = "a dozen")]
        let t = step as f64 / PIECES as f64;
        let [before, first, second, after] =
            [count - 1, 0, 1, 2].map(|offset| points.get((index + offset) % count).copied().unwrap_or_default());
        drawn.push(std::array::from_fn(|axis| {
            let (a, b, c, d) = (before[axis], first[axis], second[axis], after[axis]);
            0.5 * (2.0 * b + t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a))))
        }));
    }
    drawn
}

/// Distance of a point from a curve of straight pieces.
pub(super) fn distance([x, y]: [f64; 2], curve: &[[f64; 2]]) -> f64 {
    let pieces = curve.iter().zip(curve.iter().skip(1));
    let squared = pieces.map(|(from, to)| {
        let (along, there) = ([to[0] - from[0], to[1] - from[1]], [x - from[0], y - from[1]]);
        let length = along[0] * along[0] + along[1] * along[1];
        let share = if length > 0.0 { (there[0] * along[0] + there[1] * along[1]) / length } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        let (right, up) = (there[0] - share * along[0], there[1] - share * along[1]);
        right * right + up * up
    });
    squared.fold(f64::INFINITY, f64::min).sqrt()
}

/// Whether a point lies within a closed curve: a ray from it crosses the curve an odd number of times.
pub(super) fn within([x, y]: [f64; 2], curve: &[[f64; 2]]) -> bool {
    let pieces = curve.iter().zip(curve.iter().skip(1));
    let crossings = pieces.filter(|(from, to)| {
        (from[1] > y) != (to[1] > y) && x < from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0])
    });
    crossings.count() % 2 == 1
}

/// A function of the right half of the square, known at the nodes of a grid and linear between them.
pub(super) struct Field {
    values: Vec<f64>,
}

impl Field {
    /// Intervals of the half square: 0.008 half sides each, where a margin bends by less than 0.0002.
    const COLUMNS: usize = 120;
    const ROWS: usize = 240;

    pub(super) fn of(function: impl Fn([f64; 2]) -> f64 + Sync) -> Self {
        let node = |index: usize| {
            let (column, row) = (index % (Self::COLUMNS + 1), index / (Self::COLUMNS + 1));
            #[allow(clippy::cast_precision_loss, reason = "some hundred")]
            let at = [column as f64 / Self::COLUMNS as f64, 2.0 * row as f64 / Self::ROWS as f64 - 1.0];
            function(at)
        };
        Self { values: (0..(Self::COLUMNS + 1) * (Self::ROWS + 1)).into_par_iter().map(node).collect() }
    }

    /// At x from 0 to 1 and y from -1 to 1.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "some hundred")]
        let (across, upwards) = (x * Self::COLUMNS as f64, (0.5 * y + 0.5) * Self::ROWS as f64);
        let split = |place: f64, count: usize| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid")]
            let below = (place.max(0.0) as usize).min(count - 1);
            #[allow(clippy::cast_precision_loss, reason = "some hundred")]
            let share = place - below as f64;
            (below, share)
        };
        let ((column, right), (row, up)) = (split(across, Self::COLUMNS), split(upwards, Self::ROWS));
        let value = |column: usize, row: usize| {
            self.values.get(row * (Self::COLUMNS + 1) + column).copied().unwrap_or_default()
        };
        let between = |row| value(column, row) + right * (value(column + 1, row) - value(column, row));
        between(row) + up * (between(row + 1) - between(row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_told_from_what_is_around_it() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        assert!(within([0.3, 0.9], &square) && !within([0.3, 1.1], &square));
        assert!((distance([0.3, 0.9], &square) - 0.1).abs() < 1e-12);
        assert!((distance([2.0, 2.0], &square) - 2.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_curve_goes_through_its_points_and_closes() {
        let drawn = closed(&FOREWING);
        for (point, found) in FOREWING.iter().zip(drawn.iter().step_by(PIECES)) {
            assert!((point[0] - found[0]).hypot(point[1] - found[1]) < 1e-12);
        }
        assert_eq!(drawn.first(), drawn.last());
        let margin = part(&FOREWING, FOREWING_MARGIN);
        assert_eq!((margin.first(), margin.last()), (Some(&FOREWING[3]), Some(&FOREWING[9])));
    }
}
