//! The linear nuisances of a fit, scale, weight of A against B, and background, eliminated at each point.
//!
//! ```text
//! intensity = scale · (weight · I_A cos² omega + I_B sin² omega) + background
//! ```
//!
//! For given structure it is linear in `scale · weight`, `scale` and `background`, all of which are at least 0: the fit
//! finds the best of them by linear least squares (variable projection) and searches the structure alone.
//!
//! # Source
//! Golub and Pereyra 1973, DOI 10.1137/0710036; derivatives in the form of Kaufman 1975, DOI 10.1007/BF01932995, whose
//! normal matrix is the exact Schur complement of the full problem's.

use crate::inversion::plan::Plan;
use crate::inversion::rows::{Rows, Weighted, WeightedParts};
use crate::numerics::dot::{dot, three_by_three};
use crate::numerics::nonnegative;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use serde::{Deserialize, Serialize};

/// Whether a linear nuisance is fitted, and how many of it there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extent {
    /// Not fitted.
    None,
    /// One for all curves.
    Shared,
    /// One for each curve.
    PerCurve,
}

/// Strength of Model A beside Model B.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weight {
    /// Fitted where both planes are in the data (for each curve, if the scale is), else 1. A model that is one product has
    /// none.
    Fitted,
    /// Known.
    Fixed(f64),
}

/// Which linear nuisances are fitted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Nuisances {
    /// Factor on the whole intensity; 1 where it is not fitted.
    pub scale: Extent,
    /// Strength of Model A beside Model B.
    pub weight: Weight,
    /// What is read where nothing is reflected; 0 where it is not fitted.
    pub background: Extent,
}

impl Default for Nuisances {
    fn default() -> Self {
        Self { scale: Extent::Shared, weight: Weight::Fitted, background: Extent::None }
    }
}

/// What the coefficient of a linear column multiplies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Multiplies {
    /// Model A alone: the coefficient is scale · weight.
    Lamella,
    /// Model B alone: the coefficient is the scale.
    Multilayer,
    /// Both: the coefficient is the scale.
    Both,
    /// 1: the coefficient is the background.
    One,
}

/// One linear column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) multiplies: Multiplies,
    /// The curve it belongs to; `None` if all share it.
    pub(crate) curve: Option<usize>,
}

/// Where a part of a reading goes: to a linear column or to the known part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    Known,
    Column(usize),
}

/// The linear part of a fit, compiled for a plan.
#[derive(Debug, Clone)]
pub(crate) struct LinearPart {
    pub(crate) columns: Vec<Column>,
    /// Target of A, of B and of the background, for each curve.
    targets: Vec<(Target, Target, Option<usize>)>,
    /// Known factor on A.
    weight: f64,
}

/// Sums over readings from which the best coefficients follow.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
}

impl LinearPart {
    pub(crate) fn new(nuisances: &Nuisances, plan: &Plan<'_>) -> Self {
        let both = plan.has_lamella() && plan.has_multilayer();
        let (weight, weight_is_fitted) = match nuisances.weight {
            Weight::Fixed(weight) => (weight, false),
            Weight::Fitted => (1.0, both),
        };
        let mut seen = vec![(false, false); plan.curves];
        for reading in plan.readings() {
            seen[reading.curve].0 |= reading.share_a > 0.0;
            seen[reading.curve].1 |= reading.share_b > 0.0;
        }
        let mut columns: Vec<Column> = Vec::new();
        let mut column = |multiplies, curve| {
            let wanted = Column { multiplies, curve };
            columns.iter().position(|known| *known == wanted).unwrap_or_else(|| {
                columns.push(wanted);
                columns.len() - 1
            })
        };
        let targets = seen
            .iter()
            .enumerate()
            .map(|(curve, &(sees_a, sees_b))| {
                let of = |extent| if extent == Extent::PerCurve { Some(curve) } else { None };
                let owner = of(nuisances.scale);
                let scaled = nuisances.scale != Extent::None;
                let mut a = Target::Known;
                let mut b = Target::Known;
                if weight_is_fitted {
                    if sees_a {
                        a = Target::Column(column(Multiplies::Lamella, owner));
                    }
                    if sees_b && scaled {
                        b = Target::Column(column(Multiplies::Multilayer, owner));
                    }
                } else if scaled && (sees_a || sees_b) {
                    a = Target::Column(column(Multiplies::Both, owner));
                    b = a;
                }
                let background = nuisances.background != Extent::None;
                let background = background.then(|| column(Multiplies::One, of(nuisances.background)));
                (a, b, background)
            })
            .collect();
        Self { columns, targets, weight }
    }

