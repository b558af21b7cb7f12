//! What the colour of a pair of directions costs: looked up, and integrated over its spectrum.
//!
//! `cargo bench --bench render`. A look-up should be 20 times as fast as the spectrum in vector code.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
use morpho_fit::geometry::Polarization;
use morpho_fit::optics::multilayer::{Period, reflectivities};
use morpho_fit::optics::{HybridModel, Structure};
use morpho_fit::render::{ColourLookup, Scene, Seen, Surface, Wing, default_maps, trace};
use morpho_fit::spectrum::Wavelengths;
use std::f64::consts::{PI, TAU};

fn main() {
    divan::main();
}

const PAIRS: usize = 1000;
/// Step of the spectra from 380 to 780 nm: 41 wavelengths.
const STEP: f64 = 10.0;

fn grid() -> Wavelengths {
    Wavelengths::visible(STEP).unwrap()
}

fn light() -> Integration {
    Integration::new(&grid(), Observer::Cie1931, &Illuminant::D65).unwrap()
}

fn lookup(gaps: [f64; 2]) -> ColourLookup {
    let (grid, light) = (grid(), light());
    let seen = Seen { wavelengths: &grid, integration: &light };
    ColourLookup::new(&HybridModel::default(), &Structure::blue(), gaps, &seen, 0.5).unwrap()
}

/// Pairs of directions all over the hemisphere whose light is not black, as neighbouring pixels of a rough surface have them.
fn pairs() -> Vec<[[f64; 3]; 2]> {
    let direction = |seed: f64| {
        let (height, turn) = (0.2 + 0.8 * (0.754_877_666 * seed).fract(), TAU * (0.569_840_291 * seed).fract());
        let across = (1.0_f64 - height * height).sqrt();
        [across * turn.cos(), across * turn.sin(), height]
    };
    let all = (0..).map(|pair| f64::from(2 * pair)).map(|seed| [direction(seed), direction(seed + 1.0)]);
    let lit = |[one, other]: &[[f64; 3]; 2]| {
        let model = HybridModel::default();
        model.brdf(&Structure::blue(), *one, *other, Polarization::Unpolarized, 470.0).unwrap() > 0.0
    };
    all.filter(lit).take(PAIRS).collect()
}

#[divan::bench]
fn looked_up(bencher: Bencher<'_, '_>) {
    let (colours, pairs) = (lookup([141.0; 2]), pairs());
    let one = |sum: f64, [sun, eye]: &[[f64; 3]; 2]| sum + colours.xyz(*sun, *eye, 141.0)[1];
    bencher.counter(ItemsCount::new(PAIRS)).bench_local(|| black_box(&pairs).iter().fold(0.0, one));
}

#[divan::bench]
fn looked_up_with_a_gap_that_varies(bencher: Bencher<'_, '_>) {
    let (colours, pairs) = (lookup([126.0, 156.0]), pairs());
    let one = |sum: f64, [sun, eye]: &[[f64; 3]; 2]| sum + colours.xyz(*sun, *eye, 130.0 + sun[0])[1];
    bencher.counter(ItemsCount::new(PAIRS)).bench_local(|| black_box(&pairs).iter().fold(0.0, one));
}

/// The stack in vector registers, the slit at each wavelength, three sums; the factor that is the same at all of them is left
/// out, so that the look-up does more.
#[divan::bench]
fn spectrum_in_vector_code(bencher: Bencher<'_, '_>) {
    let (model, light, pairs, blue) = (HybridModel::default(), light(), pairs(), Structure::blue());
    let wavelengths: Vec<f64> = grid().iter().collect();
    let media = model.stack.media(550.0).unwrap();
    let one = |sum: f64, [sun, eye]: &[[f64; 3]; 2]| {
        let angle = (0.5 * (sun[2] + eye[2])).min(1.0).acos();
        let u = sun[0] + eye[0];
        let found = reflectivities(&media, &wavelengths, Period::of(&blue), model.stack.layers, angle).unwrap();
        let spectrum: Vec<f64> = (found.iter().zip(&wavelengths))
            .map(|(both, wavelength)| {
                let half = PI * u * blue.lamella_width / wavelength;
                let slit = if half.abs() > 1e-9 { half.sin() / half } else { 1.0 };
                both.mean() * slit * slit / wavelength
            })
            .collect();
        sum + light.xyz(&spectrum).unwrap().y
    };
    bencher.counter(ItemsCount::new(PAIRS)).bench_local(|| black_box(&pairs).iter().fold(0.0, one));
}

#[divan::bench]
fn spectrum_wavelength_by_wavelength(bencher: Bencher<'_, '_>) {
    let (model, light, pairs, blue) = (HybridModel::default(), light(), pairs(), Structure::blue());
    let wavelengths: Vec<f64> = grid().iter().collect();
    let one = |sum: f64, [sun, eye]: &[[f64; 3]; 2]| {
        let f = |&wavelength: &f64| model.brdf(&blue, *sun, *eye, Polarization::Unpolarized, wavelength).unwrap();
        sum + light.xyz(&wavelengths.iter().map(f).collect::<Vec<f64>>()).unwrap().y
    };
    bencher.counter(ItemsCount::new(PAIRS)).bench_local(|| black_box(&pairs).iter().fold(0.0, one));
}

/// The light of a picture of 256 × 192 pixels, 16 samples each.
#[divan::bench(sample_count = 5)]
fn picture(bencher: Bencher<'_, '_>) {
    let colours = lookup([141.0; 2]);
    let maps = default_maps(&Wing { size: (512, 512), base: 0.03, gap: 141.0, gap_spread: 0.0 }).unwrap();
    let surface = Surface::new(&maps, Wing::RELIEF, 141.0).unwrap();
    let (scene, white) = (Scene::vertical_sun(0.2), light().white());
    bencher.bench_local(|| trace(black_box(&surface), &colours, &scene, (256, 192), 4, white).unwrap());
}
