//! Why a run ended.

use serde::{Deserialize, Serialize};

/// Why a minimisation ended: data, not an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Termination {
    /// The next step lowers the cost by no share that matters: it was tried, or its promise is too small to try it.
    CostConverged,
    /// The region in which the solver trusts its model is smaller than a step that matters.
    StepConverged,
    /// The residuals are orthogonal to every derivative.
    GradientConverged,
    /// Every residual is zero to rounding.
    ExactFit,
    /// The slope does not vanish, but no neighbour is lower by what matters: a minimum on a kink of the model.
    Kink,
    /// The minimum lies on a flat plateau: some parameter or combination does nothing there, so where the solver
    /// stopped along it means nothing.
    Flat,
    /// No step lowers the cost although the gradient says that one should.
    Stalled,
    /// The residuals at the start are not finite.
    StartNotFinite,
    /// There are fewer residuals than parameters.
    Underdetermined,
    /// The budget of evaluations is spent.
    EvaluationBudget,
}

impl Termination {
    /// Whether the run ended in a minimum.
    #[must_use]
    pub fn was_successful(self) -> bool {
        matches!(
            self,
            Self::CostConverged | Self::StepConverged | Self::GradientConverged | Self::ExactFit | Self::Kink
        )
    }

    /// The reason as a phrase for a report.
    #[must_use]
    pub fn phrase(self) -> &'static str {
        match self {
            Self::CostConverged => "the cost no longer falls",
            Self::StepConverged => "the step is below its tolerance",
            Self::GradientConverged => "the gradient is zero",
            Self::ExactFit => "the data are met exactly",
            Self::Kink => "no neighbour is lower: a minimum on a kink of the model",
            Self::Flat => "the minimum is flat: a parameter does nothing there",
            Self::Stalled => "no step lowers the cost",
            Self::StartNotFinite => "the model has no finite value at the start",
            Self::Underdetermined => "there are fewer readings than parameters",
            Self::EvaluationBudget => "the evaluation budget is spent",
        }
    }
}
