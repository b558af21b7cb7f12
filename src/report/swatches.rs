//! The colours of a fitted structure, and how sure they are.

use super::html::Swatch;
use crate::colorimetry::{GamutMapping, Lab, RgbSpace, RgbTransform};
use crate::geometry::{Geometry, Polarization};
use crate::inversion::{COUNT, FitOutcome, Parameter, Role, Verdict, structure};
use crate::numerics::quantile::{NINETY_FIVE, quantile};
use crate::optics::{ReflectivityModel, Structure};
use crate::sweep::{Colours, SweepError, View, Viewing, colours};
use crate::units::radians;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::FRAC_PI_2;

/// Incidences of the swatches in the mirror direction along the ridges, degrees.
const ALONG: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
/// Draws from the covariance that tell how sure a colour is.
const DRAWS: usize = 200;
/// Other minima that fit as well whose colour is shown.
const OTHERS: usize = 4;

/// The colours of the best structure along the ridges in the mirror direction of its layers, `phi = 2 delta - theta`; across
/// them at normal incidence; and of other minima that fit as well: CIE 1931 observer, D65, sRGB with the chroma lowered where
/// it must be.
///
/// Only what the fit determines has a colour: along the ridges that takes both thicknesses and the tilt, across them the
/// period. The note of each says how far 95 % of structures drawn from the covariance, within the bounds, look from it
/// (CIEDE2000). The strength is the model's own, without the fitted scale.
///
/// # Errors
/// [`SweepError`] if the model has no value for the structure.
pub fn swatches(outcome: &FitOutcome) -> Result<Vec<Swatch>, SweepError> {
    let Some(best) = outcome.minima.first() else { return Ok(Vec::new()) };
    if matches!(outcome.verdict, Verdict::NoThickness | Verdict::NotConverged) {
        return Ok(Vec::new());
    }
    let model = outcome.settings.forward()?;
    let spread = draws(outcome, &best.values);
    let with_spread = || std::iter::once(inside(&best.values)).chain(spread.iter().copied());
    let mut swatches = Vec::new();
    if shows_the_multilayer(outcome) {
        for theta in ALONG {
            let found = seen(model.as_ref(), with_spread().map(|structure| along(structure, theta)))?;
            let name = format!("along the ridges, θ = {theta}°, mirrored");
            swatches.extend(swatch(name, &found, &sureness(&found)?)?);
        }
        let others = outcome.minima.iter().enumerate().skip(1).filter(|(_, minimum)| minimum.fits).take(OTHERS);
        for (place, minimum) in others {
            let found = seen(model.as_ref(), std::iter::once(along(inside(&minimum.values), 0.0)))?;
            let note = format!("d_air {:.0} nm, d_cuticle {:.0} nm fit as well", minimum.values[0], minimum.values[1]);
            swatches.extend(swatch(format!("minimum {} along the ridges, θ = 0°", place + 1), &found, &note)?);
        }
    }
    if outcome.derived.period.value.is_some() {
        let across = Geometry { theta: 0.0, phi: 0.0, omega: 0.0 };
        let found = seen(model.as_ref(), with_spread().map(|structure| View { structure, geometry: across }))?;
        swatches.extend(swatch("across the ridges, θ = 0°".to_owned(), &found, &sureness(&found)?)?);
    }
    Ok(swatches)
}

/// Whether the fit gives both thicknesses and the tilt: without them the multilayer has no colour of its own.
#[must_use]
pub fn shows_the_multilayer(outcome: &FitOutcome) -> bool {
    let has_value = |parameter: Parameter| outcome.parameters.each()[parameter.index()].1.value.is_some();
    [Parameter::DAir, Parameter::DCuticle, Parameter::Delta].into_iter().all(has_value)
}

/// In the mirror direction of the layers, where the width of their lobe does not count.
fn along(structure: Structure, theta: f64) -> View {
    let theta = radians(theta);
    let phi = (2.0 * structure.delta - theta).clamp(-FRAC_PI_2, FRAC_PI_2);
    View { structure, geometry: Geometry { theta, phi, omega: FRAC_PI_2 } }
}

fn inside(values: &[f64; COUNT]) -> Structure {
    structure(&std::array::from_fn(|j| Parameter::ALL[j].inside(values[j])))
}

