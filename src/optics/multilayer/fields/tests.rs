//! The recurrence in lanes against the scalar one.

use super::*;
use crate::optics::multilayer::amplitude::{Component, Layer, from_base};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const COUNT: usize = 250;

/// A stack of one to three media, each with one index or one for each wavelength.
struct Drawn {
    rows: Vec<Vec<Complex<f64>>>,
    ambient: Vec<Complex<f64>>,
    base: Vec<Complex<f64>>,
    kinds: Vec<(usize, f64)>,
    order: Vec<usize>,
    repeats: usize,
    angle: f64,
    wavenumbers: Vec<f64>,
}

impl Drawn {
    /// The edges of the domain are among the cases: normal and grazing incidence, no thickness, no contrast, opaque and metallic
    /// layers, a wave along a layer, evanescent waves from a dense medium, a phase of whole half turns, very long and short
    /// wavelengths, many layers.
    fn new(case: usize, random: &mut Xoshiro256PlusPlus) -> Self {
        let dispersive = case.is_multiple_of(3);
        let angle = match case % 7 {
            0 => 0.0,
            1 => 89.9_f64.to_radians(),
            2 => (1.0_f64 / 1.5).asin(),
            _ => random.random_range(0.0..1.57),
        };
        let wavenumbers: Vec<f64> = (0..COUNT)
            .map(|_| {
                TAU / match case % 13 {
                    0 => random.random_range(10.0..50.0),
                    1 => random.random_range(1e5..1e6),
                    _ => random.random_range(300.0..900.0),
                }
            })
            .collect();
        let mut row = |from: f64, to: f64, loss: f64| -> Vec<Complex<f64>> {
            let n: f64 = random.random_range(from..=to);
            let count = if dispersive { COUNT } else { 1 };
            (0..count).map(|place| Complex::new(n + 1e-4 * place as f64, loss)).collect()
        };
        let losses = [[0.0, 0.0, 0.0], [0.0, 0.03, 0.0], [4.0, 1e-9, 0.06], [0.5, 0.0, 3.0]][case % 4];
        let ambient = if case % 7 == 2 { row(1.5, 1.5, 0.0) } else { row(1.0, 1.6, 0.0) };
        let mut rows: Vec<_> = losses.iter().map(|&loss| row(if loss > 1.0 { 0.1 } else { 1.0 }, 2.6, loss)).collect();
        if case.is_multiple_of(50) {
            rows = vec![ambient.clone(); 3];
        }
        let base = if case.is_multiple_of(2) { ambient.clone() } else { row(1.0, 4.0, losses[0]) };
        let mut kinds = Vec::new();
        for place in 0..random.random_range(1..9) {
            let thickness = match random.random_range(0..20) {
                0 => 0.0,
                1 => 1e4,
                2 => std::f64::consts::PI / (wavenumbers[0] * rows[place % 3][0].re),
                _ => random.random_range(0.0..400.0),
            };
            kinds.push((place % 3, thickness));
        }
        let order = (0..random.random_range(1..8)).map(|_| random.random_range(0..kinds.len())).collect();
        let repeats = if case.is_multiple_of(400) { 300 } else { [1, 1, 5][case % 3] };
        Self { rows, ambient, base, kinds, order, repeats, angle, wavenumbers }
    }

    fn found(&self, portable: bool) -> Vec<SAndP> {
        let media: Vec<&[Complex<f64>]> = self.rows.iter().map(Vec::as_slice).collect();
        let layers = Layers {
            ambient: &self.ambient,
            base: &self.base,
            media: &media,
            kinds: &self.kinds,
            order: &self.order,
            repeats: self.repeats,
            stacks: 1,
            pairs: None,
        };
        let mut out = vec![SAndP::default(); COUNT];
        if portable {
            blocks::<false>(&layers, self.angle.cos(), &self.wavenumbers, &mut out);
        } else {
            values(&layers, self.angle.cos(), &self.wavenumbers, &mut out);
        }
        out
    }

    /// The scalar form with all thicknesses so much larger.
    fn scalar(&self, place: usize, larger: f64) -> SAndP {
        let at = |row: &[Complex<f64>]| row[place.min(row.len() - 1)];
        let of = |component| {
            let films = std::iter::repeat_n(&self.order, self.repeats).flatten().map(|&kind| {
                let (medium, thickness) = self.kinds[kind];
                Layer { index: at(&self.rows[medium]), thickness: thickness * larger }
            });
            let wavelength = TAU / self.wavenumbers[place];
            from_base(at(&self.ambient).re, films, at(&self.base), wavelength, self.angle, component).reflectivity
        };
        SAndP { s: of(Component::S), p: of(Component::P) }
    }
}

#[test]
fn a_million_random_values_are_those_of_the_scalar_form() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(17);
    let (mut exact, mut compared) = (0, 0);
    for case in 0..4000 {
        let drawn = Drawn::new(case, &mut random);
        let (found, portable) = (drawn.found(false), drawn.found(true));
        for (place, (found, portable)) in found.iter().zip(&portable).enumerate() {
            let expected = drawn.scalar(place, 1.0);
            let off = |a: &SAndP, b: &SAndP| (a.s - b.s).abs().max((a.p - b.p).abs());
            let difference = off(found, &expected).max(off(portable, &expected));
            compared += 1;
            if difference < 1e-11 {
                exact += 1;
                continue;
            }
            // A sharp resonance turns the rounding of a thickness, here one part in 1e14, into more than that.
            let nudged = [1.0 - 1e-14, 1.0 + 1e-14].map(|larger| off(&drawn.scalar(place, larger), &expected));
            let allowed = 1e-11 + nudged[0] + nudged[1];
            assert!(difference <= allowed, "case {case}: {found:?} {portable:?} {expected:?}, {allowed:e} allowed");
        }
    }
    assert_eq!(compared, 1_000_000);
    assert!(exact > 990_000, "{exact}");
}
