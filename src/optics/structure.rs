//! The five parameters of a structure, and the paper's presets.

use crate::optics::error::{OpticsError, require};
use crate::optics::multilayer::{Period, THICKNESSES};
use serde::{Deserialize, Serialize};

/// The structure of one scale: what a fit looks for.
///
/// Field names are the paper's symbols spelt out (sections 2.2 and 2.3, Table 1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// Thickness of one air gap, nm, at least 0.
    pub d_air: f64,
    /// Thickness of one cuticle layer, nm, at least 0.
    pub d_cuticle: f64,
    /// Mean tilt of the multilayer `delta`, rad.
    pub delta: f64,
    /// Half-width of the cosine lobe made by the curvature, rad, above 0 and at most pi.
    pub phi_alpha: f64,
    /// Width of a lamella `a`, nm, above 0.
    pub lamella_width: f64,
}

impl Structure {
    /// Table 1 of the paper: air 135 nm, cuticle 100 nm, tilt 2.5°, lobe 0.5 rad, lamella 300 nm.
    #[must_use]
    pub fn table1() -> Self {
        Self { d_air: 135.0, d_cuticle: 100.0, delta: 2.5_f64.to_radians(), phi_alpha: 0.5, lamella_width: 300.0 }
    }

    /// A *Morpho* that is blue: air 141 nm, cuticle 62 nm, the rest as in Table 1.
    #[must_use]
    pub fn blue() -> Self {
        Self { d_air: 141.0, d_cuticle: 62.0, ..Self::table1() }
    }

    /// Interval of the lamellae `d = d_air + d_cuticle`, nm.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.d_air + self.d_cuticle
    }

    /// Checks every field against its range; no length may pass 1 mm.
    ///
    /// # Errors
    /// [`OpticsError::OutOfRange`] with the first field that is out of range or not finite.
    pub fn validate(&self) -> Result<(), OpticsError> {
        Period { cuticle: self.d_cuticle, gap: self.d_air }.validate()?;
        require(self.delta.abs() < std::f64::consts::FRAC_PI_2, "delta", self.delta, "rad", "between -pi/2 and pi/2")?;
        let lobe = self.phi_alpha > 0.0 && self.phi_alpha <= std::f64::consts::PI;
        require(lobe, "phi_alpha", self.phi_alpha, "rad", "above 0 and at most pi: radians, not degrees")?;
        let wide = self.lamella_width > 0.0 && THICKNESSES.contains(&self.lamella_width);
        require(wide, "lamella_width", self.lamella_width, "nm", "above 0, at most 1e6")
    }
}
