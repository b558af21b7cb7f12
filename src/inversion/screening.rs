//! Sums over the readings for many structures at once: what structures share is summed once.
//!
//! Model A's sums depend on the width of the lamellae, Model B's on tilt and lobe, and only readings in a plane between
//! the two see their product. On a grid of 5 × 3 × 4 of these, 15 + 4 sums stand for 60.

use crate::inversion::nuisance::Sums;
use crate::inversion::plan::Plan;
use crate::inversion::rows::{Rows, Weighted};
use crate::numerics::dot::dot;
use std::ops::Range;

/// What the readings say of one model.
#[derive(Debug)]
pub(crate) struct OfPart {
    /// For each curve: the sum of its squares, of its products with the intensity, and of itself.
    sums: Vec<[f64; 3]>,
    /// Its values over sigma.
    values: Vec<f64>,
}

/// The readings of a plan by curve; curves with the same nuisances count as one.
#[derive(Debug)]
pub(crate) struct Screening<'a> {
    rows: &'a Rows,
    weighted: Weighted<'a>,
    /// Sums that no structure changes, for each curve.
    constant: Vec<Sums>,
    /// The curves that have readings.
    curves: Vec<usize>,
    /// Neighbours of one curve that see both models.
    crossed: Vec<(usize, Range<usize>)>,
}

impl<'a> Screening<'a> {
    pub(crate) fn new(plan: &'a Plan<'_>) -> Self {
        let (rows, weighted) = (&plan.rows, plan.rows.weighted(&[]));
        let mut constant = vec![Sums::default(); plan.curves];
        let mut curves = Vec::new();
        for (curve, span) in rows.spans() {
            let (weights, intensities) = (&weighted.weights[span.clone()], &weighted.intensities[span.clone()]);
            constant[*curve].products[2][2] += dot(weights, weights);
            constant[*curve].with_intensity[2] += dot(weights, intensities);
            constant[*curve].square += dot(intensities, intensities);
            curves.push(*curve);
        }
        curves.sort_unstable();
        curves.dedup();
        Self { rows, weighted, constant, curves, crossed: rows.crossed() }
    }

    /// Sums of Model A, of its values at the nodes.
    pub(crate) fn lamella(&self, nodes: &[f64]) -> OfPart {
        self.of_part(self.rows.lamella(nodes, &self.weighted.weights))
    }

    /// Sums of Model B, of the values of stack and lobe at the nodes.
    pub(crate) fn multilayer(&self, nodes: [&[f64]; 2]) -> OfPart {
        self.of_part(self.rows.multilayer(nodes, &self.weighted.weights))
    }

    fn of_part(&self, values: Vec<f64>) -> OfPart {
        let mut sums = vec![[0.0; 3]; self.constant.len()];
        for (curve, span) in self.rows.spans() {
            let own = &values[span.clone()];
            let with = |others: &[f64]| dot(own, &others[span.clone()]);
            let found = [dot(own, own), with(&self.weighted.intensities), with(&self.weighted.weights)];
            for (sum, found) in sums[*curve].iter_mut().zip(found) {
                *sum += found;
            }
        }
        OfPart { sums, values }
    }

    /// Hands the sums of each curve to `add`; `products` is memory for them.
    pub(crate) fn join(
        &self,
        lamella: &OfPart,
        multilayer: &OfPart,
        products: &mut Vec<f64>,
        mut add: impl FnMut(usize, &Sums),
    ) {
        products.clear();
        products.resize(self.constant.len(), 0.0);
        for (curve, span) in &self.crossed {
            products[*curve] += dot(&lamella.values[span.clone()], &multilayer.values[span.clone()]);
        }
        for &curve in &self.curves {
            let mut sums = self.constant[curve];
            [sums.products[0][0], sums.with_intensity[0], sums.products[2][0]] = lamella.sums[curve];
            [sums.products[1][1], sums.with_intensity[1], sums.products[2][1]] = multilayer.sums[curve];
            sums.products[1][0] = products[curve];
            add(curve, &sums);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::compiled::Compiled;
    use crate::inversion::nuisance::{Extent, Nuisances, Weight};
    use crate::inversion::settings::FitSettings;
    use crate::optics::{BlendModel, Structure};
    use crate::synthetic::{Scan, simulate};
    use approx::assert_relative_eq;

    #[test]
    fn joined_sums_are_those_over_all_readings() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let mut scans = Scan::full_design(&model, &blue).unwrap();
        scans.push(Scan::angular(480.0, 30.0)); // sees both models
        let data = simulate(&model, &blue, &scans, 2.0, 0.01, 1).unwrap();
        for (scale, weight, background) in [
            (Extent::None, Weight::Fixed(0.7), Extent::None),
            (Extent::Shared, Weight::Fixed(0.7), Extent::None),
            (Extent::Shared, Weight::Fixed(0.7), Extent::Shared),
            (Extent::Shared, Weight::Fitted, Extent::None),
            (Extent::Shared, Weight::Fitted, Extent::Shared),
            (Extent::PerCurve, Weight::Fitted, Extent::PerCurve),
        ] {
            let settings = FitSettings { nuisances: Nuisances { scale, weight, background }, ..FitSettings::default() };
            let Compiled { plan, linear, .. } = Compiled::new(&data, &settings, &model).unwrap();
            let terms = plan.terms(&[120.0, 75.0, -0.02, 0.7, 250.0]);
            let screening = Screening::new(&plan);
            let lamella = screening.lamella(&terms.lamella);
            let multilayer = screening.multilayer([&terms.stack, &terms.lobe]);
            let mut equations = linear.no_equations();
            let add = |curve, sums: &Sums| linear.add(&mut equations, curve, sums);
            screening.join(&lamella, &multilayer, &mut Vec::new(), add);
            let weighted = plan.rows.weighted(&[]);
            let parts = plan.rows.parts(terms.view(), &weighted.weights);
            let whole = linear.normal_equations(&plan.rows, &parts, &weighted);
            let expected = whole.sum_of_squares(&whole.solve());
            assert_relative_eq!(equations.best_sum_of_squares(), expected, max_relative = 1e-10);

            // Where the model has no value there is no sum, however many coefficients there are.
            let none = vec![f64::NAN; terms.stack.len()];
            let multilayer = screening.multilayer([&none, &terms.lobe]);
            equations.clear();
            screening
                .join(&lamella, &multilayer, &mut Vec::new(), |curve, sums| linear.add(&mut equations, curve, sums));
            assert!(equations.best_sum_of_squares().is_infinite(), "{scale:?}");
        }
    }
}
