//! What a structure shows over angles, wavelengths and thicknesses: the numbers behind curves and colour charts.

mod colour;
mod curve;
mod sampling;

pub use colour::{Colours, Grid, SweepError, View, Viewing, colours, spectra};
pub use curve::{Curve, Terms};
pub use sampling::Sampling;
