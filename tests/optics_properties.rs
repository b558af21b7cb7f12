//! What holds for every stack and every reading, tried on random ones with fixed seeds.

mod support;

use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, Shares, reflect_transmit};
use morpho_fit::optics::multilayer::{self, Period};
use morpho_fit::optics::{
    Admittance, BlendModel, LamellaUnit, Material, PaperModel, ReflectivityModel, Snell, Stack, Structure,
};
use morpho_fit::units::radians;
use nalgebra::Complex;
use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_assert, prop_oneof, proptest};
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};
use support::stacks::{BOTH, real};

/// Absolute, in R and T: rounding of the stacks below, which have 60 layers at most.
const ROUNDING: f64 = 1e-12;

/// The same cases in every run; a failure prints its case, so that no file of them is kept.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_260_103),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn lossless_layer() -> impl Strategy<Value = Layer> {
    (1.0..2.6_f64, 0.0..400.0_f64).prop_map(|(n, thickness)| Layer { index: real(n), thickness })
}

/// Transparent, absorbing and metallic layers.
fn any_layer() -> impl Strategy<Value = Layer> {
    let index = prop_oneof![
        (1.0..2.6_f64).prop_map(real),
        (1.0..2.6_f64, 0.0..0.5_f64).prop_map(|(n, k)| Complex::new(n, k)),
        (0.05..2.0_f64, 1.0..6.0_f64).prop_map(|(n, k)| Complex::new(n, k)),
    ];
    (index, 0.0..400.0_f64).prop_map(|(index, thickness)| Layer { index, thickness })
}

/// What surrounds the layers, and the light.
#[derive(Debug, Clone, Copy)]
struct Light {
    ambient: f64,
    base: f64,
    wavelength: f64,
    angle: f64,
    component: Component,
}

fn light() -> impl Strategy<Value = Light> {
    (1.0..2.5_f64, 1.0..4.0_f64, 300.0..1000.0_f64, radians(-89.0)..radians(89.0), select(&BOTH[..]))
        .prop_map(|(ambient, base, wavelength, angle, component)| Light { ambient, base, wavelength, angle, component })
}

impl Light {
    fn through(&self, layers: &[Layer]) -> Shares {
        let Self { ambient, base, wavelength, angle, component } = *self;
        reflect_transmit(ambient, layers, real(base), wavelength, angle, component).expect("valid")
    }

    /// The same rays the other way; none if there is no ray in the base.
    fn reversed(&self) -> Option<Self> {
        let sine = self.ambient * self.angle.sin() / self.base;
        // Close to grazing in the base the angle itself loses digits.
        (sine.abs() < 0.999).then(|| Self { ambient: self.base, base: self.ambient, angle: sine.asin(), ..*self })
    }
}

fn same(a: Shares, b: Shares) -> bool {
    (a.reflectivity - b.reflectivity).abs() < ROUNDING && (a.transmittance - b.transmittance).abs() < ROUNDING
}

