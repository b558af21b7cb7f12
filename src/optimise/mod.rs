//! Bounded nonlinear least squares over vectors: objective, bounds, solver, many starts. Knows no optics.
//!
//! ```text
//! minimise  cost(p) = 1/2 · sum_i r_i(p)²   over   lower_j <= p_j <= upper_j
//! ```
//!
//! [`argmin`] is the engine: [`LevenbergMarquardt`] is one of its solvers, and [`minimise`] runs it. How a run ended is
//! data, [`Termination`], never an error.

mod bounds;
mod difference;
mod levenberg_marquardt;
mod loss;
mod minimise;
mod multistart;
mod objective;
mod products;
mod termination;
mod trust_region;

pub use bounds::{Bounds, BoundsError};
pub use difference::{central_jacobian, derivative, step};
pub use levenberg_marquardt::{LevenbergMarquardt, Tolerances};
pub use loss::Loss;
pub use minimise::{Minimum, minimise};
pub use multistart::{merge_equal, merge_near, multistart};
pub use objective::{ArgminProblem, LeastSquares, Linearise};
pub use products::Products;
pub(crate) use products::without_columns;
pub use termination::Termination;
