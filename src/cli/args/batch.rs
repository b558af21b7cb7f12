//! Arguments of `morpho-fit batch`.

use crate::args::{ModelArgs, NuisanceArgs, ParameterArgs, ProblemArgs, ReadingArgs, UncertaintyArgs};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct BatchArgs {
    /// The measurements as CSV, in the form that `fit` reads: each file is an item, named by its file without the
    /// ending. With `--by` one file with many items in it; `-` reads standard input.
    #[arg(value_name = "DATA.csv", required = true)]
    pub(crate) data: Vec<PathBuf>,
    /// Take flags from a TOML file: the names of the flags without the dashes, such as `omega = 90`,
    /// `fix = ["d_cuticle=62"]`. A flag on the command line goes before the file.
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) settings: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) items: ItemArgs,
    #[command(flatten)]
    pub(crate) reading: ReadingArgs,
    #[command(flatten)]
    pub(crate) model: ModelArgs,
    #[command(flatten)]
    pub(crate) parameters: ParameterArgs,
    #[command(flatten)]
    pub(crate) nuisances: NuisanceArgs,
    #[command(flatten)]
    pub(crate) uncertainty: UncertaintyArgs,
    #[command(flatten)]
    pub(crate) output: BatchOutputArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Items")]
pub(crate) struct ItemArgs {
    /// Split the file: each text in this column is an item of its own, in the order of the file. `curve` is the
    /// column of that name, or with `--wide curve` the headings. Two columns of numbers, such as `x,y`, are the
    /// pixels of a map. The columns are not read as data otherwise. Names are those of the heading line to the
    /// letter.
    #[arg(long, value_name = "COLUMN[,COLUMN]", value_delimiter = ',')]
    pub(crate) by: Vec<String>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct BatchOutputArgs {
    /// Folder of the results, made if it is missing [default: fits/batch, of one file fits/<name of the data>/batch].
    /// What was done there by the same command is not done again.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Write for each item what a fit of it alone leaves, charts and report.html included, into a folder of its name.
    #[arg(long)]
    pub(crate) reports: bool,
    /// Print batch.json instead of the report.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print no report and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
    /// Draw no plots: neither items.svg and .png, nor map.svg and .png of `--by x,y`, nor those of `--reports`.
    #[arg(long)]
    pub(crate) no_plots: bool,
}

impl BatchArgs {
    /// What each item is fitted with, in the form that a single fit has it.
    pub(crate) fn split(self) -> (Vec<PathBuf>, ItemArgs, ProblemArgs, UncertaintyArgs, BatchOutputArgs) {
        let Self { data, items, settings, reading, model, parameters, nuisances, uncertainty, output } = self;
        let problem = ProblemArgs { data: None, settings, reading, model, parameters, nuisances };
        (data, items, problem, uncertainty, output)
    }
}
