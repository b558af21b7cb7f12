//! Bounded Levenberg–Marquardt as a solver of argmin.
//!
//! Trust region in coordinates scaled by the largest norm each Jacobian column has had, so that units do not matter. A
//! parameter on a bound stays there while the gradient presses it against the bound; a step that would cross a bound
//! ends on it. Steps onto points whose residuals are not finite are refused.
//!
//! # Requirements on the problem
//! [`argmin::core::Operator`] (residuals), [`argmin::core::Jacobian`] and [`Linearise`].
//!
//! # Source
//! Moré 1978, DOI 10.1007/BFb0067700 (MINPACK `lmder`): its radius rules and its tests for the end. That a whole step which promises
//! next to nothing is not tried is ours: its promise is the squared cosine between the residuals and all columns together.

use crate::numerics::dot::dot;
use crate::optimise::bounds::Bounds;
use crate::optimise::objective::Linearise;
use crate::optimise::products::Products;
use crate::optimise::termination::Termination;
use crate::optimise::trust_region::bounded_step;
use argmin::core::{Error, IterState, Jacobian, KV, Operator, Problem, Solver, State, TerminationReason};
use nalgebra::{DMatrix, DVector};

/// When a run ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Relative fall of the cost, predicted and actual, below which it has converged. A step that promises less than a
    /// hundredth of it is not tried.
    pub cost: f64,
    /// Radius of the trust region relative to the parameters below which the step has converged.
    pub step: f64,
    /// Cosine between the residuals and each column of the Jacobian below which the gradient is zero.
    pub gradient: f64,
    /// Evaluations of the residuals (those for derivatives apart) after which the run is ended.
    pub max_evaluations: usize,
    /// How often a stalled run may look round for a lower neighbour and go on from there; for models with kinks.
    pub escapes: usize,
}

impl Default for Tolerances {
    /// To rounding, within 2000 evaluations, for smooth models.
    fn default() -> Self {
        let rounding = 30.0 * f64::EPSILON;
        Self { cost: rounding, step: rounding, gradient: rounding, max_evaluations: 2000, escapes: 0 }
    }
}

/// First radius, as a multiple of the scaled start (MINPACK's factor).
const FIRST_RADIUS: f64 = 100.0;
/// Share of the predicted fall below which a step is refused.
const ACCEPT: f64 = 1e-4;
/// A run that stops short with a cosine above this has not found a minimum.
const STALLED_COSINE: f64 = 1e-3;
/// A step of which the linear problem promises less than this share of the tolerance is not worth an evaluation.
const NOT_TRIED: f64 = 0.01;
/// Residuals this small beside those of the start are rounding: their direction means nothing.
const ROUNDING: f64 = 1e-10;

/// The solver and its memory.
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt {
    bounds: Bounds,
    tolerances: Tolerances,
    radius: f64,
    scaling: DVector<f64>,
    first_norm: f64,
    evaluations: usize,
    termination: Option<Termination>,
    /// Where the run ended, if it asked for them there.
    products: Option<Products>,
}

type Iterate = IterState<DVector<f64>, (), DMatrix<f64>, (), DVector<f64>, f64>;

impl LevenbergMarquardt {
    /// A solver for parameters in `bounds`.
    #[must_use]
    pub fn new(bounds: Bounds, tolerances: Tolerances) -> Self {
        let scaling = DVector::zeros(bounds.len());
        Self {
            bounds,
            tolerances,
            radius: 0.0,
            scaling,
            first_norm: 0.0,
            evaluations: 0,
            termination: None,
            products: None,
        }
    }

    /// How the run ended; `None` before its end.
    #[must_use]
    pub fn termination(&self) -> Option<Termination> {
        self.termination
    }

    /// Residual evaluations so far, those for derivatives apart.
    #[must_use]
    pub fn evaluations(&self) -> usize {
        self.evaluations
    }

    /// `J' J` and `J' r` where the run ended, if it asked for them there.
    pub(crate) fn take_products(&mut self) -> Option<Products> {
        self.products.take()
    }

