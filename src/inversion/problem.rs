//! The join of optics, data and optimiser: weighted residuals over the free parameters.
//!
//! ```text
//! r_i = (model_i(p, c) - intensity_i) / sigma_i,   c = best non-negative nuisances at p
//! ```

use crate::inversion::compiled::Compiled;
use crate::inversion::nuisance::{LinearPart, NormalEquations, in_use};
use crate::inversion::parameter::{COUNT, Parameter, inside};
use crate::inversion::plan::{LamellaSlopes, Plan, Terms};
use crate::inversion::rows::{self, Block, Chunk, TermSlopes, Weighted, WeightedParts};
use crate::inversion::settings::Derivative;
use crate::inversion::space::Space;
use crate::numerics::dot::dot;
use crate::optimise::{Bounds, LeastSquares, Minimum, Products, derivative, without_columns};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
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
    /// The derivatives of a block of readings: memory.
    chunks: RefCell<Vec<Chunk>>,
}

/// The model at one point.
#[derive(Debug, Clone)]
pub(crate) struct Evaluation {
    free: DVector<f64>,
    pub(crate) values: [f64; COUNT],
    pub(crate) terms: Terms,
    /// What the solver asks for next, where exact derivatives are wanted.
    lamella_slopes: Option<LamellaSlopes>,
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
        let weighted = plan.rows.weighted(robust);
        Self { plan, linear, space, weighted, derivative, last: RefCell::new(None), chunks: RefCell::default() }
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
        self.evaluate_in(None, free, false)
    }

    /// The same in the memory of another evaluation, if `with_slopes` with those of Model A.
    fn evaluate_in(&self, old: Option<Evaluation>, free: &DVector<f64>, with_slopes: bool) -> Option<Evaluation> {
        let values = self.space.freedom.expand(free);
        if !inside(&values) {
            return None;
        }
        let (mut terms, mut parts, memory) =
            old.map_or_else(Default::default, |old| (old.terms, old.parts, old.lamella_slopes));
        let mut lamella_slopes = with_slopes.then(|| memory.unwrap_or_default());
        if !self.plan.renew(&values, &mut terms, lamella_slopes.as_mut()) {
            lamella_slopes = None;
        }
        self.plan.rows.renew(terms.view(), &self.weighted.weights, &mut parts);
        let equations = (!self.linear.columns.is_empty())
            .then(|| self.linear.normal_equations(&self.plan.rows, &parts, &self.weighted));
        let coefficients = equations.as_ref().map_or_else(|| DVector::zeros(0), NormalEquations::solve);
        Some(Evaluation { free: free.clone(), values, terms, lamella_slopes, parts, equations, coefficients })
    }

    /// Sum of squares at a minimum of this problem, whose own may be the cost of a robust loss.
    pub(crate) fn sum_of_squares(&self, minimum: &Minimum) -> f64 {
        // Borrowed weights are those of the data.
        match self.weighted.weights {
            Cow::Borrowed(_) => minimum.sum_of_squares,
            Cow::Owned(_) => self.residuals(&minimum.parameters).norm_squared(),
        }
    }

    /// Length of the vector of weighted readings.
    pub(crate) fn size_of_data(&self) -> f64 {
        dot(&self.weighted.intensities, &self.weighted.intensities).sqrt()
    }

    fn residuals_at(&self, point: &Evaluation) -> DVector<f64> {
        self.residuals_of(&point.parts, &self.weighted, &point.coefficients)
    }

    /// The residuals at `point` without the weights of a robust loss.
    pub(crate) fn plain_residuals(&self, point: &Evaluation) -> DVector<f64> {
        // Borrowed weights are those of the data.
        if let Cow::Borrowed(_) = self.weighted.weights {
            return self.residuals_at(point);
        }
        let plain = self.plan.rows.weighted(&[]);
        let parts = self.plan.rows.parts(point.terms.view(), &plain.weights);
        self.residuals_of(&parts, &plain, &point.coefficients)
    }

    fn residuals_of(
        &self,
        parts: &WeightedParts,
        weighted: &Weighted<'_>,
        coefficients: &DVector<f64>,
    ) -> DVector<f64> {
        let mut residuals = DVector::zeros(self.plan.len());
        for (curve, span) in self.plan.rows.spans() {
            let of = [&parts.lamella[..], &parts.multilayer[..]].map(|values| &values[span.clone()]);
            let data = [&weighted.weights[..], &weighted.intensities[..]].map(|values| &values[span.clone()]);
            let factors = self.linear.factors(*curve, coefficients);
            rows::residuals(&mut residuals.as_mut_slice()[span.clone()], factors, of, data);
        }
        residuals
    }

    /// Central differences of terms by a parameter; `None` if it does not move.
    fn difference(&self, of: Parameter, at: f64, terms: impl Fn(f64) -> Vec<f64>) -> Option<DVector<f64>> {
        let along = |x| DVector::from_vec(terms(x));
        self.space.freedom.moves(of).then(|| derivative(along, at, of.typical_change(), of.domain()))
    }

    /// Derivatives of Model A at `point`.
    fn lamella_slopes<'p>(&self, point: &'p Evaluation) -> Cow<'p, LamellaSlopes> {
        if let Some(known) = &point.lamella_slopes {
            return Cow::Borrowed(known);
        }
        let (plan, [d_air, d_cuticle, .., width]) = (self.plan, point.values);
        let period = d_air + d_cuticle;
        let exact = (self.derivative == Derivative::Exact).then(|| plan.lamella_slopes(period, width)).flatten();
        Cow::Owned(exact.unwrap_or_else(|| {
            // What does not move has no slope.
            let none = || DVector::zeros(point.terms.lamella.len());
            let moves = [Parameter::DAir, Parameter::DCuticle].map(|parameter| self.space.freedom.moves(parameter));
            let along = |x| DVector::from_vec(plan.lamella(x, width));
            let step = Parameter::DAir.typical_change();
            let by_period = moves.contains(&true).then(|| derivative(along, period, step, (0.0, f64::INFINITY)));
            let by_width = self.difference(Parameter::LamellaWidth, width, |x| plan.lamella(period, x));
            let list = |slopes: Option<DVector<f64>>| slopes.unwrap_or_else(none).data.into();
            LamellaSlopes { by_period: list(by_period), by_width: list(by_width) }
        }))
    }

    /// The derivatives of each term at `point` by each parameter it depends on.
    fn term_slopes<'p>(&self, point: &'p Evaluation) -> PointSlopes<'p> {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = point.values;
        let (plan, terms) = (self.plan, &point.terms);
        let exactly = self.derivative == Derivative::Exact;
        let stack = exactly.then(|| plan.stack_slopes(d_air, d_cuticle, delta)).flatten().map(|all| all.map(Some));
        let stack = stack.unwrap_or_else(|| {
            [
                self.difference(Parameter::DAir, d_air, |x| plan.stack(x, d_cuticle, delta)),
                self.difference(Parameter::DCuticle, d_cuticle, |x| plan.stack(d_air, x, delta)),
                self.difference(Parameter::Delta, delta, |x| plan.stack(d_air, d_cuticle, x)),
            ]
        });
        let lobe = exactly.then(|| plan.lobe_slopes(delta, phi_alpha)).flatten().map(|both| both.map(Some));
        let lobe = lobe.unwrap_or_else(|| {
            [
                self.difference(Parameter::Delta, delta, |x| plan.lobe(x, phi_alpha, lamella_width)),
                self.difference(Parameter::PhiAlpha, phi_alpha, |x| plan.lobe(delta, x, lamella_width)),
            ]
        });
        let lobe_by_width = plan
            .is_product()
            .then(|| self.difference(Parameter::LamellaWidth, lamella_width, |x| plan.lobe(delta, phi_alpha, x)))
            .flatten();
        // What does not move has no slope.
        let or_none = |slopes: Option<DVector<f64>>, like: &[f64]| slopes.unwrap_or_else(|| DVector::zeros(like.len()));
        PointSlopes {
            lamella: self.lamella_slopes(point),
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
        let mut chunks = self.chunks.take();
        for block in self.plan.rows.blocks() {
            self.slopes_of(block, point, &slopes, &mut chunks);
            chunks.iter().for_each(|chunk| chunk.write(&mut columns));
        }
        self.chunks.replace(chunks);
        if self.space.freedom.is_all_free() { all } else { all * self.space.freedom.matrix() }
    }

    fn slopes_of(&self, block: &Block, point: &Evaluation, slopes: &PointSlopes<'_>, out: &mut Vec<Chunk>) {
        let (on_a, on_b, _) = self.linear.factors(block.curve, &point.coefficients);
        let (terms, weights) = (point.terms.view(), &self.weighted.weights);
        self.plan.rows.slopes(block, terms, &slopes.view(), weights, (on_a, on_b), out);
    }

    /// The products of the Jacobian at `point`, summed up block by block; `None` where its columns are so nearly those of
    /// the nuisances that the difference of sums does not hold what is left of them.
    fn products_at(&self, point: &Evaluation, residuals: &DVector<f64>) -> Option<Products> {
        let slopes = self.term_slopes(point);
        let active = in_use(&point.coefficients);
        let mut gram = DMatrix::zeros(COUNT, COUNT);
        let mut gradient = DVector::zeros(COUNT);
        let mut along = DMatrix::zeros(active.len(), COUNT);
        let mut chunks = self.chunks.take();
        for block in self.plan.rows.blocks() {
            self.slopes_of(block, point, &slopes, &mut chunks);
            let found = rows::sums(&chunks, residuals.as_slice());
            for j in 0..COUNT {
                gradient[j] += found.gradient[j];
                for k in 0..=j {
                    gram[(j, k)] += found.gram[j][k];
                }
            }
            if active.is_empty() {
                continue;
            }
            for (of, factor, values) in self.linear.columns_of(block.curve, &point.parts, &self.weighted) {
                if let Ok(place) = active.binary_search(&of) {
                    for (j, product) in rows::along(&chunks, values).into_iter().enumerate() {
                        along[(place, j)] += factor * product;
                    }
                }
            }
        }
        self.chunks.replace(chunks);
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
        let with_slopes = self.derivative == Derivative::Exact && self.plan.has_lamella_slopes();
        let Some(point) = self.evaluate_in(self.last.take(), free, with_slopes) else {
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
struct PointSlopes<'p> {
    lamella: Cow<'p, LamellaSlopes>,
    stack: [DVector<f64>; 3],
    lobe: [DVector<f64>; 2],
    lobe_by_width: Option<DVector<f64>>,
}

impl PointSlopes<'_> {
    fn view(&self) -> TermSlopes<'_> {
        TermSlopes {
            lamella: [&self.lamella.by_period, &self.lamella.by_width],
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
