//! What intervals are given for: the five parameters, and the two sums of thicknesses that follow from them.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::outcome::{Derived, Estimate, FitOutcome};
use crate::inversion::parameter::{COUNT, Parameter, Role};
use crate::inversion::space::Space;
use crate::optics::Stack;
use nalgebra::DVector;

/// One number that a fit gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Quantity {
    /// One of the five.
    Parameter(Parameter),
    /// `d_air + d_cuticle`.
    Period,
    /// `n_gap d_air + n_cuticle d_cuticle` with these indices.
    OpticalSum { gap: f64, cuticle: f64 },
}

/// A slope below this is none.
const ROUNDING: f64 = 1e-12;

/// Real indices of gap and cuticle at the middle wavelength of the data; 1 and 1.56 where the media have none there.
pub(crate) fn indices(data: &Dataset, stack: &Stack) -> (f64, f64) {
    stack.media(data.middle_wavelength()).map_or((1.0, 1.56), |media| (media.gap.re, media.cuticle.re))
}

/// Each quantity with what is said of it.
pub(crate) fn with_estimates<'a>(
    (gap, cuticle): (f64, f64),
    estimates: &'a mut [Estimate; COUNT],
    derived: &'a mut Derived,
) -> impl Iterator<Item = (Quantity, &'a mut Estimate)> {
    let sums = [Quantity::Period, Quantity::OpticalSum { gap, cuticle }];
    let quantities = Parameter::ALL.into_iter().map(Quantity::Parameter).chain(sums);
    quantities.zip(estimates.iter_mut().chain([&mut derived.period, &mut derived.optical_sum]))
}

impl Quantity {
    /// All that move in `space`.
    pub(crate) fn moving(compiled: &Compiled<'_>, space: &Space) -> Vec<Self> {
        let (gap, cuticle) = indices(compiled.data, &compiled.settings.stack);
        let sums = [Self::Period, Self::OpticalSum { gap, cuticle }];
        let all = Parameter::ALL.into_iter().map(Self::Parameter).chain(sums);
        all.filter(|quantity| quantity.slopes(space).amax() > ROUNDING).collect()
    }

    /// As in `fit.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.name(),
            Self::Period => "period",
            Self::OpticalSum { .. } => "optical_sum",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Parameter(parameter) => parameter.unit(),
            Self::Period | Self::OpticalSum { .. } => "nm",
        }
    }

    /// An inside value in the user's unit.
    pub(crate) fn outside(self, value: f64) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.outside(value),
            Self::Period | Self::OpticalSum { .. } => value,
        }
    }

    /// A value in the user's unit as the library holds it.
    pub(crate) fn inside(self, value: f64) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.inside(value),
            Self::Period | Self::OpticalSum { .. } => value,
        }
    }

    /// A change that matters, inside unit.
    pub(crate) fn typical_change(self) -> f64 {
        match self {
            Self::Parameter(parameter) => parameter.typical_change(),
            Self::Period | Self::OpticalSum { .. } => Parameter::DAir.typical_change(),
        }
    }

    /// What the fit says of it.
    pub(crate) fn estimate(self, outcome: &FitOutcome) -> &Estimate {
        match self {
            Self::Parameter(parameter) => outcome.parameters.each()[parameter.index()].1,
            Self::Period => &outcome.derived.period,
            Self::OpticalSum { .. } => &outcome.derived.optical_sum,
        }
    }

    /// Slopes by the five parameters.
    pub(crate) fn gradient(self) -> [f64; COUNT] {
        match self {
            Self::Parameter(parameter) => {
                let mut gradient = [0.0; COUNT];
                gradient[parameter.index()] = 1.0;
                gradient
            }
            Self::Period => [1.0, 1.0, 0.0, 0.0, 0.0],
            Self::OpticalSum { gap, cuticle } => [gap, cuticle, 0.0, 0.0, 0.0],
        }
    }

    /// The value for five parameters, inside unit.
    pub(crate) fn of(self, values: &[f64; COUNT]) -> f64 {
        self.gradient().iter().zip(values).map(|(slope, value)| slope * value).sum()
    }

    /// Slopes by the free parameters of `space`.
    pub(crate) fn slopes(self, space: &Space) -> DVector<f64> {
        space.freedom.matrix().tr_mul(&DVector::from_column_slice(&self.gradient()))
    }

    /// Least and largest value in the box of `space`.
    pub(crate) fn limits(self, space: &Space) -> (f64, f64) {
        let (lower, upper) = (space.bounds.lower(), space.bounds.upper());
        let constant = self.of(&space.freedom.expand(&DVector::zeros(lower.len())));
        let ends = |(low, high): (f64, f64), (j, &slope): (usize, &f64)| {
            let (a, b) = (slope * lower[j], slope * upper[j]);
            (low + a.min(b), high + a.max(b))
        };
        self.slopes(space).iter().enumerate().fold((constant, constant), ends)
    }

    /// Whether [`held`](Self::held) can hold it at all: what another parameter follows cannot follow it.
    pub(crate) fn can_be_held(self, roles: &[Role; COUNT], space: &Space) -> bool {
        let (low, high) = self.limits(space);
        self.held(roles, space, 0.5 * (low + high)).is_some()
    }

    /// `roles` with the quantity held at `value`; `None` if that leaves no room, or if it depends on more than two
    /// parameters or on one that another follows.
    pub(crate) fn held(self, roles: &[Role; COUNT], space: &Space, value: f64) -> Option<[Role; COUNT]> {
        let slopes = self.slopes(space);
        let constant = self.of(&space.freedom.expand(&DVector::zeros(slopes.len())));
        let acting: Vec<(Parameter, f64)> = (space.freedom.free.iter().copied().zip(slopes.iter().copied()))
            .filter(|(_, slope)| slope.abs() > ROUNDING)
            .collect();
        let mut held = *roles;
        match acting.as_slice() {
            [(parameter, slope)] => {
                held[parameter.index()] = Role::Fixed { value: (value - constant) / slope };
            }
            [(kept, a), (follower, b)] => {
                let is_followed = |role: &Role| matches!(role, Role::Linked { other, .. } if other == follower);
                if roles.iter().any(is_followed) {
                    return None;
                }
                let (factor, constant) = (-a / b, (value - constant) / b);
                let Role::Free { lower, upper } = roles[kept.index()] else { return None };
                let Role::Free { lower: least, upper: most } = roles[follower.index()] else { return None };
                // The follower keeps its own bounds by way of the other's.
                let (x, y) = ((least - constant) / factor, (most - constant) / factor);
                let (lower, upper) = (lower.max(x.min(y)), upper.min(x.max(y)));
                held[kept.index()] = if lower < upper {
                    Role::Free { lower, upper }
                } else {
                    Role::Fixed { value: 0.5 * (lower + upper) }
                };
                held[follower.index()] = match held[kept.index()] {
                    Role::Fixed { value } => Role::Fixed { value: constant + factor * value },
                    _ => Role::Linked { other: *kept, factor, constant },
                };
            }
            _ => return None,
        }
        Some(held)
    }
}
