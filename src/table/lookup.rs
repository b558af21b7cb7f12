//! A filled table, and its value anywhere between the nodes.

use super::error::TableError;
use super::nodes::Nodes;
use super::source::Source;
use std::f64::consts::FRAC_PI_2;

/// Intervals of even width for each interval of an axis: more of them save steps to the right one.
const BUCKETS: usize = 2;
/// Share of the ends' distance by which rounding may put an angle past an end.
const ROUNDING: f64 = 1e-9;

/// One axis, prepared so that an interval is found at once.
#[derive(Debug, Clone, PartialEq)]
struct Axis {
    at: Vec<f64>,
    /// The last node that is not above the start of each of the even intervals.
    first: Vec<u32>,
    scale: f64,
    slack: f64,
}

impl Axis {
    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "a count of nodes is below 2^32")]
    fn new(at: Vec<f64>) -> Self {
        let count = BUCKETS * at.len();
        let (low, high) = (at.first().copied().unwrap_or(0.0), at.last().copied().unwrap_or(0.0));
        let width = (high - low) / count as f64;
        let last = at.len().saturating_sub(2);
        let first = |bucket: usize| {
            let start = low + bucket as f64 * width;
            at.partition_point(|node| *node <= start).saturating_sub(1).min(last) as u32
        };
        let first = (0..=count).map(first).collect();
        let scale = if width > 0.0 { width.recip() } else { 0.0 };
        Self { at, first, scale, slack: ROUNDING * (high - low).max(1.0) }
    }

    /// The node below, and the share of the one above; `None` outside.
    #[inline]
    fn place(&self, value: f64) -> Option<(usize, f64)> {
        let (&low, &high) = (self.at.first()?, self.at.last()?);
        if !(low - self.slack..=high + self.slack).contains(&value) {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates")]
        let bucket = ((value - low) * self.scale) as usize;
        // Rounding may have put the start of a bucket above the value: one back.
        let mut below = (*self.first.get(bucket.min(self.first.len() - 1))? as usize).saturating_sub(1);
        while below + 2 < self.at.len() && value >= *self.at.get(below + 1)? {
            below += 1;
        }
        let Some(&above) = self.at.get(below + 1) else { return Some((0, 0.0)) };
        let start = *self.at.get(below)?;
        Some((below, ((value - start) / (above - start)).clamp(0.0, 1.0)))
    }
}

/// Values at nodes in single precision, and between them linear in each coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    nodes: Nodes,
    axes: [Axis; 3],
    channels: usize,
    values: Vec<f32>,
}

impl Table {
    /// The table of `source` at `nodes`.
    ///
    /// # Errors
    /// As [`Source::fill`].
    ///
    /// ```
    /// use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
    /// use morpho_fit::geometry::Polarization;
    /// use morpho_fit::optics::{BlendModel, Structure};
    /// use morpho_fit::spectrum::Wavelengths;
    /// use morpho_fit::table::{Across, Nodes, Quantity, Source, Table, Turn};
    ///
    /// let (model, grid) = (BlendModel::default(), Wavelengths::paper());
    /// let weights = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?.relative_weights();
    /// let wavelengths: Vec<f64> = grid.iter().collect();
    /// let source =
    ///     Source::new(&model, &Structure::table1(), Polarization::Unpolarized, &wavelengths, Quantity::Colour(weights))?;
    /// let angles: Vec<f64> = (-10..=10).map(|step| 0.1 * f64::from(step)).collect();
    /// let nodes = Nodes::new(vec![0.0, 0.1], angles, vec![0.0, 1.5], Across::Mirror, Turn::Share)?;
    /// let table = Table::new(&source, nodes)?;
    /// let along = table.colour(0.05, -0.05, 1.5).unwrap();
    /// assert!(along[1] > 0.7 && along[2] < 0.3); // yellow: little Z
    /// assert!(table.colour(0.05, -0.05, 1.55).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(source: &Source<'_>, nodes: Nodes) -> Result<Self, TableError> {
        let mut values = vec![0.0; nodes.count() * source.channels()];
        source.fill(&nodes, &mut values)?;
        #[allow(clippy::cast_possible_truncation, reason = "a table is in single precision")]
        let values = values.into_iter().map(|value| value as f32).collect();
        let turn = nodes.turn();
        let planes = nodes.omega().iter().map(|&omega| turn.of(omega)).collect();
        let axes = [nodes.theta().to_vec(), nodes.across().to_vec(), planes].map(Axis::new);
        Ok(Self { nodes, axes, channels: source.channels(), values })
    }

    /// The nodes.
    #[must_use]
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// Values at one node: 3 of a colour, or one for each wavelength.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// All values.
    ///
    /// # Shape
    /// `[theta][across][omega][channel]`.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Bytes of the values.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// The colour of a direction (rad); `None` outside the table, or of a table of spectra.
    #[must_use]
    #[inline]
    pub fn colour(&self, theta: f64, phi: f64, omega: f64) -> Option<[f64; 3]> {
        let mut colour = [0.0; 3];
        (self.channels == 3 && self.look_up(theta, phi, omega, &mut colour)).then_some(colour)
    }

    /// The values of a direction (rad) into `out`; false outside the table, for a view below the horizon, or if `out` is not as long as a node has values.
    #[inline]
    pub fn look_up(&self, theta: f64, phi: f64, omega: f64, out: &mut [f64]) -> bool {
        let at = [theta, self.nodes.kind().of(theta, phi), self.nodes.turn().of(omega)];
        let [Some((row, down)), Some((column, across)), Some((plane, turn))] =
            [0, 1, 2].map(|axis| self.axes[axis].place(at[axis]))
        else {
            return false;
        };
        if out.len() != self.channels || phi.abs() > FRAC_PI_2 * (1.0 + 1e-12) {
            return false;
        }
        let [_, columns, planes] = self.axes.each_ref().map(|axis| axis.at.len());
        let run = self.channels;
        let (to_plane, to_column, to_row) =
            (if planes > 1 { run } else { 0 }, if columns > 1 { planes * run } else { 0 }, columns * planes * run);
        let to_row = if self.axes[0].at.len() > 1 { to_row } else { 0 };
        let first = ((row * columns + column) * planes + plane) * run;
        out.fill(0.0);
        for (start, share) in [(first, 1.0 - down), (first + to_row, down)] {
            for (start, share) in [(start, share * (1.0 - across)), (start + to_column, share * across)] {
                for (start, share) in [(start, share * (1.0 - turn)), (start + to_plane, share * turn)] {
                    let Some(values) = self.values.get(start..start + run) else { return false };
                    for (out, value) in out.iter_mut().zip(values) {
                        *out += share * f64::from(*value);
                    }
                }
            }
        }
        true
    }
}
