//! Exit codes, and the one place where an error becomes words on the terminal.

use crate::args::command_meant;
use crate::output;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use morpho_fit::bsdf::BsdfError;
use morpho_fit::dataset::Findings;
use morpho_fit::inversion::{AdviceError, DesignError, FitError, SettingsError};
use morpho_fit::optics::OpticsError;
use morpho_fit::render::RenderError;
use morpho_fit::report::paper::PaperError;
use morpho_fit::sweep::SweepError;
use morpho_fit::synthetic::SimulationError;
use morpho_fit::table::TableError;
use std::error::Error;
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

const READ_OR_WRITE: u8 = 1;
const USAGE: u8 = 2;
const BAD_DATA: u8 = 3;
const NOT_CONVERGED: u8 = 4;
const NOT_IDENTIFIABLE: u8 = 5;

/// How a command ended that could do its work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Everything asked for was done.
    Done,
    /// The fit found no minimum.
    NotConverged,
    /// The fit found a minimum, but not what was asked for; the reason in words.
    NotIdentifiable(String),
    /// Some of many items were not what was asked for: the code of the first cause, and the reason in words.
    Partly(u8, String),
}

impl Outcome {
    /// The exit code.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NotConverged => NOT_CONVERGED,
            Self::NotIdentifiable(_) => NOT_IDENTIFIABLE,
            Self::Partly(code, _) => *code,
        }
    }
}

/// A flag, or a combination of flags, that cannot be.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Usage(pub(crate) String);

/// A file whose content cannot be used; every defect has its own line.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct BadData(pub(crate) String);

/// Ends a run: tells an error on stderr and gives the code.
pub(crate) fn code(result: anyhow::Result<Outcome>) -> ExitCode {
    match result {
        Ok(outcome) => {
            if let Outcome::NotIdentifiable(reason) | Outcome::Partly(_, reason) = &outcome {
                output::complain(reason);
            }
            ExitCode::from(outcome.code())
        }
        // Whoever reads our output has seen enough.
        Err(error) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            output::complain(&message(&error));
            ExitCode::from(code_of(&error))
        }
    }
}

/// The error with its causes; findings about a file begin their lines with its name, as compilers do, and are counted.
fn message(error: &anyhow::Error) -> String {
    match error.chain().find_map(|cause| cause.downcast_ref::<Findings>()) {
        Some(findings) => {
            let total = findings.total();
            format!("the data cannot be used\n{findings}\n{total} {}", if total == 1 { "defect" } else { "defects" })
        }
        None => format!("{error:#}"),
    }
}

/// Ends a run whose command line was not understood, or asked for help.
pub(crate) fn of_command_line(error: &clap::Error, line: &[OsString]) -> ExitCode {
    match word_too_many(error, line) {
        Some(text) => output::complain(&text),
        // A closed pipe is no reason to complain.
        None => drop(error.print()),
    }
    if error.use_stderr() { ExitCode::from(USAGE) } else { ExitCode::SUCCESS }
}

/// What to say of a word behind a file, which clap takes for a command.
fn word_too_many(error: &clap::Error, line: &[OsString]) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    if error.kind() != ErrorKind::ArgumentConflict {
        return None;
    }
    let first = line.get(1).and_then(|first| first.to_str()).unwrap_or_default();
    let hint = if word.contains('=') {
        format!("several values of one flag are one word with commas, such as --fix d_air=141,{word}")
    } else if word.parse::<f64>().is_ok() {
        format!("a flag and its value are joined by =, such as --fix d_air={word}")
    } else if let Some(meant) = command_meant(first) {
        format!("did you mean `morpho-fit {meant}`?")
    } else {
        "a fit takes one file; `morpho-fit batch` takes several".to_owned()
    };
    Some(format!("`{word}` is one word too many: {hint}"))
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
}

/// The exit code of an error.
pub(crate) fn code_of(error: &anyhow::Error) -> u8 {
    error.chain().find_map(code_of_cause).unwrap_or(READ_OR_WRITE)
}

fn code_of_cause(cause: &(dyn Error + 'static)) -> Option<u8> {
    if cause.is::<Usage>() || cause.is::<SettingsError>() {
        return Some(USAGE);
    }
    if cause.is::<BadData>() || cause.is::<Findings>() {
        return Some(BAD_DATA);
    }
    if let Some(error) = cause.downcast_ref::<OpticsError>() {
        return Some(code_of_optics(error));
    }
    if let Some(SweepError::Optics(error)) = cause.downcast_ref() {
        return Some(code_of_optics(error));
    }
    if let Some(PaperError::Sweep(SweepError::Optics(error))) = cause.downcast_ref() {
        return Some(code_of_optics(error));
    }
    if let Some(error) = cause.downcast_ref::<TableError>() {
        return Some(match error {
            TableError::Optics(error) => code_of_optics(error),
            TableError::TooLarge { .. } | TableError::TooMany { .. } => NOT_CONVERGED,
            _ => USAGE,
        });
    }
    if let Some(error) = cause.downcast_ref::<RenderError>() {
        return Some(match error {
            RenderError::Optics(error) => code_of_optics(error),
            RenderError::Png { .. }
            | RenderError::Size { .. }
            | RenderError::Values { .. }
            | RenderError::Mismatch { .. }
            | RenderError::NoWing => BAD_DATA,
            RenderError::TooLarge { .. } => NOT_CONVERGED,
            _ => USAGE,
        });
    }
    if let Some(error) = cause.downcast_ref::<BsdfError>() {
        return Some(match error {
            BsdfError::Optics(error) => code_of_optics(error),
            BsdfError::TooLarge { .. } => NOT_CONVERGED,
            BsdfError::Nodes { .. } | BsdfError::Setting { .. } | BsdfError::Dark | BsdfError::Colour(_) => USAGE,
            _ => BAD_DATA,
        });
    }
    if let Some(error) = cause.downcast_ref::<SimulationError>() {
        return Some(match error {
            SimulationError::Optics(error) => code_of_optics(error),
            _ => USAGE,
        });
    }
    if let Some(error) = cause.downcast_ref::<DesignError>() {
        return match error {
            DesignError::Fit(error) => Some(code_of_fit(error)),
            DesignError::Optics(error) => Some(code_of_optics(error)),
            DesignError::Data(_) | DesignError::Advice(AdviceError::OtherData { .. } | AdviceError::Data(_)) => {
                Some(BAD_DATA)
            }
            DesignError::Advice(AdviceError::Optics(error)) => Some(code_of_optics(error)),
            _ => Some(USAGE),
        };
    }
    cause.downcast_ref::<FitError>().map(code_of_fit)
}

fn code_of_fit(error: &FitError) -> u8 {
    match error {
        FitError::Optics(error) => code_of_optics(error),
        FitError::TooFewReadings { .. } | FitError::Unit { .. } => BAD_DATA,
        FitError::NowhereFinite { .. } => NOT_CONVERGED,
        _ => USAGE,
    }
}

/// A table that does not reach the data is a fault of a file, everything else of a flag.
fn code_of_optics(error: &OpticsError) -> u8 {
    match error {
        OpticsError::OutsideTable { .. } | OpticsError::BadTable { .. } => BAD_DATA,
        _ => USAGE,
    }
}
