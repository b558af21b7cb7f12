//! A dataset as CSV bytes that [`read_csv`](super::read_csv) reads back.

use std::collections::{BTreeMap, HashMap};

use csv::{QuoteStyle, WriterBuilder};
use thiserror::Error;

use super::cells::plain;
use super::options::WideHeading;
use super::{Dataset, Reading};
use crate::geometry::Polarization;
use crate::units::degrees;

/// Why a dataset is not a wide table.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum NotWide {
    /// A quantity that is neither rows nor headings has more than one value.
    #[error("`{column}` takes more than one value; a wide table has room for one")]
    Varies {
        /// Name of its column in the tidy form.
        column: &'static str,
    },
    /// The table would have an empty cell.
    #[error("there is no reading at {wavelength} nm for `{heading}`; a wide table needs one in every cell")]
    Gap {
        /// Wavelength of the row, nm.
        wavelength: f64,
        /// Heading of the column: an angle in degrees, or the name of a record.
        heading: String,
    },
}

/// Writes the tidy form, one reading a row in the order of the dataset, after `header_comments` as `#` lines.
///
/// Columns `sigma`, `curve` and `polarization` are there only if they say something. Numbers are the shortest text
/// with the same bits; angles are in degrees rounded to 1e-9, far below any goniometer, so that 90 is written `90`.
/// Records are read back in the order of their first reading.
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, read_csv, to_csv};
///
/// let csv = b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,30,90,0.42\n";
/// let dataset = read_csv(csv, &ReadOptions::default())?;
/// assert_eq!(to_csv(&dataset, &[]), csv);
/// # Ok::<(), morpho_fit::dataset::Findings>(())
/// ```
#[must_use]
pub fn to_csv(dataset: &Dataset, header_comments: &[String]) -> Vec<u8> {
    let with_polarization = dataset.readings().iter().any(|reading| reading.polarization != Polarization::Unpolarized);
    let with_curve = dataset.curves() != ["data"];
    let optional = |wanted: bool, text: &str| wanted.then(|| text.to_owned());
    let mut rows = Vec::with_capacity(dataset.readings().len() + 1);
    let fixed = ["wavelength_nm", "theta_deg", "phi_deg", "omega_deg", "intensity"].map(str::to_owned);
    let mut headings: Vec<String> = fixed.into();
    headings.extend(optional(dataset.has_sigma(), "sigma"));
    headings.extend(optional(with_curve, "curve"));
    headings.extend(optional(with_polarization, "polarization"));
    rows.push(headings);
    for reading in dataset.readings() {
        let geometry = reading.geometry;
        let mut row = vec![plain(reading.wavelength)];
        row.extend([geometry.theta, geometry.phi, geometry.omega].map(angle));
        row.push(plain(reading.intensity));
        row.extend(reading.sigma.map(plain));
        row.extend(optional(with_curve, curve_of(dataset, reading)));
        row.extend(optional(with_polarization, reading.polarization.word()));
        rows.push(row);
    }
    bytes(header_comments, &rows)
}

