//! Values on a regular grid of the unit square that depend on further parameters, and the mapping that flattens them.
//!
//! A grid is bilinear within its cells and linear in its parameters, which are held beyond their ends. Where the values are a density,
//! [`Warp`] is the mapping that makes it from a flat one: first y by the marginal density, then x by the conditional one.
//!
//! # Source
//! Dupuy, Jakob 2018, *An adaptive parameterization for efficient material acquisition and rendering*, DOI 10.1145/3272127.3275059; the
//! order of operations is that of `Marginal2D` in Mitsuba 3.

/// Cell and place in it along one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Between {
    /// Number of the lower node.
    pub(super) low: usize,
    /// Number of the upper node; the lower one where there is one node only.
    pub(super) high: usize,
    /// Share of the upper node, 0 to 1.
    pub(super) share: f64,
}

impl Between {
    /// Of a value among ascending nodes; beyond their ends it is held. At least one node.
    pub(super) fn of(nodes: &[f32], value: f64) -> Self {
        if nodes.len() < 2 {
            return Self { low: 0, high: 0, share: 0.0 };
        }
        let low = nodes.partition_point(|node| f64::from(*node) < value).saturating_sub(1).min(nodes.len() - 2);
        let [first, second] = [low, low + 1].map(|node| nodes.get(node).copied().map_or(0.0, f64::from));
        let share = ((value - first) / (second - first)).clamp(0.0, 1.0);
        Self { low, high: low + 1, share }
    }

    /// Of a place from 0 to 1 among `nodes` regular nodes, at least two.
    pub(super) fn regular(nodes: usize, place: f64) -> Self {
        #[allow(clippy::cast_precision_loss, reason = "a grid has fewer than 2^53 nodes")]
        let scaled = place.clamp(0.0, 1.0) * (nodes - 1) as f64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to nodes - 1")]
        let low = (scaled as usize).min(nodes.saturating_sub(2));
        #[allow(clippy::cast_precision_loss, reason = "a grid has fewer than 2^53 nodes")]
        let share = scaled - low as f64;
        Self { low, high: low + 1, share }
    }

    /// Both nodes with their shares.
    pub(super) fn both(self) -> [(usize, f64); 2] {
        [(self.low, 1.0 - self.share), (self.high, self.share)]
    }
}

/// A place in a stack of equal grids: the four slices about it with their shares.
pub(super) type Slices = [(usize, f64); 4];

/// The slices about a place in two parameters; `inner` counts the nodes of the second.
pub(super) fn slices(first: Between, second: Between, inner: usize) -> Slices {
    let [(a, of_a), (b, of_b)] = first.both();
    let [(c, of_c), (d, of_d)] = second.both();
    [
        (a * inner + c, of_a * of_c),
        (a * inner + d, of_a * of_d),
        (b * inner + c, of_b * of_c),
        (b * inner + d, of_b * of_d),
    ]
}

/// Linear in the slices: the value at `index` of each.
fn mixed(values: &[f32], length: usize, slices: &Slices, index: usize) -> f64 {
    let one = |&(slice, share): &(usize, f64)| {
        if share > 0.0 { share * values.get(slice * length + index).copied().map_or(0.0, f64::from) } else { 0.0 }
    };
    slices.iter().map(one).sum()
}

fn lerp(low: f64, high: f64, share: f64) -> f64 {
    low * (1.0 - share) + high * share
}

/// Bilinear value of one grid at `(x, y)`.
///
/// # Shape
/// `values: [height, width]`, both at least 2.
pub(super) fn bilinear(values: &[f32], [height, width]: [usize; 2], [x, y]: [f64; 2]) -> f64 {
    let (x, y) = (Between::regular(width, x), Between::regular(height, y));
    let at = |row: usize, column: usize| values.get(row * width + column).copied().map_or(0.0, f64::from);
    lerp(
        lerp(at(y.low, x.low), at(y.low, x.high), x.share),
        lerp(at(y.high, x.low), at(y.high, x.high), x.share),
        y.share,
    )
}

/// The mapping from a flat density to that of the values, and its inverse.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Warp {
    height: usize,
    width: usize,
    /// Densities, each slice with the integral 1.
    values: Vec<f32>,
    /// Integrals along x up to each node but the first.
    conditional: Vec<f32>,
    /// Integrals over y up to each node but the first.
    marginal: Vec<f32>,
}

