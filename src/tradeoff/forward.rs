//! Forward models and their kernels: error in R and in colour, against the exact mean of s and p, over time.

use crate::geometry::{Geometry, Polarization};
use crate::optics::multilayer::amplitude::{Component, Layer, Shares, reflect_transmit};
use crate::optics::multilayer::intensity::recurrence;
use crate::optics::multilayer::{Period, reflectivities, reflectivity};
use crate::optics::{BlendModel, Media, OpticsError, PaperModel, ReflectivityModel, Stack, Structure};
use crate::spectrum::Wavelengths;
use crate::tradeoff::colours::Eye;
use crate::tradeoff::timing::{Method, seconds};
use crate::tradeoff::{Clock, Diagram, Point, Series, Settings, TradeoffError};
use crate::units::radians;
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

/// Incidences that are compared, degrees.
const ANGLES: [f64; 4] = [0.0, 20.0, 40.0, 60.0];

/// A spectrum to compute.
#[derive(Debug, Clone, Copy)]
struct Case {
    structure: Structure,
    /// Incidence, rad.
    angle: f64,
}

/// One way to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kernel {
    RecurrenceMean,
    RecurrenceExact,
    ClosedMean,
    Closed,
    Vector,
    Amplitude,
    Blend,
}

impl Kernel {
    const ALL: [Self; 7] = [
        Self::RecurrenceMean,
        Self::RecurrenceExact,
        Self::ClosedMean,
        Self::Closed,
        Self::Vector,
        Self::Amplitude,
        Self::Blend,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::RecurrenceMean => "recurrence, mean admittance (paper)",
            Self::RecurrenceExact => "recurrence, s and p",
            Self::ClosedMean => "closed form, mean admittance",
            Self::Closed => "closed form, one by one",
            Self::Vector => "closed form, whole spectrum",
            Self::Amplitude => "amplitude recurrence",
            Self::Blend => "`blend` model, checked",
        }
    }

    fn spectrum(self, wavelengths: &[f64], case: &Case) -> Result<Vec<f64>, OpticsError> {
        let stack = Stack::default();
        let media = stack.media(wavelengths.first().copied().unwrap_or(500.0))?;
        let period = Period { cuticle: case.structure.d_cuticle, gap: case.structure.d_air };
        let at = |wavelength: f64| Media { wavelength, ..media };
        let each = wavelengths.iter().copied();
        match self {
            Self::RecurrenceMean => {
                let mean = |n: f64, cos: f64| 0.5 * (n * cos + n / cos);
                each.map(|wavelength| by_intensities(&at(wavelength), period, stack.layers, case.angle, mean)).collect()
            }
            Self::RecurrenceExact => each
                .map(|wavelength| {
                    let of = |rule: fn(f64, f64) -> f64| {
                        by_intensities(&at(wavelength), period, stack.layers, case.angle, rule)
                    };
                    Ok(0.5 * (of(|n, cos| n * cos)? + of(|n, cos| n / cos)?))
                })
                .collect(),
            Self::ClosedMean => {
                let model = PaperModel::default();
                each.map(|wavelength| Ok(model.stack_reflectivity(&at(wavelength), period, case.angle)?.mean()))
                    .collect()
            }
            Self::Closed => each
                .map(|wavelength| Ok(reflectivity(&at(wavelength), period, stack.layers, case.angle)?.mean()))
                .collect(),
            Self::Vector => {
                let found = reflectivities(&media, wavelengths, period, stack.layers, case.angle)?;
                Ok(found.into_iter().map(|both| both.mean()).collect())
            }
            Self::Amplitude => Ok(amplitudes(wavelengths, case)?.into_iter().map(|found| found.reflectivity).collect()),
            Self::Blend => {
                let model = BlendModel::default();
                let geometry = Geometry { theta: case.angle, phi: -case.angle, omega: 0.5 * PI };
                each.map(|wavelength| {
                    model.reflectivity(&case.structure, &geometry, Polarization::Unpolarized, wavelength)
                })
                .collect()
            }
        }
    }
}

/// The paper's recurrence with a rule for the admittance.
fn by_intensities(
    media: &Media,
    period: Period,
    layers: usize,
    angle: f64,
    rule: impl Fn(f64, f64) -> f64,
) -> Result<f64, OpticsError> {
    let cosine = |n: f64| (1.0 - (media.ambient * angle.sin() / n).powi(2)).sqrt();
    let path = |n: f64, d: f64| 2.0 * TAU / media.wavelength * n * d * cosine(n);
    let y = |n: f64| rule(n, cosine(n));
    let (gap, cuticle) = (media.gap.re, media.cuticle.re);
    let mut admittances = vec![y(media.base.re)];
    let mut phases = Vec::with_capacity(2 * layers);
    for _ in 0..layers {
        admittances.extend([y(gap), y(cuticle)]);
        phases.extend([path(gap, period.gap), path(cuticle, period.cuticle)]);
    }
    admittances.push(y(media.ambient));
    recurrence(&admittances, &phases)
}

