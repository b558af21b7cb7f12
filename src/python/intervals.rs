//! Intervals beside the covariance: profiles, samples of the posterior, replicates of the bootstrap.

use super::errors::{of_fit, unfit};
use super::patience::patiently;
use super::settings::Keywords;
use super::words::choose;
use crate::dataset::Dataset;
use crate::inversion::intervals::{
    self, BootstrapSettings, PosteriorSettings, QuantityProfile, Resampling, bootstrap, compare, posterior, profiles,
};
use crate::inversion::{Fit, FitError, Verdict};
use crate::optimise::Loss;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

/// Least and largest number of replicates, effective samples and evaluations: those of the command.
const COUNTS: std::ops::RangeInclusive<usize> = 100..=100_000_000;

/// Methods that a fit is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Methods {
    profile: bool,
    bootstrap: bool,
    sample: bool,
    all: bool,
    replicates: usize,
    effective: usize,
    max_evaluations: usize,
}

/// A count as the command allows it.
pub(crate) fn count(name: &str, found: usize) -> PyResult<usize> {
    if COUNTS.contains(&found) {
        Ok(found)
    } else {
        Err(unfit(format!("{name} is {found}; it must be 100 to 100000000")))
    }
}

impl Methods {
    /// Takes its keywords.
    pub(crate) fn take(keywords: &mut Keywords<'_>) -> PyResult<Self> {
        let words = keywords.take::<Vec<String>>("uncertainty")?.unwrap_or_default();
        let known = ["covariance", "profile", "bootstrap", "sample", "all"].map(|word| (word, word));
        let words = words.iter().map(|word| choose("uncertainty", word, &known)).collect::<PyResult<Vec<_>>>()?;
        let all = words.contains(&"all");
        let mut number = |name, usual| count(name, keywords.take(name)?.unwrap_or(usual));
        Ok(Self {
            profile: all || words.contains(&"profile"),
            bootstrap: all || words.contains(&"bootstrap"),
            sample: all || words.contains(&"sample"),
            all,
            replicates: number("replicates", 1000)?,
            effective: number("effective", 4000)?,
            max_evaluations: number("max_evaluations", 400_000)?,
        })
    }

    /// Asks the methods and puts what they say beside each other into the outcome, as the command does.
    pub(crate) fn add_to(
        self,
        data: &Dataset,
        fit: &mut Fit,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<(), FitError> {
        let told = fit.outcome.parameters.each().into_iter().any(|(_, estimate)| estimate.sigma.is_some());
        let answered = fit.outcome.verdict != Verdict::NotConverged && told;
        if !(self.profile || self.bootstrap || self.sample) || !answered {
            return Ok(());
        }
        let seed = fit.outcome.seed;
        let profiles = self.profile.then(|| profiles(data, fit, progress)).transpose()?;
        let mut bootstraps = Vec::new();
        if self.bootstrap && !(self.all && fit.outcome.settings.loss != Loss::Linear) {
            for resampling in [Resampling::Residuals, Resampling::Cases] {
                let settings =
                    BootstrapSettings { replicates: self.replicates, ..BootstrapSettings::new(resampling, seed) };
                bootstraps.push(bootstrap(data, fit, &settings, progress)?);
            }
        }
        let settings = PosteriorSettings { effective: self.effective, max_evaluations: self.max_evaluations, seed };
        let posterior = self.sample.then(|| posterior(data, fit, &settings, progress)).transpose()?;
        let found = compare(fit, profiles.as_ref(), &bootstraps, posterior.as_ref());
        fit.outcome.uncertainty = Some(found);
        Ok(())
    }
}

fn table<'py>(py: Python<'py>, rows: &[Vec<f64>], columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat = rows.iter().flatten().copied().collect();
    let shaped = Array2::from_shape_vec((rows.len(), columns), flat).map_err(|error| unfit(error.to_string()))?;
    Ok(shaped.into_pyarray(py))
}

/// The profile likelihood of one quantity, user units.
#[pyclass(frozen, module = "morpho_fit")]
#[derive(Debug)]
pub(crate) struct ProfileFound {
    found: QuantityProfile,
}

impl ProfileFound {
    pub(crate) fn of(found: QuantityProfile) -> Self {
        Self { found }
    }
}

