//! Values of flags that have a grammar of their own: assignments, bounds, links, indices.

use morpho_fit::inversion::{Parameter, Role, Weight};
use morpho_fit::optics::{LamellaUnit, Material};
use std::path::PathBuf;

/// `NAME=VALUE`, the value as the library holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Assignment {
    pub(crate) parameter: Parameter,
    pub(crate) value: f64,
}

/// A role given to one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Given {
    pub(crate) parameter: Parameter,
    pub(crate) role: Role,
}

/// A refractive index as written, before any file is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Index {
    Known(Material),
    /// A CSV file with a column `wavelength_nm`, and the columns to use if they are not `n` and `k`.
    Table {
        path: PathBuf,
        n: Option<String>,
        k: Option<String>,
    },
}

pub(crate) fn parameter(name: &str) -> Result<Parameter, String> {
    let name = name.trim();
    Parameter::from_name(name).ok_or_else(|| {
        let names = Parameter::ALL.map(Parameter::name);
        let nearest =
            nearest(name, &names).map(|name| format!("did you mean `{name}`? It is one of ")).unwrap_or_default();
        format!(
            "`{name}` is no parameter; {}{} (or a)",
            if nearest.is_empty() { "there are " } else { &nearest },
            names.join(", ")
        )
    })
}

pub(crate) fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("`{text}` is not a finite number")),
        Err(_) => Err(format!("`{text}` is not a number; write it like 0.25 or 2.5e-1")),
    }
}

/// A number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err(format!("{value} is not above 0")) })
}

/// A number of at least 0.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value >= 0.0 { Ok(value) } else { Err(format!("{value} is below 0")) })
}

/// An angle of incidence or of view, degrees.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    within_angles(value).map(|()| value)
}

/// Whether light can come from, or go to, an angle in degrees.
pub(crate) fn within_angles(value: f64) -> Result<(), String> {
    if value.abs() <= 90.0 { Ok(()) } else { Err(format!("{value} is not within -90 to 90 degrees")) }
}

/// A whole number from 100 to 100 million.
pub(crate) fn count(text: &str) -> Result<usize, String> {
    match text.trim().parse::<usize>() {
        Ok(value) if (100..=100_000_000).contains(&value) => Ok(value),
        Ok(value) => Err(format!("{value} is not within 100 to 100000000")),
        Err(_) => Err(format!("`{text}` is not a whole number")),
    }
}

fn named(text: &str) -> Result<(Parameter, &str), String> {
    let (name, value) = text.split_once('=').ok_or("a parameter and a value are needed, such as d_air=141")?;
    Ok((parameter(name)?, value.trim()))
}

pub(crate) fn assignment(text: &str) -> Result<Assignment, String> {
    let (parameter, value) = named(text)?;
    Ok(Assignment { parameter, value: parameter.inside(number(value)?) })
}

pub(crate) fn fixed(text: &str) -> Result<Given, String> {
    assignment(text).map(|Assignment { parameter, value }| Given { parameter, role: Role::Fixed { value } })
}

pub(crate) fn bounds(text: &str) -> Result<Given, String> {
    let (parameter, value) = named(text)?;
    let (low, high) = value.split_once(':').ok_or_else(|| {
        format!("bounds need two numbers with a colon between them, such as {}=50:250", parameter.name())
    })?;
    let (lower, upper) = (parameter.inside(number(low)?), parameter.inside(number(high)?));
    if lower >= upper {
        return Err(format!("the lower bound {low} is not below the upper bound {high}"));
    }
    Ok(Given { parameter, role: Role::Free { lower, upper } })
}

