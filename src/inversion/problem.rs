//! The join of optics, data and optimiser: weighted residuals over the free parameters.
//!
//! ```text
//! r_i = (model_i(p, c) - intensity_i) / sigma_i,   c = best non-negative nuisances at p
//! ```

use crate::inversion::compiled::Compiled;
use crate::inversion::nuisance::LinearPart;
use crate::inversion::parameter::{COUNT, Parameter, inside};
use crate::inversion::plan::{Plan, PlannedReading, Terms};
use crate::inversion::settings::Derivative;
use crate::inversion::space::Space;
use crate::optimise::{Bounds, LeastSquares, derivative};
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

/// What a run of the solver minimises. Made anew for each run: it remembers its last point.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    plan: &'a Plan<'a>,
    linear: &'a LinearPart,
    space: &'a Space,
    /// Square roots of the weights of a robust loss; empty for none.
    robust: &'a [f64],
    derivative: Derivative,
    last: RefCell<Option<Evaluation>>,
}

/// The model at one point.
#[derive(Debug, Clone)]
pub(crate) struct Evaluation {
    free: DVector<f64>,
    pub(crate) values: [f64; COUNT],
    pub(crate) terms: Terms,
    pub(crate) coefficients: DVector<f64>,
}

impl<'a> Problem<'a> {
    pub(crate) fn new(compiled: &'a Compiled<'_>, space: &'a Space, robust: &'a [f64]) -> Self {
        Self::of_parts(&compiled.plan, &compiled.linear, space, robust, compiled.settings.derivative)
    }

    /// The same of what a plan and its nuisances are kept in.
    pub(crate) fn of_parts(
        plan: &'a Plan<'a>,
        linear: &'a LinearPart,
        space: &'a Space,
        robust: &'a [f64],
        derivative: Derivative,
    ) -> Self {
        Self { plan, linear, space, robust, derivative, last: RefCell::new(None) }
    }

    /// Number of residuals.
    pub(crate) fn len(&self) -> usize {
        self.plan.len()
    }

    pub(crate) fn space(&self) -> &Space {
        self.space
    }

    fn weight(&self, row: usize) -> f64 {
        self.plan.readings[row].weight * self.robust.get(row).copied().unwrap_or(1.0)
    }

    /// The model at `free` with its best nuisances; `None` outside the models' domain.
    pub(crate) fn evaluate(&self, free: &DVector<f64>) -> Option<Evaluation> {
        let values = self.space.freedom.expand(free);
        if !inside(&values) {
            return None;
        }
        let terms = self.plan.terms(&values);
        let coefficients = self.linear.best(self.plan, terms.view(), self.robust);
        Some(Evaluation { free: free.clone(), values, terms, coefficients })
    }

    /// Length of the vector of weighted readings.
    pub(crate) fn size_of_data(&self) -> f64 {
        let square = |row: usize| (self.weight(row) * self.plan.readings[row].intensity).powi(2);
        (0..self.plan.len()).map(square).sum::<f64>().sqrt()
    }

    /// Factors on A and on B and the background of each curve.
    fn factors(&self, point: &Evaluation) -> Vec<(f64, f64, f64)> {
        (0..self.plan.curves).map(|curve| self.linear.factors(curve, &point.coefficients)).collect()
    }

    fn residuals_at(&self, point: &Evaluation) -> DVector<f64> {
        let (factors, terms) = (self.factors(point), point.terms.view());
        let residual = |(row, reading): (usize, &PlannedReading)| {
            let (a, b) = self.plan.parts(reading, terms);
            let (on_a, on_b, background) = factors[reading.curve];
            self.weight(row) * (on_a * a + on_b * b + background - reading.intensity)
        };
        DVector::from_iterator(self.plan.len(), self.plan.readings.iter().enumerate().map(residual))
    }

