//! The command line as clap reads it. Help texts are sentences with units and defaults.
#![allow(clippy::doc_markdown, reason = "the comments are help texts, which a terminal shows as they are")]

mod batch;
mod bsdf;
mod constant;
mod drawing;
mod measurement;
mod problem;
mod render;
mod structure;
mod subject;
mod table;
mod tradeoff;
mod words;

pub(crate) use batch::{BatchArgs, BatchOutputArgs};
pub(crate) use bsdf::{BsdfArgs, BsdfChoiceArgs, ImportBsdfArgs, WavelengthChoice};
pub(crate) use constant::ConstantArgs;
pub(crate) use drawing::{AxesArgs, CurveArgs, CurvesArgs, GridChoice, PaperArgs, SweepArgs, ViewingArgs};
pub(crate) use measurement::SimulateArgs;
pub(crate) use problem::{AverageArgs, LAYERS, ModelArgs, NuisanceArgs, ParameterArgs, ProblemArgs, ReadingArgs};
pub(crate) use render::{Behind, Exposure, MapArgs, RenderArgs};
pub(crate) use structure::StructureArgs;
pub(crate) use subject::SubjectArgs;
pub(crate) use table::TableArgs;
pub(crate) use tradeoff::TradeoffArgs;
pub(crate) use words::{
    AcrossWord, AdmittanceWord, DerivativeWord, ExtentWord, GamutWord, KeepWord, LossWord, ModelWord, ObserverWord,
    PolarizationWord, PresetWord, SnellWord, SwingWord, TableFormat, TurnWord, UncertaintyWord, WideWord,
};

use crate::values;
use clap::{Args, CommandFactory, Parser, Subcommand};
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

/// The command that a word which is no file may be meant for.
pub(crate) fn command_meant(word: &str) -> Option<String> {
    if word.contains(['.', '/', '\\']) {
        return None;
    }
    let commands: Vec<String> = Cli::command().get_subcommands().map(|word| word.get_name().to_owned()).collect();
    let names: Vec<&str> = commands.iter().map(String::as_str).chain(["help"]).collect();
    values::nearest(word, &names).map(str::to_owned)
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
    /// Fit with one constant of the model fitted too, such as the index of the cuticle or the spread of the period, and say how
    /// wide that makes the other intervals: constant.json, constant.csv, constant.svg.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Constant(ConstantArgs),
    /// Fit many files, or many items in one file, such as the pixels of a map, with the same settings: batch.csv, batch.json, and
    /// items.svg or map.svg. Stopped, it goes on where it was; the exit code is that of the first cause among the items.
    #[command(after_help = EXIT_CODES, args_override_self = true)]
    Batch(BatchArgs),
    /// Validate a CSV file and tell what its design of measurement can identify, before fitting or even measuring: a plan needs no
    /// column intensity.
    #[command(args_override_self = true)]
    Check(CheckArgs),
    /// Draw intensity over the viewing angle for several wavelengths, cartesian and polar, and spectra at several angles:
    /// angular.svg, polar.svg, spectra.svg, model.csv.
    #[command(args_override_self = true)]
    Curves(CurvesArgs),
    /// Draw colour against d_air or another parameter: a strip at one angle, and a chart over the viewing angle: sweep.svg,
    /// strip.svg, sweep.csv.
    #[command(args_override_self = true)]
    Sweep(SweepArgs),
    /// Table the colours or spectra over incidence, view and plane for a renderer, with as many nodes as a tolerance needs:
    /// table.npy or table.csv, table.json, table.svg.
    #[command(args_override_self = true)]
    Table(TableArgs),
    /// Draw pictures of a wing of this structure in the sun, as the paper's Fig. 15: view_10.png, view_10.exr and so on for each
    /// view, views.png, render.json; or a flip-book, turn.png.
    #[command(args_override_self = true, mut_arg("model", |model| model.default_value("hybrid")))]
    Render(RenderArgs),
    /// Write the surface as `.bsdf` files in the layout of the RGL database, which Mitsuba 3 loads, with as many nodes as a tolerance
    /// needs and a certificate of what they keep: wing_spectral.bsdf, wing_rgb.bsdf, certificate.json, albedo.svg.
    #[command(args_override_self = true, mut_arg("model", |model| model.default_value("hybrid")))]
    Bsdf(BsdfArgs),
    /// Read a measured material of the RGL database, isotropic or not, into a CSV file that can be fitted.
    #[command(args_override_self = true)]
    ImportBsdf(ImportBsdfArgs),
    /// Draw the figures and the table of the paper, as printed and right, with the differences in numbers: README.md and its
    /// pictures.
    #[command(args_override_self = true)]
    Paper(PaperArgs),
    /// Measure error against time of models, derivatives, solvers, wavelengths and tables on this machine, and map where each
    /// method fails: README.md, and CSV, SVG and PNG for each study.
    #[command(args_override_self = true)]
    Tradeoff(TradeoffArgs),
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
