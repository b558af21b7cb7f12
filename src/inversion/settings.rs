//! The choices of a fit, checked and complete: together with the data they give the same result to the last bit.

use crate::inversion::nuisance::{Nuisances, Weight};
use crate::inversion::parameter::{COUNT, Parameter, Role};
use crate::optics::{
    Admittance, AveragedModel, Averages, BlendModel, HybridModel, LamellaUnit, OpticsError, PaperModel,
    ReflectivityModel, Snell, Stack,
};
use crate::optimise::Loss;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which forward model, with its choices.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "name")]
pub enum ModelChoice {
    /// The paper's structure with its physics put right.
    #[default]
    Blend,
    /// Both planes as one product.
    Hybrid {
        /// Distance of the ridges, nm.
        ridge_spacing: f64,
    },
    /// The printed formulas.
    Paper {
        /// Which way up Snell's law is.
        snell: Snell,
        /// How the polarizations are joined.
        admittance: Admittance,
        /// What Model A is divided by.
        lamella_unit: LamellaUnit,
    },
}

impl ModelChoice {
    /// The model for a stack.
    #[must_use]
    pub fn build(self, stack: Stack) -> Box<dyn ReflectivityModel> {
        match self {
            Self::Blend => Box::new(BlendModel { stack }),
            Self::Hybrid { ridge_spacing } => Box::new(HybridModel { stack, ridge_spacing }),
            Self::Paper { snell, admittance, lamella_unit } => {
                Box::new(PaperModel { stack, snell, admittance, lamella_unit })
            }
        }
    }
}

/// Which of the two parts of the model the light comes from.
///
/// A part that is left out reflects nothing, and the parameters of it alone do nothing: `delta` and `phi_alpha` without
/// the multilayer, `lamella_width` without the lamellae.
///
/// ```
/// use morpho_fit::inversion::Parts;
/// assert_eq!(Parts::Multilayer.shares((0.25, 0.75)), (0.0, 0.75));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parts {
    /// Model A and Model B.
    #[default]
    Both,
    /// Model A alone: diffraction by the lamellae.
    Lamella,
    /// Model B alone: the tilted and curved multilayer.
    Multilayer,
}

impl Parts {
    /// The shares `(cos² omega, sin² omega)` of a reading's plane in A and in B, 0 for a part that is left out.
    #[must_use]
    pub fn shares(self, (lamella, multilayer): (f64, f64)) -> (f64, f64) {
        match self {
            Self::Both => (lamella, multilayer),
            Self::Lamella => (lamella, 0.0),
            Self::Multilayer => (0.0, multilayer),
        }
    }
}

/// Where the search for the minimum begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Search {
    /// A grid over the bounds and the start, if one is given.
    #[default]
    Global,
    /// The start alone: quick, and blind to every other minimum.
    Local,
}

/// How stack and lamellae are differentiated by thicknesses, tilt and width.
///
/// The lobe costs little and is differentiated by central differences in either case.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Derivative {
    /// The formulas, differentiated, where the model has them: real indices and waves that travel; differences elsewhere.
    #[default]
    Exact,
    /// Central differences.
    FiniteDifference,
}

/// Everything that a fit is told beside the data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitSettings {
    /// The forward model.
    pub model: ModelChoice,
    /// Which of its two parts are there.
    #[serde(default)]
    pub parts: Parts,
    /// Media and layer count.
    pub stack: Stack,
    /// What each of the five parameters may do, in the order of [`Parameter::ALL`].
    pub roles: [Role; COUNT],
    /// A start for the free ones, inside units; where one is missing the middle of its bounds stands in.
    pub start: [Option<f64>; COUNT],
    /// Scale, weight, background.
    pub nuisances: Nuisances,
    /// How outliers count.
    pub loss: Loss,
    /// Where the search begins.
    pub search: Search,
    /// What a reading is averaged over.
    #[serde(default, skip_serializing_if = "Averages::is_none")]
    pub averages: Averages,
    /// How the model is differentiated.
    #[serde(default)]
    pub derivative: Derivative,
    /// A minimum within this Δchi² of the best, in units of the squared standard deviation of a weighted residual, fits as
    /// well: 9 is three standard deviations of one parameter.
    #[serde(default = "level")]
    pub level: f64,
    /// Seed of the random starts that stand beside the grid.
    pub seed: u64,
    /// Parameters that the user asked for by name: it is a failure if one of them is not determined.
    pub required: Vec<Parameter>,
}

