//! Observer, light and wavelengths as they are asked for.

use crate::args::{GridChoice, ViewingArgs};
use crate::exit::{BadData, Usage};
use crate::output;
use anyhow::Result;
use csv::{ReaderBuilder, Trim};
use morpho_fit::colorimetry::{GamutMapping, Illuminant, Integration, PowerTable, RgbSpace, RgbTransform};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::sweep::{Grid, Viewing};
use std::path::Path;

pub(crate) fn viewing(args: &ViewingArgs) -> Result<(Viewing, GamutMapping)> {
    let grid = match args.wavelengths {
        GridChoice::Auto => Grid::Within(args.max_difference),
        GridChoice::Of(wavelengths) => Grid::Of(wavelengths),
    };
    let viewing = Viewing { observer: args.observer.value(), illuminant: illuminant(&args.illuminant)?, grid };
    let used = if let Grid::Of(wavelengths) = grid { wavelengths } else { Wavelengths::finest() };
    let white = Integration::new(&used, viewing.observer, &viewing.illuminant).map(|integration| integration.white());
    let display = white.and_then(|white| RgbTransform::adapted(RgbSpace::Srgb, white));
    display.map_err(|error| BadData(format!("{}: {error}", args.illuminant)))?;
    Ok((viewing, args.gamut.value()))
}

fn illuminant(word: &str) -> Result<Illuminant> {
    Ok(match word {
        "D65" | "d65" => Illuminant::D65,
        "A" | "a" => Illuminant::A,
        "E" | "e" => Illuminant::E,
        path if Path::new(path).exists() => Illuminant::Measured(table(Path::new(path))?),
        other => {
            let message = format!("--illuminant: `{other}` is neither D65, A, E nor a file that exists");
            return Err(Usage(message).into());
        }
    })
}

/// A table of power with the columns `wavelength_nm` and `power`.
fn table(path: &Path) -> Result<PowerTable> {
    let bytes = output::read(path)?;
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    let file = path.display();
    let mut reader = ReaderBuilder::new().comment(Some(b'#')).trim(Trim::All).from_reader(bytes);
    let bad = |problem: String| BadData(format!("{file}:{problem}"));
    let headings = reader.headers().map_err(|error| bad(format!(" {error}")))?.clone();
    let column = |name: &str| {
        let missing = || bad(format!("1: column `{name}` is missing; a light has the columns wavelength_nm and power"));
        headings.iter().position(|heading| heading == name).ok_or_else(missing)
    };
    let columns = [column("wavelength_nm")?, column("power")?];
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| bad(format!(" {error}")))?;
        let line = record.position().map_or(0, csv::Position::line);
        let cell = |index: usize| {
            let text = record.get(index).unwrap_or_default();
            let problem = || bad(format!("{line}:{}: `{text}` is not a number", index + 1));
            text.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(problem)
        };
        rows.push([cell(columns[0])?, cell(columns[1])?]);
    }
    Ok(PowerTable::new(rows).map_err(|error| BadData(format!("{file}: {error}")))?)
}
