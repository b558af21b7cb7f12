//! The command line as clap reads it. Help texts are sentences with units and defaults.
#![allow(clippy::doc_markdown, reason = "the comments are help texts, which a terminal shows as they are")]

use crate::scans::ScanRequest;
use crate::values::{self, Assignment, Given, Index};
use clap::{Args, Parser, Subcommand, ValueEnum};
use morpho_fit::dataset::WideHeading;
use morpho_fit::geometry::Polarization;
use morpho_fit::inversion::{Extent, Parameter, Weight};
use morpho_fit::optics::{Admittance, LamellaUnit, Snell};
use morpho_fit::optimise::Loss;
use std::path::PathBuf;

/// Fits layer thicknesses to the angular reflectivity of structurally coloured surfaces.
///
/// `morpho-fit DATA.csv` finds the air gap d_air, the cuticle thickness d_cuticle, the tilt delta, the lobe half-width
/// phi_alpha and the lamella width a; says how sure each is and what the data cannot tell; and writes fit.json,
/// curves.csv and plots to fits/<name of the data>/.
#[derive(Debug, Parser)]
#[command(
    version,
    name = "morpho-fit",
    max_term_width = 100,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    arg_required_else_help = true,
    after_help = EXIT_CODES
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) fit: FitArgs,
}

const EXIT_CODES: &str = "\
Parameters and units: d_air nm, d_cuticle nm, delta deg, phi_alpha rad, lamella_width (or a) nm.

Exit codes: 0 done, 1 could not read or write, 2 usage, 3 bad data, 4 not converged, 5 converged but something \
required, or every thickness, is not identifiable.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Fit a measurement; the word may be left out.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Fit(FitArgs),
    /// Fit, and find asymmetric intervals by profile likelihood: profile.csv, profile.svg.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Profile(FitArgs),
    /// Fit, and find intervals by the bootstrap of residuals and of readings: bootstrap.csv.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Bootstrap(FitArgs),
    /// Fit, and sample the posterior by Markov chain Monte Carlo: posterior.csv, corner.svg, trace.svg.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Sample(FitArgs),
    /// Validate a CSV file and tell what its design of measurement can identify, before fitting.
    #[command(args_override_self = true)]
    Check(CheckArgs),
    /// Write a CSV file as if it were measured, from known parameters, design and noise.
    #[command(args_override_self = true)]
    Simulate(SimulateArgs),
}

#[derive(Debug, Args)]
pub(crate) struct FitArgs {
    #[command(flatten)]
    pub(crate) problem: ProblemArgs,
    #[command(flatten)]
    pub(crate) uncertainty: UncertaintyArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Everything that says what is fitted: the same for `fit` and `check`.
#[derive(Debug, Args)]
pub(crate) struct ProblemArgs {
    /// The measurement as CSV, one reading a row: wavelength_nm, theta_deg, phi_deg, omega_deg, intensity, and if they are
    /// known sigma, curve, polarization. `-` reads standard input.
    #[arg(value_name = "DATA.csv", required = true)]
    pub(crate) data: Option<PathBuf>,
    /// Take flags from a TOML file: the names of the flags without the dashes, such as `omega = 90`,
    /// `fix = ["d_cuticle=62"]`. A flag on the command line goes before the file.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) settings: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    #[command(flatten)]
    pub(crate) parameters: ParameterArgs,
    #[command(flatten)]
    pub(crate) nuisances: NuisanceArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "What is not in the file")]
