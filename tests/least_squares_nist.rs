//! The solver on problems whose answers are certified: NIST `StRD`, and the traps of Moré, Garbow and Hillstrom.
//!
//! The score of a parameter is `LRE = -log10(|estimate - certified| / |certified|)`, about the number of right digits.

mod support;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt as Minpack};
use morpho_fit::optimise::{
    Bounds, LeastSquares, Minimum, Tolerances, central_jacobian, merge_equal, minimise, multistart,
};
use morpho_fit::uncertainty::covariance::covariance;
use nalgebra::{DMatrix, DVector, Dyn, Owned};
use support::more_garbow_hillstrom::{self, MinimumKind, TestProblem};
use support::nist::{self, NistProblem, log_relative_error};

/// Digits that count as right.
const RIGHT: f64 = 6.0;
/// Digits that a standard error needs.
const RIGHT_ERROR: f64 = 4.0;

/// Any residual function without bounds; a change of a parameter matters in proportion to its start.
struct Problem<F> {
    residuals: F,
    bounds: Bounds,
    scales: DVector<f64>,
}

impl<F: Fn(&[f64]) -> Vec<f64>> Problem<F> {
    fn new(residuals: F, start: &[f64]) -> Self {
        let scales = DVector::from_iterator(start.len(), start.iter().map(|b| b.abs().max(1e-6)));
        Self { residuals, bounds: Bounds::none(start.len()), scales }
    }
}

impl<F: Fn(&[f64]) -> Vec<f64>> LeastSquares for Problem<F> {
    fn residuals(&self, p: &DVector<f64>) -> DVector<f64> {
        DVector::from_vec((self.residuals)(p.as_slice()))
    }
    fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    fn scales(&self) -> &DVector<f64> {
        &self.scales
    }
}

fn fit(problem: &NistProblem, start: &[f64]) -> Minimum {
    let objective = Problem::new(|b: &[f64]| problem.residuals(b), start);
    minimise(&objective, &DVector::from_column_slice(start), Tolerances::default())
}

/// Groups of parameters that may change places without changing the model: like terms of a sum.
fn like_terms(name: &str) -> &'static [&'static [usize]] {
    match name {
        "Lanczos1" | "Lanczos2" | "Lanczos3" => &[&[0, 1], &[2, 3], &[4, 5]],
        "MGH17" => &[&[1, 3], &[2, 4]],
        "Gauss1" | "Gauss2" | "Gauss3" => &[&[2, 3, 4], &[5, 6, 7]],
        "ENSO" => &[&[3, 4, 5], &[6, 7, 8]],
        _ => &[],
    }
}

/// The estimate with its like terms in the order of the certified ones, the term of the nearest last parameter first.
fn in_order(problem: &NistProblem, found: &DVector<f64>) -> DVector<f64> {
    let groups = like_terms(problem.name);
    let mut ordered = found.clone();
    let mut left: Vec<&[usize]> = groups.to_vec();
    for group in groups {
        let last = group.len() - 1;
        let target = problem.certified[group[last]];
        let apart = |other: &[usize]| (found[other[last]] - target).abs();
        let nearest = (0..left.len()).min_by(|&a, &b| apart(left[a]).total_cmp(&apart(left[b]))).unwrap();
        let from = left.remove(nearest);
        for (to, from) in group.iter().zip(from) {
            ordered[*to] = found[*from];
        }
    }
    ordered
}

fn score(problem: &NistProblem, found: &DVector<f64>) -> f64 {
    let ordered = in_order(problem, found);
    let scores = ordered.iter().zip(&problem.certified).map(|(&b, &certified)| log_relative_error(b, certified));
    scores.fold(f64::INFINITY, f64::min)
}

/// The best of the given start and six more within a decade of it, on its side of 0.
fn best_of_many(problem: &NistProblem, start: &[f64]) -> Minimum {
    let (low, high): (Vec<f64>, Vec<f64>) =
        start.iter().map(|b| if *b > 0.0 { (b / 10.0, b * 10.0) } else { (b * 10.0, b / 10.0) }).unzip();
    let mut starts = vec![DVector::from_column_slice(start)];
    starts.extend(Bounds::new(&low, &high).unwrap().latin_hypercube(6, 1));
    let objective = || Problem::new(|b: &[f64]| problem.residuals(b), start);
    let tolerances = Tolerances { max_evaluations: 2000, ..Tolerances::default() };
    let runs = multistart(objective, &starts, tolerances);
    merge_equal(runs, &objective().scales).swap_remove(0)
}

