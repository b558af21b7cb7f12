//! Where a surface has light: the density by which the nodes of a table are laid.
//!
//! Along a row of half vectors of one azimuth the density is the share of the incidences in which there is light, and its integral is the
//! extent of the light in `sin(theta)`: nodes are dense across the lobe, and azimuths where it reaches far, for there the same step across it is a
//! smaller angle. A share of the nodes is spread evenly. All incidences have the same density: the lobe hardly moves with them in half
//! vectors, and what lies between two incidences is read at the same half vectors in both.

use super::directions::{direction, mirrored, unsquare};
use super::measured::Plane;
use super::tabulate::{share, single};
use super::{BsdfError, Surface};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Rows and columns.
pub(super) const NODES: [usize; 2] = [25, 64];
/// Angles, evenly up to the last, rad, and azimuths of the incidences.
const INCIDENCES: (usize, f64, usize) = (8, 1.4, 8);
/// Halvings of a cell in which the light ends.
const HALVINGS: usize = 12;
/// Share of the nodes that are spread evenly.
const EVEN: f64 = 0.2;

/// The density of the half vectors, with the integral 1.
///
/// # Errors
/// As [`Surface::lit`].
pub(super) fn density(surface: &dyn Surface) -> Result<Plane, BsdfError> {
    let [rows, columns] = NODES;
    let mut values = vec![0.0; rows * columns];
    let reached: Vec<f64> = values
        .par_chunks_exact_mut(columns)
        .enumerate()
        .map(|(row, values)| fill_row(surface, share(row, rows), values))
        .collect::<Result<_, _>>()?;
    // Of a row its shape, times how far it reaches; the integral of all is 1.
    for (values, reached) in values.chunks_exact_mut(columns).zip(&reached) {
        let integral = integral(values);
        let factor = if integral > 0.0 { reached / integral } else { 0.0 };
        values.iter_mut().for_each(|value| *value *= factor);
    }
    let whole = integral(&reached);
    let factor = if whole > 0.0 { (1.0 - EVEN) / whole } else { 0.0 };
    Ok(Plane { size: NODES, values: values.into_iter().map(|value| single(EVEN + factor * value)).collect() })
}

/// Of values that are linear between even nodes from 0 to 1.
fn integral(values: &[f64]) -> f64 {
    let sum: f64 = values.iter().zip(values.iter().skip(1)).map(|(left, right)| 0.5 * (left + right)).sum();
    sum * share(1, values.len())
}

/// Adds up, over the incidences, the share of the cell about each node of a row that has light; gives the extent of the light in
/// `sin(theta)`, summed alike.
fn fill_row(surface: &dyn Surface, y: f64, values: &mut [f64]) -> Result<f64, BsdfError> {
    let (angles, last, azimuths) = INCIDENCES;
    let mut reached = 0.0;
    for angle in 0..angles {
        let theta = last * share(angle, angles);
        for azimuth in 0..azimuths {
            let incoming = direction(theta, PI * (2.0 * share(azimuth, azimuths + 1) - 1.0));
            // Weighted by cos²: light at grazing incidence is seen least.
            reached += add_row(surface, incoming, y, theta.cos().powi(2), values)?;
        }
    }
    Ok(reached)
}

fn add_row(
    surface: &dyn Surface,
    incoming: [f64; 3],
    y: f64,
    weight: f64,
    values: &mut [f64],
) -> Result<f64, BsdfError> {
    let lit = |x: f64| {
        let [theta, phi] = unsquare([x, y]);
        let outgoing = mirrored(incoming, direction(theta, phi));
        outgoing.map_or(Ok(false), |outgoing| surface.lit(incoming, outgoing))
    };
    let sine = |x: f64| unsquare([x, y])[0].sin();
    let last = values.len() - 1;
    let (mut low, mut of_low, mut reached) = (0.0, lit(0.0)?, 0.0);
    for node in 0..last {
        let high = share(node + 1, last + 1);
        let of_high = lit(high)?;
        // From where to where in the cell between both nodes.
        let [from, to] = if of_low == of_high {
            [0.0, f64::from(u8::from(of_low))]
        } else {
            let mut ends = [0.0, 1.0];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (ends[0] + ends[1]);
                ends[usize::from(lit(low + (high - low) * middle)? != of_low)] = middle;
            }
            if of_low { [0.0, ends[0]] } else { [ends[1], 1.0] }
        };
        reached += sine(low + (high - low) * to) - sine(low + (high - low) * from);
        let halves = [to.min(0.5) - from.min(0.5), to.max(0.5) - from.max(0.5)];
        for (index, (value, half)) in values.iter_mut().skip(node).zip(halves).enumerate() {
            // The cells at both ends are half as wide.
            let is_end = node + index == 0 || node + index == last;
            *value += weight * if is_end { 2.0 * half } else { half };
        }
        (low, of_low) = (high, of_high);
    }
    Ok(weight * reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Source;
    use crate::geometry::Polarization;
    use crate::optics::{HybridModel, Structure};

    fn of(structure: &Structure) -> Plane {
        let model = HybridModel::default();
        density(&Source::spectra(&model, structure, Polarization::Unpolarized, &[470.0]).unwrap()).unwrap()
    }

    fn row(plane: &Plane, y: usize) -> &[f32] {
        &plane.values[y * NODES[1]..(y + 1) * NODES[1]]
    }

    /// The closed form of the edge at normal incidence, `2 sin(theta) cos(theta) = 2 sin(phi_alpha / 2)` along the ridges without a
    /// tilt: within it the density is at least three times that well beyond.
    #[test]
    fn nodes_are_dense_within_the_lobe() {
        let structure = Structure { delta: 0.0, ..Structure::blue() };
        let plane = of(&structure);
        // y = 0.75 is the azimuth of 90°.
        let along = row(&plane, 18);
        let edge = 0.5 * (2.0 * (0.5 * structure.phi_alpha).sin()).asin();
        let edge = (edge / (0.5 * PI)).sqrt();
        let at = |factor: f64| {
            let node = (0..NODES[1]).find(|node| share(*node, NODES[1]) > factor * edge);
            f64::from(along[node.unwrap()])
        };
        assert!(at(0.9) > 3.0 * at(1.6) && at(1.6) > 0.99 * EVEN, "{along:?}");
        // Across the ridges there is light at all angles, and azimuths are denser there.
        let sum = |y: usize| row(&plane, y).iter().sum::<f32>();
        assert!(sum(12) > 1.5 * sum(18), "{} {}", sum(12), sum(18));
    }

    /// The integral is 1 whatever the lobe: tilted so that some azimuths are dark, narrower than the cells, or of no light at all.
    #[test]
    fn every_place_has_nodes_and_the_integral_is_1() {
        let blue = Structure::blue();
        for structure in [
            blue,
            Structure { delta: 0.5, phi_alpha: 0.05, ..blue },
            Structure { phi_alpha: 1e-3, ..blue },
            Structure { delta: 1.55, phi_alpha: 1e-3, ..blue },
        ] {
            let plane = of(&structure);
            assert!(plane.values.iter().all(|value| value.is_finite() && f64::from(*value) > 0.99 * EVEN));
            let rows: Vec<f64> = plane
                .values
                .chunks(NODES[1])
                .map(|row| integral(&row.iter().copied().map(f64::from).collect::<Vec<f64>>()))
                .collect();
            let whole = integral(&rows);
            assert!((whole - 1.0).abs() < 1e-5 || (whole - EVEN).abs() < 1e-5, "{structure:?}: {whole}");
        }
    }
}
