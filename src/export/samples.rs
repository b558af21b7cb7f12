//! `profile.csv`, `bootstrap.csv` and `posterior.csv`: what intervals were read off from.

use super::ExportError;
use super::curves::number;
use crate::inversion::intervals::{Bootstrap, Posterior, Profiles, Resampling};
use crate::inversion::{COUNT, Parameter};

/// A column's heading: the name with its unit.
fn heading(name: &str, unit: &str) -> String {
    format!("{name}_{unit}")
}

fn parameters() -> [String; COUNT] {
    Parameter::ALL.map(|parameter| heading(parameter.name(), parameter.unit()))
}

/// Every point of every profile: quantity, its value and unit, Δchi² in units of the squared standard deviation of a
/// weighted residual, and the five parameters there.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn profile_csv(profiles: &Profiles) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["quantity", "unit", "value", "delta_chi2"].map(str::to_owned);
    writer.write_record(head.into_iter().chain(parameters()))?;
    for profile in &profiles.quantities {
        for ((value, excess), parameters) in profile.values.iter().zip(&profile.excess).zip(&profile.parameters) {
            let head = [profile.name.to_owned(), profile.unit.to_owned(), number(*value), number(*excess)];
            writer.write_record(head.into_iter().chain(parameters.map(number)))?;
        }
    }
    finish(writer)
}

/// Every replicate of every bootstrap: what was drawn again, its number, and a column for each quantity.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn bootstrap_csv(bootstraps: &[Bootstrap]) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    if let Some(first) = bootstraps.first() {
        let head = ["resampling", "replicate"].map(str::to_owned);
        writer.write_record(head.into_iter().chain(headings(&first.names, &first.units)))?;
    }
    for bootstrap in bootstraps {
        let word = match bootstrap.resampling {
            Resampling::Residuals => "residuals",
            Resampling::Cases => "cases",
        };
        for (index, row) in bootstrap.replicates.iter().enumerate() {
            let head = [word.to_owned(), (index + 1).to_string()];
            writer.write_record(head.into_iter().chain(row.iter().copied().map(number)))?;
        }
    }
    finish(writer)
}

/// Every sample of the posterior: chain, step, and a column for each quantity.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn posterior_csv(posterior: &Posterior) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["chain", "step"].map(str::to_owned);
    writer.write_record(head.into_iter().chain(headings(&posterior.names, &posterior.units)))?;
    let steps = (posterior.samples.len() / posterior.chains.max(1)).max(1);
    for (index, row) in posterior.samples.iter().enumerate() {
        let head = [(index / steps + 1).to_string(), (index % steps + 1).to_string()];
        writer.write_record(head.into_iter().chain(row.iter().copied().map(number)))?;
    }
    finish(writer)
}

fn headings<'a>(names: &'a [&'static str], units: &'a [&'static str]) -> impl Iterator<Item = String> + 'a {
    names.iter().zip(units).map(|(name, unit)| heading(name, unit))
}

fn finish(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, ExportError> {
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}
