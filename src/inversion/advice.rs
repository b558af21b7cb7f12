//! What to measure next: the scans that would most improve what the data tell worst, and split what fits as well.
//!
//! ```text
//! wanted_j = max(5 % of the value, 2 % of the range)
//! m_j = max(sd_j, wanted_j / 4) / wanted_j
//! score = ln(worst m before / after) + mean_j ln(m_j before / after)
//! ```
//!
//! `sd` is expected from the normal equations of data and scan at the best minimum, the bounds as an even guess; minima
//! that fit as well count in it as structures of their own, each with the weight `exp(-chi²/2)` that the scan would leave
//! it. Where the data leave a direction open, all this is the mean over a few structures along it: what is best for one
//! of them may be blind for another. So a scan that splits an ambiguity and one that shortens an interval are measured by one number.

use crate::dataset::{Dataset, Findings};
use crate::inversion::candidates::candidates;
use crate::inversion::compiled::Compiled;
use crate::inversion::outcome::{Estimate, Fit, FitOutcome, Verdict};
use crate::inversion::parameter::Parameter;
use crate::inversion::prospect::{Prospect, ProspectError, Prospects, Quantity, Rival};
use crate::inversion::truth::truths;
use crate::optics::OpticsError;
use crate::optimise::BoundsError;
use crate::synthetic::Scan;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A standard deviation of this share of the value is good, ...
const OF_VALUE: f64 = 0.05;
/// ... or of this share of the bounds.
const OF_RANGE: f64 = 0.02;
/// What is better than wanted by this factor need not be better.
const CONTENT: f64 = 4.0;
/// Scans advised together at most.
const TOGETHER: usize = 3;
/// Proposals at most.
const PROPOSALS: usize = 3;
/// A scan with a lower score is not worth the trouble.
const WORTH: f64 = 0.05;
/// A simpler scan with so much of the best score is taken instead.
const NEARLY: f64 = 0.97;
/// Scans are enough if they are for so many of the structures that may be true: 3 of 4.
const MOST: (usize, usize) = (3, 4);
/// Readings at the same angles and wavelength, rad and nm.
const SAME: f64 = 1e-6;

/// Whether to advise where nothing is missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// Only if something free is not determined, ambiguous, on a bound or poorly known, and if the fit found a structure
    /// to plan with.
    IfNeeded,
    /// In any case.
    Always,
}

/// Scans to add, and what is expected of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The scans, in the order of their use; [`synthetic::simulate`](crate::synthetic::simulate) takes them.
    pub scans: Vec<Scan>,
    /// The same in words, with what they would tell.
    pub found: AdviceFound,
}

/// Scans to add, in words, and what is expected of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AdviceFound {
    /// The scans in words, in the order of their use.
    pub scans: Vec<String>,
    /// Whether data with these scans are expected to tell everything that is free.
    pub enough: bool,
    /// What gains most of the free parameters.
    pub gains_most: String,
    /// Free parameters, then `period` and `optical_sum`.
    pub expected: Vec<SigmaExpected>,
    /// Structures that fit as well now.
    pub splits: Vec<SplitExpected>,
}

/// How well a quantity is known now, and with the scans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SigmaExpected {
    /// Name of the quantity.
    pub name: String,
    /// nm, deg or rad.
    pub unit: String,
    /// Standard deviation now, other structures that fit as well included; 0.29 of the bounds for what is not told. The
    /// median over structures along the directions that the data leave open.
    pub before: f64,
    /// Standard deviation with the scans.
    pub after: f64,
}

/// A structure that fits as well now, and how it would with the scans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SplitExpected {
    /// Its five values, in the user's units and the order of the parameters.
    pub values: [f64; 5],
    /// Its chi² above that of the best now, in units of the noise.
    pub chi2_now: f64,
    /// The same with the scans, from an expansion about that structure: the order of size, not a number to test against.
    pub chi2_expected: f64,
}

