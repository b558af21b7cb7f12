//! Checks that the charts of uncertainty share.

use super::PlotError;

/// Values beyond this in size are not drawn, as in the panels.
const LARGEST: f64 = 1e300;

/// A number of things within `least..=most`.
pub(super) fn count(
    chart: &'static str,
    what: &str,
    (least, most): (usize, usize),
    found: usize,
) -> Result<(), PlotError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(PlotError::Count { chart, what: what.to_owned(), least, most, found })
}

/// A list as long as it must be.
pub(super) fn length(chart: &'static str, what: &str, expected: usize, found: usize) -> Result<(), PlotError> {
    if expected == found {
        return Ok(());
    }
    Err(PlotError::Unequal { chart, what: what.to_owned(), expected, found })
}

/// Numbers that can all be drawn.
pub(super) fn drawable(chart: &'static str, what: &str, values: &[f64]) -> Result<(), PlotError> {
    all(chart, what, values, |value| value.abs() <= LARGEST)
}

/// Numbers that all pass; the first other one is named.
pub(super) fn all(
    chart: &'static str,
    what: &str,
    values: &[f64],
    passes: impl Fn(f64) -> bool,
) -> Result<(), PlotError> {
    match values.iter().enumerate().find(|&(_, &value)| !passes(value)) {
        None => Ok(()),
        Some((index, &value)) => Err(PlotError::Unusable { chart, what: what.to_owned(), index, value }),
    }
}
