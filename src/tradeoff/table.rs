//! A table of colours over θ, φ, ω: the error of a colour between its nodes against its size.
//!
//! The colour at a node is three numbers in single precision, 12 bytes; in between it is linear in each coordinate. In `cos² ω`
//! the model itself is linear, so that two nodes hold every ω. [`choose`] puts the nodes where a tolerance needs them, on an axis
//! along which the lobe stands still.

use crate::colorimetry::{Illuminant, Integration, Lab, Observer, Xyz};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, Structure};
use crate::spectrum::Wavelengths;
use crate::synthetic::linspace;
use crate::table::{Across, Needs, Nodes, Quantity, Range, Source, Table, Turn, choose};
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
/// Tolerances that nodes are chosen for, the worst direction's ΔE.
const TOLERANCES: [f64; 5] = [16.0, 8.0, 4.0, 2.0, 1.0];
const QUICK_TOLERANCES: [f64; 2] = [16.0, 4.0];
/// Nodes of a chosen table at most.
const MOST: usize = 1_000_000;
/// Colours that are looked up.
const LOOKED_UP: usize = 2000;
const QUICK_LOOKED_UP: usize = 200;
/// Steps of the spectra, nm: the error looked for is that of the nodes.
const STEP: f64 = 5.0;

/// Directions with their colours.
struct Known {
    seen: Vec<Geometry>,
    colours: Vec<Lab>,
}

impl Known {
    fn new(source: &Source<'_>, settings: &Settings) -> Result<Self, TradeoffError> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
        let count = if settings.quick { QUICK_LOOKED_UP } else { LOOKED_UP };
        let farthest = radians(FARTHEST);
        let mut one = || Geometry {
            theta: random.random_range(0.0..farthest),
            phi: random.random_range(-farthest..farthest),
            omega: random.random_range(0.0..FRAC_PI_2),
        };
        let seen: Vec<Geometry> = (0..count).map(|_| one()).collect();
        let mut colours = Vec::with_capacity(count);
        for seen in &seen {
            let mut colour = [0.0; 3];
            source.evaluate(seen, &mut colour)?;
            colours.push(lab(colour)?);
        }
        Ok(Self { seen, colours })
    }

    /// Median and 95 % of the errors of a table.
    fn errors(&self, table: &Table) -> Result<[f64; 2], TradeoffError> {
        let mut differences = Vec::with_capacity(self.seen.len());
        for (seen, known) in self.seen.iter().zip(&self.colours) {
            let found = table.colour(seen.theta, seen.phi, seen.omega).unwrap_or_default();
            differences.push(lab(found)?.difference(*known));
        }
        Ok([quantile(&mut differences, 50), quantile(&mut differences, 95)])
    }
}

/// A colour in X/Xn, Y/Yn, Z/Zn.
fn lab(colour: [f64; 3]) -> Result<Lab, TradeoffError> {
    Ok(Lab::new(Xyz::from_array(colour), Xyz { x: 1.0, y: 1.0, z: 1.0 })?)
}

/// Even nodes of θ and φ.
fn even(thetas: usize, turn: Turn) -> Result<Nodes, TradeoffError> {
    let farthest = radians(FARTHEST);
    let planes = if turn == Turn::Share { 2 } else { PLANES };
    Ok(Nodes::new(
        linspace(0.0, farthest, thetas),
        linspace(-farthest, farthest, 2 * thetas - 1),
        linspace(0.0, FRAC_PI_2, planes),
        Across::View,
        turn,
    )?)
}

pub(super) fn diagram(settings: &Settings) -> Result<Diagram, TradeoffError> {
    let (model, grid) = (BlendModel::default(), Wavelengths::visible(STEP)?);
    let weights = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?.relative_weights();
    let wavelengths: Vec<f64> = grid.iter().collect();
    let quantity = Quantity::Colour(weights);
    let source = Source::new(&model, &Structure::blue(), Polarization::Unpolarized, &wavelengths, quantity)?;
    let known = Known::new(&source, settings)?;
    let mut series = Vec::new();
    let mut pair = |name: &str, tables: Vec<(String, Table)>| -> Result<(), TradeoffError> {
        let mut points = [Vec::new(), Vec::new()];
        for (setting, table) in tables {
            #[allow(clippy::cast_precision_loss, reason = "below 2^53")]
            let x = table.bytes() as f64;
            for (points, y) in points.iter_mut().zip(known.errors(&table)?) {
                points.push(Point { setting: setting.clone(), x, y });
            }
        }
        for (points, part) in points.into_iter().zip(["median", "95 %"]) {
            series.push(Series { method: format!("{name}, {part}"), points });
        }
        Ok(())
    };
    let counts = if settings.quick { &QUICK_NODES[..] } else { &NODES[..] };
    for (name, turn) in [("linear in cos² ω", Turn::Share), ("linear in ω, 10 planes", Turn::Angle)] {
        let mut tables = Vec::new();
        for &thetas in counts {
            tables.push((format!("{thetas} θ × {} φ", 2 * thetas - 1), Table::new(&source, even(thetas, turn)?)?));
        }
        pair(name, tables)?;
    }
    let farthest = radians(FARTHEST);
    let range = Range { theta: [0.0, farthest], phi: [-farthest, farthest], omega: [0.0, FRAC_PI_2] };
    let mut tables = Vec::new();
    for &tolerance in if settings.quick { &QUICK_TOLERANCES[..] } else { &TOLERANCES[..] } {
        let needs = Needs { range, across: Across::Mirror, tolerance, most: MOST, seed: settings.seed };
        let (table, judged) = choose(&source, &source, &needs)?;
        let (thetas, across) = (table.nodes().theta().len(), table.nodes().across().len());
        tables.push((format!("{thetas} θ × {across} θ + φ, at worst {:.2}", judged.worst), table));
    }
    pair("nodes of θ and θ + φ chosen", tables)?;
    Ok(Diagram {
        title: "table of colours of the blue preset, to 75°".to_owned(),
        x_label: "size of the table / bytes".to_owned(),
        y_label: "ΔE₀₀ between nodes".to_owned(),
        y_in_powers: true,
        series,
    })
}
