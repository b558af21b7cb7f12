//! What a fit found, in the user's units, ready to be written as `fit.json`.

use crate::inversion::advice::AdviceFound;
use crate::inversion::atlas::Relation;
use crate::inversion::choice::ChoiceFound;
use crate::inversion::combinations::Combination;
use crate::inversion::intervals::UncertaintyFound;
use crate::inversion::settings::FitSettings;
use crate::inversion::solution::Solution;
use crate::optimise::Termination;
use serde::{Deserialize, Serialize};

/// Version of the layout of [`FitOutcome`]; raised when a field changes its meaning.
pub const SCHEMA: &str = "morpho-fit/fit/1";

/// What can be said of one parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Status {
    /// Determined.
    Ok,
    /// Was given, not fitted.
    Fixed,
    /// Follows another parameter.
    Linked,
    /// The best value lies on a bound, or moves with one that does: the data ask for more than the bounds allow.
    AtBound,
    /// Determined on one side only: its interval reaches a bound.
    OneSided,
    /// Determined, but almost only together with another parameter.
    Correlated,
    /// Another minimum with another value fits as well.
    Ambiguous,
    /// Nothing in the data depends on it.
    Insensitive,
    /// Enters the data only in a combination with others, or weaker than the noise.
    NotIdentifiable,
}

impl Status {
    /// The status as words.
    #[must_use]
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Fixed => "fixed",
            Self::Linked => "linked",
            Self::AtBound => "at bound",
            Self::OneSided => "one-sided",
            Self::Correlated => "correlated",
            Self::Ambiguous => "ambiguous",
            Self::Insensitive => "insensitive",
            Self::NotIdentifiable => "not identifiable",
        }
    }

    /// Whether the data determine the value, on both sides.
    #[must_use]
    pub fn is_determined(self) -> bool {
        matches!(self, Self::Ok | Self::Correlated)
    }
}

/// A number with its uncertainty, in the user's unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Best value; `None` where the data do not determine it.
    pub value: Option<f64>,
    /// nm, deg or rad.
    pub unit: String,
    /// Standard deviation; `None` where it means nothing. Held parameters and other structures nearby, which fit as well, have their
    /// part in it; it is no less than half the interval of 95 % over its quantile.
    pub sigma: Option<f64>,
    /// Factor in `sigma` for how far the answer moves as parts of the data are left out; none unless the model misses them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub widened_by: Option<f64>,
    /// What can be said of the value.
    pub status: Status,
    /// Parameters that it is tied to, where the status says so.
    pub with: Vec<String>,
    /// Interval of 68.3 %; an end that is open, at a bound, is `None`. Of an ambiguous value it spans all that fit. Where chi² rises more
    /// slowly than the covariance says, its end is that of the profile likelihood.
    pub interval_68: Option<[Option<f64>; 2]>,
    /// Interval of 95 %.
    pub interval_95: Option<[Option<f64>; 2]>,
    /// Values at other minima that fit as well; empty unless the status is ambiguous.
    pub others: Vec<f64>,
    /// The value used for the curves where the data determine none.
    pub held_at: Option<f64>,
    /// Bounds of the fit, or what they allow a sum of thicknesses; `None` if it was not free.
    pub bounds: Option<[f64; 2]>,
}

impl Estimate {
    /// A value of which nothing else is known yet.
    pub(crate) fn new(value: f64, unit: &str) -> Self {
        Self {
            value: Some(value),
            unit: unit.to_owned(),
            sigma: None,
            widened_by: None,
            status: Status::Ok,
            with: Vec::new(),
            interval_68: None,
            interval_95: None,
            others: Vec::new(),
            held_at: None,
            bounds: None,
        }
    }

    /// Takes back a value that the data do not support.
    pub(crate) fn withdraw(&mut self) {
        self.status = Status::NotIdentifiable;
        self.held_at = self.value.take().or(self.held_at);
        (self.sigma, self.interval_68, self.interval_95) = (None, None, None);
        self.others.clear();
        self.with.clear();
    }
}