    /// Weighted derivatives by the free parameters at fixed nuisances, `[m, n]`: those of each term by each parameter it
    /// depends on, joined by the product rule.
    fn slopes(&self, point: &Evaluation) -> DMatrix<f64> {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = point.values;
        let plan = self.plan;
        let moves = |parameter| self.space.freedom.moves(parameter);
        let difference = |parameter: Parameter, at: f64, function: &dyn Fn(f64) -> Vec<f64>| {
            moves(parameter).then(|| {
                derivative(|x| DVector::from_vec(function(x)), at, parameter.typical_change(), parameter.domain())
            })
        };
        let exactly = self.derivative == Derivative::Exact;
        let period = (moves(Parameter::DAir) || moves(Parameter::DCuticle)).then(|| {
            let exact = exactly.then(|| plan.interference_slopes(d_air + d_cuticle)).flatten();
            exact.unwrap_or_else(|| {
                let along = |x| DVector::from_vec(plan.interference(x));
                derivative(along, d_air + d_cuticle, Parameter::DAir.typical_change(), (0.0, f64::INFINITY))
            })
        });
        let width = if exactly {
            moves(Parameter::LamellaWidth).then(|| plan.diffraction_slopes(lamella_width))
        } else {
            difference(Parameter::LamellaWidth, lamella_width, &|x| plan.diffraction(x))
        };
        let by_differences = || {
            [
                difference(Parameter::DAir, d_air, &|x| plan.stack(x, d_cuticle, delta)),
                difference(Parameter::DCuticle, d_cuticle, &|x| plan.stack(d_air, x, delta)),
                difference(Parameter::Delta, delta, &|x| plan.stack(d_air, d_cuticle, x)),
            ]
        };
        let exact = exactly.then(|| plan.stack_slopes(d_air, d_cuticle, delta)).flatten();
        let stack = exact.map_or_else(by_differences, |slopes| slopes.map(Some));
        let lobe = [
            difference(Parameter::Delta, delta, &|x| plan.lobe(x, phi_alpha, lamella_width)),
            difference(Parameter::PhiAlpha, phi_alpha, &|x| plan.lobe(delta, x, lamella_width)),
            plan.is_product()
                .then(|| difference(Parameter::LamellaWidth, lamella_width, &|x| plan.lobe(delta, phi_alpha, x)))
                .flatten(),
        ];

        let terms = &point.terms;
        let factors = self.factors(point);
        let mut all = DMatrix::zeros(plan.len(), COUNT);
        let mut columns = all.as_mut_slice().chunks_exact_mut(plan.len().max(1));
        let columns: [&mut [f64]; COUNT] = std::array::from_fn(|_| columns.next().unwrap_or_default());
        let at = |values: &[f64], index: usize| values.get(index).copied().unwrap_or(0.0);
        let (period, width) = (slice(&period), slice(&width));
        let (stack, lobe) = (stack.each_ref().map(slice), lobe.each_ref().map(slice));
        for (row, reading) in plan.readings.iter().enumerate() {
            let (on_a, on_b, _) = factors[reading.curve];
            let weight = self.weight(row);
            let mut along_thicknesses = [0.0; 2];
            if reading.share_a > 0.0 {
                let node = reading.lamella;
                let factor = weight * on_a * reading.share_a;
                along_thicknesses = [factor * at(period, node) * terms.diffraction[node]; 2];
                columns[4][row] = factor * terms.interference[node] * at(width, node);
            }
            if reading.share_b > 0.0 {
                let (node, direction) = (reading.stack, reading.lobe);
                let factor = weight * on_b * reading.share_b;
                let (r, l) = (terms.stack[node], terms.lobe[direction]);
                along_thicknesses[0] += factor * l * at(stack[0], node);
                along_thicknesses[1] += factor * l * at(stack[1], node);
                columns[2][row] = factor * (l * at(stack[2], node) + r * at(lobe[0], direction));
                columns[3][row] = factor * r * at(lobe[1], direction);
                if !lobe[2].is_empty() {
                    columns[4][row] = factor * r * at(lobe[2], direction);
                }
            }
            (columns[0][row], columns[1][row]) = along_thicknesses.into();
        }
        if self.space.freedom.is_all_free() { all } else { all * self.space.freedom.matrix() }
    }

    /// The linear columns in use at `point`, weighted, `[m, q]`.
    pub(crate) fn design(&self, point: &Evaluation) -> DMatrix<f64> {
        self.linear.design(self.plan, point.terms.view(), |row, _| self.weight(row), &point.coefficients)
    }

    /// Derivatives by free parameters and by the nuisances in use, `[m, n + q]`: the full problem's Jacobian.
    pub(crate) fn full_jacobian(&self, point: &Evaluation) -> DMatrix<f64> {
        let slopes = self.slopes(point);
        let design = self.design(point);
        let n = slopes.ncols();
        let mut full = slopes.resize_horizontally(n + design.ncols(), 0.0);
        full.columns_mut(n, design.ncols()).copy_from(&design);
        full
    }
}

