//! The join of optics, data and optimiser: weighted residuals over the free parameters.
//!
//! ```text
//! r_i = (model_i(p, c) - intensity_i) / sigma_i,   c = best non-negative nuisances at p
//! ```

use crate::inversion::compiled::Compiled;
use crate::inversion::nuisance::{LinearPart, NormalEquations, in_use};
use crate::inversion::parameter::{COUNT, Parameter, inside};
use crate::inversion::plan::{Plan, Terms};
use crate::inversion::rows::{self, Block, TermSlopes, Weighted, WeightedParts};
use crate::inversion::settings::Derivative;
use crate::inversion::space::Space;
use crate::numerics::dot::{dot, three_by_three};
use crate::optimise::{Bounds, LeastSquares, Products, derivative, without_columns};
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

/// What a run of the solver minimises. Made anew for each run: it remembers its last point.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    plan: &'a Plan<'a>,
    linear: &'a LinearPart,
    space: &'a Space,
    weighted: Weighted<'a>,
    derivative: Derivative,
    last: RefCell<Option<Evaluation>>,
}

/// The model at one point.
#[derive(Debug, Clone)]
pub(crate) struct Evaluation {
    free: DVector<f64>,
    pub(crate) values: [f64; COUNT],
    pub(crate) terms: Terms,
    parts: WeightedParts,
    /// Of the nuisances; `None` without any.
    equations: Option<NormalEquations>,
    pub(crate) coefficients: DVector<f64>,
}

impl<'a> Problem<'a> {
    /// - `robust`: square roots of the weights of a robust loss; empty for none.
    pub(crate) fn new(compiled: &'a Compiled<'_>, space: &'a Space, robust: &[f64]) -> Self {
        Self::of_parts(&compiled.plan, &compiled.linear, space, robust, compiled.settings.derivative)
    }

    /// The same of what a plan and its nuisances are kept in.
    pub(crate) fn of_parts(
        plan: &'a Plan<'a>,
        linear: &'a LinearPart,
        space: &'a Space,
        robust: &[f64],
        derivative: Derivative,
    ) -> Self {
        Self { plan, linear, space, weighted: plan.rows.weighted(robust), derivative, last: RefCell::new(None) }
    }

    /// Number of residuals.
    #[cfg(feature = "tradeoff")]
    pub(crate) fn len(&self) -> usize {
        self.plan.len()
    }

    pub(crate) fn space(&self) -> &Space {
        self.space
    }

    /// The model at `free` with its best nuisances; `None` outside the models' domain.
    pub(crate) fn evaluate(&self, free: &DVector<f64>) -> Option<Evaluation> {
        let values = self.space.freedom.expand(free);
        if !inside(&values) {
            return None;
        }
        let terms = self.plan.terms(&values);
        let parts = self.plan.rows.parts(terms.view(), &self.weighted.weights);
        let equations = (!self.linear.columns.is_empty())
            .then(|| self.linear.normal_equations(&self.plan.rows, &parts, &self.weighted));
        let coefficients = equations.as_ref().map_or_else(|| DVector::zeros(0), NormalEquations::solve);
        Some(Evaluation { free: free.clone(), values, terms, parts, equations, coefficients })
    }

    /// Length of the vector of weighted readings.
    pub(crate) fn size_of_data(&self) -> f64 {
        dot(&self.weighted.intensities, &self.weighted.intensities).sqrt()
    }

    fn residuals_at(&self, point: &Evaluation) -> DVector<f64> {
        let mut residuals = DVector::zeros(self.plan.len());
        for (curve, span) in self.plan.rows.spans() {
            let of = [&point.parts.lamella[..], &point.parts.multilayer[..]].map(|values| &values[span.clone()]);
            let data = [&self.weighted.weights[..], &self.weighted.intensities[..]].map(|values| &values[span.clone()]);
            let factors = self.linear.factors(*curve, &point.coefficients);
            rows::residuals(&mut residuals.as_mut_slice()[span.clone()], factors, of, data);
        }
        residuals
    }

