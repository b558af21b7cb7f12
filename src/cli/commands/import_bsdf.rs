//! `morpho-fit import-bsdf`: a measured material as readings in planes.

use crate::args::ImportBsdfArgs;
use crate::args::WavelengthChoice;
use crate::exit::{BadData, Outcome, Usage};
use crate::output;
use anyhow::Result;
use morpho_fit::bsdf::{BsdfError, MeasuredBsdf, MeasuredFields};
use morpho_fit::dataset::{Dataset, Reading, to_csv};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::units::radians;

/// Readings at most; beyond it a mistyped step is likelier than a measurement.
const MOST_READINGS: usize = 2_000_000;

pub(crate) fn run(args: &ImportBsdfArgs) -> Result<Outcome> {
    let name = args.file.display().to_string();
    let bad = |error: BsdfError| BadData(format!("{name}: {error}"));
    let bytes = output::read(&args.file)?;
    let material = MeasuredFields::read(&bytes).and_then(MeasuredBsdf::new).map_err(bad)?;
    drop(bytes);
    let fields = material.fields();
    let Some(known) = &fields.wavelengths else {
        let problem = "red, green and blue only, from which nothing can be fitted; import the spectral file";
        return Err(BadData(format!("{name}: {problem}")).into());
    };
    let known: Vec<f64> = known.iter().copied().map(f64::from).collect();
    let (first, last) = (known.first().copied().unwrap_or_default(), known.last().copied().unwrap_or_default());
    let wavelengths = match &args.wavelengths {
        None => known,
        Some(WavelengthChoice::Within([low, high])) => {
            known.into_iter().filter(|wavelength| (low..=high).contains(&wavelength)).collect()
        }
        Some(WavelengthChoice::At(asked)) => asked.clone(),
    };
    if let (true, Some(WavelengthChoice::Within([low, high]))) = (wavelengths.is_empty(), &args.wavelengths)
        && *low <= last
        && *high >= first
    {
        let problem = format!(
            "--wavelengths: no wavelength of {name} lies from {low} to {high} nm; {low}:{high}:STEP takes values between those \
             that it has"
        );
        return Err(Usage(problem).into());
    }
    let outside = wavelengths.iter().find(|wavelength| !(first..=last).contains(*wavelength));
    if wavelengths.is_empty() || outside.is_some() {
        return Err(Usage(format!("--wavelengths: {name} has {first} to {last} nm")).into());
    }
    let planes = match &args.omega {
        Some(omega) => omega.0.clone(),
        None if material.is_isotropic() => vec![0.0],
        None => vec![0.0, 90.0],
    };
    let counts = [planes.len(), args.theta.0.len(), args.phi.0.len(), wavelengths.len()];
    if counts.into_iter().try_fold(1_usize, usize::checked_mul).is_none_or(|readings| readings > MOST_READINGS) {
        return Err(Usage(format!("more than {MOST_READINGS} readings; ask for fewer angles or wavelengths")).into());
    }
    let mut readings = Vec::new();
    for &omega in &planes {
        let azimuth = radians(omega + args.across);
        let direction = |angle: f64| [angle.sin() * azimuth.cos(), angle.sin() * azimuth.sin(), angle.cos()];
        for &theta in &args.theta.0 {
            for &wavelength in &wavelengths {
                for &phi in &args.phi.0 {
                    let geometry = Geometry { theta: radians(theta), phi: radians(phi), omega: radians(omega) };
                    let [incoming, outgoing] = [geometry.theta, geometry.phi].map(direction);
                    let intensity = material.evaluate_at(incoming, outgoing, wavelength).map_err(bad)?;
                    let polarization = Polarization::Unpolarized;
                    readings.push(Reading {
                        wavelength,
                        geometry,
                        polarization,
                        intensity,
                        sigma: None,
                        curve: 0,
                        line: 0,
                    });
                }
            }
        }
    }
    let data = Dataset::from_readings(readings, vec!["data".to_owned()]).map_err(|findings| findings.in_file(&name))?;
    let kind = if material.is_isotropic() { "isotropic" } else { "anisotropic" };
    let head = [
        format!("read by morpho-fit {} from {name}, {kind}", env!("CARGO_PKG_VERSION")),
        format!("description: {}", fields.description.trim()),
        format!("intensity = f_r cos(phi), 1/sr; across the ridges: azimuth {} deg of the file", args.across),
    ];
    let csv = to_csv(&data, &head);
    match &args.out {
        Some(path) => output::write(path, &csv)?,
        None => output::print(&csv)?,
    }
    Ok(Outcome::Done)
}
