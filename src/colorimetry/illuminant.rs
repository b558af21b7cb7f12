//! The light that falls on the surface: relative spectral power.

use super::error::ColourError;
use super::observer::{interpolated, rows};
use crate::spectrum::Wavelengths;
use std::sync::LazyLock;

/// First wavelength and step of the daylight table, nm.
const D65_GRID: (f64, f64) = (300.0, 5.0);

static D65: LazyLock<Vec<[f64; 1]>> = LazyLock::new(|| rows(include_str!("tables/cie_d65.csv")));

/// A light, by its relative spectral power.
///
/// Only ratios count: a colour is relative to the white of its own light.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Illuminant {
    /// Average daylight, CIE standard illuminant D65: the light that sRGB assumes.
    #[default]
    D65,
    /// An incandescent lamp of 2856 K, CIE standard illuminant A.
    A,
    /// Equal power at all wavelengths.
    E,
    /// A lamp's own spectrum.
    Measured(PowerTable),
}

impl Illuminant {
    /// Relative power at `wavelength` (nm); D65 and A are 100 at 560 nm, E is 1.
    ///
    /// ```text
    /// A: 100 (560 / λ)^5 (exp(1.435e7 / (2848 · 560)) - 1) / (exp(1.435e7 / (2848 λ)) - 1)
    /// ```
    ///
    /// D65 is linear between the rows of its table of 5 nm, which is how the CIE defines it at 1 nm. The table ends at
    /// 300 and 780 nm, the power is 0 outside; less than a part in 100,000 of a white is lost there. A measured spectrum is
    /// linear between its rows and 0 outside; [`super::Integration::new`] refuses wavelengths that it does not cover.
    /// 0 where `wavelength` is not a number above 0.
    ///
    /// # Source
    /// ISO/CIE 11664-2:2022; D65: CIE 2019, data set DOI 10.25039/CIE.DS.hjfjmt59.
    ///
    /// ```
    /// use morpho_fit::colorimetry::Illuminant;
    /// assert_eq!(Illuminant::D65.power(560.0), 100.0);
    /// assert_eq!(Illuminant::A.power(560.0), 100.0);
    /// ```
    #[must_use]
    pub fn power(&self, wavelength: f64) -> f64 {
        if !(wavelength > 0.0 && wavelength.is_finite()) {
            return 0.0;
        }
        match self {
            Self::D65 => interpolated(&D65, D65_GRID.0, D65_GRID.1, wavelength)[0],
            Self::A => {
                let planck = |wavelength: f64| (1.435e7 / (2848.0 * wavelength)).exp_m1();
                // Far in the ultraviolet the quotient falls to 0 before the fifth power overflows.
                let quotient = planck(560.0) / planck(wavelength);
                if quotient > 0.0 { 100.0 * (560.0 / wavelength).powi(5) * quotient } else { 0.0 }
            }
            Self::E => 1.0,
            Self::Measured(table) => table.power(wavelength),
        }
    }

    /// What a caption calls the light.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::D65 => "D65",
            Self::A => "A",
            Self::E => "E",
            Self::Measured(_) => "measured light",
        }
    }

    /// An error where a measured light is not known at some of `wavelengths`.
    pub(super) fn covers(&self, wavelengths: &Wavelengths) -> Result<(), ColourError> {
        let Self::Measured(PowerTable { rows }) = self else { return Ok(()) };
        let (Some(&[first, _]), Some(&[last, _])) = (rows.first(), rows.last()) else { return Ok(()) };
        let outside = |wavelength: &f64| *wavelength < first || *wavelength > last;
        match [wavelengths.first(), wavelengths.last()].into_iter().find(outside) {
            Some(wavelength) => Err(ColourError::OutsideTable { first, last, wavelength }),
            None => Ok(()),
        }
    }
}

/// A table of relative spectral power that can only exist valid: wavelengths rise, powers are 0 or more, one is above 0.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerTable {
    rows: Vec<[f64; 2]>,
}

