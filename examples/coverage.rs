//! How often intervals hold the truth: simulated data sets, fitted, with covariance, profile and posterior.
//!
//! ```text
//! cargo run --release --example coverage -- --sets 2000 --seed 1 --out tests/coverage
//! ```
//!
//! For each design truths are drawn evenly from the bounds, data are simulated with noise of 1 % of their peak, and it is
//! counted how often the intervals of what a fit calls determined hold the truth. The design `w2` is simulation-based
//! calibration too: there the rank of the truth among draws from the posterior is even if the posterior is right (Talts et al.
//! 2018, arXiv 1804.06788), for every data set, determined or not.

use morpho_fit::inversion::intervals::{IntervalPair, PosteriorSettings, posterior, profiles};
use morpho_fit::inversion::{
    COUNT, Estimate, Extent, FitSettings, ModelChoice, Nuisances, Parameter, Role, Weight, fit, structure,
};
use morpho_fit::numerics::normal::distribution;
use morpho_fit::optics::{Admittance, LamellaUnit, Snell};
use morpho_fit::optimise::Bounds;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::uncertainty::goodness::excess;
use morpho_fit::units::radians;
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Standard deviation of the noise as a share of the largest intensity.
const NOISE: f64 = 0.01;
/// Draws from the posterior that the truth is ranked among; ranks are 0 to this.
const DRAWS: usize = 63;
/// Bins of ranks.
const BINS: usize = 16;
/// Effective samples of each posterior.
const EFFECTIVE: usize = 1500;
/// 99 % bands, in per cent, of 1000 data sets.
const BANDS: [(f64, f64); 2] = [(64.5, 72.1), (93.2, 96.8)];

const METHODS: [&str; 3] = ["covariance", "profile", "posterior"];
const QUANTITIES: [&str; 7] = ["d_air", "d_cuticle", "delta", "phi_alpha", "lamella_width", "period", "optical_sum"];

/// A design of measurement with the choices of its fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Design {
    /// A spectrum and an angular scan in each plane: all five.
    Full,
    /// Spectra in the mirror direction at five angles along the ridges: thicknesses and tilt.
    Spectra,
    /// The geometry and model of workload W2.
    W2,
}

impl Design {
    pub(crate) const ALL: [Self; 3] = [Self::Full, Self::Spectra, Self::W2];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Spectra => "spectra",
            Self::W2 => "w2",
        }
    }

    fn settings(self) -> FitSettings {
        if self != Self::W2 {
            return FitSettings::default();
        }
        let model = ModelChoice::Paper {
            snell: Snell::Right,
            admittance: Admittance::Mean,
            lamella_unit: LamellaUnit::Reference { width: 300.0 },
        };
        let nuisances = Nuisances { scale: Extent::None, weight: Weight::Fixed(1.0), background: Extent::None };
        let free = |lower, upper| Role::Free { lower, upper };
        let tilt = radians(10.0);
        let roles = [free(50.0, 250.0), free(30.0, 200.0), free(-tilt, tilt), free(0.1, 1.2), free(100.0, 600.0)];
        FitSettings { model, nuisances, roles, ..FitSettings::default() }
    }

    fn scans(self, settings: &FitSettings, truth: &[f64; COUNT]) -> Result<Vec<Scan>, Box<dyn Error + Send + Sync>> {
        let model = settings.forward()?;
        Ok(match self {
            Self::Full => Scan::full_design(model.as_ref(), &structure(truth))?,
            Self::Spectra => (0..5)
                .map(|step| {
                    let theta = radians(15.0 * f64::from(step));
                    let name = format!("spectrum at theta {}", 15 * step);
                    Scan { name, thetas: vec![theta], phis: vec![-theta], ..Scan::spectrum(90.0) }
                })
                .collect(),
            Self::W2 => {
                let phis: Vec<f64> = linspace(-75.0, 75.0, 31).into_iter().map(radians).collect();
                let omegas = vec![radians(15.0), radians(75.0)];
                vec![Scan { name: "w2".to_owned(), phis, omegas, ..Scan::spectrum(0.0) }]
            }
        })
    }
}

/// What one data set gives: for each quantity and method whether the two intervals hold the truth, and the ranks.
struct Held {
    /// `None` for what the fit does not call determined.
    covered: [Option<[[bool; 2]; 3]>; 7],
    ranks: Option<[usize; COUNT]>,
    converged: bool,
}

