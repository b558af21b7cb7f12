//! The stack of Model B on hard input.

use super::{DOUBLE, Expected, Map, Row, SINGLE, forms};
use crate::geometry::{Geometry, Polarization};
use crate::optics::multilayer::amplitude::{Component, Layer, reflect_transmit};
use crate::optics::multilayer::{Period, reflectivities, reflectivity};
use crate::optics::{
    Admittance, BlendModel, Material, Media, OpticsError, PaperModel, ReflectivityModel, Stack, Structure,
};
use crate::optimise::derivative;
use crate::tradeoff::complex_step::slope;
use crate::tradeoff::naive::Pile;
use crate::units::radians;
use nalgebra::{Complex, DVector};
use std::f64::consts::PI;

/// How far a slope may be from 0, 1/nm: a difference has half the digits.
const SLOPE: f64 = 1e-8;

/// One input.
struct Case {
    input: &'static str,
    expected: Expected,
    pile: Pile,
    /// Incidence, rad.
    angle: f64,
}

/// Table 1 at normal incidence and its peak.
fn table1() -> Pile {
    let air = Complex::new(1.0, 0.0);
    Pile {
        ambient: 1.0,
        cuticle: Complex::new(1.56, 0.0),
        gap: air,
        base: air,
        d_cuticle: 100.0,
        d_gap: 135.0,
        layers: 9,
        wavelength: 583.0,
        sine: 0.0,
        cosine: 1.0,
    }
}

fn at(angle: f64, pile: Pile) -> (Pile, f64) {
    // The cosine of a right angle is not 0 in binary; a table of cosines would have 0.
    let cosine = if (angle - radians(90.0)).abs() < f64::EPSILON { 0.0 } else { angle.cos() };
    (Pile { sine: angle.sin(), cosine, ..pile }, angle)
}

fn cases() -> Vec<Case> {
    let base = table1();
    let (value, refusal) = (Expected::Value, Expected::Refusal);
    let absorbing = Complex::new(1.56, 0.06);
    // A layer that lets nothing through reflects as its surface does.
    let surface = ((absorbing - 1.0) / (absorbing + 1.0)).norm_sqr();
    let with = |input, expected, pile| Case { input, expected, pile, angle: 0.0 };
    let turned = |input, expected, (pile, angle)| Case { input, expected, pile, angle };
    let half_wave = Pile { cuticle: Complex::new(1.5, 0.0), d_cuticle: 156.0, wavelength: 468.0, ..base };
    // A quarter-wave layer of nearly sqrt(2.25), under a layer of air: the last interface is met by R = 1e-9, which single
    // precision takes below 0. A quarter wave reflects ((n² - n_base) / (n² + n_base))².
    let quarter = 1.499_954_f64;
    let matched = ((quarter * quarter - 2.25) / (quarter * quarter + 2.25)).powi(2);
    let coated = Pile {
        cuticle: base.gap,
        gap: Complex::new(quarter, 0.0),
        base: Complex::new(2.25, 0.0),
        d_gap: 117.0 / quarter,
        wavelength: 468.0,
        layers: 1,
        ..base
    };
    vec![
        // Two packages agree on this one to 4e-15.
        with("nothing hard: 583 nm, 0°", value(0.998_597_010_770), base),
        turned("cos θ = 0", value(1.0), at(radians(90.0), base)),
        turned("θ − δ = 100°: in its own shadow", value(0.0), at(radians(100.0), base)),
        with("n_cuticle = n_air", value(0.0), Pile { cuticle: base.gap, ..base }),
        with("d_cuticle = 0", value(0.0), Pile { d_cuticle: 0.0, ..base }),
        with("both thicknesses 0", value(0.0), Pile { d_cuticle: 0.0, d_gap: 0.0, ..base }),
        with("R → 0: one half-wave layer", value(0.0), Pile { layers: 1, ..half_wave }),
        with("R → 0: 40 half-wave layers", value(0.0), Pile { layers: 40, ..half_wave }),
        with("R → 0: antireflection layer", value(matched), coated),
        with("λ = 0", refusal, Pile { wavelength: 0.0, ..base }),
        with("λ = −583 nm", refusal, Pile { wavelength: -583.0, ..base }),
        with("λ in µm: 0.583", refusal, Pile { wavelength: 0.583, ..base }),
        with("d_air = −135 nm", refusal, Pile { d_gap: -135.0, ..base }),
        with("d_air is not a number", refusal, Pile { d_gap: f64::NAN, ..base }),
        turned("from glass past the critical angle", value(1.0), at(radians(60.0), Pile { ambient: 1.56, ..base })),
        with("M = 1000 in the band gap", value(1.0), Pile { layers: 1000, ..base }),
        with("M = 3000 in the band gap", value(1.0), Pile { layers: 3000, ..base }),
        // Of the same two packages.
        with(
            "absorbing: k = 0.06, 480 nm",
            value(0.194_926_989_223),
            Pile { cuticle: absorbing, wavelength: 480.0, ..base },
        ),
        with("absorbing layers of 0.1 mm", value(surface), Pile { cuticle: absorbing, d_cuticle: 1e5, ..base }),
    ]
}

impl Case {
    fn media(&self) -> Media {
        let Pile { wavelength, ambient, cuticle, gap, base, .. } = self.pile;
        Media { wavelength, ambient, cuticle, gap, base }
    }

    fn period(&self) -> Period {
        Period { cuticle: self.pile.d_cuticle, gap: self.pile.d_gap }
    }

