//! A constant of the model fitted beside the parameters, by its profile likelihood.
//!
//! ```text
//! chi²(c)     = min over the parameters of chi² with the constant held at c
//! chi²(x)     = min over c of  chi²(c) + unit² (x - x(c))² / sigma(c)²
//! ```
//!
//! `x(c)` and `sigma(c)` are the best value of a quantity and its standard deviation with the constant at `c`. The interval of
//! the constant is where the first stays within `z²` of its minimum, that of the quantity where the second does: wider than
//! the fit's own, which takes the constant as known.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::conditional::lowest;
use crate::inversion::constant::Constant;
use crate::inversion::fit::{FitError, fit};
use crate::inversion::intervals::profile::LOWER;
use crate::inversion::intervals::{IntervalPair, Quantiles, rivals, stretched};
use crate::inversion::outcome::Fit;
use crate::inversion::parameter::{COUNT, outside};
use crate::inversion::problem::Problem;
use crate::inversion::quantity::Quantity;
use crate::inversion::settings::FitSettings;
use crate::optimise::LeastSquares;
use crate::uncertainty::covariance::regularised;
use crate::uncertainty::profile::{Conditional, ProfileStart, profile};
use argmin::core::{CostFunction, Executor};
use argmin::solver::brent::BrentOpt;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Values of the constant that are fitted globally, evenly over its range.
const GRID: usize = 13;
/// Steps of Brent's method from there to the minimum.
const STEPS: u64 = 40;
/// Steps between two points of the profile when the intervals of the quantities are read off.
const BETWEEN: usize = 400;
/// First step of the profile as a share of the range.
const FIRST: f64 = 0.02;
/// Times that the minimum is looked for again, and how near the last it must be, and an end of the range to be
/// there, as a share of it.
const STILL: usize = 12;
const NEAR: f64 = 1e-4;
/// Times that a lower minimum met by the profile begins it anew.
const RESTARTS: usize = 3;
/// What a quantity moves along the constant in standard deviations, at least, for an open end of that to be one of its own.
const MOVES: f64 = 0.1;

/// A quantity with the constant known, and with it fitted; user units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantityOver {
    /// Name as in `fit.json`.
    pub name: String,
    /// nm, deg or rad.
    pub unit: String,
    /// Best value.
    pub value: f64,
    /// Standard deviation if the constant were known to be at its best value.
    pub sigma_known: f64,
    /// Intervals with the constant fitted; an end that is open is `None`.
    pub intervals: IntervalPair,
}

/// A constant fitted beside the parameters.
#[derive(Debug, Clone)]
pub struct ConstantProfile {
    /// Which.
    pub constant: Constant,
    /// What the settings told, user units.
    pub told: Option<f64>,
    /// Best value, user units.
    pub best: f64,
    /// Whether the best value is an end of the range: the data ask for more than it allows.
    pub at_end: bool,
    /// Intervals; an end at the end of the range is open.
    pub intervals: IntervalPair,
    /// The range that was asked for.
    pub limits: [f64; 2],
    /// Δchi² at the ends of the two intervals.
    pub levels: [f64; 2],
    /// Values of the constant, rising.
    pub values: Vec<f64>,
    /// Δchi² in units of the squared standard deviation of a weighted residual, one for each.
    pub excess: Vec<f64>,
    /// The five parameters at each, user units.
    pub parameters: Vec<[f64; COUNT]>,
    /// The determined parameters and sums of thicknesses.
    pub quantities: Vec<QuantityOver>,
    /// The fit at the best value; its own intervals take the constant as known.
    pub fit: Fit,
}

