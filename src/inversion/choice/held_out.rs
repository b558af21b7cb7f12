//! Prediction of readings that a fit did not see.
//!
//! Each curve is cut into runs of neighbours, and the runs are dealt to [`FOLDS`] folds. A curve is smooth: with one
//! reading left out its neighbours tell it, whatever the model, and an error of the model that both share is repaid as a
//! success. A run of neighbours must be told by the model.
//!
//! The runs of a fold are left out, the others fitted again from the minimum of all, and each reading left out is scored
//! by its deviance, -2 log of its predictive density:
//!
//! ```text
//! sigma stated       rho(r_i)
//! sigma not stated   rho(r_i) / s² + ln s²,   s² = scatter of the readings fitted
//! ```

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::outcome::Fit;
use crate::inversion::problem::Problem;
use crate::inversion::search::FINE;
use crate::inversion::undetermined::unit_of_residuals;
use crate::optimise::minimise;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

/// Parts that the readings are dealt to, each left out once.
pub const FOLDS: usize = 5;
/// Runs that a curve gives to each fold, if it has the readings.
const RUNS_OF_A_FOLD: usize = 2;

/// Runs of neighbouring readings.
#[derive(Debug, Clone)]
pub(crate) struct Runs {
    /// Run of each reading.
    run: Vec<usize>,
    /// Fold of each run.
    fold: Vec<usize>,
}

impl Runs {
    /// Cuts the curves of `data`, in the order of the file.
    pub(crate) fn new(data: &Dataset) -> Self {
        let mut sizes = vec![0; data.curves().len()];
        for reading in data.readings() {
            sizes[reading.curve] += 1;
        }
        let runs = |size: usize| size.min(FOLDS * RUNS_OF_A_FOLD);
        let mut first = Vec::with_capacity(sizes.len());
        let mut fold = Vec::new();
        for (curve, &size) in sizes.iter().enumerate() {
            first.push(fold.len());
            // Curves of few readings begin with another fold each.
            fold.extend((0..runs(size)).map(|run| (curve + run) % FOLDS));
        }
        let mut passed = vec![0; sizes.len()];
        let run = (data.readings().iter())
            .map(|reading| {
                let (size, place) = (sizes[reading.curve], passed[reading.curve]);
                passed[reading.curve] += 1;
                first[reading.curve] + place * runs(size) / size.max(1)
            })
            .collect();
        Self { run, fold }
    }
}

/// Deviance of each run when it is left out; `None` if a fold leaves too little to fit or has no finite prediction.
pub(crate) fn deviances(compiled: &Compiled<'_>, fit: &Fit, runs: &Runs) -> Option<Vec<f64>> {
    let folds: Option<Vec<Vec<f64>>> =
        (0..FOLDS).into_par_iter().map(|fold| of_fold(compiled, fit, runs, fold)).collect();
    let mut sums = vec![0.0; runs.fold.len()];
    for (row, &run) in runs.run.iter().enumerate() {
        sums[run] += folds.as_ref()?.get(runs.fold[run])?.get(row)?;
    }
    sums.iter().all(|sum| sum.is_finite()).then_some(sums)
}

