//! A constant of the model fitted beside the parameters, in words.

use super::digits::{plain, with_sigma};
use super::table::{Align, Table};
use super::terminal::wrapped;
use super::wording;
use crate::inversion::Verdict;
use crate::inversion::intervals::{ConstantProfile, IntervalPair, QuantityOver};

/// The constant, and what it leaves of the parameters, in lines of `width` characters.
#[must_use]
pub fn text(found: &ConstantProfile, width: usize) -> String {
    let unit = found.constant.unit();
    let [one, two] = [found.intervals.interval_68, found.intervals.interval_95];
    let spread = half_width(&found.intervals);
    let value = spread.map_or_else(|| plain(found.best), |spread| with_sigma(found.best, spread).0);
    let told = found.told.map(|told| format!(" (the fit was told {})", plain(told))).unwrap_or_default();
    let mut text = String::new();
    let with_unit = |text: String| if unit.is_empty() { text } else { format!("{text} {unit}") };
    let (name, one, two) = (found.constant, wording::ends(one, spread), wording::ends(two, spread));
    let sentence = format!("{name} {}{told}; 68 %: {one}; 95 %: {two}", with_unit(value));
    text.push_str(&wrapped(&sentence, "", "  ", width));
    let warn = |text: &mut String, sentence: &str| text.push_str(&wrapped(sentence, "! ", "  ", width));
    if found.at_end {
        warn(&mut text, &format!("the best {name} is an end of the range: the data ask for more than it allows"));
    } else if found.intervals.interval_95 == [None, None] {
        warn(&mut text, &format!("the data do not determine {name} within the range"));
    }
    let columns = [
        ("", Align::Left),
        ("value", Align::Right),
        ("unit", Align::Left),
        (&*format!("± with {name} known"), Align::Right),
        ("68 % with it fitted", Align::Left),
        ("95 % with it fitted", Align::Left),
    ];
    if !found.quantities.is_empty() {
        let mut table = Table::new(&columns);
        for quantity in &found.quantities {
            table.row(row(quantity));
        }
        text.push('\n');
        text.push_str(&table.to_string());
    }
    for warning in &found.fit.outcome.warnings {
        warn(&mut text, warning);
    }
    if found.quantities.is_empty() && found.fit.outcome.verdict != Verdict::Given {
        warn(&mut text, "no parameter is determined at the best value");
    }
    text
}

fn row(quantity: &QuantityOver) -> [String; 6] {
    let width = half_width(&quantity.intervals).unwrap_or(quantity.sigma_known);
    [
        wording::quantity(&quantity.name).to_owned(),
        with_sigma(quantity.value, width).0,
        quantity.unit.clone(),
        with_sigma(quantity.value, quantity.sigma_known).1,
        wording::ends(quantity.intervals.interval_68, Some(width)),
        wording::ends(quantity.intervals.interval_95, Some(width)),
    ]
}

fn half_width(pair: &IntervalPair) -> Option<f64> {
    match pair.interval_68 {
        [Some(low), Some(high)] if high > low => Some(0.5 * (high - low)),
        _ => None,
    }
}
