//! Data and choices compiled once for all that is asked of them.

use crate::dataset::Dataset;
use crate::inversion::fit::FitError;
use crate::inversion::nuisance::LinearPart;
use crate::inversion::outcome::Fit;
use crate::inversion::plan::Plan;
use crate::inversion::settings::FitSettings;
use crate::optics::{OpticsError, ReflectivityModel};

/// A data set, the choices of its fit, and what both compile to.
#[derive(Debug)]
pub(crate) struct Compiled<'a> {
    pub(crate) data: &'a Dataset,
    pub(crate) settings: &'a FitSettings,
    pub(crate) plan: Plan<'a>,
    pub(crate) linear: LinearPart,
}

impl<'a> Compiled<'a> {
    /// Compiles all readings.
    pub(crate) fn new(
        data: &'a Dataset,
        settings: &'a FitSettings,
        model: &'a dyn ReflectivityModel,
    ) -> Result<Self, OpticsError> {
        Ok(Self::of(data, settings, Plan::new(data, model, settings.parts)?))
    }

    /// Compiles about `limit` of the readings, evenly chosen.
    pub(crate) fn thinned(
        data: &'a Dataset,
        settings: &'a FitSettings,
        model: &'a dyn ReflectivityModel,
        limit: usize,
    ) -> Result<Self, OpticsError> {
        Ok(Self::of(data, settings, Plan::thinned(data, model, settings.parts, limit)?))
    }

    /// Compiles the data of a fit again.
    ///
    /// # Errors
    /// [`FitError::OtherData`] if there are not as many readings as were fitted.
    pub(crate) fn of_fit(data: &'a Dataset, fit: &'a Fit, model: &'a dyn ReflectivityModel) -> Result<Self, FitError> {
        let (readings, fitted) = (data.readings().len(), fit.readings.len());
        if readings != fitted {
            return Err(FitError::OtherData { readings, fitted });
        }
        Ok(Self::new(data, &fit.outcome.settings, model)?)
    }

    /// The same design with other intensities, one for each reading.
    pub(crate) fn with_intensities(&self, intensities: &[f64]) -> Self {
        let plan = self.plan.with_intensities(intensities);
        Self { data: self.data, settings: self.settings, plan, linear: self.linear.clone() }
    }

    /// Compiles the readings of `rows`.
    pub(crate) fn of_rows(
        data: &'a Dataset,
        settings: &'a FitSettings,
        model: &'a dyn ReflectivityModel,
        rows: &[usize],
    ) -> Result<Self, OpticsError> {
        Ok(Self::of(data, settings, Plan::of_rows(data, model, settings.parts, rows)?))
    }

    fn of(data: &'a Dataset, settings: &'a FitSettings, mut plan: Plan<'a>) -> Self {
        let linear = LinearPart::new(&settings.nuisances, &plan);
        plan.arrange(&linear.alike());
        Self { data, settings, plan, linear }
    }
}
