//! How far the colours on the default wavelengths are from those by 1 nm: 500 random structures, each seen in 152 ways.
//!
//! ```sh
//! cargo run --release --example sampling -- 500 # writes the tables of `tests/sampling`, in some ten seconds on two cores
//! ```
//!
//! Structures are a Latin hypercube over the default bounds of the five parameters. A scene is one structure under incidences
//! of 0 to 75° by 1°, viewed in the mirror direction `phi = -theta`, along the ridges and across them, by the model `blend`.
//! Each view's colour on the grid that was chosen for the scene is compared with that by 1 nm by CIEDE2000, each against the
//! white of its own grid. All views of such a scene are looked at when its grid is chosen; a colour chart has more views than
//! that, so that charts are held to the same limit: the gap from 0.15 to 0.985 of the period of a structure, which stays, in 56
//! columns, by 76 incidences, along the ridges.

use morpho_fit::colorimetry::{ColourError, Lab};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::inversion::{Parameter, structure};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::optimise::Bounds;
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::sweep::{Grid, View, Viewing, colours};
use morpho_fit::synthetic::linspace;
use morpho_fit::units::radians;
use std::fmt::Write;

type Failure = Box<dyn std::error::Error>;

/// The seed of the committed tables.
pub(crate) const SEED: u64 = 2026;
/// Structures of the committed tables.
pub(crate) const STRUCTURES: usize = 500;
/// Charts of the committed table.
pub(crate) const CHARTS: usize = 60;
/// The most that the default may differ by, CIEDE2000.
pub(crate) const LIMIT: f64 = 0.5;
/// Incidences of a scene, degrees: from 0 to this.
const STEEPEST: u32 = 75;
/// Ends of the gap in a chart, as parts of its period, and the number of its columns.
const GAPS: (f64, f64) = (0.15, 0.985);
const COLUMNS: usize = 56;
/// Width of the ranges that angles are told in, degrees.
const RANGE: u32 = 15;

/// One scene.
#[derive(Debug)]
pub(crate) struct Scene {
    /// Step that was chosen, nm.
    pub(crate) step: f64,
    /// Number of wavelengths.
    pub(crate) wavelengths: usize,
    /// Incidence (degrees), then the difference to 1 nm of the chosen grid and of the paper's, of each view.
    pub(crate) views: Vec<(u32, f64, f64)>,
}

/// Random structures.
fn structures(count: usize, seed: u64) -> Result<Vec<Structure>, Failure> {
    let (lower, upper): (Vec<f64>, Vec<f64>) = Parameter::ALL.map(Parameter::default_bounds).into_iter().unzip();
    let points = Bounds::new(&lower, &upper)?.latin_hypercube(count, seed);
    Ok(points.iter().map(|point| structure(&[point[0], point[1], point[2], point[3], point[4]])).collect())
}

/// The scenes of `count` structures.
pub(crate) fn study(count: usize, seed: u64) -> Result<Vec<Scene>, Failure> {
    let scene = |one: Structure| scene(&[one], &[90.0, 0.0]);
    structures(count, seed)?.into_iter().map(scene).collect()
}

/// The charts of `count` structures.
pub(crate) fn charts(count: usize, seed: u64) -> Result<Vec<Scene>, Failure> {
    let chart = |one: Structure| {
        let period = one.period();
        let gaps = linspace(GAPS.0 * period, GAPS.1 * period, COLUMNS);
        let columns = gaps.into_iter().map(|gap| Structure { d_air: gap, d_cuticle: period - gap, ..one });
        scene(&columns.collect::<Vec<_>>(), &[90.0])
    };
    structures(count, seed)?.into_iter().map(chart).collect()
}