proptest! {
    #![proptest_config(config(5_000))]

    #[test]
    fn a_lossless_stack_reflects_what_it_does_not_transmit(layers in vec(lossless_layer(), 0..40), light in light()) {
        let Shares { reflectivity, transmittance } = light.through(&layers);
        prop_assert!((0.0..=1.0 + ROUNDING).contains(&reflectivity), "R = {reflectivity}");
        prop_assert!((-ROUNDING..=1.0 + ROUNDING).contains(&transmittance), "T = {transmittance}");
        prop_assert!((reflectivity + transmittance - 1.0).abs() < ROUNDING, "{reflectivity} + {transmittance}");
    }

    #[test]
    fn an_absorbing_stack_keeps_a_part_of_the_light(
        layers in vec(any_layer(), 0..40), light in light(), k in 0.0..5.0_f64,
    ) {
        let Light { ambient, base, wavelength, angle, component } = light;
        let base = Complex::new(base, k);
        let Shares { reflectivity, transmittance } =
            reflect_transmit(ambient, &layers, base, wavelength, angle, component).expect("valid");
        prop_assert!((0.0..=1.0 + ROUNDING).contains(&reflectivity), "R = {reflectivity}");
        prop_assert!((0.0..=1.0 + ROUNDING).contains(&transmittance), "T = {transmittance}");
        prop_assert!(reflectivity + transmittance <= 1.0 + ROUNDING, "{reflectivity} + {transmittance}");
    }

    #[test]
    fn a_reversed_stack_transmits_the_same_also_where_it_absorbs(
        mut layers in vec(any_layer(), 0..40), light in light(),
    ) {
        if let Some(back) = light.reversed() {
            let forth = light.through(&layers);
            layers.reverse();
            let found = back.through(&layers).transmittance;
            prop_assert!((found - forth.transmittance).abs() < ROUNDING, "{found} and {}", forth.transmittance);
        }
    }

    #[test]
    fn a_lossless_stack_reversed_reflects_the_same(mut layers in vec(lossless_layer(), 0..40), light in light()) {
        if let Some(back) = light.reversed() {
            let forth = light.through(&layers);
            layers.reverse();
            prop_assert!(same(back.through(&layers), forth));
        }
    }

    #[test]
    fn an_interface_without_contrast_changes_nothing(
        mut layers in vec(any_layer(), 1..40), light in light(), at in any::<Index>(), share in 0.0..=1.0_f64,
    ) {
        let whole = light.through(&layers);
        let at = at.index(layers.len());
        let thickness = layers[at].thickness;
        layers.insert(at, Layer { thickness: share * thickness, ..layers[at] });
        layers[at + 1].thickness = thickness - share * thickness;
        prop_assert!(same(light.through(&layers), whole));
    }

    #[test]
    fn a_layer_of_the_outer_media_changes_nothing(
        layers in vec(any_layer(), 0..20), light in light(), d in 0.0..400.0_f64,
    ) {
        let bare = light.through(&layers);
        let mut clad = layers.clone();
        clad.insert(0, Layer { index: real(light.ambient), thickness: d });
        prop_assert!(same(light.through(&clad), bare));
        let mut backed = layers;
        backed.push(Layer { index: real(light.base), thickness: d });
        prop_assert!(same(light.through(&backed), bare));
    }

    #[test]
    fn a_layer_without_thickness_changes_nothing(
        mut layers in vec(any_layer(), 0..40), light in light(), at in any::<Index>(), extra in any_layer(),
    ) {
        let before = light.through(&layers);
        layers.insert(at.index(layers.len() + 1), Layer { thickness: 0.0, ..extra });
        prop_assert!(same(light.through(&layers), before));
    }

    #[test]
    fn light_from_the_other_side_of_the_normal_sees_the_same_stack(
        layers in vec(any_layer(), 0..40), light in light(),
    ) {
        let other_side = Light { angle: -light.angle, ..light };
        prop_assert!(same(other_side.through(&layers), light.through(&layers)));
    }

    #[test]
    fn at_normal_incidence_the_polarizations_are_one(layers in vec(any_layer(), 0..40), light in light()) {
        let of = |component| Light { angle: 0.0, component, ..light }.through(&layers);
        prop_assert!(same(of(Component::S), of(Component::P)));
    }

    #[test]
    fn only_the_ratio_of_lengths_matters(
        layers in vec(any_layer(), 0..40), light in light(), scale in 0.01..100.0_f64,
    ) {
        let scaled: Vec<_> =
            layers.iter().map(|layer| Layer { thickness: scale * layer.thickness, ..*layer }).collect();
        let larger = Light { wavelength: scale * light.wavelength, ..light };
        prop_assert!(same(larger.through(&scaled), light.through(&layers)));
    }
}

/// A periodic stack of any media, its period, and the light.
fn periodic() -> impl Strategy<Value = (Stack, Period, f64, f64)> {
    let medium = |lowest: f64, highest: f64| {
        (lowest..highest, prop_oneof![3 => Just(0.0), 1 => 0.0..0.3_f64]).prop_map(|(n, k)| Material::Constant { n, k })
    };
    let ambient = prop_oneof![Just(1.0), 1.0..2.0_f64].prop_map(Material::constant);
    let stack = (ambient, medium(1.0, 2.5), medium(1.0, 1.5), medium(1.0, 4.0), 1..=30_usize)
        .prop_map(|(ambient, cuticle, gap, base, layers)| Stack { ambient, cuticle, gap, base, layers, filling: None });
    let period = (0.0..400.0_f64, 0.0..400.0_f64).prop_map(|(cuticle, gap)| Period { cuticle, gap });
    (stack, period, 300.0..1000.0_f64, radians(-89.5)..radians(89.5))
}

proptest! {
    #![proptest_config(config(5_000))]

    #[test]
    fn the_periodic_stack_is_its_layers_one_by_one((stack, period, wavelength, angle) in periodic()) {
        let media = stack.media(wavelength).expect("valid");
        let found = multilayer::reflectivity(&media, period, stack.layers, angle).expect("valid");
        let mirrored = multilayer::reflectivity(&media, period, stack.layers, -angle).expect("valid");
        prop_assert!((found.s - mirrored.s).abs() < ROUNDING && (found.p - mirrored.p).abs() < ROUNDING);
        let layers = [
            Layer { index: media.cuticle, thickness: period.cuticle },
            Layer { index: media.gap, thickness: period.gap },
        ]
        .repeat(stack.layers);
        for (component, value) in BOTH.into_iter().zip([found.s, found.p]) {
            let expected = reflect_transmit(media.ambient, &layers, media.base, wavelength, angle, component);
            let expected = expected.expect("valid").reflectivity;
            prop_assert!((0.0..=1.0 + ROUNDING).contains(&value), "R = {value}");
            prop_assert!((value - expected).abs() < ROUNDING, "{component:?}: {value}, {expected} layer by layer");
        }
    }
}