impl PowerTable {
    /// From rows `[wavelength nm, power in any unit]`.
    ///
    /// # Errors
    /// [`ColourError::BadTable`] with the row, if a cell is not finite, a wavelength is not above 0 and above the one
    /// before it, or a power is negative; or if no power is above 0.
    ///
    /// ```
    /// use morpho_fit::colorimetry::{Illuminant, PowerTable};
    /// let lamp = Illuminant::Measured(PowerTable::new(vec![[400.0, 1.0], [700.0, 4.0]])?);
    /// assert_eq!(lamp.power(500.0), 2.0);
    /// # Ok::<(), morpho_fit::colorimetry::ColourError>(())
    /// ```
    pub fn new(rows: Vec<[f64; 2]>) -> Result<Self, ColourError> {
        let bad = |problem, row| Err(ColourError::BadTable { problem, row });
        let mut previous = 0.0;
        for (index, &[wavelength, power]) in rows.iter().enumerate() {
            if !(wavelength.is_finite() && power.is_finite()) {
                return bad("a value that is not finite", index + 1);
            }
            if wavelength <= previous {
                return bad("a wavelength that is not above the one before it (nm, above 0)", index + 1);
            }
            if power < 0.0 {
                return bad("a negative power", index + 1);
            }
            previous = wavelength;
        }
        if !rows.iter().any(|row| row[1] > 0.0) {
            return bad("no power above 0 up to its end", rows.len().max(1));
        }
        Ok(Self { rows })
    }

    fn power(&self, wavelength: f64) -> f64 {
        let above = self.rows.partition_point(|row| row[0] < wavelength);
        let Some(&[high_at, high]) = self.rows.get(above) else { return 0.0 };
        match above.checked_sub(1).and_then(|below| self.rows.get(below)) {
            Some(&[low_at, low]) => low + (wavelength - low_at) / (high_at - low_at) * (high - low),
            None if wavelength < high_at => 0.0,
            None => high,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn every_cell_of_the_daylight_table_is_a_number_at_its_wavelength() {
        let (mut wavelength, step) = D65_GRID;
        for line in include_str!("tables/cie_d65.csv").lines().skip(1) {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            assert_relative_eq!(cells[0], wavelength);
            assert_relative_eq!(Illuminant::D65.power(cells[0]), cells[1]);
            wavelength += step;
        }
        assert_relative_eq!(wavelength, 785.0);
    }

    /// CIE 15:2018, table of illuminant A (six digits).
    #[test]
    fn illuminant_a_is_the_printed_one() {
        for (wavelength, printed) in [(380.0, 9.7951), (450.0, 33.0859), (500.0, 59.8611), (700.0, 198.261)] {
            assert_relative_eq!(Illuminant::A.power(wavelength), printed, max_relative = 2e-6);
        }
    }

    #[test]
    fn no_wavelength_makes_a_power_that_is_none() {
        let table = PowerTable::new(vec![[400.0, 1.0], [700.0, 4.0]]).unwrap();
        for light in [Illuminant::D65, Illuminant::A, Illuminant::E, Illuminant::Measured(table)] {
            for wavelength in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
                assert_relative_eq!(light.power(wavelength), 0.0);
            }
            for wavelength in [1e-300, 1e-9, 20.0, 399.0, 1e9, 1e300] {
                let power = light.power(wavelength);
                assert!(power.is_finite() && power >= 0.0, "{light:?} at {wavelength}: {power}");
            }
        }
    }

    #[test]
    fn a_table_that_is_none_is_refused_with_its_row() {
        let row = |rows: &[[f64; 2]]| match PowerTable::new(rows.to_vec()) {
            Err(ColourError::BadTable { row, .. }) => row,
            other => panic!("{other:?}"),
        };
        assert_eq!(row(&[]), 1);
        assert_eq!(row(&[[400.0, 0.0], [500.0, 0.0]]), 2);
        assert_eq!(row(&[[400.0, 1.0], [400.0, 2.0]]), 2);
        assert_eq!(row(&[[-400.0, 1.0], [400.0, 2.0]]), 1);
        assert_eq!(row(&[[400.0, 1.0], [500.0, 1.0], [600.0, -1.0]]), 3);
        assert_eq!(row(&[[400.0, f64::NAN], [500.0, 1.0]]), 1);
    }

    #[test]
    fn a_measured_light_covers_its_own_range_only() {
        let lamp = Illuminant::Measured(PowerTable::new(vec![[400.0, 1.0], [700.0, 4.0]]).unwrap());
        assert!(lamp.covers(&Wavelengths::new(400.0, 700.0, 10.0).unwrap()).is_ok());
        let outside = lamp.covers(&Wavelengths::new(400.0, 710.0, 10.0).unwrap());
        assert_eq!(outside, Err(ColourError::OutsideTable { first: 400.0, last: 700.0, wavelength: 710.0 }));
    }
}
