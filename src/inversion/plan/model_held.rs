//! The model of a plan: lent for the time of a fit, or kept by a plan that outlives it.

use super::Plan;
use crate::optics::ReflectivityModel;
use std::ops::Deref;
use std::sync::Arc;

/// A forward model, lent or kept.
#[derive(Debug, Clone)]
pub(super) enum ModelHeld<'a> {
    Lent(&'a dyn ReflectivityModel),
    Kept(Arc<dyn ReflectivityModel>),
}

impl<'a> Deref for ModelHeld<'a> {
    type Target = dyn ReflectivityModel + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Lent(model) => *model,
            Self::Kept(model) => model.as_ref(),
        }
    }
}

impl Plan<'_> {
    /// Name of the model.
    pub(crate) fn model_name(&self) -> &'static str {
        self.model.name()
    }

    /// The same plan with its model kept in it; `model` is that for which it was compiled.
    pub(crate) fn keeping(self, model: Arc<dyn ReflectivityModel>) -> Plan<'static> {
        Plan { model: ModelHeld::Kept(model), points: self.points, rows: self.rows, curves: self.curves }
    }
}