impl LeastSquares for Problem<'_> {
    fn residuals(&self, free: &DVector<f64>) -> DVector<f64> {
        let Some(point) = self.evaluate(free) else {
            return DVector::from_element(self.plan.len(), f64::INFINITY);
        };
        let residuals = self.residuals_at(&point);
        self.last.replace(Some(point));
        residuals
    }

    fn bounds(&self) -> &Bounds {
        &self.space.bounds
    }

    fn scales(&self) -> &DVector<f64> {
        &self.space.scales
    }

    /// Kaufman's form: the slopes at fixed nuisances less their projection on the linear columns in use.
    fn jacobian(&self, free: &DVector<f64>) -> DMatrix<f64> {
        let known = self.last.borrow().as_ref().filter(|point| point.free == *free).cloned();
        let Some(point) = known.or_else(|| self.evaluate(free)) else {
            return DMatrix::from_element(self.plan.len(), free.len(), f64::NAN);
        };
        let slopes = self.slopes(&point);
        let design = self.design(&point);
        if design.ncols() == 0 {
            return slopes;
        }
        let q = design.qr().q();
        let along = q.tr_mul(&slopes);
        slopes - q * along
    }
}

/// The values, or none.
fn slice(values: &Option<DVector<f64>>) -> &[f64] {
    values.as_ref().map(|values| values.as_slice()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::nuisance::{Extent, Nuisances, Weight};
    use crate::inversion::settings::{FitSettings, ModelChoice};
    use crate::optics::{Stack, Structure};
    use crate::optimise::central_jacobian;
    use crate::synthetic::{Scan, simulate};

    /// The product rule over terms against differences of the whole, nuisances eliminated, at several points.
    #[test]
    fn slopes_by_terms_agree_with_differences_of_the_residuals() {
        let blend = (ModelChoice::Blend, Weight::Fixed(0.7));
        let hybrid = (ModelChoice::Hybrid { ridge_spacing: 750.0 }, Weight::Fitted);
        for (choice, known) in [blend, hybrid] {
            slopes_agree(choice, known);
        }
    }

    fn slopes_agree(choice: ModelChoice, known: Weight) {
        let (model, blue) = (choice.build(Stack::default()), Structure::blue());
        let model = model.as_ref();
        let data = simulate(model, &blue, &Scan::full_design(model, &blue).unwrap(), 2.0, 0.0, 1).unwrap();
        let space = Space::new(&FitSettings::default().roles).unwrap();
        for (scale, weight, background) in [
            (Extent::None, known, Extent::None),
            (Extent::Shared, Weight::Fitted, Extent::None),
            (Extent::PerCurve, Weight::Fitted, Extent::Shared),
        ] {
            let nuisances = Nuisances { scale, weight, background };
            let settings = FitSettings { model: choice, nuisances, ..FitSettings::default() };
            settings.validate().unwrap();
            let compiled = Compiled::new(&data, &settings, model).unwrap();
            let problem = Problem::new(&compiled, &space, &[]);
            for point in [[141.0, 62.0, 0.04, 0.5, 300.0], [120.0, 75.0, -0.02, 0.7, 250.0]] {
                let at = DVector::from_column_slice(&point);
                // Golub and Pereyra's full Jacobian differs from Kaufman's by a term along the residuals' normal; both have
                // the same gradient, and are equal where the residuals vanish, as at the truth without noise.
                let (ours, whole) = (
                    problem.jacobian(&at),
                    central_jacobian(|p| problem.residuals(p), &at, &space.scales, &space.bounds),
                );
                let residuals = problem.residuals(&at);
                let (gradient, expected) = (ours.tr_mul(&residuals), whole.tr_mul(&residuals));
                for j in 0..5 {
                    let size = ours.column(j).norm() * residuals.norm() + 1e-12;
                    assert!((gradient[j] - expected[j]).abs() < 1e-6 * size, "{scale:?} {j}: {gradient} {expected}");
                }
                if scale == Extent::None {
                    assert!((&ours - &whole).norm() < 1e-6 * whole.norm());
                }
            }
        }
    }
}
