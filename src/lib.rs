//! Fits layer thicknesses to the angular reflectivity of structurally coloured surfaces.
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout, clippy::print_stderr)
)]

pub mod dataset;
pub mod geometry;
pub mod inversion;
pub mod numerics;
pub mod optics;
pub mod optimise;
pub mod plot;
pub mod synthetic;
pub mod uncertainty;
pub mod units;
