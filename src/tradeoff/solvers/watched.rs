//! A least-squares problem under watch: a budget, the best point so far, and when it was good enough.

use crate::inversion::{Problem, Space};
use crate::optimise::{Bounds, LeastSquares, central_jacobian};
use crate::tradeoff::Clock;
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

/// How a rival's derivatives are taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Difference {
    /// The fit's own, term by term.
    Kernel,
    /// Central differences of the whole residuals, with the step that the library chooses.
    Central,
    /// Forward differences with this step, relative to the parameter.
    FixedForward(f64),
    /// Central differences with this step.
    FixedCentral(f64),
}

/// A parameter's step is relative to at least this share of its range: the tilt may be 0.
const LEAST_SIZE: f64 = 0.01;

/// The problem and its record.
pub(crate) struct Watched<'a> {
    problem: &'a Problem<'a>,
    pub(crate) space: &'a Space,
    difference: Difference,
    clock: Clock<'a>,
    began: f64,
    seconds: f64,
    most: usize,
    goal: f64,
    single: bool,
    /// Whether a method without an end of its own is let run until the budget ends it.
    pub(crate) persistent: bool,
    record: RefCell<Record>,
}

#[derive(Debug, Default)]
struct Record {
    evaluations: usize,
    solved: Option<f64>,
}

impl<'a> Watched<'a> {
    /// Without a limit or goal.
    pub(crate) fn new(problem: &'a Problem<'a>, space: &'a Space, difference: Difference, clock: Clock<'a>) -> Self {
        let record = RefCell::default();
        let (seconds, most, goal) = (f64::INFINITY, usize::MAX, f64::NEG_INFINITY);
        Self {
            problem,
            space,
            difference,
            clock,
            began: clock(),
            seconds,
            most,
            goal,
            single: false,
            persistent: false,
            record,
        }
    }

    pub(crate) fn for_seconds(mut self, seconds: f64) -> Self {
        self.seconds = seconds;
        self
    }

    /// Without any other limit on a run.
    pub(crate) fn for_evaluations(mut self, most: usize) -> Self {
        (self.most, self.persistent) = (most, true);
        self
    }

    /// With residuals rounded to single precision, as of a model in it.
    pub(crate) fn in_single_precision(mut self, single: bool) -> Self {
        self.single = single;
        self
    }

    /// Over once a point inside the bounds has this sum of squares or less.
    pub(crate) fn until(mut self, goal: f64) -> Self {
        self.goal = goal;
        self
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.record.borrow().evaluations >= self.most || (self.clock)() - self.began > self.seconds
    }

    pub(crate) fn is_over(&self) -> bool {
        self.record.borrow().solved.is_some() || self.is_spent()
    }

    pub(crate) fn seconds_until_solved(&self) -> Option<f64> {
        self.record.borrow().solved
    }

    /// Residuals; `None` once it is over.
    pub(crate) fn residuals(&self, parameters: &DVector<f64>) -> Option<DVector<f64>> {
        if self.is_over() {
            return None;
        }
        let mut residuals = self.problem.residuals(parameters);
        if self.single {
            #[allow(clippy::cast_possible_truncation, reason = "that is what is tried")]
            residuals.apply(|residual| *residual = f64::from(*residual as f32));
        }
        let mut record = self.record.borrow_mut();
        record.evaluations += 1;
        if residuals.norm_squared() <= self.goal && self.space.bounds.contain(parameters) {
            record.solved = Some((self.clock)() - self.began);
        }
        Some(residuals)
    }

    fn or_forbidden(&self, parameters: &DVector<f64>) -> DVector<f64> {
        self.residuals(parameters).unwrap_or_else(|| DVector::from_element(self.problem.len(), f64::INFINITY))
    }

    /// Derivatives, as the rival takes them; `None` once it is over.
    pub(crate) fn jacobian(&self, parameters: &DVector<f64>) -> Option<DMatrix<f64>> {
        if self.is_over() {
            return None;
        }
        let fixed = |relative: f64, central: bool| {
            let here = self.or_forbidden(parameters);
            let columns: Vec<DVector<f64>> = (0..parameters.len())
                .map(|j| {
                    let step = relative * parameters[j].abs().max(LEAST_SIZE * self.space.ranges[j]);
                    let moved = |by: f64| {
                        let mut place = parameters.clone();
                        place[j] += by;
                        self.or_forbidden(&place)
                    };
                    if central { (moved(step) - moved(-step)) / (2.0 * step) } else { (moved(step) - &here) / step }
                })
                .collect();
            DMatrix::from_columns(&columns)
        };
        Some(match self.difference {
            Difference::Kernel => {
                self.record.borrow_mut().evaluations += 1;
                self.problem.jacobian(parameters)
            }
            Difference::Central => central_jacobian(
                |place| self.or_forbidden(place),
                parameters,
                &self.space.scales,
                &Bounds::none(parameters.len()),
            ),
            Difference::FixedForward(step) => fixed(step, false),
            Difference::FixedCentral(step) => fixed(step, true),
        })
    }
}

/// As the library's own solver sees it; once it is over every point is forbidden.
impl LeastSquares for Watched<'_> {
    fn residuals(&self, parameters: &DVector<f64>) -> DVector<f64> {
        self.or_forbidden(parameters)
    }

    fn bounds(&self) -> &Bounds {
        &self.space.bounds
    }

    fn scales(&self) -> &DVector<f64> {
        &self.space.scales
    }

    fn jacobian(&self, parameters: &DVector<f64>) -> DMatrix<f64> {
        let over = || DMatrix::from_element(self.problem.len(), parameters.len(), f64::NAN);
        Watched::jacobian(self, parameters).unwrap_or_else(over)
    }
}
