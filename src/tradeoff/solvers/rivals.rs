//! The solvers that are compared: those of argmin, the MINPACK port, and the library's own.

use super::watched::{Difference, Watched};
use crate::optimise::{Tolerances, minimise};
use argmin::core::{CostFunction, Error, Executor, Gradient, Jacobian, Operator};
use argmin::solver::gaussnewton::GaussNewton;
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::neldermead::NelderMead;
use argmin::solver::particleswarm::ParticleSwarm;
use argmin::solver::quasinewton::LBFGS;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt as Minpack};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// A solver with its way of taking derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rival {
    NelderMead,
    ParticleSwarm,
    Lbfgs,
    GaussNewton,
    Minpack,
    /// The library's, with the rivals' derivatives: what is left of a difference is the solver's.
    OursCentral,
    Ours,
}

/// Iterations of a run at most; then the next start is more promising.
const SIMPLEX_STEPS: u64 = 400;
const SWARM_STEPS: u64 = 60;
const GRADIENT_STEPS: u64 = 60;
/// Edge of the first simplex, in ranges.
const SIMPLEX_EDGE: f64 = 0.05;
/// Standard deviation of chi² over a simplex below which it ends.
const SIMPLEX_END: f64 = 1e-3;
const PARTICLES: usize = 40;
/// Pairs that L-BFGS remembers.
const MEMORY: usize = 7;
/// Fall of the length of the residuals below which Gauss–Newton ends.
const FALL: f64 = 1e-6;
/// Step of the gradient of chi², in ranges.
const GRADIENT_STEP: f64 = 1e-6;
/// How steeply chi² rises outside the bounds, where the methods without bounds look: by this factor in a range.
const WALL: f64 = 100.0;

impl Rival {
    pub(crate) const ALL: [Self; 7] = [
        Self::NelderMead,
        Self::ParticleSwarm,
        Self::Lbfgs,
        Self::GaussNewton,
        Self::Minpack,
        Self::OursCentral,
        Self::Ours,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::NelderMead => "Nelder–Mead (argmin)",
            Self::ParticleSwarm => "particle swarm (argmin)",
            Self::Lbfgs => "L-BFGS (argmin)",
            Self::GaussNewton => "Gauss–Newton (argmin)",
            Self::Minpack => "levenberg-marquardt (MINPACK)",
            Self::OursCentral => "ours, whole differences",
            Self::Ours => "ours, local",
        }
    }

    pub(crate) fn difference(self) -> Difference {
        if self == Self::Ours { Difference::Kernel } else { Difference::Central }
    }

    /// One run from `start`; where it ended, unless it broke off.
    pub(crate) fn descend(self, watched: &Watched<'_>, start: &DVector<f64>, seed: u64) -> Option<DVector<f64>> {
        let unit = Unit(watched);
        let begin = unit.share(start);
        let n = start.len();
        let steps = |most: u64| if watched.persistent { u64::MAX } else { most };
        let ended = match self {
            Self::NelderMead => {
                let mut corners = vec![begin; n + 1];
                for (j, corner) in corners.iter_mut().skip(1).enumerate() {
                    corner[j] += if corner[j] > 0.5 { -SIMPLEX_EDGE } else { SIMPLEX_EDGE };
                }
                let solver = NelderMead::new(corners).with_sd_tolerance(SIMPLEX_END).ok()?;
                let run = Executor::new(unit, solver).configure(|state| state.max_iters(steps(SIMPLEX_STEPS)));
                run.timer(false).ctrlc(false).run().ok()?.state.take_best_param()?
            }
            Self::ParticleSwarm => {
                let corners = (DVector::zeros(n), DVector::from_element(n, 1.0));
                let random = Xoshiro256PlusPlus::seed_from_u64(seed);
                let solver = ParticleSwarm::new(corners, PARTICLES).with_rng_generator(random);
                let run = Executor::new(unit, solver).configure(|state| state.max_iters(steps(SWARM_STEPS)));
                run.timer(false).ctrlc(false).run().ok()?.state.take_best_individual()?.position
            }
            Self::Lbfgs => {
                let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
                let run =
                    Executor::new(unit, solver).configure(|state| state.param(begin).max_iters(steps(GRADIENT_STEPS)));
                run.timer(false).ctrlc(false).run().ok()?.state.take_best_param()?
            }
            Self::GaussNewton => {
                let solver = GaussNewton::new().with_tolerance(FALL).ok()?;
                let run =
                    Executor::new(unit, solver).configure(|state| state.param(begin).max_iters(steps(GRADIENT_STEPS)));
                run.timer(false).ctrlc(false).run().ok()?.state.take_param()?
            }
            Self::Minpack => {
                let (end, _) = Minpack::new().minimize(Port { unit, at: begin });
                end.at
            }
            Self::OursCentral | Self::Ours => return Some(minimise(watched, start, TOLERANCES).parameters),
        };
        Some(unit.place(&ended))
    }
}

