//! What a fit costs, from a start and over the whole box: `cargo bench --bench fit`.

use divan::Bencher;
use morpho_fit::dataset::Dataset;
use morpho_fit::inversion::{FitSettings, Search, fit};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::synthetic::{Scan, simulate};

fn main() {
    divan::main();
}

#[divan::bench(args = [Search::Local, Search::Global])]
fn full_design(bencher: Bencher<'_, '_>, search: Search) {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.01, 1).unwrap();
    let start = [Some(150.0), Some(55.0), None, None, None];
    let settings = FitSettings { search, start, ..FitSettings::default() };
    bencher.bench(|| fit(&data, &settings, &|_| {}).unwrap());
}

/// What comes before a fit where the readings are values, not a file.
#[divan::bench]
fn readings_of_the_full_design(bencher: Bencher<'_, '_>) {
    let (model, blue) = (BlendModel::default(), Structure::blue());
    let data = simulate(&model, &blue, &Scan::full_design(&model, &blue).unwrap(), 1.0, 0.01, 1).unwrap();
    let values = || (data.readings().to_vec(), data.curves().to_vec());
    bencher.with_inputs(values).bench_values(|(readings, curves)| Dataset::from_readings(readings, curves).unwrap());
}
