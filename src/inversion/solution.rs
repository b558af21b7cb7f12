//! What the search left: the minima, what the data do not determine, and the weights of the readings.

use crate::inversion::space::Space;
use crate::inversion::undetermined::Held;
use crate::optimise::Minimum;

/// The minima of one data set, in inside units.
#[derive(Debug, Clone)]
pub(crate) struct Solution {
    /// The space that was searched.
    pub(crate) searched: Space,
    /// What was left of it when the undetermined parameters were taken out.
    pub(crate) space: Space,
    /// The best point of `space`.
    pub(crate) best: Minimum,
    /// Distinct minima of `searched`, best first; at least one.
    pub(crate) minima: Vec<Minimum>,
    /// What was taken out.
    pub(crate) held: Vec<Held>,
    /// What ended on a bound; see [`Undetermined::stopped`](crate::inversion::undetermined::Undetermined).
    pub(crate) stopped: Vec<Held>,
    /// Square roots of the weights of a robust loss; empty for none.
    pub(crate) robust: Vec<f64>,
    /// Weighted residual that counts as one standard deviation in the robust loss.
    pub(crate) robust_unit: f64,
    /// Standard deviation of a weighted residual, widened where the model misses the data.
    pub(crate) unit: f64,
}

impl Solution {
    /// The parameters, held or on a bound, along which others may move.
    pub(crate) fn open(&self) -> impl Iterator<Item = &Held> {
        self.held.iter().chain(&self.stopped)
    }
}
