//! `batch.csv` and `batch.json`: many fits as one table, a row an item.

use super::ExportError;
use super::curves::number;
use crate::inversion::{
    Estimate, FitOutcome, FitSettings, ModelChoice, Parameter, SigmaSource, Standing, Status, Verdict,
};
use serde::{Deserialize, Serialize};

/// Between warnings in one cell: they are sentences with semicolons.
pub(crate) const JOINT: &str = " | ";

/// Schema of `batch.json`.
pub const BATCH_SCHEMA: &str = "morpho-fit/batch/1";

/// What one fit says of one quantity, in the user's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BatchValue {
    /// Best value; none where the data do not determine it.
    pub value: Option<f64>,
    /// Its standard deviation; none where it means nothing. Of an ambiguous value that of one structure alone.
    pub sigma: Option<f64>,
    /// Its interval of 95 %, which spans every structure that fits as well; an open end, at a bound, is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_95: Option<[Option<f64>; 2]>,
    /// What can be said of it.
    pub status: Status,
}

/// The quantities of one fit: the five parameters and the two sums of the thicknesses, as in `fit.json`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BatchValues {
    /// Thickness of one air gap, nm.
    pub d_air: BatchValue,
    /// Thickness of one cuticle layer, nm.
    pub d_cuticle: BatchValue,
    /// Mean tilt of the layers, degrees.
    pub delta: BatchValue,
    /// Half-width of the lobe, rad.
    pub phi_alpha: BatchValue,
    /// Width of a lamella, nm.
    pub lamella_width: BatchValue,
    /// `d_air + d_cuticle`, nm.
    pub period: BatchValue,
    /// `n_gap d_air + n_cuticle d_cuticle` at the middle wavelength of the data, nm.
    pub optical_sum: BatchValue,
}

impl BatchValues {
    /// Name, unit and value of each, in the order of the columns.
    #[must_use]
    pub fn each(&self) -> [(&'static str, &'static str, &BatchValue); 7] {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = Parameter::ALL.map(|p| (p.name(), p.unit()));
        [
            (d_air.0, d_air.1, &self.d_air),
            (d_cuticle.0, d_cuticle.1, &self.d_cuticle),
            (delta.0, delta.1, &self.delta),
            (phi_alpha.0, phi_alpha.1, &self.phi_alpha),
            (lamella_width.0, lamella_width.1, &self.lamella_width),
            ("period", "nm", &self.period),
            ("optical_sum", "nm", &self.optical_sum),
        ]
    }
}

/// The fit of an item in short.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BatchFit {
    /// The model: `blend`, `hybrid` or `paper`; where it was chosen, the name of the variant that was kept.
    pub model: String,
    /// How it ended.
    pub verdict: Verdict,
    /// Sum of squared residuals, in units of sigma² where the data state one.
    pub chi2: f64,
    /// Degrees of freedom.
    pub dof: usize,
    /// Where the standard deviations come from; `widened` where the model misses the data.
    pub sigma_source: SigmaSource,
    /// What it found.
    pub values: BatchValues,
    /// What a reader must know, the most important first.
    pub warnings: Vec<String>,
}

impl BatchFit {
    /// Whether the model misses the data.
    #[must_use]
    pub fn misses(&self) -> bool {
        self.sigma_source == SigmaSource::Widened
    }