    /// The derivatives of each term at `point` by each parameter it depends on.
    fn term_slopes(&self, point: &Evaluation) -> PointSlopes {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = point.values;
        let (plan, terms) = (self.plan, &point.terms);
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
        let stack = exactly.then(|| plan.stack_slopes(d_air, d_cuticle, delta)).flatten().map(|all| all.map(Some));
        let stack = stack.unwrap_or_else(|| {
            [
                difference(Parameter::DAir, d_air, &|x| plan.stack(x, d_cuticle, delta)),
                difference(Parameter::DCuticle, d_cuticle, &|x| plan.stack(d_air, x, delta)),
                difference(Parameter::Delta, delta, &|x| plan.stack(d_air, d_cuticle, x)),
            ]
        });
        let lobe = exactly.then(|| plan.lobe_slopes(delta, phi_alpha)).flatten().map(|both| both.map(Some));
        let lobe = lobe.unwrap_or_else(|| {
            [
                difference(Parameter::Delta, delta, &|x| plan.lobe(x, phi_alpha, lamella_width)),
                difference(Parameter::PhiAlpha, phi_alpha, &|x| plan.lobe(delta, x, lamella_width)),
            ]
        });
        let lobe_by_width = plan
            .is_product()
            .then(|| difference(Parameter::LamellaWidth, lamella_width, &|x| plan.lobe(delta, phi_alpha, x)))
            .flatten();
        // What does not move has no slope.
        let or_none = |slopes: Option<DVector<f64>>, like: &[f64]| slopes.unwrap_or_else(|| DVector::zeros(like.len()));
        PointSlopes {
            lamella: [or_none(period, &terms.interference), or_none(width, &terms.diffraction)],
            stack: stack.map(|slopes| or_none(slopes, &terms.stack)),
            lobe: lobe.map(|slopes| or_none(slopes, &terms.lobe)),
            lobe_by_width,
        }
    }

    /// Weighted derivatives by the free parameters at fixed nuisances, `[m, n]`: those of the terms, joined by the product
    /// rule.
    fn slopes(&self, point: &Evaluation) -> DMatrix<f64> {
        let slopes = self.term_slopes(point);
        let mut all = DMatrix::zeros(self.plan.len(), COUNT);
        let mut columns = all.as_mut_slice().chunks_exact_mut(self.plan.len().max(1));
        let mut columns: [&mut [f64]; COUNT] = std::array::from_fn(|_| columns.next().unwrap_or_default());
        for block in self.plan.rows.blocks() {
            let own = columns.each_mut().map(|column| &mut column[block.rows.clone()]);
            self.slopes_of(block, point, &slopes, own);
        }
        if self.space.freedom.is_all_free() { all } else { all * self.space.freedom.matrix() }
    }

    fn slopes_of(&self, block: &Block, point: &Evaluation, slopes: &PointSlopes, columns: [&mut [f64]; COUNT]) {
        let (on_a, on_b, _) = self.linear.factors(block.curve, &point.coefficients);
        let (terms, weights) = (point.terms.view(), &self.weighted.weights);
        self.plan.rows.slopes(block, terms, &slopes.view(), weights, (on_a, on_b), columns);
    }

    /// The products of the Jacobian at `point`, summed up block by block; `None` where its columns are so nearly those of
    /// the nuisances that the difference of sums does not hold what is left of them.
    fn products_at(&self, point: &Evaluation, residuals: &DVector<f64>) -> Option<Products> {
        let slopes = self.term_slopes(point);
        let active = in_use(&point.coefficients);
        let mut gram = DMatrix::zeros(COUNT, COUNT);
        let mut gradient = DVector::zeros(COUNT);
        let mut along = DMatrix::zeros(active.len(), COUNT);
        let longest = self.plan.rows.blocks().iter().map(|block| block.rows.len()).max().unwrap_or(0);
        let mut memory: [Vec<f64>; COUNT] = std::array::from_fn(|_| vec![0.0; longest]);
        for block in self.plan.rows.blocks() {
            self.slopes_of(block, point, &slopes, memory.each_mut().map(|column| &mut column[..block.rows.len()]));
            let columns = memory.each_ref().map(|column| &column[..block.rows.len()]);
            let [air, cuticle, tilt, half_width, width] = columns;
            let own_residuals = &residuals.as_slice()[block.rows.clone()];
            let (thicknesses, rest) = ([air, cuticle, tilt], [half_width, width, own_residuals]);
            let (upper, corner) = (three_by_three(thicknesses, thicknesses), three_by_three(rest, thicknesses));
            let lower = three_by_three(rest, rest);
            for j in 0..3 {
                for k in 0..3 {
                    gram[(j, k)] += upper[j][k];
                }
                gram[(3, j)] += corner[0][j];
                gram[(4, j)] += corner[1][j];
                gradient[j] += corner[2][j];
            }
            gradient[3] += lower[2][0];
            gradient[4] += lower[2][1];
            for (i, j) in [(0, 0), (1, 0), (1, 1)] {
                gram[(3 + i, 3 + j)] += lower[i][j];
            }
            if active.is_empty() {
                continue;
            }
            for (of, factor, values) in self.linear.columns_of(block.curve, &point.parts, &self.weighted) {
                if let Ok(place) = active.binary_search(&of) {
                    for (j, column) in columns.iter().enumerate() {
                        along[(place, j)] += factor * dot(column, &values[block.rows.clone()]);
                    }
                }
            }
        }
        let freedom = &self.space.freedom;
        gram.fill_upper_triangle_with_lower_triangle();
        if !freedom.is_all_free() {
            let matrix = freedom.matrix();
            gram = matrix.tr_mul(&(gram * matrix));
            gradient = matrix.tr_mul(&gradient);
            along *= matrix;
        }
        let products = Products::of_sums(gram, gradient);
        match point.equations.as_ref().filter(|_| !active.is_empty()) {
            // Kaufman's form: the residuals have no part along the nuisances in use, the slopes lose theirs.
            Some(equations) => products.without(equations.gram_of(&active), &along),
            None => Some(products),
        }
    }

