//! Model A and the lobe on hard input.

use super::{DOUBLE, Expected, Map, Row, SINGLE, Verdict, forms};
use crate::geometry::{Geometry, Polarization};
use crate::optics::lamella::LamellaNode;
use crate::optics::{BlendModel, OpticsError, ReflectivityModel, Stack, Structure};
use crate::tradeoff::naive;
use crate::units::radians;
use std::f64::consts::{FRAC_PI_2, TAU};

/// One input of Model A, in the plane across the ridges, or of the lobe, in the plane along them.
struct Case {
    input: &'static str,
    expected: Expected,
    wavelength: f64,
    geometry: Geometry,
    structure: Structure,
    layers: usize,
    part: Part,
}

/// Which factor is looked at; the others are 1 there.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Array,
    Slit,
    Lobe,
}

/// A structure without tilt, so that the mirror direction is `phi = -theta`.
fn flat() -> Structure {
    Structure { delta: 0.0, ..Structure::table1() }
}

fn cases() -> Vec<Case> {
    let across = |theta: f64, phi: f64| Geometry { theta, phi, omega: 0.0 };
    let along = Geometry { theta: 0.0, phi: 0.0, omega: FRAC_PI_2 };
    let one = Expected::Value(1.0);
    let of = |input, expected, wavelength, geometry, structure, layers, part| Case {
        input,
        expected,
        wavelength,
        geometry,
        structure,
        layers,
        part,
    };
    let normal = across(0.0, 0.0);
    let thin = Structure { d_air: 0.0, d_cuticle: 0.0, ..flat() };
    let no_width = Structure { lamella_width: 0.0, ..flat() };
    // As a mean of cosines, sin(M x) / (M sin x) has no ratio: near an order of 1000 layers.
    let near = 470.002_f64;
    let mean = (0..1000).map(|layer| (f64::from(999 - 2 * layer) * TAU / near * 235.0).cos()).sum::<f64>() / 1000.0;
    vec![
        of(
            "φ = −θ: u = 0",
            one,
            470.0 * radians(23.0).cos(),
            across(radians(23.0), -radians(23.0)),
            flat(),
            9,
            Part::Slit,
        ),
        of("a = 0", Expected::ValueOrRefusal(1.0), 470.0, normal, no_width, 9, Part::Slit),
        of("d = 0", one, 500.0, normal, thin, 9, Part::Array),
        of(
            "grazing in and out: v = 0",
            Expected::ValueOrRefusal(0.0),
            500.0,
            across(FRAC_PI_2, FRAC_PI_2),
            flat(),
            9,
            Part::Array,
        ),
        of("λ = 2d, M = 9", one, 470.0, normal, flat(), 9, Part::Array),
        of("λ = 2d/3, M = 9", one, 470.0 / 3.0, normal, flat(), 9, Part::Array),
        of("λ = 2d, M = 1000", one, 470.0, normal, flat(), 1000, Part::Array),
        of("λ = 2d + 0.002 nm, M = 1000", Expected::Value(mean * mean), near, normal, flat(), 1000, Part::Array),
        of("φ_α = 0", Expected::Refusal, 583.0, along, Structure { phi_alpha: 0.0, ..flat() }, 9, Part::Lobe),
        of(
            "φ_α in degrees: 28.6",
            Expected::Refusal,
            583.0,
            along,
            Structure { phi_alpha: 28.6, ..flat() },
            9,
            Part::Lobe,
        ),
        of("δ in degrees: 2.5", Expected::Refusal, 583.0, along, Structure { delta: 2.5, ..flat() }, 9, Part::Lobe),
    ]
}

impl Case {
    /// The factor itself, squared where it is an amplitude, by the printed formula.
    fn printed(&self, single: bool) -> f64 {
        let Self { wavelength, geometry: Geometry { theta, phi, .. }, structure, .. } = self;
        let half_k = 0.5 * TAU / wavelength;
        #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
        let layers = self.layers as f64;
        match self.part {
            Part::Array => {
                // The cosine of a right angle is not 0 in binary; a table of cosines would have 0.
                let cos = |angle: f64| if angle >= FRAC_PI_2 { 0.0 } else { angle.cos() };
                let x = half_k * structure.period() * (cos(*theta) + cos(*phi));
                let amplitude =
                    if single { naive::array_factor::<f32>(x, layers) } else { naive::array_factor::<f64>(x, layers) };
                amplitude.powi(2) * cos(*theta).powi(2)
            }
            Part::Slit => {
                let y = half_k * structure.lamella_width * (theta.sin() + phi.sin());
                let amplitude = if single { naive::slit_factor::<f32>(y) } else { naive::slit_factor::<f64>(y) };
                amplitude.powi(2)
            }
            Part::Lobe => {
                let offset = phi - (2.0 * structure.delta - theta);
                let lobe = if single { naive::lobe::<f32> } else { naive::lobe::<f64> };
                lobe(offset, structure.phi_alpha)
            }
        }
    }

    /// The factor by the library's kernel, which trusts its caller.
    fn kernel(&self) -> Option<f64> {
        let node = LamellaNode::new(self.wavelength, self.geometry.theta, self.geometry.phi);
        match self.part {
            Part::Array => Some(node.interference(self.structure.period(), self.layers) * node.obliquity),
            Part::Slit => Some(node.diffraction(self.structure.lamella_width)),
            Part::Lobe => None,
        }
    }

    /// The factor by the model with its checks: the others are divided out.
    fn model(&self) -> Result<f64, OpticsError> {
        let model = BlendModel { stack: Stack { layers: self.layers, ..Stack::default() } };
        let found = model.reflectivity(&self.structure, &self.geometry, Polarization::Unpolarized, self.wavelength)?;
        let theta = self.geometry.theta;
        Ok(if self.part == Part::Slit { found / theta.cos().powi(2) } else { found })
    }

    fn row(&self) -> Row {
        let judge = |found, tolerance| self.expected.judge(found, tolerance);
        let cells = vec![
            judge(Ok(self.printed(false)), DOUBLE),
            judge(Ok(self.printed(true)), SINGLE),
            self.kernel().map_or(Verdict::Absent, |found| judge(Ok(found), DOUBLE)),
            judge(self.model(), DOUBLE),
        ];
        Row { input: self.input.to_owned(), expected: self.expected.words(), cells }
    }
}

pub(super) fn map() -> Map {
    Map {
        title: "Model A and the lobe".to_owned(),
        forms: forms(&[
            ("as printed", false),
            ("as printed, single precision", false),
            ("kernel", true),
            ("model", true),
        ]),
        rows: cases().iter().map(Case::row).collect(),
    }
}