/// `NAME=FACTOR*OTHER+CONSTANT` in any order, in the users' units: `d_cuticle=235-d_air`.
pub(crate) fn link(text: &str) -> Result<Given, String> {
    const SHAPE: &str = "a link is FACTOR*OTHER+CONSTANT, such as d_cuticle=235-d_air or d_cuticle=0.5*d_air+10";
    let (parameter, formula) = named(text)?;
    let mut other: Option<(Parameter, f64)> = None;
    let mut constant = 0.0;
    for (sign, term) in terms(formula) {
        if term.is_empty() {
            return Err(SHAPE.to_owned());
        }
        if let Ok(value) = term.parse::<f64>() {
            constant += sign * value;
            continue;
        }
        let (factor, name) = match term.split_once('*') {
            None => (1.0, term),
            Some((left, right)) => match (left.trim().parse::<f64>(), right.trim().parse::<f64>()) {
                (Ok(factor), Err(_)) => (factor, right),
                (Err(_), Ok(factor)) => (factor, left),
                _ => return Err(SHAPE.to_owned()),
            },
        };
        if other.replace((self::parameter(name)?, sign * factor)).is_some() {
            return Err(format!("a link follows one parameter; {SHAPE}"));
        }
    }
    let (other, factor) = other.ok_or_else(|| format!("`{formula}` names no parameter; {SHAPE}"))?;
    // The formula is in the users' units: one unit of the parameter over one unit of the other.
    let factor = factor * parameter.inside(1.0) / other.inside(1.0);
    let constant = parameter.inside(constant);
    if !(factor.is_finite() && constant.is_finite()) {
        return Err(SHAPE.to_owned());
    }
    Ok(Given { parameter, role: Role::Linked { other, factor, constant } })
}

/// Terms of a sum with their signs; the sign of an exponent belongs to its number.
fn terms(formula: &str) -> Vec<(f64, &str)> {
    let bytes = formula.as_bytes();
    let mut terms = Vec::new();
    let (mut sign, mut start) = (1.0, 0);
    for (at, &byte) in bytes.iter().enumerate() {
        let exponent = at >= 2 && matches!(bytes[at - 1], b'e' | b'E') && bytes[at - 2].is_ascii_digit();
        if matches!(byte, b'+' | b'-') && !exponent {
            let term = formula[start..at].trim();
            // A leading sign, or the sign after a `*`, starts no new term by itself.
            if !(term.is_empty() && terms.is_empty()) {
                terms.push((sign, term));
            }
            sign = if byte == b'-' { -1.0 } else { 1.0 };
            start = at + 1;
        }
    }
    terms.push((sign, formula[start..].trim()));
    terms
}

/// `1.56`, `1.56+0.06i`, `cauchy:A,B`, or a file with an optional choice of columns.
pub(crate) fn index(text: &str) -> Result<Index, String> {
    let text = text.trim();
    if let Some(constants) = text.strip_prefix("cauchy:") {
        let (a, b) =
            constants.split_once(',').ok_or("Cauchy's formula needs A and B (nm²), such as cauchy:1.517,8800")?;
        return Ok(Index::Known(Material::Cauchy { a: number(a)?, b: number(b)? }));
    }
    if let Some((n, k)) = complex(text) {
        if !(n.is_finite() && n > 0.0 && k.is_finite() && k >= 0.0) {
            return Err(format!("`{text}` is no index: n must be above 0 and k, which absorbs, at least 0"));
        }
        return Ok(Index::Known(Material::Constant { n, k }));
    }
    if text.is_empty() {
        return Err("an index is 1.56, 1.56+0.06i, cauchy:A,B or a CSV file".to_owned());
    }
    let (path, columns) = match text.rsplit_once(':') {
        Some((path, columns)) if !path.is_empty() && !columns.contains(['/', '\\']) => (path, Some(columns)),
        _ => (text, None),
    };
    let mut columns = columns.into_iter().flat_map(|columns| columns.split(',')).map(|name| name.trim().to_owned());
    let (n, k) = (columns.next(), columns.next());
    if columns.next().is_some() || [&n, &k].into_iter().flatten().any(String::is_empty) {
        return Err("a table's columns are given as file.csv:N_COLUMN or file.csv:N_COLUMN,K_COLUMN".to_owned());
    }
    Ok(Index::Table { path: PathBuf::from(path), n, k })
}

fn complex(text: &str) -> Option<(f64, f64)> {
    if let Ok(n) = text.parse::<f64>() {
        return Some((n, 0.0));
    }
    match *terms(text.strip_suffix(['i', 'j'])?).as_slice() {
        [(sign_n, n), (sign_k, k)] => Some((sign_n * n.parse::<f64>().ok()?, sign_k * k.parse::<f64>().ok()?)),
        _ => None,
    }
}