/// Means of s and p by the complex fields.
fn amplitudes(wavelengths: &[f64], case: &Case) -> Result<Vec<Shares>, OpticsError> {
    let stack = Stack::default();
    let pair = [
        Layer { index: Complex::new(1.56, 0.0), thickness: case.structure.d_cuticle },
        Layer { index: Complex::new(1.0, 0.0), thickness: case.structure.d_air },
    ];
    let layers = pair.repeat(stack.layers);
    let of = |wavelength: f64, component| {
        reflect_transmit(1.0, &layers, Complex::new(1.0, 0.0), wavelength, case.angle, component)
    };
    let both = |&wavelength: &f64| {
        let (s, p) = (of(wavelength, Component::S)?, of(wavelength, Component::P)?);
        Ok(Shares {
            reflectivity: 0.5 * (s.reflectivity + p.reflectivity),
            transmittance: 0.5 * (s.transmittance + p.transmittance),
        })
    };
    wavelengths.iter().map(both).collect()
}

pub(super) fn diagrams(settings: &Settings, clock: Clock<'_>) -> Result<Vec<Diagram>, TradeoffError> {
    let grid = Wavelengths::finest();
    let wavelengths: Vec<f64> = grid.iter().collect();
    let eye = Eye::new(&grid)?;
    let flat = |structure: Structure| Structure { delta: 0.0, ..structure };
    let structures = [flat(Structure::table1()), flat(Structure::blue())];
    let timed = Case { structure: structures[0], angle: radians(ANGLES[2]) };
    // What can be refused is refused here, not under the clock.
    for kernel in Kernel::ALL {
        kernel.spectrum(&wavelengths, &timed)?;
    }
    let mut methods: Vec<Method<'_>> = Kernel::ALL
        .iter()
        .map(|&kernel| {
            let wavelengths = &wavelengths;
            Box::new(move || drop(black_box(kernel.spectrum(wavelengths, black_box(&timed))))) as Method<'_>
        })
        .collect();
    let times = seconds(clock, settings.quick, &mut methods);
    drop(methods);
    #[allow(clippy::cast_precision_loss, reason = "401 wavelengths")]
    let samples = wavelengths.len() as f64;
    let mut by_r = Vec::new();
    let mut by_colour = Vec::new();
    for (kernel, time) in Kernel::ALL.into_iter().zip(times) {
        let (mut off, mut seen) = (Vec::new(), Vec::new());
        for degrees in ANGLES {
            let (mut worst, mut colour) = (0.0_f64, 0.0_f64);
            for structure in structures {
                let case = Case { structure, angle: radians(degrees) };
                let exact = amplitudes(&wavelengths, &case)?;
                // Without absorption 1 - T is R by another way: it tells the reference's own rounding.
                let known: Vec<f64> = if kernel == Kernel::Amplitude {
                    exact.iter().map(|found| 1.0 - found.transmittance).collect()
                } else {
                    exact.iter().map(|found| found.reflectivity).collect()
                };
                let found = kernel.spectrum(&wavelengths, &case)?;
                worst = found.iter().zip(&known).map(|(found, known)| (found - known).abs()).fold(worst, f64::max);
                colour = colour.max(eye.lab(&found)?.difference(eye.lab(&known)?));
            }
            let point = |y| Point { setting: format!("{degrees}°"), x: 1e9 * time / samples, y };
            off.push(point(worst));
            seen.push(point(colour));
        }
        by_r.push(Series { method: kernel.name().to_owned(), points: off });
        by_colour.push(Series { method: kernel.name().to_owned(), points: seen });
    }
    let diagram = |title: &str, y_label: &str, series| Diagram {
        title: title.to_owned(),
        x_label: "time for a wavelength, s and p / ns".to_owned(),
        y_label: y_label.to_owned(),
        y_in_powers: true,
        series,
    };
    Ok(vec![
        diagram("reflectivity, at 0, 20, 40 and 60°", "largest error in R", by_r),
        diagram("colour, at 0, 20, 40 and 60°", "largest ΔE₀₀", by_colour),
    ])
}