fn seen(model: &dyn ReflectivityModel, views: impl Iterator<Item = View>) -> Result<Colours, SweepError> {
    colours(model, &views.collect::<Vec<View>>(), Polarization::Unpolarized, &Viewing::default())
}

/// How far the colours after the first look from it.
fn sureness(found: &Colours) -> Result<String, SweepError> {
    let labs = found.colours.iter().flatten().map(|colour| Lab::new(*colour, found.white));
    let labs = labs.collect::<Result<Vec<Lab>, _>>()?;
    let Some((first, rest)) = labs.split_first().filter(|(_, rest)| !rest.is_empty()) else {
        return Ok("the fit does not tell how sure".to_owned());
    };
    let mut far: Vec<f64> = rest.iter().map(|other| first.difference(*other)).collect();
    far.sort_by(f64::total_cmp);
    Ok(format!("95 % within ΔE₀₀ {:.1}", quantile(&far, NINETY_FIVE).unwrap_or_default()))
}

fn swatch(name: String, found: &Colours, note: &str) -> Result<Option<Swatch>, SweepError> {
    let Some(Some(colour)) = found.colours.first() else { return Ok(None) };
    let shown = RgbTransform::adapted(RgbSpace::Srgb, found.white)?.show(*colour, GamutMapping::default())?;
    let outside = if shown.outside { "; outside sRGB, shown with less chroma" } else { "" };
    let note = format!("Y = {:.2}, {note}{outside}", colour.y);
    Ok(Some(Swatch { name, colour: shown.bytes, note }))
}

/// Structures as likely as the covariance says, within the bounds; none if there is no covariance.
fn draws(outcome: &FitOutcome, best: &[f64; COUNT]) -> Vec<Structure> {
    let names: Vec<(usize, usize)> = (outcome.covariance.names.iter().enumerate())
        .filter_map(|(row, name)| Parameter::from_name(name).map(|parameter| (row, parameter.index())))
        .collect();
    let at = |i: usize, j: usize| outcome.covariance.rows.get(i).and_then(|row| row.get(j)).copied();
    let cell = |i: usize, j: usize| at(names[i].0, names[j].0).unwrap_or(0.0);
    let matrix = DMatrix::from_fn(names.len(), names.len(), cell);
    let Some(root) = Cholesky::new(matrix).filter(|_| !names.is_empty()) else { return Vec::new() };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(outcome.seed);
    let bounds = outcome.parameters.each().map(|(_, estimate)| estimate.bounds);
    let one = |_| {
        let normal = DVector::from_fn(names.len(), |_, _| -> f64 { StandardNormal.sample(&mut random) });
        let step = root.l() * normal;
        let mut values = *best;
        for (&(_, parameter), step) in names.iter().zip(step.iter()) {
            let moved = best[parameter] + step;
            values[parameter] = bounds[parameter].map_or(moved, |[low, high]| moved.clamp(low, high));
        }
        let mut inside: [f64; COUNT] = std::array::from_fn(|j| Parameter::ALL[j].inside(values[j]));
        for (follower, role) in outcome.settings.roles.iter().enumerate() {
            if let Role::Linked { other, factor, constant } = *role {
                inside[follower] = factor * inside[other.index()] + constant;
            }
        }
        structure(&inside)
    };
    (0..DRAWS).map(one).filter(|structure| structure.validate().is_ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::{FitSettings, fit};
    use crate::optics::BlendModel;
    use crate::synthetic::{Scan, simulate};

    #[test]
    fn the_example_is_blue_and_its_colour_is_sure() {
        let (model, truth) = (BlendModel::default(), Structure::blue());
        let data = simulate(&model, &truth, &Scan::full_design(&model, &truth).unwrap(), 1.0, 0.01, 1).unwrap();
        let mut outcome = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
        let found = swatches(&outcome).unwrap();
        let [red, green, blue] = found[0].colour;
        assert!(blue > green && green > red, "{:?}", found[0]);
        assert!(found[0].note.contains("95 % within"), "{}", found[0].note);
        let mut open = outcome.clone();
        open.parameters.d_air.value = None;
        assert_eq!(swatches(&open).unwrap().len(), 1, "across the ridges alone: no colour of an arbitrary thickness");
        outcome.verdict = Verdict::NoThickness;
        assert_eq!(swatches(&outcome).unwrap(), []);
    }
}
