//! Runs one of the fixed speed workloads through the public API, so that anyone can time it beside another program.
//!
//! ```sh
//! MORPHO_WORKLOAD=w2.json MORPHO_VARIANT=mixed cargo run --release --example workload -- w2
//! ```
//!
//! The environment names the definition file (data files stand beside it), the variant, and `MORPHO_OUT` for arrays. One
//! JSON line is printed, with the seconds of the work alone.

use morpho_fit::colorimetry::{Illuminant, Integration, Observer, RgbSpace, RgbTransform};
use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::inversion::intervals::{PosteriorSettings, posterior};
use morpho_fit::inversion::{
    Extent, FitOutcome, FitSettings, Fitter, ModelChoice, Nuisances, Parameter, Role, Search, Weight, fit,
};
use morpho_fit::optics::multilayer::general::{Film, LayeredStack};
use morpho_fit::optics::multilayer::{Period, unpolarized_spectra};
use morpho_fit::optics::{Admittance, LamellaUnit, Material, PaperModel, Snell, Stack, Structure};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::table::{Across, Nodes, Quantity, Source, Turn};
use morpho_fit::units::radians;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Value, json};
use std::error::Error;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let name = std::env::args().nth(1).ok_or("which workload? w1, general, w2, w3, w3b, w4, w5, w6 or w7")?;
    let definition = PathBuf::from(std::env::var("MORPHO_WORKLOAD")?);
    let variant = std::env::var("MORPHO_VARIANT").unwrap_or_default();
    let workload: Value = serde_json::from_str(&std::fs::read_to_string(&definition)?)?;
    let folder = definition.parent().unwrap_or(Path::new("."));
    let line = match name.as_str() {
        "w1" | "general" => stack_samples(&workload, &variant, name == "general")?,
        "w2" => one_fit(&workload, folder, &variant)?,
        "w3" | "w3b" => global_fits(&workload, folder, name == "w3b")?,
        "w4" => posterior_of_w2(&workload, folder)?,
        "w5" => pixels(&workload, folder, &variant)?,
        "w6" => colours(&workload, &variant)?,
        "w7" => colour_table(&workload, folder)?,
        other => return Err(format!("this program has no workload {other} yet").into()),
    };
    println!("{line}");
    Ok(())
}

fn numbers(value: &Value) -> Result<Vec<f64>> {
    value
        .as_array()
        .ok_or("not a list")?
        .iter()
        .map(|item| item.as_f64().ok_or_else(|| "not a number".into()))
        .collect()
}

fn number(value: &Value) -> Result<f64> {
    value.as_f64().ok_or_else(|| "not a number".into())
}

/// The values of a range, both ends included.
fn range(workload: &Value, key: &str) -> Result<Vec<f64>> {
    let at = |end: &str| number(&workload[key][end]);
    let (start, stop, step) = (at("start")?, at("stop")?, at("step")?);
    let mut values = vec![start];
    while values[values.len() - 1] + step <= stop {
        values.push(values[values.len() - 1] + step);
    }
    Ok(values)
}