    /// Whether a background is fitted.
    pub(crate) fn has_background(&self) -> bool {
        self.targets.iter().any(|target| target.2.is_some())
    }

    /// For each curve the first one that has the same columns.
    pub(crate) fn alike(&self) -> Vec<usize> {
        let first = |own: &(Target, Target, Option<usize>)| self.targets.iter().position(|other| other == own);
        self.targets.iter().enumerate().map(|(curve, own)| first(own).unwrap_or(curve)).collect()
    }

    /// The known part of a reading, and its value in up to three columns.
    #[inline]
    fn split(&self, curve: usize, (a, b): (f64, f64)) -> (f64, [(usize, f64); 3], usize) {
        let (target_a, target_b, background) = self.targets[curve];
        let a = self.weight * a;
        let mut known = 0.0;
        let mut entries = [(0, 0.0); 3];
        let mut count = 0;
        match (target_a, target_b) {
            (Target::Column(i), Target::Column(j)) if i == j => {
                entries[0] = (i, a + b);
                count = 1;
            }
            _ => {
                for (target, value) in [(target_a, a), (target_b, b)] {
                    match target {
                        Target::Known => known += value,
                        Target::Column(i) => {
                            entries[count] = (i, value);
                            count += 1;
                        }
                    }
                }
            }
        }
        if let Some(i) = background {
            entries[count] = (i, 1.0);
            count += 1;
        }
        (known, entries, count)
    }

    /// Sums over all readings.
    pub(crate) fn normal_equations(
        &self,
        rows: &Rows,
        parts: &WeightedParts,
        weighted: &Weighted<'_>,
    ) -> NormalEquations {
        let mut equations = self.no_equations();
        for (curve, span) in rows.spans() {
            let models = [&parts.lamella[..], &parts.multilayer[..], &weighted.intensities[..]];
            let background = self.targets[*curve].2.map(|_| &weighted.weights[span.clone()]);
            self.add(&mut equations, *curve, &Sums::new(models.map(|values| &values[span.clone()]), background));
        }
        equations.complete();
        equations
    }

    /// Normal equations of no readings.
    pub(crate) fn no_equations(&self) -> NormalEquations {
        let q = self.columns.len();
        NormalEquations { gram: DMatrix::zeros(q, q), right: DVector::zeros(q), square: 0.0 }
    }

    /// Adds to the lower triangle what the readings of one curve have summed up to.
    pub(crate) fn add(&self, equations: &mut NormalEquations, curve: usize, sums: &Sums) {
        let product = |part: usize, other: usize| sums.products[part.max(other)][part.min(other)];
        let (a, b, background) = self.targets[curve];
        let targets = [a, b, background.map_or(Target::Known, Target::Column)];
        // A reading is A, B and 1 times these; what is known is taken from the intensity.
        let factors = [self.weight, 1.0, 1.0];
        let known = |part: usize| if targets[part] == Target::Known && part < 2 { factors[part] } else { 0.0 };
        let left = |part: usize| {
            sums.with_intensity[part] - (0..2).map(|other| known(other) * product(part, other)).sum::<f64>()
        };
        equations.square += sums.square;
        for part in 0..2 {
            equations.square -= known(part) * (sums.with_intensity[part] + left(part));
        }
        for (part, target) in targets.iter().enumerate() {
            let Target::Column(i) = *target else { continue };
            equations.right[i] += factors[part] * left(part);
            for (other, target) in targets.iter().enumerate() {
                if let Target::Column(j) = *target
                    && j <= i
                {
                    equations.gram[(i, j)] += factors[part] * factors[other] * product(part, other);
                }
            }
        }
    }

