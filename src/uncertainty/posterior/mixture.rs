//! A mixture of multivariate Student distributions: the proposal that knows the modes, and its fit to samples.
//!
//! ```text
//! q(x) = sum_k w_k t(x; c_k, S_k),   t(x; c, S) ~ |S|^(-1/2) (1 + δ/nu)^(-(nu + d)/2),   δ = (x - c)' S⁻¹ (x - c)
//! ```
//!
//! The fit is expectation and maximisation with nu held (Peel, `McLachlan` 2000, DOI 10.1023/A:1008981510081), so that
//! it is this `q` itself that comes nearest to the samples. Where the density is far above `q`, a component is added
//! (Hoogerheide, Opschoor, van Dijk 2012, DOI 10.1016/j.jeconom.2012.06.011).

use nalgebra::{Cholesky, DMatrix, DVector};
use rand::Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Degrees of freedom of the tails. On a normal density in 5 dimensions 73, 79, 85 and 89 % of the draws are accepted with
/// 5, 8, 15 and 30; but the more, the longer a walker is stuck where the density has the heavier tail.
pub(super) const FREEDOM: f64 = 15.0;
/// Smallest eigenvalue of a correlation matrix that is kept; below it two parameters are one to rounding.
const THINNEST: f64 = 1e-10;
/// No component has less than its part of this share of the weight: a mode is not given up for lack of luck.
const LEAST_SHARE: f64 = 0.02;
/// Weight of a component that covers all others, against walkers stuck where these have no density: the time to leave
/// grows with the weight `p/q`, which it bounds. What falls on it is mostly rejected.
const DEFENCE: f64 = 0.03;
/// Its deviations, in those of the whole mixture.
const DEFENCE_WIDTH: f64 = 3.0;
/// Passes of a fit. The samples, not the last digit of the fit, set its error.
const PASSES: usize = 8;
/// A new component starts from one of these shares of the samples, those nearest to where it is missing.
const NEIGHBOURS: [f64; 2] = [0.15, 0.05];
/// A component is added while the mean log density of samples that were not fitted grows by so much.
const GAIN: f64 = 0.01;
/// Components of a mixture at most, beside the modes.
const ADDED: usize = 16;
/// A fit ends after so many candidates for one more component in a row that gain nothing, and after so many in all.
const FAILURES: usize = 2;
const TRIES: usize = 10;

/// One component.
#[derive(Debug, Clone)]
struct Component {
    centre: DVector<f64>,
    /// Scale matrix `S`.
    scale: DMatrix<f64>,
    /// `L` of `S = L L'`.
    factor: DMatrix<f64>,
    /// `L⁻¹`.
    inverse: DMatrix<f64>,
    /// `ln |S|^(1/2)`.
    log_volume: f64,
    weight: f64,
}

impl Component {
    fn new(centre: DVector<f64>, scale: DMatrix<f64>, weight: f64) -> Option<Self> {
        let (scale, factor) = decompose(&scale)?;
        let inverse = factor.solve_lower_triangular(&DMatrix::identity(centre.len(), centre.len()))?;
        let log_volume = factor.diagonal().iter().map(|value| value.ln()).sum();
        let good = inverse.iter().all(|value| value.is_finite()) && f64::is_finite(log_volume);
        good.then_some(Self { centre, scale, factor, inverse, log_volume, weight })
    }

    /// `(x - c)' S⁻¹ (x - c)`.
    fn distance(&self, x: &DVector<f64>) -> f64 {
        let mut sum = 0.0;
        for i in 0..x.len() {
            let part: f64 = (0..=i).map(|j| self.inverse[(i, j)] * (x[j] - self.centre[j])).sum();
            sum += part * part;
        }
        sum
    }

    /// `ln(w t)` and `δ`.
    fn log_density(&self, x: &DVector<f64>) -> (f64, f64) {
        let distance = self.distance(x);
        #[allow(clippy::cast_precision_loss, reason = "few parameters")]
        let exponent = (FREEDOM + x.len() as f64) / 2.0;
        (self.weight.ln() - self.log_volume - exponent * (distance / FREEDOM).ln_1p(), distance)
    }
}

/// A covariance and its Cholesky factor; one that is singular or indefinite is made thin instead. `None` if a variance
/// is not above 0 and finite.
fn decompose(covariance: &DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let n = covariance.nrows();
    let deviations = covariance.diagonal().map(f64::sqrt);
    if !deviations.iter().all(|value| value.is_finite() && *value > 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        let mean = f64::midpoint(covariance[(i, j)] / deviations[i], covariance[(j, i)] / deviations[i]);
        if i == j { 1.0 } else { (mean / deviations[j]).clamp(-1.0, 1.0) }
    });
    if !scaled.iter().all(|value| value.is_finite()) {
        return None;
    }
    let eigen = scaled.clone().try_symmetric_eigen(f64::EPSILON, 0)?;
    let correlation = if eigen.eigenvalues.min() < THINNEST {
        let values = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(THINNEST)));
        &eigen.eigenvectors * values * eigen.eigenvectors.transpose()
    } else {
        scaled
    };
    let units = DMatrix::from_diagonal(&deviations);
    let factor = &units * Cholesky::new(correlation.clone())?.unpack();
    Some((&units * correlation * &units, factor))
}

