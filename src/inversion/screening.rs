//! Sums over the readings for many structures at once: what structures share is summed once.
//!
//! Model A's sums depend on the width of the lamellae, Model B's on tilt and lobe, and only readings in a plane between
//! the two see their product. On a grid of 5 × 3 × 4 of these, 15 + 4 sums stand for 60.
//!
//! Readings that see the same node are one term of a sum, whose weights no structure changes; those of Model B are of one lobe:
//!
//! ```text
//! sum_r (w_r B_r)² = sum_s R_s² q_s,   q_s = sum_{r at s} (w_r sin²(omega_r) L_r)²
//! ```

use crate::inversion::nuisance::{LinearPart, Sums};
use crate::inversion::numbering::Numbers;
use crate::inversion::plan::Plan;
use crate::numerics::dot::{dot, square_and_product};
use std::ops::Range;

/// What the readings say of one model.
#[derive(Debug)]
pub(crate) struct OfPart {
    /// For each curve: the sum of its squares, of its products with the intensity, and of itself.
    sums: Vec<[f64; 3]>,
    /// At the crossings, with their factors.
    crossed: Vec<f64>,
}

/// The stack at the places of Model B.
#[derive(Debug)]
pub(crate) struct OfStack {
    values: Vec<f64>,
    /// At the crossings.
    crossed: Vec<f64>,
}

/// What a lobe makes of the readings.
#[derive(Debug)]
pub(crate) struct OfLobe {
    weights: Weights,
    /// At the crossings, with their factors.
    crossed: Vec<f64>,
}

/// Weights of a value at each place in the sum of its squares, of its products with the intensity, and of itself; the last is
/// empty where there is no background.
#[derive(Debug, Clone, Default)]
struct Weights([Vec<f64>; 3]);

/// The nodes that the readings of a curve see, curve after curve.
#[derive(Debug, Default)]
struct Places {
    nodes: Vec<usize>,
    curves: Vec<(usize, Range<usize>)>,
}

/// A reading of Model B.
#[derive(Debug)]
struct Seen {
    place: usize,
    lobe: usize,
    /// Weight times share.
    weight: f64,
    /// Weight times intensity, and weight.
    others: [f64; 2],
}

/// Readings that see both models at the same nodes.
#[derive(Debug)]
struct Crossing {
    lamella: usize,
    stack: usize,
    lobe: usize,
    /// Sum of their weights squared times both shares.
    factor: f64,
}

/// The readings of a plan by curve; curves with the same nuisances count as one.
#[derive(Debug)]
pub(crate) struct Screening {
    /// Sums that no structure changes, for each curve.
    constant: Vec<Sums>,
    /// The curves that have readings.
    curves: Vec<usize>,
    lamella: Places,
    of_lamella: Weights,
    stack: Places,
    seen: Vec<Seen>,
    crossings: Vec<Crossing>,
    crossed: Vec<(usize, Range<usize>)>,
    has_background: bool,
}

impl Screening {
    pub(crate) fn new(plan: &Plan<'_>, linear: &LinearPart) -> Self {
        let weighted = plan.rows.weighted(&[]);
        let has_background = linear.has_background();
        let mut screening = Self {
            constant: vec![Sums::default(); plan.curves],
            curves: Vec::new(),
            lamella: Places::default(),
            of_lamella: Weights::default(),
            stack: Places::default(),
            seen: Vec::new(),
            crossings: Vec::new(),
            crossed: Vec::new(),
            has_background,
        };
        let mut spans: Vec<&(usize, Range<usize>)> = plan.rows.spans().iter().collect();
        spans.sort_by_key(|(curve, _)| *curve);
        for of_curve in spans.chunk_by(|a, b| a.0 == b.0) {
            let curve = of_curve[0].0;
            screening.curves.push(curve);
            let [mut lamellae, mut stacks] = [Numbers::default(), Numbers::default()];
            let mut crossings = Numbers::default();
            let starts = [screening.lamella.nodes.len(), screening.stack.nodes.len(), screening.crossings.len()];
            let constant = &mut screening.constant[curve];
            for row in of_curve.iter().flat_map(|(_, rows)| rows.clone()) {
                let reading = plan.readings()[row];
                let (weight, intensity) = (weighted.weights[row], weighted.intensities[row]);
                constant.products[2][2] += weight * weight;
                constant.with_intensity[2] += weight * intensity;
                constant.square += intensity * intensity;
                if reading.share_a > 0.0 {
                    let place = starts[0] + lamellae.of(reading.lamella);
                    screening.lamella.meet(place, reading.lamella);
                    screening.of_lamella.add(place, weight * reading.share_a, [intensity, weight], has_background);
                }
                if reading.share_b > 0.0 {
                    let place = starts[1] + stacks.of(reading.stack);
                    screening.stack.meet(place, reading.stack);
                    let (weight, others) = (weight * reading.share_b, [intensity, weight]);
                    screening.seen.push(Seen { place, lobe: reading.lobe, weight, others });
                }
                if reading.share_a > 0.0 && reading.share_b > 0.0 {
                    let (lamella, stack, lobe) = (reading.lamella, reading.stack, reading.lobe);
                    let place = starts[2] + crossings.of((lamella, stack, lobe));
                    if place == screening.crossings.len() {
                        screening.crossings.push(Crossing { lamella, stack, lobe, factor: 0.0 });
                    }
                    screening.crossings[place].factor += weight * weight * reading.share_a * reading.share_b;
                }
            }
            screening.lamella.curves.push((curve, starts[0]..screening.lamella.nodes.len()));
            screening.stack.curves.push((curve, starts[1]..screening.stack.nodes.len()));
            if starts[2] < screening.crossings.len() {
                screening.crossed.push((curve, starts[2]..screening.crossings.len()));
            }
        }
        screening
    }