fn scene(structures: &[Structure], omegas: &[f64]) -> Result<Scene, Failure> {
    let mut views = Vec::new();
    let mut angles = Vec::new();
    for &omega in omegas {
        for theta in 0..=STEEPEST {
            let incidence = radians(f64::from(theta));
            let geometry = Geometry { theta: incidence, phi: -incidence, omega: radians(omega) };
            views.extend(structures.iter().map(|&structure| View { structure, geometry }));
            angles.extend(structures.iter().map(|_| theta));
        }
    }
    let on = |grid: Option<Grid>| -> Result<_, Failure> {
        let usual = Viewing::default();
        let viewing = Viewing { grid: grid.unwrap_or(usual.grid), ..usual };
        let found = colours(&BlendModel::default(), &views, Polarization::Unpolarized, &viewing)?;
        let labs = found.colours.iter().map(|colour| Lab::new(colour.unwrap_or_default(), found.white));
        Ok((found.sampling.wavelengths, labs.collect::<Result<Vec<Lab>, ColourError>>()?))
    };
    let (chosen, labs) = on(None)?;
    let (_, fine) = on(Some(Grid::Of(Wavelengths::finest())))?;
    let (_, paper) = on(Some(Grid::Of(Wavelengths::paper())))?;
    let differences = |labs: Vec<Lab>| labs.into_iter().zip(&fine).map(|(one, other)| one.difference(*other));
    let views = angles.into_iter().zip(differences(labs)).zip(differences(paper));
    Ok(Scene {
        step: chosen.step(),
        wavelengths: chosen.len(),
        views: views.map(|((angle, chosen), paper)| (angle, chosen, paper)).collect(),
    })
}

/// The largest of some differences, and their median.
pub(crate) fn largest_and_median(mut values: Vec<f64>) -> (f64, f64) {
    values.sort_by(f64::total_cmp);
    (values.last().copied().unwrap_or_default(), values.get(values.len() / 2).copied().unwrap_or_default())
}

/// A row for each step that was chosen.
pub(crate) fn by_step(scenes: &[Scene]) -> String {
    let mut text = String::from("step_nm,wavelengths,structures,median_ciede2000,largest_ciede2000\n");
    let mut grids: Vec<(f64, usize)> = scenes.iter().map(|scene| (scene.step, scene.wavelengths)).collect();
    grids.sort_by(|a, b| b.0.total_cmp(&a.0));
    grids.dedup();
    for (step, wavelengths) in grids {
        let of: Vec<&Scene> = scenes.iter().filter(|scene| scene.wavelengths == wavelengths).collect();
        let all = of.iter().flat_map(|scene| scene.views.iter().map(|view| view.1)).collect();
        let (largest, median) = largest_and_median(all);
        let _ = writeln!(text, "{step},{wavelengths},{},{median:.4},{largest:.4}", of.len());
    }
    text
}

/// A row for each range of incidences.
pub(crate) fn by_angle(scenes: &[Scene]) -> String {
    let mut text = String::from("from_deg,to_deg,largest_default,median_paper,largest_paper\n");
    for from in (0..STEEPEST).step_by(RANGE as usize) {
        // The last range has its end.
        let to = from + RANGE;
        let inside = |angle: u32| (from..to).contains(&angle) || (angle == to && to == STEEPEST);
        let of = |value: fn(&(u32, f64, f64)) -> f64| {
            let views = scenes.iter().flat_map(|scene| &scene.views).filter(|view| inside(view.0));
            largest_and_median(views.map(value).collect())
        };
        let ((chosen, _), (paper, median)) = (of(|view| view.1), of(|view| view.2));
        let _ = writeln!(text, "{from},{to},{chosen:.4},{median:.4},{paper:.4}");
    }
    text
}

fn main() -> Result<(), Failure> {
    let count = std::env::args().nth(1).map_or(Ok(STRUCTURES), |text| text.parse())?;
    let scenes = study(count, SEED)?;
    let of_charts = charts(CHARTS.min(count), SEED)?;
    let folder = std::path::Path::new("tests/sampling");
    std::fs::create_dir_all(folder)?;
    for (name, scenes, table) in [
        ("sampling.csv", &scenes, by_step(&scenes)),
        ("angles.csv", &scenes, by_angle(&scenes)),
        ("charts.csv", &of_charts, by_step(&of_charts)),
    ] {
        let head =
            format!("# {} structures of a Latin hypercube with seed {SEED}; examples/sampling.rs\n", scenes.len());
        let text = head + &table;
        print!("{text}");
        std::fs::write(folder.join(name), text)?;
    }
    let above = |scene: &&Scene| scene.views.iter().any(|view| view.1 >= LIMIT);
    println!(
        "{} scenes and {} charts have a view at {LIMIT} or more",
        count_of(&scenes, above),
        count_of(&of_charts, above)
    );
    Ok(())
}

fn count_of(scenes: &[Scene], which: impl Fn(&&Scene) -> bool) -> usize {
    scenes.iter().filter(which).count()
}
