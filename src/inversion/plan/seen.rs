//! What the readings of a plan see.

use super::Plan;
use crate::inversion::parameter::Parameter;

impl Plan<'_> {
    /// Number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.readings.len()
    }

    /// Whether there are no readings.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.readings.is_empty()
    }

    /// Whether some reading sees Model A.
    #[must_use]
    pub fn has_lamella(&self) -> bool {
        !self.points.half_kv.is_empty()
    }

    /// Whether some reading sees Model B.
    #[must_use]
    pub fn has_multilayer(&self) -> bool {
        !self.points.stack.is_empty()
    }

    /// Whether some reading may depend on `parameter`.
    pub(crate) fn sees(&self, parameter: Parameter) -> bool {
        match parameter {
            Parameter::DAir | Parameter::DCuticle => self.has_lamella() || self.has_multilayer(),
            Parameter::Delta | Parameter::PhiAlpha => self.has_multilayer(),
            Parameter::LamellaWidth => self.has_lamella() || self.is_product(),
        }
    }

    /// Whether the model is one product: then the stack does not depend on the tilt, and the rest is the lobe.
    pub(crate) fn is_product(&self) -> bool {
        !self.points.product.is_empty()
    }

    /// Number of directions of incidence and view in which Model B is seen.
    pub(crate) fn directions(&self) -> usize {
        self.points.directions
    }
}
