//! What a design of measurement can tell, before it is fitted: the fit of noiseless data of the same design.

use crate::dataset::{Dataset, Findings, Reading};
use crate::inversion::advice::{AdviceError, AdviceFound, Ask, advise, is_good};
use crate::inversion::fit::{FitError, fit};
use crate::inversion::nuisance::Extent;
use crate::inversion::outcome::{Estimate, FitOutcome, Status};
use crate::inversion::parameter::{COUNT, Parameter, Role, structure, values};
use crate::inversion::settings::{FitSettings, Search};
use crate::inversion::space::Space;
use crate::optics::{OpticsError, ReflectivityModel, Structure};
use crate::optimise::Loss;
use nalgebra::DVector;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

/// Standard deviation that is assumed where the data state none, as a share of the largest intensity.
const ASSUMED_NOISE: f64 = 0.01;

/// Other structures that are tried.
const OTHERS: usize = 32;

/// What can be expected of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Structure and noise that it holds for.
    pub assuming: String,
    /// The fit of noiseless data: its values are the assumed ones, its standard deviations those to expect.
    pub outcome: FitOutcome,
    /// What the same design tells of other structures, in the order of [`Expected::each`].
    pub elsewhere: [Elsewhere; COUNT + 2],
    /// Whether everything free is told, and well.
    pub good: bool,
    /// What to measure besides, the best first; empty if nothing more is needed.
    pub advice: Vec<AdviceFound>,
}

