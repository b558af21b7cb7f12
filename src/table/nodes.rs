//! Where a table has its nodes.

use super::error::TableError;
use std::f64::consts::{FRAC_PI_2, PI};

/// Angles that rounding put past 90° by this share still belong to it.
const ROUNDING: f64 = 1e-12;

/// What the second axis of a table counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Across {
    /// `θ + φ`, the angle between the view and the mirror direction of an untilted surface.
    #[default]
    Mirror,
    /// The view φ itself.
    View,
}

impl Across {
    /// The second coordinate of a direction, rad.
    ///
    /// ```
    /// use morpho_fit::table::Across;
    /// assert_eq!(Across::Mirror.of(0.25, -0.25), 0.0);
    /// assert_eq!(Across::View.of(0.25, -0.25), -0.25);
    /// ```
    #[must_use]
    #[inline]
    pub fn of(self, theta: f64, phi: f64) -> f64 {
        match self {
            Self::Mirror => theta + phi,
            Self::View => phi,
        }
    }

    /// The view that the second coordinate `at` means at incidence `theta`, rad.
    #[must_use]
    #[inline]
    pub fn phi(self, theta: f64, at: f64) -> f64 {
        match self {
            Self::Mirror => at - theta,
            Self::View => at,
        }
    }

    /// What the axis is called in a file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mirror => "theta + phi",
            Self::View => "phi",
        }
    }
}

/// In what a table is linear between two planes ω.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Turn {
    /// `sin² ω`: exact for a model that is a sum of two planes. ω from 0 to 90°.
    #[default]
    Share,
    /// ω.
    Angle,
}

impl Turn {
    /// The coordinate of a plane.
    #[must_use]
    #[inline]
    pub fn of(self, omega: f64) -> f64 {
        match self {
            Self::Share => {
                let sin = omega.sin();
                sin * sin
            }
            Self::Angle => omega,
        }
    }

    /// The plane of a coordinate, rad; of a share that in 0 to 90°.
    #[must_use]
    pub fn omega(self, at: f64) -> f64 {
        match self {
            Self::Share => at.clamp(0.0, 1.0).sqrt().asin(),
            Self::Angle => at,
        }
    }

    /// What it is called in a file.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Share => "sin^2(omega)",
            Self::Angle => "omega",
        }
    }
}

/// The nodes of a table: every combination of the values of its three axes, rad, which rise.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes {
    theta: Vec<f64>,
    across: Vec<f64>,
    omega: Vec<f64>,
    kind: Across,
    turn: Turn,
}

impl Nodes {
    /// - `theta`: incidences, at most 90° in size.
    /// - `across`: φ, at most 90° in size, or θ + φ, at most 180°. Where θ + φ and θ make a φ beyond 90°, a node only serves
    ///   the cells that reach up to there.
    /// - `omega`: planes, at most 90° in size, for [`Turn::Share`] not below 0.
    ///
    /// # Errors
    /// [`TableError::Axis`] for an axis without a value, with values that do not rise or are out of range.
    ///
    /// ```
    /// use morpho_fit::table::{Across, Nodes, Turn};
    /// let nodes = Nodes::new(vec![0.0, 0.5], vec![-0.5, 0.0, 0.5], vec![0.0, 1.5], Across::View, Turn::Share)?;
    /// assert_eq!(nodes.count(), 12);
    /// assert!(Nodes::new(vec![0.5, 0.0], vec![0.0], vec![0.0], Across::View, Turn::Share).is_err());
    /// # Ok::<(), morpho_fit::table::TableError>(())
    /// ```
    pub fn new(
        theta: Vec<f64>,
        across: Vec<f64>,
        omega: Vec<f64>,
        kind: Across,
        turn: Turn,
    ) -> Result<Self, TableError> {
        let quarter = FRAC_PI_2 * (1.0 + ROUNDING);
        let widest = if kind == Across::View { quarter } else { PI * (1.0 + ROUNDING) };
        let lowest = if turn == Turn::Share { 0.0 } else { -quarter };
        checked("theta", &theta, -quarter, quarter)?;
        checked(kind.name(), &across, -widest, widest)?;
        checked("omega", &omega, lowest, quarter)?;
        if omega.windows(2).any(|pair| turn.of(pair[0]) >= turn.of(pair[1])) {
            return Err(TableError::Axis { axis: "omega", problem: "has planes that are too close to each other" });
        }
        Ok(Self { theta, across, omega, kind, turn })
    }

    /// Incidences, rad.
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// The second axis, rad.
    #[must_use]
    pub fn across(&self) -> &[f64] {
        &self.across
    }

    /// Planes, rad.
    #[must_use]
    pub fn omega(&self) -> &[f64] {
        &self.omega
    }

    /// What the second axis counts.
    #[must_use]
    pub fn kind(&self) -> Across {
        self.kind
    }

    /// In what the table is linear between two planes.
    #[must_use]
    pub fn turn(&self) -> Turn {
        self.turn
    }

    /// Number of nodes.
    #[must_use]
    pub fn count(&self) -> usize {
        self.theta.len() * self.across.len() * self.omega.len()
    }
}

fn checked(axis: &'static str, values: &[f64], low: f64, high: f64) -> Result<(), TableError> {
    let problem = if values.is_empty() {
        "has no value"
    } else if values.iter().any(|value| !(low..=high).contains(value)) {
        "has a value out of range: directions lie within 90° of the normal, planes within 0 to 90°"
    } else if values.windows(2).any(|pair| pair[0] >= pair[1]) {
        "does not rise"
    } else {
        return Ok(());
    };
    Err(TableError::Axis { axis, problem })
}