/// Across the ridges at a wavelength, with the two directions to be exchanged; rad.
fn lamella_reading() -> impl Strategy<Value = (Structure, f64, f64, f64)> {
    let widths = (50.0..300.0_f64, 20.0..200.0_f64, 50.0..1000.0_f64);
    let structure = widths.prop_map(|(d_air, d_cuticle, lamella_width)| Structure {
        d_air,
        d_cuticle,
        lamella_width,
        ..Structure::table1()
    });
    (structure, 380.0..780.0_f64, radians(-85.0)..radians(85.0), radians(-85.0)..radians(85.0))
}

fn across(model: &dyn ReflectivityModel, structure: &Structure, wavelength: f64, theta: f64, phi: f64) -> f64 {
    let geometry = Geometry { theta, phi, omega: 0.0 };
    model.reflectivity(structure, &geometry, Polarization::Unpolarized, wavelength).expect("valid")
}

proptest! {
    #![proptest_config(config(5_000))]

    /// The printed `cos²(theta)` is kept, so exchanging lamp and eye changes Model A by exactly this.
    #[test]
    fn exchanging_incidence_and_view_changes_the_lamellae_by_the_squared_ratio_of_the_cosines(
        (structure, wavelength, theta, phi) in lamella_reading(),
    ) {
        let model = BlendModel::default();
        let forth = across(&model, &structure, wavelength, theta, phi) * phi.cos().powi(2);
        let back = across(&model, &structure, wavelength, phi, theta) * theta.cos().powi(2);
        prop_assert!((forth - back).abs() <= ROUNDING, "{forth} and {back}");
    }

    #[test]
    fn the_lamellae_look_the_same_from_both_sides_of_the_normal(
        (structure, wavelength, theta, phi) in lamella_reading(),
    ) {
        let model = BlendModel::default();
        let right = across(&model, &structure, wavelength, theta, phi);
        let left = across(&model, &structure, wavelength, -theta, -phi);
        prop_assert!((right - left).abs() <= ROUNDING, "{right} and {left}");
        prop_assert!((0.0..=1.0 + ROUNDING).contains(&right));
    }

    #[test]
    fn the_lamellae_know_only_the_sum_of_the_thicknesses(
        (structure, wavelength, theta, phi) in lamella_reading(), share in 0.0..=1.0_f64,
    ) {
        let model = BlendModel::default();
        let other = Structure {
            d_air: share * structure.period(),
            d_cuticle: (1.0 - share) * structure.period(),
            ..structure
        };
        let (one, two) =
            (across(&model, &structure, wavelength, theta, phi), across(&model, &other, wavelength, theta, phi));
        prop_assert!((one - two).abs() <= ROUNDING, "{one} and {two}");
    }
}

#[test]
fn exchanging_0_and_60_degrees_changes_the_lamellae_by_a_factor_of_four() {
    let (model, structure) = (BlendModel::default(), Structure::table1());
    let forth = across(&model, &structure, 480.0, 0.0, radians(60.0));
    let back = across(&model, &structure, 480.0, radians(60.0), 0.0);
    assert!((forth / back - 4.0).abs() < ROUNDING, "{forth} and {back}");
}

/// A number of the usual size `usual`, a special one, or one of any size and sign.
fn number(usual: impl Strategy<Value = f64> + 'static, special: &'static [f64]) -> impl Strategy<Value = f64> {
    let anywhere = &[0.0, -0.0, 5e-324, f64::MIN_POSITIVE, 1e-200, 1e-9, 1e9, 1e200, f64::MAX][..];
    let wrong = &[-1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY][..];
    prop_oneof![
        60 => usual,
        15 => select(special),
        2 => select(anywhere),
        1 => select(wrong),
        1 => any::<f64>(),
    ]
}

fn angle() -> impl Strategy<Value = f64> {
    // A conversion from degrees may round to just past 90°.
    const SPECIAL: [f64; 12] = [
        0.0,
        1e-300,
        1e-17,
        1e-9,
        -1e-9,
        FRAC_PI_6,
        FRAC_PI_4,
        -FRAC_PI_4,
        FRAC_PI_2 - 1e-9,
        FRAC_PI_2.next_up(),
        FRAC_PI_2,
        -FRAC_PI_2,
    ];
    number(-FRAC_PI_2..FRAC_PI_2, &SPECIAL)
}

