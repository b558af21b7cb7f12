//! The `morpho-fit` program: parse the command line, run one command, turn what happened into an exit code.
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout, clippy::print_stderr)
)]

mod args;
mod commands;
mod exit;
mod index_table;
mod items;
mod journal;
mod machine;
mod options;
mod output;
mod progress;
mod scans;
mod settings_file;
mod subject;
mod values;
mod viewing;

use args::{Cli, Command, UncertaintyWord};
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let line: Vec<OsString> = std::env::args_os().collect();
    match Cli::try_parse_from(&line) {
        Ok(cli) => exit::code(run(cli, &line)),
        Err(error) => exit::of_command_line(&error, &line),
    }
}

fn run(cli: Cli, line: &[OsString]) -> anyhow::Result<exit::Outcome> {
    let cli = settings_file::merged(cli, line)?;
    match cli.command {
        None => commands::fit::run(&cli.fit, UncertaintyWord::Covariance),
        Some(Command::Fit(args)) => commands::fit::run(&args, UncertaintyWord::Covariance),
        Some(Command::Profile(args)) => commands::fit::run(&args, UncertaintyWord::Profile),
        Some(Command::Bootstrap(args)) => commands::fit::run(&args, UncertaintyWord::Bootstrap),
        Some(Command::Sample(args)) => commands::fit::run(&args, UncertaintyWord::Sample),
        Some(Command::Constant(args)) => commands::constant::run(&args),
        Some(Command::Batch(args)) => commands::batch::run(args),
        Some(Command::Check(args)) => commands::check::run(&args),
        Some(Command::Curves(args)) => commands::curves::run(&args),
        Some(Command::Sweep(args)) => commands::sweep::run(&args),
        Some(Command::Table(args)) => commands::table::run(&args),
        Some(Command::Render(args)) => commands::render::run(args),
        Some(Command::Bsdf(args)) => commands::bsdf::run(&args),
        Some(Command::ImportBsdf(args)) => commands::import_bsdf::run(&args),
        Some(Command::Paper(args)) => commands::paper::run(&args),
        Some(Command::Tradeoff(args)) => commands::tradeoff::run(&args),
        Some(Command::Simulate(args)) => commands::simulate::run(&args, line),
    }
}
