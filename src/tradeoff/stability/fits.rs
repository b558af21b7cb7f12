//! Solvers on hard input: difference steps, noise, starts.

use super::{Map, Row, Verdict, forms};
use crate::inversion::{Compiled, FitSettings, Parameter, Problem, Search, Space, fit, values};
use crate::optics::Structure;
use crate::optimise::{LeastSquares, Tolerances, minimise};
use crate::tradeoff::solvers::problems::{Known, little};
use crate::tradeoff::solvers::rivals::Rival;
use crate::tradeoff::solvers::watched::{Difference, Watched};
use crate::tradeoff::{Settings, TradeoffError};
use nalgebra::DVector;

/// Evaluations after which a run is given up; a good one takes below 200.
const LIMIT: usize = 3000;
/// How far above the lowest chi² an end may be: a thirtieth of a standard deviation of a parameter.
const SAME: f64 = 1e-3;
/// Where the start is, off the truth.
const START: f64 = 0.05;
/// Relative steps that are tried.
const STEPS: [f64; 6] = [1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 1e-15];
/// Those that are tried with a model in single precision.
const SINGLE_STEPS: [f64; 3] = [1e-2, 1e-4, 1e-7];

/// One problem and the way into it.
struct Case {
    input: String,
    /// Step of the forms that have a fixed one.
    step: f64,
    noise: f64,
    single: bool,
    start: [f64; 5],
}

fn cases() -> Vec<Case> {
    let truth = values(&Structure::table1());
    // Thicknesses against each other, as no symmetry of the model takes it back.
    let off = |share: f64| {
        let signs = [1.0, -1.0, 1.0, -1.0, 1.0];
        std::array::from_fn(|j| truth[j] * (1.0 + share * signs[j]))
    };
    let near = off(START);
    let of = |input: String| Case { input, step: 1e-6, noise: 0.02, single: false, start: near };
    let mut cases: Vec<Case> =
        STEPS.into_iter().map(|step| Case { step, ..of(format!("difference step {step:e}")) }).collect();
    cases.extend(SINGLE_STEPS.map(|step| Case {
        step,
        single: true,
        ..of(format!("model in single precision, step {step:e}"))
    }));
    cases.extend([0.0, 0.1, 0.5].map(|noise| Case { noise, ..of(format!("noise {} %", 100.0 * noise)) }));
    cases.extend(
        [0.1, 0.2, 0.3, 0.4].map(|share| Case { start: off(share), ..of(format!("start {} % off", 100.0 * share)) }),
    );
    let swapped = [truth[1] * 1.56, truth[0] / 1.56, truth[2], truth[3], truth[4]];
    let narrow = [near[0], near[1], Parameter::Delta.inside(-9.5), 0.1, near[4]];
    let no_tilt = [truth[0], truth[1], 0.0, truth[3], truth[4]];
    let corner = [250.0, 200.0, Parameter::Delta.inside(10.0), 1.2, 600.0];
    cases.extend([
        Case { start: swapped, ..of("start at the swap alias".to_owned()) },
        Case { start: narrow, ..of("start with a narrow lobe beside".to_owned()) },
        Case { start: no_tilt, ..of("start at δ = 0".to_owned()) },
        Case { start: corner, ..of("start in a corner of the bounds".to_owned()) },
    ]);
    cases
}

pub(super) fn map(settings: &Settings) -> Result<Map, TradeoffError> {
    let rows = cases().iter().map(|case| row(case, settings.seed)).collect::<Result<_, _>>()?;
    Ok(Map {
        title: "Solvers".to_owned(),
        forms: forms(&[
            ("Gauss–Newton, forward, fixed step", false),
            ("Gauss–Newton, central, fixed step", false),
            ("MINPACK port, forward, fixed step", false),
            ("MINPACK port, central, fixed step", false),
            ("ours, local", false),
            ("ours, global", true),
        ]),
        rows,
    })
}

fn row(case: &Case, seed: u64) -> Result<Row, TradeoffError> {
    let Known { data, settings, .. } = little(&values(&Structure::table1()), case.noise, seed)?;
    let model = settings.model.build(settings.stack.clone());
    let compiled = Compiled::new(&data, &settings, model.as_ref())?;
    let space = Space::new(&settings.roles)?;
    let problem = Problem::new(&compiled, &space, &[]);
    let vector = |values: &[f64; 5]| DVector::from_column_slice(values);
    let start = space.bounds.clamp(&vector(&case.start));
    let begin = Parameter::ALL.map(|parameter| Some(start[parameter.index()]));
    let global = FitSettings { search: Search::Global, start: begin, ..settings.clone() };
    let global = fit(&data, &global, &|_| {})?.outcome.chi2;
    // The minimum next to the truth, unless noise has made another one lower.
    let of_truth = minimise(&problem, &vector(&values(&Structure::table1())), Tolerances::default());
    let lowest = of_truth.sum_of_squares.min(global);
    let judge = |chi2: Option<f64>, spent: bool| match chi2 {
        Some(chi2) if chi2 <= lowest + SAME => Verdict::Right,
        _ if spent => Verdict::Endless,
        Some(chi2) if chi2.is_finite() => Verdict::Wrong,
        Some(_) => Verdict::NotANumber,
        None => Verdict::Refused,
    };
    let mut cells = Vec::new();
    for (rival, difference) in [
        (Rival::GaussNewton, Difference::FixedForward(case.step)),
        (Rival::GaussNewton, Difference::FixedCentral(case.step)),
        (Rival::Minpack, Difference::FixedForward(case.step)),
        (Rival::Minpack, Difference::FixedCentral(case.step)),
        (Rival::Ours, Difference::Kernel),
    ] {
        let watched = Watched::new(&problem, &space, difference, &|| 0.0)
            .for_evaluations(LIMIT)
            .in_single_precision(case.single && rival != Rival::Ours);
        let found = rival.descend(&watched, &start, seed);
        let chi2 = found.map(|found| problem.residuals(&found).norm_squared());
        // Ours is not run in single precision.
        let absent = case.single && rival == Rival::Ours;
        cells.push(if absent { Verdict::Absent } else { judge(chi2, watched.is_spent()) });
    }
    cells.push(if case.single { Verdict::Absent } else { judge(Some(global), false) });
    Ok(Row { input: case.input.clone(), expected: "the lowest chi²".to_owned(), cells })
}
