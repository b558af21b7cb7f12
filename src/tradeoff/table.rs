//! A table of colours over θ, φ, ω: the error of a colour between its nodes against its size.
//!
//! The colour at a node is X, Y, Z in single precision, 12 bytes; in between it is linear in each coordinate. In `cos² ω`
//! the model itself is linear, so that two nodes hold every ω.

use crate::colorimetry::{Lab, Xyz};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, Structure};
use crate::spectrum::Wavelengths;
use crate::sweep::{Grid, View, Viewing, colours};
use crate::synthetic::linspace;
use crate::tradeoff::colours::quantile;
use crate::tradeoff::{Diagram, Point, Series, Settings, TradeoffError};
use crate::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::FRAC_PI_2;

/// Largest incidence and view, degrees.
const FARTHEST: f64 = 75.0;
/// Nodes in θ; φ has twice as many intervals, over both sides.
const NODES: [usize; 5] = [6, 11, 21, 41, 81];
const QUICK_NODES: [usize; 3] = [6, 11, 21];
/// Nodes in ω of the table that is linear in ω.
const PLANES: usize = 10;
/// Colours that are looked up.
const LOOKED_UP: usize = 2000;
const QUICK_LOOKED_UP: usize = 200;
/// Bytes of a node.
const NODE: usize = 12;
/// Steps of the spectra, nm: the error looked for is that of the nodes.
const STEP: f64 = 5.0;

/// Linear colours of both planes at the nodes of θ and φ.
struct Table {
    thetas: usize,
    phis: usize,
    /// The plane across the ridges and the one along them, node by node, φ fastest.
    planes: [Vec<[f64; 3]>; 2],
}

/// Structure with the colours of views of it.
struct Subject {
    structure: Structure,
    viewing: Viewing,
}

impl Subject {
    fn new() -> Result<Self, TradeoffError> {
        let viewing = Viewing { grid: Grid::Of(Wavelengths::visible(STEP)?), ..Viewing::default() };
        Ok(Self { structure: Structure::blue(), viewing })
    }

    fn colours(&self, seen: &[Geometry]) -> Result<(Vec<[f64; 3]>, Xyz), TradeoffError> {
        let views: Vec<View> = seen.iter().map(|&geometry| View { structure: self.structure, geometry }).collect();
        let found = colours(&BlendModel::default(), &views, Polarization::Unpolarized, &self.viewing)?;
        let of = |colour: Option<Xyz>| colour.unwrap_or_default().to_array();
        Ok((found.colours.into_iter().map(of).collect(), found.white))
    }
}

impl Table {
    fn new(subject: &Subject, thetas: usize) -> Result<Self, TradeoffError> {
        let phis = 2 * thetas - 1;
        let plane = |omega: f64| -> Result<Vec<[f64; 3]>, TradeoffError> {
            let mut seen = Vec::with_capacity(thetas * phis);
            for theta in linspace(0.0, FARTHEST, thetas) {
                for phi in linspace(-FARTHEST, FARTHEST, phis) {
                    seen.push(Geometry { theta: radians(theta), phi: radians(phi), omega });
                }
            }
            // As it is stored.
            #[allow(clippy::cast_possible_truncation, reason = "a table in single precision")]
            let single = |colour: [f64; 3]| colour.map(|value| f64::from(value as f32));
            Ok(subject.colours(&seen)?.0.into_iter().map(single).collect())
        };
        Ok(Self { thetas, phis, planes: [plane(0.0)?, plane(FRAC_PI_2)?] })
    }