/// A mixture; its first components are the modes it was made of.
#[derive(Debug, Clone)]
pub(super) struct Mixture {
    components: Vec<Component>,
    modes: usize,
    /// Of the mean and covariance of all, made wide.
    defence: Option<Component>,
    tail: ChiSquared<f64>,
}

impl Mixture {
    /// Of `(centre, scale matrix, weight)`. `None` if there is none or one has no volume.
    pub(super) fn new(parts: Vec<(DVector<f64>, DMatrix<f64>, f64)>) -> Option<Self> {
        let components: Option<Vec<Component>> =
            parts.into_iter().map(|(centre, scale, weight)| Component::new(centre, scale, weight)).collect();
        let components = components.filter(|components| !components.is_empty())?;
        let modes = components.len();
        Some(Self { components, modes, defence: None, tail: ChiSquared::new(FREEDOM).ok()? }.normalised())
    }

    fn normalised(mut self) -> Self {
        let sum: f64 = self.components.iter().map(|component| component.weight).sum();
        #[allow(clippy::cast_precision_loss, reason = "few components")]
        let even = 1.0 / self.components.len() as f64;
        for component in &mut self.components {
            let share = if sum > 0.0 { component.weight / sum } else { even };
            component.weight = (1.0 - LEAST_SHARE) * share + LEAST_SHARE * even;
        }
        self
    }

    /// The same with every deviation times `factor`.
    pub(super) fn widened(&self, factor: f64) -> Option<Self> {
        let part = |c: &Component| (c.centre.clone(), &c.scale * (factor * factor), c.weight);
        Self::new(self.components.iter().map(part).collect())
    }

    fn all(&self) -> impl Iterator<Item = &Component> {
        self.components.iter().chain(&self.defence)
    }

    /// With a wide component that covers all others.
    fn defended(mut self) -> Self {
        let Some(n) = self.components.first().map(|component| component.centre.len()) else { return self };
        let centre = self.components.iter().fold(DVector::zeros(n), |sum: DVector<f64>, c| sum + &c.centre * c.weight);
        let mut scale = DMatrix::zeros(n, n);
        for component in &self.components {
            let from = &component.centre - &centre;
            scale += (&component.scale + &from * from.transpose()) * component.weight;
        }
        self.defence = Component::new(centre, scale * (DEFENCE_WIDTH * DEFENCE_WIDTH), DEFENCE);
        if self.defence.is_some() {
            self.components.iter_mut().for_each(|component| component.weight *= 1.0 - DEFENCE);
        }
        self
    }

    /// Whether there are more components than modes.
    pub(super) fn is_extended(&self) -> bool {
        self.len() > self.modes
    }

    /// Number of components, without the defence.
    pub(super) fn len(&self) -> usize {
        self.components.len()
    }

    /// Logarithm of the density, up to a constant that all mixtures of this dimension share.
    pub(super) fn log_density(&self, x: &DVector<f64>) -> f64 {
        let mut logs = self.all().map(|component| component.log_density(x).0);
        let first = logs.next().unwrap_or(f64::NEG_INFINITY);
        logs.fold(first, |a, b| {
            let (low, high) = if a < b { (a, b) } else { (b, a) };
            if high > f64::NEG_INFINITY { high + (low - high).exp().ln_1p() } else { high }
        })
    }

    pub(super) fn draw(&self, random: &mut Xoshiro256PlusPlus) -> DVector<f64> {
        let mut left = random.random::<f64>();
        let chosen = self.all().find(|component| {
            left -= component.weight;
            left < 0.0
        });
        let Some(component) = chosen.or(self.components.last()) else {
            return DVector::zeros(0);
        };
        let stretch = (FREEDOM / self.tail.sample(random)).sqrt();
        let normal = DVector::from_fn(component.centre.len(), |_, _| random.sample::<f64, _>(StandardNormal) * stretch);
        &component.centre + &component.factor * normal
    }

    /// Standard deviation of each parameter over the whole mixture.
    pub(super) fn deviations(&self) -> DVector<f64> {
        let n = self.components.first().map_or(0, |component| component.centre.len());
        let mean = self.components.iter().fold(DVector::zeros(n), |sum: DVector<f64>, c| sum + &c.centre * c.weight);
        DVector::from_fn(n, |j, _| {
            let part = |c: &Component| c.weight * (c.scale[(j, j)] + (c.centre[j] - mean[j]).powi(2));
            self.components.iter().map(part).sum::<f64>().sqrt()
        })
    }