/// Advice that could not be given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AdviceError {
    /// The data are not those of the fit.
    #[error("the fit is of {fitted} readings, but the data have {readings}")]
    OtherData {
        /// Readings in the data.
        readings: usize,
        /// Readings of the fit.
        fitted: usize,
    },
    /// The model has no value for the data.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// Bounds without room.
    #[error(transparent)]
    Bounds(#[from] BoundsError),
    /// The data and what is expected of a scan make no valid data set.
    #[error(transparent)]
    Data(#[from] Findings),
}

impl From<ProspectError> for AdviceError {
    fn from(error: ProspectError) -> Self {
        match error {
            ProspectError::Optics(error) => Self::Optics(error),
            ProspectError::Data(error) => Self::Data(error),
        }
    }
}

/// Scans that would tell most, the advised ones first; empty if nothing more is needed or no scan helps.
///
/// The first proposal has as many scans, up to three, as it takes to tell everything that is free; the others are the next
/// best with a single scan. Candidates are spectra from 380 to 740 nm near the mirror direction at four incidences, in both
/// planes, spectra of s and p polarization at 60°, and phi scans at several wavelengths and two incidences in three planes.
/// Those that the data hold already are left out. Where the thicknesses are open the first scan is a
/// spectrum, and the first across the ridges at one wavelength has the shortest. A new reading is taken to have the noise of the data, and the mean scale
/// and background of the curves; with a scale for each curve it has one of its own.
///
/// Standard deviations are as good as the derivatives at the best fit: where a direction is open they are a median over
/// five structures along it, and the fit that follows may differ by several times.
///
/// - `data`: what `fit` was fitted to.
///
/// # Errors
/// [`AdviceError`] if `data` are not those of the fit.
///
/// ```
/// use morpho_fit::inversion::{Ask, FitSettings, advise, fit};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let across = [Scan::angular(420.0, 0.0), Scan::angular(460.0, 0.0)];
/// let data = simulate(&BlendModel::default(), &Structure::blue(), &across, 1.0, 0.01, 1)?;
/// let found = fit(&data, &FitSettings::default(), &|_| {})?;
/// let advice = advise(&data, &found, Ask::IfNeeded)?;
/// // Nothing was seen along the ridges.
/// assert!(advice[0].found.scans.iter().any(|scan| !scan.contains("omega 0°")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn advise(data: &Dataset, fit: &Fit, ask: Ask) -> Result<Vec<Proposal>, AdviceError> {
    let outcome = &fit.outcome;
    if data.readings().len() != fit.readings.len() {
        return Err(AdviceError::OtherData { readings: data.readings().len(), fitted: fit.readings.len() });
    }
    if ask == Ask::IfNeeded && (is_good(outcome) || !has_structure(outcome)) {
        return Ok(Vec::new());
    }
    let model = outcome.settings.forward()?;
    let compiled = Compiled::new(data, &outcome.settings, model.as_ref())?;
    let truths = truths(&compiled, &fit.solution)?;
    let Some(best) = truths.first() else { return Ok(Vec::new()) };
    let mut scans = candidates(model.as_ref(), &best.values);
    let has_value = |scan: &Scan| truths.iter().all(|truth| truth.readings(scan, model.as_ref()).is_some());
    scans.retain(|scan| !is_in(scan, data) && has_value(scan));
    let prospects: Result<Vec<Prospects<'_>>, ProspectError> = (truths.iter())
        .map(|truth| {
            let rivals = Rival::of(&fit.solution, truth, best, fit.outcome.settings.level);
            Prospects::new(data, fit, model.as_ref(), truth, &scans, rivals)
        })
        .collect();
    let thickness = |(parameter, _): &(Parameter, f64)| matches!(parameter, Parameter::DAir | Parameter::DCuticle);
    let open = fit.solution.held.iter().flat_map(|held| &held.direction).any(thickness);
    Ok(propose(&prospects?, &scans, open))
}

/// Whether everything free is determined, and well.
pub(crate) fn is_good(outcome: &FitOutcome) -> bool {
    let good = |(name, estimate): (&str, &Estimate)| {
        let free = outcome.identifiability.free.iter().any(|free| free == name);
        let (Some(value), Some(sigma), Some([lower, upper])) = (estimate.value, estimate.sigma, estimate.bounds) else {
            return !free;
        };
        estimate.status.is_determined() && sigma <= wanted(value, upper - lower)
    };
    matches!(outcome.verdict, Verdict::Determined | Verdict::Given) && outcome.parameters.each().into_iter().all(good)
}

/// Whether the fit tells anything to plan with.
fn has_structure(outcome: &FitOutcome) -> bool {
    let free = |(name, _): &(&str, &Estimate)| outcome.identifiability.free.iter().any(|free| free == name);
    let told = |estimate: &Estimate| estimate.value.is_some();
    outcome.verdict != Verdict::NotConverged
        && (outcome.parameters.each().into_iter().filter(free).any(|(_, estimate)| told(estimate))
            || [&outcome.derived.period, &outcome.derived.optical_sum].into_iter().any(told))
}