pub(crate) struct ReadingArgs {
    /// Wavelength of all readings, nm.
    #[arg(long, value_name = "NM", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) wavelength: Option<f64>,
    /// Incidence angle of all readings, degrees from the scale normal.
    #[arg(long, value_name = "DEG", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) theta: Option<f64>,
    /// Viewing angle of all readings, degrees, the same way round as theta: the mirror direction is -theta.
    #[arg(long, value_name = "DEG", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) phi: Option<f64>,
    /// Anisotropy angle of all readings, degrees: 0 measures across the ridges, 90 along them.
    #[arg(long, value_name = "DEG", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) omega: Option<f64>,
    /// Standard deviation of all readings, in the unit of the intensity.
    #[arg(long, value_name = "VALUE", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) sigma: Option<f64>,
    /// Polarization of all readings [default: unpolarized].
    #[arg(long, value_name = "WORD")]
    pub(crate) polarization: Option<PolarizationWord>,
    /// Read a wide table: first column wavelength_nm, the other headings are angles in degrees or names of records.
    #[arg(long, value_name = "HEADINGS")]
    pub(crate) wide: Option<WideWord>,
    /// Take the intensity from the column of this heading.
    #[arg(long, value_name = "HEADING", conflicts_with = "wide")]
    pub(crate) intensity_column: Option<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Model")]
pub(crate) struct ModelArgs {
    /// Forward model.
    #[arg(long, value_name = "WORD", default_value = "blend")]
    pub(crate) model: ModelWord,
    /// Snell's law of the `paper` model, right way up or as printed [default: right].
    #[arg(long, value_name = "WORD")]
    pub(crate) snell: Option<SnellWord>,
    /// How the `paper` model joins the polarizations [default: mean].
    #[arg(long, value_name = "WORD")]
    pub(crate) admittance: Option<AdmittanceWord>,
    /// What the `paper` model divides Model A by: `peak`, `printed`, or a reference width in nm [default: peak].
    #[arg(long, value_name = "peak|printed|NM", value_parser = values::lamella_unit)]
    pub(crate) lamella_unit: Option<LamellaUnit>,
    /// Number of cuticle layers, 1 to 100000.
    #[arg(long, value_name = "COUNT", default_value_t = 9)]
    pub(crate) layers: usize,
    /// Refractive index of the cuticle: a number, n+ki, Cauchy constants (b in nm²), or a CSV file with the columns
    /// wavelength_nm, n and k (other columns: `file.csv:N_COLUMN` or `file.csv:N_COLUMN,K_COLUMN`) [default: 1.56].
    #[arg(long, value_name = "1.56|1.56+0.06i|cauchy:A,B|FILE.csv", value_parser = values::index, allow_negative_numbers = true)]
    pub(crate) n_cuticle: Option<Index>,
    /// Refractive index between the layers, written like that of the cuticle [default: 1].
    #[arg(long, value_name = "INDEX", value_parser = values::index, allow_negative_numbers = true)]
    pub(crate) n_gap: Option<Index>,
    /// Refractive index behind the last gap, written like that of the cuticle [default: 1].
    #[arg(long, value_name = "INDEX", value_parser = values::index, allow_negative_numbers = true)]
    pub(crate) n_base: Option<Index>,
    /// Refractive index before the first layer, written like that of the cuticle, without absorption [default: 1].
    #[arg(long, value_name = "INDEX", value_parser = values::index, allow_negative_numbers = true)]
    pub(crate) n_ambient: Option<Index>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Parameters (d_air nm, d_cuticle nm, delta deg, phi_alpha rad, lamella_width or a nm)")]
pub(crate) struct ParameterArgs {
    /// Hold a parameter at a known value: `--fix d_cuticle=62`. May be repeated.
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::fixed)]
    pub(crate) fix: Vec<Given>,
    /// Search between two values: `--bounds d_air=50:250`. May be repeated. Defaults: d_air and d_cuticle 20:300 nm,
    /// delta -10:10 deg, phi_alpha 0.1:1.2 rad, lamella_width 100:600 nm.
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = values::bounds)]
    pub(crate) bounds: Vec<Given>,
    /// Begin the search there too: `--start d_air=140`. May be repeated. Where none is given the middle of the bounds
    /// stands in.
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::assignment)]
    pub(crate) start: Vec<Assignment>,
    /// Let a parameter follow another, in their own units: `--link d_cuticle=235-d_air`. May be repeated.
    #[arg(long, value_name = "NAME=FACTOR*OTHER+CONSTANT", value_parser = values::link)]
    pub(crate) link: Vec<Given>,
    /// Exit with code 5 if one of these is not determined: `--require d_air,d_cuticle`.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = values::parameter)]
    pub(crate) require: Vec<Parameter>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Scale, weight, background and search")]