    /// Sums of Model A, of its values at the nodes.
    pub(crate) fn lamella(&self, nodes: &[f64]) -> OfPart {
        let values = self.lamella.values(nodes);
        let crossed = self.crossings.iter().map(|at| nodes[at.lamella]).collect();
        OfPart { sums: self.sums(&self.lamella, &values, &self.of_lamella), crossed }
    }

    /// The stack's values at the nodes.
    pub(crate) fn stack(&self, nodes: &[f64]) -> OfStack {
        let crossed = self.crossings.iter().map(|at| nodes[at.stack]).collect();
        OfStack { values: self.stack.values(nodes), crossed }
    }

    /// The lobe's values at the nodes.
    pub(crate) fn lobe(&self, nodes: &[f64]) -> OfLobe {
        let mut weights = Weights::none(self.stack.nodes.len(), self.has_background);
        for seen in &self.seen {
            weights.add(seen.place, seen.weight * nodes[seen.lobe], seen.others, self.has_background);
        }
        let crossed = self.crossings.iter().map(|at| at.factor * nodes[at.lobe]).collect();
        OfLobe { weights, crossed }
    }

    /// Sums of Model B.
    pub(crate) fn multilayer(&self, stack: &OfStack, lobe: &OfLobe) -> OfPart {
        let crossed = stack.crossed.iter().zip(&lobe.crossed).map(|(r, l)| r * l).collect();
        OfPart { sums: self.sums(&self.stack, &stack.values, &lobe.weights), crossed }
    }

    fn sums(&self, places: &Places, values: &[f64], Weights([squares, products, ones]): &Weights) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.constant.len()];
        for (curve, of) in &places.curves {
            let values = &values[of.clone()];
            let (square, product) = square_and_product(values, [&squares[of.clone()], &products[of.clone()]]);
            let one = if self.has_background { dot(values, &ones[of.clone()]) } else { 0.0 };
            sums[*curve] = [square, product, one];
        }
        sums
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
        for (curve, of) in &self.crossed {
            products[*curve] = dot(&lamella.crossed[of.clone()], &multilayer.crossed[of.clone()]);
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

impl Places {
    /// The next place, if it is a new one.
    fn meet(&mut self, place: usize, node: usize) {
        if place == self.nodes.len() {
            self.nodes.push(node);
        }
    }

    fn values(&self, nodes: &[f64]) -> Vec<f64> {
        self.nodes.iter().map(|&node| nodes[node]).collect()
    }
}

impl Weights {
    fn none(places: usize, has_background: bool) -> Self {
        Self([places, places, if has_background { places } else { 0 }].map(|count| vec![0.0; count]))
    }

    /// A reading of this weight, with its weighted intensity and the weight of its background.
    fn add(&mut self, place: usize, weight: f64, [intensity, one]: [f64; 2], has_background: bool) {
        let Self([squares, products, ones]) = self;
        if place == squares.len() {
            squares.push(0.0);
            products.push(0.0);
            ones.extend(has_background.then_some(0.0));
        }
        squares[place] += weight * weight;
        products[place] += weight * intensity;
        if let Some(sum) = ones.get_mut(place) {
            *sum += weight * one;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Dataset, Reading};
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
        // Both models are seen, in two planes, and by another curve at the same nodes.
        scans.extend([Scan::angular(480.0, 30.0), Scan::angular(480.0, 75.0)]);
        let data = simulate(&model, &blue, &scans, 2.0, 0.01, 1).unwrap();
        let (mut readings, mut curves) = (data.readings().to_vec(), data.curves().to_vec());
        let again = readings.iter().filter(|reading| reading.curve + 1 == curves.len()).cloned();
        let again: Vec<Reading> = again.map(|reading| Reading { curve: curves.len(), ..reading }).collect();
        readings.extend(again);
        curves.push("again".to_owned());
        let data = Dataset::from_readings(readings, curves).unwrap();
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
            let screening = Screening::new(&plan, &linear);
            let lamella = screening.lamella(&terms.lamella);
            let lobe = screening.lobe(&terms.lobe);
            let multilayer = screening.multilayer(&screening.stack(&terms.stack), &lobe);
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
            let multilayer = screening.multilayer(&screening.stack(&none), &lobe);
            equations.clear();
            screening
                .join(&lamella, &multilayer, &mut Vec::new(), |curve, sums| linear.add(&mut equations, curve, sums));
            assert!(equations.best_sum_of_squares().is_infinite(), "{scale:?}");
        }
    }
}