/// `fit` or a number of at least 0.
pub(crate) fn weight(text: &str) -> Result<Weight, String> {
    if text == "fit" {
        return Ok(Weight::Fitted);
    }
    not_negative(text).map(Weight::Fixed).map_err(|problem| format!("{problem}; `fit` or a number of at least 0"))
}

/// `peak`, `printed` or a reference width in nm.
pub(crate) fn lamella_unit(text: &str) -> Result<LamellaUnit, String> {
    match text {
        "peak" => Ok(LamellaUnit::Peak),
        "printed" => Ok(LamellaUnit::Printed { ridges: 1.0 }),
        width => positive(width)
            .map(|width| LamellaUnit::Reference { width })
            .map_err(|problem| format!("{problem}; `peak`, `printed` or a width in nm")),
    }
}

/// The name nearest to what was typed, if it is near enough to be meant.
pub(crate) fn nearest<'a>(typed: &str, names: &[&'a str]) -> Option<&'a str> {
    let bare = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let typed = bare(typed);
    let best = names.iter().map(|name| (edits(&typed, &bare(name)), *name)).min_by_key(|(edits, _)| *edits)?;
    (best.0 <= 1 + best.1.len() / 4).then_some(best.1)
}

/// Levenshtein's distance.
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, left) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, right) in to.iter().enumerate() {
            let changed = diagonal + usize::from(left != *right);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linked(text: &str) -> (Parameter, Parameter, f64, f64) {
        match link(text).unwrap() {
            Given { parameter, role: Role::Linked { other, factor, constant } } => (parameter, other, factor, constant),
            other => unreachable!("{other:?} is no link"),
        }
    }

    #[test]
    fn a_link_is_read_in_any_order() {
        let (air, cuticle) = (Parameter::DAir, Parameter::DCuticle);
        assert_eq!(linked("d_cuticle=235-d_air"), (cuticle, air, -1.0, 235.0));
        assert_eq!(linked("d_cuticle = 0.5*d_air + 10"), (cuticle, air, 0.5, 10.0));
        assert_eq!(linked("d_cuticle=-d_air*2+1e+2"), (cuticle, air, -2.0, 100.0));
        for wrong in ["d_cuticle=5", "d_cuticle=d_air+delta", "d_cuticle=", "d_cuticle=2*3", "d_cuticle=1+", "d_air"] {
            assert!(link(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_link_between_units_is_in_the_users_units() {
        let (_, _, factor, constant) = linked("delta=10*phi_alpha+2");
        assert!((factor - 10.0_f64.to_radians()).abs() < 1e-15 && (constant - 2.0_f64.to_radians()).abs() < 1e-15);
    }

    #[test]
    fn an_index_is_a_number_a_formula_or_a_file() {
        let known = |n, k| Ok(Index::Known(Material::Constant { n, k }));
        assert_eq!(index("1.56"), known(1.56, 0.0));
        assert_eq!(index("1.56+0.06i"), known(1.56, 0.06));
        assert_eq!(index("1.5+6e-2i"), known(1.5, 0.06));
        assert_eq!(index("cauchy:1.517,8800"), Ok(Index::Known(Material::Cauchy { a: 1.517, b: 8800.0 })));
        let table = |path: &str, n: Option<&str>, k: Option<&str>| {
            Ok(Index::Table { path: path.into(), n: n.map(str::to_owned), k: k.map(str::to_owned) })
        };
        assert_eq!(index("glass.csv"), table("glass.csv", None, None));
        assert_eq!(index("nk.csv:n_film,k_film"), table("nk.csv", Some("n_film"), Some("k_film")));
        assert_eq!(index(r"C:\nk.csv"), table(r"C:\nk.csv", None, None));
        for wrong in ["", "-1", "1.5-0.1i", "cauchy:1.5", "nan", "a.csv:n,k,j", "a.csv:"] {
            assert!(index(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_slip_in_a_name_is_recognised() {
        assert!(parameter("d_ari").unwrap_err().contains("did you mean `d_air`?"));
        assert!(parameter("phi-alpha").unwrap_err().contains("did you mean `phi_alpha`?"));
        assert!(!parameter("colour").unwrap_err().contains("did you mean"));
        assert_eq!(parameter("a"), Ok(Parameter::LamellaWidth));
    }
}
