//! Estimates: values, standard deviations, intervals and statuses from the covariance at a minimum.

use crate::dataset::Dataset;
use crate::inversion::beyond::is_free_on_bound;
use crate::inversion::compiled::Compiled;
use crate::inversion::elsewhere::elsewhere;
use crate::inversion::intervals::Quantiles;
use crate::inversion::nuisance::{Column, LinearPart, Multiplies};
use crate::inversion::outcome::{Derived, Estimate, NamedMatrix, NuisanceFound, SigmaSource, Status};
use crate::inversion::parameter::{COUNT, Parameter, Role};
use crate::inversion::plan::Plan;
use crate::inversion::problem::{Evaluation, Problem};
use crate::inversion::quantity::{Quantity, indices};
use crate::inversion::settings::FitSettings;
use crate::inversion::solution::Solution;
use crate::inversion::space::Space;
use crate::inversion::undetermined::Held;
use crate::optimise::Minimum;
use crate::uncertainty::covariance::{correlation, covariance};
use crate::uncertainty::discrepancy::Spread;
use nalgebra::{Cholesky, DMatrix, DVector};

/// An ambiguous value whose answers cover more than this share of the bounds is none.
const ALL: f64 = 0.8;
/// A correlation beyond this is a status of its own.
const CORRELATED: f64 = 0.99;
/// A value at another minimum is another value only if it lies off by more than this share of a change that matters.
const NOTICEABLE: f64 = 0.2;
/// A derived quantity with a smaller slope by every free parameter does not depend on them: a link keeps it.
const ROUNDING: f64 = 1e-12;
/// A derived quantity that changes by more than this share along an undetermined direction is undetermined.
const LEAK: f64 = 0.05;

/// Everything a summary is made of.
#[derive(Debug)]
pub(crate) struct Found<'a> {
    pub(crate) compiled: &'a Compiled<'a>,
    pub(crate) solution: &'a Solution,
    pub(crate) data: &'a Dataset,
    pub(crate) settings: &'a FitSettings,
    pub(crate) plan: &'a Plan<'a>,
    pub(crate) linear: &'a LinearPart,
    pub(crate) robust: &'a [f64],
    /// Weighted residual that counts as one standard deviation in the robust loss.
    pub(crate) robust_unit: f64,
    /// The space that was searched.
    pub(crate) searched: &'a Space,
    /// What was left of it when the undetermined parameters were taken out.
    pub(crate) space: &'a Space,
    pub(crate) best: &'a Minimum,
    pub(crate) minima: &'a [Minimum],
    pub(crate) held: &'a [Held],
}

impl<'a> Found<'a> {
    pub(crate) fn new(compiled: &'a Compiled<'a>, solution: &'a Solution) -> Self {
        Self {
            compiled,
            solution,
            data: compiled.data,
            settings: compiled.settings,
            plan: &compiled.plan,
            linear: &compiled.linear,
            robust: &solution.robust,
            robust_unit: solution.robust_unit,
            searched: &solution.searched,
            space: &solution.space,
            best: &solution.best,
            minima: &solution.minima,
            held: &solution.held,
        }
    }
}

/// Covariance over the parameters that moved freely, and the rules for intervals.
pub(crate) struct Uncertainty {
    /// Free parameters inside their bounds, or on one that costs nothing.
    inner: Vec<Parameter>,
    /// Covariance of these, then of the nuisances in use; `None` if it does not exist.
    matrix: Option<DMatrix<f64>>,
    /// What the model's misses add to it.
    spread: Option<Spread>,
    /// The covariance with what misses and held parameters add to it.
    common: Option<DMatrix<f64>>,
    columns: Vec<usize>,
    pub(crate) quantiles: Quantiles,
    /// Standard deviation of a weighted residual.
    unit: f64,
    /// Whether the model misses the data.
    misses: bool,
}

/// How far `sum gradient · parameter` moves at most along a held parameter; the truth lies
/// anywhere between, so that a third of its square is a variance.
fn shift(held: &Held, gradient: &[f64; COUNT], found: &Found<'_>) -> f64 {
    let here = found.space.freedom.expand(&found.best.parameters);
    let moved = |there: &[f64; COUNT]| {
        (0..COUNT)
            .filter(|&j| Some(j) != held.direction.first().map(|(parameter, _)| parameter.index()))
            .map(|j| gradient[j] * (there[j] - here[j]))
            .sum::<f64>()
            .abs()
    };
    held.elsewhere.iter().map(moved).fold(0.0, f64::max)
}

