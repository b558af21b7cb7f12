//! Derivatives of the model by its five parameters over a whole design: error against time.

use crate::inversion::{Compiled, Derivative, Extent, FitSettings, Nuisances, Problem, Space, Weight, values};
use crate::optics::{BlendModel, Structure};
use crate::optimise::{Bounds, LeastSquares, central_jacobian};
use crate::synthetic::linspace;
use crate::tradeoff::complex_step::{Design, Way, jacobian};
use crate::tradeoff::solvers::problems::drawn;
use crate::tradeoff::timing::{Method, seconds};
use crate::tradeoff::{Clock, Diagram, Point, Series, Settings, TradeoffError};
use crate::units::radians;
use nalgebra::{DMatrix, DVector};
use std::hint::black_box;

/// Relative step of the four points: nine layers have large fifth derivatives, so that `epsilon^(1/5)` would be too wide.
const FOUR_POINT_STEP: f64 = 4e-5;

/// A way to all five columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Means {
    Forward,
    Central,
    Richardson,
    /// The fit's own by `--derivative finite-difference`: of each term by the parameters that it depends on.
    ByTerms,
    /// The fit's own by `--derivative exact`.
    Exact,
    ComplexStep,
}

impl Means {
    const ALL: [Self; 6] =
        [Self::Forward, Self::Central, Self::Richardson, Self::ByTerms, Self::Exact, Self::ComplexStep];

    fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward difference",
            Self::Central => "central difference",
            Self::Richardson => "Richardson, four points",
            Self::ByTerms => "the fit's own, differences",
            Self::Exact => "the fit's own, exact",
            Self::ComplexStep => "complex step",
        }
    }
}

/// Differences of the whole residuals with steps of `size` times the parameter or a change that matters.
fn differences(problem: &Problem<'_>, at: &DVector<f64>, scales: &DVector<f64>, way: Means) -> DMatrix<f64> {
    let size = match way {
        Means::Forward => f64::EPSILON.sqrt(),
        _ => FOUR_POINT_STEP,
    };
    let here = if way == Means::Forward { problem.residuals(at) } else { DVector::zeros(0) };
    let columns: Vec<DVector<f64>> = (0..at.len())
        .map(|j| {
            let there = at[j] + size * at[j].abs().max(scales[j]);
            let step = there - at[j];
            let moved = |steps: f64| {
                let mut place = at.clone();
                place[j] += steps * step;
                problem.residuals(&place)
            };
            match way {
                Means::Forward => (moved(1.0) - &here) / step,
                _ => ((moved(1.0) - moved(-1.0)) * 8.0 - (moved(2.0) - moved(-2.0))) / (12.0 * step),
            }
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// The largest relative error of a column, in its length.
fn error(found: &DMatrix<f64>, known: &DMatrix<f64>) -> f64 {
    let of = |(found, known): (nalgebra::DVectorView<'_, f64>, nalgebra::DVectorView<'_, f64>)| {
        (found - known).norm() / known.norm()
    };
    found.column_iter().zip(known.column_iter()).map(of).fold(0.0, f64::max)
}

pub(super) fn diagram(settings: &Settings, clock: Clock<'_>) -> Result<Diagram, TradeoffError> {
    let truth = values(&Structure::table1());
    let data = drawn(&truth, 0.0, settings.seed)?.data;
    let nuisances = Nuisances { scale: Extent::None, weight: Weight::Fixed(1.0), background: Extent::None };
    let chosen = FitSettings { nuisances, derivative: Derivative::FiniteDifference, ..FitSettings::default() };
    let exactly = FitSettings { derivative: Derivative::Exact, ..chosen.clone() };
    let model = BlendModel::default();
    let compiled = Compiled::new(&data, &chosen, &model)?;
    let compiled_exactly = Compiled::new(&data, &exactly, &model)?;
    let space = Space::new(&chosen.roles)?;
    let problem = Problem::new(&compiled, &space, &[]);
    let exact = Problem::new(&compiled_exactly, &space, &[]);
    let design = Design {
        planes: [15.0, 75.0].map(radians).to_vec(),
        wavelengths: linspace(380.0, 740.0, 37),
        views: linspace(-75.0, 75.0, 31).into_iter().map(radians).collect(),
    };
    // Residuals are in units of sigma, which all readings share.
    let weight = data.readings().first().and_then(|reading| reading.sigma).map_or(1.0, f64::recip);
    let at = DVector::from_column_slice(&truth);
    let of = |way: Means| match way {
        Means::Forward | Means::Richardson => differences(&problem, &at, &space.scales, way),
        Means::Central => central_jacobian(|place| problem.residuals(place), &at, &space.scales, &Bounds::none(5)),
        Means::ByTerms => problem.jacobian(&at),
        Means::Exact => exact.jacobian(&at),
        Means::ComplexStep => jacobian(&design, &truth, Way::Chebyshev) * weight,
    };
    let known = jacobian(&design, &truth, Way::Product) * weight;
    let mut methods: Vec<Method<'_>> =
        Means::ALL.iter().map(|&way| Box::new(move || drop(black_box(of(way)))) as Method<'_>).collect();
    let times = seconds(clock, settings.quick, &mut methods);
    drop(methods);
    let series = Means::ALL
        .iter()
        .zip(times)
        .map(|(&way, time)| {
            let point = Point { setting: "five columns".to_owned(), x: 1e6 * time, y: error(&of(way), &known) };
            Series { method: way.name().to_owned(), points: vec![point] }
        })
        .collect();
    Ok(Diagram {
        title: "five columns at 2294 readings".to_owned(),
        x_label: "time / µs".to_owned(),
        y_label: "relative error of the worst column".to_owned(),
        y_in_powers: true,
        series,
    })
}
