//! The inverse problem: from a measured data set to the structure that made it. The one join of optics, data and optimiser.

mod choice;
mod compiled;
mod estimates;
mod fit;
mod nuisance;
mod outcome;
mod parameter;
mod plan;
mod problem;
mod search;
mod settings;
mod solution;
mod space;
mod summary;
mod undetermined;
mod wording;

pub use choice::{Choice, ChoiceFound, Criterion, FOLDS, Standing, VariantFound, choose};
pub use fit::{FitError, fit};
pub use nuisance::{Extent, Nuisances, Weight};
pub use outcome::{
    DataFound, Derived, Estimate, Fit, FitOutcome, FittedReading, IdentifiabilityFound, MinimumFound, NamedMatrix,
    NuisanceFound, Parameters, SCHEMA, SigmaSource, Status, Verdict,
};
pub use parameter::{COUNT, Parameter, Role, structure, values};
pub use plan::Plan;
pub use settings::{FitSettings, ModelChoice, Parts, Search, SettingsError};
