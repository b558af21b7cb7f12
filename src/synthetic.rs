//! Data sets from known structures: a measurement's design, the model's values, seeded noise.

use crate::dataset::{Dataset, Findings, Reading};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{OpticsError, ReflectivityModel, Structure};
use crate::units::radians;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// One record of a measurement: every combination of its wavelengths and angles, the last of them fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Name of the record.
    pub name: String,
    /// Wavelengths, nm.
    pub wavelengths: Vec<f64>,
    /// Incidence angles, rad.
    pub thetas: Vec<f64>,
    /// Viewing angles, rad.
    pub phis: Vec<f64>,
    /// Anisotropy angles, rad.
    pub omegas: Vec<f64>,
    /// What the detector sees.
    pub polarization: Polarization,
}

/// A data set that could not be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The model has no value for a reading.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The scans do not make a valid data set.
    #[error(transparent)]
    Data(#[from] Findings),
    /// Noise or scale that is no number of at least 0.
    #[error("{quantity} is {found}; it must be a finite number, at least 0")]
    Number {
        /// `noise` or `scale`.
        quantity: &'static str,
        /// What was given.
        found: f64,
    },
}

/// `count` values from `first` to `last`, both included.
#[must_use]
pub fn linspace(first: f64, last: f64, count: usize) -> Vec<f64> {
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let share = |index: usize| index as f64 / (count.max(2) - 1) as f64;
    (0..count).map(|index| first + share(index) * (last - first)).collect()
}

impl Scan {
    /// A spectrum from 380 to 740 nm by 10 nm at normal incidence and view, in the plane `omega` degrees.
    #[must_use]
    pub fn spectrum(omega_deg: f64) -> Self {
        Self {
            name: format!("spectrum at omega {omega_deg}"),
            wavelengths: linspace(380.0, 740.0, 37),
            thetas: vec![0.0],
            phis: vec![0.0],
            omegas: vec![radians(omega_deg)],
            polarization: Polarization::Unpolarized,
        }
    }

    /// A scan of the viewing angle from -60° to 60° by 2.5° at normal incidence and one wavelength.
    #[must_use]
    pub fn angular(wavelength: f64, omega_deg: f64) -> Self {
        Self {
            name: format!("{wavelength} nm at omega {omega_deg}"),
            wavelengths: vec![wavelength],
            thetas: vec![0.0],
            phis: linspace(-60.0, 60.0, 49).into_iter().map(radians).collect(),
            omegas: vec![radians(omega_deg)],
            polarization: Polarization::Unpolarized,
        }
    }

    /// The smallest design that determines all five parameters: in each plane a spectrum, and an angular scan at its
    /// peak, 172 readings.
    ///
    /// As an experimenter would: a scan at a wavelength that the structure does not reflect tells nothing.
    ///
    /// # Errors
    /// [`OpticsError`] if the model has no value for the structure.
    pub fn full_design(model: &dyn ReflectivityModel, structure: &Structure) -> Result<Vec<Self>, OpticsError> {
        let mut scans = Vec::new();
        for omega_deg in [0.0, 90.0] {
            let spectrum = Self::spectrum(omega_deg);
            // On the mirror direction of the plane: the peak does not depend on what the lobe lets through.
            let phi = if omega_deg > 0.0 { 2.0 * structure.delta } else { 0.0 };
            let geometry = Geometry { theta: 0.0, phi, omega: radians(omega_deg) };
            let mut peak = (f64::NEG_INFINITY, 0.0);
            for &wavelength in &spectrum.wavelengths {
                let value = model.reflectivity(structure, &geometry, spectrum.polarization, wavelength)?;
                if value > peak.0 {
                    peak = (value, wavelength);
                }
            }
            scans.extend([spectrum, Self::angular(peak.1, omega_deg)]);
        }
        Ok(scans)
    }
}

/// The readings of `scans` for a structure, with normal noise.
///
/// ```text
/// intensity = scale · model + sigma · z,   sigma = noise · largest intensity,   z ~ N(0, 1)
/// ```
///
/// - `noise`: share of the largest intensity of the whole set; with 0 the data have no sigma.
///
/// # Seed
/// The same seed gives the same data on every machine whose `sin` rounds alike.
///
/// # Errors
/// [`SimulationError`] if the model has no value at a reading, or the scans make no valid data set.
///
/// ```
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
/// let (model, blue) = (BlendModel::default(), Structure::blue());
/// let data = simulate(&model, &blue, &Scan::full_design(&model, &blue)?, 1.0, 0.01, 1)?;
/// assert_eq!(data.readings().len(), 172);
/// # Ok::<(), morpho_fit::synthetic::SimulationError>(())
/// ```
pub fn simulate(
    model: &dyn ReflectivityModel,
    structure: &Structure,
    scans: &[Scan],
    scale: f64,
    noise: f64,
    seed: u64,
) -> Result<Dataset, SimulationError> {
    for (quantity, found) in [("noise", noise), ("scale", scale)] {
        if !(found.is_finite() && found >= 0.0) {
            return Err(SimulationError::Number { quantity, found });
        }
    }
    let mut readings = Vec::new();
    for (curve, scan) in scans.iter().enumerate() {
        for &omega in &scan.omegas {
            for &theta in &scan.thetas {
                for &wavelength in &scan.wavelengths {
                    for &phi in &scan.phis {
                        let geometry = Geometry { theta, phi, omega };
                        let value = model.reflectivity(structure, &geometry, scan.polarization, wavelength)?;
                        let (polarization, intensity) = (scan.polarization, scale * value);
                        readings.push(Reading {
                            wavelength,
                            geometry,
                            polarization,
                            intensity,
                            sigma: None,
                            curve,
                            line: 0,
                        });
                    }
                }
            }
        }
    }
    let sigma = noise * readings.iter().map(|reading| reading.intensity).fold(0.0, f64::max);
    if sigma > 0.0 {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        for reading in &mut readings {
            let deviate: f64 = StandardNormal.sample(&mut random);
            reading.intensity += sigma * deviate;
            reading.sigma = Some(sigma);
        }
    }
    Ok(Dataset::from_readings(readings, scans.iter().map(|scan| scan.name.clone()).collect())?)
}
