//! The five parameters as a fit sees them: names, units, bounds, and which of them are free.

use crate::optics::Structure;
use crate::units;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Number of structure parameters.
pub const COUNT: usize = 5;

/// One of the five parameters, in the order of every parameter vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameter {
    /// Thickness of one air gap.
    DAir,
    /// Thickness of one cuticle layer.
    DCuticle,
    /// Mean tilt of the multilayer.
    Delta,
    /// Half-width of the lobe.
    PhiAlpha,
    /// Width of a lamella, `a`.
    LamellaWidth,
}

impl Parameter {
    /// All five, in order.
    pub const ALL: [Self; COUNT] = [Self::DAir, Self::DCuticle, Self::Delta, Self::PhiAlpha, Self::LamellaWidth];

    /// The name in options, files and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DAir => "d_air",
            Self::DCuticle => "d_cuticle",
            Self::Delta => "delta",
            Self::PhiAlpha => "phi_alpha",
            Self::LamellaWidth => "lamella_width",
        }
    }

    /// The parameter of that name; `a` is accepted for the lamella width.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        if name == "a" {
            return Some(Self::LamellaWidth);
        }
        Self::ALL.into_iter().find(|parameter| parameter.name() == name)
    }

    /// The unit users write and read: nm, deg or rad. Inside, angles are radians.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::DAir | Self::DCuticle | Self::LamellaWidth => "nm",
            Self::Delta => "deg",
            Self::PhiAlpha => "rad",
        }
    }

    /// A value in the user's unit as the library holds it.
    #[must_use]
    pub fn inside(self, value: f64) -> f64 {
        if self == Self::Delta { units::radians(value) } else { value }
    }

    /// A value of the library in the user's unit.
    #[must_use]
    pub fn outside(self, value: f64) -> f64 {
        if self == Self::Delta { units::degrees(value) } else { value }
    }

    /// Default bounds, inside units: what scales of butterflies, beetles and feathers are built of.
    #[must_use]
    pub fn default_bounds(self) -> (f64, f64) {
        match self {
            Self::DAir | Self::DCuticle => (20.0, 300.0),
            Self::Delta => (-units::radians(10.0), units::radians(10.0)),
            Self::PhiAlpha => (0.1, 1.2),
            Self::LamellaWidth => (100.0, 600.0),
        }
    }

    /// The widest bounds that make sense, inside units; what a user may ask for.
    #[must_use]
    pub fn domain(self) -> (f64, f64) {
        match self {
            Self::DAir | Self::DCuticle => (0.0, 1e6),
            Self::Delta => (-units::radians(89.0), units::radians(89.0)),
            Self::PhiAlpha => (1e-3, std::f64::consts::PI),
            Self::LamellaWidth => (1e-3, 1e6),
        }
    }

    /// A change that matters, inside units: the least scale of difference steps.
    #[must_use]
    pub fn typical_change(self) -> f64 {
        match self {
            Self::DAir | Self::DCuticle => 10.0,
            Self::Delta => units::radians(1.0),
            Self::PhiAlpha => 0.1,
            Self::LamellaWidth => 30.0,
        }
    }

    /// Index in [`Parameter::ALL`].
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }
}

impl std::fmt::Display for Parameter {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

/// The structure of a parameter vector `[d_air, d_cuticle, delta, phi_alpha, lamella_width]`, inside units.
#[must_use]
pub fn structure(values: &[f64; COUNT]) -> Structure {
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = *values;
    Structure { d_air, d_cuticle, delta, phi_alpha, lamella_width }
}

/// The parameter vector of a structure, inside units.
#[must_use]
pub fn values(structure: &Structure) -> [f64; COUNT] {
    let Structure { d_air, d_cuticle, delta, phi_alpha, lamella_width } = *structure;
    [d_air, d_cuticle, delta, phi_alpha, lamella_width]
}

/// Whether a structure makes sense at all.
pub(crate) fn inside(values: &[f64; COUNT]) -> bool {
    Parameter::ALL.iter().zip(values).all(|(parameter, value)| {
        let (lower, upper) = parameter.domain();
        (lower..=upper).contains(value)
    })
}

/// Five inside values in the user's units.
#[must_use]
pub(crate) fn outside(inside: &[f64; COUNT]) -> [f64; COUNT] {
    Parameter::ALL.map(|parameter| parameter.outside(inside[parameter.index()]))
}

/// What one parameter may do in a fit; values in the library's units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Fitted between bounds.
    Free {
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// Known.
    Fixed {
        /// Its value.
        value: f64,
    },
    /// Follows another parameter: `constant + factor · other`.
    Linked {
        /// The parameter it follows, which is free.
        other: Parameter,
        /// Multiple of the other.
        factor: f64,
        /// What is added.
        constant: f64,
    },
}

/// The affine map from the free parameters to all five.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Freedom {
    /// The free parameters, in order.
    pub(crate) free: Vec<Parameter>,
    offset: [f64; COUNT],
    matrix: DMatrix<f64>,
}

