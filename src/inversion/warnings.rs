//! Warnings of a fit: outliers, bounds, hidden scales, intervals without ends, other minima.

use crate::dataset::{Reading, note_on_angles};
use crate::inversion::elsewhere::as_good;
use crate::inversion::estimates::Found;
use crate::inversion::nuisance::Extent;
use crate::inversion::outcome::{Estimate, Status, Verdict};
use crate::inversion::parameter::{COUNT, Parameter, Role};

/// A reading with more than this share of chi² is named.
const OUTLIER: f64 = 0.5;

/// A warning if one reading makes up most of chi².
pub(crate) fn outlier(found: &Found<'_>, weighted: &[f64], chi2: f64) -> Option<String> {
    let (worst, size) =
        weighted.iter().map(|residual| residual.abs()).enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let line = found.data.readings()[worst].line;
    let place = if line > 0 { format!("line {line}") } else { format!("reading {}", worst + 1) };
    (size.powi(2) > OUTLIER * chi2).then(|| {
        format!("one reading makes up most of chi²: {place}; leave it out or use a robust loss (huber, cauchy)")
    })
}

/// What to try where the model misses the data.
pub(crate) fn may_help(found: &Found<'_>, estimates: &[Estimate; COUNT], verdict: Verdict) -> String {
    let nuisances = &found.settings.nuisances;
    let fixed = |role: &Role| matches!(role, Role::Fixed { .. });
    let on_a_bound = estimates.iter().any(|estimate| estimate.status == Status::AtBound);
    let tries = [
        (note_on_angles(found.data.readings()).is_some(), "angles in radians (write them in degrees)"),
        (on_a_bound, "a bound that is too narrow (--bounds)"),
        (nuisances.background == Extent::None, "an offset of the readings (--background shared)"),
        (
            nuisances.scale != Extent::PerCurve && found.data.curves().len() > 1,
            "curves that were scaled one by one (--scale per-curve)",
        ),
        (nuisances.scale == Extent::None, "readings that are no reflectivities (--scale shared)"),
        (verdict != Verdict::Given && found.settings.roles.iter().any(fixed), "what was fixed (leave it free)"),
        (true, "an index that is off (morpho-fit constant)"),
    ];
    let tries: Vec<&str> = tries.iter().filter(|(may, _)| *may).map(|(_, text)| *text).collect();
    format!("causes to try: {}", tries.join("; "))
}

pub(crate) fn bounds(found: &Found<'_>, estimates: &[Estimate; COUNT]) -> Vec<String> {
    // At angles of 0 there is no sign to be wrong.
    let signed = |reading: &Reading| reading.geometry.theta != 0.0 || reading.geometry.phi != 0.0;
    let turned = found.data.readings().iter().any(signed);
    let on_a_bound = |(_, estimate): &(&Parameter, &Estimate)| {
        let on = |value| estimate.bounds.is_some_and(|bounds| bounds.contains(&value));
        // What moves with one on a bound is named beside it.
        estimate.status == Status::AtBound && estimate.with.is_empty()
            || estimate.status == Status::Ambiguous && estimate.value.is_some_and(on)
    };
    (Parameter::ALL.iter().zip(estimates))
        .filter(on_a_bound)
        .map(|(parameter, estimate)| {
            let value = estimate.value.unwrap_or_default();
            let unit = parameter.unit();
            if estimate.status == Status::Ambiguous {
                return format!(
                    "{parameter} ended on its bound {value:.4} {unit}, where it may lie beyond, but a value inside fits as well"
                );
            }
            let hint = if *parameter == Parameter::Delta && turned {
                " (or is phi the other way round? a mirror reflects theta = 20 into phi = -20)"
            } else {
                ""
            };
            format!(
                "{parameter} ended on its bound {value:.4} {unit}: widen it with --bounds {parameter}=LOW:HIGH{hint}"
            )
        })
        .collect()
}

/// A warning if the lobe acts as a scale although none is fitted.
pub(crate) fn hidden_scale(found: &Found<'_>) -> Option<String> {
    let free = &found.searched.freedom.free;
    // A width that the data do not feel, as in the mirror direction of a fixed tilt, was taken out of the fit.
    let lobe = free.contains(&Parameter::Delta) || found.space.freedom.free.contains(&Parameter::PhiAlpha);
    let hidden = found.settings.nuisances.scale == Extent::None && found.plan.directions() == 1 && lobe;
    hidden.then(|| {
        "with one direction of incidence and view the lobe acts as a scale, although none is fitted: fix delta and phi_alpha \
         if the intensities are absolute"
            .to_owned()
    })
}

/// Warnings of parameters whose interval spans all of their bounds.
pub(crate) fn open_intervals(found: &Found<'_>, estimates: &[Estimate; COUNT]) -> Vec<String> {
    let of_a_direction =
        |parameter: &Parameter| found.held.iter().any(|held| held.direction.iter().any(|(part, _)| part == parameter));
    (Parameter::ALL.iter().zip(estimates))
        .filter(|(parameter, estimate)| estimate.status == Status::NotIdentifiable && !of_a_direction(parameter))
        .map(|(parameter, _)| format!("{parameter} cannot be told: its interval spans all of its bounds"))
        .collect()
}

/// A warning if a minimum elsewhere fits as well as the best.
pub(crate) fn others(found: &Found<'_>, estimates: &[Estimate; COUNT], unit: f64) -> Option<String> {
    let ambiguous: Vec<&str> = (Parameter::ALL.iter().zip(estimates))
        .filter(|(_, estimate)| estimate.status == Status::Ambiguous)
        .map(|(parameter, _)| parameter.name())
        .collect();
    let minima = as_good(found, unit).count();
    (!ambiguous.is_empty()).then(|| {
        let (structures, fit) = if minima == 1 { ("structure", "fits") } else { ("structures", "fit") };
        format!(
            "{minima} other {structures} {fit} as well, with another {}: see `minima` in fit.json",
            ambiguous.join(", ")
        )
    })
}