    fn end(&mut self, state: Iterate, termination: Termination) -> Iterate {
        self.termination = Some(termination);
        state.terminate_with(if termination.was_successful() {
            TerminationReason::SolverConverged
        } else {
            TerminationReason::SolverExit(termination.phrase().to_owned())
        })
    }

    /// Columns that may move: not pressed against a bound by the gradient.
    fn movable(&self, parameters: &DVector<f64>, gradient: &DVector<f64>) -> Vec<usize> {
        (0..parameters.len())
            .filter(|&j| {
                let pressed_down = parameters[j] <= self.bounds.lower()[j] && gradient[j] > 0.0;
                let pressed_up = parameters[j] >= self.bounds.upper()[j] && gradient[j] < 0.0;
                !(pressed_down || pressed_up)
            })
            .collect()
    }
}

fn half_square(residuals: &DVector<f64>) -> f64 {
    let cost = 0.5 * dot(residuals.as_slice(), residuals.as_slice());
    if cost.is_finite() { cost } else { f64::INFINITY }
}

/// Largest cosine between the residuals and the movable columns.
fn largest_cosine(products: &Products, gradient: &DVector<f64>, norm: f64, movable: &[usize]) -> f64 {
    movable
        .iter()
        .map(|&j| {
            let length = products.length(j);
            if length > 0.0 { gradient[j].abs() / (length * norm) } else { 0.0 }
        })
        .fold(0.0, f64::max)
}

