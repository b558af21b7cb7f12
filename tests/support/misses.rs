//! Data that a model misses: simulated with another, fitted by plain `blend`, and how often intervals hold the truth.

use super::disorder::Disordered;
use morpho_fit::dataset::{Dataset, Reading};
use morpho_fit::inversion::{Estimate, FitOutcome, FitSettings, Parameter, SigmaSource, Verdict, fit, structure};
use morpho_fit::optics::{BlendModel, PaperModel, ReflectivityModel, Structure};
use morpho_fit::optimise::Bounds;
use morpho_fit::synthetic::{Scan, linspace, simulate};
use morpho_fit::units::radians;
use rayon::prelude::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Standard deviation of a layer's thickness, nm.
const DISORDER: f64 = 10.0;
/// Stacks in an incoherent mean.
const STACKS: usize = 100;
/// Noise as a share of the largest reading.
const NOISE: f64 = 0.01;
/// Index of the cuticle, which in `blend` is the same at every wavelength.
const N_CUTICLE: f64 = 1.56;

/// What makes the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The model of the fit: the control.
    Blend,
    /// The paper's formulas: mean admittance, Snell's law the right way up.
    Paper,
    /// Layers drawn by themselves, the mean over many stacks.
    Ensemble,
    /// Layers drawn by themselves, one stack.
    Single,
}

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Design {
    /// [`Scan::full_design`].
    Full,
    /// Spectra at 0, 15, 30, 45, 60 degrees in the mirror direction, along the ridges.
    Angles,
    /// A spectrum and four scans of the viewing angle, at incidence up to 60 degrees, along the ridges.
    Scans,
}

/// One fit beside its truth.
#[derive(Debug, Clone)]
pub struct Case {
    pub truth: Structure,
    /// Which of its source and design it is.
    pub number: u64,
    pub outcome: FitOutcome,
}

/// Truths evenly over the default bounds.
fn truths(count: usize) -> Vec<Structure> {
    let (lower, upper): (Vec<f64>, Vec<f64>) =
        Parameter::ALL.iter().map(|parameter| parameter.default_bounds()).unzip();
    let points = Bounds::new(&lower, &upper).unwrap().latin_hypercube(count, 29);
    points.iter().map(|point| structure(&[point[0], point[1], point[2], point[3], point[4]])).collect()
}

fn scans(design: Design, model: &dyn ReflectivityModel, truth: &Structure) -> Vec<Scan> {
    let mirror = |theta: f64| Scan {
        name: format!("spectrum at theta {theta}"),
        thetas: vec![radians(theta)],
        phis: vec![radians(-theta)],
        ..Scan::spectrum(90.0)
    };
    match design {
        Design::Full => Scan::full_design(model, truth).unwrap(),
        Design::Angles => [0.0, 15.0, 30.0, 45.0, 60.0].map(mirror).to_vec(),
        Design::Scans => {
            let about = |(wavelength, theta): (f64, f64)| Scan {
                name: format!("{wavelength} nm at theta {theta}"),
                thetas: vec![radians(theta)],
                phis: linspace((-theta - 40.0).max(-85.0), 40.0 - theta, 41).into_iter().map(radians).collect(),
                ..Scan::angular(wavelength, 90.0)
            };
            let angular = [(450.0, 0.0), (550.0, 0.0), (450.0, 30.0), (550.0, 60.0)].map(about);
            std::iter::once(mirror(0.0)).chain(angular).collect()
        }
    }
}

/// Data with noise of `noise` times the largest reading.
fn data(source: Source, design: Design, truth: &Structure, case: u64, noise: f64) -> Dataset {
    let model: Box<dyn ReflectivityModel> = match source {
        Source::Blend => Box::new(BlendModel::default()),
        Source::Paper => Box::new(PaperModel::default()),
        Source::Ensemble => Box::new(Disordered::ensemble(DISORDER, STACKS, 1000 + case)),
        Source::Single => Box::new(Disordered::single(DISORDER, 5000 + case)),
    };
    simulate(model.as_ref(), truth, &scans(design, model.as_ref(), truth), 1.0, noise, case).unwrap()
}

