//! Whether Markov chains agree, and how many independent samples they are worth.
//!
//! Each chain is cut into two halves of `n` steps, `m` of them in all. With `W` the mean variance within a half, `B / n`
//! the variance of their means and `rho_t` the autocorrelation at lag `t` over all of them,
//!
//! ```text
//! V = (n - 1)/n W + B/n,   R̂ = sqrt(V / W),   ESS = m n / (1 + 2 sum_{t>0} rho_t).
//! ```
//!
//! The sum ends by Geyer's initial monotone sequence. R̂ and the bulk ESS are of the normal scores of the ranks, so that
//! they exist for any distribution; R̂ is the larger of that of the values and that of their distances from the median.
//! The tail ESS is the smaller of those of the 5 % and the 95 % quantile.
//!
//! Vehtari, Gelman, Simpson, Carpenter, Bürkner 2021, DOI 10.1214/20-BA1221; Geyer 1992, DOI 10.1214/ss/1177011137.

use crate::numerics::normal::normal_quantile;
use crate::numerics::quantile::quantile;

/// A half of fewer steps has no autocorrelation to speak of: chains must have twice as many.
const SHORTEST_HALF: usize = 5;
/// Offset of a rank in its normal score (Blom 1958).
const BLOM: f64 = 3.0 / 8.0;
/// Probabilities whose quantiles make the tail ESS.
const TAILS: [f64; 2] = [0.05, 0.95];

/// How well chains of one quantity have converged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Rank-normalised split-R̂; near 1 if the chains agree.
    pub r_hat: f64,
    /// Effective sample size of the bulk: of means and medians.
    pub bulk: f64,
    /// Effective sample size of the tails: of the 5 % and 95 % quantiles; the bulk's if so many values are equal that
    /// neither has any beyond it.
    pub tail: f64,
}

impl Convergence {
    /// Of chains of one quantity.
    ///
    /// `None` if there are no chains, if they differ in length or have fewer than 10 steps, if a value is not finite, or
    /// if nothing varies within a half: then there is nothing to compare with.
    ///
    /// # Shape
    /// `chains: [chain][step]`. The middle step of an odd number of steps is left out of the halves.
    ///
    /// ```
    /// use morpho_fit::uncertainty::convergence::Convergence;
    /// // a rotation by the golden ratio: evenly spread, so worth more than as many independent draws
    /// let even: Vec<f64> = (0..400).map(|i| (f64::from(i) * 0.618_033_988_749_895).fract()).collect();
    /// let apart: Vec<f64> = even.iter().map(|x| x + 2.0).collect();
    /// assert!(Convergence::of(&[&even, &even]).unwrap().bulk > 800.0);
    /// assert!(Convergence::of(&[&even, &apart]).unwrap().r_hat > 1.5);
    /// assert!(Convergence::of(&[&[1.0; 400]]).is_none());
    /// ```
    #[must_use]
    pub fn of(chains: &[&[f64]]) -> Option<Self> {
        let steps = chains.first()?.len();
        let half = steps / 2;
        let usable = |chain: &&[f64]| chain.len() == steps && chain.iter().all(|value| value.is_finite());
        if half < SHORTEST_HALF || !chains.iter().all(usable) {
            return None;
        }
        let halves = chains.iter().flat_map(|chain| [&chain[..half], &chain[steps - half..]]);
        let values: Vec<f64> = halves.flatten().copied().collect();
        let order = ranked(&values);
        let scores = Halves::of_ranks(&order, half)?;
        let sorted: Vec<f64> = order.iter().map(|(value, _)| *value).collect();
        let median = quantile(&sorted, 0.5)?;
        // The quantiles are of all steps, the rest of the halves: a middle step belongs to neither.
        let all = if 2 * half == steps {
            sorted
        } else {
            let mut all: Vec<f64> = chains.concat();
            all.sort_unstable_by(f64::total_cmp);
            all
        };
        let distances: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
        // Values of only two kinds lie equally far from the median and have no spread to compare.
        let spread = Halves::of_ranks(&ranked(&distances), half).and_then(|folded| folded.r_hat());
        let r_hat = scores.r_hat()?;
        let mut tail = f64::INFINITY;
        for probability in TAILS {
            let edge = quantile(&all, probability)?;
            let below: Vec<f64> = values.iter().map(|&value| f64::from(u8::from(value <= edge))).collect();
            // A quantile that equals the largest value has nothing above it to tell from.
            tail = tail.min(Halves { values: below, length: half }.effective_size().unwrap_or(f64::INFINITY));
        }
        let bulk = scores.effective_size()?;
        Some(Self { r_hat: r_hat.max(spread.unwrap_or(r_hat)), bulk, tail: if tail.is_finite() { tail } else { bulk } })
    }
}