/// Fits `constant` within `limits` (user units) beside the free parameters.
///
/// # Errors
/// [`FitError`] if the constant is not one of the settings, or if no value of it can be fitted.
///
/// # Source
/// Venzon and Moolgavkar 1988, DOI 10.2307/2347496.
///
/// ```
/// use morpho_fit::inversion::{Constant, FitSettings, intervals::over_constant};
/// use morpho_fit::optics::{BlendModel, Material, Stack, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let stack = Stack { cuticle: Material::Constant { n: 1.52, k: 0.0 }, ..Stack::default() };
/// let (model, blue) = (BlendModel { stack }, Structure::blue());
/// let data = simulate(&model, &blue, &Scan::full_design(&model, &blue)?, 1.0, 0.01, 7)?;
/// let found = over_constant(&data, &FitSettings::default(), Constant::NCuticle, [1.4, 1.7], &|_| {})?;
/// let [low, high] = found.intervals.interval_95;
/// assert!(low.unwrap() < 1.52 && 1.52 < high.unwrap());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn over_constant(
    data: &Dataset,
    settings: &FitSettings,
    constant: Constant,
    limits: [f64; 2],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<ConstantProfile, FitError> {
    let [low, high] = limits;
    let (least, most) = constant.domain();
    if !(least <= low && low < high && high <= most) {
        return Err(FitError::ConstantRange { constant: constant.name(), low, high, least, most });
    }
    let at = |value: f64| fit(data, &constant.set(settings, value)?, &|_| {});
    let mut grid: Vec<(f64, Fit)> = Vec::new();
    let mut refused = None;
    for step in 0..GRID {
        #[allow(clippy::cast_precision_loss, reason = "a few steps")]
        let value = low + (high - low) * step as f64 / (GRID - 1) as f64;
        progress(&format!("fitting with {constant} {value:.4}"));
        match at(value) {
            Ok(found) if cost(&found).is_finite() => grid.push((value, found)),
            Ok(_) => {}
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    let lowest = (0..grid.len()).min_by(|a, b| cost(&grid[*a].1).total_cmp(&cost(&grid[*b].1)));
    let Some(place) = lowest else {
        return Err(refused.unwrap_or(FitError::NowhereFinite { model: settings.forward()?.name() }));
    };
    let ends = [grid[place.saturating_sub(1)].0, grid[(place + 1).min(grid.len() - 1)].0];
    let (mut best, mut fit) = grid.swap_remove(place);
    // The weights of a robust loss follow the fit: the minimum is looked for until it stands still.
    for _ in 0..STILL {
        let start = fit.solution.minima[0].parameters.clone();
        let along = Along { data, settings, constant, base: &fit, progress };
        let Some(refined) = along.minimum(ends, &start) else { break };
        // It stands only if a whole search there agrees that it is lower.
        let Some(found) = at(refined).ok().filter(|found| cost(found) <= cost(&fit)) else { break };
        let moved = (refined - best).abs();
        (best, fit) = (refined, found);
        if moved < NEAR * (high - low) {
            break;
        }
    }
    for _ in 0..RESTARTS {
        let found = Along { data, settings, constant, base: &fit, progress }.profile(best, limits)?;
        let lowest = found.values.iter().zip(&found.excess).min_by(|a, b| a.1.total_cmp(b.1));
        // A minimum below that of the fit, in a basin that the first values stepped over.
        let lower =
            lowest.filter(|(_, excess)| **excess < -LOWER).and_then(|(&value, _)| Some((value, at(value).ok()?)));
        match lower.filter(|(_, other)| cost(other) < cost(&fit)) {
            Some((value, other)) => (best, fit) = (value, other),
            None => return Ok(found),
        }
    }
    Along { data, settings, constant, base: &fit, progress }.profile(best, limits)
}

/// What a fit minimised: chi², or the sum of its robust loss.
fn cost(found: &Fit) -> f64 {
    found.solution.minima.first().map_or(f64::INFINITY, |minimum| minimum.sum_of_squares)
}

/// The least sums of squares along a constant, from the minima of the fit at one of its values.
struct Along<'a> {
    data: &'a Dataset,
    settings: &'a FitSettings,
    constant: Constant,
    base: &'a Fit,
    progress: &'a (dyn Fn(&str) + Sync),
}

/// The quantities at one point: best value and standard deviation, inside units.
type Seen = Vec<(f64, f64)>;

impl Along<'_> {
    /// `ask` of the problem with the constant at `value`.
    fn at<T>(&self, value: f64, ask: impl FnOnce(&Problem<'_>, &Compiled<'_>) -> Option<T>) -> Option<T> {
        let settings = self.constant.set(self.settings, value).ok()?;
        let model = settings.forward().ok()?;
        model.validate().ok()?;
        let compiled = Compiled::new(self.data, &settings, model.as_ref()).ok()?;
        ask(&Problem::new(&compiled, &self.base.solution.searched, &self.base.solution.robust), &compiled)
    }

    fn conditional(&self, value: f64, starts: &[&DVector<f64>]) -> Option<Conditional> {
        (self.progress)(&format!("fitting with {} {value:.4}", self.constant));
        let mut all: Vec<DVector<f64>> = starts.iter().map(|start| (*start).clone()).collect();
        let neighbours = all.len();
        all.extend(rivals(&self.base.solution, self.base.solution.unit).map(|minimum| minimum.parameters.clone()));
        self.at(value, |problem, _| lowest(problem, &all, neighbours))
    }

    /// Brent's minimum between two values.
    fn minimum(&self, [low, high]: [f64; 2], start: &DVector<f64>) -> Option<f64> {
        struct Cost<'a>(&'a Along<'a>, &'a DVector<f64>);
        impl CostFunction for Cost<'_> {
            type Param = f64;
            type Output = f64;

            fn cost(&self, value: &f64) -> Result<f64, argmin::core::Error> {
                Ok(self.0.conditional(*value, &[self.1]).map_or(f64::INFINITY, |found| found.sum_of_squares))
            }
        }
        let run = Executor::new(Cost(self, start), BrentOpt::new(low, high)).configure(|state| state.max_iters(STEPS));
        run.run().ok()?.state.best_param
    }

    fn profile(&self, best: f64, limits: [f64; 2]) -> Result<ConstantProfile, FitError> {
        let (solution, outcome) = (&self.base.solution, &self.base.outcome);
        let own = &solution.minima[0];
        let model = outcome.settings.forward()?;
        let compiled = Compiled::of_fit(self.data, self.base, model.as_ref())?;
        let told = |quantity: &Quantity| quantity.estimate(outcome).sigma.is_some();
        let quantities: Vec<Quantity> =
            Quantity::moving(&compiled, &solution.searched).into_iter().filter(told).collect();
        let start = ProfileStart {
            value: best,
            others: own.parameters.clone(),
            sum_of_squares: Problem::new(&compiled, &solution.searched, &solution.robust)
                .residuals(&own.parameters)
                .norm_squared(),
            sigma: FIRST * (limits[1] - limits[0]),
            limits: (limits[0], limits[1]),
            unit: solution.unit,
        };
        let Quantiles { sixty_eight, ninety_five } = Quantiles::of(outcome);
        let found = profile(|value, starts| self.conditional(value, starts), &start, &[sixty_eight, ninety_five]);
        let pair = |place: usize| found.intervals.get(place).copied().unwrap_or([None; 2]);
        let seen: Vec<(f64, Seen)> = found
            .points
            .iter()
            .filter_map(|point| Some((point.excess.max(0.0), self.seen(point.value, &point.others, &quantities)?)))
            .collect();
        let domain = self.constant.domain();
        let cut_short = [limits[0] > domain.0, limits[1] < domain.1];
        let over = |(column, quantity): (usize, &Quantity)| {
            let value = quantity.of(&solution.searched.freedom.expand(&own.parameters));
            let limits = quantity.limits(&solution.searched);
            let points: Vec<[f64; 3]> = seen.iter().map(|(e, all)| [*e, all[column].0, all[column].1]).collect();
            let interval = |z: f64, constant: [Option<f64>; 2]| {
                let Some([low, high]) = reach(&points, z) else { return [None; 2] };
                // Where the range of the constant was cut short, the quantity goes on too, if it moves at all.
                let moves = [points.first(), points.last()]
                    .map(|end| end.is_some_and(|[_, there, sigma]| (there - value).abs() > MOVES * sigma));
                let cut = [0, 1].map(|end| constant[end].is_none() && cut_short[end] && moves[end]);
                let end = |end: (f64, Option<usize>), limit: f64, side: f64| {
                    let within = (limit - end.0) * side > 0.0 && !end.1.is_some_and(|end| cut[end]);
                    within.then(|| quantity.outside(end.0))
                };
                [end(low, limits.0, -1.0), end(high, limits.1, 1.0)]
            };
            let intervals = IntervalPair {
                interval_68: interval(sixty_eight, pair(0)),
                interval_95: interval(ninety_five, pair(1)),
            };
            let outer = [quantity.outside(limits.0), quantity.outside(limits.1)];
            QuantityOver {
                name: quantity.name().to_owned(),
                unit: quantity.unit().to_owned(),
                value: quantity.outside(value),
                sigma_known: quantity.estimate(outcome).sigma.unwrap_or(f64::NAN),
                intervals: stretched(intervals, *quantity, self.base, quantity.outside(value), outer),
            }
        };
        let near = NEAR * (limits[1] - limits[0]);
        // Where the model misses the data, the constant moves with parts of them as the quantities do.
        let widest = quantities.iter().map(|quantity| Quantiles::of(outcome).stretch(*quantity, outcome));
        let widest = widest.fold([1.0_f64; 2], |most, one| [most[0].max(one[0]), most[1].max(one[1])]);
        let widened = |place: usize| {
            pair(place).map(|end| {
                let moved = best + widest[place] * (end? - best);
                (limits[0] < moved && moved < limits[1]).then_some(moved)
            })
        };
        Ok(ConstantProfile {
            constant: self.constant,
            told: self.constant.of(self.settings),
            best,
            at_end: (cut_short[0] && best - limits[0] < near) || (cut_short[1] && limits[1] - best < near),
            intervals: IntervalPair { interval_68: widened(0), interval_95: widened(1) },
            limits,
            levels: [sixty_eight * sixty_eight, ninety_five * ninety_five],
            values: found.points.iter().map(|point| point.value).collect(),
            excess: found.points.iter().map(|point| point.excess).collect(),
            parameters: (found.points.iter())
                .map(|point| outside(&solution.searched.freedom.expand(&point.others)))
                .collect(),
            quantities: quantities.iter().enumerate().map(over).collect(),
            fit: self.base.clone(),
        })
    }

    /// Best values and standard deviations of `quantities` with the constant held; what the data leave open floats over its
    /// range.
    fn seen(&self, value: f64, free: &DVector<f64>, quantities: &[Quantity]) -> Option<Seen> {
        let (space, unit) = (&self.base.solution.searched, self.base.solution.unit);
        self.at(value, |problem, compiled| {
            let jacobian: DMatrix<f64> = problem.jacobian(free) / unit;
            let covariance = regularised(&jacobian, &space.ranges)?;
            let values = space.freedom.expand(free);
            // The sum of optical paths takes the index that is fitted.
            let mut now = Quantity::moving(compiled, space);
            now.retain(|quantity| quantities.iter().any(|other| other.name() == quantity.name()));
            let of = |quantity: &Quantity| {
                let slopes = quantity.slopes(space);
                (quantity.of(&values), slopes.dot(&(&covariance * &slopes)).max(0.0).sqrt())
            };
            (now.len() == quantities.len()).then(|| now.iter().map(of).collect())
        })
    }
}