pub(crate) fn index_ratio(found: &Found<'_>) -> f64 {
    let (gap, cuticle) = indices(found.data, &found.settings.stack);
    cuticle / gap
}

fn rows(matrix: &DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

impl Uncertainty {
    pub(crate) fn new(
        found: &Found<'_>,
        problem: &Problem<'_>,
        point: &Evaluation,
        in_use: &[usize],
        unit: f64,
        dof: usize,
        source: SigmaSource,
    ) -> Self {
        let free = &found.space.freedom.free;
        let (lower, upper) = (found.space.bounds.lower(), found.space.bounds.upper());
        let at = &found.best.parameters;
        let is_inside = |&j: &usize| at[j] > lower[j] && at[j] < upper[j] || is_free_on_bound(found, unit, j);
        let moved: Vec<usize> = (0..free.len()).filter(is_inside).collect();
        // Without nuisances in use the Jacobian of the best point is the whole one.
        let full = if in_use.is_empty() { found.best.triangle.clone() } else { problem.full_jacobian(point) };
        let columns: Vec<usize> = moved.iter().copied().chain(free.len()..full.ncols()).collect();
        let matrix = covariance(&full.select_columns(&columns)).map(|matrix| matrix * (unit * unit));
        Self {
            inner: moved.iter().map(|&j| free[j]).collect(),
            matrix,
            spread: None,
            common: None,
            columns: in_use.to_vec(),
            quantiles: Quantiles::new(source, dof),
            unit,
            misses: source == SigmaSource::Widened,
        }
    }

    /// Adds the spread of the answer over parts of the data; returns the factor on the standard deviations of the free
    /// parameters, their geometric mean.
    pub(crate) fn widen(&mut self, spread: Option<Spread>, dof: usize) -> f64 {
        let (Some(spread), Some(matrix)) = (spread, &self.matrix) else { return 1.0 };
        let (mut logarithms, mut count) = (0.0, 0.0);
        for (i, parameter) in self.inner.iter().enumerate() {
            let (own, added) = (matrix[(i, i)], spread.of(&[parameter.index()])[(0, 0)]);
            if own > 0.0 {
                logarithms += 0.5 * (1.0 + added / own).ln();
                count += 1.0;
            }
        }
        self.quantiles = Quantiles::new(SigmaSource::Widened, dof.min(spread.dof));
        self.spread = Some(spread);
        if count > 0.0 { f64::exp(logarithms / count) } else { 1.0 }
    }

    /// What is held, and what ended on a bound, unless the model misses the data: it may do so because of its bounds.
    fn open<'a>(&self, found: &Found<'a>) -> impl Iterator<Item = &'a Held> {
        let stopped = if self.misses { &[] } else { found.solution.stopped.as_slice() };
        found.held.iter().chain(stopped)
    }

    /// Makes the covariance that the estimates have in common, of the covariance at the best point, what the model's misses add, and
    /// what moves along each held parameter: the way to the one of its other values that is the most standard deviations off, spread
    /// evenly. Once, after [`Uncertainty::widen`].
    pub(crate) fn settle(&mut self, found: &Found<'_>) {
        let Some(matrix) = &self.matrix else { return };
        let mut common = matrix.clone();
        if let Some(spread) = &self.spread {
            let chosen = self.inner.iter().map(|parameter| parameter.index());
            common += spread.of(&chosen.chain((0..self.columns.len()).map(|c| COUNT + c)).collect::<Vec<usize>>());
        }
        let here = found.space.freedom.expand(&found.best.parameters);
        // What is not told apart from a held parameter has no deviation that could be widened.
        let steps: Vec<[f64; COUNT]> = found.held.iter().map(|held| held.step(found.searched)).collect();
        let is_told: [bool; COUNT] = std::array::from_fn(|j| steps.iter().all(|step| step[j].abs() <= 0.0));
        let moved = |there: &[f64; COUNT]| {
            DVector::from_fn(matrix.nrows(), |row, _| match self.inner.get(row).map(|parameter| parameter.index()) {
                Some(j) if is_told[j] => there[j] - here[j],
                _ => 0.0,
            })
        };
        if let Some(factors) = Cholesky::new(common.clone()) {
            let deviations = |moved: &DVector<f64>| moved.dot(&factors.solve(moved));
            for held in self.open(found) {
                let others = held.elsewhere.iter().map(moved);
                if let Some(farthest) = others.max_by(|a, b| deviations(a).total_cmp(&deviations(b))) {
                    common += &farthest * farthest.transpose() / 3.0;
                }
            }
        }
        self.common = Some(common);
    }

    /// How the free parameters move, inside units, where `sum_j gradient_j · parameter_j` grows by 1 and chi² by as little as the covariance
    /// lets it.
    pub(crate) fn along(&self, gradient: &[f64; COUNT], found: &Found<'_>) -> Option<DVector<f64>> {
        let matrix = self.matrix.as_ref()?;
        let free = &found.space.freedom.free;
        let places: Vec<usize> =
            self.inner.iter().map(|parameter| free.iter().position(|own| own == parameter)).collect::<Option<_>>()?;
        let slopes = found.space.freedom.matrix().tr_mul(&DVector::from_column_slice(gradient));
        let own = DVector::from_fn(matrix.nrows(), |row, _| places.get(row).map_or(0.0, |&place| slopes[place]));
        let moved = matrix * &own;
        let variance = moved.dot(&own);
        let mut step = DVector::zeros(free.len());
        for (row, &place) in places.iter().enumerate() {
            step[place] = moved[row] / variance;
        }
        (variance > 0.0).then_some(step)
    }

    /// Variance of `sum_j gradient_j · parameter_j` over the free parameters inside their bounds, or on one that costs nothing; `None` if it depends on
    /// none of them: a quantity that only follows what was given or stopped at a bound has no error of its own.
    fn variance(&self, gradient: &[f64; COUNT], found: &Found<'_>) -> Option<f64> {
        let matrix = self.matrix.as_ref()?;
        let to_free = found.space.freedom.matrix();
        let mut along = DVector::zeros(matrix.nrows());
        for (c, parameter) in self.inner.iter().enumerate() {
            let column = found.space.freedom.free.iter().position(|free| free == parameter)?;
            along[c] = (0..COUNT).map(|row| gradient[row] * to_free[(row, column)]).sum();
        }
        let added = self.spread.as_ref().map_or(0.0, |spread| spread.variance(&DVector::from_column_slice(gradient)));
        let even: f64 = self.open(found).map(|held| shift(held, gradient, found).powi(2) / 3.0).sum();
        (along.amax() > 0.0).then(|| (matrix * &along).dot(&along).max(0.0) + added + even)
    }

    /// Factor by which the spread widens a standard deviation of this variance.
    fn widened_by(&self, gradient: &[f64; COUNT], variance: Option<f64>) -> Option<f64> {
        let added = self.spread.as_ref()?.variance(&DVector::from_column_slice(gradient));
        let variance = variance.filter(|variance| *variance > added)?;
        Some((variance / (variance - added)).sqrt())
    }

    pub(crate) fn parameter(&self, found: &Found<'_>, point: &Evaluation, parameter: Parameter) -> Estimate {
        let inside = point.values[parameter.index()];
        let mut gradient = [0.0; COUNT];
        gradient[parameter.index()] = 1.0;
        let mut estimate = Estimate::new(parameter.outside(inside), parameter.unit());
        let role = found.settings.roles[parameter.index()];
        if let Role::Free { lower, upper } = role {
            estimate.bounds = Some([parameter.outside(lower), parameter.outside(upper)]);
        }
        // What follows a fixed parameter is as fixed as that one.
        if !found.searched.freedom.moves(parameter) {
            estimate.status = Status::Fixed;
            return estimate;
        }
        let touched: Vec<&Held> =
            found.held.iter().filter(|held| held.step(found.searched)[parameter.index()].abs() > 0.0).collect();
        if !touched.is_empty() {
            let alone = role_is_free(role)
                && touched.iter().any(|held| held.direction.len() == 1 && held.deviation.is_infinite());
            estimate.status = if alone { Status::Insensitive } else { Status::NotIdentifiable };
            let partners = touched.iter().flat_map(|held| &held.direction).map(|(part, _)| *part);
            let mut partners: Vec<Parameter> = partners.filter(|part| *part != parameter).collect();
            partners.sort();
            partners.dedup();
            estimate.with = partners.iter().map(|part| part.name().to_owned()).collect();
            estimate.held_at = estimate.value.take();
            return estimate;
        }
        let followed = match role {
            Role::Linked { other, .. } => {
                estimate.status = Status::Linked;
                estimate.with = vec![other.name().to_owned()];
                other
            }
            Role::Free { .. } | Role::Fixed { .. } => parameter,
        };
        let noticeable = NOTICEABLE * parameter.outside(parameter.typical_change());
        let value = |values: &[f64; COUNT]| parameter.outside(values[parameter.index()]);
        if role_is_free(role) && !self.inner.contains(&followed) {
            // A model that misses may do so because of its bounds, and then everything fits as well.
            let elsewhere = if self.misses { Vec::new() } else { elsewhere(found, self.unit, value) };
            estimate.stopped_at_bound(&elsewhere, noticeable);
            let own =
                found.solution.stopped.iter().filter(|stopped| !self.misses && stopped.direction[0].0 == parameter);
            let mut others: Vec<f64> = own.flat_map(|stopped| &stopped.elsewhere).map(value).collect();
            others.extend(elsewhere.iter().map(|other| other.value));
            estimate.open_from_bound(&others, noticeable);
            return estimate;
        }
        let variance = self.variance(&gradient, found);
        estimate.widened_by = self.widened_by(&gradient, variance);
        self.finish(&mut estimate, variance.map(|variance| parameter.outside(variance.sqrt())));
        if estimate.status == Status::Ok {
            estimate.with = self.correlated_with(parameter);
            if !estimate.with.is_empty() {
                estimate.status = Status::Correlated;
            }
        }
        estimate.allow_for(&elsewhere(found, self.unit, value), noticeable, &self.quantiles);
        self.withdraw_if_anywhere(&mut estimate);
        estimate
    }

    /// Takes back an ambiguous value whose answers lie anywhere within the bounds.
    fn withdraw_if_anywhere(&self, estimate: &mut Estimate) {
        let is_open = matches!(estimate.interval_95, Some([None, None]));
        let is_anywhere = is_open || estimate.covered(self.quantiles.ninety_five) > ALL;
        if estimate.status == Status::Ambiguous && is_anywhere {
            estimate.withdraw();
        }
    }

    /// Names of the parameters whose correlation with `parameter` is beyond [`CORRELATED`].
    fn correlated_with(&self, parameter: Parameter) -> Vec<String> {
        let (Some(matrix), Some(row)) = (&self.common, self.inner.iter().position(|p| *p == parameter)) else {
            return Vec::new();
        };
        let correlation = correlation(matrix);
        let close = |&(column, other): &(usize, &Parameter)| {
            column != row && *other != parameter && correlation[(row, column)].abs() > CORRELATED
        };
        self.inner.iter().enumerate().filter(close).map(|(_, other)| other.name().to_owned()).collect()
    }

    /// Sigma and intervals; an interval that reaches a bound is open there.
    fn finish(&self, estimate: &mut Estimate, sigma: Option<f64>) {
        let (Some(value), Some(sigma)) = (estimate.value, sigma.filter(|sigma| sigma.is_finite())) else {
            return;
        };
        estimate.sigma = Some(sigma);
        let bounds = estimate.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let interval = |quantile: f64| {
            let (low, high) = (value - quantile * sigma, value + quantile * sigma);
            [(low > bounds[0]).then_some(low), (high < bounds[1]).then_some(high)]
        };
        estimate.interval_68 = Some(interval(self.quantiles.sixty_eight));
        estimate.interval_95 = Some(interval(self.quantiles.ninety_five));
        estimate.mark_open_ends();
    }

    pub(crate) fn derived(&self, found: &Found<'_>, point: &Evaluation) -> Derived {
        let (gap, cuticle) = indices(found.data, &found.settings.stack);
        let of = |quantity: Quantity| {
            let gradient = quantity.gradient();
            let mut estimate = Estimate::new(quantity.of(&point.values), "nm");
            let (least, most) = quantity.limits(found.searched);
            estimate.bounds = (least < most).then_some([least, most]);
            let along = found.searched.freedom.matrix().tr_mul(&DVector::from_column_slice(&gradient));
            if along.iter().all(|slope| slope.abs() <= ROUNDING) {
                estimate.status = Status::Fixed;
                return estimate;
            }
            let mut extra = 0.0;
            for held in found.held {
                let changes = held.step(found.searched).into_iter().zip(gradient).map(|(step, slope)| slope * step);
                let (change, size) = changes.fold((0.0, 0.0), |(sum, size), c| (sum + c, size + f64::abs(c)));
                if size > 0.0 && f64::abs(change) > LEAK * size {
                    estimate.status = Status::NotIdentifiable;
                    estimate.held_at = estimate.value.take();
                    return estimate;
                }
                extra += (change * held.deviation.min(1.0)).powi(2);
            }
            let at_bound = [Parameter::DAir, Parameter::DCuticle]
                .into_iter()
                .any(|p| found.space.freedom.free.contains(&p) && !self.inner.contains(&p));
            if at_bound {
                estimate.status = Status::AtBound;
            }
            let variance = self.variance(&gradient, found);
            estimate.widened_by = self.widened_by(&gradient, variance);
            self.finish(&mut estimate, variance.map(|variance| (variance + extra).sqrt()));
            let noticeable = NOTICEABLE * Parameter::DAir.typical_change();
            let elsewhere = elsewhere(found, self.unit, |values| quantity.of(values));
            estimate.allow_for(&elsewhere, noticeable, &self.quantiles);
            self.withdraw_if_anywhere(&mut estimate);
            estimate
        };
        Derived { period: of(Quantity::Period), optical_sum: of(Quantity::OpticalSum { gap, cuticle }) }
    }

    /// Covariance and correlation, user units, whose diagonal is that of the standard deviations in `estimates` that there are; empty
    /// where they do not exist.
    pub(crate) fn named_matrices(
        &self,
        found: &Found<'_>,
        estimates: &[Estimate; COUNT],
    ) -> (NamedMatrix, NamedMatrix) {
        let Some(matrix) = &self.common else { return Default::default() };
        // A parameter that is not told has no deviation; its row would be one with others held.
        let has_sigma = |row: &usize| self.inner.get(*row).is_none_or(|own| estimates[own.index()].sigma.is_some());
        let kept: Vec<usize> = (0..matrix.nrows()).filter(has_sigma).collect();
        let name = |&row: &usize| {
            let column = |place: usize| column_name(&found.linear.columns[self.columns[place]], found.data);
            self.inner.get(row).map_or_else(|| column(row - self.inner.len()), |parameter| parameter.name().to_owned())
        };
        let names: Vec<String> = kept.iter().map(name).collect();
        // Structures nearby that fit as well widen a deviation further; how they move together is not told.
        let factor = |j: usize| {
            let Some(parameter) = self.inner.get(j) else { return 1.0 };
            let own = parameter.outside(matrix[(j, j)].sqrt());
            let widened = estimates[parameter.index()].sigma.map(|sigma| sigma / own);
            let widened = widened.filter(|factor| factor.is_finite() && (factor - 1.0).abs() > ROUNDING);
            parameter.outside(widened.unwrap_or(1.0))
        };
        let scaled = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
            factor(kept[i]) * factor(kept[j]) * matrix[(kept[i], kept[j])]
        });
        let named = |matrix: &DMatrix<f64>| NamedMatrix { names: names.clone(), rows: rows(matrix) };
        (named(&scaled), named(&correlation(&scaled)))
    }

    pub(crate) fn nuisances(&self, found: &Found<'_>, point: &Evaluation, bound_costs: bool) -> Vec<NuisanceFound> {
        let total = &self.common;
        let sigma = |i: usize| {
            let place = self.columns.iter().position(|&column| column == i)? + self.inner.len();
            total.as_ref().map(|matrix| matrix[(place, place)].sqrt())
        };
        // A parameter that acts as a scale, has other values which fit, or would go on beyond a bound was held at some value, and
        // the scale with it.
        let moves = |held: &Held| held.absorbed && held.direction.len() == 1 || !held.elsewhere.is_empty();
        let conditional = bound_costs || self.open(found).any(moves);
        (found.linear.columns.iter().enumerate())
            .map(|(i, column)| NuisanceFound {
                name: column_name(column, found.data),
                value: point.coefficients[i],
                sigma: sigma(i).filter(|_| !conditional),
                conditional,
            })
            .collect()
    }
}

fn role_is_free(role: Role) -> bool {
    matches!(role, Role::Free { .. })
}

/// `scale`, `lamella_scale` (scale · weight) or `background`, with the curve it belongs to.
fn column_name(column: &Column, data: &Dataset) -> String {
    let what = match column.multiplies {
        Multiplies::Lamella => "lamella_scale",
        Multiplies::Multilayer | Multiplies::Both => "scale",
        Multiplies::One => "background",
    };
    column.curve.map_or_else(|| what.to_owned(), |curve| format!("{what} of {}", data.curves()[curve]))
}
