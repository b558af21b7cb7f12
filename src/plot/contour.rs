//! Lines of equal height on a grid.

use std::collections::BTreeMap;

/// A side of a cell: from node `(column, row)` one step to the right, or one up.
type Side = (usize, usize, bool);

/// The lines on which values between the nodes of a grid reach `level`, as one list of points with a gap (not a number)
/// after each line; closed lines end where they began. Cells with a node that is not a number are left out.
///
/// Values are mixed linearly along the sides of the cells; a saddle is cut by the mean of its four corners.
///
/// # Shape
/// `x: [columns]`, `y: [rows]`, `values: [rows * columns]`, row by row.
///
/// # Source
/// Lorensen and Cline, *Marching cubes*, SIGGRAPH 1987, in two dimensions.
pub(super) fn contour(x: &[f64], y: &[f64], values: &[f64], level: f64) -> (Vec<f64>, Vec<f64>) {
    let value = |column: usize, row: usize| values.get(row * x.len() + column).copied().unwrap_or(f64::NAN);
    let place = |(column, row, up): Side| {
        let (next_column, next_row) = if up { (column, row + 1) } else { (column + 1, row) };
        let (from, to) = (value(column, row), value(next_column, next_row));
        // An end that is infinite is as far away as the line can be from it.
        let part = if to.is_infinite() {
            0.0
        } else if from.is_infinite() {
            1.0
        } else {
            (level - from) / (to - from)
        };
        let mixed = |axis: &[f64], a: usize, b: usize| match (axis.get(a), axis.get(b)) {
            (Some(low), Some(high)) => low + part.clamp(0.0, 1.0) * (high - low),
            _ => f64::NAN,
        };
        (mixed(x, column, next_column), mixed(y, row, next_row))
    };
    // Each crossing of a side has at most two neighbours.
    let mut neighbours: BTreeMap<Side, Vec<Side>> = BTreeMap::new();
    for row in 0..y.len().saturating_sub(1) {
        for column in 0..x.len().saturating_sub(1) {
            for (from, to) in crossings(column, row, level, &value) {
                neighbours.entry(from).or_default().push(to);
                neighbours.entry(to).or_default().push(from);
            }
        }
    }
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    // Open lines from one of their ends, then closed ones from anywhere.
    let ends: Vec<Side> = neighbours.iter().filter(|(_, next)| next.len() == 1).map(|(&side, _)| side).collect();
    let all: Vec<Side> = neighbours.keys().copied().collect();
    for start in ends.into_iter().chain(all) {
        let mut here = start;
        let mut length = 0;
        while let Some(next) = neighbours.get_mut(&here).and_then(Vec::pop) {
            if let Some(back) = neighbours.get_mut(&next)
                && let Some(index) = back.iter().position(|&side| side == here)
            {
                back.swap_remove(index);
            }
            if length == 0 {
                let (px, py) = place(start);
                xs.push(px);
                ys.push(py);
            }
            let (px, py) = place(next);
            xs.push(px);
            ys.push(py);
            length += 1;
            here = next;
        }
        if length > 0 {
            xs.push(f64::NAN);
            ys.push(f64::NAN);
        }
    }
    (xs, ys)
}

/// Pairs of sides of a cell that a line joins.
fn crossings(column: usize, row: usize, level: f64, value: &impl Fn(usize, usize) -> f64) -> Vec<(Side, Side)> {
    let corners = [value(column, row), value(column + 1, row), value(column + 1, row + 1), value(column, row + 1)];
    if corners.iter().any(|corner| corner.is_nan()) {
        return Vec::new();
    }
    let inside = corners.map(|corner| corner < level);
    // Side k lies between the corners k and k + 1: bottom, right, top, left.
    let sides: [Side; 4] =
        [(column, row, false), (column + 1, row, true), (column, row + 1, false), (column, row, true)];
    let crossed: Vec<Side> =
        (0..4).filter(|&k| inside[k] != inside[(k + 1) % 4]).filter_map(|k| sides.get(k).copied()).collect();
    match *crossed.as_slice() {
        [from, to] => vec![(from, to)],
        [bottom, right, top, left] => {
            let middle_inside = corners.iter().sum::<f64>() / 4.0 < level;
            if middle_inside == inside[0] {
                vec![(bottom, right), (top, left)]
            } else {
                vec![(bottom, left), (right, top)]
            }
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize) -> Vec<f64> {
        (0..n).map(|i| -2.0 + 4.0 * i as f64 / (n - 1) as f64).collect()
    }

    #[test]
    fn a_paraboloid_is_cut_in_a_circle() {
        let axis = grid(81);
        let values: Vec<f64> = axis.iter().flat_map(|y| axis.iter().map(move |x| x * x + y * y)).collect();
        let (x, y) = contour(&axis, &axis, &values, 1.0);
        // One closed line, then the gap.
        assert_eq!(x.iter().filter(|x| x.is_nan()).count(), 1);
        assert!((x[0] - x[x.len() - 2]).abs() < 1e-12 && (y[0] - y[y.len() - 2]).abs() < 1e-12);
        // Linear mixing in steps of h = 0.05 puts x^2 + y^2 at most h^2 / 4 below the level.
        let radii = x.iter().zip(&y).filter(|(x, _)| !x.is_nan()).map(|(x, y)| x * x + y * y);
        radii.for_each(|square| assert!((1.0 - 0.05 * 0.05 / 4.0 - 1e-12..=1.0 + 1e-12).contains(&square)));
        let length: f64 = x
            .windows(2)
            .zip(y.windows(2))
            .map(|(x, y)| (x[1] - x[0]).hypot(y[1] - y[0]))
            .filter(|length| !length.is_nan())
            .sum();
        assert!((length - std::f64::consts::TAU).abs() < 0.01, "{length}");
    }

    #[test]
    fn a_saddle_gives_two_lines_and_a_slope_one() {
        let corners = [0.0, 1.0, 1.0, 0.0]; // low on one diagonal
        let (x, _) = contour(&[0.0, 1.0], &[0.0, 1.0], &corners, 0.4);
        assert_eq!(x.iter().filter(|x| x.is_nan()).count(), 2);
        let slope = [0.0, 0.0, f64::INFINITY, 2.0];
        let (x, y) = contour(&[0.0, 1.0], &[0.0, 1.0], &slope, 1.0);
        assert_eq!((x.len(), y[..2].to_vec()), (3, vec![0.0, 0.5]));
    }

    #[test]
    fn cells_without_numbers_and_flat_grids_have_no_line() {
        assert!(contour(&[0.0, 1.0], &[0.0, 1.0], &[0.0, f64::NAN, 1.0, 1.0], 0.5).0.is_empty());
        assert!(contour(&[0.0, 1.0], &[0.0, 1.0], &[1.0; 4], 1.0).0.is_empty());
        assert!(contour(&[], &[1.0], &[], 1.0).0.is_empty());
    }
}
