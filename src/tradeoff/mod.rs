//! Error against time of every choice of method, and where each form of a formula fails.
//!
//! Every number is measured where the program runs: errors against a reference that another formula gives, times by a clock
//! that the caller hands in (the library has none), the methods in turn so that noise of the machine hits all alike. All work
//! is done by one thread.
//!
//! Eight studies: [`Study`]. Each gives diagrams of points ([`Diagram`]), the stability map tables of words ([`Map`]).

mod averages;
mod colours;
mod complex_step;
mod derivatives;
mod forward;
mod naive;
mod options;
mod solvers;
mod stability;
mod table;
mod timing;
mod wavelengths;

pub use stability::{Form, Map, Row, Verdict};

use crate::colorimetry::ColourError;
use crate::dataset::Findings;
use crate::inversion::FitError;
use crate::optics::OpticsError;
use crate::optimise::BoundsError;
use crate::spectrum::SpectrumError;
use crate::table::TableError;

/// A clock: seconds since any moment, never falling.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Study {
    /// Where each form of a formula, and each solver, fails.
    Stability,
    /// Forward models and their kernels.
    Forward,
    /// Options of the model: what each costs, and what leaving it out costs.
    Option,
    /// Averages over layer thickness and over a cone of incidence.
    Average,
    /// Derivatives of the model by its five parameters.
    Derivative,
    /// Solvers, by the share of known problems that they solve.
    Solver,
    /// Wavelengths of a spectrum, by the error of its colour.
    Wavelength,
    /// Nodes of a table of colours, by the error of a colour in between.
    Table,
}

impl Study {
    /// All, in the order in which they are done.
    pub const ALL: [Self; 8] = [
        Self::Stability,
        Self::Forward,
        Self::Option,
        Self::Average,
        Self::Derivative,
        Self::Solver,
        Self::Wavelength,
        Self::Table,
    ];

    /// The word for the command line, and the name of the study's files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stability => "stability",
            Self::Forward => "forward",
            Self::Option => "option",
            Self::Average => "average",
            Self::Derivative => "derivative",
            Self::Solver => "solver",
            Self::Wavelength => "wavelength",
            Self::Table => "table",
        }
    }

    /// The study of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|study| study.name() == name)
    }
}

/// One measured point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// What was set, such as `60°` or `9 nodes`.
    pub setting: String,
    /// Abscissa, a cost.
    pub x: f64,
    /// Ordinate, mostly an error.
    pub y: f64,
}

/// The points of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The method.
    pub method: String,
    /// Its points, in the order of their settings.
    pub points: Vec<Point>,
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagram {
    /// What is shown.
    pub title: String,
    /// What x is, with its unit.
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// Whether y spans powers of ten; x always does.
    pub y_in_powers: bool,
    /// The methods.
    pub series: Vec<Series>,
}

impl Diagram {
    /// The point of `method` at `setting`.
    #[must_use]
    pub fn point(&self, method: &str, setting: &str) -> Option<&Point> {
        let series = self.series.iter().find(|series| series.method == method)?;
        series.points.iter().find(|point| point.setting == setting)
    }
}

/// What was measured in one study.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// The study.
    pub study: Study,
    /// Its diagrams; none for [`Study::Stability`].
    pub diagrams: Vec<Diagram>,
    /// The tables of the stability map; none for the others.
    pub maps: Vec<Map>,
}

/// How much is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Which studies.
    pub studies: Vec<Study>,
    /// Fewer repeats, problems and structures: seconds instead of minutes.
    pub quick: bool,
    /// Seed of the random structures, starts and noise.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { studies: Study::ALL.to_vec(), quick: false, seed: 1 }
    }
}

/// Why nothing could be measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TradeoffError {
    /// A model has no value.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// A colour has no value.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// A table has no value.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A grid of wavelengths is none.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A fit could not begin.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Bounds without room.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// A problem's data are none.
    #[error(transparent)]
    Data(#[from] Findings),
    /// The problems that come with the library cannot be read.
    #[error("the problems that come with the program cannot be read")]
    Problems(#[from] serde_json::Error),
    /// Their data cannot be read.
    #[error("the data of the problems that come with the program cannot be read: {0}")]
    ProblemData(String),
    /// One thread could not be started.
    #[error(transparent)]
    Thread(#[from] rayon::ThreadPoolBuildError),
}

/// Measures the studies of `settings`, in one thread.
///
/// - `clock`: seconds; only differences count.
/// - `progress` is told what is being done.
///
/// # Seed
/// Errors, words and success within a number of evaluations repeat with the seed; times do not.
///
/// # Errors
/// [`TradeoffError`] if a model, a colour or a problem has no value.
///
/// ```
/// use morpho_fit::tradeoff::{Settings, Study, measure};
/// let settings = Settings { studies: vec![Study::Wavelength], quick: true, seed: 1 };
/// let sheets = measure(&settings, &|| 0.0, &|_| {})?;
/// let finest = sheets[0].diagrams[0].point("plane wave, worst", "2 nm").unwrap();
/// assert!(finest.y < 1.0);
/// # Ok::<(), morpho_fit::tradeoff::TradeoffError>(())
/// ```
pub fn measure(
    settings: &Settings,
    clock: Clock<'_>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Vec<Sheet>, TradeoffError> {
    let one = |study: Study| -> Result<Sheet, TradeoffError> {
        progress(study.name());
        let (diagrams, maps) = match study {
            Study::Stability => (Vec::new(), stability::maps(settings)?),
            Study::Forward => (forward::diagrams(settings, clock)?, Vec::new()),
            Study::Option => (vec![options::diagram(settings, clock)?], Vec::new()),
            Study::Average => (averages::diagrams(settings, clock)?, Vec::new()),
            Study::Derivative => (vec![derivatives::diagram(settings, clock)?], Vec::new()),
            Study::Solver => (solvers::diagrams(settings, clock, progress)?, Vec::new()),
            Study::Wavelength => (vec![wavelengths::diagram(settings)?], Vec::new()),
            Study::Table => (vec![table::diagram(settings)?], Vec::new()),
        };
        Ok(Sheet { study, diagrams, maps })
    };
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    thread.install(|| settings.studies.iter().map(|study| one(*study)).collect())
}
