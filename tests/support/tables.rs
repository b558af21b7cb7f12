//! Small tables as bytes, and ways to read them.

use morpho_fit::dataset::{Constants, ReadOptions, WideHeading};

/// Heading lines of tables.
macro_rules! tidy {
    ($rows:literal) => {
        concat!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n", $rows).as_bytes()
    };
}
macro_rules! with_sigma {
    ($rows:literal) => {
        concat!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma\n", $rows).as_bytes()
    };
}
macro_rules! semicolons {
    ($rows:literal) => {
        concat!("wavelength_nm;theta_deg;phi_deg;omega_deg;intensity\n", $rows).as_bytes()
    };
}

pub(crate) fn plain() -> ReadOptions {
    ReadOptions::default()
}

pub(crate) fn flags(constants: Constants) -> ReadOptions {
    ReadOptions { constants, ..plain() }
}

pub(crate) fn theta_flag(degrees: f64) -> ReadOptions {
    flags(Constants { theta_deg: Some(degrees), ..Constants::default() })
}

/// A wide table of one plane, with the angle that is not in its headings given by a flag.
pub(crate) fn wide(heading: WideHeading) -> ReadOptions {
    let theta_deg = (heading != WideHeading::Theta).then_some(0.0);
    let phi_deg = (heading != WideHeading::Phi).then_some(10.0);
    let constants = Constants { theta_deg, phi_deg, omega_deg: Some(90.0), ..Constants::default() };
    ReadOptions { wide: Some(heading), ..flags(constants) }
}
