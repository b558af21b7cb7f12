//! The sums of the grid against residuals taken one by one.

use super::*;
use crate::dataset::Dataset;
use crate::inversion::nuisance::{Extent, Nuisances, Weight};
use crate::inversion::parameter::Role;
use crate::inversion::settings::ModelChoice;
use crate::optics::{BlendModel, Structure};
use crate::optimise::LeastSquares;
use crate::synthetic::{Scan, simulate};
use approx::assert_relative_eq;

/// All four planes; curves as they were measured, curves that take turns, and these without sigma.
fn sets() -> [Dataset; 3] {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let mut scans = Scan::full_design(&model, &blue).unwrap();
    scans.extend([Scan::angular(480.0, 30.0), Scan::angular(480.0, 75.0), Scan::spectrum(45.0)]);
    let data = simulate(&model, &blue, &scans, 2.0, 0.01, 1).unwrap();
    let names: Vec<String> = (0..2 * data.curves().len()).map(|curve| format!("curve {curve}")).collect();
    let mut readings = data.readings().to_vec();
    for (row, reading) in readings.iter_mut().enumerate() {
        reading.curve = 2 * reading.curve + (row / 3) % 2;
    }
    let turns = Dataset::from_readings(readings.clone(), names.clone()).unwrap();
    readings.iter_mut().for_each(|reading| reading.sigma = None);
    [data, turns, Dataset::from_readings(readings, names).unwrap()]
}

/// Free, linked to each other or to what a lobe or a slit depends on, and fixed.
fn roles() -> Vec<[Role; COUNT]> {
    let free = FitSettings::default().roles;
    let linked = |of: usize, other: Parameter, factor: f64, constant: f64| {
        let mut roles = free;
        roles[of] = Role::Linked { other, factor, constant };
        roles
    };
    vec![
        free,
        linked(1, Parameter::DAir, -1.0, 203.0),
        linked(2, Parameter::DAir, 2e-4, 0.01),
        linked(4, Parameter::DCuticle, 2.0, 130.0),
        linked(0, Parameter::LamellaWidth, 0.4, 20.0),
        [141.0, 62.0, 0.04, 0.5, 300.0].map(|value| Role::Fixed { value }),
    ]
}

fn assert_cells(data: &Dataset, settings: &FitSettings) -> usize {
    let model = settings.forward().unwrap();
    let compiled = Compiled::new(data, settings, model.as_ref()).unwrap();
    let space = Space::new(&settings.roles).unwrap();
    let (axes, outer) = (axes(&space, &compiled.plan, COARSER), thicknesses(&space));
    let outers: Vec<Vec<f64>> = combinations(&axes[..outer]).into_iter().step_by(37).take(3).collect();
    let inner: Vec<Vec<f64>> = combinations(&axes[outer..]).into_iter().step_by(3).take(9).collect();
    let problem = Problem::new(&compiled, &space, &[]);
    let mut finite = 0;
    for (outer, cell) in outers.iter().zip(cells(&space, &compiled.plan, &compiled.linear, &outers, &inner)) {
        let points = inner
            .iter()
            .map(|inner| DVector::from_iterator(space.freedom.free.len(), outer.iter().chain(inner).copied()));
        let costs = points
            .filter(|point| inside(&space.freedom.expand(point)))
            .map(|point| problem.residuals(&point).norm_squared());
        let least = costs.fold(f64::INFINITY, f64::min);
        assert_eq!(least.is_finite(), cell.cost.is_finite());
        if least.is_finite() {
            assert_relative_eq!(cell.cost, least, max_relative = 1e-9);
            finite += 1;
        }
    }
    finite
}

#[test]
fn a_cell_costs_what_the_best_of_its_points_does() {
    for data in &sets() {
        for model in [ModelChoice::Blend, ModelChoice::Hybrid { ridge_spacing: 750.0 }] {
            for (scale, weight, background) in [
                (Extent::None, Weight::Fixed(0.7), Extent::PerCurve),
                (Extent::Shared, Weight::Fixed(0.7), Extent::None),
                (Extent::Shared, Weight::Fitted, Extent::Shared),
                (Extent::PerCurve, Weight::Fixed(1.0), Extent::Shared),
                (Extent::PerCurve, Weight::Fitted, Extent::PerCurve),
            ] {
                // A product has no weight to be known.
                let product = matches!(model, ModelChoice::Hybrid { .. });
                let weight = if product { Weight::Fitted } else { weight };
                let mut finite = 0;
                for roles in roles() {
                    let nuisances = Nuisances { scale, weight, background };
                    let settings = FitSettings { model, roles, nuisances, ..FitSettings::default() };
                    settings.validate().unwrap();
                    finite += assert_cells(data, &settings);
                }
                assert!(finite >= 6, "{model:?} {scale:?} {weight:?} {background:?}: {finite}");
            }
        }
    }
}
