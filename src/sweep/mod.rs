//! What a structure shows over angles, wavelengths and thicknesses: the numbers behind curves and colour charts.

mod curve;

pub use curve::{Curve, Terms};