/// The standard deviation that is good enough.
fn wanted(value: f64, range: f64) -> f64 {
    (OF_VALUE * value.abs()).max(OF_RANGE * range)
}

/// Whether the data hold every reading of a scan.
fn is_in(scan: &Scan, data: &Dataset) -> bool {
    let near = |values: &[f64], value: f64| values.iter().any(|other| (other - value).abs() < SAME);
    let readings = data.readings().iter().filter(|reading| {
        reading.polarization == scan.polarization
            && near(&scan.omegas, reading.geometry.omega)
            && near(&scan.thetas, reading.geometry.theta)
    });
    let held: Vec<(f64, f64)> = readings.map(|reading| (reading.wavelength, reading.geometry.phi)).collect();
    scan.wavelengths.iter().all(|line| {
        let at: Vec<f64> = held.iter().filter(|(other, _)| (other - line).abs() < SAME).map(|(_, phi)| *phi).collect();
        scan.phis.iter().all(|phi| near(&at, *phi))
    })
}

/// What is expected of a set of scans, for each structure that may be the true one, the best first.
type Outlook = Vec<Prospect>;

/// A set of scans.
struct Choice {
    scans: Vec<usize>,
    score: f64,
    outlook: Outlook,
}

fn outlook(prospects: &[Prospects<'_>], scans: &[usize]) -> Option<Outlook> {
    prospects.iter().map(|prospects| prospects.with(scans)).collect()
}

/// Whether a scan lies in the plane along the ridges, where the lamellae are not seen.
fn is_along(scan: &Scan) -> bool {
    scan.omegas.iter().all(|omega| omega.cos().powi(2) < 1e-9)
}

/// Proposals for scans to choose from; where the thicknesses are `open` the first is a spectrum: at one wavelength many
/// of them give the same colour, far beyond what derivatives at one structure show.
fn propose(prospects: &[Prospects<'_>], scans: &[Scan], open: bool) -> Vec<Proposal> {
    let Some(before) = outlook(prospects, &[]) else { return Vec::new() };
    // Across the ridges one wavelength may miss every order of a period that is not known: the shortest misses the fewest.
    let line = |scan: &Scan| match scan.wavelengths.as_slice() {
        [line] if !is_along(scan) => Some(*line),
        _ => None,
    };
    let shortest = scans.iter().filter_map(line).fold(f64::INFINITY, f64::min);
    let sure = |scan: &Scan| line(scan).is_none_or(|line| line <= shortest);
    let all: Vec<usize> = (0..scans.len()).collect();
    let sure: Vec<usize> = all.iter().copied().filter(|&scan| !open || sure(&scans[scan])).collect();
    let is_spectrum = |scan: &usize| scans.get(*scan).is_some_and(|scan| scan.wavelengths.len() > 1);
    let first: Vec<usize> = all.iter().copied().filter(|scan| !open || is_spectrum(scan)).collect();
    let singles = extended(prospects, &before, &[], &first);
    let Some(first) = singles.first() else { return Vec::new() };
    let (mut together, mut expected) = (first.scans.clone(), first.outlook.clone());
    while together.len() < TOGETHER && !is_enough(prospects, &expected) {
        let is_across = |scan: &usize| scans.get(*scan).is_some_and(|scan| !is_along(scan));
        let from = if together.iter().any(is_across) { &all } else { &sure };
        let Some(next) = extended(prospects, &expected, &together, from).into_iter().next() else { break };
        (together, expected) = (next.scans, next.outlook);
    }
    let best = (together.len() > 1).then_some((together, expected));
    let singles = singles.into_iter().map(|single| (single.scans, single.outlook));
    let proposal = |(chosen, after): (Vec<usize>, Outlook)| Proposal {
        scans: chosen.iter().filter_map(|&scan| scans.get(scan).cloned()).collect(),
        found: found(prospects, scans, &chosen, &before, &after),
    };
    best.into_iter().chain(singles).take(PROPOSALS).map(proposal).collect()
}

/// The sets that one more scan makes of `chosen`, the best first, where it is worth it.
fn extended(prospects: &[Prospects<'_>], before: &Outlook, chosen: &[usize], from: &[usize]) -> Vec<Choice> {
    let with = |&scan: &usize| {
        if chosen.contains(&scan) {
            return None;
        }
        let scans: Vec<usize> = chosen.iter().copied().chain([scan]).collect();
        let outlook = outlook(prospects, &scans)?;
        let score = score(prospects, before, &outlook);
        (score > WORTH).then_some(Choice { scans, score, outlook })
    };
    let mut rest: Vec<Choice> = from.par_iter().filter_map(with).collect();
    let mut ordered = Vec::new();
    while ordered.len() < PROPOSALS {
        let best = rest.iter().map(|choice| choice.score).fold(0.0, f64::max);
        let Some(place) = rest.iter().position(|choice| choice.score >= NEARLY * best) else { break };
        ordered.push(rest.remove(place));
    }
    ordered
}

/// Free parameters with their place among the quantities and the standard deviation that is wanted.
fn free<'a>(prospects: &'a Prospects<'_>) -> impl Iterator<Item = (usize, &'a Quantity, f64)> {
    let all = prospects.quantities.iter().enumerate();
    all.filter_map(|(place, quantity)| Some((place, quantity, wanted(quantity.value, quantity.range?))))
}

/// Whether everything is told for most of the structures.
fn is_enough(prospects: &[Prospects<'_>], outlook: &Outlook) -> bool {
    let told = |(prospects, prospect): &(&Prospects<'_>, &Prospect)| {
        free(prospects).all(|(place, _, wanted)| prospect.spreads[place] <= wanted)
    };
    let count = prospects.iter().zip(outlook).filter(told).count();
    MOST.0 * prospects.len() <= MOST.1 * count
}

/// The mean over the structures.
fn score(prospects: &[Prospects<'_>], before: &Outlook, after: &Outlook) -> f64 {
    let each = prospects.iter().zip(before.iter().zip(after));
    #[allow(clippy::cast_precision_loss, reason = "a handful of structures")]
    let count = prospects.len().max(1) as f64;
    each.map(|(prospects, (before, after))| score_of_one(prospects, before, after)).sum::<f64>() / count
}

fn score_of_one(prospects: &Prospects<'_>, before: &Prospect, after: &Prospect) -> f64 {
    let (mut worst, mut sum, mut count) = ((0.0_f64, 0.0_f64), 0.0, 0.0_f64);
    for (place, _, wanted) in free(prospects) {
        let of = |prospect: &Prospect| (prospect.spreads[place] / wanted).max(1.0 / CONTENT);
        let (old, new) = (of(before), of(after));
        worst = (worst.0.max(old), worst.1.max(new));
        sum += (old / new).ln();
        count += 1.0;
    }
    if count > 0.0 { (worst.0 / worst.1).ln() + sum / count } else { 0.0 }
}

/// The median over the structures of one quantity's standard deviation.
fn median(outlook: &Outlook, place: usize) -> f64 {
    let mut spreads: Vec<f64> = outlook.iter().map(|prospect| prospect.spreads[place]).collect();
    spreads.sort_by(f64::total_cmp);
    spreads.get(spreads.len() / 2).copied().unwrap_or_default()
}

fn found(
    prospects: &[Prospects<'_>],
    scans: &[Scan],
    chosen: &[usize],
    before: &Outlook,
    after: &Outlook,
) -> AdviceFound {
    let enough = is_enough(prospects, after);
    let scans = chosen.iter().filter_map(|&scan| scans.get(scan)).map(|scan| scan.name.clone()).collect();
    let mut found = AdviceFound { scans, enough, gains_most: String::new(), expected: Vec::new(), splits: Vec::new() };
    let (Some(best), Some(expected)) = (prospects.first(), after.first()) else { return found };
    let gain = |place: usize| median(before, place) / median(after, place);
    let most = free(best).max_by(|a, b| gain(a.0).total_cmp(&gain(b.0)));
    found.gains_most = most.map_or_else(String::new, |(_, quantity, _)| quantity.name.to_owned());
    let sigma = |(place, quantity): (usize, &Quantity)| SigmaExpected {
        name: quantity.name.to_owned(),
        unit: quantity.unit.to_owned(),
        before: median(before, place) * quantity.outside,
        after: median(after, place) * quantity.outside,
    };
    found.expected = best.quantities.iter().enumerate().map(sigma).collect();
    let split = |(rival, chi2_expected): (&Rival, &f64)| SplitExpected {
        values: rival.outside(),
        chi2_now: rival.seen,
        chi2_expected: *chi2_expected,
    };
    found.splits = best.rivals.iter().zip(&expected.rivals).map(split).collect();
    found
}
