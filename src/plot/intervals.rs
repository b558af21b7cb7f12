//! The charts of what a fit's intervals were read off from, and of its rival minima.

use super::atlas::{Atlas, Minimum, atlas_figure};
use super::corner::{Corner, corner_figure};
use super::profile::{PROFILE, Profile, ProfileQuantity, profile_figure};
use super::trace::{Trace, TraceQuantity, trace_figure};
use super::{Figure, LineSeries, Panel, PlotError};
use crate::inversion::intervals::{ConstantProfile, Posterior, Profiles};
use crate::inversion::{ChiSquareMap, FitOutcome, MinimumFound, Parameter, Parameters};

/// Minima that a map names.
const NAMED: usize = 12;

fn label(name: &str, unit: &str) -> String {
    let name = match name {
        "period" => "d_air + d_cuticle",
        "optical_sum" => "optical sum",
        name => name,
    };
    format!("{name} / {unit}")
}

/// Δchi² against each quantity, with the levels of the two intervals and the covariance's parabola.
///
/// # Errors
/// Those of [`profile_figure`].
pub fn profiles_figure(profiles: &Profiles, title: &str) -> Result<Figure, PlotError> {
    let quantities = (profiles.quantities.iter())
        .map(|profile| ProfileQuantity {
            name: label(profile.name, profile.unit),
            values: profile.values.clone(),
            delta_chi_squared: profile.excess.clone(),
            best: profile.best,
            sigma: profile.sigma.filter(|sigma| *sigma > 0.0),
            ends: [profile.intervals.interval_68, profile.intervals.interval_95]
                .map(|[low, high]| (low, high))
                .to_vec(),
        })
        .collect();
    let levels = profiles.quantities.first().map(|profile| profile.levels).unwrap_or_default();
    profile_figure(&Profile {
        title: title.to_owned(),
        subtitle: "profile likelihood: chi² with the quantity held and all others fitted again".to_owned(),
        quantities,
        levels: ["68.3 %", "95 %"].into_iter().map(str::to_owned).zip(levels).collect(),
    })
}

/// Δchi² against a constant of the model, and the determined parameters at each value of it.
///
/// # Errors
/// Those of [`profile_figure`].
pub fn constant_figure(found: &ConstantProfile, title: &str) -> Result<Figure, PlotError> {
    let (name, unit) = (found.constant.name(), found.constant.unit());
    let name = if unit.is_empty() { name.to_owned() } else { label(name, unit) };
    let quantity = ProfileQuantity {
        name: name.clone(),
        values: found.values.clone(),
        delta_chi_squared: found.excess.clone(),
        best: found.best,
        sigma: None,
        ends: [found.intervals.interval_68, found.intervals.interval_95].map(|[low, high]| (low, high)).to_vec(),
    };
    let mut figure = profile_figure(&Profile {
        title: title.to_owned(),
        subtitle: "first: chi² with the constant held and all parameters fitted again; then: where they are then"
            .to_owned(),
        quantities: vec![quantity],
        levels: ["68.3 %", "95 %"].into_iter().map(str::to_owned).zip(found.levels).collect(),
    })?;
    let range = figure.panels.first().and_then(|panel| panel.x_range);
    for parameter in Parameter::ALL {
        let Some(told) = found.quantities.iter().find(|quantity| quantity.name == parameter.name()) else { continue };
        let y: Vec<f64> = found.parameters.iter().map(|values| values[parameter.index()]).collect();
        // What hardly moves is drawn flat: the panel reaches two standard deviations at least.
        let reach = [told.value - 2.0 * told.sigma_known, told.value + 2.0 * told.sigma_known];
        let low = y.iter().copied().fold(reach[0], f64::min);
        let high = y.iter().copied().fold(reach[1], f64::max);
        let line = LineSeries {
            name: "parameter".to_owned(),
            x: found.values.clone(),
            y,
            colour: PROFILE,
            ..LineSeries::default()
        };
        figure.panels.push(Panel {
            x_label: name.clone(),
            y_label: label(parameter.name(), parameter.unit()),
            x_range: range,
            y_range: (low < high).then_some((low, high)),
            lines: vec![line],
            ..Panel::default()
        });
    }
    Ok(figure)
}

