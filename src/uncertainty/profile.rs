//! Profile likelihood: how far a quantity can move before the best of everything else no longer makes up for it.
//!
//! ```text
//! s(v) = sqrt((min of the sum of squares with the quantity held at v) - (sum of squares at the minimum)) / unit
//! ```
//!
//! The interval of quantile `z` is where `s < z`, connected to the minimum. For a linear model `s` is `|v - best| / sigma`
//! and the interval is that of the covariance; elsewhere it bends, and it ends at a limit only if the data leave it open.
//!
//! # Source
//! Venzon and Moolgavkar 1988, DOI 10.2307/2347496; Bates and Watts 1988, *Nonlinear Regression Analysis*, §6.1.

use nalgebra::DVector;

/// First step in standard deviations.
const STEP: f64 = 0.5;
/// A step that changes `s` by less is followed by a longer one, ...
const SHORT: f64 = 0.2;
/// ... and one that changes it by more is done again with half the length.
const LONG: f64 = 1.2;
/// How far beyond the last quantile a profile is drawn.
const BEYOND: f64 = 0.3;
/// Points on one side at most.
const POINTS: usize = 60;
/// Halvings of one step at most: then `s` jumps there.
const HALVINGS: usize = 6;
/// An end is found when `s` is this near its quantile, ...
const NEAR: f64 = 2e-3;
/// ... or the points that enclose it are this near each other, in standard deviations.
const CLOSE: f64 = 1e-4;
/// Points spent on one end.
const REFINED: usize = 14;

/// The best of everything else with the quantity held.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditional {
    /// Sum of squares.
    pub sum_of_squares: f64,
    /// Where the other parameters are, as the objective numbers them.
    pub others: DVector<f64>,
}

/// One point of a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfilePoint {
    /// Value of the quantity.
    pub value: f64,
    /// Sum of squares less that of the minimum, in units of `unit²`; below 0 if a lower minimum was met.
    pub excess: f64,
    /// The other parameters there.
    pub others: DVector<f64>,
}

impl ProfilePoint {
    fn deviations(&self) -> f64 {
        self.excess.max(0.0).sqrt()
    }
}

/// What a profile starts from.
#[derive(Debug, Clone, PartialEq)]
pub struct ProfileStart {
    /// Value of the quantity at the minimum.
    pub value: f64,
    /// The other parameters there.
    pub others: DVector<f64>,
    /// Sum of squares there.
    pub sum_of_squares: f64,
    /// Standard deviation of the quantity by the covariance, or a guess of it; above 0.
    pub sigma: f64,
    /// Ends of the range in which the quantity may lie.
    pub limits: (f64, f64),
    /// Standard deviation of a residual.
    pub unit: f64,
}

/// A profile and its intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Points by rising value; the minimum is one of them.
    pub points: Vec<ProfilePoint>,
    /// The two ends for each quantile; `None` where the limit was reached first.
    pub intervals: Vec<[Option<f64>; 2]>,
}

/// Walks to both sides of the minimum and finds where the profile crosses each of `quantiles`.
///
/// - `conditional(v, starts)`: the least sum of squares with the quantity held at `v`, searched from `starts`, the
///   others' places at neighbouring points; `None` where there is none. It may know further starts, such as other minima.
/// - `quantiles`: of the standard normal, or of Student's t; rising.
///
/// ```
/// use morpho_fit::uncertainty::profile::{Conditional, ProfileStart, profile};
/// use nalgebra::DVector;
/// // One number measured four times with sigma 1: sigma 1/2. Nothing else is free.
/// let none = DVector::zeros(0);
/// let start = ProfileStart {
///     value: 3.0, others: none.clone(), sum_of_squares: 0.0, sigma: 0.4, limits: (2.2, 9.0), unit: 1.0,
/// };
/// let found = profile(
///     |v, _| Some(Conditional { sum_of_squares: 4.0 * (v - 3.0) * (v - 3.0), others: none.clone() }),
///     &start,
///     &[1.0, 2.0],
/// );
/// assert!((found.intervals[0][1].unwrap() - 3.5).abs() < 1e-3);
/// assert_eq!(found.intervals[1][0], None); // 2.0 lies below the limit
/// ```
#[must_use]
pub fn profile(
    conditional: impl Fn(f64, &[&DVector<f64>]) -> Option<Conditional>,
    start: &ProfileStart,
    quantiles: &[f64],
) -> Profile {
    let best = ProfilePoint { value: start.value, excess: 0.0, others: start.others.clone() };
    let point = |value: f64, starts: &[&DVector<f64>]| {
        let found = conditional(value, starts).filter(|found| found.sum_of_squares.is_finite())?;
        let excess = (found.sum_of_squares - start.sum_of_squares) / (start.unit * start.unit);
        Some(ProfilePoint { value, excess, others: found.others })
    };
    let mut intervals = vec![[None; 2]; quantiles.len()];
    let mut points = vec![best.clone()];
    for side in 0..2 {
        let limit = if side == 0 { start.limits.0 } else { start.limits.1 };
        let direction = if side == 0 { -1.0 } else { 1.0 };
        let farthest = quantiles.iter().copied().fold(0.0, f64::max) + BEYOND;
        let mut branch = walk(&point, &best, direction * STEP * start.sigma, limit, farthest);
        for (interval, &quantile) in intervals.iter_mut().zip(quantiles) {
            interval[side] = cross(&point, &mut branch, quantile, start.sigma);
        }
        points.extend(branch.into_iter().skip(1));
    }
    points.sort_by(|a, b| a.value.total_cmp(&b.value));
    Profile { points, intervals }
}

