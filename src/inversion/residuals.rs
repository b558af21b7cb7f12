//! What the residuals of a fit look like: whether neighbours agree, over all and in each curve.

use crate::inversion::estimates::Found;
use crate::inversion::outcome::CurveResiduals;
use crate::numerics::dot::dot;
use crate::uncertainty::discrepancy::{ResidualTests, residual_tests};
use crate::uncertainty::goodness::excess;
use std::borrow::Cow;

/// A correlation beyond this counts as this: the rule for it has no limit.
const MOST_CORRELATED: f64 = 0.99;

/// Correlation of each residual with the next one of its curve.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Neighbours {
    pub(crate) value: f64,
    /// In units of its standard deviation for noise, `1/sqrt(pairs)`.
    pub(crate) deviations: f64,
}

impl Neighbours {
    /// Factor on standard deviations: of `n` readings so correlated only `n (1 - r)/(1 + r)` are independent.
    pub(crate) fn widening(&self) -> f64 {
        let r = self.value.min(MOST_CORRELATED);
        ((1.0 + r) / (1.0 - r)).sqrt()
    }
}

/// The residuals of each curve in the order of the data, over `unit`.
pub(crate) fn by_curve<'r>(found: &Found<'_>, residuals: &'r [f64], unit: f64) -> Vec<Cow<'r, [f64]>> {
    if found.plan.curves == 1 && unit.to_bits() == 1.0_f64.to_bits() {
        return vec![Cow::Borrowed(residuals)];
    }
    let mut curves: Vec<Vec<f64>> = vec![Vec::new(); found.plan.curves];
    for (planned, residual) in found.plan.readings().iter().zip(residuals) {
        curves[planned.curve].push(residual / unit);
    }
    curves.into_iter().map(Cow::Owned).collect()
}

/// The lag-1 autocorrelation of the residuals of all curves.
pub(crate) fn neighbours(curves: &[Cow<'_, [f64]>]) -> Neighbours {
    let squares: f64 = curves.iter().map(|own| dot(own, own)).sum();
    let products: f64 = curves.iter().map(|own| dot(own, own.get(1..).unwrap_or_default())).sum();
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let pairs = curves.iter().map(|own| own.len().saturating_sub(1)).sum::<usize>() as f64;
    let value = if squares > 0.0 { products / squares } else { 0.0 };
    Neighbours { value, deviations: value * pairs.sqrt() }
}

/// Tests of the residuals of each curve, with its number of readings.
pub(crate) fn tests_by_curve(curves: &[Cow<'_, [f64]>]) -> Vec<(ResidualTests, usize)> {
    curves.iter().map(|residuals| (residual_tests(residuals), residuals.len())).collect()
}

/// A curve that the model misses, and by how many times its noise.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MissedCurve {
    pub(crate) curve: usize,
    pub(crate) times: f64,
}

/// The curve whose chi² exceeds its number of readings most, if that is more than chance leaves to the worst of so many: with
/// `deviations` allowed to one curve, `sqrt(deviations² + 2 ln n)` to the worst of `n`.
pub(crate) fn worst_curve(tests: &[(ResidualTests, usize)], deviations: f64) -> Option<MissedCurve> {
    #[allow(clippy::cast_precision_loss, reason = "a count of curves is small")]
    let allowed = (deviations * deviations + 2.0 * (tests.len().max(1) as f64).ln()).sqrt();
    let each = tests.iter().map(|&(tests, readings)| excess(tests.chi2, readings));
    let (curve, worst) = each.enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (residuals, readings) = tests[curve];
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let times = (residuals.chi2 / readings as f64).sqrt();
    (worst > allowed).then_some(MissedCurve { curve, times })
}

pub(crate) fn curve_residuals(found: &Found<'_>, tests: &[(ResidualTests, usize)]) -> Vec<CurveResiduals> {
    (found.data.curves().iter().zip(tests))
        .map(|(curve, &(tests, readings))| {
            let ResidualTests { chi2, correlation, runs } = tests;
            CurveResiduals { curve: curve.clone(), readings, chi2, correlation, runs_z: runs }
        })
        .collect()
}