/// The posterior of the free parameters in pairs, with the best fit.
///
/// # Errors
/// Those of [`corner_figure`].
pub fn posterior_corner(posterior: &Posterior, outcome: &FitOutcome, title: &str) -> Result<Figure, PlotError> {
    let columns: Vec<usize> =
        (0..posterior.names.len()).filter(|&column| Parameter::from_name(posterior.names[column]).is_some()).collect();
    let best = |&column: &usize| {
        let estimate = outcome.parameters.each().into_iter().find(|(name, _)| *name == posterior.names[column])?.1;
        estimate.value.or(estimate.held_at)
    };
    corner_figure(&Corner {
        title: title.to_owned(),
        subtitle: "posterior; the lines are the best fit and the middle 68 %".to_owned(),
        names: columns.iter().map(|&column| label(posterior.names[column], posterior.units[column])).collect(),
        samples: columns.iter().map(|&column| posterior.samples.iter().map(|row| row[column]).collect()).collect(),
        best: columns.iter().map(best).collect(),
        truths: None,
        intervals: None,
    })
}

/// The chains of the posterior.
///
/// # Errors
/// Those of [`trace_figure`].
pub fn posterior_trace(posterior: &Posterior, title: &str) -> Result<Figure, PlotError> {
    let steps = (posterior.samples.len() / posterior.chains.max(1)).max(1);
    let quantity = |column: usize| {
        let values: Vec<f64> = posterior.samples.iter().map(|row| row[column]).collect();
        let convergence = posterior.convergence[column];
        TraceQuantity {
            name: label(posterior.names[column], posterior.units[column]),
            chains: values.chunks_exact(steps).map(<[f64]>::to_vec).collect(),
            r_hat: convergence.map(|found| found.r_hat),
            effective_samples: convergence.map(|found| found.bulk.min(found.tail)),
        }
    };
    trace_figure(&Trace {
        title: title.to_owned(),
        subtitle: "chains after the warm-up".to_owned(),
        quantities: (0..posterior.names.len()).map(quantity).collect(),
        stride: 1,
        warm_up: None,
    })
}

/// chi² over the two thicknesses with the minima of the fit.
///
/// # Errors
/// Those of [`atlas_figure`].
pub fn map_figure(map: &ChiSquareMap, outcome: &FitOutcome, title: &str) -> Result<Figure, PlotError> {
    let middles = |edges: &[f64]| edges.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let Parameters { d_air, d_cuticle, .. } = &outcome.parameters;
    let told = d_air.value.is_some() || d_cuticle.value.is_some();
    let minimum = |(place, minimum): (usize, &MinimumFound)| {
        let [d_air, d_cuticle, ..] = minimum.values;
        let words = minimum.relation.phrase();
        let fits = if minimum.fits { "" } else { ", does not fit" };
        let label = if place == 0 && !told {
            "the lowest point found; the data tell neither thickness".to_owned()
        } else if place == 0 {
            format!("{d_air:.1} and {d_cuticle:.1} nm: the best")
        } else {
            let decimals = usize::from(minimum.delta_chi2 < 100.0);
            let place = if told { format!("{d_air:.1} and {d_cuticle:.1} nm, ") } else { String::new() };
            format!("{place}Δχ² = {:.decimals$}: {words}{fits}", minimum.delta_chi2)
        };
        Minimum { x: d_air, y: d_cuticle, label, best: place == 0 }
    };
    let level = outcome.settings.level;
    atlas_figure(&Atlas {
        title: title.to_owned(),
        subtitle: "chi² with everything else at or near its best".to_owned(),
        x_label: "d_air / nm".to_owned(),
        y_label: "d_cuticle / nm".to_owned(),
        x: middles(&map.d_air_edges),
        y: middles(&map.d_cuticle_edges),
        delta_chi_squared: map.excess.iter().flatten().copied().collect(),
        level: (level > 0.0).then(|| (format!("Δχ² = {level}: fits as well"), level)),
        minima: outcome.minima.iter().take(NAMED).enumerate().map(minimum).collect(),
    })
}