/// The five parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Thickness of one air gap.
    pub d_air: Estimate,
    /// Thickness of one cuticle layer.
    pub d_cuticle: Estimate,
    /// Mean tilt of the multilayer.
    pub delta: Estimate,
    /// Half-width of the lobe.
    pub phi_alpha: Estimate,
    /// Width of a lamella.
    pub lamella_width: Estimate,
}

impl Parameters {
    /// Names and estimates, in order.
    #[must_use]
    pub fn each(&self) -> [(&'static str, &Estimate); 5] {
        [
            ("d_air", &self.d_air),
            ("d_cuticle", &self.d_cuticle),
            ("delta", &self.delta),
            ("phi_alpha", &self.phi_alpha),
            ("lamella_width", &self.lamella_width),
        ]
    }
}

/// Quantities that follow from the parameters, with the correlation of these in their uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Derived {
    /// `d_air + d_cuticle`.
    pub period: Estimate,
    /// `n_gap d_air + n_cuticle d_cuticle` at the middle wavelength of the data: half the Bragg wavelength.
    pub optical_sum: Estimate,
}

/// A square matrix with named rows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NamedMatrix {
    /// Names of rows and columns: free parameters, then nuisances in use.
    pub names: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<f64>>,
}

/// One minimum of the sum of squares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MinimumFound {
    /// Its chi², or the sum of the robust loss where one is used.
    pub chi2: f64,
    /// How far that is above the best, in units of the squared standard deviation of a weighted residual.
    pub delta_chi2: f64,
    /// Whether that is within the level at which a minimum counts as fitting as well.
    pub fits: bool,
    /// Share of the posterior about it, by its depth and curvature.
    pub weight: f64,
    /// How it is related to the best.
    pub relation: Relation,
    /// The five values, in the user's units and the order of the parameters.
    pub values: [f64; 5],
    /// How the solver ended there.
    pub termination: Termination,
}

/// What the data can tell of the free parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IdentifiabilityFound {
    /// Parameters searched for.
    pub free: Vec<String>,
    /// How many directions among them the data determine.
    pub rank: usize,
    /// Condition number in units of the bounds; `None` if infinite.
    pub condition: Option<f64>,
    /// What is not determined, as sentences.
    pub undetermined: Vec<String>,
    /// What is determined, in principal directions, the stiffest first.
    pub combinations: Vec<Combination>,
}

/// One linear nuisance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NuisanceFound {
    /// What it is, with its curve where it has one.
    pub name: String,
    /// Best value, at least 0.
    pub value: f64,
    /// Standard deviation; `None` on its bound 0 or where it means nothing.
    pub sigma: Option<f64>,
    /// Whether it stands for the held values only: a parameter that acts as a scale is not determined.
    pub conditional: bool,
}

/// Where the standard deviations come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SigmaSource {
    /// The data's own sigma.
    Stated,
    /// Stated or from the scatter, times `widened_by`, because the model misses the data: by more than they state, or in
    /// a way that noise does not.
    Widened,
    /// The scatter about the model: the data state no sigma.
    Scatter,
}

/// The residuals of one curve, in units of their standard deviation: stated, or the scatter about the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveResiduals {
    /// Name of the curve.
    pub curve: String,
    /// Its readings.
    pub readings: usize,
    /// Sum of squares.
    pub chi2: f64,
    /// Correlation of each with the next.
    pub correlation: f64,
    /// Runs of one sign less those expected of noise, in standard deviations (Wald and Wolfowitz 1940): far below 0 if
    /// neighbours agree. `None` unless both signs occur.
    pub runs_z: Option<f64>,
}

/// The fitted data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataFound {
    /// SHA-256 of the file, hexadecimal; of values as [`Dataset::from_readings`](crate::dataset::Dataset::from_readings) says.
    pub sha256: String,
    /// Readings.
    pub readings: usize,
    /// Records.
    pub curves: Vec<String>,
    /// What was noticed while reading.
    pub notes: Vec<String>,
}

