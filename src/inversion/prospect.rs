//! What a fit would tell of more data than it has: the normal equations at the best minimum and at its rivals, over the
//! data and scans that are not measured yet.
//!
//! ```text
//! H = J' J / unit² + diag(12 / range²),   C = H⁻¹
//! delta chi² of a rival = (r' r - g' H⁻¹ g) / unit²,   g = J' r   at the rival
//! ```
//!
//! `J` holds the derivatives by all parameters that were searched, held ones too, and by the nuisances in use. The second
//! term of `H` is an even guess over the bounds: what no reading tells has a standard deviation of 0.29 of its range. `r`
//! is the rival's distance from what the best minimum would give, with the nuisances fitted again to data and scan; the
//! term in `g` is what a step of its other parameters makes good.

use crate::dataset::{Dataset, Findings, Reading};
use crate::inversion::compiled::Compiled;
use crate::inversion::outcome::Fit;
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::plan::Plan;
use crate::inversion::problem::Problem;
use crate::inversion::quantity::indices;
use crate::inversion::settings::FitSettings;
use crate::inversion::solution::Solution;
use crate::inversion::truth::Truth;
use crate::optics::{OpticsError, ReflectivityModel};
use crate::optimise::{LeastSquares, Minimum};
use crate::synthetic::Scan;
use nalgebra::{DMatrix, DVector};

/// Readings of the data that are looked at, about; the weight of the others is given to these.
const READINGS: usize = 600;
/// Standard deviation of a nuisance before any reading, as a multiple of its value.
const NUISANCE: f64 = 10.0;
/// Least noise of a reading, as a share of the largest: no instrument repeats better, and noiseless data have no information
/// that an even guess could be added to.
const LEAST_NOISE: f64 = 1e-4;
/// Rivals that are followed.
const RIVALS: usize = 6;

/// A quantity of the fit: the gradient by the five parameters, inside units.
#[derive(Debug, Clone)]
pub(crate) struct Quantity {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    gradient: [f64; COUNT],
    /// One inside unit in the user's.
    pub(crate) outside: f64,
    /// At the best minimum, inside units.
    pub(crate) value: f64,
    /// Of a free parameter, inside units.
    pub(crate) range: Option<f64>,
}

/// A structure that fits as well as the best.
#[derive(Debug, Clone)]
pub(crate) struct Rival {
    point: DVector<f64>,
    values: [f64; COUNT],
    /// chi² above the best in the data, in units of the widened noise.
    pub(crate) seen: f64,
    /// The same for data as the best minimum would give them, at this expansion.
    alone: f64,
}

/// What is expected of a set of readings.
#[derive(Debug, Clone)]
pub(crate) struct Prospect {
    /// Standard deviation of each quantity, inside units, the rivals included: each structure counts with `exp(-chi²/2)`.
    pub(crate) spreads: Vec<f64>,
    /// chi² of each rival above the best.
    pub(crate) rivals: Vec<f64>,
}

/// A fit, and scans that could be added to its data.
#[derive(Debug)]
pub(crate) struct Prospects<'a> {
    settings: &'a FitSettings,
    solution: &'a Solution,
    model: &'a dyn ReflectivityModel,
    /// The data as the best minimum would give them, then the readings of the scans.
    pool: Dataset,
    /// Rows of the data, and square roots of their weights.
    base: Vec<(usize, f64)>,
    /// Rows of each scan in the pool.
    rows: Vec<std::ops::Range<usize>>,
    best: DVector<f64>,
    /// Standard deviation of a weighted residual.
    unit: f64,
    /// Free parameters, then period and optical sum.
    pub(crate) quantities: Vec<Quantity>,
    pub(crate) rivals: Vec<Rival>,
}

