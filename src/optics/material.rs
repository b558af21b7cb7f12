//! Refractive index of a medium over wavelength: a number, Cauchy's formula, or a table.
//!
//! The time factor is `exp(-i omega t)`, so `n + i k` absorbs for `k > 0`.

use crate::optics::error::{OpticsError, require};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Wavelengths, nm: outside it is no light, but most likely a length in µm or m.
pub(crate) const WAVELENGTHS: RangeInclusive<f64> = 10.0..=1e6;

/// Values of n: far outside, no material is known and the squares overflow.
pub(crate) const INDICES: RangeInclusive<f64> = 1e-3..=1e3;

/// Refractive index of one medium.
///
/// ```
/// use morpho_fit::optics::Material;
/// let chitin = Material::Cauchy { a: 1.517, b: 8.80e3 }; // butterfly chitin, Leertouwer 2011
/// let n = chitin.index("cuticle", 500.0)?;
/// assert!((n.re - 1.552).abs() < 5e-4);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// The same `n + i k` at every wavelength.
    Constant {
        /// Refractive index, above 0.
        n: f64,
        /// Extinction coefficient, at least 0.
        k: f64,
    },
    /// Cauchy's formula `n = a + b / wavelength^2`, without absorption.
    Cauchy {
        /// Constant term.
        a: f64,
        /// Dispersion term, nm².
        b: f64,
    },
    /// Measured values, linear in between; outside its range it is an error.
    Table(IndexTable),
}

/// Rows of wavelength, n and k with rising wavelength.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 3]>", into = "Vec<[f64; 3]>")]
pub struct IndexTable {
    rows: Vec<[f64; 3]>,
}

impl IndexTable {
    /// A table from rows `[wavelength nm, n, k]`.
    ///
    /// # Errors
    /// [`OpticsError::BadTable`] if it is empty, if a value is not finite or out of range, or if the wavelengths do
    /// not rise.
    pub fn new(rows: Vec<[f64; 3]>) -> Result<Self, OpticsError> {
        let bad = |problem, row| Err(OpticsError::BadTable { problem, row });
        if rows.is_empty() {
            return bad("no value", 1);
        }
        let mut previous = 0.0;
        for (index, &[wavelength, n, k]) in rows.iter().enumerate() {
            let row = index + 1;
            if !(wavelength.is_finite() && n.is_finite() && k.is_finite()) {
                return bad("a value that is not finite", row);
            }
            if wavelength <= previous {
                return bad("a wavelength that is not above the one before it (nm, above 0)", row);
            }
            if n <= 0.0 || k < 0.0 {
                return bad("n that is not above 0 or k below 0", row);
            }
            previous = wavelength;
        }
        Ok(Self { rows })
    }

    /// The rows `[wavelength nm, n, k]`.
    #[must_use]
    pub fn rows(&self) -> &[[f64; 3]] {
        &self.rows
    }

    fn at(&self, medium: &'static str, wavelength: f64) -> Result<Complex<f64>, OpticsError> {
        let (first, last) = (self.rows[0], self.rows[self.rows.len() - 1]);
        if !(first[0]..=last[0]).contains(&wavelength) {
            return Err(OpticsError::OutsideTable { medium, first: first[0], last: last[0], wavelength });
        }
        let above = self.rows.partition_point(|row| row[0] < wavelength);
        let high = self.rows[above];
        if above == 0 {
            return Ok(Complex::new(high[1], high[2]));
        }
        let low = self.rows[above - 1];
        let share = (wavelength - low[0]) / (high[0] - low[0]);
        Ok(Complex::new(low[1] + share * (high[1] - low[1]), low[2] + share * (high[2] - low[2])))
    }
}

impl TryFrom<Vec<[f64; 3]>> for IndexTable {
    type Error = OpticsError;
    fn try_from(rows: Vec<[f64; 3]>) -> Result<Self, OpticsError> {
        Self::new(rows)
    }
}

