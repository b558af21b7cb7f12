//! Colour as an observer sees it: from a reflectance spectrum to XYZ, CIELAB and the RGB of a display.
//!
//! ```text
//! spectrum R(λ) --[Integration: observer, illuminant]--> Xyz --> Lab, colour difference
//!                                                        Xyz --[RgbTransform: Bradford, matrix, encoding]--> RGB
//!                                                        Xyz --[show: gamut]--> bytes, and whether they are the colour
//! ```
//!
//! Tables and formulas agree with `colour-science` 0.4.7 to 1e-9 (`tests/colour_reference.rs`). CIELAB, CIEDE2000 and Oklab
//! are `palette`'s, which is right to that. Its RGB spaces are not used: their matrices are made from a white of other digits
//! than the standards', which moves a channel by up to 5e-4. Neither are its encodings, whose power is too slow here.
//!
//! Left out: fluorescence, colour appearance beyond the adaptation to white, and observers other than the two standard
//! ones.

mod encoding;
mod error;
pub mod gamut;
mod illuminant;
mod integration;
mod lab;
mod observer;
mod printed;
mod rgb;
mod tristimulus;

pub use error::ColourError;
pub use gamut::{GamutMapping, Shown, show};
pub use illuminant::{Illuminant, PowerTable};
pub use integration::Integration;
pub use lab::Lab;
pub use observer::Observer;
pub use printed::printed_rgb;
pub use rgb::{RgbSpace, RgbTransform};
pub use tristimulus::{XyY, Xyz};