impl<'a> Prospects<'a> {
    /// Compiles the readings that the data and `scans` would have if `truth` were true. `rivals` are the structures that
    /// fit as well, or none.
    ///
    /// A reading of a scan has the noise of the data: their median sigma, or the scatter about the model.
    pub(crate) fn new(
        data: &Dataset,
        fit: &'a Fit,
        model: &'a dyn ReflectivityModel,
        truth: &Truth,
        scans: &[Scan],
        rivals: Vec<Rival>,
    ) -> Result<Self, ProspectError> {
        let (settings, solution) = (&fit.outcome.settings, &fit.solution);
        let mut readings: Vec<Reading> = data.readings().to_vec();
        for (reading, intensity) in readings.iter_mut().zip(&truth.data) {
            reading.intensity = *intensity;
        }
        let sigma = median_sigma(data);
        let mut rows = Vec::new();
        let mut curves = data.curves().len();
        for scan in scans {
            let first = readings.len();
            let seen = truth.readings(scan, model).unwrap_or_default();
            readings.extend(seen.into_iter().map(|reading| Reading { sigma, curve: curves, ..reading }));
            rows.push(first..readings.len());
            curves += 1;
        }
        let pool = Dataset::from_readings(readings, (0..curves).map(|curve| curve.to_string()).collect())?;
        let best = truth.point.clone();
        let size = |reading: &Reading| reading.intensity.abs() / reading.sigma.unwrap_or(1.0);
        let largest = data.readings().iter().map(size).fold(0.0, f64::max);
        let unit = solution.unit.max(LEAST_NOISE * largest);
        let base = base(data, &solution.robust);
        let quantities = quantities(data, model, solution, &truth.values);
        let mut prospects = Self { settings, solution, model, pool, base, rows, best, unit, quantities, rivals };
        let (rows, roots): (Vec<usize>, Vec<f64>) = prospects.base.iter().copied().unzip();
        let compiled = Compiled::of_rows(&prospects.pool, settings, model, &rows)?;
        let alone =
            |rival: &Rival| prospects.normal_equations(&compiled, &roots, &rival.point).map(|(_, missed)| missed);
        let alone: Vec<Option<f64>> = prospects.rivals.iter().map(alone).collect();
        for (rival, alone) in prospects.rivals.iter_mut().zip(alone) {
            rival.alone = alone.unwrap_or(0.0);
        }
        Ok(prospects)
    }

    /// What the data and some of the scans would tell; `None` if the normal equations cannot be solved.
    pub(crate) fn with(&self, scans: &[usize]) -> Option<Prospect> {
        let mut rows: Vec<usize> = self.base.iter().map(|(row, _)| *row).collect();
        let mut roots: Vec<f64> = self.base.iter().map(|(_, root)| *root).collect();
        for scan in scans {
            rows.extend(self.rows.get(*scan)?.clone());
        }
        roots.resize(rows.len(), 1.0);
        let compiled = Compiled::of_rows(&self.pool, self.settings, self.model, &rows).ok()?;
        let (information, _) = self.normal_equations(&compiled, &roots, &self.best)?;
        let covariance = information.inverse();
        let mut rivals = Vec::with_capacity(self.rivals.len());
        for rival in &self.rivals {
            let (_, missed) = self.normal_equations(&compiled, &roots, &rival.point)?;
            rivals.push(rival.seen + (missed - rival.alone).max(0.0));
        }
        let free = self.solution.searched.freedom.matrix();
        let weights: Vec<f64> = rivals.iter().map(|chi2| (-0.5 * chi2).exp()).collect();
        let total = 1.0 + weights.iter().sum::<f64>();
        let spreads = self.quantities.iter().map(|quantity| {
            let along = free.tr_mul(&DVector::from_column_slice(&quantity.gradient));
            let block = covariance.view((0, 0), (along.len(), along.len()));
            let variance = (block * &along).dot(&along).max(0.0);
            let offsets = self.rivals.iter().map(|rival| quantity.of(&rival.values) - quantity.value);
            let moments = offsets.zip(&weights).fold((0.0, 0.0), |(first, second), (offset, weight)| {
                (first + weight / total * offset, second + weight / total * offset * offset)
            });
            (variance + (moments.1 - moments.0 * moments.0).max(0.0)).sqrt()
        });
        let spreads: Vec<f64> = spreads.collect();
        spreads.iter().all(|spread| spread.is_finite()).then_some(Prospect { spreads, rivals })
    }

    /// `H`, decomposed, and the distance `(r' r - g' H⁻¹ g) / unit²` at a point.
    fn normal_equations(&self, compiled: &Compiled<'_>, roots: &[f64], at: &DVector<f64>) -> Option<(Scaled, f64)> {
        let space = &self.solution.searched;
        let problem = Problem::new(compiled, space, roots);
        let residuals = problem.residuals(at);
        let point = problem.evaluate(at)?;
        let jacobian = problem.full_jacobian(&point);
        let variance = self.unit.powi(2);
        let mut information = jacobian.tr_mul(&jacobian) / variance;
        let ranges = space.ranges.iter().map(|range| range / 12.0_f64.sqrt());
        let in_use = point.coefficients.iter().filter(|value| **value > 0.0).map(|value| NUISANCE * value);
        for (j, deviation) in ranges.chain(in_use).enumerate() {
            information[(j, j)] += deviation.powi(-2);
        }
        let scaled = Scaled::new(information)?;
        let gradient = jacobian.tr_mul(&residuals) / variance;
        let gained = gradient.dot(&scaled.solve(&gradient));
        let missed = residuals.norm_squared() / variance - gained;
        missed.is_finite().then_some((scaled, missed))
    }
}

