//! One ensemble of walkers and its two moves.
//!
//! Walkers are moved in two halves, each against the other half, which stands still: so each move leaves the joint
//! density as it is (Foreman-Mackey et al. 2013, DOI 10.1086/670067).

use super::Acceptance;
use super::mixture::Mixture;
use crate::optimise::Bounds;
use nalgebra::DVector;
use rand::Rng;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

/// One jump of differential evolution in so many goes the whole way from one walker to the other, to change modes.
const WHOLE_JUMPS: f64 = 0.1;
/// Of the others, the shortest in the usual length: short ones are accepted where a ridge is curved.
const SHORTEST_JUMP: f64 = 0.2;
/// Jitter of a jump, in standard deviations: keeps walkers from being held in the plane through the others.
const JITTER: f64 = 1e-3;

/// A point with the logarithm of the density, which is finite.
#[derive(Debug, Clone)]
pub(super) struct Walker {
    pub(super) x: DVector<f64>,
    pub(super) log_p: f64,
    /// Of the mixture in use.
    log_q: f64,
}

/// What does not change while a batch of steps runs.
pub(super) struct Moves<'a> {
    pub(super) target: &'a (dyn Fn(&DVector<f64>) -> f64 + Sync),
    pub(super) bounds: &'a Bounds,
    pub(super) mixture: &'a Mixture,
    pub(super) deviations: DVector<f64>,
    /// Share of independence proposals.
    pub(super) share: f64,
}

impl Moves<'_> {
    /// Logarithm of the density where it exists. Outside the box the target is not called.
    fn log_density(&self, x: &DVector<f64>, evaluations: &mut usize) -> Option<f64> {
        evaluate(self.target, self.bounds, x, evaluations)
    }
}

/// Logarithm of the density at `x`, `None` outside the box or where it is not finite.
pub(super) fn evaluate(
    target: &(dyn Fn(&DVector<f64>) -> f64 + Sync),
    bounds: &Bounds,
    x: &DVector<f64>,
    evaluations: &mut usize,
) -> Option<f64> {
    if !bounds.contain(x) || !x.iter().all(|value| value.is_finite()) {
        return None;
    }
    *evaluations += 1;
    Some(target(x)).filter(|value| value.is_finite())
}

/// Walkers, their history and what their moves came to.
#[derive(Debug)]
pub(super) struct Ensemble {
    walkers: Vec<Walker>,
    /// `[walker][step]` since it was last cleared.
    pub(super) history: Vec<Vec<(DVector<f64>, f64)>>,
    pub(super) evaluations: usize,
    pub(super) independence: Acceptance,
    pub(super) evolution: Acceptance,
    random: Xoshiro256PlusPlus,
}

impl Ensemble {
    pub(super) fn new(starts: &[(DVector<f64>, f64)], random: Xoshiro256PlusPlus) -> Self {
        let walker = |(x, log_p): &(DVector<f64>, f64)| Walker { x: x.clone(), log_p: *log_p, log_q: 0.0 };
        Self {
            walkers: starts.iter().map(walker).collect(),
            history: vec![Vec::new(); starts.len()],
            evaluations: 0,
            independence: Acceptance::default(),
            evolution: Acceptance::default(),
            random,
        }
    }

    /// Forgets history and counts of moves.
    pub(super) fn clear(&mut self) {
        self.history.iter_mut().for_each(Vec::clear);
        self.forget_moves();
    }

    /// Forgets counts of moves.
    pub(super) fn forget_moves(&mut self) {
        self.independence = Acceptance::default();
        self.evolution = Acceptance::default();
    }

    /// Moves each walker `steps` times.
    pub(super) fn run(&mut self, moves: &Moves<'_>, steps: usize) {
        for walker in &mut self.walkers {
            walker.log_q = moves.mixture.log_density(&walker.x);
        }
        for _ in 0..steps {
            let middle = self.walkers.len() / 2;
            for index in 0..self.walkers.len() {
                let others = if index < middle { middle..self.walkers.len() } else { 0..middle };
                if self.random.random::<f64>() < moves.share {
                    self.propose_from_mixture(moves, index);
                } else {
                    self.propose_from_others(moves, index, others);
                }
            }
            for (walker, history) in self.walkers.iter().zip(&mut self.history) {
                history.push((walker.x.clone(), walker.log_p));
            }
        }
    }

    /// Accepted with probability `min(1, p(y) q(x) / (p(x) q(y)))`.
    fn propose_from_mixture(&mut self, moves: &Moves<'_>, index: usize) {
        let x = moves.mixture.draw(&mut self.random);
        let threshold = self.random.random::<f64>().ln();
        self.independence.proposed += 1;
        let Some(log_p) = moves.log_density(&x, &mut self.evaluations) else { return };
        let log_q = moves.mixture.log_density(&x);
        let Some(walker) = self.walkers.get_mut(index) else { return };
        if threshold < (log_p - log_q) - (walker.log_p - walker.log_q) {
            *walker = Walker { x, log_p, log_q };
            self.independence.accepted += 1;
        }
    }

    /// `y = x + gamma (a - b) + jitter`, accepted with probability `min(1, p(y) / p(x))`: symmetric, as `a` and `b` are
    /// of the other half (ter Braak 2006, DOI 10.1007/s11222-006-8769-1).
    fn propose_from_others(&mut self, moves: &Moves<'_>, index: usize, others: std::ops::Range<usize>) {
        #[allow(clippy::cast_precision_loss, reason = "few parameters")]
        let usual = 2.38 / (2.0 * moves.deviations.len() as f64).sqrt();
        let length = SHORTEST_JUMP.powf(self.random.random::<f64>());
        let gamma = if self.random.random::<f64>() < WHOLE_JUMPS { 1.0 } else { usual * length };
        let first = self.random.random_range(others.clone());
        let mut second = self.random.random_range(others.start..others.end - 1);
        if second >= first {
            second += 1;
        }
        let (Some(a), Some(b)) = (self.walkers.get(first), self.walkers.get(second)) else { return };
        let mut x = (&a.x - &b.x) * gamma;
        for (value, deviation) in x.iter_mut().zip(&moves.deviations) {
            *value += JITTER * deviation * self.random.sample::<f64, _>(StandardNormal);
        }
        let threshold = self.random.random::<f64>().ln();
        let Some(walker) = self.walkers.get_mut(index) else { return };
        x += &walker.x;
        self.evolution.proposed += 1;
        let Some(log_p) = moves.log_density(&x, &mut self.evaluations) else { return };
        if threshold < log_p - walker.log_p {
            let log_q = moves.mixture.log_density(&x);
            *walker = Walker { x, log_p, log_q };
            self.evolution.accepted += 1;
        }
    }
}