    /// The outcome of a fit in short.
    #[must_use]
    pub fn of(outcome: &FitOutcome) -> Self {
        let short = |estimate: &Estimate| BatchValue {
            value: estimate.value,
            sigma: estimate.value.and(estimate.sigma),
            interval_95: estimate.value.and(estimate.interval_95),
            status: estimate.status,
        };
        let (parameters, derived) = (&outcome.parameters, &outcome.derived);
        let kept = outcome.choice.iter().flat_map(|choice| &choice.variants).find(|v| v.standing == Standing::Kept);
        Self {
            model: kept.map_or_else(|| name(outcome.settings.model).to_owned(), |variant| variant.name.clone()),
            verdict: outcome.verdict,
            chi2: outcome.chi2,
            dof: outcome.dof,
            sigma_source: outcome.sigma_source,
            values: BatchValues {
                d_air: short(&parameters.d_air),
                d_cuticle: short(&parameters.d_cuticle),
                delta: short(&parameters.delta),
                phi_alpha: short(&parameters.phi_alpha),
                lamella_width: short(&parameters.lamella_width),
                period: short(&derived.period),
                optical_sum: short(&derived.optical_sum),
            },
            warnings: outcome.warnings.clone(),
        }
    }
}

/// One item: a file, or a part of one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BatchRow {
    /// Its name.
    pub item: String,
    /// Where it lies in a map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<[f64; 2]>,
    /// SHA-256 of its data, hexadecimal; none if they could not be read.
    pub sha256: Option<String>,
    /// SHA-256 of the `fit.json` in its folder, hexadecimal; none if it was given no folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub report_sha256: Option<String>,
    /// Its fit; none if there is an error.
    pub fit: Option<BatchFit>,
    /// Why there is no fit.
    pub error: Option<String>,
}

/// How many items ended how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct BatchCounts {
    /// Items.
    pub items: usize,
    /// Everything free is determined.
    pub determined: usize,
    /// A part of it is.
    pub partly_determined: usize,
    /// No thickness is, not even the sum.
    pub no_thickness: usize,
    /// No minimum was found.
    pub not_converged: usize,
    /// Nothing was free.
    #[serde(default)]
    pub given: usize,
    /// Data that cannot be used, or a fit that could not begin.
    pub errors: usize,
    /// The model misses the data, however it ended.
    #[serde(default)]
    pub missed: usize,
}

impl BatchCounts {
    /// Counts the rows.
    #[must_use]
    pub fn of(rows: &[BatchRow]) -> Self {
        let mut counts = Self { items: rows.len(), ..Self::default() };
        for row in rows {
            let count = match row.fit.as_ref().map(|fit| fit.verdict) {
                None => &mut counts.errors,
                Some(Verdict::Determined) => &mut counts.determined,
                Some(Verdict::PartlyDetermined) => &mut counts.partly_determined,
                Some(Verdict::NoThickness) => &mut counts.no_thickness,
                Some(Verdict::NotConverged) => &mut counts.not_converged,
                Some(Verdict::Given) => &mut counts.given,
            };
            *count += 1;
            counts.missed += usize::from(row.fit.as_ref().is_some_and(BatchFit::misses));
        }
        counts
    }
}

/// Everything that `batch.json` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Batch {
    /// [`BATCH_SCHEMA`].
    pub schema: String,
    /// Name and version of the program.
    pub program: String,
    /// SHA-256 of program and settings, hexadecimal: rows with the same one are of the same fit.
    pub settings_sha256: String,
    /// Every choice of the fits, inside units (nm, rad).
    pub settings: FitSettings,
    /// Models whose variants were compared with those of the settings' own; none where no model was chosen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<Vec<ModelChoice>>,
    /// Seed of the random starts.
    pub seed: u64,
    /// Columns by which the rows of the file are told apart; empty where each file is an item.
    pub by: Vec<String>,
    /// Whether each item has a folder of results, and what is in it: `none`, `without_plots`, `with_plots`.
    pub reports: String,
    /// How many items ended how.
    pub counts: BatchCounts,
    /// The items in the order in which they were given.
    pub items: Vec<BatchRow>,
}