/// The values, each with its place, from the least to the largest.
fn ranked(values: &[f64]) -> Vec<(f64, usize)> {
    let mut order: Vec<(f64, usize)> = values.iter().copied().zip(0..).collect();
    order.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
    order
}

/// Halves of chains, one after the other, each of `length` steps.
struct Halves {
    values: Vec<f64>,
    length: usize,
}

impl Halves {
    /// Normal scores of the ranks, equal values sharing their mean rank.
    fn of_ranks(order: &[(f64, usize)], length: usize) -> Option<Self> {
        #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
        let count = |number: usize| number as f64;
        let mut scores = vec![0.0; order.len()];
        let mut below = 0;
        for equal in order.chunk_by(|(a, _), (b, _)| a.partial_cmp(b) == Some(std::cmp::Ordering::Equal)) {
            let rank = count(below) + (count(equal.len()) + 1.0) / 2.0;
            let score = normal_quantile((rank - BLOM) / (count(order.len()) - 2.0 * BLOM + 1.0))?;
            for &(_, index) in equal {
                scores[index] = score;
            }
            below += equal.len();
        }
        Some(Self { values: scores, length })
    }

    #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
    fn steps(&self) -> f64 {
        self.length as f64
    }

    fn means(&self) -> Vec<f64> {
        self.values.chunks_exact(self.length).map(|half| half.iter().sum::<f64>() / self.steps()).collect()
    }

    /// `W` and `B / n`.
    fn variances(&self, means: &[f64]) -> (f64, f64) {
        let within = self.covariance(means, 0) * self.steps() / (self.steps() - 1.0);
        #[allow(clippy::cast_precision_loss, reason = "counts of chains are below 2^53")]
        let count = means.len() as f64;
        let mean = means.iter().sum::<f64>() / count;
        let between = means.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        (within, between)
    }

    /// Mean over the halves of `1/n sum_i (x_i - mean)(x_{i+lag} - mean)`.
    fn covariance(&self, means: &[f64], lag: usize) -> f64 {
        let mut sum = 0.0;
        for (half, mean) in self.values.chunks_exact(self.length).zip(means) {
            sum += half.iter().zip(half.iter().skip(lag)).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
        }
        #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
        let count = self.values.len() as f64;
        sum / count
    }

    fn r_hat(&self) -> Option<f64> {
        let (within, between) = self.variances(&self.means());
        (within > f64::EPSILON * between).then(|| (between / within + (self.steps() - 1.0) / self.steps()).sqrt())
    }

