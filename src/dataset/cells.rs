//! One cell to one number, strictly, and back.

use super::findings::excerpt;
use super::kind::{FindingKind, NumberHint};

/// What stands before the decimals of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DecimalMark {
    Point,
    Comma,
}

/// The number in a trimmed cell and its decimal mark if it has one; finite.
pub(super) fn number(cell: &str, decimal_commas: bool) -> Result<(f64, Option<DecimalMark>), FindingKind> {
    if cell.is_empty() {
        return Err(FindingKind::EmptyCell);
    }
    let comma = decimal_commas && cell.contains(',');
    let parsed = if comma { with_point(cell) } else { cell.parse().ok() };
    match parsed {
        Some(value) if value.is_finite() => {
            let point = cell.contains('.').then_some(DecimalMark::Point);
            Ok((value, if comma { Some(DecimalMark::Comma) } else { point }))
        }
        Some(_) => Err(FindingKind::NotFinite { found: excerpt(cell) }),
        None => Err(FindingKind::NotANumber { found: excerpt(cell), hint: hint(cell) }),
    }
}

/// Reads a decimal comma; `None` if there is a point as well, because then one of them groups thousands.
fn with_point(cell: &str) -> Option<f64> {
    if cell.contains('.') || cell.matches(',').count() != 1 {
        return None;
    }
    cell.replace(',', ".").parse().ok()
}

fn hint(cell: &str) -> Option<NumberHint> {
    let reads = |text: &str| text.trim().parse::<f64>().is_ok_and(f64::is_finite);
    if cell.starts_with('#') {
        return Some(NumberHint::Spreadsheet);
    }
    if cell.strip_suffix('%').is_some_and(|rest| reads(rest) || reads(&rest.replace(',', "."))) {
        return Some(NumberHint::Percent);
    }
    if reads(&cell.replace(['\u{2212}', '\u{2012}', '\u{2013}', '\u{2014}', '\u{FF0D}'], "-")) {
        return Some(NumberHint::Minus);
    }
    if with_point(cell).is_some() {
        return Some(NumberHint::DecimalComma);
    }
    if reads(&cell.replace(',', "")) || reads(&cell.replace('.', "").replace(',', ".")) {
        return Some(NumberHint::Thousands);
    }
    let number = cell.trim_end_matches(|c: char| c.is_alphabetic() || c == '°' || c == 'µ');
    (number.len() < cell.len() && reads(number)).then_some(NumberHint::Unit)
}

/// The shortest text that reads back to the same bits; with an exponent only where the zeros would pile up.
pub(super) fn plain(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-5..1e15).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_one_decimal_mark() {
        assert_eq!(number("0,5", true), Ok((0.5, Some(DecimalMark::Comma))));
        assert_eq!(number("0.5", true), Ok((0.5, Some(DecimalMark::Point))));
        assert_eq!(number("-5e2", false), Ok((-500.0, None)));
        for text in ["1.234,5", "1,234,5", "0x10", "1_000", "", "--1", "1 2", "nan", "inf", "1e999"] {
            assert!(number(text, true).is_err(), "{text}");
        }
    }

    #[test]
    fn hints_tell_what_the_writer_meant() {
        for (text, expected) in [
            ("0,5", Some(NumberHint::DecimalComma)),
            ("1,234.5", Some(NumberHint::Thousands)),
            ("1.234,5", Some(NumberHint::Thousands)),
            ("\u{2212}30", Some(NumberHint::Minus)),
            ("45 %", Some(NumberHint::Percent)),
            ("550 nm", Some(NumberHint::Unit)),
            ("30°", Some(NumberHint::Unit)),
            ("#DIV/0!", Some(NumberHint::Spreadsheet)),
            ("abc", None),
        ] {
            assert_eq!(hint(text), expected, "{text}");
        }
    }

    #[test]
    fn plain_text_reads_back_to_the_same_bits() {
        for value in [90.0, 0.1, -0.02, 1e-300, 5e-324, f64::MAX, 123_456.789, 0.0] {
            assert_eq!(plain(value).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
        }
        assert_eq!(plain(90.0), "90");
    }
}