/// The median time of as many runs as half a second holds, 3 to 1000, after the first, which pays for cold memory.
fn median_seconds(mut work: impl FnMut() -> Result<()>) -> Result<f64> {
    work()?;
    let (mut times, begin) = (Vec::new(), Instant::now());
    while times.len() < 3 || (times.len() < 1000 && begin.elapsed().as_secs_f64() < 0.5) {
        let clock = Instant::now();
        work()?;
        times.push(clock.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

/// Columns of a CSV file with one heading line.
fn columns(path: &Path) -> Result<Vec<Vec<f64>>> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path)?;
    let mut columns = vec![Vec::new(); reader.headers()?.len()];
    for record in reader.records() {
        for (column, cell) in columns.iter_mut().zip(&record?) {
            column.push(cell.parse()?);
        }
    }
    Ok(columns)
}

/// The workload model, and its settings for a fit within the workload's bounds.
fn settings(workload: &Value, scale: Extent) -> Result<FitSettings> {
    let model = ModelChoice::Paper {
        snell: Snell::Right,
        admittance: Admittance::Mean,
        lamella_unit: LamellaUnit::Reference { width: number(&workload["fixed"]["a_ref_nm"])? },
    };
    let (lower, upper) = (numbers(&workload["bounds"]["lower"])?, numbers(&workload["bounds"]["upper"])?);
    let roles = Parameter::ALL.map(|parameter| Role::Free {
        lower: parameter.inside(lower[parameter.index()]),
        upper: parameter.inside(upper[parameter.index()]),
    });
    let nuisances = Nuisances { scale, weight: Weight::Fixed(1.0), background: Extent::None };
    Ok(FitSettings { model, roles, nuisances, ..FitSettings::default() })
}

fn start_at(settings: &FitSettings, start: &[f64]) -> FitSettings {
    let start = Parameter::ALL.map(|parameter| Some(parameter.inside(start[parameter.index()])));
    FitSettings { start, search: Search::Local, ..settings.clone() }
}

fn dataset(workload: &Value, intensities: &[f64], sigma: f64) -> Result<Dataset> {
    let theta = radians(number(&workload["theta_deg"])?);
    let mut readings = Vec::with_capacity(intensities.len());
    for omega in numbers(&workload["omega_deg"])? {
        for &wavelength in &numbers(&workload["lambda_nm"])? {
            for phi in numbers(&workload["phi_deg"])? {
                readings.push(Reading {
                    wavelength,
                    geometry: Geometry { theta, phi: radians(phi), omega: radians(omega) },
                    polarization: Polarization::Unpolarized,
                    intensity: intensities[readings.len()],
                    sigma: Some(sigma),
                    curve: 0,
                    line: 0,
                });
            }
        }
    }
    Ok(Dataset::from_readings(readings, vec!["data".to_owned()])?)
}

/// The five values in the workload's units (delta in degrees).
fn values(outcome: &FitOutcome) -> Vec<f64> {
    outcome.parameters.each().iter().map(|(_, e)| e.value.or(e.held_at).unwrap_or(f64::NAN)).collect()
}

/// W1: spectra of a periodic stack at many angles, by the closed form, or layer by layer as a list that could be any other.
pub(crate) fn stack_samples(workload: &Value, variant: &str, general: bool) -> Result<Value> {
    let (kind, small) = variant.strip_suffix("_small").map_or((variant, false), |kind| (kind, true));
    let n = |key: &str| number(&workload[key]);
    let (mut wavelengths, mut thetas) = (range(workload, "lambda_nm")?, range(workload, "theta_deg")?);
    if small {
        wavelengths = wavelengths.into_iter().step_by(10).collect();
        thetas.truncate(1);
    }
    let stack = Stack {
        ambient: Material::constant(n("n_air")?),
        cuticle: Material::constant(n("n_cuticle")?),
        gap: Material::constant(n("n_air")?),
        base: Material::constant(number(&workload["variants"][kind])?),
        layers: serde_json::from_value(workload["periods"].clone())?,
        filling: None,
    };
    let period = Period { cuticle: n("d_cuticle_nm")?, gap: n("d_air_nm")? };
    let film = |material: &Material, thickness| Film { material: material.clone(), thickness };
    let pair = || [film(&stack.cuticle, period.cuticle), film(&stack.gap, period.gap)];
    let films = (0..stack.layers).flat_map(|_| pair()).collect();
    let layered = LayeredStack { ambient: stack.ambient.clone(), films, base: stack.base.clone() };
    let media = stack.media(500.0)?;
    let angles: Vec<f64> = thetas.iter().map(|&theta| radians(theta)).collect();
    let mut values = vec![0.0; wavelengths.len() * thetas.len()];
    let seconds = median_seconds(|| {
        if general {
            let spectra = layered.spectra(&wavelengths, &angles)?;
            turn(&spectra, wavelengths.len(), &mut values, |both| both.mean());
        } else {
            let spectra = unpolarized_spectra(&media, &wavelengths, period, stack.layers, &angles)?;
            turn(&spectra, wavelengths.len(), &mut values, |mean| mean);
        }
        Ok(())
    })?;
    if let Ok(path) = std::env::var("MORPHO_OUT") {
        std::fs::write(path, values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    Ok(json!({ "seconds": seconds, "cpu_seconds": seconds, "samples": values.len() }))
}

/// `[angle][wavelength]`, `along` of these, to `[wavelength][angle]`: some angles together, whose places lie side by side.
fn turn<T: Copy>(from: &[T], along: usize, into: &mut [f64], of: impl Fn(T) -> f64) {
    const TOGETHER: usize = 8;
    let angles = from.len() / along;
    for first in (0..angles).step_by(TOGETHER) {
        let few = first..angles.min(first + TOGETHER);
        for row in 0..along {
            for (into, angle) in into[row * angles..][few.clone()].iter_mut().zip(few.clone()) {
                *into = of(from[angle * along + row]);
            }
        }
    }
}

pub(crate) fn one_fit(workload: &Value, folder: &Path, variant: &str) -> Result<Value> {
    let table = columns(&folder.join("w2_data.csv"))?;
    let data = dataset(workload, &table[4], number(&workload["sigma"])?)?;
    let settings = start_at(&settings(workload, Extent::None)?, &numbers(&workload["starts"][variant])?);
    let mut found = fit(&data, &settings, &|_| {})?.outcome;
    let seconds = median_seconds(|| {
        found = fit(&data, &settings, &|_| {})?.outcome;
        Ok(())
    })?;
    let (x, chi2) = (values(&found), found.chi2);
    Ok(json!({ "seconds": seconds, "cpu_seconds": seconds, "x": x, "chi2": chi2, "nev": found.evaluations }))
}

/// W4: the posterior of W2 from its minimum, flat within its bounds.
pub(crate) fn posterior_of_w2(workload: &Value, folder: &Path) -> Result<Value> {
    let table = columns(&folder.join("w2_data.csv"))?;
    let data = dataset(workload, &table[4], number(&workload["sigma"])?)?;
    let start = numbers(&workload["starts"]["mixed"])?;
    let settings = start_at(&settings(workload, Extent::None)?, &start);
    let found = fit(&data, &settings, &|_| {})?;
    let clock = Instant::now();
    let sampled =
        posterior(&data, &found, &PosteriorSettings { effective: 8000, ..PosteriorSettings::new(1) }, &|_| {})?;
    let seconds = clock.elapsed().as_secs_f64();
    let of_free = sampled.names.iter().take_while(|name| Parameter::from_name(name).is_some()).count();
    let steps = sampled.samples.len() / sampled.chains.max(1);
    if let Ok(path) = std::env::var("MORPHO_OUT") {
        let at = |step: usize, walker: usize| &sampled.samples[walker * steps + step][..of_free];
        let all = (0..steps).flat_map(|step| (0..sampled.chains).flat_map(move |walker| at(step, walker)));
        std::fs::write(path, all.flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    let column = |index: usize| sampled.samples.iter().map(move |row| row[index]);
    let count = sampled.samples.len() as f64;
    let mean: Vec<f64> = (0..of_free).map(|index| column(index).sum::<f64>() / count).collect();
    let spread = |index: usize| (column(index).map(|x| (x - mean[index]).powi(2)).sum::<f64>() / count).sqrt();
    let sd: Vec<f64> = (0..of_free).map(spread).collect();
    let bulk = sampled.convergence.iter().take(of_free).map(|one| one.map_or(0.0, |one| one.bulk));
    let effective = bulk.fold(f64::INFINITY, f64::min);
    Ok(json!({
        "seconds": seconds, "cpu_seconds": seconds, "walkers": sampled.chains, "mean": mean, "sd": sd,
        "effective": effective, "evaluations": sampled.evaluations, "samples": sampled.samples.len(),
        "converged": sampled.converged,
    }))
}

pub(crate) fn global_fits(workload: &Value, folder: &Path, scaled: bool) -> Result<Value> {
    let table = columns(&folder.join(if scaled { "w3b_data.csv" } else { "w3_data.csv" }))?;
    let settings = settings(workload, if scaled { Extent::Shared } else { Extent::None })?;
    let cases = workload["cases"].as_array().ok_or("no cases")?;
    let mut found = Vec::new();
    let (mut seconds, mut ended) = (0.0, 0);
    for (case, intensities) in cases.iter().zip(&table) {
        let data = dataset(workload, intensities, number(&case["sigma"])?)?;
        let clock = Instant::now();
        let outcome = fit(&data, &settings, &|_| {})?.outcome;
        seconds += clock.elapsed().as_secs_f64();
        ended += usize::from(outcome.termination.was_successful());
        found.push((values(&outcome), outcome.chi2, number(&case["chi2_truth"])?));
    }
    let successes = found.iter().filter(|(_, chi2, truth)| *chi2 <= 1.05 * truth).count();
    let x: Vec<&Vec<f64>> = found.iter().map(|(x, ..)| x).collect();
    let chi2: Vec<f64> = found.iter().map(|(_, chi2, _)| *chi2).collect();
    Ok(
        json!({ "seconds": seconds, "cpu_seconds": seconds, "x": x, "chi2": chi2, "successes": successes, "ended": ended }),
    )
}

pub(crate) fn pixels(workload: &Value, folder: &Path, variant: &str) -> Result<Value> {
    let truths = columns(&folder.join("w5_truths.csv"))?;
    let noise: Vec<f64> = std::fs::read_to_string(folder.join("noise.csv"))?
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(str::parse)
        .collect::<std::result::Result<_, _>>()?;
    let settings = settings(workload, Extent::None)?;
    let model = settings.forward()?;
    let fitter = Fitter::new(start_at(&settings, &numbers(&workload["start_all"])?))?;
    let count = variant.parse::<usize>().unwrap_or(1000).min(truths[0].len());
    let blank = dataset(workload, &vec![0.0; noise.len()], 1.0)?;
    let mut sets = Vec::with_capacity(count);
    for pixel in 0..count {
        let structure = Structure {
            d_air: truths[0][pixel],
            d_cuticle: truths[1][pixel],
            delta: radians(truths[2][pixel]),
            phi_alpha: truths[3][pixel],
            lamella_width: truths[4][pixel],
        };
        let clean: Vec<f64> = blank
            .readings()
            .iter()
            .map(|reading| model.reflectivity(&structure, &reading.geometry, reading.polarization, reading.wavelength))
            .collect::<std::result::Result<_, _>>()?;
        let sigma = 0.01 * clean.iter().copied().fold(0.0, f64::max);
        let noisy = clean.iter().enumerate().map(|(j, value)| value + sigma * noise[(j + 37 * pixel) % noise.len()]);
        sets.push(dataset(workload, &noisy.collect::<Vec<f64>>(), sigma)?);
    }
    let clock = Instant::now();
    let found: Vec<FitOutcome> =
        sets.par_iter().map(|data| fitter.outcome(data, &|_| {})).collect::<std::result::Result<_, _>>()?;
    let seconds = clock.elapsed().as_secs_f64();
    let x: Vec<Vec<f64>> = found.iter().map(values).collect();
    let right = x.iter().enumerate().filter(|(pixel, x)| {
        let within = |j: usize| (x[j] - truths[j][*pixel]).abs() <= 0.05 * truths[j][*pixel].abs().max(1.0);
        (0..5).all(within)
    });
    let chi2_max = found.iter().map(|outcome| outcome.chi2 / outcome.dof as f64).fold(0.0, f64::max);
    Ok(json!({ "seconds": seconds, "cpu_seconds": seconds, "right": right.count(), "largest_reduced_chi2": chi2_max }))
}

/// W6: the spectra at a step of `variant` nm, to encoded sRGB.
pub(crate) fn colours(workload: &Value, variant: &str) -> Result<Value> {
    let grid = Wavelengths::new(380.0, 740.0, variant.parse()?)?;
    let count = usize::try_from(workload["n_spectra"].as_u64().ok_or("no count")?)?;
    let mut reflectances = Vec::with_capacity(count * grid.len());
    for spectrum in 0..count {
        let i = spectrum as f64;
        let period = 80.0 + 400.0 * (0.618_033_988_749_894_9 * i).fract();
        let phase = TAU * (0.754_877_666_246_692_7 * i).fract();
        reflectances
            .extend(grid.iter().map(|wavelength| 0.5 + 0.45 * (TAU * (wavelength - 380.0) / period + phase).sin()));
    }
    let integration = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65)?;
    let transform = RgbTransform::new(RgbSpace::Srgb);
    let mut found = integration.encoded_of_many(&reflectances, &transform)?;
    let seconds = median_seconds(|| {
        found = integration.encoded_of_many(&reflectances, &transform)?;
        Ok(())
    })?;
    if let Ok(path) = std::env::var("MORPHO_OUT") {
        std::fs::write(path, found.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    let (mut worst, mut checked) = (0.0_f64, 0);
    for check in workload["checks"].as_array().ok_or("no checks")? {
        if check["step_nm"].as_f64() == Some(grid.step()) {
            let at = usize::try_from(check["i"].as_u64().ok_or("no index")?)?;
            for (channel, known) in found[at].iter().zip(numbers(&check["sRGB"])?) {
                worst = worst.max((channel - known).abs());
            }
            checked += 1;
        }
    }
    Ok(json!({
        "seconds": seconds, "cpu_seconds": seconds, "spectra": count, "spectra_per_second": count as f64 / seconds,
        "worst_check": worst, "checked": checked,
    }))
}

/// W7: the table of linear colours over theta, phi and omega, every plane written out.
pub(crate) fn colour_table(workload: &Value, folder: &Path) -> Result<Value> {
    let (values, seconds) = colour_table_values(workload, folder, |work| median_seconds(work))?;
    if let Ok(path) = std::env::var("MORPHO_OUT") {
        std::fs::write(path, values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>())?;
    }
    Ok(json!({ "seconds": seconds, "cpu_seconds": seconds, "values": values.len() }))
}

type Work<'a> = &'a mut dyn FnMut() -> Result<()>;

/// The table, and what `run` says that filling it takes.
pub(crate) fn colour_table_values(
    workload: &Value,
    folder: &Path,
    run: impl FnOnce(Work<'_>) -> Result<f64>,
) -> Result<(Vec<f64>, f64)> {
    let fixed = |key: &str| number(&workload["fixed"][key]);
    let model = PaperModel {
        stack: Stack {
            ambient: Material::constant(fixed("n_air")?),
            cuticle: Material::constant(fixed("n_cuticle")?),
            gap: Material::constant(fixed("n_air")?),
            base: Material::constant(fixed("n_base")?),
            layers: serde_json::from_value(workload["fixed"]["M"].clone())?,
            filling: None,
        },
        lamella_unit: LamellaUnit::Reference { width: fixed("a_ref_nm")? },
        ..PaperModel::default()
    };
    let [d_air, d_cuticle, delta, phi_alpha, lamella_width] =
        numbers(&workload["p"])?.try_into().map_err(|_| "p has five values")?;
    let structure = Structure { d_air, d_cuticle, delta: radians(delta), phi_alpha, lamella_width };
    let axis = |key: &str| -> Result<Vec<f64>> { Ok(range(workload, key)?.into_iter().map(radians).collect()) };
    let nodes = Nodes::new(axis("theta_deg")?, axis("phi_deg")?, axis("omega_deg")?, Across::View, Turn::Share)?;
    let table = columns(&folder.join(workload["weights"].as_str().ok_or("no weights")?))?;
    let [wavelengths, red, green, blue] = table.try_into().map_err(|_| "weights have four columns")?;
    let weights = Quantity::Colour([red, green, blue]);
    let mut values = vec![0.0; 3 * nodes.count()];
    let seconds = run(&mut || {
        let source = Source::new(&model, &structure, Polarization::Unpolarized, &wavelengths, weights.clone())?;
        Ok(source.fill(&nodes, &mut values)?)
    })?;
    Ok((values, seconds))
}