/// Simulates and fits `count` cases.
pub fn cases(source: Source, design: Design, count: usize) -> Vec<Case> {
    (truths(count).into_par_iter().enumerate())
        .map(|(case, truth)| {
            let data = data(source, design, &truth, case as u64, NOISE);
            let outcome = fit(&data, &FitSettings::default(), &|_| {}).unwrap().outcome;
            Case { truth, number: case as u64, outcome }
        })
        .collect()
}

/// What the model misses without noise, in the unit of the noise: chi² of a fit to the same readings without it, beside the
/// standard deviation of chi² of noise alone.
pub fn misfit_without_noise(source: Source, design: Design, case: &Case) -> (f64, f64) {
    let bare = data(source, design, &case.truth, case.number, 0.0);
    let sigma = data(source, design, &case.truth, case.number, NOISE).readings()[0].sigma;
    let with_sigma = |reading: &Reading| Reading { sigma, ..*reading };
    let readings = bare.readings().iter().map(with_sigma).collect();
    let bare = Dataset::from_readings(readings, bare.curves().to_vec()).unwrap();
    let outcome = fit(&bare, &FitSettings::default(), &|_| {}).unwrap().outcome;
    #[allow(clippy::cast_precision_loss, reason = "a count of readings is small")]
    (outcome.chi2, (2.0 * outcome.dof as f64).sqrt())
}

/// The quantities that are judged: name, estimate and truth.
fn quantities(case: &Case) -> [(&'static str, &Estimate, f64); 4] {
    let (outcome, truth) = (&case.outcome, &case.truth);
    [
        ("period", &outcome.derived.period, truth.period()),
        ("optical sum", &outcome.derived.optical_sum, truth.d_air + N_CUTICLE * truth.d_cuticle),
        ("d_air", &outcome.parameters.d_air, truth.d_air),
        ("d_cuticle", &outcome.parameters.d_cuticle, truth.d_cuticle),
    ]
}

/// How often the printed intervals of a quantity hold its truth.
#[derive(Debug, Clone)]
pub struct Coverage {
    pub name: &'static str,
    /// Cases in which an interval is printed.
    pub printed: usize,
    pub within_68: usize,
    pub within_95: usize,
    /// Medians: standard deviation, error, and error in standard deviations.
    pub sigma: f64,
    pub error: f64,
    pub ratio: f64,
}

/// Whether the model is said to miss the data, first of all.
pub fn is_flagged(case: &Case) -> bool {
    let said = case.outcome.warnings.first().is_some_and(|warning| warning.starts_with("the model misses the data"));
    said && case.outcome.sigma_source == SigmaSource::Widened
}

/// Whether the fit names no thickness.
pub fn is_refused(case: &Case) -> bool {
    matches!(case.outcome.verdict, Verdict::NoThickness | Verdict::NotConverged)
}

fn holds(interval: Option<[Option<f64>; 2]>, truth: f64) -> bool {
    interval.is_some_and(|[low, high]| low.is_none_or(|low| low <= truth) && high.is_none_or(|high| truth <= high))
}

pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Coverage of the four quantities.
pub fn coverage(cases: &[&Case]) -> Vec<Coverage> {
    (0..4)
        .map(|which| {
            let all: Vec<_> = cases.iter().map(|case| quantities(case)[which]).collect();
            let printed: Vec<_> = all.iter().filter(|(_, e, _)| e.value.is_some() && e.interval_95.is_some()).collect();
            let errors =
                || printed.iter().filter_map(|(_, e, truth)| e.value.zip(e.sigma).map(|(v, s)| (s, (v - truth).abs())));
            Coverage {
                name: ["period", "optical sum", "d_air", "d_cuticle"][which],
                printed: printed.len(),
                within_68: printed.iter().filter(|(_, e, truth)| holds(e.interval_68, *truth)).count(),
                within_95: printed.iter().filter(|(_, e, truth)| holds(e.interval_95, *truth)).count(),
                sigma: median(errors().map(|(sigma, _)| sigma).collect()),
                error: median(errors().map(|(_, error)| error).collect()),
                ratio: median(errors().map(|(sigma, error)| error / sigma).collect()),
            }
        })
        .collect()
}
