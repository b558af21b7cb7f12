//! What a pixel costs: its colour looked up in a table, and evaluated directly in two ways.
//!
//! `cargo bench --bench table`. A look-up should be 20 times as fast as the faster of the others.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::table::{Across, Needs, Quantity, Range, Source, choose};

fn main() {
    divan::main();
}

const PIXELS: usize = 1000;
/// Step of the spectra from 380 to 780 nm: 41 wavelengths.
const STEP: f64 = 10.0;

fn grid() -> Wavelengths {
    Wavelengths::visible(STEP).unwrap()
}

fn integration() -> Integration {
    Integration::new(&grid(), Observer::Cie1931, &Illuminant::D65).unwrap()
}

fn source(model: &BlendModel) -> Source<'_> {
    let wavelengths: Vec<f64> = grid().iter().collect();
    let quantity = Quantity::Colour(integration().relative_weights());
    Source::new(model, &Structure::blue(), Polarization::Unpolarized, &wavelengths, quantity).unwrap()
}

/// Directions all over the range, as neighbouring pixels of a rough surface have them.
fn pixels() -> Vec<Geometry> {
    let Range { theta, phi, omega } = Range::default();
    let at = |[low, high]: [f64; 2], pixel: usize, step: f64| low + (high - low) * (step * pixel as f64).fract();
    let one = |pixel| Geometry {
        theta: at(theta, pixel, 0.754_877_666),
        phi: at(phi, pixel, 0.569_840_291),
        omega: at(omega, pixel, 0.618_033_989),
    };
    (0..PIXELS).map(one).collect()
}

#[divan::bench]
fn looked_up(bencher: Bencher<'_, '_>) {
    let model = BlendModel::default();
    let source = source(&model);
    let needs = Needs { range: Range::default(), across: Across::Mirror, tolerance: 1.0, most: 1_000_000, seed: 1 };
    let (table, pixels) = (choose(&source, &source, &needs).unwrap().0, pixels());
    let one = |sum: f64, seen: &Geometry| sum + table.colour(seen.theta, seen.phi, seen.omega).unwrap()[1];
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| black_box(&pixels).iter().fold(0.0, one));
}

#[divan::bench]
fn evaluated_in_vector_code(bencher: Bencher<'_, '_>) {
    let model = BlendModel::default();
    let (source, pixels) = (source(&model), pixels());
    let mut colour = [0.0; 3];
    let mut one = |sum: f64, seen: &Geometry| {
        source.evaluate(seen, &mut colour).unwrap();
        sum + colour[1]
    };
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| black_box(&pixels).iter().fold(0.0, &mut one));
}

#[divan::bench]
fn evaluated_wavelength_by_wavelength(bencher: Bencher<'_, '_>) {
    let (model, integration, pixels) = (BlendModel::default(), integration(), pixels());
    let wavelengths: Vec<f64> = grid().iter().collect();
    let mut spectrum = vec![0.0; wavelengths.len()];
    let structure = Structure::blue();
    let mut one = |sum: f64, seen: &Geometry| {
        for (value, &wavelength) in spectrum.iter_mut().zip(&wavelengths) {
            *value = model.reflectivity(&structure, seen, Polarization::Unpolarized, wavelength).unwrap();
        }
        sum + integration.xyz(&spectrum).unwrap().y
    };
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| black_box(&pixels).iter().fold(0.0, &mut one));
}
