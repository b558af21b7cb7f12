//! What a colour costs: the integral alone, with the encoding, and with the gamut.
//!
//! `cargo bench --bench colour`. The encoding should cost less than the integral over 37 wavelengths, and a colour within
//! the gamut a small part of one outside.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use morpho_fit::colorimetry::{GamutMapping, Illuminant, Integration, Observer, RgbSpace, RgbTransform, Xyz, show};
use morpho_fit::spectrum::Wavelengths;

fn main() {
    divan::main();
}

const SPECTRA: usize = 10_000;
/// Steps of the grid from 380 to 740 nm: 37, 73 and 361 wavelengths.
const STEPS: [f64; 3] = [10.0, 5.0, 1.0];

fn spectra(step: f64) -> (Integration, Vec<f64>) {
    let grid = Wavelengths::new(380.0, 740.0, step).unwrap();
    let of = |spectrum: usize| {
        let period = 80.0 + 400.0 * (0.618 * spectrum as f64).fract();
        grid.iter().map(move |wavelength| 0.5 + 0.45 * (std::f64::consts::TAU * wavelength / period).sin())
    };
    (Integration::new(&grid, Observer::Cie1931, &Illuminant::D65).unwrap(), (0..SPECTRA).flat_map(of).collect())
}

#[divan::bench(args = STEPS)]
fn xyz(bencher: Bencher<'_, '_>, step: f64) {
    let (integration, spectra) = spectra(step);
    bencher.counter(ItemsCount::new(SPECTRA)).bench_local(|| integration.xyz_of_many(black_box(&spectra)).unwrap());
}

#[divan::bench(args = STEPS)]
fn encoded(bencher: Bencher<'_, '_>, step: f64) {
    let (integration, spectra) = spectra(step);
    let transform = RgbTransform::new(RgbSpace::Srgb);
    bencher
        .counter(ItemsCount::new(SPECTRA))
        .bench_local(|| integration.encoded_of_many(black_box(&spectra), &transform).unwrap());
}

#[divan::bench(args = [0.4, 1.3])]
fn shown(z: f64) {
    let white = Xyz { x: 0.9505, y: 1.0, z: 1.089 };
    show(black_box(Xyz { x: 0.3, y: 0.35, z }), white, RgbSpace::Srgb, GamutMapping::default()).unwrap();
}
