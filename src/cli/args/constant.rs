//! A constant of the model to fit.

use crate::args::ProblemArgs;
use crate::values;
use clap::Args;
use morpho_fit::inversion::Constant;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct ConstantArgs {
    #[command(flatten)]
    pub(crate) problem: ProblemArgs,
    /// The constant, and between which values: n_cuticle, k_cuticle, n_gap, n_base, filling, ridge_spacing (nm),
    /// numerical_aperture, bandwidth (nm), period_spread (nm), layer_spread (nm) or tilt_spread (deg).
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = varied, required = true, help_heading = "Constant")]
    pub(crate) vary: Vec<Varied>,
    #[command(flatten)]
    pub(crate) output: ConstantOutputArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct ConstantOutputArgs {
    /// Folder of the results, made if it is missing [default: fits/<name of the data>/constant].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print constant.json instead of the report.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print no report and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Draw no plots.
    #[arg(long)]
    pub(crate) no_plots: bool,
}

/// A constant and its range, user units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Varied {
    pub(crate) constant: Constant,
    pub(crate) limits: [f64; 2],
}

fn varied(text: &str) -> Result<Varied, String> {
    let shape = "write it like n_cuticle=1.45:1.65";
    let (name, range) = text.split_once('=').ok_or(shape)?;
    let names = Constant::ALL.map(Constant::name);
    let constant = Constant::from_name(name.trim()).ok_or_else(|| {
        let meant = values::nearest(name.trim(), &names).map(|name| format!("; did you mean `{name}`?"));
        let meant = meant.unwrap_or_else(|| format!("; there are {}", names.join(", ")));
        format!("`{name}` is no constant of the model{meant}")
    })?;
    let (low, high) = range.split_once(':').ok_or(shape)?;
    let limits = [values::number(low)?, values::number(high)?];
    let (least, most) = constant.domain();
    if least <= limits[0] && limits[0] < limits[1] && limits[1] <= most {
        Ok(Varied { constant, limits })
    } else {
        Err(format!("the range must rise, within {least} to {most}"))
    }
}