/// The batch as indented JSON with a line feed at its end; numbers are the shortest text with the same bits.
///
/// # Errors
/// [`ExportError::Json`] if the writer fails.
pub fn batch_json(batch: &Batch) -> Result<Vec<u8>, ExportError> {
    let mut bytes = serde_json::to_vec_pretty(batch)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A row an item: `item`, or both columns of the map under their own names; `model`, `verdict`, `chi2`, `dof`; value,
/// standard deviation, status and ends of the interval of 95 % of each quantity (`d_air_nm`, `d_air_sigma_nm`, `d_air_status`,
/// `d_air_low_95_nm`, `d_air_high_95_nm`, …); `warnings`, joined by ` | `; `sha256` of the data; `error`.
///
/// Cells are empty where there is no value. Numbers are the shortest text with the same bits.
///
/// # Errors
/// [`ExportError::Csv`] if the writer fails.
pub fn batch_csv(batch: &Batch) -> Result<Vec<u8>, ExportError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let place = match batch.by.as_slice() {
        [x, y] => Some([x.clone(), y.clone()]),
        _ => None,
    };
    let mut headings: Vec<String> = place.clone().map_or_else(|| vec!["item".to_owned()], Vec::from);
    headings.extend(["model", "verdict", "chi2", "dof", "sigma_source"].map(str::to_owned));
    for (name, unit, _) in nothing().each() {
        headings.extend([format!("{name}_{unit}"), format!("{name}_sigma_{unit}"), format!("{name}_status")]);
        headings.extend(["low", "high"].map(|end| format!("{name}_{end}_95_{unit}")));
    }
    headings.extend(["warnings", "sha256", "error"].map(str::to_owned));
    writer.write_record(&headings)?;
    for row in &batch.items {
        let mut cells = match (&place, row.place) {
            (Some(_), Some(at)) => at.map(number).to_vec(),
            (Some(_), None) => vec![row.item.clone(), String::new()],
            (None, _) => vec![row.item.clone()],
        };
        match &row.fit {
            Some(fit) => {
                cells.extend([fit.model.clone(), word(&fit.verdict)?, number(fit.chi2), fit.dof.to_string()]);
                cells.push(word(&fit.sigma_source)?);
                for (_, _, found) in fit.values.each() {
                    let text = |value: Option<f64>| value.map(number).unwrap_or_default();
                    let [low, high] = found.interval_95.unwrap_or_default();
                    cells.extend([text(found.value), text(found.sigma), word(&found.status)?, text(low), text(high)]);
                }
                cells.push(fit.warnings.join(JOINT));
            }
            None => cells.resize(headings.len() - 2, String::new()),
        }
        cells.extend([row.sha256.clone().unwrap_or_default(), row.error.clone().unwrap_or_default()]);
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()).into())
}

/// The name of a model in `fit.json`.
fn name(model: ModelChoice) -> &'static str {
    match model {
        ModelChoice::Blend => "blend",
        ModelChoice::Hybrid { .. } => "hybrid",
        ModelChoice::Paper { .. } => "paper",
    }
}

/// The word that JSON has for it.
pub(crate) fn word(value: &impl Serialize) -> Result<String, ExportError> {
    Ok(serde_json::to_value(value)?.as_str().unwrap_or_default().to_owned())
}