/// Writes a wide table: a row for each wavelength, rising, and a column for each angle, rising, or record.
///
/// A comment says which flags read it back; the name of a single record and the order of the readings are not kept.
///
/// # Errors
/// [`NotWide`] if the table would need more than one value of anything else (sigma included), or have an empty cell.
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, WideHeading, read_csv, to_wide_csv};
///
/// let csv = b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,30,90,0.4\n450,5,30,90,0.3\n";
/// let dataset = read_csv(csv, &ReadOptions::default())?;
/// let wide = to_wide_csv(&dataset, WideHeading::Theta, &[])?;
/// assert_eq!(wide, b"# --wide theta --phi 30 --omega 90\nwavelength_nm,0,5\n450,0.4,0.3\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn to_wide_csv(dataset: &Dataset, heading: WideHeading, header_comments: &[String]) -> Result<Vec<u8>, NotWide> {
    let mut comments = header_comments.to_vec();
    comments.push(flags(dataset, heading)?);

    // Bits of a positive number sort like the number; angles are sorted after.
    let mut table: BTreeMap<u64, HashMap<String, f64>> = BTreeMap::new();
    let mut columns: Vec<(f64, String)> = Vec::new();
    for reading in dataset.readings() {
        let (order, name) = match heading {
            WideHeading::Theta => (reading.geometry.theta, angle(reading.geometry.theta)),
            WideHeading::Phi => (reading.geometry.phi, angle(reading.geometry.phi)),
            WideHeading::Curve => (0.0, curve_of(dataset, reading).to_owned()),
        };
        let row = table.entry(reading.wavelength.to_bits()).or_default();
        if row.insert(name.clone(), reading.intensity).is_none() && !columns.iter().any(|(_, known)| *known == name) {
            columns.push((order, name));
        }
    }
    // Stable: records keep the order of their first reading.
    columns.sort_by(|(left, _), (right, _)| left.total_cmp(right));

    let mut headings = vec!["wavelength_nm".to_owned()];
    headings.extend(columns.iter().map(|(_, name)| name.clone()));
    let mut rows = vec![headings];
    for (wavelength, cells) in &table {
        let wavelength = f64::from_bits(*wavelength);
        let mut row = vec![plain(wavelength)];
        for (_, name) in &columns {
            let value = cells.get(name).ok_or_else(|| NotWide::Gap { wavelength, heading: name.clone() })?;
            row.push(plain(*value));
        }
        rows.push(row);
    }
    Ok(bytes(&comments, &rows))
}

/// The flags that a wide table is read with; everything but wavelength and headings has to be the same throughout.
fn flags(dataset: &Dataset, heading: WideHeading) -> Result<String, NotWide> {
    let mut flags = format!("--wide {}", heading.quantity());
    let mut constant = |column: &'static str, flag: &str, text: &dyn Fn(&Reading) -> Option<String>| {
        let mut values = dataset.readings().iter().map(text);
        let first = values.next().flatten();
        if values.any(|value| value != first) {
            return Err(NotWide::Varies { column });
        }
        if let Some(value) = first.filter(|_| !flag.is_empty()) {
            flags.push_str(&format!(" {flag} {value}"));
        }
        Ok(())
    };
    if heading != WideHeading::Theta {
        constant("theta_deg", "--theta", &|reading| Some(angle(reading.geometry.theta)))?;
    }
    if heading != WideHeading::Phi {
        constant("phi_deg", "--phi", &|reading| Some(angle(reading.geometry.phi)))?;
    }
    constant("omega_deg", "--omega", &|reading| Some(angle(reading.geometry.omega)))?;
    constant("sigma", "--sigma", &|reading| reading.sigma.map(plain))?;
    let word = |polarization: Polarization| Some(polarization.word().to_owned());
    constant("polarization", "--polarization", &|reading| {
        word(reading.polarization).filter(|_| reading.polarization != Polarization::Unpolarized)
    })?;
    if heading != WideHeading::Curve {
        constant("curve", "", &|reading| Some(reading.curve.to_string()))?;
    }
    Ok(flags)
}

fn curve_of<'a>(dataset: &'a Dataset, reading: &Reading) -> &'a str {
    dataset.curves().get(reading.curve).map_or("", String::as_str)
}

/// Degrees to nine decimals; adding 0 turns -0 into 0.
fn angle(radians: f64) -> String {
    plain((degrees(radians) * 1e9).round() / 1e9 + 0.0)
}

fn bytes(comments: &[String], rows: &[Vec<String>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for line in comments.iter().flat_map(|comment| comment.split('\n')) {
        // Other control characters would be defects of the file.
        let line: String = line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        bytes.extend_from_slice(format!("# {line}").trim_end().as_bytes());
        bytes.push(b'\n');
    }
    // The reader would take a semicolon in the heading line for the separator, unless it is quoted.
    let ambiguous = rows.first().is_some_and(|headings| headings.iter().any(|heading| heading.contains(';')));
    let style = if ambiguous { QuoteStyle::NonNumeric } else { QuoteStyle::Necessary };
    let mut writer = WriterBuilder::new().quote_style(style).from_writer(bytes);
    let written = rows.iter().try_for_each(|row| writer.write_record(row));
    // Writing to memory does not fail; if it did, the reader would tell of a file without readings.
    match (written, writer.into_inner()) {
        (Ok(()), Ok(bytes)) => bytes,
        _ => Vec::new(),
    }
}
