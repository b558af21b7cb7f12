//! Sentences about a fit: the verdict, the status of a parameter, the values in one line.

use super::digits::{plain, to_place_of, with_sigma};
use crate::inversion::{
    AdviceFound, Combination, Estimate, FitOutcome, SigmaExpected, SigmaSource, SplitExpected, Status, Verdict,
};

/// Other values of an ambiguous estimate that are named.
const OTHERS: usize = 3;
/// Wavelength at which an index is told, nm.
const GREEN: f64 = 550.0;
/// A thickness known no better than this, nm, is all but unknown.
const ROUGH: f64 = 10.0;

/// The verdict as a sentence without a full stop, the first line of every report.
#[must_use]
pub fn verdict(outcome: &FitOutcome) -> String {
    let missed = if outcome.sigma_source == SigmaSource::Widened { "the model misses the data; " } else { "" };
    match outcome.verdict {
        Verdict::Determined => format!("{missed}{}", determined(outcome)),
        Verdict::PartlyDetermined => format!("{missed}{}", partly(outcome)),
        Verdict::NoThickness => {
            format!("{missed}a minimum was found, but it determines no thickness, not even their sum")
        }
        Verdict::NotConverged => format!("no minimum was found: {}", outcome.termination.phrase()),
        Verdict::Given => {
            let how = if missed.is_empty() { "is not contradicted by" } else { "misses" };
            format!("nothing was free; the given structure {how} the data")
        }
    }
}

fn free(outcome: &FitOutcome) -> Vec<(&'static str, &Estimate)> {
    let is_free = |(name, _): &(&str, &Estimate)| outcome.identifiability.free.iter().any(|free| free == name);
    outcome.parameters.each().into_iter().filter(is_free).collect()
}

fn determined(outcome: &FitOutcome) -> String {
    let names: Vec<&str> = free(outcome).iter().map(|(name, _)| *name).collect();
    match names.as_slice() {
        all if all.len() == outcome.parameters.each().len() => "all five parameters are determined".to_owned(),
        names => format!("{} {} determined", list(names), is(names)),
    }
}

fn partly(outcome: &FitOutcome) -> String {
    let names = |keep: &dyn Fn(Status) -> bool| -> Vec<&str> {
        free(outcome).iter().filter(|(_, estimate)| keep(estimate.status)).map(|(name, _)| *name).collect()
    };
    let known = names(&Status::is_determined);
    let on_a_bound = |is_itself: bool| -> Vec<&str> {
        let keep = |estimate: &Estimate| estimate.status == Status::AtBound && estimate.with.is_empty() == is_itself;
        free(outcome).iter().filter(|(_, estimate)| keep(estimate)).map(|(name, _)| *name).collect()
    };
    let (stopped, moving) = (on_a_bound(true), on_a_bound(false));
    let ambiguous = names(&|status| status == Status::Ambiguous);
    let one_sided = names(&|status| status == Status::OneSided);
    let apart = [Status::AtBound, Status::Ambiguous, Status::OneSided];
    let unknown = names(&|status| !status.is_determined() && !apart.contains(&status));
    let mut parts = Vec::new();
    let split = ["d_air", "d_cuticle"].iter().all(|name| unknown.contains(name));
    let sums = [("period", &outcome.derived.period), ("optical sum", &outcome.derived.optical_sum)];
    let sum = sums.into_iter().find(|(_, sum)| split && sum.status.is_determined()).map(|(name, _)| name);
    if let Some(sum) = sum {
        parts.push(format!("the {sum} of the layers is determined, its split into d_air and d_cuticle is not"));
    }
    if !known.is_empty() {
        parts.push(format!("{} {} determined", list(&known), is(&known)));
    }
    let rest: Vec<&str> =
        unknown.into_iter().filter(|name| sum.is_none() || !["d_air", "d_cuticle"].contains(name)).collect();
    if !rest.is_empty() {
        let word = if known.is_empty() && sum.is_none() { " determined" } else { "" };
        parts.push(format!("{} {} not{word}", list(&rest), is(&rest)));
    }
    if !one_sided.is_empty() {
        parts.push(format!("{} {} told on one side only", list(&one_sided), is(&one_sided)));
    }
    if !ambiguous.is_empty() {
        let (names, verb) = (list(&ambiguous), is(&ambiguous));
        parts.push(format!("{names} {verb} ambiguous: another structure fits as well"));
    }
    if !stopped.is_empty() {
        let with = if stopped.len() == 1 { "it" } else { "them" };
        let verb = if moving.len() == 1 { "moves" } else { "move" };
        let others =
            if moving.is_empty() { String::new() } else { format!(", and {} {verb} with {with}", list(&moving)) };
        parts.push(format!("{} ended on a bound{others}", list(&stopped)));
    }
    parts.join("; ")
}

