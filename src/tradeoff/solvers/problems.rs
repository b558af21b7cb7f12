//! Fits with a known answer: 20 with much data, drawn here, and 20 with little, which another program made.

use crate::dataset::{Dataset, Reading};
use crate::geometry::{Geometry, Polarization};
use crate::inversion::{Extent, FitSettings, ModelChoice, Nuisances, Parameter, Role, Weight, structure};
use crate::optics::{Admittance, LamellaUnit, Snell, Stack};
use crate::synthetic::linspace;
use crate::tradeoff::TradeoffError;
use crate::units::radians;
use rand::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::Deserialize;

/// Definition and data of the problems with little data, as the tests of the library have them.
const LITTLE: &str = include_str!("../../../tests/reference/workloads/w3b.json");
const LITTLE_DATA: &str = include_str!("../../../tests/reference/workloads/w3b_data.csv");
/// Problems with much data.
const COUNT: usize = 20;
/// Truths are drawn so far inside the bounds, as a share of their range.
const INSIDE: f64 = 0.1;
/// Bounds of every problem: nm, nm, degrees, rad, nm.
const LOWER: [f64; 5] = [50.0, 30.0, -10.0, 0.1, 100.0];
const UPPER: [f64; 5] = [250.0, 200.0, 10.0, 1.2, 600.0];
/// Lamella width at which Model A has the weight 1, nm.
const REFERENCE_WIDTH: f64 = 300.0;
/// Planes of measurement, degrees.
const PLANES: [f64; 2] = [15.0, 75.0];

/// A data set with the chi² of the truth in it.
#[derive(Debug)]
pub(crate) struct Known {
    pub(crate) data: Dataset,
    pub(crate) settings: FitSettings,
    pub(crate) chi2_truth: f64,
}

/// Where a data set is measured, at normal incidence: every plane, wavelength and view, the last fastest.
struct Design {
    planes: Vec<f64>,
    wavelengths: Vec<f64>,
    views: Vec<f64>,
}

impl Design {
    /// 2 × 37 × 31 readings.
    fn whole() -> Self {
        Self { planes: PLANES.to_vec(), wavelengths: linspace(380.0, 740.0, 37), views: linspace(-75.0, 75.0, 31) }
    }

    fn readings(&self, sigma: f64) -> Vec<Reading> {
        let mut readings = Vec::new();
        for &omega in &self.planes {
            for &wavelength in &self.wavelengths {
                for &phi in &self.views {
                    readings.push(Reading {
                        wavelength,
                        geometry: Geometry { theta: 0.0, phi: radians(phi), omega: radians(omega) },
                        polarization: Polarization::Unpolarized,
                        intensity: 0.0,
                        sigma: Some(sigma),
                        curve: 0,
                        line: 0,
                    });
                }
            }
        }
        readings
    }
}

fn dataset(mut readings: Vec<Reading>, intensities: &[f64], sigma: f64) -> Result<Dataset, TradeoffError> {
    for (reading, &intensity) in readings.iter_mut().zip(intensities) {
        (reading.intensity, reading.sigma) = (intensity, Some(sigma));
    }
    Ok(Dataset::from_readings(readings, vec!["data".to_owned()])?)
}

fn settings(scale: Extent) -> FitSettings {
    let model = ModelChoice::Paper {
        snell: Snell::Right,
        admittance: Admittance::Mean,
        lamella_unit: LamellaUnit::Reference { width: REFERENCE_WIDTH },
    };
    let roles = Parameter::ALL.map(|parameter| Role::Free {
        lower: parameter.inside(LOWER[parameter.index()]),
        upper: parameter.inside(UPPER[parameter.index()]),
    });
    let nuisances = Nuisances { scale, weight: Weight::Fixed(1.0), background: Extent::None };
    FitSettings { model, roles, nuisances, ..FitSettings::default() }
}

/// The design of the little data for a truth (inside units), with an unknown scale and normal noise.
pub(crate) fn little(truth: &[f64; 5], noise: f64, seed: u64) -> Result<Known, TradeoffError> {
    let definition: Definition = serde_json::from_str(LITTLE)?;
    simulated(&definition.design(), settings(Extent::Shared), truth, noise, seed)
}

