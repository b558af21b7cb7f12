//! Numbers as a reader wants them: two significant digits of the standard deviation, and the value to the same place.

/// Decimals beyond which a standard deviation is written with an exponent.
const MOST_DECIMALS: i32 = 6;
/// Significant digits of a number without a standard deviation.
const SIGNIFICANT: i32 = 4;

/// Value and standard deviation with the same number of decimals, of which the deviation has two significant digits.
///
/// ```
/// use morpho_fit::report::with_sigma;
/// assert_eq!(with_sigma(141.03721, 0.2713), ("141.04".to_owned(), "0.27".to_owned()));
/// assert_eq!(with_sigma(1234.56, 99.7), ("1235".to_owned(), "100".to_owned()));
/// assert_eq!(with_sigma(0.5, 3e-9), ("0.500000".to_owned(), "3.0e-9".to_owned()));
/// ```
#[must_use]
pub fn with_sigma(value: f64, sigma: f64) -> (String, String) {
    if !(sigma.is_finite() && sigma > 0.0) {
        return (plain(value), if sigma.is_finite() { "0".to_owned() } else { "∞".to_owned() });
    }
    let decimals = decimals(sigma, 2);
    if decimals > MOST_DECIMALS {
        return (fixed(value, MOST_DECIMALS), format!("{sigma:.1e}"));
    }
    (fixed(value, decimals), fixed(sigma, decimals))
}

/// A number with four significant digits, or as many as stand before its point.
///
/// ```
/// use morpho_fit::report::plain;
/// assert_eq!((plain(0.0123456), plain(2.5), plain(123456.7)), ("0.01235".into(), "2.5".into(), "123457".into()));
/// ```
#[must_use]
pub fn plain(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-4..1e7).contains(&size) {
        return format!("{value:.3e}");
    }
    let text = fixed(value, decimals(size, SIGNIFICANT));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Value with the decimals that `sigma` would have.
#[must_use]
pub(crate) fn to_place_of(value: f64, sigma: f64) -> String {
    with_sigma(value, sigma).0
}

/// Decimals for so many significant digits, looking at the rounded number: 0.0996 to two is 0.10.
fn decimals(size: f64, significant: i32) -> i32 {
    if !(size.is_finite() && size > 0.0) {
        return 0;
    }
    let digits = usize::try_from(significant - 1).unwrap_or_default();
    let rounded = format!("{size:.digits$e}");
    let exponent = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()).unwrap_or_default();
    (significant - 1 - exponent).max(0)
}

fn fixed(value: f64, decimals: i32) -> String {
    let decimals = usize::try_from(decimals).unwrap_or_default();
    let text = format!("{value:.decimals$}");
    // -0.00 is 0.00
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| matches!(c, '0' | '.')) => rest.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_has_two_significant_digits_after_rounding() {
        assert_eq!(with_sigma(10.0, 0.0996), ("10.00".to_owned(), "0.10".to_owned()));
        assert_eq!(with_sigma(-0.001, 0.5), ("0.00".to_owned(), "0.50".to_owned()));
        assert_eq!(with_sigma(7.0, f64::INFINITY).1, "∞");
    }

    #[test]
    fn plain_numbers_have_no_trailing_zeros() {
        assert_eq!(plain(300.0), "300");
        assert_eq!(plain(0.0), "0");
        assert_eq!(plain(1.2e-9), "1.200e-9");
        assert_eq!(plain(-10.0), "-10");
    }
}
