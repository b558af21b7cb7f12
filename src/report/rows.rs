//! The rows of a report's tables as texts; terminal and page choose the columns they have room for.

use super::digits::{plain, with_sigma};
use super::wording;
use crate::inversion::{Estimate, FitOutcome, MinimumFound, NuisanceFound};

/// What stands where there is no value.
pub(super) const NONE: &str = "—";

/// Name, value, `± sigma`, unit, interval of 68 %, interval of 95 %, status.
pub(super) fn estimate(name: &str, estimate: &Estimate) -> [String; 7] {
    let (value, sigma) = match (estimate.value, estimate.sigma) {
        (None, _) => (NONE.to_owned(), String::new()),
        (Some(value), None) => (plain(value), String::new()),
        (Some(value), Some(sigma)) => {
            let (value, sigma) = with_sigma(value, sigma);
            (value, format!("± {sigma}"))
        }
    };
    let interval_68 = estimate.interval_68.map_or_else(String::new, |ends| wording::ends(ends, estimate.sigma));
    let (interval_95, status) = (wording::interval(estimate), wording::status(estimate));
    [name.to_owned(), value, sigma, estimate.unit.clone(), interval_68, interval_95, status]
}

/// The sums of the thicknesses with their names.
pub(super) fn sums(outcome: &FitOutcome) -> [(&'static str, &Estimate); 2] {
    [("period", &outcome.derived.period), ("optical_sum", &outcome.derived.optical_sum)]
        .map(|(name, sum)| (wording::quantity(name), sum))
}

/// Number, the five values in their order, delta chi², weight, relation to the best.
///
/// A value that the data do not tell is none at a minimum either.
pub(super) fn minimum(place: usize, minimum: &MinimumFound, outcome: &FitOutcome) -> [String; 9] {
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = {
        let told = outcome.parameters.each().map(|(_, estimate)| estimate.value.is_some());
        let mut told = told.into_iter();
        minimum.values.map(|value| if told.next() == Some(true) { plain(settled(value)) } else { NONE.to_owned() })
    };
    let (chi2, weight) = (plain(settled(minimum.delta_chi2)), format!("{:.0} %", 100.0 * minimum.weight));
    let (number, relation) = ((place + 1).to_string(), minimum.relation.phrase());
    [number, d_air, d_cuticle, delta, phi_alpha, lamella_width, chi2, weight, relation]
}

/// The number without what rounding left of a zero.
fn settled(value: f64) -> f64 {
    if value.abs() < 1e-6 { 0.0 } else { value }
}

/// Name, value, `± sigma` or what the value stands for.
pub(super) fn nuisance(found: &NuisanceFound) -> [String; 3] {
    let name = found.name.clone();
    match found.sigma {
        Some(sigma) => {
            let (value, sigma) = with_sigma(found.value, sigma);
            [name, value, format!("± {sigma}")]
        }
        None if found.conditional => [name, plain(found.value), "for the held values only".to_owned()],
        None => [name, plain(found.value), String::new()],
    }
}