    /// The model's value of a reading for `coefficients`.
    #[inline]
    pub(crate) fn value(&self, curve: usize, parts: (f64, f64), coefficients: &DVector<f64>) -> f64 {
        let (known, entries, count) = self.split(curve, parts);
        known + entries[..count].iter().map(|&(i, value)| coefficients[i] * value).sum::<f64>()
    }

    /// Factors on A and on B of a reading's curve, and its background.
    #[inline]
    pub(crate) fn factors(&self, curve: usize, coefficients: &DVector<f64>) -> (f64, f64, f64) {
        let (a, b, background) = self.targets[curve];
        let of = |target| match target {
            Target::Known => 1.0,
            Target::Column(i) => coefficients[i],
        };
        (self.weight * of(a), of(b), background.map_or(0.0, |i| coefficients[i]))
    }

    /// Factors on A and on B wherever a reading of a curve may lie, and its background: those of [`LinearPart::factors`] hold where the
    /// curve was measured. `None` for a part of which nothing that was measured tells the factor.
    pub(crate) fn factors_anywhere(
        &self,
        nuisances: &Nuisances,
        plan: &Plan<'_>,
        curve: usize,
        coefficients: &DVector<f64>,
    ) -> (Option<f64>, Option<f64>, f64) {
        let owner = (nuisances.scale == Extent::PerCurve).then_some(curve);
        let fitted = |multiplies| {
            let place = self.columns.iter().position(|column| *column == Column { multiplies, curve: owner });
            place.map(|place| coefficients[place])
        };
        let scaled = |multiplies| if nuisances.scale == Extent::None { Some(1.0) } else { fitted(multiplies) };
        let (a, b) = match nuisances.weight {
            Weight::Fixed(weight) => (scaled(Multiplies::Both).map(|scale| weight * scale), scaled(Multiplies::Both)),
            Weight::Fitted if plan.has_lamella() && plan.has_multilayer() => {
                (fitted(Multiplies::Lamella), scaled(Multiplies::Multilayer))
            }
            // One plane alone tells no weight.
            Weight::Fitted => {
                let scale = scaled(Multiplies::Both);
                (scale.filter(|_| plan.has_lamella()), scale.filter(|_| plan.has_multilayer()))
            }
        };
        (a, b, self.factors(curve, coefficients).2)
    }

    /// Columns whose coefficient is above 0, weighted, `[m, q]`: the part of the model that a projection removes.
    pub(crate) fn design(
        &self,
        rows: &Rows,
        parts: &WeightedParts,
        weighted: &Weighted<'_>,
        coefficients: &DVector<f64>,
    ) -> DMatrix<f64> {
        let active = in_use(coefficients);
        let mut design = DMatrix::zeros(weighted.weights.len(), active.len());
        for (curve, span) in rows.spans() {
            for (column, factor, values) in self.columns_of(*curve, parts, weighted) {
                let Ok(place) = active.binary_search(&column) else { continue };
                let mut column = design.view_mut((span.start, place), (span.len(), 1));
                for (out, value) in column.iter_mut().zip(&values[span.clone()]) {
                    *out += factor * value;
                }
            }
        }
        design
    }

    /// What the readings of a curve add to linear columns: which column, the factor, and the values at all readings.
    pub(crate) fn columns_of<'v>(
        &self,
        curve: usize,
        parts: &'v WeightedParts,
        weighted: &'v Weighted<'_>,
    ) -> impl Iterator<Item = (usize, f64, &'v [f64])> {
        let (a, b, background) = self.targets[curve];
        let parts = [
            (a, self.weight, &parts.lamella[..]),
            (b, 1.0, &parts.multilayer[..]),
            (background.map_or(Target::Known, Target::Column), 1.0, &weighted.weights[..]),
        ];
        parts.into_iter().filter_map(|(target, factor, values)| match target {
            Target::Column(column) => Some((column, factor, values)),
            Target::Known => None,
        })
    }
}