    fn amplitude(&self) -> Result<f64, OpticsError> {
        let Pile { ambient, cuticle, gap, base, d_cuticle, d_gap, layers, wavelength, .. } = self.pile;
        let pair = [Layer { index: cuticle, thickness: d_cuticle }, Layer { index: gap, thickness: d_gap }];
        let list = pair.repeat(layers);
        let of = |component| {
            reflect_transmit(ambient, &list, base, wavelength, self.angle, component).map(|found| found.reflectivity)
        };
        Ok(0.5 * (of(Component::S)? + of(Component::P)?))
    }

    /// A whole model in the plane along the ridges, seen in the mirror direction, where the lobe is 1.
    fn model(&self, of: impl Fn(Stack) -> Box<dyn ReflectivityModel>) -> Result<f64, OpticsError> {
        let material = |index: Complex<f64>| Material::Constant { n: index.re, k: index.im };
        let model = of(Stack {
            ambient: Material::constant(self.pile.ambient),
            cuticle: material(self.pile.cuticle),
            gap: material(self.pile.gap),
            base: material(self.pile.base),
            layers: self.pile.layers,
            filling: None,
        });
        // What is beyond 90° from the layers is met by tilting them.
        let delta = if self.angle > radians(90.0) { radians(80.0) - self.angle } else { 0.0 };
        let theta = self.angle + delta;
        let phi = (2.0 * delta - theta).max(-radians(90.0));
        let structure = Structure {
            d_air: self.pile.d_gap,
            d_cuticle: self.pile.d_cuticle,
            delta,
            phi_alpha: PI,
            ..Structure::table1()
        };
        let geometry = Geometry { theta, phi, omega: radians(90.0) };
        model.reflectivity(&structure, &geometry, Polarization::Unpolarized, self.pile.wavelength)
    }

    fn row(&self) -> Row {
        let (media, period, layers) = (self.media(), self.period(), self.pile.layers);
        let spectrum = || {
            let found = reflectivities(&media, &[self.pile.wavelength], period, layers, self.angle)?;
            Ok(found.first().map_or(f64::NAN, |both| both.mean()))
        };
        let exact = |stack| -> Box<dyn ReflectivityModel> {
            Box::new(PaperModel { stack, admittance: Admittance::PerPolarization, ..PaperModel::default() })
        };
        let found = [
            (Ok(self.pile.recurrence::<f64>(true)), DOUBLE),
            (Ok(self.pile.recurrence::<f64>(false)), DOUBLE),
            (Ok(self.pile.recurrence::<f32>(false)), SINGLE),
            (Ok(self.pile.matrix_product::<f64>()), DOUBLE),
            (Ok(self.pile.matrix_product::<f32>()), SINGLE),
            (Ok(self.pile.closed_form()), DOUBLE),
            (reflectivity(&media, period, layers, self.angle).map(|both| both.mean()), DOUBLE),
            (spectrum(), DOUBLE),
            (self.amplitude(), DOUBLE),
            (self.model(|stack| Box::new(BlendModel { stack })), DOUBLE),
            (self.model(exact), DOUBLE),
        ];
        let cells = found.into_iter().map(|(found, tolerance)| self.expected.judge(found, tolerance)).collect();
        Row { input: self.input.to_owned(), expected: self.expected.words(), cells }
    }
}

/// The slope of R where R vanishes: 0, as R is nowhere negative.
pub(super) fn slopes() -> Map {
    let base = table1();
    let half_wave = Pile { cuticle: Complex::new(1.5, 0.0), d_cuticle: 156.0, wavelength: 468.0, ..base };
    let rows = [
        ("R → 0: one half-wave layer", Pile { layers: 1, ..half_wave }),
        ("R → 0: nine half-wave layers", half_wave),
        ("n_cuticle = n_air", Pile { cuticle: base.gap, ..base }),
        ("d_cuticle = 0, on the bound", Pile { d_cuticle: 0.0, ..base }),
    ];
    let row = |(input, pile): (&str, Pile)| {
        let case = Case { input: "", expected: Expected::Value(0.0), pile, angle: 0.0 };
        let at = |cuticle: f64| {
            let period = Period { cuticle, gap: pile.d_gap };
            reflectivity(&case.media(), period, pile.layers, 0.0).map_or(f64::NAN, |both| both.mean())
        };
        let difference = derivative(|d| DVector::from_element(1, at(d)), pile.d_cuticle, 1.0, (0.0, 1e6))[0];
        let step = slope(pile.cuticle.re, pile.layers, pile.wavelength, pile.d_gap, pile.d_cuticle);
        let judge = |found| case.expected.judge(Ok(found), SLOPE);
        let cells = vec![judge(pile.slope_of_recurrence()), judge(step), judge(difference)];
        Row { input: input.to_owned(), expected: case.expected.words(), cells }
    };
    Map {
        title: "Slope dR/dd_cuticle where R is 0".to_owned(),
        forms: forms(&[
            ("chain rule through √R of the recurrence", false),
            ("complex step through the closed form", true),
            ("difference of the closed form", true),
        ]),
        rows: rows.into_iter().map(row).collect(),
    }
}

pub(super) fn map() -> Map {
    Map {
        title: "Model B's stack".to_owned(),
        forms: forms(&[
            ("recurrence as printed, tan", false),
            ("recurrence, atan2", false),
            ("recurrence, atan2, single", false),
            ("matrix product", false),
            ("matrix product, single", false),
            ("sin MK / sin K, real index", false),
            ("closed form", true),
            ("closed form, vector", true),
            ("amplitude recurrence", true),
            ("`blend` model", true),
            ("`paper` model, s and p", true),
        ]),
        rows: cases().iter().map(Case::row).collect(),
    }
}
