//! The box of free parameters that a search moves in.

use crate::inversion::parameter::{COUNT, Freedom, Parameter, Role};
use crate::optimise::{Bounds, BoundsError};
use nalgebra::DVector;

/// Free parameters with their bounds, ranges and scales.
#[derive(Debug, Clone)]
pub(crate) struct Space {
    pub(crate) freedom: Freedom,
    pub(crate) bounds: Bounds,
    /// Range of each free parameter.
    pub(crate) ranges: DVector<f64>,
    /// A change that matters of each free parameter.
    pub(crate) scales: DVector<f64>,
}

impl Space {
    /// The space of `roles`, whose bounds were checked.
    pub(crate) fn new(roles: &[Role; COUNT]) -> Result<Self, BoundsError> {
        let freedom = Freedom::new(roles);
        let limits = |parameter: &Parameter| match roles[parameter.index()] {
            Role::Free { lower, upper } => (lower, upper),
            Role::Fixed { .. } | Role::Linked { .. } => parameter.domain(),
        };
        let (lower, upper): (Vec<f64>, Vec<f64>) = freedom.free.iter().map(limits).unzip();
        let bounds = Bounds::new(&lower, &upper)?;
        let ranges = bounds.upper() - bounds.lower();
        let scales = DVector::from_iterator(freedom.free.len(), freedom.free.iter().map(|p| p.typical_change()));
        Ok(Self { freedom, bounds, ranges, scales })
    }
}
