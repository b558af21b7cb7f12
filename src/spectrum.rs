//! The wavelengths at which a spectrum is given: a regular grid in nanometres.

/// More points than any spectrum needs; a mistyped step ends here and not in the memory.
const MAX_POINTS: f64 = 100_000.0;
/// A last point that rounding put past the end by this share of a step still belongs to the grid.
const ROUNDING: f64 = 1e-9;

/// A grid that is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectrumError {
    /// An end or the step is not a finite number above 0.
    #[error("the {quantity} is {found} nm; it must be a number above 0")]
    OutOfRange {
        /// `first wavelength`, `last wavelength` or `step`.
        quantity: &'static str,
        /// What was given, nm.
        found: f64,
    },
    /// The grid ends where it begins, or before.
    #[error("the first wavelength, {first} nm, must be below the last, {last} nm")]
    NoRange {
        /// First wavelength, nm.
        first: f64,
        /// Last wavelength, nm.
        last: f64,
    },
    /// More points than a grid may have.
    #[error("a step of {step} nm makes more than {MAX_POINTS} wavelengths")]
    TooMany {
        /// What was given, nm.
        step: f64,
    },
}

/// `first, first + step, ...` up to `last`, in nm.
///
/// ```
/// use morpho_fit::spectrum::Wavelengths;
/// let grid = Wavelengths::new(400.0, 700.0, 50.0)?;
/// assert_eq!(grid.iter().collect::<Vec<_>>(), [400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0]);
/// # Ok::<(), morpho_fit::spectrum::SpectrumError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wavelengths {
    first: f64,
    step: f64,
    points: usize,
}

impl Wavelengths {
    /// From `first` to `last` by `step`, nm. Where `step` does not divide the range, the last point is below `last`.
    ///
    /// # Errors
    /// [`SpectrumError`] if a number is not finite and above 0, if `first` is not below `last`, or if there would be
    /// more than 100,000 points.
    pub fn new(first: f64, last: f64, step: f64) -> Result<Self, SpectrumError> {
        for (quantity, found) in [("first wavelength", first), ("last wavelength", last), ("step", step)] {
            if !(found.is_finite() && found > 0.0) {
                return Err(SpectrumError::OutOfRange { quantity, found });
            }
        }
        if first >= last {
            return Err(SpectrumError::NoRange { first, last });
        }
        let steps = ((last - first) / step + ROUNDING).floor();
        if steps >= MAX_POINTS {
            return Err(SpectrumError::TooMany { step });
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 100,000")]
        Ok(Self { first, step, points: steps as usize + 1 })
    }

    /// The grid of Iwasawa, Shichijo and Kawaguchi: 380 to 740 nm by 10 nm, 37 points.
    ///
    /// ```
    /// use morpho_fit::spectrum::Wavelengths;
    /// assert_eq!((Wavelengths::paper().len(), Wavelengths::paper().last()), (37, 740.0));
    /// ```
    #[must_use]
    pub fn paper() -> Self {
        Self { first: 380.0, step: 10.0, points: 37 }
    }

    /// 380 to 780 nm by 1 nm, 401 points: the reference that coarser grids are held against.
    #[must_use]
    pub fn finest() -> Self {
        Self { first: 380.0, step: 1.0, points: 401 }
    }

    /// 380 to 780 nm by `step` nm: what eyes see, and the range of the daylight table.
    ///
    /// # Errors
    /// As [`Wavelengths::new`].
    pub fn visible(step: f64) -> Result<Self, SpectrumError> {
        Self::new(380.0, 780.0, step)
    }

    /// Number of points, at least 1.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "no grid is empty")]
    pub fn len(&self) -> usize {
        self.points
    }

    /// Point `index` counted from 0, nm; past the end the grid goes on.
    #[must_use]
    pub fn at(&self, index: usize) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "a grid has at most 100,000 points")]
        let steps = index as f64;
        self.first + steps * self.step
    }

    /// All points from the first, nm.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f64> + Clone + use<> {
        let grid = *self;
        (0..self.points).map(move |index| grid.at(index))
    }

    /// Distance of neighbours, nm.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// First point, nm.
    #[must_use]
    pub fn first(&self) -> f64 {
        self.first
    }

    /// Last point, nm.
    #[must_use]
    pub fn last(&self) -> f64 {
        self.at(self.points - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_binary_fractions_cannot_hold_still_reaches_the_end() {
        for (step, points) in [(0.1, 4001), (0.3, 1334), (1.0, 401), (5.0, 81), (7.0, 58)] {
            let grid = Wavelengths::visible(step).unwrap();
            assert_eq!(grid.len(), points, "{step}");
            assert_eq!(grid.iter().len(), points);
            assert!(grid.last() <= 780.0 + 1e-9 && grid.last() > 780.0 - step, "{step}: {}", grid.last());
        }
    }

    #[test]
    fn the_paper_grid_is_the_same_either_way() {
        assert_eq!(Wavelengths::paper(), Wavelengths::new(380.0, 740.0, 10.0).unwrap());
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        for bad in [f64::NAN, f64::INFINITY, 0.0, -5.0] {
            assert!(matches!(Wavelengths::new(bad, 700.0, 1.0), Err(SpectrumError::OutOfRange { .. })));
            assert!(matches!(Wavelengths::new(400.0, bad, 1.0), Err(SpectrumError::OutOfRange { .. })));
            assert!(matches!(Wavelengths::new(400.0, 700.0, bad), Err(SpectrumError::OutOfRange { .. })));
        }
        assert!(matches!(Wavelengths::new(700.0, 700.0, 1.0), Err(SpectrumError::NoRange { .. })));
        assert!(matches!(Wavelengths::new(700.0, 400.0, 1.0), Err(SpectrumError::NoRange { .. })));
        assert_eq!(Wavelengths::new(400.0, 700.0, 1e-300), Err(SpectrumError::TooMany { step: 1e-300 }));
        let message = Wavelengths::new(400.0, 700.0, 0.001).unwrap_err().to_string();
        assert_eq!(message, "a step of 0.001 nm makes more than 100000 wavelengths");
    }
}
