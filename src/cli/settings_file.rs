//! The settings file: TOML whose keys are the names of the flags. It is turned into arguments that stand before those of
//! the command line, so that a file and flags mean the same and a flag on the command line goes before the file.

use crate::args::{Cli, Command};
use crate::exit::Usage;
use crate::output;
use crate::values::nearest;
use anyhow::Result;
use clap::{ArgAction, CommandFactory, FromArgMatches};
use std::ffi::OsString;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Flags that a file cannot hold.
const NOT_IN_A_FILE: [&str; 3] = ["settings", "help", "version"];

/// The command line with the settings file that it names, if it names one.
pub(crate) fn merged(cli: Cli, line: &[OsString]) -> Result<Cli> {
    let (word, path) = match &cli.command {
        None => ("fit", &cli.fit.problem.settings),
        Some(Command::Fit(args)) => ("fit", &args.problem.settings),
        Some(Command::Profile(args)) => ("profile", &args.problem.settings),
        Some(Command::Bootstrap(args)) => ("bootstrap", &args.problem.settings),
        Some(Command::Sample(args)) => ("sample", &args.problem.settings),
        Some(Command::Constant(args)) => ("constant", &args.problem.settings),
        Some(Command::Batch(args)) => ("batch", &args.settings),
        Some(Command::Check(args)) => ("check", &args.problem.settings),
        Some(
            Command::Simulate(_)
            | Command::Curves(_)
            | Command::Sweep(_)
            | Command::Table(_)
            | Command::Render(_)
            | Command::Bsdf(_)
            | Command::ImportBsdf(_)
            | Command::Paper(_)
            | Command::Tradeoff(_),
        ) => return Ok(cli),
    };
    let Some(path) = path else { return Ok(cli) };
    let text = String::from_utf8(output::read(path)?)
        .map_err(|_| Usage(format!("{} is not UTF-8; save it as UTF-8", path.display())))?;
    let given = arguments(&text, path, word)?;
    let first = 1 + usize::from(cli.command.is_some());
    let whole = line.iter().take(first).cloned().chain(given.into_iter().map(OsString::from));
    let command = Cli::command().args_override_self(true).mut_subcommands(|word| word.args_override_self(true));
    let found = command.try_get_matches_from(whole.chain(line.iter().skip(first).cloned()));
    let cli = found.and_then(|matches| Cli::from_arg_matches(&matches));
    cli.map_err(|error| Usage(format!("{} and the command line: {}", path.display(), sentence(&error))).into())
}

/// The arguments that a file stands for.
fn arguments(text: &str, path: &Path, word: &str) -> Result<Vec<String>, Usage> {
    let place = |span: Range<usize>| {
        let line = 1 + text.get(..span.start).map_or(0, |before| before.matches('\n').count());
        format!("{}:{line}", path.display())
    };
    let table = DeTable::parse(text)
        .map_err(|error| Usage(format!("{}: {}", place(error.span().unwrap_or(0..0)), error.message())))?;
    let command = Cli::command();
    let known = |word: &str| {
        let flags = command.find_subcommand(word).into_iter().flat_map(|word| word.get_arguments());
        flags.filter(|flag| flag.get_long().is_some_and(|name| !NOT_IN_A_FILE.contains(&name))).collect::<Vec<_>>()
    };
    let (ours, every) = (known(word), known("fit"));
    let mut arguments = Vec::new();
    for (key, value) in table.get_ref() {
        let name = key.get_ref().as_ref();
        let find =
            |flags: &[&clap::Arg]| flags.iter().find(|flag| flag.get_long() == Some(name)).map(|flag| (*flag).clone());
        let Some(flag) = find(&ours) else {
            if find(&every).is_some() {
                continue; // for the fit, not for this word
            }
            let names: Vec<&str> = every.iter().filter_map(|flag| flag.get_long()).collect();
            let meant = nearest(name, &names).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
            let place = place(key.span());
            return Err(Usage(format!("{place}: `{name}` is no setting{meant} (settings are named like the flags)")));
        };
        let one = of_key(name, value, matches!(flag.get_action(), ArgAction::SetTrue))
            .map_err(|problem| Usage(format!("{}: {problem}", place(value.span()))))?;
        let alone = ["morpho-fit", word, "-"].into_iter().chain(one.iter().map(String::as_str));
        if let Err(error) = command.clone().args_override_self(true).try_get_matches_from(alone) {
            return Err(Usage(format!("{}: {}", place(value.span()), sentence(&error))));
        }
        arguments.extend(one);
    }
    Ok(arguments)
}

/// The arguments of one key: a scalar, a list, or a table of names.
fn of_key(key: &str, value: &Spanned<DeValue<'_>>, is_switch: bool) -> Result<Vec<String>, String> {
    let flag = |value: String| format!("--{key}={value}");
    match (value.get_ref(), is_switch) {
        (DeValue::Boolean(on), true) => Ok(on.then(|| format!("--{key}")).into_iter().collect()),
        (_, true) => Err(format!("`{key}` is true or false")),
        (DeValue::Array(list), false) => list.iter().map(|value| Ok(flag(scalar(key, value.get_ref())?))).collect(),
        (DeValue::Table(table), false) => {
            let entry = |(name, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                let name: &std::borrow::Cow<'_, str> = name.get_ref();
                let value = match value.get_ref() {
                    DeValue::Array(pair) => {
                        let ends: Result<Vec<String>, String> =
                            pair.iter().map(|end| scalar(key, end.get_ref())).collect();
                        ends?.join(":")
                    }
                    single => scalar(key, single)?,
                };
                Ok(flag(format!("{name}={value}")))
            };
            table.iter().map(entry).collect()
        }
        (single, false) => Ok(vec![flag(scalar(key, single)?)]),
    }
}

fn scalar(key: &str, value: &DeValue<'_>) -> Result<String, String> {
    match value {
        DeValue::String(text) => Ok(text.to_string()),
        DeValue::Integer(number) => Ok(number.to_string()),
        DeValue::Float(number) => Ok(number.to_string()),
        _ => Err(format!("`{key}` takes text or a number")),
    }
}

/// What the parser of the command line says, without its hints for a command line.
fn sentence(error: &clap::Error) -> String {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let end = text.find("\n\n").unwrap_or(text.len());
    text.get(..end).unwrap_or(text).trim().to_owned()
}