/// Columns whose coefficient is above 0.
pub(crate) fn in_use(coefficients: &DVector<f64>) -> Vec<usize> {
    (0..coefficients.len()).filter(|&i| coefficients[i] > 0.0).collect()
}

/// Weighted sums over readings of the products of A, B, 1 and the intensity.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sums {
    /// Of A, B and 1 with those before them and themselves: the lower triangle.
    pub(crate) products: [[f64; 3]; 3],
    pub(crate) with_intensity: [f64; 3],
    pub(crate) square: f64,
}

impl Sums {
    /// Of A, B and the intensities, and of 1 where there is a background; all times the weights.
    fn new(columns: [&[f64]; 3], one: Option<&[f64]>) -> Self {
        let [a, b, y] = three_by_three(columns, columns);
        let mut sums = Self { products: [[a[0], 0.0, 0.0], [b[0], b[1], 0.0], [0.0; 3]], ..Self::default() };
        (sums.with_intensity, sums.square) = ([y[0], y[1], 0.0], y[2]);
        if let Some(one) = one {
            sums.products[2] = [dot(one, columns[0]), dot(one, columns[1]), dot(one, one)];
            sums.with_intensity[2] = dot(one, columns[2]);
        }
        sums
    }
}

impl NormalEquations {
    /// The best non-negative coefficients.
    pub(crate) fn solve(&self) -> DVector<f64> {
        nonnegative::solve(&self.gram, &self.right)
    }

    /// Makes both triangles equal, after the last sums were added.
    pub(crate) fn complete(&mut self) {
        self.gram.fill_upper_triangle_with_lower_triangle();
    }

    /// Back to no readings.
    pub(crate) fn clear(&mut self) {
        self.gram.fill(0.0);
        self.right.fill(0.0);
        self.square = 0.0;
    }

    /// The sum of squares at the best non-negative coefficients, from the lower triangle.
    pub(crate) fn best_sum_of_squares(&mut self) -> f64 {
        let best = match self.right.len() {
            0 => self.square,
            1 => {
                // One coefficient: the projection, if it is above 0.
                let (gram, right) = (self.gram[(0, 0)], self.right[0]);
                if gram > 0.0 && right > 0.0 {
                    self.square - right * right / gram
                } else {
                    // Nothing is taken away, and where the model has no value there is no sum: 0 · NaN is NaN.
                    self.square + 0.0 * (gram + right)
                }
            }
            2 => {
                let (gram, right) = (&self.gram, [self.right[0], self.right[1]]);
                let elements = [gram[(0, 0)], gram[(1, 0)], gram[(1, 1)]];
                let [c, d] = nonnegative::pair(elements, right);
                let [first, across, second] = elements;
                self.square + c * (c * first + 2.0 * (d * across - right[0])) + d * (d * second - 2.0 * right[1])
            }
            _ => {
                self.complete();
                return self.sum_of_squares(&self.solve());
            }
        };
        if best.is_finite() { best.max(0.0) } else { f64::INFINITY }
    }

    /// The normal matrix of some columns.
    pub(crate) fn gram_of(&self, columns: &[usize]) -> DMatrix<f64> {
        self.gram.select_rows(columns).select_columns(columns)
    }

    /// Factors of the normal matrix; `None` if its columns depend on each other, or one is 0 or not finite.
    pub(crate) fn factors(&self) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(self.gram.clone())
    }

    /// The best coefficients of either sign.
    pub(crate) fn unconstrained(&self, factors: &Cholesky<f64, Dyn>) -> DVector<f64> {
        factors.solve(&self.right)
    }

    /// Weighted sum of squares at `coefficients`, to rounding of the data's own sum of squares; infinite if not finite.
    pub(crate) fn sum_of_squares(&self, coefficients: &DVector<f64>) -> f64 {
        let sum = self.square - 2.0 * self.right.dot(coefficients) + (&self.gram * coefficients).dot(coefficients);
        if sum.is_finite() { sum.max(0.0) } else { f64::INFINITY }
    }
}