pub(crate) struct NuisanceArgs {
    /// Factor on the intensity that is fitted beside the parameters; without one the data are reflectivities.
    #[arg(long, value_name = "WORD", default_value = "shared")]
    pub(crate) scale: ExtentWord,
    /// Intensity that is read where nothing is reflected.
    #[arg(long, value_name = "WORD", default_value = "none")]
    pub(crate) background: ExtentWord,
    /// Strength of Model A beside Model B: `fit` where the data see both planes, or a number of at least 0.
    #[arg(long, value_name = "fit|NUMBER", default_value = "fit", value_parser = values::weight)]
    pub(crate) weight: Weight,
    /// How readings far from the model count.
    #[arg(long, value_name = "WORD", default_value = "linear")]
    pub(crate) loss: LossWord,
    /// Search from the start alone: quick, and blind to every other minimum.
    #[arg(long)]
    pub(crate) local: bool,
    /// Another minimum fits as well if its chi² is above the best by at most this, in standard deviations squared.
    #[arg(long, value_name = "DELTA_CHI2", default_value_t = 9.0, value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) level: f64,
    /// Seed of the random starts that stand beside the grid.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Number of threads; the result does not depend on it [default: one for each processor].
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Intervals beside the covariance's")]
pub(crate) struct UncertaintyArgs {
    /// Find intervals by these methods too, and say where they part: `profile`, `bootstrap`, `sample` or `all`.
    #[arg(long, value_name = "WORDS", value_delimiter = ',')]
    pub(crate) uncertainty: Vec<UncertaintyWord>,
    /// Data sets that each bootstrap fits.
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = values::count)]
    pub(crate) replicates: usize,
    /// Effective samples of the posterior that are wanted for every parameter.
    #[arg(long, value_name = "COUNT", default_value_t = 4000, value_parser = values::count)]
    pub(crate) effective: usize,
    /// Evaluations of the model after which sampling ends even if it has not converged.
    #[arg(long, value_name = "COUNT", default_value_t = 400_000, value_parser = values::count)]
    pub(crate) max_evaluations: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum UncertaintyWord {
    /// Curvature at the minimum, which every fit has.
    Covariance,
    /// Profile likelihood.
    Profile,
    /// Bootstrap of residuals, and of readings.
    Bootstrap,
    /// Markov chain Monte Carlo.
    Sample,
    /// All of them.
    All,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    /// Folder of the results, made if it is missing [default: fits/<name of the data>].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print fit.json instead of the report.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print no report and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Draw no plots.
    #[arg(long)]
    pub(crate) no_plots: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) problem: ProblemArgs,
    /// Print the findings as JSON.
    #[arg(long, help_heading = "Output")]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Structure that the parameters below change: a blue Morpho (air 141 nm, cuticle 62 nm) or Table 1 of the paper (135 nm,
    /// 100 nm); both with delta 2.5 deg, phi_alpha 0.5 rad, lamella_width 300 nm.
    #[arg(long, value_name = "WORD", default_value = "blue")]
    pub(crate) preset: PresetWord,
    /// Thickness of one air gap, nm.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) d_air: Option<f64>,
    /// Thickness of one cuticle layer, nm.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) d_cuticle: Option<f64>,
    /// Mean tilt of the layers, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) delta: Option<f64>,
    /// Half-width of the lobe, rad.
    #[arg(long, value_name = "RAD", value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) phi_alpha: Option<f64>,
    /// Width of a lamella, nm.
    #[arg(long, visible_alias = "a", value_name = "NM", value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) lamella_width: Option<f64>,
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    #[command(flatten)]
    pub(crate) measurement: MeasurementArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Measurement")]