/// The whole design for a truth (inside units), with normal noise of a share of the largest intensity; the readings have
/// the sigma of 1 % if there is none.
pub(crate) fn drawn(truth: &[f64; 5], noise: f64, seed: u64) -> Result<Known, TradeoffError> {
    simulated(&Design::whole(), settings(Extent::None), truth, noise, seed)
}

fn simulated(
    design: &Design,
    settings: FitSettings,
    truth: &[f64; 5],
    noise: f64,
    seed: u64,
) -> Result<Known, TradeoffError> {
    let model = settings.model.build(Stack::default());
    let readings = design.readings(1.0);
    let of = structure(truth);
    let clean = readings
        .iter()
        .map(|reading| model.reflectivity(&of, &reading.geometry, reading.polarization, reading.wavelength))
        .collect::<Result<Vec<f64>, _>>()?;
    let largest = clean.iter().copied().fold(0.0, f64::max);
    let sigma = if noise > 0.0 { noise } else { 0.01 } * largest;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut chi2_truth = 0.0;
    let mut noisy = Vec::with_capacity(clean.len());
    for value in clean {
        let deviate: f64 = StandardNormal.sample(&mut random);
        let error = noise * largest * deviate;
        chi2_truth += (error / sigma).powi(2);
        noisy.push(value + error);
    }
    Ok(Known { data: dataset(readings, &noisy, sigma)?, settings, chi2_truth })
}

/// 20 truths with the whole design and 1 % noise.
pub(super) fn much_data(seed: u64) -> Result<Vec<Known>, TradeoffError> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    (0..COUNT as u64)
        .map(|index| {
            let truth = Parameter::ALL.map(|parameter| {
                let (lower, upper) = (LOWER[parameter.index()], UPPER[parameter.index()]);
                let share = random.random_range(INSIDE..1.0 - INSIDE);
                parameter.inside(lower + share * (upper - lower))
            });
            drawn(&truth, 0.01, seed.wrapping_add(index))
        })
        .collect()
}

/// The parts of the definition that are used.
#[derive(Debug, Deserialize)]
struct Definition {
    lambda_nm: Vec<f64>,
    phi_deg: Vec<f64>,
    omega_deg: Vec<f64>,
    cases: Vec<Case>,
}

impl Definition {
    fn design(&self) -> Design {
        Design { planes: self.omega_deg.clone(), wavelengths: self.lambda_nm.clone(), views: self.phi_deg.clone() }
    }
}

#[derive(Debug, Deserialize)]
struct Case {
    sigma: f64,
    chi2_truth: f64,
}

/// 20 truths with 310 readings, 2 % noise and an unknown scale.
pub(super) fn little_data() -> Result<Vec<Known>, TradeoffError> {
    let definition: Definition = serde_json::from_str(LITTLE)?;
    let design = definition.design();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); definition.cases.len()];
    for line in LITTLE_DATA.lines().skip(1).filter(|line| !line.starts_with('#')) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            let value = cell.trim().parse().map_err(|_| TradeoffError::ProblemData(cell.to_owned()))?;
            column.push(value);
        }
    }
    (definition.cases.iter().zip(&columns))
        .map(|(case, column)| {
            let data = dataset(design.readings(case.sigma), column, case.sigma)?;
            Ok(Known { data, settings: settings(Extent::Shared), chi2_truth: case.chi2_truth })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_problems_are_those_of_the_reference() {
        let little = little_data().unwrap();
        assert_eq!((little.len(), little[0].data.readings().len()), (20, 310));
        // Readings of the file, and the last truth's chi².
        assert!((little[0].data.readings()[0].intensity - 54.395_465_1).abs() < 1e-9);
        assert!((little[19].chi2_truth - 334.843_234_813_417).abs() < 1e-9);
        let much = much_data(1).unwrap();
        assert_eq!((much.len(), much[3].data.readings().len()), (20, 2294));
        // 2294 squares of normal deviates: within five standard deviations of their mean.
        assert!(much.iter().all(|known| (known.chi2_truth - 2294.0).abs() < 5.0 * (2.0 * 2294.0_f64).sqrt()));
    }
}
