//! What can be wrong with a question put to the optics.

/// A structure, geometry or material for which no reflectivity can be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A quantity is outside its domain, or is not a finite number.
    #[error("{quantity} is {found}{}{unit}; it must be {allowed}", if unit.is_empty() { "" } else { " " })]
    OutOfRange {
        /// Name of the quantity, as in the documentation.
        quantity: &'static str,
        /// What was given.
        found: f64,
        /// Unit of `found`, or an empty text.
        unit: &'static str,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// The index table of a material does not reach the wavelength.
    #[error("the index table of the {medium} covers {first} to {last} nm, but {wavelength} nm is asked for")]
    OutsideTable {
        /// Which medium of the stack.
        medium: &'static str,
        /// Shortest wavelength of the table, nm.
        first: f64,
        /// Longest wavelength of the table, nm.
        last: f64,
        /// What was asked for, nm.
        wavelength: f64,
    },
    /// A table of λ, n, k that is not one.
    #[error("the index table has {problem} in row {row}")]
    BadTable {
        /// What is wrong, in words.
        problem: &'static str,
        /// Row of the table, counted from 1 without the heading.
        row: usize,
    },
    /// The model is defined for real indices, and a medium absorbs.
    #[error("the `{model}` model holds real indices only, but the {medium} has k = {k}; use the `blend` model")]
    Absorbing {
        /// Name of the forward model.
        model: &'static str,
        /// Which medium of the stack.
        medium: &'static str,
        /// Its extinction coefficient.
        k: f64,
    },
    /// Snell's law has no real solution in a medium, and the model has no answer for that.
    #[error("no refracted ray: sin(angle) would be {sine} in the {medium}; the `{model}` model ends there")]
    NoRefractedRay {
        /// Name of the forward model.
        model: &'static str,
        /// Which medium of the stack.
        medium: &'static str,
        /// The sine that Snell's law asks for.
        sine: f64,
    },
}

/// `Ok(value)` if it is finite and `holds`, else [`OpticsError::OutOfRange`].
pub(crate) fn require(
    holds: bool,
    quantity: &'static str,
    found: f64,
    unit: &'static str,
    allowed: &'static str,
) -> Result<(), OpticsError> {
    if found.is_finite() && holds { Ok(()) } else { Err(OpticsError::OutOfRange { quantity, found, unit, allowed }) }
}
