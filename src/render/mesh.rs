//! The relief as a mesh, for renderers that have no map of heights.

use super::error::RenderError;
use super::maps::{Slopes, neighbours};
use super::raster::Raster;
use super::scene::HALF_SIDE;
use rayon::prelude::*;

/// Vertices along a side at most: 4 million of them, 240 MB with their triangles.
const MOST: usize = 2048;

/// A grid of vertices over the square, displaced along z.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Position, unit normal, and place in the maps: u to the right and v downwards, 0 to 1; row by row from the
    /// upper left.
    pub vertices: Vec<[f32; 8]>,
    /// Vertices of each triangle, counterclockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The mesh with `side` vertices along each side; two where the map is even, which is a plain square.
    ///
    /// ```text
    /// z = 2 · relief · (level(x, y) − mean level),   n ∝ (−∂z/∂x, −∂z/∂y, 1)
    /// ```
    ///
    /// Heights and slopes are those of [`Surface`](super::Surface), linear between the pixels; their mean lies in the plane of the
    /// square. Lengths are in half sides.
    ///
    /// - `relief`: height of a displacement of 1, in sides of the square.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for a relief beyond -1 to 1 and for fewer than 2 vertices along a side, or more than 2048.
    ///
    /// ```
    /// use morpho_fit::render::{Mesh, Raster};
    /// let step = Raster::new(2, 2, 1, vec![0.0, 1.0, 0.0, 1.0])?;
    /// let mesh = Mesh::new(&step, 0.1, 3)?;
    /// assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (9, 8));
    /// let [x, y, z, across, .., u, v] = mesh.vertices[2];
    /// assert_eq!((x, y, u, v), (1.0, 1.0, 1.0, 0.0));
    /// assert!((z - 0.1).abs() < 1e-6 && across < 0.0, "upper right, half of 2 · 0.1 above the mean; leans to the left");
    /// # Ok::<(), morpho_fit::render::RenderError>(())
    /// ```
    pub fn new(height: &Raster, relief: f64, side: usize) -> Result<Self, RenderError> {
        if !(-1.0..=1.0).contains(&relief) {
            let quantity = "the relief, in sides of the square,";
            return Err(RenderError::OutOfRange { quantity, found: relief, allowed: "-1 to 1" });
        }
        if !(2..=MOST).contains(&side) {
            let quantity = "the vertices along a side of the mesh";
            return Err(RenderError::OutOfRange { quantity, found: whole(side), allowed: "2 to 2048" });
        }
        let relief = Relief::new(height, relief);
        let side = if relief.is_even { 2 } else { side };
        let row = |row: usize| (0..side).map(move |column| (share(column, side), share(row, side)));
        let vertices = (0..side).into_par_iter().flat_map_iter(row).map(|(u, v)| relief.vertex(u, v)).collect();
        let corner = |column: usize, row: usize| u32::try_from(row * side + column).unwrap_or(u32::MAX);
        let mut triangles = Vec::with_capacity(2 * (side - 1) * (side - 1));
        for row in 0..side - 1 {
            for column in 0..side - 1 {
                let (left, right) = (corner(column, row), corner(column + 1, row));
                let (below, opposite) = (corner(column, row + 1), corner(column + 1, row + 1));
                triangles.extend([[below, opposite, right], [below, right, left]]);
            }
        }
        Ok(Self { vertices, triangles })
    }
}

/// Heights and slopes at any place.
struct Relief<'a> {
    height: &'a Raster,
    slopes: Slopes<'a>,
    /// Height of a displacement of 1, half sides.
    scale: f64,
    mean: f64,
    is_even: bool,
}

impl<'a> Relief<'a> {
    fn new(height: &'a Raster, relief: f64) -> Self {
        let (columns, rows) = (height.width(), height.height());
        let level = |pixel: usize| height.grey(pixel % columns, pixel / columns);
        let levels = || (0..columns * rows).map(level);
        let mean = levels().map(f64::from).sum::<f64>() / whole(columns * rows);
        #[allow(clippy::float_cmp, reason = "levels of a map, the same or not")]
        let is_even = levels().all(|other| other == level(0)) || relief == 0.0;
        Self { height, slopes: Slopes::new(height, relief), scale: 2.0 * HALF_SIDE * relief, mean, is_even }
    }

    fn vertex(&self, u: f64, v: f64) -> [f32; 8] {
        let (left, right, across) = neighbours(u * whole(self.height.width()) - 0.5, self.height.width());
        let (upper, lower, down) = neighbours(v * whole(self.height.height()) - 0.5, self.height.height());
        let corners = [
            (left, upper, (1.0 - across) * (1.0 - down)),
            (right, upper, across * (1.0 - down)),
            (left, lower, (1.0 - across) * down),
            (right, lower, across * down),
        ];
        let (mut level, mut slope) = (0.0, [0.0; 2]);
        for (column, row, share) in corners {
            let share = f64::from(share);
            level += share * f64::from(self.height.grey(column, row));
            let [x, y] = self.slopes.at(column, row);
            slope[0] += share * f64::from(x);
            slope[1] += share * f64::from(y);
        }
        let z = if self.is_even { 0.0 } else { self.scale * (level - self.mean) };
        let upright = (slope[0] * slope[0] + slope[1] * slope[1] + 1.0).sqrt().recip();
        let place = |part: f64| HALF_SIDE * (2.0 * part - 1.0);
        let vertex = [place(u), -place(v), z, -slope[0] * upright, -slope[1] * upright, upright, u, v];
        #[allow(clippy::cast_possible_truncation, reason = "meshes are in single precision")]
        vertex.map(|value| value as f32)
    }
}

/// Place of a vertex along a side, 0 to 1.
fn share(index: usize, side: usize) -> f64 {
    whole(index) / whole(side - 1)
}

#[allow(clippy::cast_precision_loss, reason = "pixels and vertices")]
fn whole(count: usize) -> f64 {
    count as f64
}