fn is(names: &[&str]) -> &'static str {
    if names.len() == 1 { "is" } else { "are" }
}

/// `a`, `a and b`, `a, b and c`.
#[must_use]
pub fn list(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [head @ .., last] => format!("{} and {last}", head.join(", ")),
    }
}

/// The status of an estimate with the parameters that it is tied to, or with its values elsewhere.
#[must_use]
pub fn status(estimate: &Estimate) -> String {
    let phrase = estimate.status.phrase();
    let with: Vec<&str> = estimate.with.iter().map(String::as_str).collect();
    match (with.as_slice(), estimate.status) {
        (_, Status::Ambiguous) => {
            let others: Vec<String> = estimate.others.iter().map(|value| plain(*value)).collect();
            let others: Vec<&str> = others.iter().map(String::as_str).collect();
            let more = if others.len() > OTHERS { ", …" } else { "" };
            let named = others.iter().take(OTHERS).copied().collect::<Vec<&str>>().join(", or ");
            if others.is_empty() { phrase.to_owned() } else { format!("{phrase}: or {named}{more}") }
        }
        ([], _) => phrase.to_owned(),
        (with, Status::Linked) => format!("{phrase} to {}", list(with)),
        (with, Status::NotIdentifiable) => format!("{phrase} apart from {}", list(with)),
        (with, _) => format!("{phrase} with {}", list(with)),
    }
}

/// What a status means for the reader of a value.
#[must_use]
pub fn meaning(status: Status) -> &'static str {
    match status {
        Status::Ok => "determined; the interval holds",
        Status::Fixed | Status::Linked => "as the settings say",
        Status::AtBound => {
            "the best value lies on a bound, or moves with one that does: the data ask for more than the bounds allow"
        }
        Status::OneSided => "told on one side: the interval reaches a bound and is open there",
        Status::Correlated => {
            "determined, but almost only together with another: quote both with their correlation, or a sum that is known better"
        }
        Status::Ambiguous => {
            "another structure with another value fits as well; the interval, if there is one, spans them all"
        }
        Status::Insensitive => "nothing in the data depends on it: no value is given",
        Status::NotIdentifiable => "the data cannot tell it apart from others or from the noise: no value is given",
    }
}

/// The name of a quantity for a reader.
#[must_use]
pub fn quantity(name: &str) -> &str {
    match name {
        "period" => "d_air + d_cuticle",
        "optical_sum" => "optical sum",
        name => name,
    }
}

/// The interval of 95 % in words; an open end is a bound of the search.
#[must_use]
pub fn interval(estimate: &Estimate) -> String {
    estimate.interval_95.map_or_else(String::new, |interval| ends(interval, estimate.sigma))
}

/// An interval in words with the digits that a standard deviation of `width` would have; an open end is a bound.
///
/// ```
/// use morpho_fit::report::wording::ends;
/// assert_eq!(ends([Some(140.7182), Some(141.3574)], Some(0.16)), "140.72 to 141.36");
/// assert_eq!(ends([None, Some(2.5)], None), "below 2.5");
/// ```
#[must_use]
pub fn ends(interval: [Option<f64>; 2], width: Option<f64>) -> String {
    let number = |value: f64| width.map_or_else(|| plain(value), |width| to_place_of(value, width));
    match interval {
        [Some(low), Some(high)] => format!("{} to {}", number(low), number(high)),
        [Some(low), None] => format!("above {}", number(low)),
        [None, Some(high)] => format!("below {}", number(high)),
        [None, None] => "all of the bounds".to_owned(),
    }
}