impl From<IndexTable> for Vec<[f64; 3]> {
    fn from(table: IndexTable) -> Self {
        table.rows
    }
}

impl Material {
    /// A medium with the real index `n` at every wavelength.
    #[must_use]
    pub fn constant(n: f64) -> Self {
        Self::Constant { n, k: 0.0 }
    }

    /// The complex index `n + i k` at `wavelength` nm; `medium` names it in errors.
    ///
    /// # Errors
    /// [`OpticsError::OutsideTable`] beyond a table's ends; [`OpticsError::OutOfRange`] if the wavelength is not
    /// 10 to 1e6 nm or the resulting index not 0.001 to 1000 with `k` from 0 to 1000.
    pub fn index(&self, medium: &'static str, wavelength: f64) -> Result<Complex<f64>, OpticsError> {
        require(WAVELENGTHS.contains(&wavelength), "wavelength", wavelength, "nm", "10 to 1e6")?;
        let index = match self {
            Self::Constant { n, k } => Complex::new(*n, *k),
            Self::Cauchy { a, b } => Complex::new(a + b / (wavelength * wavelength), 0.0),
            Self::Table(table) => table.at(medium, wavelength)?,
        };
        require_index(medium, index)?;
        Ok(index)
    }
}

/// Checks `n` and `k` of `medium`.
pub(crate) fn require_index(medium: &'static str, index: Complex<f64>) -> Result<(), OpticsError> {
    require(INDICES.contains(&index.re), medium, index.re, "(refractive index n)", "0.001 to 1000")?;
    require((0.0..=1e3).contains(&index.im), medium, index.im, "(extinction coefficient k)", "0 to 1000")
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn cauchy_chitin_has_the_published_indices() {
        // Leertouwer, Wilts, Stavenga 2011: 1.572, 1.552, 1.541 at 400, 500, 600 nm.
        let chitin = Material::Cauchy { a: 1.517, b: 8.80e3 };
        for (wavelength, n) in [(400.0, 1.572), (500.0, 1.552), (600.0, 1.541)] {
            assert_relative_eq!(chitin.index("cuticle", wavelength).unwrap().re, n, epsilon = 6e-4);
        }
    }

    #[test]
    fn a_table_is_linear_inside_exact_at_its_rows_and_an_error_outside() {
        let table = Material::Table(IndexTable::new(vec![[400.0, 1.5, 0.0], [500.0, 1.6, 0.2]]).unwrap());
        assert_eq!(table.index("base", 400.0).unwrap(), Complex::new(1.5, 0.0));
        assert_eq!(table.index("base", 500.0).unwrap(), Complex::new(1.6, 0.2));
        assert_relative_eq!(table.index("base", 425.0).unwrap().im, 0.05, epsilon = 1e-15);
        assert_eq!(
            table.index("base", 399.0).unwrap_err().to_string(),
            "the index table of the base covers 400 to 500 nm, but 399 nm is asked for"
        );
    }

    #[test]
    fn a_table_that_is_not_one_is_refused() {
        for rows in [
            vec![],
            vec![[0.0, 1.0, 0.0]],
            vec![[400.0, f64::NAN, 0.0]],
            vec![[400.0, 1.0, -1.0]],
            vec![[400.0, 1.0, 0.0], [400.0, 1.0, 0.0]],
        ] {
            assert!(IndexTable::new(rows).is_err());
        }
    }

    #[test]
    fn an_index_that_is_no_number_is_an_error() {
        assert!(Material::constant(f64::NAN).index("gap", 500.0).is_err());
        assert!(Material::constant(0.0).index("gap", 500.0).is_err());
        assert!(Material::Constant { n: 1.5, k: -0.1 }.index("gap", 500.0).is_err());
        assert!(Material::Cauchy { a: 1.5, b: -1e9 }.index("gap", 500.0).is_err());
    }
}
