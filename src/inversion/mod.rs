//! The inverse problem: from a measured data set to the structure that made it. The one join of optics, data and optimiser.

mod advice;
mod atlas;
mod beyond;
mod candidates;
mod choice;
mod combinations;
mod compiled;
mod conditional;
mod constant;
mod design;
mod elsewhere;
mod estimates;
mod fit;
mod fitter;
pub mod intervals;
mod jackknife;
mod marginal;
mod nuisance;
mod numbering;
mod objective;
mod outcome;
mod parameter;
mod plan;
mod prediction;
mod problem;
mod prospect;
mod quantity;
mod reach;
mod residuals;
mod rows;
mod screening;
mod search;
mod settings;
mod solution;
mod space;
mod summary;
mod truth;
mod undetermined;
mod warnings;
mod wording;

pub use advice::{AdviceError, AdviceFound, Ask, Proposal, SigmaExpected, SplitExpected, advise};
pub use atlas::{ChiSquareMap, Relation, chi_square_map};
pub use choice::{Choice, ChoiceFound, Criterion, FOLDS, Standing, VariantFound, choose};
pub use combinations::Combination;
#[cfg(feature = "tradeoff")]
pub(crate) use compiled::Compiled;
pub use constant::Constant;
pub use design::{DesignError, Elsewhere, Expected, expected};
pub use fit::{FitError, fit};
pub use fitter::Fitter;
pub use nuisance::{Extent, Nuisances, Weight};
pub use objective::Objective;
pub use outcome::{
    CurveResiduals, DataFound, Derived, Estimate, Fit, FitOutcome, FittedReading, IdentifiabilityFound, MinimumFound,
    NamedMatrix, NuisanceFound, Parameters, SCHEMA, SigmaSource, Status, Verdict,
};
pub use parameter::{COUNT, Parameter, Role, structure, values};
pub use plan::Plan;
pub use prediction::{Predicted, predict};
#[cfg(feature = "tradeoff")]
pub(crate) use problem::Problem;
pub use settings::{Derivative, FitSettings, ModelChoice, Parts, Search, SettingsError};
#[cfg(feature = "tradeoff")]
pub(crate) use space::Space;
