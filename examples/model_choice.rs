//! How often the choice among nested variants finds the one that made the data.
//!
//! ```sh
//! cargo run --release --example model_choice -- 40
//! ```
//!
//! For each variant and noise (1 % and 5 % of the peak) so many structures are drawn over the middle of the default box,
//! measured with the full design of 172 readings, and chosen from again; all seeded. One row of counts each: the true
//! variant kept, one that contains it (too large), one that it contains or a different one (too small or other).

use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{FitSettings, Parts, VariantFound, choose, structure};
use morpho_fit::optics::{BlendModel, Structure};
use morpho_fit::optimise::Bounds;
use morpho_fit::synthetic::{Scan, simulate};
use morpho_fit::units::radians;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use std::error::Error;

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Background as a share of the peak.
const BACKGROUND: f64 = 0.05;

/// What made the data.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Truth {
    parts: Parts,
    tilt: bool,
    background: bool,
}

impl Truth {
    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for parts in [Parts::Lamella, Parts::Multilayer, Parts::Both] {
            for tilt in [false, true] {
                for background in [false, true] {
                    all.push(Self { parts, tilt, background });
                }
            }
        }
        all.retain(|truth| truth.parts != Parts::Lamella || !truth.tilt);
        all
    }

    fn of(name: &str) -> Self {
        let parts = match name {
            name if name.starts_with("lamella") => Parts::Lamella,
            name if name.starts_with("multilayer") => Parts::Multilayer,
            _ => Parts::Both,
        };
        Self { parts, tilt: name.contains("tilt"), background: name.contains("background") }
    }

    fn is_within(self, larger: Self) -> bool {
        (self.parts == larger.parts || larger.parts == Parts::Both)
            && (!self.tilt || larger.tilt)
            && (!self.background || larger.background)
    }

    fn name(self) -> String {
        let parts = match self.parts {
            Parts::Lamella => "lamella",
            Parts::Multilayer => "multilayer",
            Parts::Both => "blend",
        };
        let tilt = if self.tilt { " + tilt" } else { "" };
        format!("{parts}{tilt}{}", if self.background { " + background" } else { "" })
    }
}

/// Readings of the full design with the parts, tilt and background of `truth`, and normal noise.
fn measured(truth: Truth, drawn: &Structure, noise: f64, seed: u64) -> Result<Dataset> {
    let model = BlendModel::default();
    let drawn = Structure { delta: if truth.tilt { drawn.delta } else { 0.0 }, ..*drawn };
    let plain = simulate(&model, &drawn, &Scan::full_design(&model, &drawn)?, 1.0, 0.0, 0)?;
    // At omega of 0 and 90 degrees each reading sees one part.
    let there = |reading: &Reading| truth.parts.shares(reading.geometry.plane_shares());
    let mut readings = plain.readings().to_vec();
    for reading in &mut readings {
        let (a, b) = there(reading);
        reading.intensity *= a + b;
    }
    let peak = readings.iter().map(|reading| reading.intensity).fold(0.0, f64::max);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for reading in &mut readings {
        let deviate: f64 = StandardNormal.sample(&mut random);
        reading.intensity += peak * (noise * deviate + if truth.background { BACKGROUND } else { 0.0 });
        reading.sigma = Some(noise * peak);
    }
    Ok(Dataset::from_readings(readings, plain.curves().to_vec())?)
}

/// Structures over the box, tilts of at least 1 degree either way.
fn structures(count: usize) -> Result<Vec<Structure>> {
    let bounds = Bounds::new(&[60.0, 40.0, -radians(7.0), 0.25, 150.0], &[250.0, 200.0, radians(7.0), 0.9, 500.0])?;
    let points = bounds.latin_hypercube(count, 17);
    Ok(points
        .iter()
        .map(|point| {
            let delta = point[2] + radians(1.0).copysign(point[2]);
            structure(&[point[0], point[1], delta, point[3], point[4]])
        })
        .collect())
}

fn main() -> Result<()> {
    let count = std::env::args().nth(1).map_or(Ok(1), |count| count.parse())?;
    let dump = std::env::args().nth(2);
    let structures = structures(count)?;
    println!("{:36} {:>5} {:>9} {:>9} {:>9}", "truth", "noise", "true", "too large", "too small");
    let mut lines = Vec::new();
    for noise in [0.01, 0.05] {
        for truth in Truth::all() {
            let one = |(case, drawn): (usize, &Structure)| -> Result<(Truth, Vec<VariantFound>)> {
                let data = measured(truth, drawn, noise, case as u64)?;
                let choice = choose(&data, &FitSettings::default(), &[], &|_| {})?;
                let table = choice.fit.outcome.choice.ok_or("no table")?;
                let kept = table.variants.iter().find(|row| row.standing == morpho_fit::inversion::Standing::Kept);
                let kept = Truth::of(&kept.ok_or("nothing kept")?.name);
                Ok((kept, table.variants))
            };
            let found: Vec<(Truth, Vec<VariantFound>)> =
                structures.iter().collect::<Vec<_>>().into_par_iter().enumerate().map(one).collect::<Result<_>>()?;
            let right = found.iter().filter(|(kept, _)| *kept == truth).count();
            let large = found.iter().filter(|(kept, _)| *kept != truth && truth.is_within(*kept)).count();
            println!("{:36} {noise:>5} {right:>9} {large:>9} {:>9}", truth.name(), found.len() - right - large);
            for (case, (_, rows)) in found.into_iter().enumerate() {
                lines.push(serde_json::json!({"truth": truth.name(), "noise": noise, "case": case, "rows": rows}));
            }
            if let Some(path) = &dump {
                std::fs::write(path, serde_json::to_vec(&lines)?)?;
            }
        }
    }
    Ok(())
}