/// The counts of one design.
#[derive(Debug, Clone)]
pub(crate) struct Study {
    pub(crate) design: Design,
    pub(crate) sets: usize,
    /// Data sets in which each quantity was determined.
    pub(crate) determined: [usize; 7],
    /// Of these, how often the intervals held the truth: quantity, method, level.
    pub(crate) covered: [[[usize; 2]; 3]; 7],
    /// Ranks of the truth in the posterior, for each parameter.
    pub(crate) ranks: [[usize; BINS]; COUNT],
    /// Posteriors that did not converge.
    pub(crate) unconverged: usize,
}

impl Study {
    /// Coverage in per cent: 68.3 % and 95 %.
    pub(crate) fn coverage(&self, quantity: usize, method: usize) -> [f64; 2] {
        self.covered[quantity][method].map(|count| 100.0 * count as f64 / self.determined[quantity].max(1) as f64)
    }

    /// chi² of the ranks of a parameter against an even histogram, and the probability of a larger one.
    pub(crate) fn evenness(&self, parameter: usize) -> (f64, f64) {
        let ranks = &self.ranks[parameter];
        let expected = ranks.iter().sum::<usize>() as f64 / BINS as f64;
        let chi2 = ranks.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum::<f64>();
        (chi2, distribution(-excess(chi2, BINS - 1)))
    }
}

/// Runs a design with `sets` data sets; each set has a seed of its own, so that the same call gives the same counts.
pub(crate) fn study(design: Design, sets: usize, seed: u64) -> Result<Study, Box<dyn Error + Send + Sync>> {
    let settings = design.settings();
    let (lower, upper): (Vec<f64>, Vec<f64>) = (settings.roles.iter())
        .map(|role| match *role {
            Role::Free { lower, upper } => (lower, upper),
            Role::Fixed { value } => (value, value),
            Role::Linked { .. } => (f64::NAN, f64::NAN),
        })
        .unzip();
    let truths = Bounds::new(&lower, &upper)?.latin_hypercube(sets, seed);
    let done = AtomicUsize::new(0);
    let one = |(index, truth): (usize, &nalgebra::DVector<f64>)| {
        let truth: [f64; COUNT] = std::array::from_fn(|j| truth[j]);
        let held = data_set(design, &settings, &truth, seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_multiple_of(100) {
            eprintln!("{}: {count} of {sets}", design.name());
        }
        held
    };
    let all: Result<Vec<Held>, _> = truths.par_iter().enumerate().map(one).collect();
    let mut study = Study {
        design,
        sets,
        determined: [0; 7],
        covered: [[[0; 2]; 3]; 7],
        ranks: [[0; BINS]; COUNT],
        unconverged: 0,
    };
    for held in all? {
        for (quantity, covered) in held.covered.iter().enumerate() {
            let Some(covered) = covered else { continue };
            study.determined[quantity] += 1;
            for (method, levels) in covered.iter().enumerate() {
                for (level, &inside) in levels.iter().enumerate() {
                    study.covered[quantity][method][level] += usize::from(inside);
                }
            }
        }
        for (parameter, rank) in held.ranks.into_iter().flatten().enumerate() {
            study.ranks[parameter][rank * BINS / (DRAWS + 1)] += 1;
        }
        study.unconverged += usize::from(!held.converged);
    }
    Ok(study)
}

fn data_set(
    design: Design,
    settings: &FitSettings,
    truth: &[f64; COUNT],
    seed: u64,
) -> Result<Held, Box<dyn Error + Send + Sync>> {
    let model = settings.forward()?;
    let scans = design.scans(settings, truth)?;
    let data = simulate(model.as_ref(), &structure(truth), &scans, 1.0, NOISE, seed)?;
    let settings = FitSettings { seed, ..settings.clone() };
    let quiet = |_: &str| {};
    let found = fit(&data, &settings, &quiet)?;
    let outcome = &found.outcome;
    let estimates: Vec<&Estimate> = (outcome.parameters.each().into_iter().map(|(_, estimate)| estimate))
        .chain([&outcome.derived.period, &outcome.derived.optical_sum])
        .collect();
    let ranked = design == Design::W2;
    if !ranked && !estimates.iter().any(|estimate| estimate.status.is_determined()) {
        return Ok(Held { covered: [None; 7], ranks: None, converged: true });
    }
    let profiles = profiles(&data, &found, &quiet)?;
    let sampling = PosteriorSettings { effective: EFFECTIVE, ..PosteriorSettings::new(seed) };
    let posterior = posterior(&data, &found, &sampling, &quiet)?;
    let mut values = Parameter::ALL.map(|parameter| parameter.outside(truth[parameter.index()])).to_vec();
    let media = settings.stack.media(560.0)?;
    values.extend([truth[0] + truth[1], media.gap.re * truth[0] + media.cuticle.re * truth[1]]);
    let mut covered = [None; 7];
    for (quantity, name) in QUANTITIES.into_iter().enumerate() {
        let estimate = estimates[quantity];
        if !estimate.status.is_determined() {
            continue;
        }
        let of_covariance = estimate.interval_68.zip(estimate.interval_95);
        let of_profile = profiles.quantities.iter().find(|profile| profile.name == name).map(|one| one.intervals);
        let of_posterior = posterior.names.iter().position(|other| *other == name).map(|at| posterior.intervals[at]);
        let truth = values[quantity];
        let holds = |interval: [Option<f64>; 2]| {
            interval[0].is_none_or(|low| low <= truth) && interval[1].is_none_or(|high| truth <= high)
        };
        let both = |pair: Option<IntervalPair>| {
            pair.map_or([false; 2], |pair| [holds(pair.interval_68), holds(pair.interval_95)])
        };
        let first = of_covariance.map(|(interval_68, interval_95)| IntervalPair { interval_68, interval_95 });
        covered[quantity] = Some([both(first), both(of_profile), both(of_posterior)]);
    }
    let count = posterior.samples.len();
    let ranks = (ranked && count > DRAWS).then(|| {
        std::array::from_fn(|parameter| {
            let draws = (0..DRAWS).map(|draw| &posterior.samples[(2 * draw + 1) * count / (2 * DRAWS)]);
            draws.filter(|draw| draw[parameter] < values[parameter]).count()
        })
    });
    Ok(Held { covered, ranks, converged: posterior.converged })
}

/// The table as CSV.
pub(crate) fn table(studies: &[Study], seed: u64) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!("# morpho-fit {version}, seed {seed}, noise {NOISE} of the peak\n");
    text.push_str("design,sets,quantity,determined,method,coverage_68_percent,coverage_95_percent,within_bands\n");
    for study in studies {
        for (quantity, name) in
            QUANTITIES.into_iter().enumerate().filter(|(q, _)| 2 * study.determined[*q] > study.sets)
        {
            for (method, word) in METHODS.into_iter().enumerate() {
                let [one, two] = study.coverage(quantity, method);
                let inside = |value: f64, band: (f64, f64)| (band.0..=band.1).contains(&value);
                let within = inside(one, BANDS[0]) && inside(two, BANDS[1]);
                let (design, sets, determined) = (study.design.name(), study.sets, study.determined[quantity]);
                let _ = writeln!(text, "{design},{sets},{name},{determined},{word},{one:.1},{two:.1},{within}");
            }
        }
    }
    text
}