/// How a fit ended, as one word; the first line of every report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// A minimum, and everything free is determined.
    Determined,
    /// A minimum, and a part of what is free is determined.
    PartlyDetermined,
    /// A minimum that determines no thickness, not even a sum of them.
    NoThickness,
    /// No minimum was found.
    NotConverged,
    /// Nothing was free: the structure is that which was given.
    Given,
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitOutcome {
    /// [`SCHEMA`].
    pub schema: String,
    /// How it ended.
    pub verdict: Verdict,
    /// What a reader must know, the most important first.
    pub warnings: Vec<String>,
    /// The five parameters.
    pub parameters: Parameters,
    /// What follows from them.
    pub derived: Derived,
    /// Sum of squared residuals, in units of sigma² where the data state one.
    pub chi2: f64,
    /// Sum of the robust loss, where one was used.
    pub robust_cost: Option<f64>,
    /// Readings less parameters and nuisances in use.
    pub dof: usize,
    /// Akaike's criterion with the correction for small samples; `None` without degrees of freedom.
    pub aicc: Option<f64>,
    /// Bayes's criterion.
    pub bic: f64,
    /// Where the standard deviations come from.
    pub sigma_source: SigmaSource,
    /// Correlation of each residual with the next of its curve: near 0 for noise.
    pub residual_correlation: f64,
    /// Residuals curve by curve.
    #[serde(default)]
    pub curve_residuals: Vec<CurveResiduals>,
    /// Factor by which the standard deviations are widened because the model misses the data, the geometric mean over the
    /// parameters where each has its own; 1 if it does not.
    pub widened_by: f64,
    /// Half-widths of the intervals of 68.3 and 95 % in standard deviations: normal, or Student's t.
    pub quantiles: [f64; 2],
    /// Factor between these and the deviations by the other rule (stated against scatter); `None` without a stated one.
    pub sigma_ratio: Option<f64>,
    /// Covariance of free parameters and nuisances in use, user units; empty where it does not exist.
    pub covariance: NamedMatrix,
    /// Their correlations.
    pub correlation: NamedMatrix,
    /// Distinct minima, best first.
    pub minima: Vec<MinimumFound>,
    /// What the data can tell.
    pub identifiability: IdentifiabilityFound,
    /// Intervals by other methods than the covariance, where they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintyFound>,
    /// Scale, weight and background.
    pub nuisance: Vec<NuisanceFound>,
    /// What to measure next, the best first; empty if nothing more is needed, and until
    /// [`advise`](crate::inversion::advise) is asked.
    #[serde(default)]
    pub advice: Vec<AdviceFound>,
    /// How the solver ended at the best minimum.
    pub termination: Termination,
    /// Evaluations of the model in the run that ended there, those for derivatives apart.
    pub evaluations: usize,
    /// Every choice of the fit.
    pub settings: FitSettings,
    /// Seed of the random starts.
    pub seed: u64,
    /// Name and version of the program.
    pub program: String,
    /// What was fitted.
    pub data: DataFound,
    /// What this variant of the model was chosen from, where there was a choice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub choice: Option<ChoiceFound>,
}

/// One row of `curves.csv`: a reading beside the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedReading {
    /// The model's value.
    pub model: f64,
    /// Data less model, in the unit of the data.
    pub residual: f64,
    /// The same in units of its standard deviation, or of the scatter where none is stated.
    pub normalised: f64,
    /// Model A's part, with scale and weight.
    pub lamella: f64,
    /// Model B's part, with its scale.
    pub multilayer: f64,
    /// The background.
    pub background: f64,
}

/// A fit with its curves, and what further questions to it need.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Everything that `fit.json` holds.
    pub outcome: FitOutcome,
    /// A row for each reading, in the order of the data.
    pub readings: Vec<FittedReading>,
    pub(crate) solution: Solution,
}
