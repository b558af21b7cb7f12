//! Wavelengths of a spectrum: the error of its colour against their number.

use crate::spectrum::Wavelengths;
use crate::tradeoff::averages::{SPREAD, normal, spectrum};
use crate::tradeoff::colours::{Eye, quantile};
use crate::tradeoff::{Diagram, Point, Series, Settings, TradeoffError};
use crate::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Steps that divide 400 nm, nm.
const STEPS: [usize; 8] = [40, 20, 16, 10, 8, 5, 4, 2];
/// Random structures and incidences.
const STRUCTURES: usize = 400;
const QUICK_STRUCTURES: usize = 60;
/// Gap, cuticle (nm) and incidence (degrees) are drawn from these.
const GAPS: (f64, f64) = (50.0, 250.0);
const CUTICLES: (f64, f64) = (30.0, 200.0);
const ANGLES: (f64, f64) = (0.0, 60.0);
/// Nodes of the average over thickness.
const NODES: usize = 9;

pub(super) fn diagram(settings: &Settings) -> Result<Diagram, TradeoffError> {
    let wavelengths: Vec<f64> = Wavelengths::finest().iter().collect();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
    let (mut plane, mut mixed) = (Vec::new(), Vec::new());
    for _ in 0..if settings.quick { QUICK_STRUCTURES } else { STRUCTURES } {
        let mut between = |(low, high): (f64, f64)| random.random_range(low..high);
        let (gap, cuticle, angle) = (between(GAPS), between(CUTICLES), radians(between(ANGLES)));
        plane.push(spectrum(&wavelengths, cuticle, gap, angle)?);
        let mut sum = vec![0.0; wavelengths.len()];
        for (node, weight) in normal(NODES) {
            for (sum, value) in sum.iter_mut().zip(spectrum(&wavelengths, cuticle, gap + SPREAD * node, angle)?) {
                *sum += weight * value;
            }
        }
        mixed.push(sum);
    }
    let finest = Eye::new(&Wavelengths::finest())?;
    let mut series: Vec<Series> =
        ["plane wave, median", "plane wave, worst", "thickness sd 5 nm, median", "thickness sd 5 nm, worst"]
            .into_iter()
            .map(|method| Series { method: method.to_owned(), points: Vec::new() })
            .collect();
    for step in STEPS {
        #[allow(clippy::cast_precision_loss, reason = "at most 40")]
        let grid = Wavelengths::visible(step as f64)?;
        let eye = Eye::new(&grid)?;
        let differences = |spectra: &[Vec<f64>]| -> Result<[f64; 2], TradeoffError> {
            let mut differences = Vec::new();
            for spectrum in spectra {
                let thinned: Vec<f64> = spectrum.iter().step_by(step).copied().collect();
                differences.push(eye.lab(&thinned)?.difference(finest.lab(spectrum)?));
            }
            Ok([quantile(&mut differences, 50), quantile(&mut differences, 100)])
        };
        let found = [differences(&plane)?, differences(&mixed)?].concat();
        for (series, y) in series.iter_mut().zip(found) {
            #[allow(clippy::cast_precision_loss, reason = "at most 401")]
            series.points.push(Point { setting: format!("{step} nm"), x: grid.len() as f64, y });
        }
    }
    Ok(Diagram {
        title: "wavelengths from 380 to 780 nm, against steps of 1 nm".to_owned(),
        x_label: "number of wavelengths".to_owned(),
        y_label: "ΔE₀₀".to_owned(),
        y_in_powers: true,
        series,
    })
}