#[test]
fn one_start_finds_at_least_53_of_54_and_never_claims_a_wrong_one() {
    let mut right = 0;
    let mut report = Vec::new();
    for problem in nist::problems() {
        for (which, start) in problem.starts.iter().enumerate() {
            let found = fit(&problem, start);
            let digits = score(&problem, &found.parameters);
            let line = format!("{} start {}: {digits:.1} digits, {:?}", problem.name, which + 1, found.termination);
            if digits >= RIGHT {
                right += 1;
                assert!(found.termination.was_successful(), "right but not claimed: {line}");
            } else {
                assert!(!found.termination.was_successful(), "wrong but claimed: {line}");
                report.push(line);
            }
        }
    }
    assert!(right >= 53, "{right} of 54: {report:#?}");
}

#[test]
fn many_starts_find_all_54_with_standard_errors_right_on_at_least_52() {
    let mut errors_right = 0;
    let mut report = Vec::new();
    for problem in nist::problems() {
        for start in &problem.starts {
            let best = best_of_many(&problem, start);
            let digits = score(&problem, &best.parameters);
            assert!(digits >= RIGHT, "{}: {digits:.1} digits, {:?}", problem.name, best.termination);
            assert!(best.termination.was_successful(), "{}: {:?}", problem.name, best.termination);

            #[allow(clippy::cast_precision_loss, reason = "a few hundred readings")]
            let variance = best.sum_of_squares / problem.degrees_of_freedom as f64;
            let covariance = covariance(&best.triangle).unwrap();
            let errors = DVector::from_fn(best.parameters.len(), |j, _| (covariance[(j, j)] * variance).sqrt());
            // Put in order as the parameters were: by their values, not by those of the errors.
            let places = in_order(&problem, &DVector::from_fn(errors.len(), |j, _| best.parameters[j]));
            let place = |j: usize| best.parameters.iter().position(|b| b.to_bits() == places[j].to_bits()).unwrap();
            let digits = (problem.standard_errors.iter().enumerate())
                .map(|(j, &certified)| log_relative_error(errors[place(j)], certified))
                .fold(f64::INFINITY, f64::min);
            if digits >= RIGHT_ERROR {
                errors_right += 1;
            } else {
                report.push(format!("{}: {digits:.1} digits", problem.name));
            }
        }
    }
    // Lanczos1's certified residuals are below what its printed digits can reproduce in double precision.
    assert!(errors_right >= 52, "{errors_right} of 54: {report:#?}");
}

/// The same problem for the MINPACK port, with the same differences.
struct ForMinpack<'a> {
    problem: &'a NistProblem,
    at: DVector<f64>,
    scales: DVector<f64>,
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for ForMinpack<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;
    fn set_params(&mut self, at: &DVector<f64>) {
        self.at.copy_from(at);
    }
    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }
    fn residuals(&self) -> Option<DVector<f64>> {
        Some(DVector::from_vec(self.problem.residuals(self.at.as_slice())))
    }
    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let residuals = |p: &DVector<f64>| DVector::from_vec(self.problem.residuals(p.as_slice()));
        Some(central_jacobian(residuals, &self.at, &self.scales, &Bounds::none(self.at.len())))
    }
}

#[test]
fn agrees_with_the_minpack_port_where_that_one_is_right() {
    let mut compared = 0;
    for problem in nist::problems() {
        for start in &problem.starts {
            let at = DVector::from_column_slice(start);
            let scales = at.map(|b| b.abs().max(1e-6));
            let (oracle, _) = Minpack::new().minimize(ForMinpack { problem: &problem, at, scales });
            if score(&problem, &oracle.at) >= RIGHT {
                compared += 1;
                let ours = fit(&problem, start);
                assert!(score(&problem, &ours.parameters) >= RIGHT, "{}: only the oracle is right", problem.name);
            }
        }
    }
    assert!(compared >= 50, "the oracle itself was right only {compared} times");
}