impl<O> Solver<O, Iterate> for LevenbergMarquardt
where
    O: Operator<Param = DVector<f64>, Output = DVector<f64>>
        + Jacobian<Param = DVector<f64>, Jacobian = DMatrix<f64>>
        + Linearise,
{
    fn name(&self) -> &'static str {
        "bounded Levenberg-Marquardt"
    }

    fn init(&mut self, problem: &mut Problem<O>, mut state: Iterate) -> Result<(Iterate, Option<KV>), Error> {
        let start = state.take_param().ok_or_else(|| Error::msg("Levenberg-Marquardt needs a start"))?;
        let start = self.bounds.clamp(&start);
        let residuals = problem.apply(&start)?;
        self.evaluations += 1;
        let cost = half_square(&residuals);
        self.first_norm = (2.0 * cost).sqrt();
        let (m, n) = (residuals.len(), start.len());
        let state = state.param(start).residuals(residuals).cost(cost);
        if m < n {
            return Ok((self.end(state, Termination::Underdetermined), None));
        }
        if cost.is_infinite() {
            return Ok((self.end(state, Termination::StartNotFinite), None));
        }
        Ok((state, None))
    }

    fn next_iter(&mut self, problem: &mut Problem<O>, mut state: Iterate) -> Result<(Iterate, Option<KV>), Error> {
        let (Some(parameters), Some(residuals)) = (state.take_param(), state.take_residuals()) else {
            return Err(Error::msg("Levenberg-Marquardt lost its state"));
        };
        let cost = state.cost;
        let norm = (2.0 * cost).sqrt();
        let products = problem.problem("products_count", |problem| Ok(problem.products(&parameters, &residuals)))?;
        let gradient = products.gradient();
        let back =
            |state: Iterate, parameters, residuals, cost| state.param(parameters).residuals(residuals).cost(cost);
        if !gradient.iter().all(|value| value.is_finite()) {
            return Ok((self.end(back(state, parameters, residuals, cost), Termination::Stalled), None));
        }
        for (j, scale) in self.scaling.iter_mut().enumerate() {
            *scale = scale.max(products.length(j));
            if *scale <= 0.0 {
                *scale = 1.0;
            }
        }
        if !self.scaling.iter().all(|scale| scale.is_finite()) {
            return Ok((self.end(back(state, parameters, residuals, cost), Termination::Stalled), None));
        }
        // A parameter that does nothing stays where it is.
        let mut movable = self.movable(&parameters, gradient);
        movable.retain(|&j| products.length(j) > 0.0);
        let cosine = largest_cosine(&products, gradient, norm, &movable);
        let ended = if norm <= 0.0 {
            Some(Termination::ExactFit)
        } else if movable.is_empty() || cosine <= self.tolerances.gradient {
            Some(Termination::GradientConverged)
        } else {
            None
        };
        if let Some(termination) = ended {
            self.products = Some(products);
            return Ok((self.end(back(state, parameters, residuals, cost), termination), None));
        }
        let scaled_size = parameters.component_mul(&self.scaling).norm();
        if self.radius <= 0.0 {
            self.radius = if scaled_size > 0.0 { FIRST_RADIUS * scaled_size } else { FIRST_RADIUS };
        }

        let pick = |vector: &DVector<f64>| DVector::from_fn(movable.len(), |c, _| vector[movable[c]]);
        let (r, b) = match products.triangle(&movable) {
            Some(triangle) => triangle,
            None => {
                let qr = problem.jacobian(&parameters)?.select_columns(&movable).qr();
                let mut rotated = residuals.clone();
                qr.q_tr_mul(&mut rotated);
                (qr.r(), rotated.rows(0, movable.len()).into_owned())
            }
        };
        let d = pick(&self.scaling);
        let lower = pick(&(self.bounds.lower() - &parameters));
        let upper = pick(&(self.bounds.upper() - &parameters));

        loop {
            let trial = bounded_step(&r, &b, &d, self.radius, &lower, &upper);
            let mut moved = parameters.clone();
            for (c, &j) in movable.iter().enumerate() {
                // A step that ends on a wall must end on it to the last bit.
                moved[j] = if trial.step[c] <= lower[c] {
                    self.bounds.lower()[j]
                } else if trial.step[c] >= upper[c] {
                    self.bounds.upper()[j]
                } else {
                    (parameters[j] + trial.step[c]).clamp(self.bounds.lower()[j], self.bounds.upper()[j])
                };
            }
            let length = trial.step.component_mul(&d).norm();
            let predicted = -(&r * &trial.step).dot(&(&b + 0.5 * (&r * &trial.step))) / cost;
            // A step that was cut short promises less than the minimum has, or even a rise.
            if trial.is_whole() && predicted <= NOT_TRIED * self.tolerances.cost {
                self.products = Some(products);
                let state = back(state, parameters, residuals, cost);
                return Ok((self.end(state, Termination::CostConverged), None));
            }
            let new_residuals = problem.apply(&moved)?;
            self.evaluations += 1;
            let new_cost = half_square(&new_residuals);
            let actual = if new_cost.is_finite() { 1.0 - new_cost / cost } else { -1.0 };
            let ratio = if predicted > 0.0 { actual / predicted } else { -1.0 };

            if ratio <= 0.25 {
                let shrink = if new_cost.is_finite() && new_cost > cost && ratio > -10.0 {
                    // minimum of the parabola through the cost here, its slope, and the cost there
                    let slope = (&r * &trial.step).dot(&b) / cost;
                    (0.5 * slope / (slope + actual)).clamp(0.1, 0.5)
                } else if ratio >= 0.0 {
                    0.5
                } else {
                    0.1
                };
                self.radius = shrink * self.radius.min(length * 10.0);
            } else if ratio >= 0.75 || !trial.held_back {
                self.radius = 2.0 * length;
            }

            let accepted = ratio >= ACCEPT;
            let size = if accepted { moved.component_mul(&self.scaling).norm() } else { scaled_size };
            let tolerances = self.tolerances;
            let ended = if actual.abs() <= tolerances.cost && predicted <= tolerances.cost && ratio <= 2.0 {
                Some(Termination::CostConverged)
            } else if self.radius <= tolerances.step * size {
                Some(Termination::StepConverged)
            } else if self.evaluations >= tolerances.max_evaluations {
                Some(Termination::EvaluationBudget)
            } else {
                None
            };
            if let Some(mut termination) = ended {
                let short = termination == Termination::StepConverged && !accepted;
                if short && cosine > STALLED_COSINE && norm > ROUNDING * self.first_norm {
                    termination = Termination::Stalled;
                }
                let state = if accepted {
                    back(state, moved, new_residuals, new_cost)
                } else {
                    self.products = Some(products);
                    back(state, parameters, residuals, cost)
                };
                return Ok((self.end(state, termination), None));
            }
            if accepted {
                return Ok((back(state, moved, new_residuals, new_cost), None));
            }
        }
    }
}