    /// The mixture nearest to samples of the density, from this one as start, with as many components as they justify.
    ///
    /// - `fitted`, `held`: two independent sets of samples with the logarithm of their density; the second decides on
    ///   the number of components.
    pub(super) fn refitted(&self, fitted: &[(DVector<f64>, f64)], held: &[(DVector<f64>, f64)]) -> Self {
        let mut best = Self { defence: None, ..self.clone() }.normalised().maximised(fitted);
        let mut quality = best.mean_log_density(held);
        let mut failures = 0;
        for _ in 0..TRIES {
            if failures == FAILURES || best.len() >= self.modes + ADDED {
                break;
            }
            let share = NEIGHBOURS[failures % NEIGHBOURS.len()];
            failures += 1;
            let Some(candidate) = best.with_one_more(fitted, share) else { continue };
            let candidate = candidate.maximised(fitted);
            let found = candidate.mean_log_density(held);
            if found > quality + GAIN {
                (best, quality, failures) = (candidate, found, 0);
            }
        }
        let all: Vec<_> = fitted.iter().chain(held).cloned().collect();
        best.maximised(&all).defended()
    }

    #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    fn mean_log_density(&self, samples: &[(DVector<f64>, f64)]) -> f64 {
        samples.iter().map(|(x, _)| self.log_density(x)).sum::<f64>() / samples.len().max(1) as f64
    }

    /// With a component more, of the `share` of the samples about the one where the density is farthest above the mixture.
    fn with_one_more(&self, samples: &[(DVector<f64>, f64)], share: f64) -> Option<Self> {
        let missing = samples.iter().map(|(x, log_p)| (log_p - self.log_density(x), x));
        let centre = missing.max_by(|a, b| a.0.total_cmp(&b.0))?.1;
        let units = self.deviations();
        let mut near: Vec<(f64, &DVector<f64>)> =
            samples.iter().map(|(x, _)| ((x - centre).component_div(&units).norm_squared(), x)).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        #[allow(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of a count"
        )]
        let count = (near.len() as f64 * share) as usize;
        let near = near.get(..count.max(2 * centre.len() + 2))?;
        #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
        let each = 1.0 / near.len() as f64;
        let mean = near.iter().fold(DVector::zeros(centre.len()), |sum: DVector<f64>, (_, x)| sum + *x * each);
        let mut scale = DMatrix::from_diagonal(&units.map(|unit| (1e-3 * unit).powi(2)));
        for (_, x) in near {
            let from = *x - &mean;
            scale.ger(each, &from, &from, 1.0);
        }
        let mut more = self.clone();
        more.components.push(Component::new(mean, scale, share)?);
        Some(more.normalised())
    }

    /// After expectation and maximisation on `samples`. A mode without samples stays as it was; any other component
    /// without is dropped.
    fn maximised(&self, samples: &[(DVector<f64>, f64)]) -> Self {
        let mut mixture = self.clone();
        for _ in 0..PASSES {
            let Some(next) = mixture.pass(samples) else { break };
            mixture = next;
        }
        mixture
    }

    fn pass(&self, samples: &[(DVector<f64>, f64)]) -> Option<Self> {
        let n = self.components.first()?.centre.len();
        #[allow(clippy::cast_precision_loss, reason = "few parameters")]
        let d = n as f64;
        let k = self.components.len();
        let mut share = vec![0.0; k];
        let mut mass = vec![0.0; k];
        let mut mean = vec![DVector::<f64>::zeros(n); k];
        let mut square = vec![DMatrix::<f64>::zeros(n, n); k];
        let mut parts = vec![(0.0, 0.0); k];
        for (x, _) in samples {
            let mut sum = 0.0;
            let top = self.log_density(x);
            for (part, component) in parts.iter_mut().zip(&self.components) {
                let (log, distance) = component.log_density(x);
                *part = ((log - top).exp(), distance);
                sum += part.0;
            }
            for (j, &(part, distance)) in parts.iter().enumerate() {
                let r = part / sum;
                if r.is_nan() || r < 1e-6 {
                    continue;
                }
                let u = r * (FREEDOM + d) / (FREEDOM + distance);
                let from = x - &self.components[j].centre;
                share[j] += r;
                mass[j] += u;
                mean[j].axpy(u, &from, 1.0);
                square[j].ger(u, &from, &from, 1.0);
            }
        }
        let mut components = Vec::with_capacity(k);
        for (j, old) in self.components.iter().enumerate() {
            if share[j] < 2.0 * (d + 1.0) {
                if j < self.modes {
                    components.push(Component { weight: share[j], ..old.clone() });
                }
                continue;
            }
            let shift = &mean[j] / mass[j];
            // One sample's worth of the old scale keeps a component of few distinct samples from collapsing.
            let scale = (&square[j] - &shift * shift.transpose() * mass[j] + &old.scale) / (share[j] + 1.0);
            match Component::new(&old.centre + shift, scale, share[j]) {
                Some(component) => components.push(component),
                None => components.push(Component { weight: share[j], ..old.clone() }),
            }
        }
        Some(Self { components, ..self.clone() }.normalised())
    }
}