/// A combination of parameters with its precision: `d_air + 1.52·d_cuticle to 0.014 %`, `lamella_width to 1.2 % of its
/// bounds`.
#[must_use]
pub fn combination(found: &Combination) -> String {
    let term = |(place, (name, coefficient)): (usize, (&String, &f64))| {
        let sign = match (place, *coefficient < 0.0) {
            (0, _) => "",
            (_, true) => " - ",
            (_, false) => " + ",
        };
        let size = coefficient.abs();
        let factor = if place == 0 { String::new() } else { format!("{}·", plain((size * 1e3).round() / 1e3)) };
        format!("{sign}{factor}{name}")
    };
    let thicknesses = found.names.iter().all(|name| name.starts_with("d_"));
    let per_cent = |share: f64| plain(to_two_digits(100.0 * share));
    if !thicknesses && found.names.len() > 1 {
        let names: Vec<&str> = found.names.iter().map(String::as_str).collect();
        return format!("{} together to {} % of their bounds", list(&names), per_cent(found.of_range));
    }
    let sum: String = found.names.iter().zip(&found.coefficients).enumerate().map(term).collect();
    match found.relative {
        Some(relative) => format!("{sum} to {} %", per_cent(relative)),
        None if thicknesses => format!("{sum} to {} nm", plain(to_two_digits(found.sigma))),
        None => format!("{sum} to {} % of its bounds", per_cent(found.of_range)),
    }
}

/// The number with two significant digits.
fn to_two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// What was found, in one line: `d_air 141.04 ± 0.27 nm, …`; what is fixed or not determined is left out.
#[must_use]
pub fn values(outcome: &FitOutcome) -> String {
    let one = |(name, estimate): (&str, &Estimate)| {
        let value = estimate.value.filter(|_| estimate.status != Status::Fixed)?;
        let unit = &estimate.unit;
        Some(match estimate.sigma {
            Some(sigma) => {
                let (value, sigma) = with_sigma(value, sigma);
                format!("{name} {value} ± {sigma} {unit}")
            }
            None => format!("{name} {} {unit} ({})", plain(value), estimate.status.phrase()),
        })
    };
    let mut found: Vec<String> = outcome.parameters.each().into_iter().filter_map(one).collect();
    let thickness = |name: &str| found.iter().any(|text| text.starts_with(name));
    if !(thickness("d_air") || thickness("d_cuticle")) {
        let sums = [("d_air + d_cuticle", &outcome.derived.period), ("optical sum", &outcome.derived.optical_sum)];
        found.splice(0..0, sums.into_iter().filter_map(one).take(1));
    }
    found.join(", ")
}

/// A share of its standard deviation now, below which a quantity gains from a scan.
const GAINS: f64 = 0.5;
/// chi² from which another structure no longer fits as well.
const SPLIT: f64 = 9.0;

/// Whether the expected standard deviations are numbers to tell: where a thickness is all but unknown the derivatives at one
/// structure are no forecast.
#[must_use]
pub fn forecasts(advice: &AdviceFound) -> bool {
    !advice.expected.iter().any(|expected| expected.name.starts_with("d_") && expected.before > ROUGH)
}

/// Scans to add, and what they would tell: `a spectrum …: d_air to ± 0.4 nm (now ± 80 nm)`.
#[must_use]
pub fn advice(advice: &AdviceFound) -> String {
    let scans: Vec<&str> = advice.scans.iter().map(String::as_str).collect();
    let gain = |expected: &&SigmaExpected| expected.after < GAINS * expected.before;
    let rough = !forecasts(advice);
    let one = |expected: &SigmaExpected| {
        let SigmaExpected { name, unit, after, .. } = expected;
        if rough { name.clone() } else { format!("{name} to about ± {} {unit}", with_sigma(0.0, *after).1) }
    };
    let free = |expected: &&SigmaExpected| expected.name != "period" && expected.name != "optical_sum";
    let gains: Vec<String> = advice.expected.iter().filter(free).filter(gain).map(one).collect();
    let mut text = scans.join("; and ");
    if !gains.is_empty() {
        let gains: Vec<&str> = gains.iter().map(String::as_str).collect();
        text.push_str(&format!(". Tells {}", list(&gains)));
    }
    let open = |split: &&SplitExpected| split.chi2_expected < SPLIT;
    match (advice.splits.iter().filter(open).count(), advice.splits.len()) {
        (_, 0) => {}
        (0, _) => text.push_str("; should rule out the other structures that fit as well"),
        (left, all) if left < all => text.push_str("; should rule out some of the other structures that fit as well"),
        _ => {}
    }
    text
}

