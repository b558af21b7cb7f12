//! `morpho-fit simulate`: a measurement from known parameters, with the command that makes it again in its head.

use crate::args::SimulateArgs;
use crate::exit::{Outcome, Usage};
use crate::{options, output, scans};
use anyhow::Result;
use morpho_fit::dataset::{Dataset, Reading, to_csv, to_wide_csv};
use morpho_fit::inversion::Parameter;
use morpho_fit::optics::Structure;
use morpho_fit::synthetic::{Scan, simulate};
use std::ffi::OsString;

pub(crate) fn run(args: &SimulateArgs, line: &[OsString]) -> Result<Outcome> {
    options::one_model(&args.model)?;
    let measurement = &args.measurement;
    let structure = options::structure(&args.structure, options::preset(&args.structure));
    let model = options::forward(&args.model)?;
    let scans = match measurement.scan.as_slice() {
        [] => Scan::full_design(model.as_ref(), &structure)?,
        requests => scans::named(requests),
    };
    let (scale, noise, seed) = (measurement.scale, measurement.noise, measurement.seed);
    let mut data = simulate(model.as_ref(), &structure, &scans, scale, noise, seed)?;
    if measurement.no_sigma {
        let bare = data.readings().iter().map(|reading| Reading { sigma: None, ..*reading }).collect();
        data = Dataset::from_readings(bare, data.curves().to_vec())?;
    }
    let head = head(&structure, line);
    let bytes = match measurement.wide {
        None => to_csv(&data, &head),
        Some(word) => to_wide_csv(&data, word.value(), &head)
            .map_err(|problem| Usage(format!("--wide: {problem}; give one --scan that fits, or leave --wide out")))?,
    };
    match &measurement.out {
        Some(path) => output::write(path, &bytes)?,
        None => output::print(&bytes)?,
    }
    Ok(Outcome::Done)
}

/// What a reader of the file must know: that it is not measured, what is in it, and how to make it again.
fn head(structure: &Structure, line: &[OsString]) -> Vec<String> {
    let values = morpho_fit::inversion::values(structure);
    let truth = |parameter: &Parameter| {
        let value = parameter.outside(values[parameter.index()]);
        // Degrees without the last digits of their conversion.
        let value = (value * 1e9).round() / 1e9 + 0.0;
        format!("{parameter} = {value} {}", parameter.unit())
    };
    let truths: Vec<String> = Parameter::ALL.iter().map(truth).collect();
    vec![
        format!("simulated by morpho-fit {}, not measured", env!("CARGO_PKG_VERSION")),
        format!("command: {}", command(line)),
        format!("truth: {}", truths.join(", ")),
    ]
}

/// The command without the name of its output, quoted for a shell.
fn command(line: &[OsString]) -> String {
    let mut words = vec!["morpho-fit".to_owned()];
    let mut skip = false;
    for word in line.iter().skip(1).map(|word| word.to_string_lossy()) {
        if std::mem::take(&mut skip) || word.starts_with("--out=") {
            continue;
        }
        if word == "--out" {
            skip = true;
            continue;
        }
        words.push(quoted(&word));
    }
    words.join(" ")
}

fn quoted(word: &str) -> String {
    let safe = |c: char| c.is_alphanumeric() || "-_=+.,:/@%".contains(c);
    if !word.is_empty() && word.chars().all(safe) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_is_quoted_and_names_no_output() {
        let line =
            ["/bin/morpho-fit", "simulate", "--out", "x.csv", "--scan", "wavelength=400|500", "--out=y", "--seed=2"];
        let line: Vec<OsString> = line.into_iter().map(OsString::from).collect();
        assert_eq!(command(&line), "morpho-fit simulate --scan 'wavelength=400|500' --seed=2");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
