//! Residuals and Jacobian of a fit, for optimisers and samplers of others.

use crate::dataset::Dataset;
use crate::inversion::fit::FitError;
use crate::inversion::nuisance::LinearPart;
use crate::inversion::parameter::Parameter;
use crate::inversion::plan::Plan;
use crate::inversion::problem::Problem;
use crate::inversion::settings::{Derivative, FitSettings, SettingsError};
use crate::inversion::space::Space;
use crate::optics::ReflectivityModel;
use crate::optimise::LeastSquares;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// What a fit minimises, over its free parameters: weighted residuals with scale, weight and background eliminated.
///
/// ```text
/// r_i(p) = (model_i(p, c) - y_i) / sigma_i,   c = best non-negative nuisances at p;   sigma_i = 1 where none is stated
/// ```
///
/// A robust loss has no say here: residuals are those of least squares. Compiled once; any number of threads may ask it.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, Objective};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, blue) = (BlendModel::default(), Structure::blue());
/// let data = simulate(&model, &blue, &Scan::full_design(&model, &blue)?, 1.0, 0.0, 1)?;
/// let objective = Objective::new(&data, &FitSettings::default())?;
/// let truth = [blue.d_air, blue.d_cuticle, blue.delta, blue.phi_alpha, blue.lamella_width];
/// assert!(objective.residuals(&truth)?.norm() < 1e-9);
/// assert_eq!(objective.jacobian(&truth)?.ncols(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Objective {
    plan: Plan<'static>,
    linear: LinearPart,
    space: Space,
    derivative: Derivative,
}

impl Objective {
    /// Compiles `data` for `settings`.
    ///
    /// # Errors
    /// [`FitError`] for settings that cannot be fitted, or data for which the model has no value.
    pub fn new(data: &Dataset, settings: &FitSettings) -> Result<Self, FitError> {
        settings.validate()?;
        let model: Arc<dyn ReflectivityModel> = settings.forward()?.into();
        let mut plan = Plan::new(data, model.as_ref(), settings.parts)?.keeping(Arc::clone(&model));
        let linear = LinearPart::new(&settings.nuisances, &plan);
        plan.arrange(&linear.alike());
        Ok(Self { linear, plan, space: Space::new(&settings.roles)?, derivative: settings.derivative })
    }

    /// The free parameters, in the order of every point.
    #[must_use]
    pub fn free(&self) -> &[Parameter] {
        &self.space.freedom.free
    }

    /// Lower and upper bounds of the free parameters, inside units.
    #[must_use]
    pub fn bounds(&self) -> (&DVector<f64>, &DVector<f64>) {
        (self.space.bounds.lower(), self.space.bounds.upper())
    }

    /// Number of residuals.
    #[must_use]
    pub fn len(&self) -> usize {
        self.plan.len()
    }

    /// Whether there are no residuals: never, for a data set has a reading.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.plan.is_empty()
    }

    /// The weighted residuals `[m]` at a point of free parameters, inside units.
    ///
    /// # Errors
    /// [`FitError`] for a point of another dimension or outside what makes sense, or where the model has no value.
    pub fn residuals(&self, point: &[f64]) -> Result<DVector<f64>, FitError> {
        let found = self.problem().residuals(&self.checked(point)?);
        if found.iter().all(|residual| residual.is_finite()) { Ok(found) } else { Err(self.nowhere()) }
    }

    /// Their derivatives `[m, n]` by the free parameters, inside units, in Kaufman's form: those at fixed nuisances less their
    /// projection on the linear columns. With the residuals it gives the exact gradient of chi²/2.
    ///
    /// # Errors
    /// As [`Objective::residuals`].
    pub fn jacobian(&self, point: &[f64]) -> Result<DMatrix<f64>, FitError> {
        let found = self.problem().jacobian(&self.checked(point)?);
        if found.iter().all(|slope| slope.is_finite()) { Ok(found) } else { Err(self.nowhere()) }
    }

    fn problem(&self) -> Problem<'_> {
        Problem::of_parts(&self.plan, &self.linear, &self.space, &[], self.derivative)
    }

    fn nowhere(&self) -> FitError {
        FitError::NotFinite { model: self.plan.model_name() }
    }

    fn checked(&self, point: &[f64]) -> Result<DVector<f64>, FitError> {
        let (found, expected) = (point.len(), self.free().len());
        if found != expected {
            return Err(FitError::Point { found, expected });
        }
        for (&parameter, &value) in self.free().iter().zip(point) {
            let (lower, upper) = parameter.domain();
            if !(lower..=upper).contains(&value) {
                let [found, least, most] = [value, lower, upper].map(|value| parameter.outside(value));
                let (what, unit) = ("value", parameter.unit());
                return Err(SettingsError::Value { what, parameter, found, unit, least, most }.into());
            }
        }
        Ok(DVector::from_column_slice(point))
    }
}