#[pymethods]
impl ProfileFound {
    /// Name of the quantity, as in fit.json.
    #[getter]
    fn name(&self) -> &'static str {
        self.found.name
    }

    /// nm, deg or rad.
    #[getter]
    fn unit(&self) -> &'static str {
        self.found.unit
    }

    /// Best value.
    #[getter]
    fn best(&self) -> f64 {
        self.found.best
    }

    /// Values [n] of the quantity, rising.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.found.values.clone().into_pyarray(py)
    }

    /// Delta chi² [n] at each, in units of the squared standard deviation of a weighted residual.
    #[getter]
    fn delta_chi2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.found.excess.clone().into_pyarray(py)
    }

    /// The five parameters [n, 5] at each.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<Vec<f64>> = self.found.parameters.iter().map(|row| row.to_vec()).collect();
        table(py, &rows, crate::inversion::COUNT)
    }

    /// Interval of 68.3 %; an end at a bound is None.
    #[getter]
    fn interval_68(&self) -> (Option<f64>, Option<f64>) {
        self.found.intervals.interval_68.into()
    }

    /// Interval of 95 %.
    #[getter]
    fn interval_95(&self) -> (Option<f64>, Option<f64>) {
        self.found.intervals.interval_95.into()
    }

    fn __repr__(&self) -> String {
        format!("<Profile of {}: {} points>", self.found.name, self.found.values.len())
    }
}

/// Samples of the posterior, user units.
#[pyclass(frozen, module = "morpho_fit")]
#[derive(Debug)]
pub(crate) struct Posterior {
    found: intervals::Posterior,
    /// Largest split R-hat of a quantity; None if one does not move.
    #[pyo3(get)]
    r_hat: Option<f64>,
    /// Smallest effective sample size of a quantity, in bulk or tails.
    #[pyo3(get)]
    effective: Option<f64>,
}

impl Posterior {
    pub(crate) fn of(found: intervals::Posterior, fit: &Fit) -> Self {
        let how = compare(fit, None, &[], Some(&found)).posterior;
        let (r_hat, effective) = how.map_or((None, None), |how| (how.r_hat, how.effective));
        Self { found, r_hat, effective }
    }
}

#[pymethods]
impl Posterior {
    /// Names of the quantities, as in fit.json.
    #[getter]
    fn names(&self) -> Vec<&'static str> {
        self.found.names.clone()
    }

    /// Their units.
    #[getter]
    fn units(&self) -> Vec<&'static str> {
        self.found.units.clone()
    }

    /// Samples [sample, quantity]; the steps of the first chain, then the second's, ...
    #[getter]
    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, &self.found.samples, self.found.names.len())
    }

    /// Chains, of equal length.
    #[getter]
    fn chains(&self) -> usize {
        self.found.chains
    }

    /// Whether the chains agree and are worth the samples asked for.
    #[getter]
    fn converged(&self) -> bool {
        self.found.converged
    }

    /// Share of the posterior about each minimum of the fit, in their order.
    #[getter]
    fn weights(&self) -> Vec<f64> {
        self.found.weights.clone()
    }

    /// Evaluations of the model.
    #[getter]
    fn evaluations(&self) -> usize {
        self.found.evaluations
    }

    /// Credible intervals of 68.3 % by name; an end at a bound is None.
    #[getter]
    fn intervals_68(&self) -> Vec<(Option<f64>, Option<f64>)> {
        self.found.intervals.iter().map(|pair| pair.interval_68.into()).collect()
    }

    /// Credible intervals of 95 %.
    #[getter]
    fn intervals_95(&self) -> Vec<(Option<f64>, Option<f64>)> {
        self.found.intervals.iter().map(|pair| pair.interval_95.into()).collect()
    }

    fn __repr__(&self) -> String {
        format!("<Posterior: {} samples of {}>", self.found.samples.len(), self.found.names.join(", "))
    }
}

/// The replicates of one bootstrap.
pub(crate) fn bootstraps_of<'py>(
    py: Python<'py>,
    data: &Dataset,
    fit: &Fit,
    resampling: &str,
    replicates: usize,
    seed: u64,
) -> PyResult<(Vec<&'static str>, Bound<'py, PyArray2<f64>>)> {
    let kinds = [("residuals", Resampling::Residuals), ("cases", Resampling::Cases)];
    let resampling = choose("resampling", resampling, &kinds)?;
    let settings = BootstrapSettings { resampling, replicates: count("replicates", replicates)?, seed };
    let found = patiently(py, |progress| bootstrap(data, fit, &settings, progress))?;
    let found = found.map_err(|error| of_fit(py, &error))?;
    let samples = table(py, &found.replicates, found.names.len())?;
    Ok((found.names, samples))
}
