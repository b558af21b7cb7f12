//! Scans that an experimenter could add to a measurement, the simplest first.

use crate::geometry::{Geometry, Polarization};
use crate::inversion::parameter::{COUNT, structure};
use crate::optics::{Contribution, OpticsError, ReflectivityModel, Structure, lobe};
use crate::synthetic::{Scan, linspace};
use crate::units::{degrees, radians};

/// Incidence angles of the spectra, degrees.
const SPECTRA: [f64; 4] = [0.0, 20.0, 40.0, 60.0];
/// Incidence of the polarized spectra, degrees: s and p are alike at small angles.
const POLARIZED: f64 = 60.0;
/// Incidence angles of the phi scans, degrees.
const SCANS: [f64; 2] = [0.0, 30.0];
/// Wavelengths of the phi scans beside the peaks of the structure, nm.
const WAVELENGTHS: [f64; 5] = [420.0, 460.0, 500.0, 550.0, 600.0];
/// A spectrum is taken in the mirror direction of the scale if the lobe lets so much through there.
const SEEN: f64 = 0.5;
/// Fewer wavelengths that the media are known at make no spectrum.
const LEAST: usize = 5;

/// Spectra from 380 to 740 nm by 10, and phi scans from -60° to 60° by 2.5°; only at wavelengths at which the media are
/// known. The name of a scan says in words what it is.
///
/// - `values`: the structure that the scans are for, inside units. A spectrum looks along `phi = -theta`, or, if the lobe
///   of the tilted layers does not reach it, along `2 delta - theta` to 5°. Phi scans are at the peaks of the structure too.
pub(crate) fn candidates(model: &dyn ReflectivityModel, values: &[f64; COUNT]) -> Vec<Scan> {
    let of = structure(values);
    let known = |wavelength: &f64| model.stack().media(*wavelength).is_ok();
    let wavelengths: Vec<f64> = linspace(380.0, 740.0, 37).into_iter().filter(known).collect();
    let mut scans = Vec::new();
    let spectrum = |theta: f64, omega: f64, polarization| spectrum(&of, &wavelengths, theta, omega, polarization);
    if wavelengths.len() >= LEAST {
        for theta in SPECTRA {
            scans.extend([90.0, 0.0].map(|omega| spectrum(theta, omega, Polarization::Unpolarized)));
        }
    }
    let mut lines: Vec<f64> = [90.0, 0.0].iter().filter_map(|omega| peak(model, &of, &wavelengths, *omega)).collect();
    lines.extend(WAVELENGTHS.iter().filter(|line| known(line)));
    for theta in SCANS {
        for omega in [90.0, 0.0, 45.0] {
            for (place, &line) in lines.iter().enumerate() {
                let repeated = lines[..place].iter().any(|other| (other - line).abs() < 1.0);
                if !repeated {
                    scans.push(phi_scan(line, theta, omega));
                }
            }
        }
    }
    if wavelengths.len() >= LEAST {
        scans.extend([Polarization::S, Polarization::P].map(|polarization| spectrum(POLARIZED, 90.0, polarization)));
    }
    scans
}

fn spectrum(of: &Structure, wavelengths: &[f64], theta: f64, omega: f64, polarization: Polarization) -> Scan {
    let mirror = 2.0 * degrees(of.delta) - theta;
    let unseen = lobe::lobe(radians(theta), radians(-theta), of.delta, of.phi_alpha) < SEEN;
    // Adding 0 turns -0 into 0.
    let phi = 0.0 + if omega > 0.0 && unseen { 5.0 * (mirror / 5.0).round() } else { -theta };
    let light = match polarization {
        Polarization::Unpolarized => String::new(),
        Polarization::S | Polarization::P => format!(" of {} polarization", polarization.word()),
    };
    let (first, last) = (wavelengths.first().copied().unwrap_or(0.0), wavelengths.last().copied().unwrap_or(0.0));
    Scan {
        name: format!(
            "a spectrum{light} from {first:.0} to {last:.0} nm, theta {theta}°, phi {phi}°, omega {omega}°, {} readings",
            wavelengths.len()
        ),
        wavelengths: wavelengths.to_vec(),
        thetas: vec![radians(theta)],
        phis: vec![radians(phi)],
        omegas: vec![radians(omega)],
        polarization,
    }
}

fn phi_scan(wavelength: f64, theta: f64, omega: f64) -> Scan {
    let scan = Scan::angular(wavelength, omega);
    let readings = scan.phis.len();
    Scan {
        name: format!(
            "a phi scan from -60° to 60° at {wavelength:.0} nm, theta {theta}°, omega {omega}°, {readings} readings"
        ),
        thetas: vec![radians(theta)],
        ..scan
    }
}

/// The wavelength at which the structure is brightest at normal incidence in one plane.
fn peak(model: &dyn ReflectivityModel, of: &Structure, wavelengths: &[f64], omega: f64) -> Option<f64> {
    let phi = if omega > 0.0 { 2.0 * of.delta } else { 0.0 };
    let geometry = Geometry { theta: 0.0, phi, omega: radians(omega) };
    let readings: Vec<(Geometry, f64)> = wavelengths.iter().map(|&wavelength| (geometry, wavelength)).collect();
    let found = model.contributions_at(of, Polarization::Unpolarized, &readings).ok()?;
    let value = |(found, &wavelength): (Result<[Contribution; 2], OpticsError>, &f64)| {
        let value = found.ok()?.iter().map(|part| part.intensity).sum::<f64>();
        value.is_finite().then_some((value, wavelength))
    };
    let found = found.into_iter().zip(wavelengths).filter_map(value);
    found.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, wavelength)| wavelength)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::parameter::values;
    use crate::optics::{BlendModel, IndexTable, Material, Stack};

    #[test]
    fn scans_are_named_after_what_they_are() {
        let scans = candidates(&BlendModel::default(), &values(&Structure::blue()));
        let has = |name: &str| scans.iter().any(|scan| scan.name == name);
        assert_eq!(scans[0].name, "a spectrum from 380 to 740 nm, theta 0°, phi 0°, omega 90°, 37 readings");
        assert!(has("a spectrum of p polarization from 380 to 740 nm, theta 60°, phi -60°, omega 90°, 37 readings"));
        // The blue preset in Model A peaks at twice its period, 406 nm.
        assert!(has("a phi scan from -60° to 60° at 410 nm, theta 0°, omega 0°, 49 readings"));
        for (place, scan) in scans.iter().enumerate() {
            assert!(scans[..place].iter().all(|other| other.name != scan.name), "{} twice", scan.name);
        }
    }

    #[test]
    fn a_narrow_tilted_lobe_is_followed() {
        let tilted = Structure { delta: radians(9.0), phi_alpha: 0.1, ..Structure::blue() };
        let scans = candidates(&BlendModel::default(), &values(&tilted));
        assert_eq!(scans[2].name, "a spectrum from 380 to 740 nm, theta 20°, phi 0°, omega 90°, 37 readings");
        assert_eq!(scans[3].name, "a spectrum from 380 to 740 nm, theta 20°, phi -20°, omega 0°, 37 readings");
    }

    #[test]
    fn no_scan_leaves_the_table_of_an_index() {
        let table = IndexTable::new(vec![[500.0, 1.5, 0.0], [580.0, 1.5, 0.0]]).unwrap();
        let model = BlendModel { stack: Stack { cuticle: Material::Table(table), ..Stack::default() } };
        let scans = candidates(&model, &values(&Structure::blue()));
        assert!(!scans.is_empty());
        assert!(scans.iter().flat_map(|scan| &scan.wavelengths).all(|line| (500.0..=580.0).contains(line)));
    }
}