/// Deviance of each reading of `fold`, 0 for those that were fitted.
fn of_fold(compiled: &Compiled<'_>, fit: &Fit, runs: &Runs, fold: usize) -> Option<Vec<f64>> {
    let (solution, loss) = (&fit.solution, compiled.settings.loss);
    let left_out: Vec<bool> = runs.run.iter().map(|&run| runs.fold[run] == fold).collect();
    // A weight of 0 takes a reading out of the fit and leaves its prediction in the plan.
    let robust = |row: usize| solution.robust.get(row).copied().unwrap_or(1.0);
    let weights: Vec<f64> =
        left_out.iter().enumerate().map(|(row, &out)| if out { 0.0 } else { robust(row) }).collect();
    let unknowns = compiled.plan.len().saturating_sub(fit.outcome.dof);
    let fitted = left_out.iter().filter(|out| !**out).count();
    let dof = fitted.checked_sub(unknowns).filter(|dof| *dof > 0)?;
    let problem = Problem::new(compiled, &solution.space, &weights);
    let found = minimise(&problem, &solution.best.parameters, FINE);
    let point = problem.evaluate(&found.parameters)?;
    let scale = solution.robust_unit;
    let residuals = problem.plain_residuals(&point);
    let costs: Vec<f64> = residuals.iter().map(|residual| scale * scale * loss.rho(residual / scale)).collect();
    let seen = costs.iter().zip(&left_out).filter(|(_, out)| !**out).map(|(cost, _)| cost).sum();
    let square = unit_of_residuals(compiled.data, seen, dof).powi(2);
    let deviance = |(cost, out): (&f64, &bool)| if *out { cost / square + square.ln() } else { 0.0 };
    Some(costs.iter().zip(&left_out).map(deviance).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::fit::fit;
    use crate::inversion::nuisance::{Extent, Nuisances, Weight};
    use crate::inversion::parameter::{Parameter, Role, values};
    use crate::inversion::settings::FitSettings;
    use crate::optics::{BlendModel, Structure};
    use crate::synthetic::{Scan, simulate};
    use approx::assert_relative_eq;

    fn blue() -> Dataset {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.02, 3).unwrap()
    }

    #[test]
    fn every_curve_gives_two_runs_of_neighbours_to_every_fold() {
        let data = blue();
        let runs = Runs::new(&data);
        assert_eq!(runs.fold.len(), 4 * 2 * FOLDS);
        for fold in 0..FOLDS {
            assert_eq!(runs.fold.iter().filter(|&&own| own == fold).count(), 8);
        }
        // 37 and 49 readings in ten runs each.
        let count = |run: usize| runs.run.iter().filter(|&&own| own == run).count();
        assert!((0..runs.fold.len()).all(|run| (3..=5).contains(&count(run))));
        assert!(runs.run.windows(2).all(|pair| pair[1] == pair[0] || pair[1] == pair[0] + 1));
    }

    /// What is left out and how it is predicted, against the closed form of a straight line through the origin.
    #[test]
    fn a_scale_alone_predicts_as_the_closed_form_says() {
        let data = blue();
        let truth = values(&Structure::blue());
        let roles = Parameter::ALL.map(|parameter| Role::Fixed { value: truth[parameter.index()] });
        let nuisances = Nuisances { scale: Extent::Shared, weight: Weight::Fixed(1.0), background: Extent::None };
        let settings = FitSettings { roles, nuisances, ..FitSettings::default() };
        let found = fit(&data, &settings, &|_| {}).unwrap();
        let model = settings.forward().unwrap();
        let compiled = Compiled::new(&data, &settings, model.as_ref()).unwrap();
        let runs = Runs::new(&data);
        let whole: f64 = deviances(&compiled, &found, &runs).unwrap().iter().sum();

        let (mut expected, scale) = (0.0, found.outcome.nuisance[0].value);
        let x: Vec<f64> = found.readings.iter().map(|fitted| fitted.model / scale).collect();
        let y: Vec<f64> = data.readings().iter().map(|reading| reading.intensity).collect();
        let sigma = data.readings()[0].sigma.unwrap();
        for fold in 0..FOLDS {
            let seen = |&row: &usize| runs.fold[runs.run[row]] != fold;
            let (xy, xx) = (0..y.len()).filter(seen).fold((0.0, 0.0), |s, i| (s.0 + x[i] * y[i], s.1 + x[i] * x[i]));
            let out = (0..y.len()).filter(|row| !seen(row));
            expected += out.map(|i| ((y[i] - xy / xx * x[i]) / sigma).powi(2)).sum::<f64>();
        }
        assert_relative_eq!(whole, expected, max_relative = 1e-9);
        assert!(whole > found.outcome.chi2, "readings that were seen are met better");
    }
}