/// Where the standard deviations come from.
#[must_use]
pub fn sigma_source(source: SigmaSource) -> &'static str {
    match source {
        SigmaSource::Stated => "sigma as the data state it",
        SigmaSource::Widened => "sigma widened because the model misses the data",
        SigmaSource::Scatter => "sigma from the scatter about the model: the data state none",
    }
}

/// The best and the worst known combination of parameters; empty where the fit has no answer, or they would be no measure.
#[must_use]
pub fn stiffness(outcome: &FitOutcome) -> String {
    let all = &outcome.identifiability.combinations;
    let (Some(stiff), Some(sloppy), true) = (all.first(), all.last(), all.len() > 1) else { return String::new() };
    // Where the model misses the data, or holds a part of them at values that nothing tells, these are not what is known.
    let told = |(name, estimate): (&str, &Estimate)| {
        estimate.value.is_some() || [stiff, sloppy].iter().all(|one| one.names.iter().all(|own| own != name))
    };
    let is_measure = outcome.sigma_source != SigmaSource::Widened && outcome.parameters.each().into_iter().all(told);
    if !answers(outcome) || !is_measure {
        return String::new();
    }
    format!("stiffest: {}; sloppiest: {}", combination(stiff), combination(sloppy))
}

/// What is averaged over; empty for plane waves on equal layers.
#[must_use]
pub fn averages(outcome: &FitOutcome) -> String {
    let averages = outcome.settings.averages;
    if averages.is_none() { String::new() } else { format!("averaged over: {averages}") }
}

/// How well the model meets the data.
#[must_use]
pub fn goodness(outcome: &FitOutcome) -> String {
    let source = sigma_source(outcome.sigma_source);
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let per = outcome.chi2 / outcome.dof as f64;
    if outcome.dof == 0 {
        return format!("chi² {} without degrees of freedom; {source}", plain(outcome.chi2));
    }
    let (chi2, dof) = (plain(outcome.chi2), outcome.dof);
    let scatter = outcome.sigma_ratio.is_none();
    if scatter {
        return format!("scatter {} with {dof} degrees of freedom; {source}", plain(per.sqrt()));
    }
    format!("chi² {chi2} for {dof} degrees of freedom, {} each; {source}", plain(per))
}

/// What the thicknesses hold for, in one line: the fit takes it as exact. Empty where no thickness is told.
#[must_use]
pub fn taken_as_exact(outcome: &FitOutcome) -> String {
    let stack = &outcome.settings.stack;
    let index = |wavelength: f64| stack.media(wavelength).ok().map(|media| media.cuticle.re);
    let Some(green) = index(GREEN).filter(|_| answers(outcome)) else { return String::new() };
    let at = if index(GREEN - 100.0) == Some(green) { String::new() } else { format!(" at {GREEN} nm") };
    let (layers, plural) = (stack.layers, if stack.layers == 1 { "" } else { "s" });
    format!("for {layers} layer{plural} and n_cuticle {}{at}, taken as exact (see morpho-fit constant)", plain(green))
}

/// Whether the fit tells a thickness, so that there is something to compare with.
#[must_use]
pub fn answers(outcome: &FitOutcome) -> bool {
    !matches!(outcome.verdict, Verdict::NotConverged | Verdict::NoThickness)
}

/// The sentence with a capital letter, unless it begins with the name of a parameter or a symbol.
#[must_use]
pub fn capitalised(text: &str) -> String {
    let is_name = |word: &str| word.contains('_') || ["delta", "chi²"].contains(&word.trim_end_matches(','));
    if text.split(' ').next().is_some_and(is_name) {
        return text.to_owned();
    }
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_read_like_sentences() {
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
        assert_eq!(list(&["a", "b"]), "a and b");
        assert_eq!(list(&["a"]), "a");
    }
}
