//! What is fitted: data, model, parameters, nuisances.

use crate::args::{
    AdmittanceWord, DerivativeWord, ExtentWord, LossWord, ModelWord, PolarizationWord, SnellWord, WideWord,
};
use crate::values::{self, Assignment, Given, Index};
use clap::Args;
use morpho_fit::inversion::{Parameter, Weight};
use morpho_fit::optics::LamellaUnit;
use std::path::PathBuf;

/// Cuticle layers of a tree in the paper's Table 1.
pub(crate) const LAYERS: usize = 9;

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
    /// Distance of the ridges in the `hybrid` model, also beside the `blend` of `auto`, nm, 1 to 1000000 [default: 750].
    #[arg(long, value_name = "NM", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) ridge_spacing: Option<f64>,
    /// Give the layers the index sqrt(1 + SHARE (n² - 1)) that wide light sees of ridges in air; SHARE is that of a layer
    /// that is cuticle, lamella width over distance of the ridges, above 0, at most 1 [default: whole layers].
    #[arg(long, value_name = "SHARE", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) filling: Option<f64>,
    /// Number of cuticle layers, 1 to 100000.
    #[arg(long, value_name = "COUNT", default_value_t = LAYERS)]
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
    #[command(flatten)]
    pub(crate) averages: AverageArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Averages of the multilayer (off unless given)")]
pub(crate) struct AverageArgs {
    /// Numerical aperture of the objective that lights and gathers, 0 to 0.99.
    #[arg(long, value_name = "NA", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) numerical_aperture: Option<f64>,
    /// Full width at half maximum of the instrument's band, nm.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) bandwidth: Option<f64>,
    /// Standard deviation of the period over the spot, nm; both layers in proportion.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) period_spread: Option<f64>,
    /// Standard deviation of each layer by itself, cuticle as gap, nm: stacks of unequal layers within the spot; not for `paper`.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) layer_spread: Option<f64>,
    /// Standard deviation of the tilt over the spot, degrees; not beside an aperture, and not for `hybrid`.
    #[arg(long, value_name = "DEG", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) tilt_spread: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Parameters (d_air nm, d_cuticle nm, delta deg, phi_alpha rad, lamella_width or a nm)")]
pub(crate) struct ParameterArgs {
    /// Hold a parameter at a known value: `--fix d_cuticle=62`. May be repeated, or given as a list with commas. With all five
    /// held nothing is fitted but scales: the report tells how well that structure describes the data.
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::fixed, value_delimiter = ',')]
    pub(crate) fix: Vec<Given>,
    /// Search between two values: `--bounds d_air=50:250`. May be repeated, or a list. Defaults: d_air and d_cuticle 20:300 nm,
    /// delta -10:10 deg, phi_alpha 0.1:1.2 rad, lamella_width 100:600 nm.
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = values::bounds, value_delimiter = ',')]
    pub(crate) bounds: Vec<Given>,
    /// Begin the search there too: `--start d_air=140`. May be repeated, or a list. Where none is given the middle of the bounds
    /// stands in.
    #[arg(long, value_name = "NAME=VALUE", value_parser = values::assignment, value_delimiter = ',')]
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
    /// How stack and lamellae are differentiated.
    #[arg(long, value_name = "WORD", default_value = "exact")]
    pub(crate) derivative: DerivativeWord,
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
