//! Sums over the readings for many structures at once: what structures share is summed once.
//!
//! Model A's sums depend on the width of the lamellae, Model B's on tilt and lobe, and only readings in a plane between
//! the two see their product. On a grid of 5 × 3 × 4 of these, 15 + 4 sums stand for 60.

use crate::inversion::nuisance::Sums;
use crate::inversion::plan::{Plan, TermsView};
use crate::numerics::dot::dot;
use std::ops::Range;

/// A reading that sees one of the two models.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// Nodes of its two factors.
    nodes: (usize, usize),
    curve: usize,
    share: f64,
    /// `1 / sigma²`, and that times the intensity.
    weight: f64,
    weighted_intensity: f64,
    /// Place among the readings that see both models.
    crossed: Option<usize>,
}

/// What the readings say of one model.
#[derive(Debug)]
pub(crate) struct OfPart {
    /// For each curve: the sum of its squares, of its products with the intensity, and of itself.
    sums: Vec<[f64; 3]>,
    /// Its values over sigma where a reading sees the other model too.
    values: Vec<f64>,
}

/// The readings of a plan by what they see.
#[derive(Debug)]
pub(crate) struct Screening {
    lamella: Vec<Row>,
    multilayer: Vec<Row>,
    /// Readings that see both models, of each curve in turn.
    crossed: Vec<Range<usize>>,
    /// Sums that no structure changes, for each curve.
    constant: Vec<Sums>,
}

impl Screening {
    pub(crate) fn new(plan: &Plan<'_>) -> Self {
        let mut constant = vec![Sums::default(); plan.curves];
        let mut by_curve = vec![Vec::new(); plan.curves];
        for (index, reading) in plan.readings.iter().enumerate() {
            constant[reading.curve].add(reading.weight * reading.weight, (0.0, 0.0), reading.intensity);
            by_curve[reading.curve].push(index);
        }
        let (mut lamella, mut multilayer, mut crossed) = (Vec::new(), Vec::new(), Vec::new());
        let mut next = 0;
        for (curve, rows) in by_curve.into_iter().enumerate() {
            let first = next;
            for reading in rows.into_iter().map(|index| &plan.readings[index]) {
                let both = reading.share_a > 0.0 && reading.share_b > 0.0;
                let weight = reading.weight * reading.weight;
                let row = |nodes, share| Row {
                    nodes,
                    curve,
                    share,
                    weight,
                    weighted_intensity: weight * reading.intensity,
                    crossed: both.then_some(next),
                };
                if reading.share_a > 0.0 {
                    lamella.push(row((reading.lamella, reading.lamella), reading.share_a));
                }
                if reading.share_b > 0.0 {
                    multilayer.push(row((reading.stack, reading.lobe), reading.share_b));
                }
                next += usize::from(both);
            }
            crossed.push(first..next);
        }
        Self { lamella, multilayer, crossed, constant }
    }

    /// Sums of Model A.
    pub(crate) fn lamella(&self, terms: TermsView<'_>) -> OfPart {
        self.sums(&self.lamella, terms.interference, terms.diffraction)
    }

    /// Sums of Model B.
    pub(crate) fn multilayer(&self, terms: TermsView<'_>) -> OfPart {
        self.sums(&self.multilayer, terms.stack, terms.lobe)
    }

    fn sums(&self, rows: &[Row], first: &[f64], second: &[f64]) -> OfPart {
        let mut sums = vec![[0.0; 3]; self.constant.len()];
        let mut values = vec![0.0; self.crossed.last().map_or(0, |last| last.end)];
        for run in rows.chunk_by(|a, b| a.curve == b.curve) {
            let mut own = [0.0; 3];
            for row in run {
                let value = row.share * first[row.nodes.0] * second[row.nodes.1];
                let weighted = row.weight * value;
                own[0] += weighted * value;
                own[1] += row.weighted_intensity * value;
                own[2] += weighted;
                if let Some(place) = row.crossed {
                    values[place] = value * row.weight.sqrt();
                }
            }
            sums[run[0].curve] = own;
        }
        OfPart { sums, values }
    }

    /// Hands the sums of each curve to `add`.
    pub(crate) fn join(&self, lamella: &OfPart, multilayer: &OfPart, mut add: impl FnMut(usize, &Sums)) {
        for (curve, constant) in self.constant.iter().enumerate() {
            let mut sums = *constant;
            [sums.products[0][0], sums.with_intensity[0], sums.products[2][0]] = lamella.sums[curve];
            [sums.products[1][1], sums.with_intensity[1], sums.products[2][1]] = multilayer.sums[curve];
            let rows = self.crossed[curve].clone();
            sums.products[1][0] = dot(&lamella.values[rows.clone()], &multilayer.values[rows]);
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
            (Extent::Shared, Weight::Fitted, Extent::Shared),
            (Extent::PerCurve, Weight::Fitted, Extent::PerCurve),
        ] {
            let settings = FitSettings { nuisances: Nuisances { scale, weight, background }, ..FitSettings::default() };
            let Compiled { plan, linear, .. } = Compiled::new(&data, &settings, &model).unwrap();
            let terms = plan.terms(&[120.0, 75.0, -0.02, 0.7, 250.0]);
            let screening = Screening::new(&plan);
            let (lamella, multilayer) = (screening.lamella(terms.view()), screening.multilayer(terms.view()));
            let mut equations = linear.no_equations();
            let add = |curve, sums: &Sums| linear.add(&mut equations, curve, sums);
            screening.join(&lamella, &multilayer, add);
            let weighted = plan.rows.weighted(&[]);
            let parts = plan.rows.parts(terms.view(), &weighted.weights);
            let whole = linear.normal_equations(&plan.rows, &parts, &weighted);
            let expected = whole.sum_of_squares(&whole.solve());
            assert_relative_eq!(equations.best_sum_of_squares(), expected, max_relative = 1e-10);

            // Where the model has no value there is no sum, however many coefficients there are.
            let mut none = terms.clone();
            none.stack.fill(f64::NAN);
            let multilayer = screening.multilayer(none.view());
            equations.clear();
            screening.join(&lamella, &multilayer, |curve, sums| linear.add(&mut equations, curve, sums));
            assert!(equations.best_sum_of_squares().is_infinite(), "{scale:?}");
        }
    }
}
