//! Stacks and lamellae of known reflectivity, read from the tables in `tests/reference`, as this crate's types.
//!
//! `tests/reference/README.md` says how the numbers were made.

use morpho_fit::optics::multilayer::amplitude::{Component, Layer, Shares, reflect_transmit};
use morpho_fit::optics::multilayer::intensity::recurrence;
use morpho_fit::optics::multilayer::{Period, SAndP};
use morpho_fit::optics::{Material, Media, Stack};
use morpho_fit::units::radians;
use nalgebra::Complex;
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Both polarizations, in the order of [`SAndP`].
pub const BOTH: [Component; 2] = [Component::S, Component::P];

/// A row by the names of its columns.
type Cells = HashMap<String, String>;

fn table(text: &str) -> Vec<Cells> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().expect("a table with a heading")
}

fn number(cells: &Cells, column: &str) -> f64 {
    cells[column].parse().unwrap_or_else(|_| panic!("{column} is no number in {cells:?}"))
}

fn count(cells: &Cells, column: &str) -> usize {
    cells[column].parse().unwrap_or_else(|_| panic!("{column} is no count in {cells:?}"))
}

/// `n + 0 i`.
pub fn real(n: f64) -> Complex<f64> {
    Complex::new(n, 0.0)
}

/// One row of `tmm_stacks.csv`: any list of layers.
#[derive(Debug, Clone)]
pub struct GeneralStack {
    pub case: String,
    pub wavelength: f64,
    /// Rad.
    pub theta: f64,
    pub component: Component,
    pub ambient: f64,
    pub layers: Vec<Layer>,
    pub base: Complex<f64>,
    pub expected: Shares,
}

/// The 330 rows of `tmm_stacks.csv`.
pub fn general() -> Vec<GeneralStack> {
    let layer = |cell: &str| {
        let numbers: Vec<f64> = cell.split(':').map(|number| number.parse().expect("n:k:d")).collect();
        Layer { index: Complex::new(numbers[0], numbers[1]), thickness: numbers[2] }
    };
    let row = |cells: Cells| GeneralStack {
        wavelength: number(&cells, "wavelength_nm"),
        theta: radians(number(&cells, "theta_deg")),
        component: if cells["polarization"] == "s" { Component::S } else { Component::P },
        ambient: number(&cells, "n_ambient"),
        layers: cells["layers"].split('|').filter(|cell| !cell.is_empty()).map(layer).collect(),
        base: Complex::new(number(&cells, "n_base"), number(&cells, "k_base")),
        expected: Shares { reflectivity: number(&cells, "R"), transmittance: number(&cells, "T") },
        case: cells["case"].clone(),
    };
    table(include_str!("../reference/tmm_stacks.csv")).into_iter().map(row).collect()
}

/// A lossless periodic stack in air, with its exact reflectivity where the table gives it.
#[derive(Debug, Clone)]
pub struct PeriodicStack {
    pub wavelength: f64,
    /// Rad.
    pub theta: f64,
    pub period: Period,
    pub n_cuticle: f64,
    pub n_gap: f64,
    pub n_base: f64,
    pub layers: usize,
    /// Whether a gap lies between the last cuticle layer and the base.
    pub last_gap: bool,
    pub expected: SAndP,
    /// Mean of both; not a number where the table does not give it.
    pub expected_unpolarized: f64,
    /// Of the paper's recurrence as printed; not a number where the table does not give it.
    pub expected_mean_admittance: f64,
}

impl PeriodicStack {
    fn of(cells: &Cells, last_gap: bool) -> Self {
        let if_there = |column| if cells.contains_key(column) { number(cells, column) } else { f64::NAN };
        Self {
            wavelength: number(cells, "wavelength_nm"),
            theta: radians(number(cells, "theta_deg")),
            period: Period { cuticle: number(cells, "d_cuticle_nm"), gap: number(cells, "d_air_nm") },
            n_cuticle: number(cells, "n_cuticle"),
            n_gap: number(cells, "n_gap"),
            n_base: number(cells, "n_base"),
            layers: count(cells, "layers"),
            last_gap,
            expected: SAndP { s: number(cells, "R_s"), p: number(cells, "R_p") },
            expected_unpolarized: if_there("R"),
            expected_mean_admittance: if_there("R_mean_admittance"),
        }
    }