/// Points from `best` outwards until one lies `farthest` off, or the limit is reached.
fn walk(
    point: &impl Fn(f64, &[&DVector<f64>]) -> Option<ProfilePoint>,
    best: &ProfilePoint,
    first: f64,
    limit: f64,
    farthest: f64,
) -> Vec<ProfilePoint> {
    let mut branch = vec![best.clone()];
    // Points that a step too long has found: they close the branch if nothing nearer does.
    let mut ahead: Vec<ProfilePoint> = Vec::new();
    let (mut step, mut halvings) = (first, 0);
    while let Some(last) = branch.last().filter(|last| last.deviations() < farthest && branch.len() < POINTS) {
        let value = last.value + step;
        let beyond = (value - limit) * step.signum() >= 0.0;
        let value = if beyond { limit } else { value };
        if (value - last.value).abs() <= f64::EPSILON * value.abs() {
            break;
        }
        let extrapolated = branch.len().checked_sub(2).map(|before| {
            let before = &branch[before];
            let share = (value - last.value) / (last.value - before.value);
            &last.others + (&last.others - &before.others) * share
        });
        let starts: Vec<&DVector<f64>> = extrapolated.iter().chain([&last.others]).collect();
        let found = point(value, &starts);
        let change = found.as_ref().map_or(f64::INFINITY, |found| (found.deviations() - last.deviations()).abs());
        if change > LONG && halvings < HALVINGS {
            ahead.extend(found);
            (step, halvings) = (0.5 * (value - last.value), halvings + 1);
            continue;
        }
        let Some(found) = found else { break };
        halvings = 0;
        branch.push(found);
        if change < SHORT {
            step *= 2.0;
        }
        if beyond {
            break;
        }
    }
    let end = branch.last().map_or(best.value, |last| last.value);
    ahead.retain(|point| (point.value - end) * first.signum() > 0.0);
    ahead.sort_by(|a, b| (a.value * first.signum()).total_cmp(&(b.value * first.signum())));
    branch.extend(ahead);
    branch
}

