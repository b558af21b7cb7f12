//! A box of allowed parameters.

use nalgebra::DVector;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Lower and upper bound of each parameter; infinite where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    lower: DVector<f64>,
    upper: DVector<f64>,
}

/// Two vectors that do not bound a box.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundsError {
    /// One lower bound is not below its upper bound, or one of them is NaN.
    #[error("parameter {index}: the lower bound {lower} is not below the upper bound {upper}")]
    Empty {
        /// Which parameter, from 0.
        index: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// The two vectors differ in length.
    #[error("{lower} lower bounds, but {upper} upper bounds")]
    Lengths {
        /// Number of lower bounds.
        lower: usize,
        /// Number of upper bounds.
        upper: usize,
    },
}

impl Bounds {
    /// The box `lower <= p <= upper`.
    ///
    /// # Errors
    /// [`BoundsError`] if a lower bound is not below its upper bound or the lengths differ.
    pub fn new(lower: &[f64], upper: &[f64]) -> Result<Self, BoundsError> {
        if lower.len() != upper.len() {
            return Err(BoundsError::Lengths { lower: lower.len(), upper: upper.len() });
        }
        for (index, (&lower, &upper)) in lower.iter().zip(upper).enumerate() {
            if lower.partial_cmp(&upper) != Some(std::cmp::Ordering::Less) {
                return Err(BoundsError::Empty { index, lower, upper });
            }
        }
        Ok(Self { lower: DVector::from_column_slice(lower), upper: DVector::from_column_slice(upper) })
    }

    /// No bounds on `count` parameters.
    #[must_use]
    pub fn none(count: usize) -> Self {
        Self {
            lower: DVector::from_element(count, f64::NEG_INFINITY),
            upper: DVector::from_element(count, f64::INFINITY),
        }
    }

    /// Lower bounds.
    #[must_use]
    pub fn lower(&self) -> &DVector<f64> {
        &self.lower
    }

    /// Upper bounds.
    #[must_use]
    pub fn upper(&self) -> &DVector<f64> {
        &self.upper
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lower.len()
    }

    /// Whether there are no parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lower.is_empty()
    }

    /// Whether `parameters` lie in the box, to the last bit; a NaN does not.
    #[must_use]
    pub fn contain(&self, parameters: &DVector<f64>) -> bool {
        parameters.len() == self.len()
            && parameters.iter().enumerate().all(|(j, value)| (self.lower[j]..=self.upper[j]).contains(value))
    }

    /// The nearest point of the box.
    #[must_use]
    pub fn clamp(&self, parameters: &DVector<f64>) -> DVector<f64> {
        DVector::from_fn(parameters.len(), |j, _| parameters[j].max(self.lower[j]).min(self.upper[j]))
    }

    /// `count` points of a Latin hypercube: each parameter has one point in each of `count` equal slices.
    ///
    /// # Seed
    /// The same seed gives the same points on every machine. Unbounded parameters must be bounded first: their points
    /// would not be finite.
    #[must_use]
    pub fn latin_hypercube(&self, count: usize, seed: u64) -> Vec<DVector<f64>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut points = vec![DVector::zeros(self.len()); count];
        let mut slices: Vec<usize> = (0..count).collect();
        for j in 0..self.len() {
            slices.shuffle(&mut random);
            for (point, &slice) in points.iter_mut().zip(&slices) {
                #[allow(clippy::cast_precision_loss, reason = "counts of starts are small")]
                let share = (slice as f64 + random.random::<f64>()) / count as f64;
                point[j] = self.lower[j] + share * (self.upper[j] - self.lower[j]);
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_without_room_is_refused() {
        assert!(Bounds::new(&[1.0], &[1.0]).is_err());
        assert!(Bounds::new(&[f64::NAN], &[1.0]).is_err());
        assert!(Bounds::new(&[0.0, 0.0], &[1.0]).is_err());
    }

    #[test]
    fn a_latin_hypercube_fills_each_slice_once_and_repeats() {
        let bounds = Bounds::new(&[-1.0, 10.0], &[1.0, 20.0]).unwrap();
        let points = bounds.latin_hypercube(8, 7);
        assert_eq!(points, bounds.latin_hypercube(8, 7));
        assert_ne!(points, bounds.latin_hypercube(8, 8));
        let mut slices: Vec<f64> = points.iter().map(|point| ((point[0] + 1.0) * 4.0).floor()).collect();
        slices.sort_by(f64::total_cmp);
        assert_eq!(slices, (0..8).map(f64::from).collect::<Vec<_>>());
        assert!(points.iter().all(|point| bounds.contain(point)));
    }
}
