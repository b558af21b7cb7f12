//! `constant.json` and `constant.csv`: a constant of the model fitted beside the parameters.

use super::ExportError;
use super::curves::number;
use crate::inversion::Parameter;
use crate::inversion::intervals::ConstantProfile;
use serde_json::json;

/// Schema of `constant.json`.
pub const CONSTANT_SCHEMA: &str = "morpho-fit/constant/1";

/// The constant, the quantities with it fitted, and the fit at its best value as in `fit.json`, as indented JSON.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn constant_json(found: &ConstantProfile) -> Result<Vec<u8>, ExportError> {
    let whole = json!({
        "schema": CONSTANT_SCHEMA,
        "constant": found.constant,
        "unit": found.constant.unit(),
        "told": found.told,
        "value": found.best,
        "at_end_of_range": found.at_end,
        "range": found.limits,
        "interval_68": found.intervals.interval_68,
        "interval_95": found.intervals.interval_95,
        "quantities": found.quantities,
        "fit": found.fit.outcome,
    });
    let mut bytes = serde_json::to_vec_pretty(&whole)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Every point of the profile: the constant, Δchi² in units of the squared standard deviation of a weighted residual, and the
/// five parameters there.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn constant_csv(found: &ConstantProfile) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let heading = |name: &str, unit: &str| if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") };
    let head = [heading(found.constant.name(), found.constant.unit()), "delta_chi2".to_owned()];
    let parameters = Parameter::ALL.map(|parameter| heading(parameter.name(), parameter.unit()));
    writer.write_record(head.into_iter().chain(parameters))?;
    for ((value, excess), parameters) in found.values.iter().zip(&found.excess).zip(&found.parameters) {
        writer.write_record([*value, *excess].into_iter().chain(*parameters).map(number))?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}
