//! The intervals of several methods in one table.

use super::digits::{plain, to_place_of};
use super::table::{Align, Table};
use super::terminal::wrapped;
use crate::inversion::intervals::{Method, MethodIntervals, Resampling, UncertaintyFound};

/// The table, and below it how bootstrap and sampling went, in lines of `width` characters.
///
/// A method that parts from the covariance by more than a fifth is marked with by how much.
#[must_use]
pub fn text(found: &UncertaintyFound, width: usize) -> String {
    let left = Align::Left;
    let mut table = Table::new(&[
        ("", left),
        ("unit", left),
        ("method", left),
        ("68 % interval", left),
        ("95 % interval", left),
        ("", left),
    ]);
    for quantity in &found.quantities {
        let name = match quantity.name.as_str() {
            "period" => "d_air + d_cuticle",
            "optical_sum" => "optical sum",
            name => name,
        };
        for (place, method) in quantity.methods.iter().enumerate() {
            let first = place == 0;
            table.row([
                if first { name.to_owned() } else { String::new() },
                if first { quantity.unit.clone() } else { String::new() },
                method.method.phrase().to_owned(),
                ends(method, method.intervals.interval_68),
                ends(method, method.intervals.interval_95),
                parting(method),
            ]);
        }
    }
    let mut text = table.to_string();
    let parted = |bent: bool| {
        let of = |method: Method| matches!(method, Method::Profile | Method::Posterior) == bent;
        found.quantities.iter().flat_map(|quantity| &quantity.methods).any(|m| of(m.method) && m.parts())
    };
    let mut say = |sentence: &str| text.push_str(&wrapped(sentence, "! ", "  ", width));
    if parted(true) {
        say("profile or posterior part from the covariance by more than 20 %: trust them, the problem is not linear");
    }
    if parted(false) {
        say(
            "a bootstrap parts from the covariance by more than 20 %: the noise is not what sigma says, few readings carry the \
             answer, or the curves are short (40 readings know their own scatter to 11 %)",
        );
    }
    for bootstrap in &found.bootstraps {
        if bootstrap.failed > 0 {
            let (failed, all) = (bootstrap.failed, bootstrap.replicates + bootstrap.failed);
            let what = match bootstrap.resampling {
                Resampling::Residuals => "residuals",
                Resampling::Cases => "cases",
            };
            say(&format!("{failed} of {all} replicates of the bootstrap of {what} found no minimum and are left out"));
        }
    }
    if let Some(values) = found.lower_minimum {
        let values: Vec<String> = values.iter().map(|value| plain(*value)).collect();
        say(&format!("a profile met a lower minimum, at {}: fit again with --start there", values.join(", ")));
    }
    if let Some(posterior) = &found.posterior {
        let number = |value: Option<f64>| value.map_or_else(|| "unknown".to_owned(), plain);
        let (r_hat, effective) = (number(posterior.r_hat), number(posterior.effective));
        let evaluations = posterior.evaluations;
        if posterior.samples == 0 {
            say(&format!("the posterior has no samples after {evaluations} evaluations; give more --max-evaluations"));
        } else if !posterior.converged {
            say(&format!(
                "the posterior is not sampled enough: split-R̂ {r_hat}, {effective} effective samples; give more \
                 --max-evaluations"
            ));
        }
        if posterior.samples > 0 {
            text.push_str(&format!(
                "  posterior: {} samples in {} chains, at least {effective} effective, split-R̂ {r_hat}, {evaluations} \
                 evaluations\n",
                posterior.samples, posterior.chains
            ));
        }
    }
    text
}

fn parting(method: &MethodIntervals) -> String {
    match method.parting.filter(|_| method.parts()) {
        Some(parting) if parting > 0.0 => format!("{:.0} % wider", 100.0 * parting),
        Some(parting) => format!("{:.0} % narrower", -100.0 * parting),
        None => String::new(),
    }
}

/// An interval with the digits that its width asks for; an open end is a bound.
fn ends(method: &MethodIntervals, interval: [Option<f64>; 2]) -> String {
    let width = match method.intervals.interval_68 {
        [Some(low), Some(high)] => Some(0.5 * (high - low)),
        _ => method.sigma,
    };
    let number = |value: f64| width.map_or_else(|| plain(value), |width| to_place_of(value, width));
    match interval {
        [Some(low), Some(high)] => format!("{} to {}", number(low), number(high)),
        [Some(low), None] => format!("above {}", number(low)),
        [None, Some(high)] => format!("below {}", number(high)),
        [None, None] => "all of the bounds".to_owned(),
    }
}
