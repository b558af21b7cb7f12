//! The variants of one or more models that a data set can tell apart.

use crate::dataset::Dataset;
use crate::inversion::nuisance::{Extent, Weight};
use crate::inversion::parameter::{Parameter, Role};
use crate::inversion::settings::{FitSettings, ModelChoice, Parts};
use crate::optics::Averages;

/// One variant of what the user asked for.
#[derive(Debug, Clone)]
pub(crate) struct Variant {
    /// `lamella`, `multilayer`, `blend` or `hybrid`, with `+ tilt`, `+ background` and `+ averages` where there are any.
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
        let averages = !settings.averages.is_none();
        let name = [(true, parts), (tilt, "tilt"), (background, "background"), (averages, "averages")];
        let name: Vec<&str> = name.into_iter().filter(|(there, _)| *there).map(|(_, word)| word).collect();
        Self { name: name.join(" + "), settings }
    }

    /// Whether every value of this variant is one of `larger` too: never of another model or under other averages.
    pub(crate) fn is_within(&self, larger: &Self) -> bool {
        let (own, other) = (&self.settings, &larger.settings);
        let free = |settings: &FitSettings| matches!(settings.roles[Parameter::Delta.index()], Role::Free { .. });
        own.model == other.model
            && own.averages == other.averages
            && (own.parts == other.parts || other.parts == Parts::Both)
            && (!free(own) || free(other))
            && (own.nuisances.background == Extent::None || other.nuisances.background != Extent::None)
    }
}

/// The variants that `data` can tell apart; what the user chose himself stays in all but the averages. A variant stands
/// behind those within it and, of different kinds, behind the simpler: plane waves before averages, the model of `settings`
/// before those of `beside` in their order.
///
/// - Averages: none and those of the settings, where these have any. The lamellae alone are not averaged.
/// - Models: that of the settings, and each of `beside` that can hold what the settings ask for; none of these under an
///   aperture.
/// - Parts, tilt, background: see [`of_model`].
pub(crate) fn variants(data: &Dataset, settings: &FitSettings, beside: &[ModelChoice]) -> Vec<Variant> {
    let mut models = vec![settings.clone()];
    for &model in beside {
        if models.iter().all(|known| known.model != model) {
            models.extend(settings.for_model(model));
        }
    }
    let mut averages = vec![Averages::default()];
    averages.extend((!settings.averages.is_none()).then_some(settings.averages));
    let mut variants = Vec::new();
    for averages in averages {
        for (place, model) in models.iter().enumerate() {
            // A product over a cone of directions takes minutes a fit: only who asks for it waits for it.
            if place > 0 && averages.numerical_aperture > 0.0 {
                continue;
            }
            let settings = FitSettings { averages, ..model.clone() };
            // Not every model can be averaged over everything.
            if settings.forward().is_ok() {
                variants.extend(of_model(data, &settings));
            }
        }
    }
    variants
}

/// The nested variants of one model, smaller before larger.
///
/// - Parts: A alone, B alone and both, if the data see both planes, the settings leave out none, and the weight of A is
///   not given; not of a model that is one product.
/// - `delta`: held at 0 and free, if it is free, may be 0, is not required, and the variant has a multilayer.
/// - Background: none and shared, if the settings have none.
fn of_model(data: &Dataset, settings: &FitSettings) -> Vec<Variant> {
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
        if !planes.1 && !settings.averages.is_none() {
            continue; // Averages are of the multilayer.
        }
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
            variants(&data, &settings, &[]).into_iter().map(|variant| variant.name).collect::<Vec<_>>()
        };
        let hybrid = ModelChoice::Hybrid { ridge_spacing: HybridModel::RIDGE_SPACING };
        assert_eq!(names(hybrid), ["hybrid", "hybrid + background", "hybrid + tilt", "hybrid + tilt + background"]);
        assert_eq!(names(ModelChoice::Blend).len(), 10);
    }

    #[test]
    fn models_and_averages_stand_beside_each_other_and_within_none() {
        let (model, blue) = (HybridModel::default(), Structure::blue());
        let scans = Scan::full_design(&model, &blue).unwrap();
        let data = simulate(&model, &blue, &scans, 1.0, 0.01, 1).unwrap();
        let hybrid = |ridge_spacing| [ModelChoice::Blend, ModelChoice::Hybrid { ridge_spacing }];
        let averages = Averages { bandwidth: 20.0, ..Averages::default() };
        let all = variants(&data, &FitSettings { averages, ..FitSettings::default() }, &hybrid(500.0));
        // The lamellae alone have no averages.
        assert_eq!(all.len(), 10 + 4 + 8 + 4);
        let place = |name: &str| all.iter().position(|variant| variant.name == name).unwrap();
        assert!(place("blend") < place("hybrid") && place("hybrid") < place("blend + averages"));
        for (i, one) in all.iter().enumerate() {
            for (j, other) in all.iter().enumerate().filter(|(j, _)| *j != i) {
                let kind = |variant: &Variant| (variant.settings.model, variant.settings.averages);
                if one.is_within(other) {
                    assert!(i < j && kind(one) == kind(other), "{} in {}", one.name, other.name);
                }
            }
        }
        assert!(all[place("multilayer + averages")].is_within(&all[place("blend + tilt + averages")]));
        let width = |name| all[place(name)].settings.roles[Parameter::LamellaWidth.index()];
        assert_eq!([width("blend"), width("hybrid")], [600.0, 500.0].map(|upper| Role::Free { lower: 100.0, upper }));

        // What a product cannot hold leaves it out, and the averages that it cannot take leave out these.
        let count = |settings: FitSettings| variants(&data, &settings, &hybrid(500.0)).len();
        let wide = FitSettings::default().with_role(Parameter::LamellaWidth, Role::Fixed { value: 501.0 });
        assert_eq!(count(wide), 10);
        let mut weighted = FitSettings::default();
        weighted.nuisances.weight = Weight::Fixed(1.0);
        assert_eq!(count(weighted), 4);
        let cone = Averages { numerical_aperture: 0.4, ..Averages::default() };
        assert_eq!(count(FitSettings { averages: cone, ..FitSettings::default() }), 10 + 4 + 8);
        let tilts = Averages { tilt_spread: 0.05, ..Averages::default() };
        assert_eq!(count(FitSettings { averages: tilts, ..FitSettings::default() }), 10 + 4 + 8);
    }
}
