//! Averages over what is not the same everywhere: layer thickness, and a cone of incidence. Error against time by the number of
//! nodes.
//!
//! ```text
//! <R> = sum_i w_i R(d_air + sd x_i)                    x_i, w_i of the normal density
//! <R> = sum_i w_i R(theta_i),   sin²(theta_i) = u_i    u_i, w_i even over 0 to NA²: an aperture filled with light
//! ```

use crate::numerics::quadrature;
use crate::optics::multilayer::{Period, reflectivities};
use crate::optics::{OpticsError, Stack, Structure};
use crate::spectrum::Wavelengths;
use crate::tradeoff::colours::Eye;
use crate::tradeoff::timing::{Method, seconds};
use crate::tradeoff::{Clock, Diagram, Point, Series, Settings, TradeoffError};
use std::hint::black_box;

/// Standard deviation of the air gaps, nm: all gaps of a scale together.
pub(crate) const SPREAD: f64 = 5.0;
/// Numerical aperture of the cone.
const APERTURE: f64 = 0.5;
/// Node counts that are compared.
const COUNTS: [usize; 5] = [1, 2, 3, 5, 9];
/// Nodes of the fine average, in equal steps.
const FINE: usize = 2001;
/// Ends of the equal steps over a normal density, in standard deviations: beyond lie 1e-9 for the fine average.
const FINE_ENDS: f64 = 6.0;
const ENDS: f64 = 2.5;

/// Nodes and weights, whose sum is 1.
pub(crate) type Nodes = Vec<(f64, f64)>;

/// Gauss's nodes for the standard normal density.
pub(crate) fn normal(count: usize) -> Nodes {
    quadrature::normal(count).into_iter().map(|node| (node.at, node.share)).collect()
}

/// Gauss's nodes for an even density from 0 to 1.
fn even(count: usize) -> Nodes {
    quadrature::even(count).into_iter().map(|node| (0.5 * (node.at + 1.0), node.share)).collect()
}

/// Midpoints of equal steps from 0 to 1.
fn midpoints(count: usize) -> Nodes {
    #[allow(clippy::cast_precision_loss, reason = "a count of nodes is small")]
    let share = |index: usize| (index as f64 + 0.5) / count as f64;
    #[allow(clippy::cast_precision_loss, reason = "a count of nodes is small")]
    (0..count).map(|index| (share(index), 1.0 / count as f64)).collect()
}

/// Equal steps over the normal density.
fn steps(count: usize, ends: f64) -> Nodes {
    let raw: Nodes = midpoints(count)
        .into_iter()
        .map(|(share, _)| {
            let x = ends * (2.0 * share - 1.0);
            (x, (-0.5 * x * x).exp())
        })
        .collect();
    let sum: f64 = raw.iter().map(|(_, weight)| weight).sum();
    raw.into_iter().map(|(x, weight)| (x, weight / sum)).collect()
}

/// What is averaged over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Over {
    Thickness,
    Cone,
}

/// The spectrum of a structure, averaged.
fn averaged(over: Over, wavelengths: &[f64], structure: &Structure, nodes: &Nodes) -> Result<Vec<f64>, OpticsError> {
    let mut sum = vec![0.0; wavelengths.len()];
    for &(node, weight) in nodes {
        let (gap, angle) = match over {
            Over::Thickness => (structure.d_air + SPREAD * node, 0.0),
            Over::Cone => (structure.d_air, (APERTURE * node.sqrt()).asin()),
        };
        for (sum, value) in sum.iter_mut().zip(spectrum(wavelengths, structure.d_cuticle, gap, angle)?) {
            *sum += weight * value;
        }
    }
    Ok(sum)
}

/// Mean of s and p of the default stack, without tilt.
pub(crate) fn spectrum(wavelengths: &[f64], cuticle: f64, gap: f64, angle: f64) -> Result<Vec<f64>, OpticsError> {
    let stack = Stack::default();
    let media = stack.media(wavelengths.first().copied().unwrap_or(500.0))?;
    let found = reflectivities(&media, wavelengths, Period { cuticle, gap: gap.max(0.0) }, stack.layers, angle)?;
    Ok(found.into_iter().map(|both| both.mean()).collect())
}