/// Values for the names alone.
pub(crate) fn nothing() -> BatchValues {
    let none = BatchValue { value: None, sigma: None, interval_95: None, status: Status::NotIdentifiable };
    BatchValues {
        d_air: none,
        d_cuticle: none,
        delta: none,
        phi_alpha: none,
        lamella_width: none,
        period: none,
        optical_sum: none,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batch(by: &[&str]) -> Batch {
        let fit = BatchFit {
            model: "blend + tilt".to_owned(),
            verdict: Verdict::PartlyDetermined,
            chi2: 12.5,
            dof: 9,
            sigma_source: SigmaSource::Stated,
            values: BatchValues {
                d_air: BatchValue {
                    value: Some(0.1),
                    sigma: Some(2e-7),
                    interval_95: Some([None, Some(0.3)]),
                    status: Status::Ambiguous,
                },
                ..nothing()
            },
            warnings: vec!["one, two".to_owned(), "three".to_owned()],
        };
        let row = BatchRow {
            item: "a,b".to_owned(),
            place: Some([1.0, -2.5]),
            sha256: Some("00ff".to_owned()),
            report_sha256: None,
            fit: Some(fit),
            error: None,
        };
        let bad =
            BatchRow { place: None, sha256: None, fit: None, error: Some("no \"data\"".to_owned()), ..row.clone() };
        let items = vec![row, bad];
        Batch {
            schema: BATCH_SCHEMA.to_owned(),
            program: "p".to_owned(),
            settings_sha256: "s".to_owned(),
            settings: FitSettings::default(),
            compared: Some(vec![ModelChoice::Hybrid { ridge_spacing: 750.0 }]),
            seed: 1,
            by: by.iter().map(|name| (*name).to_owned()).collect(),
            reports: "none".to_owned(),
            counts: BatchCounts::of(&items),
            items,
        }
    }

    /// Read by the csv crate, with the names that DESIGN gives.
    #[test]
    fn every_row_has_a_cell_for_every_heading() {
        for (by, first) in [(vec![], vec!["item"]), (vec!["pixel"], vec!["item"]), (vec!["x", "y"], vec!["x", "y"])] {
            let bytes = batch_csv(&batch(&by)).unwrap();
            let mut reader = csv::Reader::from_reader(bytes.as_slice());
            let headings = reader.headers().unwrap().clone();
            let mut expected = first.clone();
            expected.extend([
                "model",
                "verdict",
                "chi2",
                "dof",
                "sigma_source",
                "d_air_nm",
                "d_air_sigma_nm",
                "d_air_status",
            ]);
            assert_eq!(headings.iter().take(expected.len()).collect::<Vec<_>>(), expected);
            assert_eq!(headings.iter().rev().take(3).collect::<Vec<_>>(), ["error", "sha256", "warnings"]);
            assert_eq!(headings.len(), first.len() + 5 + 35 + 3);
            let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
            let cell = |row: usize, name: &str| &rows[row][headings.iter().position(|head| head == name).unwrap()];
            assert_eq!((cell(0, "d_air_nm"), cell(0, "d_air_sigma_nm")), ("0.1", "2e-7"));
            assert_eq!((cell(0, "d_air_low_95_nm"), cell(0, "d_air_high_95_nm")), ("", "0.3"));
            assert_eq!((cell(0, "d_air_status"), cell(0, "verdict")), ("ambiguous", "partly_determined"));
            assert_eq!((cell(0, "model"), cell(1, "model")), ("blend + tilt", ""));
            assert_eq!((cell(0, "delta_deg"), cell(0, "delta_status")), ("", "not_identifiable"));
            assert_eq!((cell(0, "warnings"), cell(1, "error")), ("one, two | three", "no \"data\""));
            assert_eq!((cell(1, "verdict"), cell(1, "sha256")), ("", ""));
            assert_eq!(cell(0, first[0]), if first.len() == 2 { "1" } else { "a,b" });
        }
    }

    #[test]
    fn a_model_has_the_name_of_its_json() {
        let hybrid = ModelChoice::Hybrid { ridge_spacing: 750.0 };
        let paper = ModelChoice::Paper {
            snell: Default::default(),
            admittance: Default::default(),
            lamella_unit: Default::default(),
        };
        for model in [ModelChoice::Blend, hybrid, paper] {
            assert_eq!(serde_json::to_value(model).unwrap()["name"], name(model));
        }
    }

    #[test]
    fn the_json_reads_back_to_the_same_batch() {
        let batch = batch(&["x", "y"]);
        let again: Batch = serde_json::from_slice(&batch_json(&batch).unwrap()).unwrap();
        assert_eq!(again, batch);
        assert_eq!(batch.counts, BatchCounts { items: 2, partly_determined: 1, errors: 1, ..BatchCounts::default() });
    }
}
