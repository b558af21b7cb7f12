//! Data and choices compiled once for all that is asked of them.

use crate::dataset::Dataset;
use crate::inversion::nuisance::LinearPart;
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

    fn of(data: &'a Dataset, settings: &'a FitSettings, plan: Plan<'a>) -> Self {
        let linear = LinearPart::new(&settings.nuisances, &plan);
        Self { data, settings, plan, linear }
    }
}
