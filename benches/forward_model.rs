//! What one reading costs: the three forms of the stack beside each other, and a whole model.
//!
//! `cargo bench --bench forward_model`. The closed form should cost the same for any number of layers, and a fraction
//! of the recurrence.

use divan::{Bencher, black_box};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use morpho_fit::optics::multilayer::general::{Film, LayeredStack};
use morpho_fit::optics::multilayer::intensity::recurrence;
use morpho_fit::optics::multilayer::{Period, SAndP, reflectivities, reflectivity};
use morpho_fit::optics::{BlendModel, HybridModel, Material, ReflectivityModel, Stack, Structure};
use nalgebra::Complex;

fn main() {
    divan::main();
}

const LAYERS: [usize; 3] = [3, 9, 81];
const PERIOD: Period = Period { cuticle: 100.0, gap: 135.0 };

#[divan::bench(args = LAYERS)]
fn closed_form(bencher: Bencher<'_, '_>, layers: usize) {
    let media = Stack { layers, ..Stack::default() }.media(480.0).unwrap();
    bencher.bench(|| reflectivity(black_box(&media), PERIOD, layers, black_box(0.5)).unwrap());
}

#[divan::bench(args = LAYERS)]
fn amplitude_recurrence(bencher: Bencher<'_, '_>, layers: usize) {
    let film = |n, thickness| Layer { index: Complex::new(n, 0.0), thickness };
    let stack: Vec<Layer> = (0..layers).flat_map(|_| [film(1.56, 100.0), film(1.0, 135.0)]).collect();
    let air = Complex::new(1.0, 0.0);
    bencher.bench(|| {
        [Component::S, Component::P]
            .map(|component| reflect_transmit(1.0, black_box(&stack), air, 480.0, black_box(0.5), component).unwrap())
    });
}

#[divan::bench(args = LAYERS)]
fn intensity_recurrence_of_the_paper(bencher: Bencher<'_, '_>, layers: usize) {
    // One admittance at normal incidence: half the work of the other two.
    let mut admittances = vec![1.0];
    admittances.extend((0..layers).flat_map(|_| [1.0, 1.56]));
    admittances.push(1.0);
    let k = std::f64::consts::TAU / 480.0;
    let phases: Vec<f64> = (0..layers).flat_map(|_| [2.0 * k * 135.0, 2.0 * k * 156.0]).collect();
    bencher.bench(|| recurrence(black_box(&admittances), black_box(&phases)).unwrap());
}

#[divan::bench(args = [0.0, 45.0, 90.0])]
fn blend(bencher: Bencher<'_, '_>, omega_deg: f64) {
    let model = BlendModel::default();
    let geometry = Geometry { theta: 0.1, phi: -0.2, omega: omega_deg.to_radians() };
    bencher.bench(|| model.reflectivity(&Structure::blue(), black_box(&geometry), Polarization::Unpolarized, 480.0));
}

#[divan::bench(args = [0.0, 45.0, 90.0])]
fn hybrid(bencher: Bencher<'_, '_>, omega_deg: f64) {
    let model = HybridModel::default();
    let geometry = Geometry { theta: 0.1, phi: -0.2, omega: omega_deg.to_radians() };
    bencher.bench(|| model.reflectivity(&Structure::blue(), black_box(&geometry), Polarization::Unpolarized, 480.0));
}

/// Any two directions.
#[divan::bench]
fn hybrid_brdf(bencher: Bencher<'_, '_>) {
    let model = HybridModel::default();
    let (incoming, outgoing) = ([0.0, 0.28, 0.96], [0.6, 0.0, 0.8]);
    bencher.bench(|| {
        model.brdf(&Structure::blue(), black_box(incoming), outgoing, Polarization::Unpolarized, 480.0).unwrap()
    });
}

/// A spectrum of 361 wavelengths at once, s and p: divide by 361 to compare with `closed_form`.
#[divan::bench(args = LAYERS)]
fn closed_form_of_a_spectrum(bencher: Bencher<'_, '_>, layers: usize) {
    let media = Stack { layers, ..Stack::default() }.media(480.0).unwrap();
    let wavelengths: Vec<f64> = (380..=740).map(f64::from).collect();
    bencher.bench(|| reflectivities(black_box(&media), &wavelengths, PERIOD, layers, black_box(0.5)).unwrap());
}

/// The same as a list of layers that could be any other, without and with absorption.
#[divan::bench(args = LAYERS, consts = [false, true])]
fn any_layers_of_a_spectrum<const ABSORBING: bool>(bencher: Bencher<'_, '_>, layers: usize) {
    let k = if ABSORBING { 0.06 } else { 0.0 };
    let (air, cuticle) = (Material::constant(1.0), Material::Constant { n: 1.56, k });
    let film = |material: &Material, thickness| Film { material: material.clone(), thickness };
    let films = (0..layers).flat_map(|_| [film(&cuticle, PERIOD.cuticle), film(&air, PERIOD.gap)]).collect();
    let stack = LayeredStack { ambient: air.clone(), films, base: air };
    let wavelengths: Vec<f64> = (380..=740).map(f64::from).collect();
    bencher.bench(|| black_box(&stack).reflectivities(&wavelengths, black_box(0.5)).unwrap());
}

/// The closed form without the checks, as the fit calls it.
#[divan::bench(args = LAYERS)]
fn unchecked_spectrum(bencher: Bencher<'_, '_>, layers: usize) {
    let model = BlendModel { stack: Stack { layers, ..Stack::default() } };
    let media = model.stack.media(480.0).unwrap();
    let wavenumbers: Vec<f64> = (380..=740).map(|nm| std::f64::consts::TAU / f64::from(nm)).collect();
    let mut out = vec![SAndP::default(); wavenumbers.len()];
    bencher.bench_local(|| {
        model.stack_reflectivities(black_box(&[media]), &wavenumbers, PERIOD, black_box(0.5), &mut out).unwrap();
        black_box(&out);
    });
}
