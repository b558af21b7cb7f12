//! The colours of a fitted structure, and how sure they are.

use super::html::Swatch;
use crate::colorimetry::{GamutMapping, Lab, RgbSpace, RgbTransform};
use crate::geometry::{Geometry, Polarization};
use crate::inversion::{COUNT, FitOutcome, Parameter, Verdict, structure};
use crate::numerics::quantile::{NINETY_FIVE, quantile};
use crate::optics::{ReflectivityModel, Structure};
use crate::sweep::{Colours, SweepError, View, Viewing, colours};
use crate::units::radians;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Incidences of the swatches in the mirror direction along the ridges, degrees.
const ALONG: [f64; 5] = [0.0, 15.0, 30.0, 45.0, 60.0];
/// Draws from the covariance that tell how sure a colour is.
const DRAWS: usize = 200;
/// Other minima that fit as well whose colour is shown.
const OTHERS: usize = 4;

/// The colours of the best structure along the ridges in the mirror direction, across them at normal incidence, and of other
/// minima that fit as well: CIE 1931 observer, D65, sRGB with the chroma lowered where it must be.
///
/// The note of each says how far 95 % of structures drawn from the covariance, within the bounds, look from it (CIEDE2000).
/// Empty where the fit determines no thickness. The strength is the model's own, without the fitted scale.
///
/// # Errors
/// [`SweepError`] if the model has no value for the structure.
pub fn swatches(outcome: &FitOutcome) -> Result<Vec<Swatch>, SweepError> {
    let Some(best) = outcome.minima.first() else { return Ok(Vec::new()) };
    if matches!(outcome.verdict, Verdict::NoThickness | Verdict::NotConverged) {
        return Ok(Vec::new());
    }
    let model = outcome.settings.model.build(outcome.settings.stack.clone());
    let spread = draws(outcome, &best.values);
    let mut swatches = Vec::new();
    for (name, geometry) in views() {
        let structures = std::iter::once(inside(&best.values)).chain(spread.iter().copied());
        let found = seen(model.as_ref(), structures, geometry)?;
        let note = sureness(&found)? + &held(outcome);
        swatches.extend(swatch(name, &found, 0, &note)?);
    }
    let normal = Geometry { theta: 0.0, phi: 0.0, omega: radians(90.0) };
    let others = outcome.minima.iter().enumerate().skip(1).filter(|(_, minimum)| minimum.fits).take(OTHERS);
    for (place, minimum) in others {
        let found = seen(model.as_ref(), std::iter::once(inside(&minimum.values)), normal)?;
        let note = format!("d_air {:.0} nm, d_cuticle {:.0} nm fit as well", minimum.values[0], minimum.values[1]);
        swatches.extend(swatch(format!("minimum {} along the ridges, θ = 0°", place + 1), &found, 0, &note)?);
    }
    Ok(swatches)
}

fn views() -> Vec<(String, Geometry)> {
    let along = ALONG.map(|theta| {
        let geometry = Geometry { theta: radians(theta), phi: radians(-theta), omega: radians(90.0) };
        (format!("along the ridges, θ = {theta}°, φ = {}°", -theta + 0.0).replace('-', "−"), geometry)
    });
    let across = ("across the ridges, θ = 0°, φ = 0°".to_owned(), Geometry { theta: 0.0, phi: 0.0, omega: 0.0 });
    along.into_iter().chain([across]).collect()
}

fn inside(values: &[f64; COUNT]) -> Structure {
    structure(&std::array::from_fn(|j| Parameter::ALL[j].inside(values[j])))
}

fn seen(
    model: &dyn ReflectivityModel,
    structures: impl Iterator<Item = Structure>,
    geometry: Geometry,
) -> Result<Colours, SweepError> {
    let views: Vec<View> = structures.map(|structure| View { structure, geometry }).collect();
    colours(model, &views, Polarization::Unpolarized, &Viewing::default())
}

/// How far the colours after the first look from it.
fn sureness(found: &Colours) -> Result<String, SweepError> {
    let labs = found.colours.iter().flatten().map(|colour| Lab::new(*colour, found.white));
    let labs = labs.collect::<Result<Vec<Lab>, _>>()?;
    let Some((first, rest)) = labs.split_first().filter(|(_, rest)| !rest.is_empty()) else {
        return Ok("how sure the fit does not tell".to_owned());
    };
    let mut far: Vec<f64> = rest.iter().map(|other| first.difference(*other)).collect();
    far.sort_by(f64::total_cmp);
    Ok(format!("95 % within ΔE₀₀ {:.1}", quantile(&far, NINETY_FIVE).unwrap_or_default()))
}

/// Parameters that no draw moves because the data leave them open.
fn held(outcome: &FitOutcome) -> String {
    let is_held = |name: &&String| !outcome.covariance.names.contains(name);
    let names: Vec<&str> = outcome.identifiability.free.iter().filter(is_held).map(String::as_str).collect();
    if names.is_empty() { String::new() } else { format!(" with {} held", names.join(", ")) }
}

fn swatch(name: String, found: &Colours, place: usize, note: &str) -> Result<Option<Swatch>, SweepError> {
    let Some(Some(colour)) = found.colours.get(place) else { return Ok(None) };
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
        inside(&values)
    };
    (0..DRAWS).map(one).filter(|structure| structure.validate().is_ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::{FitSettings, Search, fit};
    use crate::optics::BlendModel;
    use crate::synthetic::{Scan, simulate};

    #[test]
    fn the_example_is_blue_and_its_colour_is_sure() {
        let (model, truth) = (BlendModel::default(), Structure::blue());
        let data = simulate(&model, &truth, &Scan::full_design(&model, &truth).unwrap(), 1.0, 0.01, 1).unwrap();
        let local = FitSettings { search: Search::Local, ..FitSettings::default() };
        let mut outcome = fit(&data, &local, &|_| {}).unwrap().outcome;
        let found = swatches(&outcome).unwrap();
        let [red, green, blue] = found[0].colour;
        assert!(blue > green && green > red, "{:?}", found[0]);
        assert!(found[0].note.contains("95 % within"), "{}", found[0].note);
        outcome.verdict = Verdict::NoThickness;
        assert_eq!(swatches(&outcome).unwrap(), []);
    }
}