impl Rival {
    /// Those of a fit, for the case that `truth` is true: where the data leave a direction open they move along with it.
    pub(crate) fn of(solution: &Solution, truth: &Truth, best: &Truth, level: f64) -> Vec<Self> {
        let space = &solution.searched;
        let least = solution.minima.first().map_or(0.0, |minimum| minimum.sum_of_squares);
        let rival = |minimum: &Minimum| {
            let point = space.bounds.clamp(&(&minimum.parameters + (&truth.point - &best.point)));
            let seen = (minimum.sum_of_squares - least) / solution.unit.powi(2);
            Self { values: space.freedom.expand(&point), point, seen, alone: 0.0 }
        };
        let others = solution.minima.iter().skip(1).map(rival);
        others.filter(|rival| rival.seen <= level).take(RIVALS).collect()
    }

    /// Its values in the user's units.
    pub(crate) fn outside(&self) -> [f64; COUNT] {
        Parameter::ALL.map(|parameter| parameter.outside(self.values[parameter.index()]))
    }
}

impl Quantity {
    fn of(&self, values: &[f64; COUNT]) -> f64 {
        self.gradient.iter().zip(values).map(|(slope, value)| slope * value).sum()
    }
}

/// A positive matrix with its diagonal scaled to 1, decomposed.
struct Scaled {
    lengths: DVector<f64>,
    cholesky: nalgebra::Cholesky<f64, nalgebra::Dyn>,
}

impl Scaled {
    fn new(matrix: DMatrix<f64>) -> Option<Self> {
        let lengths = matrix.diagonal().map(f64::sqrt);
        if !lengths.iter().all(|length| length.is_finite() && *length > 0.0) {
            return None;
        }
        let scaled =
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] / (lengths[i] * lengths[j]));
        Some(Self { lengths, cholesky: scaled.cholesky()? })
    }

    fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        self.cholesky.solve(&right.component_div(&self.lengths)).component_div(&self.lengths)
    }

    fn inverse(&self) -> DMatrix<f64> {
        let inverse = self.cholesky.inverse();
        DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |i, j| inverse[(i, j)] / (self.lengths[i] * self.lengths[j]))
    }
}

/// Prospects that could not be compiled.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum ProspectError {
    #[error(transparent)]
    Optics(#[from] OpticsError),
    #[error(transparent)]
    Data(#[from] Findings),
}

fn quantities(
    data: &Dataset,
    model: &dyn ReflectivityModel,
    solution: &Solution,
    values: &[f64; COUNT],
) -> Vec<Quantity> {
    let free = solution.searched.freedom.free.iter().zip(&solution.searched.ranges);
    let mut all: Vec<Quantity> = free
        .map(|(&parameter, &range)| {
            let mut gradient = [0.0; COUNT];
            gradient[parameter.index()] = 1.0;
            let (name, unit, outside) = (parameter.name(), parameter.unit(), parameter.outside(1.0));
            Quantity { name, unit, gradient, outside, value: values[parameter.index()], range: Some(range) }
        })
        .collect();
    let (gap, cuticle) = indices(data, model.stack());
    let moves = |parameter| solution.searched.freedom.moves(parameter);
    if moves(Parameter::DAir) || moves(Parameter::DCuticle) {
        for (name, on_air, on_cuticle) in [("period", 1.0, 1.0), ("optical_sum", gap, cuticle)] {
            let gradient = [on_air, on_cuticle, 0.0, 0.0, 0.0];
            let value = on_air * values[0] + on_cuticle * values[1];
            all.push(Quantity { name, unit: "nm", gradient, outside: 1.0, value, range: None });
        }
    }
    all
}

/// About [`READINGS`] rows of the data with the square roots of their weights: the robust ones, times those that make up
/// for the rows of the same curve that are left out.
fn base(data: &Dataset, robust: &[f64]) -> Vec<(usize, f64)> {
    let rows = Plan::thinned_rows(data, READINGS);
    let mut counts = vec![(0_u32, 0_u32); data.curves().len()];
    for reading in data.readings() {
        counts[reading.curve].0 += 1;
    }
    for &row in &rows {
        counts[data.readings()[row].curve].1 += 1;
    }
    let root = |row: usize| {
        let (all, kept) = counts[data.readings()[row].curve];
        robust.get(row).copied().unwrap_or(1.0) * (f64::from(all) / f64::from(kept.max(1))).sqrt()
    };
    rows.into_iter().map(|row| (row, root(row))).collect()
}

fn median_sigma(data: &Dataset) -> Option<f64> {
    let mut sigmas: Vec<f64> = data.readings().iter().filter_map(|reading| reading.sigma).collect();
    sigmas.sort_by(f64::total_cmp);
    sigmas.get(sigmas.len() / 2).copied()
}
