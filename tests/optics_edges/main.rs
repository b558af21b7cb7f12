//! Where the naive formulas end in 0/0, overflow or a plausible wrong number, the optics gives the limit or an error.

mod angles;
mod dense_ambient;
mod extremes;
mod input;
mod lamella;
mod no_contrast;
#[path = "../support/mod.rs"]
mod support;

use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::multilayer;
use morpho_fit::optics::multilayer::{Period, SAndP};
use morpho_fit::optics::{Admittance, BlendModel, OpticsError, PaperModel, ReflectivityModel, Stack, Structure};
use morpho_fit::units::radians;

/// Absolute, for values of at most 1: some tens of roundings.
const ROUNDING: f64 = 1e-13;

/// Absolute, for the largest stacks and for places where a cosine is known to 1e-8 only.
const LOOSE: f64 = 1e-10;

const POLARIZATIONS: [Polarization; 3] = [Polarization::Unpolarized, Polarization::S, Polarization::P];

/// Quantities that are no number.
const NO_NUMBERS: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

#[track_caller]
fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found:e} is not {expected:e}");
}

/// Both models on one stack; the paper's with each way of joining the polarizations.
fn models(stack: &Stack) -> [Box<dyn ReflectivityModel>; 3] {
    let paper = PaperModel { stack: stack.clone(), ..PaperModel::default() };
    let apart = PaperModel { admittance: Admittance::PerPolarization, ..paper.clone() };
    [Box::new(BlendModel { stack: stack.clone() }), Box::new(paper), Box::new(apart)]
}

fn of_layers(layers: usize) -> Stack {
    Stack { layers, ..Stack::default() }
}

/// Table 1 without its tilt.
fn upright() -> Structure {
    Structure { delta: 0.0, ..Structure::table1() }
}

/// Across the ridges, where Model A is alone; degrees.
fn across(theta: f64, phi: f64) -> Geometry {
    Geometry { theta: radians(theta), phi: radians(phi), omega: 0.0 }
}

/// Along the ridges, where Model B is alone; degrees.
fn along(theta: f64, phi: f64) -> Geometry {
    Geometry { theta: radians(theta), phi: radians(phi), omega: radians(90.0) }
}

fn read(model: &dyn ReflectivityModel, structure: &Structure, geometry: &Geometry, wavelength: f64) -> f64 {
    model.reflectivity(structure, geometry, Polarization::Unpolarized, wavelength).expect("an answer")
}

/// The reflectivity of `stack` at `angle` (rad) by the library's choice of method.
fn stack_reflectivity(stack: &Stack, period: Period, wavelength: f64, angle: f64) -> SAndP {
    multilayer::reflectivity(&stack.media(wavelength).expect("media"), period, stack.layers, angle).expect("an answer")
}

const TABLE1: Period = Period { cuticle: 100.0, gap: 135.0 };

/// The named quantity is found out of range.
#[track_caller]
fn assert_out_of_range<T: std::fmt::Debug>(result: Result<T, OpticsError>, name: &str) {
    match result {
        Err(OpticsError::OutOfRange { quantity, .. }) => assert_eq!(quantity, name),
        other => panic!("{name}: {other:?}"),
    }
}

/// `((n1 cos1 - n2 cos2) / (n1 cos1 + n2 cos2))²` and the same with n and cos crossed: Fresnel's formulas.
fn fresnel(n: f64, angle: f64) -> SAndP {
    let (cos, refracted) = (angle.cos(), (1.0 - (angle.sin() / n).powi(2)).sqrt());
    let square = |a: f64, b: f64| ((a - b) / (a + b)).powi(2);
    SAndP { s: square(cos, n * refracted), p: square(n * cos, refracted) }
}

/// Runs `check` on both planes of each model.
fn in_each_plane(check: impl Fn(&dyn Fn(&Structure, f64) -> Result<f64, OpticsError>)) {
    for model in models(&Stack::default()) {
        for geometry in [across(10.0, -8.0), along(10.0, -8.0), Geometry { omega: 0.7, ..across(10.0, -8.0) }] {
            check(&|structure, wavelength| {
                model.reflectivity(structure, &geometry, Polarization::Unpolarized, wavelength)
            });
        }
    }
}
