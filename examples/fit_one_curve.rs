//! Simulates a measurement, fits it, and prints what was found: the library in twenty lines.
//!
//! `cargo run --release --example fit_one_curve`

use morpho_fit::inversion::{FitSettings, fit};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, simulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, truth) = (BlendModel::default(), Structure::blue());
    let scans = Scan::full_design(&model, &truth)?;
    let data = simulate(&model, &truth, &scans, 1.0, 0.01, 1)?;

    let outcome = fit(&data, &FitSettings::default(), &|_| {})?.outcome;
    println!("{:?}: chi² {:.1} with {} degrees of freedom", outcome.verdict, outcome.chi2, outcome.dof);
    for (name, estimate) in outcome.parameters.each() {
        match (estimate.value, estimate.sigma) {
            (Some(value), Some(sigma)) => println!("{name} = {value:.3} ± {sigma:.3} {}", estimate.unit),
            _ => println!("{name}: {}", estimate.status.phrase()),
        }
    }
    Ok(())
}
