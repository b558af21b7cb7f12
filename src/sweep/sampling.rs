//! How many wavelengths the colours of a scene need.

use crate::colorimetry::{ColourError, Illuminant, Integration, Lab, Observer};
use crate::spectrum::Wavelengths;

/// Steps that are tried, nm, the coarsest first: they divide the 400 nm of [`Wavelengths::visible`].
const STEPS: [usize; 8] = [20, 16, 10, 8, 5, 4, 2, 1];

/// A grid of wavelengths with the colour error that it was chosen for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// The grid.
    pub wavelengths: Wavelengths,
    /// Largest CIEDE2000 difference to the grid of 1 nm among the spectra that were compared; none if none were.
    pub difference: Option<f64>,
    /// How many spectra were compared.
    pub compared: usize,
    /// Largest difference between grids of 1 and 2 nm: where it is large, 1 nm may be too coarse as well.
    pub difference_of_two: Option<f64>,
}

impl Sampling {
    /// A grid that was asked for.
    #[must_use]
    pub fn given(wavelengths: Wavelengths) -> Self {
        Self { wavelengths, difference: None, compared: 0, difference_of_two: None }
    }

    /// The coarsest grid from 380 to 780 nm on which every one of `spectra` has the colour that it has on the grid of 1 nm,
    /// within `tolerance` of CIEDE2000, each against the white of its grid. Without spectra it is the grid of 1 nm.
    ///
    /// # Shape
    /// `spectra: [spectrum][401]`, by 1 nm.
    ///
    /// # Errors
    /// [`ColourError`] for a spectrum of another length or with a value that is not finite, and for a light that does not
    /// cover the range.
    ///
    /// ```
    /// use morpho_fit::colorimetry::{Illuminant, Observer};
    /// use morpho_fit::sweep::Sampling;
    /// let smooth: Vec<f64> = (380..=780).map(|nm| (-((f64::from(nm) - 550.0) / 60.0).powi(2)).exp()).collect();
    /// let found = Sampling::coarsest(&[smooth], Observer::Cie1931, &Illuminant::D65, 0.5)?;
    /// assert!(found.wavelengths.step() >= 10.0 && found.difference.unwrap() <= 0.5);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn coarsest(
        spectra: &[Vec<f64>],
        observer: Observer,
        illuminant: &Illuminant,
        tolerance: f64,
    ) -> Result<Self, ColourError> {
        let mut finest: Vec<Lab> = Vec::new();
        let mut chosen = None;
        let mut difference_of_two = None;
        // From the finest: as the step grows a chance agreement beyond a coarser failure is not taken.
        for step in STEPS.into_iter().rev() {
            #[allow(clippy::cast_precision_loss, reason = "at most 20")]
            let Ok(wavelengths) = Wavelengths::visible(step as f64) else { break };
            let integration = Integration::new(&wavelengths, observer, illuminant)?;
            let white = integration.white();
            let of = |spectrum: &Vec<f64>| {
                let thinned: Vec<f64> = spectrum.iter().step_by(step).copied().collect();
                Lab::new(integration.xyz(&thinned)?, white)
            };
            let colours = spectra.iter().map(of).collect::<Result<Vec<Lab>, ColourError>>()?;
            if step == 1 {
                finest.clone_from(&colours);
            }
            let pairs = colours.iter().zip(&finest);
            let difference = pairs.map(|(one, other)| one.difference(*other)).fold(0.0, f64::max);
            if step == 2 {
                difference_of_two = Some(difference);
            }
            if difference > tolerance {
                break;
            }
            if spectra.is_empty() {
                break;
            }
            chosen =
                Some(Self { wavelengths, difference: Some(difference), compared: spectra.len(), difference_of_two });
        }
        let mut chosen = chosen.unwrap_or(Self::given(Wavelengths::finest()));
        chosen.difference_of_two = difference_of_two.filter(|_| !spectra.is_empty());
        Ok(chosen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fringes(period: f64) -> Vec<f64> {
        (380..=780).map(|nm| 0.5 + 0.5 * (std::f64::consts::TAU * f64::from(nm) / period).sin()).collect()
    }

    #[test]
    fn narrow_fringes_need_a_finer_grid() {
        let step = |period: f64| {
            let found = Sampling::coarsest(&[fringes(period)], Observer::Cie1931, &Illuminant::D65, 0.5).unwrap();
            found.wavelengths.step()
        };
        assert!(step(300.0) >= 10.0, "{}", step(300.0));
        // A sampling theorem: two points for each period at the very least, whatever the tolerance.
        assert!(step(9.0) <= 5.0, "{}", step(9.0));
    }

    #[test]
    fn no_spectrum_and_a_wrong_one() {
        let of = |spectra: &[Vec<f64>]| Sampling::coarsest(spectra, Observer::Cie1964, &Illuminant::E, 0.5);
        let none = of(&[]).unwrap();
        assert_eq!((none.wavelengths.len(), none.difference, none.compared), (401, None, 0));
        assert!(of(&[vec![0.5; 400]]).is_err());
        assert!(of(&[vec![f64::NAN; 401]]).is_err());
    }
}
