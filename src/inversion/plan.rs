//! A data set compiled for one model, once, so that a fit computes nothing twice.
//!
//! ```text
//! unique (wavelength, theta, polarization)   reflectivity of the stack
//! unique (wavelength, theta, phi)            array and slit factor of the lamellae
//! unique (theta, phi)                        lobe
//! unique (wavelength, theta, phi, omega)     all but the stack, of a model that is one product
//! ```
//!
//! Each reading is then three indices and two shares ([`points`]). [`Terms`] holds the values at the unique points for one structure, in
//! parts that some parameters alone enter ([`terms`]).

mod model_held;
mod points;
mod seen;
mod terms;

use crate::dataset::{Dataset, Reading};
use crate::inversion::rows::Rows;
use crate::inversion::settings::Parts;
use crate::optics::{OpticsError, ReflectivityModel};
use model_held::ModelHeld;
pub(crate) use points::PlannedReading;
use points::Points;
use std::sync::Arc;
pub(crate) use terms::{LamellaSlopes, Terms, TermsView};

/// Readings that a thinned plan keeps of each curve, if it has them.
const LEAST_OF_A_CURVE: usize = 16;

/// Denominator and numerator of the golden ratio's fractional part: multiples of it are spread evenly.
const SPREAD: usize = 1 << 16;
const GOLDEN: usize = 40_503;

/// What multiplies the residual of a reading, `1 / sigma`, or 1 where the data have none; and its intensity.
fn weight_and_intensity(reading: &Reading) -> (f64, f64) {
    (reading.sigma.map_or(1.0, f64::recip), reading.intensity)
}

/// A data set compiled for one model. What its readings see of the model is shared by all that are made of it.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    model: ModelHeld<'a>,
    points: Arc<Points>,
    pub(crate) rows: Rows,
    pub(crate) curves: usize,
}

impl<'a> Plan<'a> {
    /// Compiles `data` for the `parts` of `model`.
    ///
    /// # Errors
    /// [`OpticsError`] if a medium has no valid index at a wavelength of the data, or the model cannot hold the media.
    pub fn new(data: &Dataset, model: &'a dyn ReflectivityModel, parts: Parts) -> Result<Self, OpticsError> {
        let all: Vec<usize> = (0..data.readings().len()).collect();
        Self::of_rows(data, model, parts, &all)
    }

    /// [`Plan::new`] for about `limit` readings of all.
    pub(crate) fn thinned(
        data: &Dataset,
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        limit: usize,
    ) -> Result<Self, OpticsError> {
        Self::of_rows(data, model, parts, &Self::thinned_rows(data, limit))
    }

    /// About `limit` rows of all, curve by curve: one from each run of neighbours in a curve; short curves are kept.
    ///
    /// Which one of a run is spread by the golden ratio: a fixed stride would take the same angles from each scan wherever
    /// it shares a factor with the length of a scan, and then the search sees none of the others.
    pub(crate) fn thinned_rows(data: &Dataset, limit: usize) -> Vec<usize> {
        let stride = data.readings().len().div_ceil(limit.max(1)).max(1);
        let mut curves: Vec<Vec<usize>> = vec![Vec::new(); data.curves().len()];
        for (row, reading) in data.readings().iter().enumerate() {
            curves[reading.curve].push(row);
        }
        let mut rows: Vec<usize> = Vec::new();
        for curve in &curves {
            let stride = stride.min(curve.len() / LEAST_OF_A_CURVE).max(1);
            let spread = |place: usize, run: &[usize]| run[place.wrapping_mul(GOLDEN) % SPREAD * run.len() / SPREAD];
            rows.extend(curve.chunks(stride).enumerate().map(|(place, run)| spread(place, run)));
        }
        rows
    }

    /// [`Plan::new`] for some rows of the data, in their order.
    pub(crate) fn of_rows(
        data: &Dataset,
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        rows: &[usize],
    ) -> Result<Self, OpticsError> {
        let chosen = rows.iter().map(|&row| &data.readings()[row]);
        Self::of_all(chosen, model, parts, data.curves().len())
    }

    /// [`Plan::new`] for readings of `curves` curves that are no data set.
    pub(crate) fn of_readings(
        readings: &[Reading],
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        curves: usize,
    ) -> Result<Self, OpticsError> {
        Self::of_all(readings.iter(), model, parts, curves)
    }

    fn of_all<'r>(
        readings: impl ExactSizeIterator<Item = &'r Reading> + Clone,
        model: &'a dyn ReflectivityModel,
        parts: Parts,
        curves: usize,
    ) -> Result<Self, OpticsError> {
        model.validate()?;
        let points = Arc::new(Points::new(readings.clone(), model, parts)?);
        let rows = Rows::of_data(readings.map(weight_and_intensity));
        Ok(Self { model: ModelHeld::Lent(model), points, rows, curves })
    }

    /// The readings as indices into what they see.
    pub(crate) fn readings(&self) -> &[PlannedReading] {
        &self.points.readings
    }

    /// Lays the readings out for arithmetic; `like` as in [`Rows::arrange`].
    pub(crate) fn arrange(&mut self, like: &[usize]) {
        self.rows.arrange(&self.points.readings, like);
    }

    /// The same design with other intensities, one for each reading.
    pub(crate) fn with_intensities(&self, intensities: &[f64]) -> Self {
        let rows = self.rows.with_data(self.rows.weights().iter().copied().zip(intensities.iter().copied()));
        Self { model: self.model.clone(), points: Arc::clone(&self.points), rows, curves: self.curves }
    }

    /// The same design with the intensities and sigmas of other readings.
    pub(crate) fn with_readings<'r>(&self, readings: impl ExactSizeIterator<Item = &'r Reading>) -> Self {
        let rows = self.rows.with_data(readings.map(weight_and_intensity));
        Self { model: self.model.clone(), points: Arc::clone(&self.points), rows, curves: self.curves }
    }
}
