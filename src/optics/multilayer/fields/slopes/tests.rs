//! Derivatives in lanes against differences of the values.

use crate::optics::multilayer::{CUTICLE, GAP, Order, SAndP, StackSlopes, ordered_slopes_unchecked, ordered_unchecked};
use crate::optics::{Material, Media, Stack};
use approx::assert_abs_diff_eq;
use std::f64::consts::TAU;

/// Wavelengths, more than a block of them.
const COUNT: usize = 21;
/// Deviations of two kinds of gap and two of cuticle, nm.
const DEVIATIONS: [f64; 4] = [-4.0, 3.0, 5.0, -2.0];

/// Two stacks of ten layers, by the thickness of gap and cuticle.
fn order(kinds: &[(usize, f64)]) -> Order<'_> {
    const LAYERS: [usize; 20] = [0, 2, 1, 3, 0, 3, 0, 2, 1, 2, 1, 2, 1, 3, 1, 3, 0, 2, 1, 3];
    Order { kinds, order: &LAYERS, repeats: 1, stacks: 2 }
}

fn kinds(gap: f64, cuticle: f64) -> [(usize, f64); 4] {
    let [a, b, c, d] = DEVIATIONS;
    [(GAP, gap + a), (GAP, gap + b), (CUTICLE, cuticle + c), (CUTICLE, cuticle + d)]
}

fn wavenumbers() -> Vec<f64> {
    (0..COUNT).map(|step| TAU / (400.0 + 15.0 * step as f64)).collect()
}

fn values(media: &[Media], gap: f64, cuticle: f64, angle: f64) -> Vec<SAndP> {
    let mut out = vec![SAndP::default(); COUNT];
    ordered_unchecked(media, &wavenumbers(), order(&kinds(gap, cuticle)), angle, &mut out);
    out
}

/// With a base of glass and dispersion, so that each of the terms has its part; central differences of the values are right to
/// 1e-8 here.
#[test]
fn slopes_are_differences_of_the_values() {
    let cuticle = Material::Cauchy { a: 1.517, b: 8800.0 };
    let stack = Stack { cuticle, base: Material::constant(1.5), ambient: Material::constant(1.2), ..Stack::default() };
    let stack = Stack { gap: Material::constant(1.1), ..stack };
    let media: Vec<Media> = wavenumbers().iter().map(|k| stack.media(TAU / k).unwrap()).collect();
    for angle in [0.0, 0.4, -0.7, 1.1] {
        let mut found = vec![StackSlopes::default(); COUNT];
        let kinds = kinds(90.0, 70.0);
        let layers = (order(&kinds), [1.0; 4].as_slice());
        assert!(ordered_slopes_unchecked(&media, &wavenumbers(), layers, angle, &mut found));
        let step = 1e-3;
        let turn = 1e-5;
        let by = [
            (values(&media, 90.0 + step, 70.0, angle), values(&media, 90.0 - step, 70.0, angle), step),
            (values(&media, 90.0, 70.0 + step, angle), values(&media, 90.0, 70.0 - step, angle), step),
            (values(&media, 90.0, 70.0, angle + turn), values(&media, 90.0, 70.0, angle - turn), turn),
        ];
        for (place, found) in found.iter().enumerate() {
            for (found, (above, below, step)) in [found.gap, found.cuticle, found.angle].into_iter().zip(&by) {
                let slope = |of: fn(&SAndP) -> f64| (of(&above[place]) - of(&below[place])) / (2.0 * step);
                assert_abs_diff_eq!(found.s, slope(|both| both.s), epsilon = 1e-6);
                assert_abs_diff_eq!(found.p, slope(|both| both.p), epsilon = 1e-6);
            }
        }
    }
}

#[test]
fn a_kind_that_stays_has_no_part_in_the_slope_by_a_thickness() {
    let media = [Stack::default().media(500.0).unwrap()];
    let slopes = |moves: [f64; 4]| {
        let mut found = vec![StackSlopes::default(); COUNT];
        let kinds = kinds(90.0, 70.0);
        assert!(ordered_slopes_unchecked(&media, &wavenumbers(), (order(&kinds), &moves), 0.3, &mut found));
        found
    };
    let (all, none, one) = (slopes([1.0; 4]), slopes([0.0, 0.0, 1.0, 1.0]), slopes([1.0, 0.0, 1.0, 1.0]));
    let other = slopes([0.0, 1.0, 1.0, 1.0]);
    for place in 0..COUNT {
        assert_abs_diff_eq!(none[place].gap.s, 0.0);
        assert_abs_diff_eq!(one[place].gap.p + other[place].gap.p, all[place].gap.p, epsilon = 1e-14);
        assert_eq!((one[place].cuticle, one[place].angle), (all[place].cuticle, all[place].angle));
    }
}

#[test]
fn where_light_is_lost_or_does_not_travel_there_are_none() {
    let stack = |k, ambient| {
        let cuticle = Material::Constant { n: 1.56, k };
        Stack { cuticle, ambient: Material::constant(ambient), ..Stack::default() }.media(500.0).unwrap()
    };
    let kinds = kinds(90.0, 70.0);
    let found = |media: Media, angle: f64| {
        let mut out = vec![StackSlopes::default(); COUNT];
        ordered_slopes_unchecked(&[media], &wavenumbers(), (order(&kinds), &[1.0; 4]), angle, &mut out)
    };
    assert!(found(stack(0.0, 1.5), 0.5));
    assert!(!found(stack(0.0, 1.5), 0.8) && !found(stack(0.01, 1.0), 0.5) && !found(stack(0.0, 1.0), 2.0));
}