impl Warp {
    /// Of densities of at least 0; a slice of nothing maps to (0, 0).
    ///
    /// # Shape
    /// `values: [slice, height, width]`, height and width at least 2.
    #[allow(clippy::cast_possible_truncation, reason = "tables in single precision, as the renderers hold them")]
    #[allow(clippy::cast_precision_loss, reason = "grids have fewer than 2^53 nodes")]
    pub(super) fn new(values: &[f32], [height, width]: [usize; 2]) -> Self {
        let slices = values.len() / (height * width);
        let mut warp = Self {
            height,
            width,
            values: Vec::with_capacity(values.len()),
            conditional: Vec::with_capacity(slices * height * (width - 1)),
            marginal: Vec::with_capacity(slices * (height - 1)),
        };
        let [half_x, half_y] = [width, height].map(|nodes| 0.5 / (nodes - 1) as f64);
        for slice in values.chunks_exact(height * width) {
            // In double precision up to the norm: that of tiny densities is more than single precision holds.
            let (mut conditional, mut marginal) =
                (Vec::with_capacity(height * (width - 1)), Vec::with_capacity(height - 1));
            let mut sums = Vec::with_capacity(height);
            for row in slice.chunks_exact(width) {
                let mut sum = 0.0;
                for (left, right) in row.iter().zip(row.iter().skip(1)) {
                    sum += half_x * (f64::from(*left) + f64::from(*right));
                    conditional.push(sum);
                }
                sums.push(sum);
            }
            let mut sum = 0.0;
            for (low, high) in sums.iter().zip(sums.iter().skip(1)) {
                sum += half_y * (low + high);
                marginal.push(sum);
            }
            let norm = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            warp.conditional.extend(conditional.iter().map(|value| (value * norm) as f32));
            warp.marginal.extend(marginal.iter().map(|value| (value * norm) as f32));
            warp.values.extend(slice.iter().map(|value| (f64::from(*value) * norm) as f32));
        }
        warp
    }

    /// Where `(x, y)` comes from.
    pub(super) fn inverse(&self, [x, y]: [f64; 2], slices: &Slices) -> [f64; 2] {
        let (cells, size) = (self.width - 1, self.height * self.width);
        let (x, y) = (Between::regular(self.width, x), Between::regular(self.height, y));
        let value = |row: usize, column: usize| mixed(&self.values, size, slices, row * self.width + column);
        // The integral along x up to a node, in the two rows about y.
        let up_to = |row: usize, column: usize| match column {
            0 => 0.0,
            column => mixed(&self.conditional, self.height * cells, slices, row * cells + column - 1),
        };
        let column = |column| lerp(value(y.low, column), value(y.high, column), y.share);
        #[allow(clippy::cast_precision_loss, reason = "grids have fewer than 2^53 nodes")]
        let segment =
            |place: f64, cells: usize, low: f64, high: f64| place * lerp(low, high, 0.5 * place) / cells as f64;
        let along = segment(x.share, cells, column(x.low), column(x.high))
            + lerp(up_to(y.low, x.low), up_to(y.high, x.low), y.share);
        let [low, high] = [y.low, y.high].map(|row| up_to(row, cells));
        let whole = lerp(low, high, y.share);
        let below = match y.low {
            0 => 0.0,
            row => mixed(&self.marginal, self.height - 1, slices, row - 1),
        };
        let upwards = segment(y.share, self.height - 1, low, high) + below;
        // Where there is no density every x is as good.
        [if whole > 0.0 { along / whole } else { 0.0 }, upwards]
    }

    /// Where the place `(x, y)` of the flat density comes to lie in one slice, and the density there.
    pub(super) fn forward(&self, [x, y]: [f64; 2], slice: usize) -> ([f64; 2], f64) {
        let at = |values: &[f32], index: usize| values.get(index).copied().map_or(0.0, f64::from);
        let cells = [self.width - 1, self.height - 1];
        let up_to = |row: usize, column: usize| match column {
            0 => 0.0,
            column => at(&self.conditional, (slice * self.height + row) * cells[0] + column - 1),
        };
        let below = |row: usize| if row == 0 { 0.0 } else { at(&self.marginal, slice * cells[1] + row - 1) };
        let rows = Cell::of(y * below(cells[1]), cells[1], below, |row| up_to(row, cells[0]));
        let across = |of: &dyn Fn(usize) -> f64| lerp(of(rows.index), of(rows.index + 1), rows.share);
        let up_to = |column: usize| across(&|row| up_to(row, column));
        let value = |column: usize| across(&|row| at(&self.values, (slice * self.height + row) * self.width + column));
        let columns = Cell::of(x * up_to(cells[0]), cells[0], up_to, value);
        let density = lerp(value(columns.index), value(columns.index + 1), columns.share);
        ([columns.place(cells[0]), rows.place(cells[1])], density)
    }
}

/// A place among even nodes.
struct Cell {
    index: usize,
    share: f64,
}

