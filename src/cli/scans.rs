//! The design of a simulated measurement as it is written on the command line.

use crate::values::{nearest, number};
use morpho_fit::geometry::Polarization;
use morpho_fit::synthetic::Scan;
use morpho_fit::units::radians;

/// Readings of one scan at most; beyond it a mistyped step is likelier than a measurement.
const MOST_READINGS: usize = 2_000_000;
/// A range whose last step falls short of its end by less than this share of a step still has its end.
const SHORT_OF_THE_END: f64 = 1e-6;

/// One scan; its name may still have to be made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScanRequest {
    name: Option<String>,
    scan: Scan,
}

/// Values of one coordinate as they are written, in the users' unit.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Values(pub(crate) Vec<f64>);

/// Single values and ranges, with `|` between them.
pub(crate) fn values(text: &str) -> Result<Values, String> {
    range(text).map(Values)
}

/// The scans with a name each.
pub(crate) fn named(requests: &[ScanRequest]) -> Vec<Scan> {
    let only = requests.len() == 1;
    let name = |(index, request): (usize, &ScanRequest)| {
        let made = || if only { "data".to_owned() } else { format!("scan {}", index + 1) };
        Scan { name: request.name.clone().unwrap_or_else(made), ..request.scan.clone() }
    };
    requests.iter().enumerate().map(name).collect()
}

/// `wavelength=380:740:10,theta=0,phi=-60:60:5,omega=0|90,polarization=s,name=blue`.
pub(crate) fn parse(text: &str) -> Result<ScanRequest, String> {
    const KEYS: [&str; 6] = ["wavelength", "theta", "phi", "omega", "polarization", "name"];
    let mut name = None;
    let mut scan = Scan {
        name: String::new(),
        wavelengths: Vec::new(),
        thetas: vec![0.0],
        phis: vec![0.0],
        omegas: vec![0.0],
        polarization: Polarization::Unpolarized,
    };
    let mut seen: Vec<&str> = Vec::new();
    for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("`{part}` is no key=value"))?;
        let (key, value) = (key.trim(), value.trim());
        if seen.contains(&key) {
            return Err(format!("`{key}` is given twice; write single values as {key}=A|B"));
        }
        seen.push(key);
        let angles = || range(value).map(|degrees| degrees.into_iter().map(radians).collect());
        match key {
            "wavelength" => scan.wavelengths = range(value)?,
            "theta" => scan.thetas = angles()?,
            "phi" => scan.phis = angles()?,
            "omega" => scan.omegas = angles()?,
            "polarization" => scan.polarization = polarization(value)?,
            "name" if value.is_empty() => return Err("the name is empty".to_owned()),
            "name" => name = Some(value.to_owned()),
            _ => {
                let meant = nearest(key, &KEYS).map(|key| format!("did you mean `{key}`? ")).unwrap_or_default();
                return Err(format!("`{key}` is no key of a scan; {meant}There are {}", KEYS.join(", ")));
            }
        }
    }
    if scan.wavelengths.is_empty() {
        return Err("a scan needs wavelengths in nm, such as wavelength=380:740:10".to_owned());
    }
    let counts = [scan.wavelengths.len(), scan.thetas.len(), scan.phis.len(), scan.omegas.len()];
    let readings = counts.into_iter().try_fold(1_usize, usize::checked_mul);
    if readings.is_none_or(|readings| readings > MOST_READINGS) {
        return Err(format!("the scan has more than {MOST_READINGS} readings"));
    }
    Ok(ScanRequest { name, scan })
}

fn polarization(word: &str) -> Result<Polarization, String> {
    [Polarization::S, Polarization::P, Polarization::Unpolarized]
        .into_iter()
        .find(|polarization| polarization.word() == word)
        .ok_or_else(|| format!("`{word}` is not a polarization; allowed are s, p, unpolarized"))
}

/// Single values and ranges, with `|` between them.
fn range(text: &str) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    for piece in text.split('|') {
        match *piece.split(':').collect::<Vec<_>>().as_slice() {
            [value] => values.push(number(value)?),
            [start, stop, step] => values.extend(steps(number(start)?, number(stop)?, number(step)?)?),
            _ => return Err(format!("`{piece}` is neither a number nor START:STOP:STEP")),
        }
    }
    Ok(values)
}

fn steps(start: f64, stop: f64, step: f64) -> Result<Vec<f64>, String> {
    let count = (stop - start) / step;
    if !(step.abs() > 0.0 && count >= 0.0) {
        return Err(format!("the range {start}:{stop}:{step} never arrives; the step must lead from start to stop"));
    }
    #[allow(clippy::cast_precision_loss, reason = "a limit far below 2^53")]
    let most = MOST_READINGS as f64;
    if count >= most {
        return Err(format!("the range {start}:{stop}:{step} has more than {MOST_READINGS} values"));
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to the limit above")]
    let count = (count + SHORT_OF_THE_END).floor() as usize;
    #[allow(clippy::cast_precision_loss, reason = "a limit far below 2^53")]
    let value = |index: usize| {
        // Counted in steps from the start and freed from the last digits, so that 0.1 steps read as they are written.
        let value = start + index as f64 * step;
        (value * 1e9).round() / 1e9
    };
    Ok((0..=count).map(value).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_includes_both_ends() {
        assert_eq!(range("380:400:10"), Ok(vec![380.0, 390.0, 400.0]));
        assert_eq!(range("0:0.3:0.1").unwrap().len(), 4);
        assert_eq!(range("5:-5:-5|30"), Ok(vec![5.0, 0.0, -5.0, 30.0]));
        for wrong in ["0:10:0", "0:10:-1", "0:10", "a", "0:1e12:1e-3"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_scan_has_degrees_outside_and_radians_inside() {
        let request = parse("wavelength=400|500, omega=90, polarization=s, name=along").unwrap();
        assert_eq!(request.name.as_deref(), Some("along"));
        assert_eq!(request.scan.wavelengths, [400.0, 500.0]);
        assert_eq!(request.scan.omegas, [radians(90.0)]);
        assert_eq!(request.scan.polarization, Polarization::S);
        assert!(parse("theta=0").is_err());
        assert!(parse("wavelength=400,omgea=0").unwrap_err().contains("did you mean `omega`?"));
    }
}