fn level() -> f64 {
    9.0
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            model: ModelChoice::default(),
            parts: Parts::default(),
            stack: Stack::default(),
            roles: Parameter::ALL.map(|parameter| {
                let (lower, upper) = parameter.default_bounds();
                Role::Free { lower, upper }
            }),
            start: [None; COUNT],
            nuisances: Nuisances::default(),
            loss: Loss::default(),
            search: Search::default(),
            averages: Averages::default(),
            derivative: Derivative::default(),
            level: level(),
            seed: 1,
            required: Vec::new(),
        }
    }
}

/// A hint for a number of radians that is more like one of degrees.
fn in_degrees(unit: &str, value: f64) -> String {
    let is_likely = unit == "rad" && (PI..=180.0).contains(&value);
    if is_likely { format!(": {value} degrees are {:.4} rad", value.to_radians()) } else { String::new() }
}

/// A set of choices that cannot be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Bounds without room between them, or beyond the parameter's domain; user units.
    #[error("bounds of {parameter}: {lower} to {upper} {unit} must rise and lie within {least} to {most} {unit}{}", in_degrees(unit, *upper))]
    Bounds {
        /// Which parameter.
        parameter: Parameter,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
        /// Its unit.
        unit: &'static str,
        /// Least value that makes sense.
        least: f64,
        /// Largest value that makes sense.
        most: f64,
    },
    /// A value or start outside what is allowed; user units.
    #[error("{what} of {parameter}: {found} {unit} is not within {least} to {most} {unit}{}", in_degrees(unit, *found))]
    Value {
        /// `fixed value` or `start`.
        what: &'static str,
        /// Which parameter.
        parameter: Parameter,
        /// What was given.
        found: f64,
        /// Its unit.
        unit: &'static str,
        /// Least allowed value.
        least: f64,
        /// Largest allowed value.
        most: f64,
    },
    /// A link to a parameter that is itself linked, or to itself.
    #[error("{parameter} cannot be linked to {other}, which is itself linked")]
    Link {
        /// The linked parameter.
        parameter: Parameter,
        /// What it should follow.
        other: Parameter,
    },
    /// A level of Δchi² that is no number of at least 0.
    #[error("the level of delta chi² is {found}; it must be a finite number, at least 0")]
    Level {
        /// What was given.
        found: f64,
    },
    /// A choice about the terms of a sum, for a model that is one product.
    #[error("the `hybrid` model is one product of lamellae and multilayer: {what}; leave it out")]
    OneProduct {
        /// What cannot be, in words.
        what: &'static str,
    },
    /// A lamella width beyond what the `hybrid` model has room for.
    #[error("lamella_width may be {widest} nm, but the ridges are {ridge_spacing} nm apart: it must be at most that")]
    WiderThanRidges {
        /// Largest width that was given, nm.
        widest: f64,
        /// Distance of the ridges, nm.
        ridge_spacing: f64,
    },
    /// A weight of Model A that is no number of at least 0.
    #[error("the weight of Model A is {found}; it must be a finite number, at least 0")]
    Weight {
        /// What was given.
        found: f64,
    },
}

impl FitSettings {
    /// The forward model: that of the choice for the stack, averaged if it is.
    ///
    /// # Errors
    /// [`OpticsError::OutOfRange`] for an average out of range.
    pub fn forward(&self) -> Result<Box<dyn ReflectivityModel>, OpticsError> {
        let model = self.model.build(self.stack.clone());
        if self.averages.is_none() { Ok(model) } else { Ok(Box::new(AveragedModel::new(model, self.averages)?)) }
    }

