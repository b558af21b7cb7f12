//! The table of a model choice.

use super::digits::plain;
use super::rows::NONE;
use super::table::Align;
use super::wording::list;
use crate::inversion::{ChoiceFound, Criterion, Standing, VariantFound};

/// Decimals of what is compared.
const DECIMALS: usize = 1;

/// The headings of [`rows`].
pub(super) const COLUMNS: [(&str, Align); 7] = [
    ("variant", Align::Left),
    ("unknowns", Align::Right),
    ("chi²", Align::Right),
    ("AICc", Align::Right),
    ("BIC", Align::Right),
    ("held-out", Align::Right),
    ("", Align::Left),
];

/// A row for each variant: what is compared stands as its distance from the lowest of those with a minimum.
pub(super) fn rows(found: &ChoiceFound) -> Vec<[String; 7]> {
    let least = |of: &dyn Fn(&VariantFound) -> Option<f64>| {
        let compared = found.variants.iter().filter(|row| !row.behind_in.contains(&Criterion::Convergence));
        compared.filter_map(of).fold(f64::INFINITY, f64::min)
    };
    let (aicc, bic) = (least(&|row| row.aicc), least(&|row| Some(row.bic)));
    let behind = |value: Option<f64>| value.map_or_else(|| NONE.to_owned(), |value| format!("{value:+.DECIMALS$}"));
    let row = |row: &VariantFound| {
        let held_out = row
            .held_out_behind
            .zip(row.held_out_error)
            .map_or_else(|| NONE.to_owned(), |(behind, error)| format!("{behind:+.DECIMALS$} ± {error:.DECIMALS$}"));
        [
            row.name.clone(),
            row.unknowns.to_string(),
            plain(row.chi2),
            behind(row.aicc.map(|own| own - aicc)),
            behind(Some(row.bic - bic)),
            held_out,
            standing(row),
        ]
    };
    found.variants.iter().map(row).collect()
}

/// How a variant came out, in words.
fn standing(row: &VariantFound) -> String {
    let word = |by: &Criterion| match by {
        Criterion::Convergence => "no minimum",
        Criterion::Aicc => "AICc",
        Criterion::Bic => "BIC",
        Criterion::HeldOut => "held-out",
    };
    let by: Vec<&str> = row.behind_in.iter().map(word).collect();
    match (row.standing, by.as_slice()) {
        (Standing::Kept, _) => "kept".to_owned(),
        (Standing::NotNeeded, _) => "not needed".to_owned(),
        (Standing::Lost, by) => format!("loses: {}", list(by)),
    }
}