    /// The linear columns in use at `point`, weighted, `[m, q]`.
    pub(crate) fn design(&self, point: &Evaluation) -> DMatrix<f64> {
        self.linear.design(&self.plan.rows, &point.parts, &self.weighted, &point.coefficients)
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

    fn products(&self, free: &DVector<f64>, residuals: &DVector<f64>) -> Products {
        let known = self.last.take().filter(|point| point.free == *free);
        let point = known.or_else(|| self.evaluate(free));
        let products = point.as_ref().and_then(|point| self.products_at(point, residuals));
        self.last.replace(point);
        products.unwrap_or_else(|| Products::new(&self.jacobian(free), residuals))
    }

    /// Kaufman's form: the slopes at fixed nuisances less their projection on the linear columns in use.
    fn jacobian(&self, free: &DVector<f64>) -> DMatrix<f64> {
        let known = self.last.take().filter(|point| point.free == *free);
        let Some(point) = known.or_else(|| self.evaluate(free)) else {
            return DMatrix::from_element(self.plan.len(), free.len(), f64::NAN);
        };
        let slopes = self.slopes(&point);
        let design = self.design(&point);
        self.last.replace(Some(point));
        if design.ncols() == 0 { slopes } else { without_columns(slopes, &design) }
    }
}

/// Derivatives of the terms at one point; see [`TermSlopes`].
struct PointSlopes {
    lamella: [DVector<f64>; 2],
    stack: [DVector<f64>; 3],
    lobe: [DVector<f64>; 2],
    lobe_by_width: Option<DVector<f64>>,
}

impl PointSlopes {
    fn view(&self) -> TermSlopes<'_> {
        TermSlopes {
            lamella: self.lamella.each_ref().map(DVector::as_slice),
            stack: self.stack.each_ref().map(DVector::as_slice),
            lobe: self.lobe.each_ref().map(DVector::as_slice),
            lobe_by_width: self.lobe_by_width.as_ref().map(DVector::as_slice),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::nuisance::{Extent, Nuisances, Weight};
    use crate::inversion::settings::{FitSettings, ModelChoice};
    use crate::optics::{Stack, Structure};
    use crate::optimise::central_jacobian;
    use crate::synthetic::{Scan, simulate};
    use approx::{assert_abs_diff_eq, assert_relative_eq};

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
                // The products that are summed up block by block are those of the Jacobian.
                let (residuals, ours) = (problem.residuals(&at), problem.jacobian(&at));
                let (direct, summed) = (Products::new(&ours, &residuals), problem.products(&at, &residuals));
                let triangle = |products: &Products| products.triangle(&[0, 1, 2, 3, 4]).unwrap().0;
                assert_relative_eq!(triangle(&direct), triangle(&summed), max_relative = 1e-7, epsilon = 1e-7);
                for j in 0..5 {
                    assert_relative_eq!(direct.length(j), summed.length(j), max_relative = 1e-9);
                    let size = direct.length(j) * residuals.norm() + 1e-12;
                    assert_abs_diff_eq!(direct.gradient()[j], summed.gradient()[j], epsilon = 1e-9 * size);
                }
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
