//! The viewing geometry of one reading: angles, their signs, and the polarization of the light.
//!
//! `theta` (incidence) and `phi` (viewing) are signed and measured from the scale normal in one plane, **both the
//! same way round**: retro-reflection is `phi = theta`, the mirror direction of an untilted surface is
//! `phi = -theta`. `omega` turns that plane about the normal: 0 lies across the ridges (Model A alone), 90° along
//! them (Model B alone). Angles are in radians.
//!
//! # Source
//! Iwasawa, Shichijo, Kawaguchi, sections 2.2 to 2.4. The paper leaves the sign of `phi` open; `u = sin(theta) +
//! sin(phi) = 0` at the mirror direction fixes it.

use serde::{Deserialize, Serialize};

/// Which linear polarization was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Polarization {
    /// The mean of s and p.
    #[default]
    Unpolarized,
    /// Electric field across the plane of incidence.
    S,
    /// Electric field in the plane of incidence.
    P,
}

impl Polarization {
    /// Shares of the s and the p reflectivity in what is measured; they add up to 1.
    ///
    /// ```
    /// use morpho_fit::geometry::Polarization;
    /// assert_eq!(Polarization::Unpolarized.shares(), (0.5, 0.5));
    /// ```
    #[must_use]
    pub fn shares(self) -> (f64, f64) {
        match self {
            Self::Unpolarized => (0.5, 0.5),
            Self::S => (1.0, 0.0),
            Self::P => (0.0, 1.0),
        }
    }

    /// The word used in CSV files: `unpolarized`, `s` or `p`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Unpolarized => "unpolarized",
            Self::S => "s",
            Self::P => "p",
        }
    }
}

/// Incidence, viewing and anisotropy angle, in radians.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Geometry {
    /// Incidence angle `theta` from the scale normal, rad.
    pub theta: f64,
    /// Viewing angle `phi` from the scale normal, the same way round as `theta`, rad.
    pub phi: f64,
    /// Angle `omega` between the measuring plane and the plane across the ridges, rad.
    pub omega: f64,
}

impl Geometry {
    /// Shares of Model A and Model B, `(cos^2 omega, sin^2 omega)`.
    ///
    /// A share below 1e-30 is returned as 0, so that 90° in degrees switches Model A off exactly.
    ///
    /// ```
    /// use morpho_fit::{geometry::Geometry, units::radians};
    /// let along = Geometry { omega: radians(90.0), ..Geometry::default() };
    /// assert_eq!(along.plane_shares(), (0.0, 1.0));
    /// ```
    #[must_use]
    pub fn plane_shares(&self) -> (f64, f64) {
        let clean = |share: f64| if share < 1e-30 { 0.0 } else { share };
        let (sin, cos) = self.omega.sin_cos();
        (clean(cos * cos), clean(sin * sin))
    }
}