/// The histograms of ranks as CSV.
pub(crate) fn ranks(study: &Study, seed: u64) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut text = format!(
        "# morpho-fit {version}, seed {seed}, design {}, {} data sets, ranks among {DRAWS} draws\n",
        study.design.name(),
        study.sets
    );
    let bins: Vec<String> = (1..=BINS).map(|bin| format!("bin_{bin}")).collect();
    let _ = writeln!(text, "parameter,chi2,probability,{}", bins.join(","));
    for parameter in Parameter::ALL {
        let (chi2, probability) = study.evenness(parameter.index());
        let counts: Vec<String> = study.ranks[parameter.index()].iter().map(usize::to_string).collect();
        let _ = writeln!(text, "{parameter},{chi2:.1},{probability:.3},{}", counts.join(","));
    }
    text
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let (mut sets, mut seed, mut out, mut designs) = (1000, 1, None, Design::ALL.to_vec());
    let mut arguments = std::env::args().skip(1);
    while let Some(flag) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{flag} needs a value"))?;
        match flag.as_str() {
            "--sets" => sets = value.parse()?,
            "--seed" => seed = value.parse()?,
            "--out" => out = Some(std::path::PathBuf::from(value)),
            "--design" => designs.retain(|design| design.name() == value),
            _ => return Err(format!("{flag} is none of --sets, --seed, --design, --out").into()),
        }
    }
    let studies: Vec<Study> = designs.into_iter().map(|design| study(design, sets, seed)).collect::<Result<_, _>>()?;
    let mut files = vec![("coverage.csv", table(&studies, seed))];
    files.extend(studies.iter().filter(|s| s.design == Design::W2).map(|study| ("ranks.csv", ranks(study, seed))));
    for (name, text) in files {
        println!("{text}");
        if let Some(folder) = &out {
            std::fs::create_dir_all(folder)?;
            std::fs::write(folder.join(name), text)?;
        }
    }
    for study in &studies {
        println!("{}: {} of {} posteriors not converged", study.design.name(), study.unconverged, study.sets);
    }
    Ok(())
}