impl Cell {
    /// Where the integral of a density that is linear in cells reaches a value.
    ///
    /// - `target`: the value; `up_to(node)`: the integral from the first node to this one; `density(node)`.
    fn of(target: f64, cells: usize, up_to: impl Fn(usize) -> f64, density: impl Fn(usize) -> f64) -> Self {
        // The first cell whose upper end reaches the target; so a target of 0 stays at the first node.
        let (mut low, mut high) = (0, cells - 1);
        while low < high {
            let middle = low.midpoint(high);
            if up_to(middle + 1) < target { low = middle + 1 } else { high = middle }
        }
        let (left, right) = (density(low), density(low + 1));
        #[allow(clippy::cast_precision_loss, reason = "grids have fewer than 2^53 nodes")]
        let rest = (target - up_to(low)).max(0.0) * cells as f64;
        // left t + (right - left) t^2 / 2 = rest, in the form that has no difference of near numbers.
        let root = (left * left + 2.0 * (right - left) * rest).max(0.0).sqrt();
        let share = if left + root > 0.0 { (2.0 * rest / (left + root)).clamp(0.0, 1.0) } else { 0.0 };
        Self { index: low, share }
    }

    #[allow(clippy::cast_precision_loss, reason = "grids have fewer than 2^53 nodes")]
    fn place(&self, cells: usize) -> f64 {
        (self.index as f64 + self.share) / cells as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Slices = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];

    #[test]
    fn a_flat_density_maps_to_itself() {
        let warp = Warp::new(&[3.0; 20], [4, 5]);
        for place in [[0.0, 0.0], [0.3, 0.7], [1.0, 1.0], [0.25, 1.0 / 3.0]] {
            let found = warp.inverse(place, &ALONE);
            assert!(found.iter().zip(place).all(|(found, place)| (found - place).abs() < 1e-6), "{found:?}");
        }
    }

    /// The density 4 x y on the unit square: its mapping is the square root of either coordinate, the inverse their squares.
    #[test]
    fn a_product_of_slopes_maps_to_squares() {
        let values: Vec<f32> = (0..9_u8).flat_map(|y| (0..5_u8).map(move |x| f32::from(x) * f32::from(y))).collect();
        let warp = Warp::new(&values, [9, 5]);
        for place in [[0.2_f64, 0.9_f64], [0.77, 0.31], [1.0, 1.0], [0.5, 0.5]] {
            let found = warp.inverse(place, &ALONE);
            let expected = place.map(|place| place * place);
            assert!(found.iter().zip(expected).all(|(found, place)| (found - place).abs() < 1e-6), "{found:?}");
        }
    }

    /// Where the inverse finds a place, the mapping came from: of a density with a dark corner, in the second of two slices.
    #[test]
    fn the_mapping_is_undone_by_its_inverse() {
        let second = [1.0, 2.0, 0.0, 0.0, 0.5, 3.0, 1.0, 0.0, 0.0, 1.0, 4.0, 1.0_f32];
        let values = [[1.0; 12], second].concat();
        let warp = Warp::new(&values, [3, 4]);
        let alone = [(1, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        for place in [[0.1, 0.2], [0.9, 0.1], [0.5, 0.5], [0.3, 0.99], [0.75, 0.6], [1.0, 0.7], [0.0, 0.4]] {
            let (there, density) = warp.forward(place, 1);
            let back = warp.inverse(there, &alone);
            assert!(back.iter().zip(place).all(|(back, place)| (back - place).abs() < 1e-6), "{place:?} {back:?}");
            // The density of the mapping, by areas: 1 over how much a small square grows.
            let step = 1e-4;
            if place.iter().all(|place| (0.05..0.95).contains(place)) {
                let [right, up] =
                    [[step, 0.0], [0.0, step]].map(|[x, y]| warp.forward([place[0] + x, place[1] + y], 1).0);
                let area = (right[0] - there[0]) * (up[1] - there[1]) - (right[1] - there[1]) * (up[0] - there[0]);
                assert!((step * step / area / density - 1.0).abs() < 2e-3, "{place:?}: {density}");
            }
        }
        // Behind the end of the light there is no place to come from.
        assert!(warp.forward([1.0, 0.0], 1).0[0] < 0.7);
    }

    #[test]
    fn a_density_of_nothing_is_no_division_by_zero() {
        let warp = Warp::new(&[0.0; 4], [2, 2]);
        let (place, density) = warp.forward([0.5, 0.5], 0);
        let found = warp.inverse([0.5, 0.5], &ALONE).into_iter().chain(place).chain([density]);
        assert!(found.into_iter().all(f64::is_finite));
    }

    #[test]
    fn tiny_densities_map_as_large_ones() {
        // A norm of 1e39 is infinite in single precision.
        for density in [1e-39_f32, 1.0] {
            let found = Warp::new(&[density; 20], [4, 5]).inverse([0.3, 0.7], &ALONE);
            assert!((found[0] - 0.3).abs() < 1e-6 && (found[1] - 0.7).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn values_are_held_beyond_the_ends() {
        let nodes = [1.0, 2.0, 4.0];
        let place = |value| {
            let between = Between::of(&nodes, value);
            between.both().map(|(node, share)| share * f64::from(nodes[node])).iter().sum::<f64>()
        };
        for (value, expected) in [(0.0, 1.0), (1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (3.5, 3.5), (9.0, 4.0)] {
            assert!((place(value) - expected).abs() < 1e-12, "{value}");
        }
    }
}
