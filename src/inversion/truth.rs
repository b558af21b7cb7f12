//! Structures that may be the true one as far as the data tell, and what would be read of them.

use crate::dataset::Reading;
use crate::geometry::Geometry;
use crate::inversion::compiled::Compiled;
use crate::inversion::nuisance::Weight;
use crate::inversion::parameter::{COUNT, structure};
use crate::inversion::problem::Problem;
use crate::inversion::solution::Solution;
use crate::optics::ReflectivityModel;
use crate::optimise::{Bounds, BoundsError};
use crate::synthetic::Scan;
use nalgebra::DVector;

/// Structures beside the best where the data leave a direction open.
const OTHERS: usize = 4;
/// Share of the room along an open direction that is left free at either end.
const MARGIN: f64 = 0.1;

/// A structure that may be the true one.
#[derive(Debug, Clone)]
pub(crate) struct Truth {
    /// In the space that was searched.
    pub(crate) point: DVector<f64>,
    pub(crate) values: [f64; COUNT],
    /// What it gives at the readings of the data, with the nuisances that fit them best.
    pub(crate) data: Vec<f64>,
    /// Mean factor on A of the curves that show it.
    lamella: f64,
    /// Mean factor on B of the curves that show it.
    multilayer: f64,
    /// Mean background.
    background: f64,
}

/// The best structure, then others along the directions that the data do not determine; empty if the model has no value
/// at the best.
///
/// # Seed
/// The others are a Latin hypercube over the open directions, from the seed of the fit.
pub(crate) fn truths(compiled: &Compiled<'_>, solution: &Solution) -> Result<Vec<Truth>, BoundsError> {
    let best = solution.searched.freedom.restrict(&solution.space.freedom.expand(&solution.best.parameters));
    let Some(first) = Truth::new(compiled, solution, best.clone()) else { return Ok(Vec::new()) };
    let mut truths = vec![first];
    let open = solution.held.len();
    if open > 0 {
        let unit = Bounds::new(&vec![MARGIN; open], &vec![1.0 - MARGIN; open])?;
        let shares = unit.latin_hypercube(OTHERS, compiled.settings.seed);
        let points = shares.iter().map(|shares| moved(solution, &best, shares));
        truths.extend(points.filter_map(|point| Truth::new(compiled, solution, point)));
    }
    Ok(truths)
}

/// A point moved along each open direction to a share of the room that the bounds leave.
fn moved(solution: &Solution, from: &DVector<f64>, shares: &DVector<f64>) -> DVector<f64> {
    let (space, mut point) = (&solution.searched, from.clone());
    for (held, share) in solution.held.iter().zip(shares) {
        let mut step = DVector::zeros(point.len());
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (parameter, size) in &held.direction {
            let Some(j) = space.freedom.free.iter().position(|free| free == parameter) else { continue };
            let ends = [space.bounds.lower()[j], space.bounds.upper()[j]].map(|bound| (bound - point[j]) / size);
            (low, high) = (low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1])));
            step[j] = *size;
        }
        let along = low + share * (high - low);
        if along.is_finite() {
            point += step * along;
        }
    }
    space.bounds.clamp(&point)
}

impl Truth {
    fn new(compiled: &Compiled<'_>, solution: &Solution, point: DVector<f64>) -> Option<Self> {
        let problem = Problem::new(compiled, &solution.searched, &solution.robust);
        let at = problem.evaluate(&point)?;
        let (mut lamella, mut multilayer, mut background) = (Mean::default(), Mean::default(), Mean::default());
        let mut data = Vec::with_capacity(compiled.plan.len());
        for reading in compiled.plan.readings() {
            let parts = compiled.plan.parts(reading, at.terms.view());
            data.push(compiled.linear.value(reading.curve, parts, &at.coefficients));
            let (on_a, on_b, below) = compiled.linear.factors(reading.curve, &at.coefficients);
            lamella.add(reading.share_a, on_a);
            multilayer.add(reading.share_b, on_b);
            background.add(1.0, below);
        }
        if !data.iter().all(|value| value.is_finite()) {
            return None;
        }
        // A part that the data do not show is as strong beside the other as the models have it.
        let weight = match compiled.settings.nuisances.weight {
            Weight::Fixed(weight) => weight,
            Weight::Fitted => 1.0,
        };
        let on_b = multilayer.value().or_else(|| lamella.value().map(|on_a| on_a / weight)).unwrap_or(1.0);
        let multilayer = if on_b.is_finite() { on_b } else { 1.0 };
        Some(Self {
            values: at.values,
            point,
            data,
            lamella: lamella.value().unwrap_or(weight * multilayer),
            multilayer,
            background: background.value().unwrap_or(0.0),
        })
    }

    /// What would be read, without sigma, all in curve 0; `None` where the model has no value for one of the readings.
    pub(crate) fn readings(&self, scan: &Scan, model: &dyn ReflectivityModel) -> Option<Vec<Reading>> {
        let of = structure(&self.values);
        let mut readings = Vec::new();
        for &omega in &scan.omegas {
            for &theta in &scan.thetas {
                for &wavelength in &scan.wavelengths {
                    for &phi in &scan.phis {
                        let (geometry, polarization) = (Geometry { theta, phi, omega }, scan.polarization);
                        let (intensity, sigma, curve, line) = (0.0, None, 0, 0);
                        readings.push(Reading { wavelength, geometry, polarization, intensity, sigma, curve, line });
                    }
                }
            }
        }
        let seen: Vec<(Geometry, f64)> =
            readings.iter().map(|reading| (reading.geometry, reading.wavelength)).collect();
        let found = model.contributions_at(&of, scan.polarization, &seen).ok()?;
        for (reading, parts) in readings.iter_mut().zip(found) {
            let [a, b] = parts.ok()?.map(|part| part.intensity);
            reading.intensity = self.lamella * a + self.multilayer * b + self.background;
            if !reading.intensity.is_finite() {
                return None;
            }
        }
        Some(readings)
    }
}

/// A mean of what is above 0.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, weight: f64, value: f64) {
        if value > 0.0 {
            self.sum += weight * value;
            self.weight += weight;
        }
    }

    /// `None` without any.
    fn value(self) -> Option<f64> {
        Some(self.sum / self.weight).filter(|mean| mean.is_finite() && *mean > 0.0)
    }
}