fn length() -> impl Strategy<Value = f64> {
    number(0.0..400.0_f64, &[0.0, 1e-12, 62.0, 100.0, 117.5, 135.0, 141.0, 156.0, 235.0, 470.0, 1e4, 1e6])
}

fn wavelength() -> impl Strategy<Value = f64> {
    number(300.0..1000.0_f64, &[1.0, 235.0, 468.0, 470.0, 480.0, 583.0, 1e4, 1e6])
}

fn material() -> impl Strategy<Value = Material> {
    let n = number(1.0..2.6_f64, &[1.0, 1.0, 1.0, 1.56, 1.5, 2.0, 0.05, 0.5, 4.0]);
    let k = prop_oneof![10 => Just(0.0), 3 => number(0.0..1.0_f64, &[0.0, 1e-300, 1e-9, 0.06, 6.0])];
    prop_oneof![
        8 => (n, k).prop_map(|(n, k)| Material::Constant { n, k }),
        1 => number(0.0..1e4_f64, &[8.80e3]).prop_map(|b| Material::Cauchy { a: 1.517, b }),
    ]
}

fn any_stack() -> impl Strategy<Value = Stack> {
    let layers = prop_oneof![30 => 1..=30_usize, 3 => select(&[0, 1, 16, 17, 1000, 100_001, usize::MAX][..])];
    let ambient = prop_oneof![4 => Just(Material::constant(1.0)), 1 => material()];
    (ambient, material(), material(), material(), layers).prop_map(|(ambient, cuticle, gap, base, layers)| Stack {
        ambient,
        cuticle,
        gap,
        base,
        layers,
        filling: None,
    })
}

fn any_model() -> impl Strategy<Value = (BlendModel, PaperModel)> {
    let snell = select(&[Snell::Right, Snell::Printed][..]);
    let admittance = select(&[Admittance::Mean, Admittance::PerPolarization][..]);
    (any_stack(), snell, admittance).prop_map(|(stack, snell, admittance)| {
        let paper = PaperModel { stack: stack.clone(), snell, admittance, lamella_unit: LamellaUnit::Peak };
        (BlendModel { stack }, paper)
    })
}

fn any_structure() -> impl Strategy<Value = Structure> {
    let phi_alpha = number(0.0..1.5_f64, &[0.5, 1e-9, 5e-324, PI]);
    (length(), length(), angle(), phi_alpha, length()).prop_map(
        |(d_air, d_cuticle, delta, phi_alpha, lamella_width)| Structure {
            d_air,
            d_cuticle,
            delta,
            phi_alpha,
            lamella_width,
        },
    )
}

proptest! {
    #![proptest_config(config(100_000))]

    #[test]
    fn every_question_is_answered_by_a_share_of_the_light_or_by_an_error(
        (blend, paper) in any_model(),
        structure in any_structure(),
        (theta, phi, omega) in (angle(), angle(), angle()),
        mirror in any::<bool>(),
        wavelength in wavelength(),
        polarization in select(&[Polarization::Unpolarized, Polarization::S, Polarization::P][..]),
    ) {
        let phi = if mirror { 2.0 * structure.delta - theta } else { phi };
        let geometry = Geometry { theta, phi, omega };
        let models: [&dyn ReflectivityModel; 2] = [&blend, &paper];
        for model in models {
            let found = model.reflectivity(&structure, &geometry, polarization, wavelength);
            if let Ok(value) = found {
                prop_assert!((0.0..=1.0 + ROUNDING).contains(&value), "{}: {value}", model.name());
            }
        }
    }

    #[test]
    fn every_list_of_layers_is_answered_by_shares_or_by_an_error(
        layers in vec(((number(1.0..2.6_f64, &[1.56]), number(0.0..1.0_f64, &[0.0])), length()), 0..4),
        (n_ambient, n_base, k_base) in (number(1.0..2.6_f64, &[1.0]), number(1.0..2.6_f64, &[1.0]), length()),
        (wavelength, angle) in (wavelength(), angle()),
        component in select(&BOTH[..]),
    ) {
        let layers: Vec<_> = layers
            .into_iter()
            .map(|((n, k), thickness)| Layer { index: Complex::new(n, k), thickness })
            .collect();
        let base = Complex::new(n_base, k_base);
        if let Ok(found) = reflect_transmit(n_ambient, &layers, base, wavelength, angle, component) {
            let Shares { reflectivity, transmittance } = found;
            prop_assert!((0.0..=1.0 + ROUNDING).contains(&reflectivity), "R = {reflectivity}");
            prop_assert!((0.0..=1.0 + ROUNDING).contains(&transmittance), "T = {transmittance}");
        }
    }
}
