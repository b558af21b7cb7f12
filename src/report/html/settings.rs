//! The choices of a fit in the user's units, and exactly as `fit.json` has them.

use super::markup::{escape, facts};
use crate::inversion::{FitSettings, Parameter, Role};
use crate::optics::Material;
use serde::Serialize;

/// Decimals that a change of units and back leaves right.
const DECIMALS: f64 = 1e9;

/// The table, and below it all of them as JSON.
pub(super) fn settings(settings: &FitSettings) -> String {
    let mut rows: Vec<(&str, String)> = Parameter::ALL.iter().map(|one| (one.name(), role(*one, settings))).collect();
    let FitSettings { model, parts, stack, nuisances, loss, search, derivative, averages, level, required, .. } =
        settings;
    rows.extend([
        ("model", word(model)),
        ("parts", word(parts)),
        ("ambient", medium(&stack.ambient)),
        ("cuticle", medium(&stack.cuticle)),
        ("gap", medium(&stack.gap)),
        ("base", medium(&stack.base)),
        ("layers", stack.layers.to_string()),
        ("scale", word(&nuisances.scale)),
        ("weight of the lamellae", word(&nuisances.weight)),
        ("background", word(&nuisances.background)),
        ("loss", word(loss)),
        ("search", word(search)),
        ("derivative", word(derivative)),
        ("fits as well within", format!("delta chi² {level}")),
        ("seed", settings.seed.to_string()),
    ]);
    if let Some(filling) = stack.filling {
        rows.push(("filling of the layers", filling.to_string()));
    }
    if !averages.is_none() {
        rows.push(("averages", averages.to_string()));
    }
    if !required.is_empty() {
        let names: Vec<&str> = required.iter().map(|parameter| parameter.name()).collect();
        rows.push(("required", names.join(", ")));
    }
    let all = serde_json::to_string_pretty(settings).unwrap_or_else(|error| error.to_string());
    let summary = "<summary>All of them as in fit.json, in nm and rad</summary>";
    format!("{}<details>{summary}\n<pre>{}</pre></details>\n", facts("Settings", &rows), escape(&all))
}

fn role(parameter: Parameter, settings: &FitSettings) -> String {
    let (index, unit) = (parameter.index(), parameter.unit());
    let outside = |inside: f64| rounded(parameter.outside(inside));
    match settings.roles[index] {
        Role::Free { lower, upper } => {
            let start = settings.start[index].map(|start| format!(", from {}", outside(start))).unwrap_or_default();
            format!("free, {} to {} {unit}{start}", outside(lower), outside(upper))
        }
        Role::Fixed { value } => format!("fixed at {} {unit}", outside(value)),
        Role::Linked { other, factor, constant } => {
            let factor = rounded(parameter.outside(factor) / other.outside(1.0));
            format!("linked: {} {unit} + {factor} · {other}", outside(constant))
        }
    }
}

/// A choice as the word it has in `fit.json`.
fn word(choice: &impl Serialize) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(word)) => word.replace(['_', '-'], " "),
        Ok(serde_json::Value::Object(fields)) => {
            let text = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let field = |(name, value): (&String, &serde_json::Value)| match name.as_str() {
                "name" => text(value),
                name => format!("{} {}", name.replace('_', " "), text(value)),
            };
            let mut fields: Vec<_> = fields.iter().collect();
            fields.sort_by_key(|(name, _)| *name != "name");
            fields.into_iter().map(field).collect::<Vec<String>>().join(", ")
        }
        Ok(other) => other.to_string(),
        Err(error) => error.to_string(),
    }
}

fn medium(material: &Material) -> String {
    match material {
        Material::Constant { n, k } if *k > 0.0 => format!("{n} + {k} i"),
        Material::Constant { n, .. } => n.to_string(),
        Material::Cauchy { a, b } => format!("{a} + {b} nm² / wavelength²"),
        Material::Table(_) => "a table of wavelength, n and k, below".to_owned(),
    }
}

fn rounded(value: f64) -> f64 {
    (value * DECIMALS).round() / DECIMALS + 0.0
}
