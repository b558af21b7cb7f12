//! The stability map: what each form makes of hard input, in a word.

mod diffraction;
mod fits;
mod layers;

use crate::optics::OpticsError;
use crate::tradeoff::{Settings, TradeoffError};

/// How far a form in double precision may be from the known value.
const DOUBLE: f64 = 1e-9;
/// The same in single precision, which has seven digits.
const SINGLE: f64 = 1e-4;

/// What a form made of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The known value, or the error that the input deserves.
    Right,
    /// A number that is not the known value, or any number where the input has none.
    Wrong,
    /// No number.
    NotANumber,
    /// An error where there is a value: safe, but no answer.
    Refused,
    /// Not done when its limit was spent.
    Endless,
    /// The form has no such input.
    Absent,
}

impl Verdict {
    /// The word in the map.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Wrong => "wrong",
            Self::NotANumber => "NaN",
            Self::Refused => "refused",
            Self::Endless => "time limit",
            Self::Absent => "–",
        }
    }

    /// Whether nobody is misled: the answer is right, or there is none and it is said.
    #[must_use]
    pub fn is_safe(self) -> bool {
        matches!(self, Self::Right | Self::Refused | Self::Absent)
    }
}

/// One column of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// What it is.
    pub name: String,
    /// Whether it is the library's, and so must be safe.
    pub guarded: bool,
}

/// One hard input.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What is hard about it.
    pub input: String,
    /// What is right, in words.
    pub expected: String,
    /// One for each form.
    pub cells: Vec<Verdict>,
}

/// One table of the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// What is mapped.
    pub title: String,
    /// The columns.
    pub forms: Vec<Form>,
    /// The rows.
    pub rows: Vec<Row>,
}

/// All tables.
pub(super) fn maps(settings: &Settings) -> Result<Vec<Map>, TradeoffError> {
    Ok(vec![diffraction::map(), layers::map(), layers::slopes(), fits::map(settings)?])
}

/// What is right.
#[derive(Debug, Clone, Copy)]
enum Expected {
    /// This value.
    Value(f64),
    /// An error.
    Refusal,
    /// This value as a limit, or an error.
    ValueOrRefusal(f64),
}

impl Expected {
    fn words(self) -> String {
        match self {
            Self::Value(value) => format!("{value}"),
            Self::Refusal => "an error".to_owned(),
            Self::ValueOrRefusal(value) => format!("{value} or an error"),
        }
    }

    fn judge(self, found: Result<f64, OpticsError>, tolerance: f64) -> Verdict {
        match (self, found) {
            (Self::Value(_), Err(_)) => Verdict::Refused,
            (Self::Refusal | Self::ValueOrRefusal(_), Err(_)) => Verdict::Right,
            (_, Ok(found)) if !found.is_finite() => Verdict::NotANumber,
            (Self::Value(value) | Self::ValueOrRefusal(value), Ok(found)) if (found - value).abs() <= tolerance => {
                Verdict::Right
            }
            (_, Ok(_)) => Verdict::Wrong,
        }
    }
}

fn forms(names: &[(&str, bool)]) -> Vec<Form> {
    names.iter().map(|&(name, guarded)| Form { name: name.to_owned(), guarded }).collect()
}