/// Least and largest value of a quantity within `z` standard deviations, and at which end of the profile each is met, if at
/// one; none without a point.
///
/// - `points`: Δchi², best value, standard deviation along the profile; in between the root of the first and the others are
///   taken to be straight.
fn reach(points: &[[f64; 3]], z: f64) -> Option<[(f64, Option<usize>); 2]> {
    let (mut low, mut high) = ((f64::INFINITY, None), (f64::NEG_INFINITY, None));
    let last = points.len().saturating_sub(1);
    let mut ask = |[excess, value, sigma]: [f64; 3], end: Option<usize>| {
        let room = z * z - excess;
        if room < 0.0 {
            return;
        }
        let half = sigma * room.sqrt();
        if value - half < low.0 {
            low = (value - half, end);
        }
        if value + half > high.0 {
            high = (value + half, end);
        }
    };
    for (place, pair) in points.windows(2).enumerate() {
        for step in 0..=BETWEEN {
            #[allow(clippy::cast_precision_loss, reason = "a few steps")]
            let share = step as f64 / BETWEEN as f64;
            let mix = |from: f64, to: f64| from + share * (to - from);
            let between = std::array::from_fn(|column| match column {
                0 => mix(pair[0][0].sqrt(), pair[1][0].sqrt()).powi(2),
                column => mix(pair[0][column], pair[1][column]),
            });
            let first = (place == 0 && step == 0).then_some(0);
            ask(between, first.or((place + 1 == last && step == BETWEEN).then_some(1)));
        }
    }
    if let [only] = points {
        ask(*only, None);
    }
    (!points.is_empty()).then_some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_problem_has_the_variance_of_two_unknowns() {
        // chi² = (c / 0.5)² + ((x - 3 c) / 0.2)²: the variance of x is 0.2² + (3 · 0.5)².
        let at = |step: i32, steps: f64| -> [f64; 3] {
            let c = f64::from(step) / steps;
            [(c / 0.5).powi(2), 3.0 * c, 0.2]
        };
        // Points as near as one likes, and as far from each other as a profile steps: one standard deviation.
        for points in
            [(-40..=40).map(|step| at(step, 20.0)).collect::<Vec<_>>(), (-4..=4).map(|step| at(step, 2.0)).collect()]
        {
            for z in [1.0, 1.96] {
                let [low, high] = reach(&points, z).unwrap();
                let expected = z * (0.04_f64 + 2.25).sqrt();
                assert!((high.0 - expected).abs() < 4e-3 && (low.0 + expected).abs() < 4e-3, "{low:?} {high:?}");
                assert_eq!((low.1, high.1), (None, None));
            }
        }
        // Beyond a fifth of it the profile was not followed.
        let half: Vec<[f64; 3]> = (-40..=9).map(|step| at(step, 20.0)).collect();
        assert_eq!(reach(&half, 1.0).unwrap()[1].1, Some(1));
        assert_eq!(reach(&[], 1.0), None);
    }
}