impl Expected {
    /// Names and estimates of the five parameters, period and optical sum.
    #[must_use]
    pub fn each(&self) -> [(&'static str, &Estimate); COUNT + 2] {
        quantities(&self.outcome)
    }
}

fn quantities(outcome: &FitOutcome) -> [(&'static str, &Estimate); COUNT + 2] {
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = outcome.parameters.each();
    let derived = &outcome.derived;
    let (period, sum) = (("d_air + d_cuticle", &derived.period), ("optical sum", &derived.optical_sum));
    [d_air, d_cuticle, delta, phi_alpha, lamella_width, period, sum]
}

/// What a design tells of one quantity over structures drawn evenly from the bounds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Elsewhere {
    /// Structures that were tried; 0 of what is fixed, and of a model that averages, which would take long.
    pub structures: usize,
    /// Of how many the quantity is told.
    pub told: usize,
    /// The standard deviations of the middle half of these, the least and the largest, in the quantity's unit; `None` if none is
    /// told.
    pub middle: Option<[f64; 2]>,
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
/// data do. The structure is the blue preset, moved to what is fixed, linked, started from or bounded. Others tell less or
/// more: 32 of them, drawn from the bounds, are fitted from their own values alone.
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
    let design = noiseless(data, settings, model.as_ref(), &assumed)?;
    let settings = started_at(settings, &assumed);
    let found = fit(&design, &settings, progress)?;
    progress("asking what to measure besides");
    let good = is_good(&found.outcome);
    let proposals = if good { Vec::new() } else { advise(&design, &found, Ask::Always)? };
    let noise = match (data.has_sigma(), data.is_plan()) {
        (true, false) => "the stated sigma",
        (true, true) => "the stated sigma, of readings that are reflectivities (a peak of about 1)",
        (false, _) => "noise of 1 % of the peak",
    };
    progress("trying other structures");
    let mut elsewhere = elsewhere(data, &settings, model.as_ref());
    for (elsewhere, (_, estimate)) in elsewhere.iter_mut().zip(quantities(&found.outcome)) {
        if estimate.status == Status::Fixed {
            *elsewhere = Elsewhere::default();
        }
    }
    Ok(Expected {
        elsewhere,
        assuming: format!("of a structure like the assumed one, with {noise}"),
        outcome: found.outcome,
        good,
        advice: proposals.into_iter().map(|proposal| proposal.found).collect(),
    })
}

/// What the model gives at the geometry of `data`, as bright as these where a scale is fitted, with their sigma or an assumed one.
fn noiseless(
    data: &Dataset,
    settings: &FitSettings,
    model: &dyn ReflectivityModel,
    values: &[f64; COUNT],
) -> Result<Dataset, DesignError> {
    let truth = structure(values);
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
    Ok(Dataset::from_readings(readings, data.curves().to_vec())?)
}

/// Least squares from these values.
fn started_at(settings: &FitSettings, values: &[f64; COUNT]) -> FitSettings {
    let mut settings = FitSettings { loss: Loss::Linear, ..settings.clone() };
    for parameter in Parameter::ALL {
        if matches!(settings.roles[parameter.index()], Role::Free { .. }) {
            settings.start[parameter.index()] = Some(values[parameter.index()]);
        }
    }
    settings
}

/// What fits of noiseless data of other structures tell, each from its own values.
fn elsewhere(data: &Dataset, settings: &FitSettings, model: &dyn ReflectivityModel) -> [Elsewhere; COUNT + 2] {
    let space = Space::new(&settings.roles).ok().filter(|space| !space.freedom.free.is_empty());
    // What averages takes as long for each as for the assumed one: minutes in all.
    let Some(space) = space.filter(|_| settings.averages.is_none()) else { return Default::default() };
    let points = space.bounds.latin_hypercube(OTHERS, settings.seed);
    let one = |point: &DVector<f64>| {
        let values = space.freedom.expand(point);
        let design = noiseless(data, settings, model, &values).ok()?;
        let settings = FitSettings { search: Search::Local, ..started_at(settings, &values) };
        let outcome = fit(&design, &settings, &|_| {}).ok()?.outcome;
        let told = |estimate: &Estimate| estimate.value.and(estimate.sigma);
        Some(quantities(&outcome).map(|(_, estimate)| told(estimate)))
    };
    let found: Vec<_> = points.par_iter().map(one).collect();
    std::array::from_fn(|quantity| {
        let mut told: Vec<f64> = found.iter().flatten().filter_map(|sigmas| sigmas[quantity]).collect();
        told.sort_by(f64::total_cmp);
        let quarter = told.len() / 4;
        let middle = told.get(quarter).zip(told.iter().rev().nth(quarter)).map(|(&least, &most)| [least, most]);
        Elsewhere { structures: found.len(), told: told.len(), middle }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Averages, BlendModel};
    use crate::synthetic::{Scan, simulate};

    /// Structures near the assumed one have its errors, nearly.
    #[test]
    fn other_structures_of_a_narrow_box_are_told_as_well() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let data = simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.01, 1).unwrap();
        let mut settings = FitSettings::default();
        let near = |parameter: Parameter, value: f64| Role::Free {
            lower: value - 0.3 * parameter.typical_change(),
            upper: value + 0.3 * parameter.typical_change(),
        };
        for parameter in Parameter::ALL {
            settings.roles[parameter.index()] = near(parameter, values(&blue)[parameter.index()]);
        }
        // The width is known worse than this box is wide.
        settings.roles[Parameter::LamellaWidth.index()] = Role::Fixed { value: blue.lamella_width };
        let narrow = expected(&data, &settings, &|_| {}).unwrap();
        for ((name, estimate), elsewhere) in narrow.each().iter().zip(&narrow.elsewhere) {
            if *name == "lamella_width" {
                assert_eq!(*elsewhere, Elsewhere::default());
                continue;
            }
            let (sigma, [least, most]) = (estimate.sigma.unwrap(), elsewhere.middle.unwrap());
            assert!(elsewhere.told > OTHERS / 2, "{name}: {elsewhere:?}");
            assert!(least > 0.8 * sigma && most < 1.25 * sigma, "{name}: {sigma}, {elsewhere:?}");
        }
    }

    #[test]
    fn what_averages_is_tried_for_the_assumed_structure_alone() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let data = simulate(&model, &blue, &[Scan::spectrum(90.0)], 1.0, 0.01, 1).unwrap();
        let averages = Averages { bandwidth: 10.0, ..Averages::default() };
        let mut settings = FitSettings { averages, ..FitSettings::default() };
        for parameter in [Parameter::Delta, Parameter::PhiAlpha, Parameter::LamellaWidth] {
            settings.roles[parameter.index()] = Role::Fixed { value: values(&blue)[parameter.index()] };
        }
        let found = expected(&data, &settings, &|_| {}).unwrap();
        assert!(found.outcome.parameters.d_air.sigma.is_some());
        assert!(found.elsewhere.iter().all(|elsewhere| *elsewhere == Elsewhere::default()));
    }

    /// Across the ridges no structure tells a thickness, and most tell the period.
    #[test]
    fn what_no_structure_tells_is_told_nowhere() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let data = simulate(&model, &blue, &[Scan::spectrum(0.0)], 1.0, 0.01, 1).unwrap();
        let found = expected(&data, &FitSettings::default(), &|_| {}).unwrap();
        let [d_air, .., period, _] = found.elsewhere;
        assert_eq!((d_air.structures, d_air.told, d_air.middle), (OTHERS, 0, None));
        assert!(period.told > OTHERS / 2, "{period:?}");
    }
}
