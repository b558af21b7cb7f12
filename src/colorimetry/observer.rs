//! The CIE standard observers: how much each wavelength adds to X, Y and Z.

use std::sync::LazyLock;

/// First wavelength of the tables, nm; they go on by 1 nm.
const FIRST: f64 = 360.0;

static CIE_1931: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| rows(include_str!("tables/cie_1931_2deg.csv")));
static CIE_1964: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| rows(include_str!("tables/cie_1964_10deg.csv")));

/// The columns behind the first, heading left out. The tables are part of the crate, and a test reads every cell.
pub(super) fn rows<const N: usize>(table: &str) -> Vec<[f64; N]> {
    let cells = |line: &str| {
        let mut values = [0.0; N];
        for (value, cell) in values.iter_mut().zip(line.split(',').skip(1)) {
            *value = cell.trim().parse().unwrap_or(0.0);
        }
        values
    };
    table.lines().skip(1).map(cells).collect()
}

/// The value at `wavelength` of rows that begin at `first` and go on by `step`, linearly between them; 0 outside.
pub(super) fn interpolated<const N: usize>(rows: &[[f64; N]], first: f64, step: f64, wavelength: f64) -> [f64; N] {
    let place = (wavelength - first) / step;
    if place.is_nan() || place < 0.0 {
        return [0.0; N];
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; a large one saturates")]
    let index = place.floor() as usize;
    let Some(below) = rows.get(index) else { return [0.0; N] };
    let share = place - place.floor();
    match rows.get(index + 1) {
        Some(above) => std::array::from_fn(|k| below[k] + share * (above[k] - below[k])),
        None if share > 0.0 => [0.0; N],
        None => *below,
    }
}

/// A CIE standard colorimetric observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Observer {
    /// 2° field of view, 1931: the one that sRGB and most of the literature use.
    #[default]
    Cie1931,
    /// 10° field of view, 1964: for surfaces that fill more than 4° of it.
    Cie1964,
}

impl Observer {
    /// Colour matching functions `[x̄, ȳ, z̄]` at `wavelength` (nm), dimensionless.
    ///
    /// The tables of 1 nm, 360 to 830 nm; linear between their rows, 0 outside and where `wavelength` is no number.
    ///
    /// # Source
    /// CIE 2019, data sets DOI 10.25039/CIE.DS.xvudnb9b (1931) and DOI 10.25039/CIE.DS.sqksu2n5 (1964); the standard is
    /// ISO/CIE 11664-1:2019.
    ///
    /// ```
    /// use morpho_fit::colorimetry::Observer;
    /// assert_eq!(Observer::Cie1931.matching(555.0)[1], 1.0);
    /// assert_eq!(Observer::Cie1931.matching(900.0), [0.0; 3]);
    /// ```
    #[must_use]
    pub fn matching(self, wavelength: f64) -> [f64; 3] {
        let table = match self {
            Self::Cie1931 => &*CIE_1931,
            Self::Cie1964 => &*CIE_1964,
        };
        interpolated(table, FIRST, 1.0, wavelength)
    }

    /// What a caption calls the observer.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cie1931 => "CIE 1931 2°",
            Self::Cie1964 => "CIE 1964 10°",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn every_cell_of_the_tables_is_a_number_at_its_wavelength() {
        for table in [include_str!("tables/cie_1931_2deg.csv"), include_str!("tables/cie_1964_10deg.csv")] {
            let mut wavelength = FIRST;
            for line in table.lines().skip(1) {
                let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
                assert_eq!(cells.len(), 4);
                assert_relative_eq!(cells[0], wavelength);
                // Three of the published z of 1931 are rounding errors about 0.
                assert!(cells[1..].iter().all(|cell| (-1e-21..2.1).contains(cell)));
                wavelength += 1.0;
            }
            assert_relative_eq!(wavelength, 831.0);
        }
    }

    /// The three functions of an observer were made to have equal areas, to the rounding of their tables.
    #[test]
    fn an_equal_energy_light_is_white() {
        for observer in [Observer::Cie1931, Observer::Cie1964] {
            let sums = (360..=830).fold([0.0; 3], |sums, wavelength| {
                let matching = observer.matching(f64::from(wavelength));
                std::array::from_fn(|k| sums[k] + matching[k])
            });
            assert_relative_eq!(sums[0], sums[1], max_relative = 4e-4);
            assert_relative_eq!(sums[2], sums[1], max_relative = 4e-4);
        }
    }

    #[test]
    fn between_the_rows_and_outside() {
        let of = |wavelength| Observer::Cie1964.matching(wavelength);
        assert_relative_eq!(of(500.25)[1], 0.75 * of(500.0)[1] + 0.25 * of(501.0)[1], max_relative = 1e-15);
        assert!(of(830.0)[0] > 0.0 && of(360.0)[0] > 0.0);
        for outside in [359.999, 830.001, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(of(outside).iter().all(|value| value.abs() < f64::MIN_POSITIVE), "{outside}");
        }
    }
}