    /// Linear in θ and φ, with the shares of both planes given.
    fn colour(&self, seen: &Geometry, shares: [f64; 2]) -> [f64; 3] {
        let along = |angle: f64, first: f64, count: usize| {
            #[allow(clippy::cast_precision_loss, reason = "a count of nodes is small")]
            let last = (count - 1) as f64;
            let place = ((angle - first) / (radians(FARTHEST) - first) * last).clamp(0.0, last);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to the last node")]
            let below = (place.floor() as usize).min(count - 2);
            #[allow(clippy::cast_precision_loss, reason = "a count of nodes is small")]
            let share = place - below as f64;
            [(below, 1.0 - share), (below + 1, share)]
        };
        let mut sum = [0.0; 3];
        for (row, on_row) in along(seen.theta, 0.0, self.thetas) {
            for (column, on_column) in along(seen.phi, -radians(FARTHEST), self.phis) {
                for (plane, of_plane) in self.planes.iter().zip(shares) {
                    for (sum, value) in sum.iter_mut().zip(plane[row * self.phis + column]) {
                        *sum += on_row * on_column * of_plane * value;
                    }
                }
            }
        }
        sum
    }
}

/// `cos² ω` and `sin² ω`.
fn exact_shares(omega: f64) -> [f64; 2] {
    [omega.cos().powi(2), omega.sin().powi(2)]
}

/// The same, linear between [`PLANES`] values of ω: what a table that is linear in ω holds.
#[allow(clippy::cast_precision_loss, reason = "ten planes")]
fn linear_shares(omega: f64) -> [f64; 2] {
    let step = FRAC_PI_2 / (PLANES - 1) as f64;
    let below = (omega / step).floor().min((PLANES - 2) as f64);
    let share = omega / step - below;
    let (low, high) = (exact_shares(below * step), exact_shares((below + 1.0) * step));
    std::array::from_fn(|plane| (1.0 - share) * low[plane] + share * high[plane])
}

pub(super) fn diagram(settings: &Settings) -> Result<Diagram, TradeoffError> {
    let subject = Subject::new()?;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let count = if settings.quick { QUICK_LOOKED_UP } else { LOOKED_UP };
    let farthest = radians(FARTHEST);
    let seen: Vec<Geometry> = (0..count)
        .map(|_| Geometry {
            theta: random.random_range(0.0..farthest),
            phi: random.random_range(-farthest..farthest),
            omega: random.random_range(0.0..FRAC_PI_2),
        })
        .collect();
    let (known, white) = subject.colours(&seen)?;
    let names = [
        "linear in cos² ω, median",
        "linear in cos² ω, 95 %",
        "linear in ω, 10 planes, median",
        "linear in ω, 10 planes, 95 %",
    ];
    let mut series: Vec<Series> =
        names.into_iter().map(|method| Series { method: method.to_owned(), points: Vec::new() }).collect();
    for &thetas in if settings.quick { &QUICK_NODES[..] } else { &NODES[..] } {
        let table = Table::new(&subject, thetas)?;
        let differences = |shares: fn(f64) -> [f64; 2]| -> Result<[f64; 2], TradeoffError> {
            let mut differences = Vec::with_capacity(seen.len());
            for (seen, known) in seen.iter().zip(&known) {
                let found = Xyz::from_array(table.colour(seen, shares(seen.omega)));
                let known = Lab::new(Xyz::from_array(*known), white)?;
                differences.push(Lab::new(found, white)?.difference(known));
            }
            Ok([quantile(&mut differences, 50), quantile(&mut differences, 95)])
        };
        let found = [differences(exact_shares)?, differences(linear_shares)?].concat();
        for (index, (series, y)) in series.iter_mut().zip(found).enumerate() {
            let planes = if index < 2 { 2 } else { PLANES };
            #[allow(clippy::cast_precision_loss, reason = "below 2^53")]
            let x = (NODE * planes * table.thetas * table.phis) as f64;
            series.points.push(Point { setting: format!("{thetas} θ × {} φ", table.phis), x, y });
        }
    }
    Ok(Diagram {
        title: "table of colours of the blue preset, to 75°".to_owned(),
        x_label: "size of the table / bytes".to_owned(),
        y_label: "ΔE₀₀ between nodes".to_owned(),
        y_in_powers: true,
        series,
    })
}