    /// Checks every role, start and number.
    ///
    /// # Errors
    /// [`SettingsError`] with the first choice that cannot be.
    pub fn validate(&self) -> Result<(), SettingsError> {
        for (parameter, role) in Parameter::ALL.into_iter().zip(&self.roles) {
            let domain = parameter.domain();
            let (least, most, unit) = (parameter.outside(domain.0), parameter.outside(domain.1), parameter.unit());
            let value = |what, found: f64, (lower, upper): (f64, f64)| {
                if (lower..=upper).contains(&found) {
                    return Ok(());
                }
                let (found, least, most) =
                    (parameter.outside(found), parameter.outside(lower), parameter.outside(upper));
                Err(SettingsError::Value { what, parameter, found, unit, least, most })
            };
            match *role {
                Role::Free { lower, upper } => {
                    let rises = lower < upper && lower >= domain.0 && upper <= domain.1;
                    if !rises {
                        let (lower, upper) = (parameter.outside(lower), parameter.outside(upper));
                        return Err(SettingsError::Bounds { parameter, lower, upper, unit, least, most });
                    }
                    if let Some(start) = self.start[parameter.index()] {
                        value("start", start, (lower, upper))?;
                    }
                }
                Role::Fixed { value: fixed } => value("fixed value", fixed, domain)?,
                Role::Linked { other, factor, constant } => {
                    if other == parameter || matches!(self.roles[other.index()], Role::Linked { .. }) {
                        return Err(SettingsError::Link { parameter, other });
                    }
                    value("link's factor", factor, (-1e9, 1e9))?;
                    value("link's constant", constant, (-1e9, 1e9))?;
                }
            }
        }
        if let ModelChoice::Hybrid { ridge_spacing } = self.model {
            if self.nuisances.weight != Weight::Fitted {
                return Err(SettingsError::OneProduct { what: "a weight of one beside the other has no meaning" });
            }
            if self.parts != Parts::Both {
                return Err(SettingsError::OneProduct { what: "neither of its parts can be there alone" });
            }
            let widest = match self.roles[Parameter::LamellaWidth.index()] {
                Role::Free { upper, .. } => upper,
                Role::Fixed { value } => value,
                Role::Linked { .. } => 0.0,
            };
            if widest > ridge_spacing {
                return Err(SettingsError::WiderThanRidges { widest, ridge_spacing });
            }
        }
        if let Weight::Fixed(found) = self.nuisances.weight
            && !(found.is_finite() && found >= 0.0)
        {
            return Err(SettingsError::Weight { found });
        }
        if !(self.level.is_finite() && self.level >= 0.0) {
            return Err(SettingsError::Level { found: self.level });
        }
        Ok(())
    }

    /// The same choices for another model, with the bounds and start of a free `lamella_width` cut to the room that the
    /// `hybrid` model has between its ridges.
    ///
    /// # Errors
    /// [`SettingsError`] where the choices mean nothing to that model: a given weight, a part alone, a lamella wider than the
    /// distance of the ridges.
    ///
    /// ```
    /// use morpho_fit::inversion::{FitSettings, ModelChoice, Role};
    /// let hybrid = FitSettings::default().for_model(ModelChoice::Hybrid { ridge_spacing: 500.0 })?;
    /// assert_eq!(hybrid.roles[4], Role::Free { lower: 100.0, upper: 500.0 });
    /// # Ok::<(), morpho_fit::inversion::SettingsError>(())
    /// ```
    pub fn for_model(&self, model: ModelChoice) -> Result<Self, SettingsError> {
        let mut settings = Self { model, ..self.clone() };
        let width = Parameter::LamellaWidth.index();
        if let (ModelChoice::Hybrid { ridge_spacing }, Role::Free { lower, upper }) =
            (model, &mut settings.roles[width])
            && ridge_spacing > *lower
        {
            *upper = upper.min(ridge_spacing);
            settings.start[width] = settings.start[width].map(|start| start.min(ridge_spacing));
        }
        settings.validate()?;
        Ok(settings)
    }

    /// Sets the role of one parameter.
    #[must_use]
    pub fn with_role(mut self, parameter: Parameter, role: Role) -> Self {
        self.roles[parameter.index()] = role;
        self
    }
}