pub(super) fn diagrams(settings: &Settings, clock: Clock<'_>) -> Result<Vec<Diagram>, TradeoffError> {
    let grid = Wavelengths::finest();
    let wavelengths: Vec<f64> = grid.iter().collect();
    let eye = Eye::new(&grid)?;
    let structures = [Structure::table1(), Structure::blue()];
    let mut by_r = Vec::new();
    let mut by_colour = Vec::new();
    for (name, over, rule) in [
        ("thickness sd 5 nm, Gauss", Over::Thickness, normal as fn(usize) -> Nodes),
        ("thickness sd 5 nm, equal steps", Over::Thickness, |count| steps(count, ENDS)),
        ("cone NA 0.5, Gauss", Over::Cone, even),
        ("cone NA 0.5, equal steps", Over::Cone, midpoints),
    ] {
        let nodes: Vec<Nodes> = COUNTS.iter().map(|&count| rule(count)).collect();
        let mut methods: Vec<Method<'_>> = nodes
            .iter()
            .map(|nodes| {
                let (wavelengths, structure) = (&wavelengths, &structures[0]);
                Box::new(move || drop(black_box(averaged(over, wavelengths, black_box(structure), nodes))))
                    as Method<'_>
            })
            .collect();
        let times = seconds(clock, settings.quick, &mut methods);
        drop(methods);
        let fine = if over == Over::Thickness { steps(FINE, FINE_ENDS) } else { midpoints(FINE) };
        let known: Vec<Vec<f64>> = (structures.iter())
            .map(|structure| averaged(over, &wavelengths, structure, &fine))
            .collect::<Result<_, _>>()?;
        let (mut off, mut seen) = (Vec::new(), Vec::new());
        for ((count, nodes), time) in COUNTS.iter().zip(&nodes).zip(times) {
            let (mut worst, mut colour) = (0.0_f64, 0.0_f64);
            for (structure, known) in structures.iter().zip(&known) {
                let found = averaged(over, &wavelengths, structure, nodes)?;
                worst = found.iter().zip(known).map(|(found, known)| (found - known).abs()).fold(worst, f64::max);
                colour = colour.max(eye.lab(&found)?.difference(eye.lab(known)?));
            }
            #[allow(clippy::cast_precision_loss, reason = "401 wavelengths")]
            let x = 1e9 * time / wavelengths.len() as f64;
            let setting = if *count == 1 { "1 node".to_owned() } else { format!("{count} nodes") };
            off.push(Point { setting: setting.clone(), x, y: worst });
            seen.push(Point { setting, x, y: colour });
        }
        by_r.push(Series { method: name.to_owned(), points: off });
        by_colour.push(Series { method: name.to_owned(), points: seen });
    }
    let diagram = |title: &str, y_label: &str, series| Diagram {
        title: title.to_owned(),
        x_label: "time for a wavelength, s and p / ns".to_owned(),
        y_label: y_label.to_owned(),
        y_in_powers: true,
        series,
    };
    Ok(vec![
        diagram("reflectivity, 1, 2, 3, 5 and 9 nodes", "largest error in R", by_r),
        diagram("colour, 1, 2, 3, 5 and 9 nodes", "largest ΔE₀₀", by_colour),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_holds_polynomials_to_its_order() {
        // Moments of the normal density: 1, 0, 1, 0, 3, 0, 15, 0, 105; of the even one: 1 / (k + 1).
        let moment = |nodes: &Nodes, k: i32| nodes.iter().map(|(x, w)| w * x.powi(k)).sum::<f64>();
        for (k, expected) in [(0, 1.0), (1, 0.0), (2, 1.0), (4, 3.0), (6, 15.0), (8, 105.0)] {
            assert!((moment(&normal(5), k) - expected).abs() < 1e-11, "{k}");
        }
        for k in 0..10 {
            assert!((moment(&even(5), k) - 1.0 / f64::from(k + 1)).abs() < 1e-14, "{k}");
        }
        assert!((moment(&steps(FINE, FINE_ENDS), 2) - 1.0).abs() < 1e-6);
    }
}
