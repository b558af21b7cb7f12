//! What each option of the model costs, and what leaving it out costs: time of a reading against the change of colour.
//!
//! The strengths are usual ones, told in the names. A `hybrid` reading is brought to the luminance of `blend`, whose unit is
//! another.

use crate::geometry::{Geometry, Polarization};
use crate::optics::{
    AveragedModel, Averages, BlendModel, HybridModel, Material, OpticsError, ReflectivityModel, Stack, Structure,
};
use crate::spectrum::Wavelengths;
use crate::tradeoff::colours::Eye;
use crate::tradeoff::timing::{Method, seconds};
use crate::tradeoff::{Clock, Diagram, Point, Series, Settings, TradeoffError};
use crate::units::radians;
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

/// Incidences in the plane along the ridges, seen in the mirror direction of the layers, degrees.
const ANGLES: [f64; 4] = [0.0, 20.0, 40.0, 60.0];
/// The incidence that is timed.
const TIMED: usize = 1;
/// Step of the wavelengths, nm.
const STEP: f64 = 5.0;
/// Cauchy's constants of chitin (Leertouwer, Wilts and Stavenga 2011, DOI 10.1364/OE.19.024061).
const CHITIN: (f64, f64) = (1.517, 8800.0);
/// Least difference that is told: nobody sees it.
const UNSEEN: f64 = 0.01;
/// The method without any option.
pub(crate) const PLAIN: &str = "plane waves, equal layers";

/// A model with one option, and that without.
struct Case {
    name: &'static str,
    with: Box<dyn ReflectivityModel>,
    without: Box<dyn ReflectivityModel>,
}

fn cases() -> Result<Vec<Case>, OpticsError> {
    let of = |cuticle: Material| Box::new(BlendModel { stack: Stack { cuticle, ..Stack::default() } });
    let plain = || -> Box<dyn ReflectivityModel> { Box::new(BlendModel::default()) };
    let (a, b) = CHITIN;
    let middle = Material::Constant { n: a + b / 560.0_f64.powi(2), k: 0.0 };
    let mut cases = vec![
        Case { name: PLAIN, with: plain(), without: plain() },
        Case { name: "dispersion of chitin", with: of(Material::Cauchy { a, b }), without: of(middle) },
        Case { name: "absorption k 0.06", with: of(Material::Constant { n: 1.56, k: 0.06 }), without: plain() },
        Case { name: "`hybrid`", with: Box::new(HybridModel::default()), without: plain() },
    ];
    let none = Averages::default();
    for (name, averages) in [
        ("bandwidth 10 nm", Averages { bandwidth: 10.0, ..none }),
        ("period spread 5 nm", Averages { period_spread: 5.0, ..none }),
        ("layer spread 5 nm", Averages { layer_spread: 5.0, ..none }),
        ("tilt spread 3°", Averages { tilt_spread: radians(3.0), ..none }),
        ("aperture 0.4", Averages { numerical_aperture: 0.4, ..none }),
    ] {
        cases.push(Case { name, with: Box::new(AveragedModel::new(plain(), averages)?), without: plain() });
    }
    Ok(cases)
}

/// What a detector reads in the mirror direction of the layers.
fn spectrum(model: &dyn ReflectivityModel, wavelengths: &[f64], theta: f64) -> Result<Vec<f64>, OpticsError> {
    spectrum_of(model, &Structure::table1(), wavelengths, theta)
}

fn spectrum_of(
    model: &dyn ReflectivityModel,
    structure: &Structure,
    wavelengths: &[f64],
    theta: f64,
) -> Result<Vec<f64>, OpticsError> {
    let geometry = Geometry { theta, phi: 2.0 * structure.delta - theta, omega: FRAC_PI_2 };
    wavelengths.iter().map(|&at| model.reflectivity(structure, &geometry, Polarization::Unpolarized, at)).collect()
}

pub(super) fn diagram(settings: &Settings, clock: Clock<'_>) -> Result<Diagram, TradeoffError> {
    let grid = Wavelengths::new(380.0, 780.0, STEP)?;
    let wavelengths: Vec<f64> = grid.iter().collect();
    let (eye, cases) = (Eye::new(&grid)?, cases()?);
    for case in &cases {
        spectrum(case.with.as_ref(), &wavelengths, radians(ANGLES[TIMED]))?;
    }
    let mut methods: Vec<Method<'_>> = (cases.iter())
        .map(|case| {
            let wavelengths = &wavelengths;
            let mut structure = Structure::table1();
            let work = move || {
                // An average remembers what it was asked for: each run asks for another structure.
                structure.d_air += 1e-7;
                drop(black_box(spectrum_of(case.with.as_ref(), &structure, wavelengths, radians(ANGLES[TIMED]))));
            };
            Box::new(work) as Method<'_>
        })
        .collect();
    let times = seconds(clock, settings.quick, &mut methods);
    drop(methods);
    #[allow(clippy::cast_precision_loss, reason = "81 wavelengths")]
    let readings = wavelengths.len() as f64;
    let mut series = Vec::new();
    for (case, time) in cases.iter().zip(times) {
        let mut points = Vec::new();
        for degrees in ANGLES {
            let [mut with, without] = [
                spectrum(case.with.as_ref(), &wavelengths, radians(degrees))?,
                spectrum(case.without.as_ref(), &wavelengths, radians(degrees))?,
            ];
            if case.with.name() != case.without.name() {
                let factor = eye.luminance(&without)? / eye.luminance(&with)?.max(f64::MIN_POSITIVE);
                with.iter_mut().for_each(|value| *value *= factor);
            }
            let y = eye.lab(&with)?.difference(eye.lab(&without)?).max(UNSEEN);
            points.push(Point { setting: format!("{degrees}°"), x: 1e9 * time / readings, y });
        }
        series.push(Series { method: case.name.to_owned(), points });
    }
    Ok(Diagram {
        title: "options, at 0, 20, 40 and 60°".to_owned(),
        x_label: "time for a reading, s and p / ns".to_owned(),
        y_label: "ΔE₀₀ that leaving it out costs, 0.01 at least".to_owned(),
        y_in_powers: true,
        series,
    })
}
