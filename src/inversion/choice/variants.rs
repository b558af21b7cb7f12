//! The nested variants of a model that a data set can tell apart.

use crate::dataset::Dataset;
use crate::inversion::nuisance::{Extent, Weight};
use crate::inversion::parameter::{Parameter, Role};
use crate::inversion::settings::{FitSettings, ModelChoice, Parts};

/// One variant of what the user asked for.
#[derive(Debug, Clone)]
pub(crate) struct Variant {
    /// `lamella`, `multilayer`, `blend` or `hybrid`, with `+ tilt` and `+ background` where these are fitted.
    pub(crate) name: String,
    /// The user's settings with the variant's choices.
    pub(crate) settings: FitSettings,
}

impl Variant {
    fn new(settings: FitSettings, (lamella, multilayer): (bool, bool)) -> Self {
        let parts = match (lamella, multilayer) {
            _ if matches!(settings.model, ModelChoice::Hybrid { .. }) => "hybrid",
            (true, false) => "lamella",
            (false, true) => "multilayer",
            _ => "blend",
        };
        let tilt = multilayer && matches!(settings.roles[Parameter::Delta.index()], Role::Free { .. });
        let background = settings.nuisances.background != Extent::None;
        let name = [(true, parts), (tilt, "tilt"), (background, "background")];
        let name: Vec<&str> = name.into_iter().filter(|(there, _)| *there).map(|(_, word)| word).collect();
        Self { name: name.join(" + "), settings }
    }

    /// Whether every value of this variant is one of `larger` too.
    pub(crate) fn is_within(&self, larger: &Self) -> bool {
        let (own, other) = (&self.settings, &larger.settings);
        let free = |settings: &FitSettings| matches!(settings.roles[Parameter::Delta.index()], Role::Free { .. });
        (own.parts == other.parts || other.parts == Parts::Both)
            && (!free(own) || free(other))
            && (own.nuisances.background == Extent::None || other.nuisances.background != Extent::None)
    }
}

/// The variants that `data` can tell apart, smaller before larger; what the user chose himself stays in all.
///
/// - Parts: A alone, B alone and both, if the data see both planes, the settings leave out none, and the weight of A is
///   not given; not of a model that is one product.
/// - `delta`: held at 0 and free, if it is free, may be 0, is not required, and the variant has a multilayer.
/// - Background: none and shared, if the settings have none.
pub(crate) fn variants(data: &Dataset, settings: &FitSettings) -> Vec<Variant> {
    let product = matches!(settings.model, ModelChoice::Hybrid { .. });
    let seen = |parts: Parts| {
        if product {
            return (false, true);
        }
        let shares = data.readings().iter().map(|reading| parts.shares(reading.geometry.plane_shares()));
        shares.fold((false, false), |seen, (a, b)| (seen.0 || a > 0.0, seen.1 || b > 0.0))
    };
    let several = seen(settings.parts) == (true, true) && settings.nuisances.weight == Weight::Fitted;
    let parts = if several { vec![Parts::Lamella, Parts::Multilayer, Parts::Both] } else { vec![settings.parts] };
    let backgrounds = match settings.nuisances.background {
        Extent::None => vec![Extent::None, Extent::Shared],
        given => vec![given],
    };
    let mut variants = Vec::new();
    for parts in parts {
        let planes = seen(parts);
        let roles = match settings.roles[Parameter::Delta.index()] {
            free @ Role::Free { lower, upper } if planes.1 && (lower..=upper).contains(&0.0) => {
                let required = settings.required.contains(&Parameter::Delta);
                if required { vec![free] } else { vec![Role::Fixed { value: 0.0 }, free] }
            }
            given => vec![given],
        };
        for role in roles {
            for &background in &backgrounds {
                let mut settings = FitSettings { parts, ..settings.clone() }.with_role(Parameter::Delta, role);
                settings.nuisances.background = background;
                variants.push(Variant::new(settings, planes));
            }
        }
    }
    variants
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{HybridModel, Structure};
    use crate::synthetic::{Scan, simulate};

    #[test]
    fn a_product_has_no_variants_of_a_part_alone() {
        let (model, blue) = (HybridModel::default(), Structure::blue());
        let scans = Scan::full_design(&model, &blue).unwrap();
        let data = simulate(&model, &blue, &scans, 1.0, 0.01, 1).unwrap();
        let names = |model| {
            let settings = FitSettings { model, ..FitSettings::default() };
            variants(&data, &settings).into_iter().map(|variant| variant.name).collect::<Vec<_>>()
        };
        let hybrid = ModelChoice::Hybrid { ridge_spacing: HybridModel::RIDGE_SPACING };
        assert_eq!(names(hybrid), ["hybrid", "hybrid + background", "hybrid + tilt", "hybrid + tilt + background"]);
        assert_eq!(names(ModelChoice::Blend).len(), 10);
    }
}