/// Where the branch first rises to `quantile`; points met on the way join it.
fn cross(
    point: &impl Fn(f64, &[&DVector<f64>]) -> Option<ProfilePoint>,
    branch: &mut Vec<ProfilePoint>,
    quantile: f64,
    sigma: f64,
) -> Option<f64> {
    let mut outer = branch.iter().position(|point| point.deviations() >= quantile).filter(|&place| place > 0)?;
    for spent in 0..REFINED {
        let (a, b) = (&branch[outer - 1], &branch[outer]);
        let (low, high) = (a.deviations(), b.deviations());
        let share = ((quantile - low) / (high - low)).clamp(0.0, 1.0);
        for (end, at) in [(a, low), (b, high)] {
            if (at - quantile).abs() < NEAR {
                return Some(end.value);
            }
        }
        if (b.value - a.value).abs() < CLOSE * sigma {
            break;
        }
        // The chord is nearly right where s is smooth; where it jumps, halving gets there.
        let share = if spent % 3 == 2 { 0.5 } else { share.clamp(0.02, 0.98) };
        let value = a.value + share * (b.value - a.value);
        let Some(found) = point(value, &[&a.others, &b.others]) else { break };
        let place = outer;
        outer = if found.deviations() >= quantile { place } else { place + 1 };
        branch.insert(place, found);
    }
    let (a, b) = (&branch[outer - 1], &branch[outer]);
    let share = (quantile - a.deviations()) / (b.deviations() - a.deviations());
    Some(a.value + share.clamp(0.0, 1.0) * (b.value - a.value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn start(value: f64, sigma: f64, limits: (f64, f64)) -> ProfileStart {
        ProfileStart { value, others: DVector::zeros(0), sum_of_squares: 0.0, sigma, limits, unit: 1.0 }
    }

    fn alone(sum_of_squares: f64) -> Option<Conditional> {
        Some(Conditional { sum_of_squares, others: DVector::zeros(0) })
    }

    #[test]
    fn an_exponential_rate_has_its_closed_form() {
        // 100 (exp(-v) - exp(-1))²: s = z where exp(-v) = exp(-1) ∓ z / 10.
        let found = profile(
            |v, _| alone(100.0 * ((-v).exp() - (-1.0_f64).exp()).powi(2)),
            &start(1.0, 0.3, (0.0, 50.0)),
            &[1.0, 2.0, 3.7],
        );
        let centre = (-1.0_f64).exp();
        for (interval, z) in found.intervals.iter().zip([1.0, 2.0]) {
            assert_abs_diff_eq!(interval[0].unwrap(), -(centre + z / 10.0).ln(), epsilon = 2e-3);
            assert_abs_diff_eq!(interval[1].unwrap(), -(centre - z / 10.0).ln(), epsilon = 2e-3);
        }
        // exp(-v) never falls by 0.37: s approaches 3.68 for large v.
        assert_eq!(found.intervals[2][1], None);
        assert!(found.points.windows(2).all(|pair| pair[0].value < pair[1].value));
    }

    #[test]
    fn a_wrong_guess_of_sigma_costs_points_and_changes_nothing() {
        for guess in [1e-4, 1e-2, 1.0, 100.0] {
            let found = profile(|v, _| alone((v / 0.1).powi(2)), &start(0.0, guess, (-1e3, 1e3)), &[1.0]);
            assert_abs_diff_eq!(found.intervals[0][0].unwrap(), -0.1, epsilon = 3e-4);
            assert_abs_diff_eq!(found.intervals[0][1].unwrap(), 0.1, epsilon = 3e-4);
        }
    }

    #[test]
    fn a_jump_is_found_to_within_the_tolerance_of_its_place() {
        let found =
            profile(|v, _| alone(if v < 0.123 { v * v } else { 25.0 }), &start(0.0, 1.0, (-9.0, 9.0)), &[1.0, 2.0]);
        assert_abs_diff_eq!(found.intervals[0][1].unwrap(), 0.123, epsilon = 0.02);
        assert_abs_diff_eq!(found.intervals[0][0].unwrap(), -1.0, epsilon = 2e-3);
    }

    #[test]
    fn a_place_without_a_value_ends_the_walk() {
        let nowhere = |_: f64, _: &[&DVector<f64>]| None;
        let found = profile(nowhere, &start(0.0, 1.0, (-1.0, 1.0)), &[1.0]);
        assert_eq!((found.points.len(), found.intervals[0]), (1, [None, None]));
        let found = profile(|_, _| alone(f64::NAN), &start(0.0, 1.0, (-1.0, 1.0)), &[1.0]);
        assert_eq!(found.points.len(), 1);
    }

    #[test]
    fn the_others_follow() {
        // (x - y)² · 100 + y²: held at x, y = 100 x / 101 and the sum is x² · 100/101.
        let conditional = |x: f64, starts: &[&DVector<f64>]| {
            assert!(!starts.is_empty());
            let y = 100.0 * x / 101.0;
            Some(Conditional { sum_of_squares: 100.0 * (x - y).powi(2) + y * y, others: DVector::from_element(1, y) })
        };
        let start = ProfileStart { others: DVector::zeros(1), ..start(0.0, 1.0, (-9.0, 9.0)) };
        let found = profile(conditional, &start, &[1.0]);
        assert_abs_diff_eq!(found.intervals[0][1].unwrap(), 1.01_f64.sqrt(), epsilon = 3e-3);
    }
}