    fn effective_size(&self) -> Option<f64> {
        let means = self.means();
        let (within, between) = self.variances(&means);
        let whole = within * (self.steps() - 1.0) / self.steps() + between;
        if whole <= 0.0 {
            return None;
        }
        let correlation = |lag: usize| 1.0 - (within - self.covariance(&means, lag)) / whole;
        // Sums of pairs (0, 1), (2, 3), ... are positive and fall in a reversible chain: end the noise where they do not.
        // Of the pair that ends it only the even term counts, once.
        let mut pair = 1.0 + correlation(1);
        let mut positive = pair > 0.0;
        let mut sum = 0.0;
        let mut last_even = 1.0;
        let mut lag = 2;
        while positive && lag + 2 < self.length {
            sum += pair;
            let (even, odd) = (correlation(lag), correlation(lag + 1));
            last_even = even.max(0.0);
            positive = even + odd > 0.0;
            pair = pair.min(even + odd);
            lag += 2;
        }
        #[allow(clippy::cast_precision_loss, reason = "counts of samples are below 2^53")]
        let count = self.values.len() as f64;
        // Chains that alternate can be worth more than their length, but an estimate of much more is noise.
        let time = (2.0 * sum - 1.0 + last_even).max(count.log10().recip());
        Some(count / time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Chains and values of arviz, written by `scripts/reference/convergence.py`.
    const REFERENCE: &str = include_str!("../../tests/reference/convergence.csv");

    /// `[chain][step]` of an autoregression `x' = r x + sqrt(1 - r²) z`; z by Lehmer's generator (minstd).
    fn autoregression(chains: usize, steps: usize, r: f64) -> Vec<Vec<f64>> {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state * 48_271 % 2_147_483_647;
            state as f64 / 2_147_483_647.0
        };
        let mut chain = || {
            let mut x = normal_quantile(uniform()).unwrap();
            let mut next = || {
                x = r * x + (1.0 - r * r).sqrt() * normal_quantile(uniform()).unwrap();
                x
            };
            (0..steps).map(|_| next()).collect()
        };
        (0..chains).map(|_| chain()).collect()
    }

    fn of(chains: &[Vec<f64>]) -> Option<Convergence> {
        Convergence::of(&chains.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    #[test]
    fn all_three_are_those_of_another_program() {
        let mut cases = 0;
        for line in REFERENCE.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let numbers: Vec<f64> = cells[1..].iter().map(|cell| cell.parse().unwrap()).collect();
            let (length, expected) = (cells[1].parse::<usize>().unwrap(), &numbers[1..4]);
            let chains: Vec<&[f64]> = numbers[4..].chunks_exact(length).collect();
            let found = Convergence::of(&chains).unwrap();
            assert_relative_eq!(found.r_hat, expected[0], max_relative = 1e-10);
            assert_relative_eq!(found.bulk, expected[1], max_relative = 1e-8);
            assert_relative_eq!(found.tail, expected[2], max_relative = 1e-8);
            cases += 1;
        }
        assert_eq!(cases, 6);
    }

    #[test]
    fn an_autoregression_is_worth_its_closed_form() {
        // ESS / N = (1 - r) / (1 + r); the estimate of 80,000 steps is good to a few per cent.
        for (r, tolerance) in [(0.0, 0.05), (0.5, 0.06), (0.9, 0.12)] {
            let found = of(&autoregression(4, 20_000, r)).unwrap();
            assert_relative_eq!(found.bulk / 80_000.0, (1.0 - r) / (1.0 + r), max_relative = tolerance);
            assert!(found.r_hat < 1.01, "{r}: {}", found.r_hat);
        }
    }

    #[test]
    fn ranks_make_it_independent_of_the_scale() {
        let chains = autoregression(3, 500, 0.6);
        let curved: Vec<Vec<f64>> =
            chains.iter().map(|chain| chain.iter().map(|x| (9.0 * x).exp()).collect()).collect();
        let (plain, curved) = (of(&chains).unwrap(), of(&curved).unwrap());
        assert_relative_eq!(plain.bulk, curved.bulk, max_relative = 1e-12);
        // Linear quantiles between two values move with the scale, but not across one.
        assert_relative_eq!(plain.tail, curved.tail, max_relative = 1e-12);
    }

    #[test]
    fn chains_of_other_width_are_seen() {
        let mut chains = autoregression(4, 1000, 0.3);
        chains[2].iter_mut().for_each(|x| *x *= 4.0);
        assert!(of(&chains).unwrap().r_hat > 1.1);
    }

    #[test]
    fn what_cannot_be_compared_gives_none() {
        let good = autoregression(2, 50, 0.0);
        assert!(of(&[]).is_none());
        assert!(of(&[vec![]]).is_none());
        assert!(of(&[vec![1.0; 50], vec![1.0; 50]]).is_none());
        assert!(of(&[vec![1.0; 50], vec![2.0; 50]]).is_none());
        assert!(of(&[good[0][..9].to_vec()]).is_none());
        assert!(of(&[good[0].clone(), good[1][..40].to_vec()]).is_none());
        for bad in [f64::NAN, f64::INFINITY] {
            let mut spoilt = good.clone();
            spoilt[1][3] = bad;
            assert!(of(&spoilt).is_none());
        }
        let huge: Vec<Vec<f64>> = good.iter().map(|chain| chain.iter().map(|x| x * 1e308).collect()).collect();
        assert!(of(&huge).is_none_or(|found| found.r_hat.is_finite() && found.bulk.is_finite()));
        let two_kinds: Vec<Vec<f64>> = good.iter().map(|chain| chain.iter().map(|x| x.signum()).collect()).collect();
        assert!(of(&two_kinds).unwrap().tail > 0.0);
    }
}