/// The library's tolerances for a refined minimum.
const TOLERANCES: Tolerances =
    Tolerances { cost: 1e-10, step: 1e-10, gradient: 1e-13, max_evaluations: 400, escapes: 0 };

/// The problem with each parameter as a share of its range, for methods that know no units.
#[derive(Clone, Copy)]
struct Unit<'a, 'b>(&'b Watched<'a>);

fn over() -> Error {
    Error::msg("the budget is spent, or the problem solved")
}

impl Unit<'_, '_> {
    fn place(&self, share: &DVector<f64>) -> DVector<f64> {
        share.component_mul(&self.0.space.ranges) + self.0.space.bounds.lower()
    }

    fn share(&self, place: &DVector<f64>) -> DVector<f64> {
        (place - self.0.space.bounds.lower()).component_div(&self.0.space.ranges)
    }
}

impl CostFunction for Unit<'_, '_> {
    type Param = DVector<f64>;
    type Output = f64;
    /// chi² at the nearest point of the box, raised by the distance from it.
    fn cost(&self, share: &DVector<f64>) -> Result<f64, Error> {
        let inside = share.map(|share| share.clamp(0.0, 1.0));
        let outside = (share - &inside).norm_squared();
        let residuals = self.0.residuals(&self.place(&inside)).ok_or_else(over)?;
        Ok(residuals.norm_squared() * (1.0 + WALL * outside))
    }
}

impl Gradient for Unit<'_, '_> {
    type Param = DVector<f64>;
    type Gradient = DVector<f64>;
    fn gradient(&self, share: &DVector<f64>) -> Result<DVector<f64>, Error> {
        let mut gradient = DVector::zeros(share.len());
        for j in 0..share.len() {
            let moved = |by: f64| {
                let mut place = share.clone();
                place[j] += by;
                self.cost(&place)
            };
            gradient[j] = (moved(GRADIENT_STEP)? - moved(-GRADIENT_STEP)?) / (2.0 * GRADIENT_STEP);
        }
        Ok(gradient)
    }
}

impl Operator for Unit<'_, '_> {
    type Param = DVector<f64>;
    type Output = DVector<f64>;
    fn apply(&self, share: &DVector<f64>) -> Result<DVector<f64>, Error> {
        let residuals = self.0.residuals(&self.place(share)).ok_or_else(over)?;
        // Gauss–Newton goes on with values that are none, and never comes back.
        if self.0.persistent || residuals.iter().all(|residual| residual.is_finite()) {
            Ok(residuals)
        } else {
            Err(Error::msg("no value"))
        }
    }
}

impl Jacobian for Unit<'_, '_> {
    type Param = DVector<f64>;
    type Jacobian = DMatrix<f64>;
    fn jacobian(&self, share: &DVector<f64>) -> Result<DMatrix<f64>, Error> {
        let mut jacobian = self.0.jacobian(&self.place(share)).ok_or_else(over)?;
        for (mut column, range) in jacobian.column_iter_mut().zip(self.0.space.ranges.iter()) {
            column *= *range;
        }
        Ok(jacobian)
    }
}

/// The problem as the MINPACK port sees it.
struct Port<'a, 'b> {
    unit: Unit<'a, 'b>,
    at: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Port<'_, '_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, share: &DVector<f64>) {
        self.at.copy_from(share);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.unit.0.residuals(&self.unit.place(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Jacobian::jacobian(&self.unit, &self.at).ok()
    }
}