pub(crate) struct MeasurementArgs {
    /// One record, every combination of its values: `wavelength=380:740:10,theta=0,phi=-60:60:5,omega=0|90`, with
    /// START:STOP:STEP for a range (both ends included) and | between single values; wavelengths in nm, angles in
    /// degrees (0 where left out); `polarization=s` and `name=...` if wanted. May be repeated. Default: a spectrum and an
    /// angular scan in each plane, 172 readings.
    #[arg(long, value_name = "DESIGN", value_parser = crate::scans::parse)]
    pub(crate) scan: Vec<ScanRequest>,
    /// Standard deviation of the noise as a share of the largest intensity.
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) noise: f64,
    /// Factor on all intensities.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) scale: f64,
    /// Seed of the noise: the same seed gives the same file.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Add the noise but leave its standard deviation out of the file.
    #[arg(long)]
    pub(crate) no_sigma: bool,
    /// Write a wide table with these headings.
    #[arg(long, value_name = "HEADINGS")]
    pub(crate) wide: Option<WideWord>,
    /// File to write [default: standard output].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// An enumeration of words on the command line, each with its library value.
macro_rules! words {
    ($name:ident => $target:ty { $($(#[$doc:meta])* $variant:ident => $value:expr,)+ }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
        pub(crate) enum $name { $($(#[$doc])* $variant,)+ }

        impl $name {
            pub(crate) fn value(self) -> $target {
                match self { $(Self::$variant => $value,)+ }
            }
        }
    };
}

words!(PolarizationWord => Polarization {
    /// Electric field across the plane of incidence.
    S => Polarization::S,
    /// Electric field in the plane of incidence.
    P => Polarization::P,
    /// The mean of both.
    Unpolarized => Polarization::Unpolarized,
});

words!(WideWord => WideHeading {
    /// Headings are incidence angles in degrees.
    Theta => WideHeading::Theta,
    /// Headings are viewing angles in degrees.
    Phi => WideHeading::Phi,
    /// Headings are names of records.
    Curve => WideHeading::Curve,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModelWord {
    /// The paper's structure with its physics put right.
    Blend,
    /// The printed formulas.
    Paper,
    /// For a fit: the smallest variant of `blend` that does not lose, of lamellae or multilayer or both, delta 0 or free,
    /// without a background or with one. What is fixed stays fixed.
    Auto,
}

words!(SnellWord => Snell {
    /// Light bends towards the normal in the denser medium.
    Right => Snell::Right,
    /// As printed: no solution beyond 39.87 degrees for an index of 1.56.
    Printed => Snell::Printed,
});

words!(AdmittanceWord => Admittance {
    /// As printed: one mean admittance.
    Mean => Admittance::Mean,
    /// Each polarization by itself, which is exact.
    PerPolarization => Admittance::PerPolarization,
});

words!(ExtentWord => Extent {
    /// Not fitted.
    None => Extent::None,
    /// One for all curves.
    Shared => Extent::Shared,
    /// One for each curve.
    PerCurve => Extent::PerCurve,
});

words!(LossWord => Loss {
    /// Least squares.
    Linear => Loss::Linear,
    /// Squares near the model, absolute values far from it, joined smoothly.
    SoftL1 => Loss::SoftL1,
    /// Squares up to one standard deviation, absolute values beyond.
    Huber => Loss::Huber,
    /// The logarithm: readings far away hardly count.
    Cauchy => Loss::Cauchy,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetWord {
    /// A blue Morpho: air 141 nm, cuticle 62 nm.
    Blue,
    /// Table 1 of the paper: air 135 nm, cuticle 100 nm.
    Table1,
}
