//! What is drawn: the structure of a fit, or one that is known.

use crate::args::{ModelArgs, StructureArgs};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct SubjectArgs {
    /// Draw the structure of a fit, with its stack and model: its fit.json, or the folder where that lies. Flags of the
    /// structure change it. Without it the preset is drawn.
    #[arg(value_name = "FIT.json")]
    pub(crate) fit: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) structure: StructureArgs,
    #[command(flatten)]
    pub(crate) model: ModelArgs,
}