fn minimise_trap(problem: &TestProblem, factor: f64) -> Minimum {
    let start = problem.scaled_start(factor);
    let objective = Problem::new(|x: &[f64]| problem.residuals(x), &start);
    minimise(&objective, &DVector::from_column_slice(&start), Tolerances::default())
}

#[test]
fn traps_end_in_a_published_minimum_or_are_not_called_a_success() {
    for problem in more_garbow_hillstrom::problems() {
        for factor in [1.0, 10.0, 100.0] {
            let found = minimise_trap(&problem, factor);
            if !found.termination.was_successful() {
                continue;
            }
            let sum = found.sum_of_squares;
            let known = problem.minima.iter().find(|minimum| {
                let minimum_is = matches!(minimum.kind, MinimumKind::Global | MinimumKind::Local);
                minimum_is && (sum - minimum.sum_of_squares).abs() <= 1e-6 * minimum.sum_of_squares + 1e-12
            });
            assert!(known.is_some(), "{} from {factor} starts: claims {sum}, {:?}", problem.name, found.termination);
        }
    }
}

#[test]
fn standard_starts_reach_their_global_minimum() {
    for problem in more_garbow_hillstrom::problems() {
        // From its standard start every descent falls into the local minimum 48.98.
        if problem.name.starts_with("Freudenstein") {
            continue;
        }
        let found = minimise_trap(&problem, 1.0);
        let (sum, global) = (found.sum_of_squares, problem.global_minimum());
        assert!((sum - global).abs() <= 1e-6 * global + 1e-12, "{}: {sum} for {global}", problem.name);
    }
}

#[test]
fn the_local_minimum_of_freudenstein_and_roth_is_the_published_one() {
    let problems = more_garbow_hillstrom::problems();
    let problem = problems.iter().find(|problem| problem.name.starts_with("Freudenstein")).unwrap();
    assert!((minimise_trap(problem, 1.0).sum_of_squares - 48.984_253_679).abs() < 1e-6);
}

#[test]
fn bounds_hold_to_the_last_bit_whatever_the_start() {
    // Rosenbrock in boxes that cut off its valley at random.
    for (case, corner) in Bounds::new(&[-2.0, -2.0], &[0.9, 0.7]).unwrap().latin_hypercube(200, 3).iter().enumerate() {
        let bounds = Bounds::new(corner.as_slice(), &[corner[0] + 0.37, corner[1] + 0.21]).unwrap();
        let visited = std::cell::RefCell::new(0);
        let residuals = |p: &[f64]| {
            assert!(bounds.contain(&DVector::from_column_slice(p)), "case {case} left the box: {p:?}");
            *visited.borrow_mut() += 1;
            vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]
        };
        let objective = Problem { residuals, bounds: bounds.clone(), scales: DVector::from_element(2, 1.0) };
        let found = minimise(&objective, &DVector::from_vec(vec![5.0, -5.0]), Tolerances::default());
        assert!(bounds.contain(&found.parameters));
        assert!(*visited.borrow() > 0);
        // The minimum in the box: no feasible step to any side lowers the sum.
        let sum = found.sum_of_squares;
        for step in [[1e-5, 0.0], [-1e-5, 0.0], [0.0, 1e-5], [0.0, -1e-5]] {
            let moved = bounds.clamp(&(&found.parameters + DVector::from_column_slice(&step)));
            let there = DVector::from_vec((objective.residuals)(moved.as_slice())).norm_squared();
            assert!(there >= sum - 1e-12 * sum.max(1e-6), "case {case}: {there} < {sum}");
        }
    }
}

#[test]
fn a_residual_that_is_not_finite_is_walked_round() {
    // ln(b) is NaN below 0, where the full step from 10 leads.
    let residuals = |b: &[f64]| vec![b[0].ln() - 0.5, 1e-3 * (b[0] - 2.0)];
    let objective = Problem::new(residuals, &[10.0]);
    let found = minimise(&objective, &DVector::from_element(1, 10.0), Tolerances::default());
    assert!(found.termination.was_successful() && (found.parameters[0] - 0.5_f64.exp()).abs() < 1e-3);
    let nowhere = Problem::new(|_: &[f64]| vec![f64::NAN; 2], &[1.0]);
    let lost = minimise(&nowhere, &DVector::from_element(1, 1.0), Tolerances::default());
    assert!(!lost.termination.was_successful());
}
