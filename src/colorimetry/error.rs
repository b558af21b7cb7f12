//! What can be wrong with a colour that is asked for.

/// A spectrum, illuminant or white for which no colour can be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ColourError {
    /// A number is not finite.
    #[error("{quantity} {index} is {found}; it must be a finite number")]
    NotFinite {
        /// What the number is, in words.
        quantity: &'static str,
        /// Which of them, counted from 0.
        index: usize,
        /// What was given.
        found: f64,
    },
    /// A list of spectra is not as long as its wavelengths ask for.
    #[error("{found} reflectances are no whole number of spectra of {wavelengths} wavelengths each")]
    Length {
        /// Wavelengths of one spectrum.
        wavelengths: usize,
        /// Reflectances given.
        found: usize,
    },
    /// The illuminant sends nothing visible at the wavelengths.
    #[error("the illuminant has no light that the observer sees between {first} and {last} nm")]
    NoLight {
        /// First wavelength, nm.
        first: f64,
        /// Last wavelength, nm.
        last: f64,
    },
    /// A measured illuminant does not reach the wavelengths.
    #[error("the illuminant's table covers {first} to {last} nm, but {wavelength} nm is asked for")]
    OutsideTable {
        /// Shortest wavelength of the table, nm.
        first: f64,
        /// Longest wavelength of the table, nm.
        last: f64,
        /// What was asked for, nm.
        wavelength: f64,
    },
    /// A table of wavelength and power that is not one.
    #[error("the illuminant's table has {problem} in row {row}")]
    BadTable {
        /// What is wrong, in words.
        problem: &'static str,
        /// Row of the table, counted from 1 without the heading.
        row: usize,
    },
    /// A white that no light has.
    #[error("the white is ({x}, {y}, {z}); all three must be above 0")]
    BadWhite {
        /// X of the white.
        x: f64,
        /// Y of the white.
        y: f64,
        /// Z of the white.
        z: f64,
    },
}