impl Freedom {
    /// The map of five roles; a role linked to a parameter that is fixed is a constant.
    #[must_use]
    pub(crate) fn new(roles: &[Role; COUNT]) -> Self {
        let is_free = |parameter: Parameter| matches!(roles[parameter.index()], Role::Free { .. });
        let free: Vec<Parameter> = Parameter::ALL.into_iter().filter(|&parameter| is_free(parameter)).collect();
        let mut offset = [0.0; COUNT];
        let mut matrix = DMatrix::zeros(COUNT, free.len());
        let column = |parameter| free.iter().position(|&other| other == parameter);
        for (row, role) in roles.iter().enumerate() {
            match *role {
                Role::Free { .. } => {
                    if let Some(column) = column(Parameter::ALL[row]) {
                        matrix[(row, column)] = 1.0;
                    }
                }
                Role::Fixed { value } => offset[row] = value,
                Role::Linked { other, factor, constant } => {
                    offset[row] = constant;
                    match (column(other), roles[other.index()]) {
                        (Some(column), _) => matrix[(row, column)] = factor,
                        (None, Role::Fixed { value }) => offset[row] += factor * value,
                        (None, _) => {}
                    }
                }
            }
        }
        Self { free, offset, matrix }
    }

    /// All five values for the free ones.
    #[must_use]
    pub(crate) fn expand(&self, free: &DVector<f64>) -> [f64; COUNT] {
        if let (true, Ok(all)) = (self.is_all_free(), free.as_slice().try_into()) {
            return all;
        }
        let mut all = self.offset;
        for (row, value) in all.iter_mut().enumerate() {
            for (column, free) in free.iter().enumerate() {
                *value += self.matrix[(row, column)] * free;
            }
        }
        all
    }

    /// The free ones of all five.
    #[must_use]
    pub(crate) fn restrict(&self, all: &[f64; COUNT]) -> DVector<f64> {
        DVector::from_iterator(self.free.len(), self.free.iter().map(|parameter| all[parameter.index()]))
    }

    /// Whether every parameter is free: then the map is the identity.
    pub(crate) fn is_all_free(&self) -> bool {
        self.free.len() == COUNT
    }

    /// `d all / d free`, `[5, n]`.
    #[must_use]
    pub(crate) fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Whether `parameter` moves with any free one.
    #[must_use]
    pub(crate) fn moves(&self, parameter: Parameter) -> bool {
        self.matrix.row(parameter.index()).iter().any(|value| value.abs() > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_link_of_the_two_thicknesses_is_an_affine_map() {
        // Fig. 16: d_cuticle = 235 nm - d_air.
        let mut roles = Parameter::ALL.map(|parameter| Role::Fixed { value: parameter.default_bounds().0 });
        roles[0] = Role::Free { lower: 20.0, upper: 200.0 };
        roles[1] = Role::Linked { other: Parameter::DAir, factor: -1.0, constant: 235.0 };
        let freedom = Freedom::new(&roles);
        let all = freedom.expand(&DVector::from_element(1, 135.0));
        assert_eq!(all[..2], [135.0, 100.0]);
        assert!(freedom.moves(Parameter::DCuticle) && !freedom.moves(Parameter::Delta));
        assert_eq!(freedom.restrict(&all).as_slice(), &[135.0]);
    }

    #[test]
    fn names_round_trip() {
        for parameter in Parameter::ALL {
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
            assert_eq!(parameter, Parameter::ALL[parameter.index()]);
        }
        assert_eq!(Parameter::from_name("a"), Some(Parameter::LamellaWidth));
        assert_eq!(Parameter::from_name("d_gap"), None);
    }
}
