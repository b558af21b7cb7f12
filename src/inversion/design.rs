//! What a design of measurement can tell, before it is fitted: the fit of noiseless data of the same design.

use crate::dataset::{Dataset, Findings, Reading};
use crate::inversion::advice::{AdviceError, AdviceFound, Ask, advise, is_good};
use crate::inversion::fit::{FitError, fit};
use crate::inversion::nuisance::Extent;
use crate::inversion::outcome::{Estimate, FitOutcome};
use crate::inversion::parameter::{COUNT, Parameter, Role, structure, values};
use crate::inversion::settings::FitSettings;
use crate::optics::{OpticsError, Structure};
use crate::optimise::Loss;

/// Standard deviation that is assumed where the data state none, as a share of the largest intensity.
const ASSUMED_NOISE: f64 = 0.01;

/// What can be expected of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Structure and noise that it holds for.
    pub assuming: String,
    /// The fit of noiseless data: its values are the assumed ones, its standard deviations those to expect.
    pub outcome: FitOutcome,
    /// Whether everything free is told, and well.
    pub good: bool,
    /// What to measure besides, the best first; empty if nothing more is needed.
    pub advice: Vec<AdviceFound>,
}

impl Expected {
    /// Names and estimates of the five parameters, period and optical sum.
    #[must_use]
    pub fn each(&self) -> [(&'static str, &Estimate); COUNT + 2] {
        let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = self.outcome.parameters.each();
        let derived = &self.outcome.derived;
        let (period, sum) = (("d_air + d_cuticle", &derived.period), ("optical sum", &derived.optical_sum));
        [d_air, d_cuticle, delta, phi_alpha, lamella_width, period, sum]
    }
}

/// A design of which nothing can be expected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// The design cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The model has no value at a reading.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// What the model gives is no valid data set.
    #[error(transparent)]
    Data(#[from] Findings),
    /// No advice could be given.
    #[error(transparent)]
    Advice(#[from] AdviceError),
}

/// Fits what the model gives at the geometry of `data` for a typical structure, from that structure and from everywhere.
///
/// The intensities of `data` are not used but for their size, so that this says what the design can tell, not what the
/// data do. The structure is the blue preset, moved to what is fixed, linked, started from or bounded.
///
/// # Errors
/// [`DesignError`] if the model has no value at a reading or the fit cannot begin.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, expected};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let data = simulate(&BlendModel::default(), &Structure::blue(), &[Scan::spectrum(90.0)], 1.0, 0.0, 1)?;
/// let design = expected(&data, &FitSettings::default(), &|_| {})?;
/// assert!(!design.good && design.outcome.parameters.lamella_width.value.is_none());
/// assert!(!design.advice.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn expected(
    data: &Dataset,
    settings: &FitSettings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Expected, DesignError> {
    settings.validate().map_err(FitError::from)?;
    let model = settings.forward()?;
    let assumed = typical(settings);
    let truth = structure(&assumed);
    let mut readings = Vec::with_capacity(data.readings().len());
    for reading in data.readings() {
        let Reading { geometry, polarization, wavelength, .. } = *reading;
        let intensity = model.reflectivity(&truth, &geometry, polarization, wavelength)?;
        readings.push(Reading { intensity, ..*reading });
    }
    let largest = |readings: &[Reading]| readings.iter().map(|reading| reading.intensity).fold(0.0, f64::max);
    let (measured, modelled) = (largest(data.readings()), largest(&readings));
    // Where a scale is fitted the data may be in any unit.
    let gain = if measured > 0.0 && modelled > 0.0 { measured / modelled } else { 1.0 };
    let gain = if settings.nuisances.scale == Extent::None { 1.0 } else { gain };
    let noise = ASSUMED_NOISE * gain * modelled;
    for reading in &mut readings {
        reading.intensity *= gain;
        reading.sigma = reading.sigma.or(Some(if noise > 0.0 { noise } else { 1.0 }));
    }
    let design = Dataset::from_readings(readings, data.curves().to_vec())?;
    let mut settings = FitSettings { loss: Loss::Linear, ..settings.clone() };
    for parameter in Parameter::ALL {
        if matches!(settings.roles[parameter.index()], Role::Free { .. }) {
            settings.start[parameter.index()] = Some(assumed[parameter.index()]);
        }
    }
    let found = fit(&design, &settings, progress)?;
    progress("asking what to measure besides");
    let good = is_good(&found.outcome);
    let proposals = if good { Vec::new() } else { advise(&design, &found, Ask::Always)? };
    let noise = if data.has_sigma() { "the stated sigma".to_owned() } else { "noise of 1 % of the peak".to_owned() };
    Ok(Expected {
        assuming: format!("of a structure like the assumed one, with {noise}"),
        outcome: found.outcome,
        good,
        advice: proposals.into_iter().map(|proposal| proposal.found).collect(),
    })
}

/// The blue preset, moved to what is fixed, linked, started from or bounded.
fn typical(settings: &FitSettings) -> [f64; COUNT] {
    let mut typical = values(&Structure::blue());
    for (index, role) in settings.roles.iter().enumerate() {
        match *role {
            Role::Fixed { value } => typical[index] = value,
            Role::Free { lower, upper } => {
                let start = settings.start[index].unwrap_or(typical[index]);
                let inside = start > lower && start < upper;
                typical[index] = if inside { start } else { 0.5 * (lower + upper) };
            }
            Role::Linked { .. } => {}
        }
    }
    let free = typical;
    for (index, role) in settings.roles.iter().enumerate() {
        if let Role::Linked { other, factor, constant } = *role {
            typical[index] = constant + factor * free[other.index()];
        }
    }
    typical
}