    /// Whether this is a stack of the library's: one with the last gap, or one where that gap is a part of the base.
    pub fn is_ours(&self) -> bool {
        self.last_gap || (self.n_gap - self.n_base).abs() < f64::EPSILON
    }

    pub fn stack(&self) -> Stack {
        Stack {
            ambient: Material::constant(1.0),
            cuticle: Material::constant(self.n_cuticle),
            gap: Material::constant(self.n_gap),
            base: Material::constant(self.n_base),
            layers: self.layers,
            filling: None,
        }
    }

    pub fn media(&self) -> Media {
        self.stack().media(self.wavelength).expect("a valid stack")
    }

    /// The layers one by one, the first one met by the light first.
    pub fn layer_list(&self) -> Vec<Layer> {
        let cuticle = Layer { index: real(self.n_cuticle), thickness: self.period.cuticle };
        let gap = Layer { index: real(self.n_gap), thickness: self.period.gap };
        let mut list = [cuticle, gap].repeat(self.layers);
        if !self.last_gap {
            list.pop();
        }
        list
    }

    /// R by the recurrence over amplitudes, layer by layer.
    pub fn by_amplitudes(&self) -> SAndP {
        let list = self.layer_list();
        let of = |component| {
            let base = real(self.n_base);
            reflect_transmit(1.0, &list, base, self.wavelength, self.theta, component).expect("valid").reflectivity
        };
        SAndP { s: of(Component::S), p: of(Component::P) }
    }

    /// R by the paper's recurrence over intensities, with `admittance(n, cos)` for each medium.
    pub fn by_intensities(&self, admittance: impl Fn(f64, f64) -> f64) -> f64 {
        let (sin, cos) = self.theta.sin_cos();
        let inside = |n: f64| (cos * cos + (1.0 - 1.0 / n) * (1.0 + 1.0 / n) * sin * sin).sqrt();
        let (mut admittances, mut phases) = (vec![admittance(self.n_base, inside(self.n_base))], Vec::new());
        for Layer { index, thickness } in self.layer_list().into_iter().rev() {
            let cos = inside(index.re);
            admittances.push(admittance(index.re, cos));
            phases.push(2.0 * TAU / self.wavelength * index.re * thickness * cos);
        }
        admittances.push(admittance(1.0, cos));
        recurrence(&admittances, &phases).expect("valid")
    }

    /// R by the paper's recurrence, once for each polarization.
    pub fn by_intensities_per_polarization(&self) -> SAndP {
        SAndP { s: self.by_intensities(|n, cos| n * cos), p: self.by_intensities(|n, cos| n / cos) }
    }
}

/// The 24 checks of `w1_checks.csv`.
pub fn w1() -> Vec<PeriodicStack> {
    table(include_str!("../reference/w1_checks.csv")).iter().map(|cells| PeriodicStack::of(cells, true)).collect()
}

/// The 200 rows of `periodic_stacks.csv`.
pub fn periodic() -> Vec<PeriodicStack> {
    table(include_str!("../reference/periodic_stacks.csv"))
        .iter()
        .map(|cells| PeriodicStack::of(cells, false))
        .collect()
}

/// The 200 rows of `mean_admittance.csv`.
pub fn mean_admittance() -> Vec<PeriodicStack> {
    table(include_str!("../reference/mean_admittance.csv"))
        .iter()
        .map(|cells| PeriodicStack::of(cells, false))
        .collect()
}

/// One row of `lamella.csv`.
#[derive(Debug, Clone)]
pub struct Lamella {
    pub wavelength: f64,
    /// Rad.
    pub theta: f64,
    /// Rad.
    pub phi: f64,
    pub period: f64,
    pub width: f64,
    pub layers: usize,
    pub expected: f64,
}

/// The 200 rows of `lamella.csv`.
pub fn lamellae() -> Vec<Lamella> {
    let row = |cells: &Cells| Lamella {
        wavelength: number(cells, "wavelength_nm"),
        theta: radians(number(cells, "theta_deg")),
        phi: radians(number(cells, "phi_deg")),
        period: number(cells, "d_nm"),
        width: number(cells, "a_nm"),
        layers: count(cells, "layers"),
        expected: number(cells, "intensity"),
    };
    table(include_str!("../reference/lamella.csv")).iter().map(row).collect()
}
