//! What a design of measurement can tell, before it is fitted: the fit of noiseless data of the same design.

use anyhow::Result;
use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{Estimate, FitSettings, Parameter, Role, fit, structure, values};
use morpho_fit::optics::Structure;
use morpho_fit::optimise::Loss;
use morpho_fit::report::wording;
use serde::Serialize;

/// Standard deviation that is assumed where the data state none, as a share of the largest intensity.
const ASSUMED_NOISE: f64 = 0.01;

/// What can be expected of a fit.
#[derive(Debug, Serialize)]
pub(crate) struct Expected {
    /// Structure and noise that it holds for.
    pub(crate) assuming: String,
    pub(crate) parameters: Vec<ExpectedParameter>,
    /// What is not determined, as sentences.
    pub(crate) undetermined: Vec<String>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ExpectedParameter {
    pub(crate) name: String,
    pub(crate) unit: String,
    /// The value that the expectation is for; none for what is not determined.
    pub(crate) assumed: Option<f64>,
    pub(crate) sigma: Option<f64>,
    pub(crate) status: String,
}

/// Fits what the model gives at the geometry of `data` for a typical structure, from that structure and from everywhere.
///
/// The intensities of `data` are not used but for their size, so that this says what the design can tell, not what the
/// data do.
pub(crate) fn expected(data: &Dataset, settings: &FitSettings, progress: &(dyn Fn(&str) + Sync)) -> Result<Expected> {
    let model = settings.model.build(settings.stack.clone());
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
    let gain = if settings.nuisances.scale == morpho_fit::inversion::Extent::None { 1.0 } else { gain };
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
    let outcome = fit(&design, &settings, progress)?.outcome;
    let derived = [("d_air + d_cuticle", &outcome.derived.period), ("optical sum", &outcome.derived.optical_sum)];
    let parameters = outcome.parameters.each().into_iter().chain(derived).map(of).collect();
    let noise = if data.has_sigma() { "the stated sigma".to_owned() } else { "noise of 1 % of the peak".to_owned() };
    Ok(Expected {
        assuming: format!("of a structure like the assumed one, with {noise}"),
        parameters,
        undetermined: outcome.identifiability.undetermined,
    })
}

fn of((name, estimate): (&str, &Estimate)) -> ExpectedParameter {
    ExpectedParameter {
        name: name.to_owned(),
        unit: estimate.unit.clone(),
        assumed: estimate.value,
        sigma: estimate.sigma,
        status: wording::status(estimate),
    }
}

/// The blue preset, moved to what is fixed, linked, started from or bounded.
fn typical(settings: &FitSettings) -> [f64; morpho_fit::inversion::COUNT] {
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
