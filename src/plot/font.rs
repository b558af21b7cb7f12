//! The embedded font: `DejaVu` Sans, regular and bold, cut down to Latin, Greek and the signs of science.
//!
//! The drawing library uses no system font and draws a character outside the font as nothing, without a word.
//! [`printable`] therefore replaces such characters by `?`; every text of a chart goes through it.
//!
//! The fonts and the list of their characters are made by `scripts/font/subset.py`.

use std::sync::OnceLock;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use super::PlotError;

mod covered;

/// The font family of the charts: in a PNG always the first, in an SVG the first that the viewer has.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Heights of a line, in ems, by the font's own tables (2384 of 2048 units). The bitmap renderer takes this as "size".
pub(super) const EMS_PER_LINE: f64 = 2384.0 / 2048.0;

/// Texts are measured at this size and scaled down, because the drawing library rounds widths to whole pixels.
const MEASURING_EM: f64 = 256.0;

const REGULAR: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");
const BOLD: &[u8] = include_bytes!("font/DejaVuSans-Bold-subset.ttf");

/// Makes the embedded fonts known to the drawing library, as [`FAMILY`] and as `sans-serif`. Works once; later
/// calls cost nothing. Needed only before drawing with `plotters` directly: [`picture`](super::picture) calls it.
///
/// # Errors
/// [`PlotError::Font`] if the embedded bytes are not a font.
pub fn register() -> Result<(), PlotError> {
    static OUTCOME: OnceLock<Result<(), &'static str>> = OnceLock::new();
    let register_all = || {
        for family in [FAMILY, "sans-serif"] {
            register_font(family, FontStyle::Normal, REGULAR).map_err(|_| "normal")?;
            register_font(family, FontStyle::Bold, BOLD).map_err(|_| "bold")?;
        }
        Ok(())
    };
    OUTCOME.get_or_init(register_all).map_err(|style| PlotError::Font { style })
}

/// The characters of the text that the embedded font cannot draw, each once, in order of appearance.
///
/// ```
/// use morpho_fit::plot::font::missing_glyphs;
/// assert_eq!(missing_glyphs("θ = −45°, χ² ≤ 1"), []);
/// assert_eq!(missing_glyphs("蝶.csv 蝶"), ['蝶']);
/// ```
#[must_use]
pub fn missing_glyphs(text: &str) -> Vec<char> {
    let mut missing = Vec::new();
    for character in text.chars().filter(|&character| !is_covered(character)) {
        if !missing.contains(&character) {
            missing.push(character);
        }
    }
    missing
}

/// The text as it can be drawn: tabs and line breaks become spaces, characters without glyph become `?`.
///
/// ```
/// assert_eq!(morpho_fit::plot::font::printable("蝶\t1.csv"), "? 1.csv");
/// ```
#[must_use]
pub fn printable(text: &str) -> String {
    let drawable = |character: char| match character {
        '\t' | '\n' | '\r' => ' ',
        covered if is_covered(covered) => covered,
        _ => '?',
    };
    text.chars().map(drawable).collect()
}

fn is_covered(character: char) -> bool {
    covered::COVERED.iter().any(|&(first, last)| (first..=last).contains(&character))
}

/// The font for the drawing library; `size` as its renderer understands it, see [`EMS_PER_LINE`].
pub(super) fn description(size: f64, bold: bool) -> FontDesc<'static> {
    FontDesc::new(FontFamily::Name(FAMILY), size, if bold { FontStyle::Bold } else { FontStyle::Normal })
}

/// Width of a text on one line, in the unit of `em`, the size of the letters.
///
/// # Errors
/// [`PlotError`] if the embedded font cannot be read.
pub fn width(text: &str, em: f64, bold: bool) -> Result<f64, PlotError> {
    register()?;
    let (width, _) = description(MEASURING_EM * EMS_PER_LINE, bold)
        .box_size(&printable(text))
        .map_err(|source| PlotError::Drawing { format: "PNG", source: Box::new(source) })?;
    Ok(f64::from(width) * em / MEASURING_EM)
}

/// Breaks a text into lines not wider than `limit`: at spaces where possible, else after one of `_-/.,;:`, which
/// suits file names, else anywhere.
///
/// Nothing is lost but the spaces at the breaks. A line has at least one character, however narrow the limit.
///
/// # Errors
/// [`PlotError`] if the embedded font cannot be read.
pub fn wrap(text: &str, em: f64, bold: bool, limit: f64) -> Result<Vec<String>, PlotError> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in printable(text).split(' ').filter(|word| !word.is_empty()) {
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if width(&longer, em, bold)? <= limit {
            line = longer;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        for character in word.chars() {
            while !line.is_empty() && width(&format!("{line}{character}"), em, bold)? > limit {
                let cut = line.rfind(['_', '-', '/', '.', ',', ';', ':']).map_or(line.len(), |last| last + 1);
                let rest = line.split_off(cut);
                lines.push(std::mem::replace(&mut line, rest));
            }
            line.push(character);
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_covered_character_leaves_ink_unless_it_is_a_space() {
        register().unwrap();
        for bold in [false, true] {
            for character in covered::COVERED.iter().flat_map(|&(first, last)| first..=last) {
                let mut inked = 0;
                description(40.0, bold)
                    .draw(&character.to_string(), (0, 0), |_, _, coverage| {
                        inked += i32::from(coverage > 0.5);
                        Ok::<_, std::convert::Infallible>(())
                    })
                    .unwrap()
                    .unwrap();
                let blank = character.is_whitespace() || character == '\u{ad}';
                assert!(blank || inked > 0, "U+{:04X} bold {bold}", u32::from(character));
            }
        }
    }

    #[test]
    fn the_alphabet_of_the_charts_is_covered() {
        const GLYPHS: &str = concat!(
            "aäßÅñé ΑΩαβγδεζηθικλμνξοπρςστυφχψωϑϕ",
            " ⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ ₀₁₂₃₄₅₆₇₈₉ −±×÷·⋅≤≥≈≠∞∝√ °′″‰µ ←→↑↓↔⇒ Δ∂∇∑ –—…“”‘’ \u{2009}\u{202f}\u{a0}|",
        );
        assert_eq!(missing_glyphs(GLYPHS), []);
    }

    #[test]
    fn the_minus_sign_is_not_the_hyphen() {
        assert!(width("−", 10.0, false).unwrap() > 1.5 * width("-", 10.0, false).unwrap());
    }

    #[test]
    fn width_grows_with_the_letters_and_with_weight() {
        let regular = width("reflectivity", 10.0, false).unwrap();
        assert!((width("reflectivity", 20.0, false).unwrap() - 2.0 * regular).abs() < 1e-9);
        assert!(width("reflectivity", 10.0, true).unwrap() > regular);
    }

    #[test]
    fn wrapped_lines_fit_and_lose_nothing() {
        let text = "one two-and-a-very-long-word-that-fits-on-no-line three four";
        let lines = wrap(text, 12.0, false, 80.0).unwrap();
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        for line in &lines {
            assert!(width(line, 12.0, false).unwrap() <= 80.0, "{line}");
        }
        assert_eq!(lines[1], "two-and-a-");
        for line in wrap(".WWWWWWWWWWWWWW", 12.0, false, 60.0).unwrap() {
            assert!(width(&line, 12.0, false).unwrap() <= 60.0, "{line}");
        }
        assert_eq!(wrap("abc", 12.0, false, 0.0).unwrap(), ["a", "b", "c"]);
        assert!(wrap(" \n ", 12.0, false, 80.0).unwrap().is_empty());
    }
}
