//! Arguments of `morpho-fit tradeoff`.

use clap::Args;
use morpho_fit::tradeoff::Study;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct TradeoffArgs {
    /// Folder of the charts, tables and conclusions, made if it is missing.
    #[arg(long, value_name = "DIR", default_value = "fits/tradeoff")]
    pub(crate) out: PathBuf,
    /// Fewer repeats, problems and structures: seconds, and rougher times.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Only these: `stability`, `forward`, `average`, `derivative`, `solver`, `wavelength`, `table` [default: all].
    #[arg(long, value_name = "WORDS", value_delimiter = ',', value_parser = study)]
    pub(crate) only: Vec<Study>,
    /// Seed of the random structures, starts and noise.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Print no conclusions and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
}

fn study(word: &str) -> Result<Study, String> {
    let names = Study::ALL.map(Study::name).join(", ");
    Study::from_name(word).ok_or_else(|| format!("there is no study of that name; there are {names}"))
}
