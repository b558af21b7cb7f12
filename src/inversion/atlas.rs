//! The ambiguity atlas: which other structures fit, how they are related to the best, and how likely each is.

use crate::dataset::Dataset;
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::FitError;
use crate::inversion::outcome::{Fit, MinimumFound};
use crate::inversion::parameter::{COUNT, Parameter, Role, outside};
use crate::inversion::problem::Problem;
use crate::inversion::search::{self, COARSE, Cell};
use crate::inversion::space::Space;
use crate::optimise::{LeastSquares, Minimum, minimise};
use crate::uncertainty::covariance::regularised;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

/// Minima that are listed even if they do not fit.
const LISTED: usize = 10;
/// Minima that are listed at most.
const MOST: usize = 100;
/// Two thicknesses within this many nm, ...
const NEAR_NM: f64 = 5.0;
/// ... or this share of the sum of the layers, are of one kind.
const NEAR: f64 = 0.03;
/// A tilt below this is none to mirror, rad.
const UPRIGHT: f64 = 1e-3;
/// A ratio of two optical sums within this share of that of two orders is one of orders.
const ORDER: f64 = 0.03;
/// Minima within this Δchi² of the best are tied, ...
const TIED: f64 = 1e-3;
/// ... and one that is likelier by this factor goes first.
const LIKELIER: f64 = 1.5;
/// Readings that a map looks at.
const MAP_READINGS: usize = 240;
/// The same of a model that averages.
const DEAR_READINGS: usize = 80;
/// One cell in so many, the best ones, is polished.
const POLISHED: usize = 6;

/// How another minimum is related to the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Relation {
    /// It is the best.
    Best,
    /// The same layers, tilted the other way.
    Mirror,
    /// Gap and cuticle have each other's optical thickness: `(d_air, d_cuticle)` and `(n d_cuticle, d_air / n)`.
    Swap,
    /// Both.
    SwapAndMirror,
    /// The same optical sum, and so the same Bragg wavelength, with another split.
    Split,
    /// The optical sums are as two orders of interference that reflect one wavelength.
    Order {
        /// Order of the best.
        best: u8,
        /// Order of this one.
        other: u8,
    },
    /// The same layers; tilt, lobe or lamella width differ.
    SameLayers,
    /// None of these.
    Other,
}

impl Relation {
    /// The relation in words.
    #[must_use]
    pub fn phrase(self) -> String {
        match self {
            Self::Best => "the best".to_owned(),
            Self::Mirror => "mirror image in delta".to_owned(),
            Self::Swap => "swap alias (thicknesses exchanged)".to_owned(),
            Self::SwapAndMirror => "swap alias, tilted the other way".to_owned(),
            Self::Split => "same optical sum, another split".to_owned(),
            Self::Order { best, other } => {
                format!("interference order {other}, not {best}")
            }
            Self::SameLayers => "same layers, other tilt or widths".to_owned(),
            Self::Other => "another structure".to_owned(),
        }
    }

    /// The relation of `other` to `best`, inside units; `indices` of gap and cuticle.
    ///
    /// The minimum next to an exact alias is a little off it: a finite stack tells a half of the difference.
    pub(crate) fn of(best: &[f64; COUNT], other: &[f64; COUNT], (gap, cuticle): (f64, f64)) -> Self {
        let near = |layers: (f64, f64)| {
            let most = NEAR_NM.max(NEAR * (best[0] + best[1]));
            (other[0] - layers.0).abs() < most && (other[1] - layers.1).abs() < most
        };
        let tilted = best[2].abs() > UPRIGHT && (other[2] + best[2]).abs() < 0.5 * best[2].abs();
        if near((best[0], best[1])) {
            return if tilted { Self::Mirror } else { Self::SameLayers };
        }
        if near((cuticle * best[1] / gap, gap * best[0] / cuticle)) {
            return if tilted { Self::SwapAndMirror } else { Self::Swap };
        }
        let sum = |values: &[f64; COUNT]| gap * values[0] + cuticle * values[1];
        let ratio = sum(other) / sum(best);
        let is_near = |wanted: f64| (ratio / wanted - 1.0).abs() < ORDER;
        if is_near(1.0) {
            return Self::Split;
        }
        for best in 1..=4_u8 {
            for other in (1..=4_u8).filter(|&other| other != best) {
                if is_near(f64::from(other) / f64::from(best)) {
                    return Self::Order { best, other };
                }
            }
        }
        Self::Other
    }
}

/// The normal approximation of the posterior about a minimum: its covariance, the bounds counting as a normal prior of their
/// spread, and the logarithm of its share, up to what all have in common.
pub(crate) fn laplace(
    minimum: &Minimum,
    best: &Minimum,
    ranges: &DVector<f64>,
    unit: f64,
) -> Option<(DMatrix<f64>, f64)> {
    let covariance = regularised(&(&minimum.triangle / unit), ranges)?;
    let volume: f64 = covariance.clone().cholesky()?.l().diagonal().iter().map(|side| side.ln()).sum();
    let behind = (minimum.sum_of_squares - best.sum_of_squares) / (unit * unit);
    Some((covariance, volume - 0.5 * behind))
}

/// Shares of the posterior about each of `minima`, from the curvature of each; of one common unit.
///
/// ```text
/// share ~ exp(-chi²/(2 unit²)) sqrt(det C),   C = (J'J/unit² + 12 diag(range)⁻²)⁻¹
/// ```
///
/// # Source
/// Laplace's approximation: Tierney and Kadane 1986, DOI 10.1080/01621459.1986.10478240.
pub(crate) fn weights(minima: &[Minimum], ranges: &DVector<f64>, unit: f64) -> Vec<f64> {
    let Some(best) = minima.first() else { return Vec::new() };
    if let [only] = minima {
        // All of it, if there is a curvature at all.
        return vec![if only.triangle.iter().all(|value| value.is_finite()) { 1.0 } else { 0.0 }];
    }
    let logarithm = |minimum: &Minimum| laplace(minimum, best, ranges, unit).map(|(_, logarithm)| logarithm);
    let all: Vec<f64> = minima.iter().map(|minimum| logarithm(minimum).unwrap_or(f64::NEG_INFINITY)).collect();
    let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !most.is_finite() {
        return vec![0.0; minima.len()];
    }
    let shares: Vec<f64> = all.iter().map(|one| (one - most).exp()).collect();
    let sum: f64 = shares.iter().sum();
    shares.iter().map(|share| share / sum).collect()
}

/// Puts the likeliest of the minima that fit exactly as well first: which of them is lower is rounding.
pub(crate) fn likeliest_first(minima: &mut [Minimum], ranges: &DVector<f64>, unit: f64) {
    let best = minima.first().map_or(0.0, |minimum| minimum.sum_of_squares);
    let tied = minima.iter().take_while(|one| one.sum_of_squares - best <= TIED * unit * unit).count();
    if tied < 2 {
        return;
    }
    let weights = weights(&minima[..tied], ranges, unit);
    let first = weights.first().copied().unwrap_or(0.0);
    let likeliest = (weights.iter().enumerate()).max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
    if let Some((place, _)) = likeliest.filter(|(_, weight)| **weight > LIKELIER * first) {
        minima[..=place].rotate_right(1);
    }
}

/// The minima as they are reported: all within `level` of the best, and the next few.
pub(crate) fn listed(
    minima: &[Minimum],
    space: &Space,
    unit: f64,
    level: f64,
    indices: (f64, f64),
) -> Vec<MinimumFound> {
    let Some(first) = minima.first() else { return Vec::new() };
    let best = space.freedom.expand(&first.parameters);
    let weights = weights(minima, &space.ranges, unit);
    let of = |(place, (minimum, weight)): (usize, (&Minimum, f64))| {
        let values = space.freedom.expand(&minimum.parameters);
        let delta_chi2 = (minimum.sum_of_squares - first.sum_of_squares) / (unit * unit);
        MinimumFound {
            chi2: minimum.sum_of_squares,
            delta_chi2,
            fits: delta_chi2 <= level,
            weight,
            relation: if place == 0 { Relation::Best } else { Relation::of(&best, &values, indices) },
            values: outside(&values),
            termination: minimum.termination,
        }
    };
    let all = minima.iter().zip(weights).enumerate().map(of);
    all.enumerate().take(MOST).filter(|(place, minimum)| *place < LISTED || minimum.fits).map(|(_, one)| one).collect()
}

/// The least chi² over the two thicknesses, everything else at its best.
#[derive(Debug, Clone, PartialEq)]
pub struct ChiSquareMap {
    /// Edges of the cells in `d_air`, nm, rising.
    pub d_air_edges: Vec<f64>,
    /// Edges of the cells in `d_cuticle`, nm, rising.
    pub d_cuticle_edges: Vec<f64>,
    /// Least Δchi² to the best minimum within each cell, for all readings, in units of the squared standard deviation of a
    /// weighted residual, `[d_cuticle][d_air]`; infinite where the model has no value.
    pub excess: Vec<Vec<f64>>,
}

/// The map of chi² over the bounds of the two thicknesses, in `cells` by `cells` cells; `None` unless both were searched.
///
/// A cell shows chi² at its middle with the best of the other parameters on a grid, and the best sixth of the cells the
/// least chi² within, as a run of the solver finds it. The map looks at some 240 readings; Δchi² is brought to the number
/// of all. Of a model that averages, each value of which is dear, it has half as many cells each way and looks at some 80.
///
/// # Errors
/// [`FitError`] if `data` are not those of `fit`.
pub fn chi_square_map(data: &Dataset, fit: &Fit, cells: usize) -> Result<Option<ChiSquareMap>, FitError> {
    let settings = &fit.outcome.settings;
    let model = settings.forward()?;
    let whole = Compiled::of_fit(data, fit, model.as_ref())?;
    let roles = settings.roles;
    let (Role::Free { lower: low_air, upper: high_air }, Role::Free { lower: low_cuticle, upper: high_cuticle }) =
        (roles[Parameter::DAir.index()], roles[Parameter::DCuticle.index()])
    else {
        return Ok(None);
    };
    let (readings, cells) = if model.is_average() { (DEAR_READINGS, cells / 2) } else { (MAP_READINGS, cells) };
    let thin = Compiled::thinned(data, settings, model.as_ref(), readings)?;
    let cells = cells.clamp(2, 400);
    #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
    let edges = |low: f64, high: f64| -> Vec<f64> {
        (0..=cells).map(|edge| low + (high - low) * edge as f64 / cells as f64).collect()
    };
    let (d_air_edges, d_cuticle_edges) = (edges(low_air, high_air), edges(low_cuticle, high_cuticle));
    let solution = &fit.solution;
    let best = &solution.minima[0];
    let at_best = Problem::new(&thin, &solution.searched, &[]);
    let reference = at_best.residuals(&best.parameters).norm_squared();
    #[allow(clippy::cast_precision_loss, reason = "counts of readings are below 2^53")]
    let factor = whole.plan.len() as f64 / thin.plan.len().max(1) as f64 / (solution.unit * solution.unit);
    let corners: Vec<[f64; 4]> = (d_cuticle_edges.windows(2))
        .flat_map(|cuticle| d_air_edges.windows(2).map(move |air| [air[0], air[1], cuticle[0], cuticle[1]]))
        .collect();
    let middles: Vec<Vec<f64>> = corners.iter().map(|c| vec![0.5 * (c[0] + c[1]), 0.5 * (c[2] + c[3])]).collect();
    let grid = search::best_of_the_rest(&solution.searched, &thin.plan, &thin.linear, &middles);
    let mut costs: Vec<f64> = grid.iter().map(|cell| cell.cost).collect();
    costs.sort_by(f64::total_cmp);
    let polished = costs.get(costs.len() / POLISHED).copied().unwrap_or(f64::INFINITY);
    let jobs: Vec<([f64; 4], Cell)> = corners.into_iter().zip(grid).collect();
    // With the other parameters of the best fit, too: where no thickness matters their grid is too coarse for all cells.
    let beside = |corner: &[f64; 4]| -> Option<f64> {
        let free = &solution.searched.freedom.free;
        let place = |parameter: Parameter| free.iter().position(|other| *other == parameter);
        let mut moved = best.parameters.clone();
        moved[place(Parameter::DAir)?] = 0.5 * (corner[0] + corner[1]);
        moved[place(Parameter::DCuticle)?] = 0.5 * (corner[2] + corner[3]);
        let cost = Problem::new(&thin, &solution.searched, &[]).residuals(&moved).norm_squared();
        cost.is_finite().then_some(cost)
    };
    let least = |(corner, cell): &([f64; 4], Cell)| {
        let excess = |cost: f64| ((cost - reference) * factor).max(0.0);
        let moved = beside(corner).unwrap_or(f64::INFINITY);
        if !cell.cost.is_finite() || cell.cost > polished {
            return excess(cell.cost.min(moved));
        }
        let mut roles = roles;
        roles[Parameter::DAir.index()] = Role::Free { lower: corner[0], upper: corner[1] };
        roles[Parameter::DCuticle.index()] = Role::Free { lower: corner[2], upper: corner[3] };
        let Ok(space) = Space::new(&roles) else { return excess(cell.cost) };
        let problem = Problem::new(&thin, &space, &[]);
        let found = minimise(&problem, &space.bounds.clamp(&space.freedom.restrict(&cell.values)), COARSE);
        excess(found.sum_of_squares.min(cell.cost).min(moved))
    };
    let flat: Vec<f64> = jobs.par_iter().map(least).collect();
    let excess = flat.chunks(cells).map(<[f64]>::to_vec).collect();
    Ok(Some(ChiSquareMap { d_air_edges, d_cuticle_edges, excess }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relations_are_named() {
        let best = [141.0, 62.0, 0.04, 0.5, 300.0];
        let indices = (1.0, 1.56);
        let of = |d_air, d_cuticle, delta| Relation::of(&best, &[d_air, d_cuticle, delta, 0.5, 300.0], indices);
        assert_eq!(of(98.0, 89.0, 0.04), Relation::Swap); // the swap alias of a blue Morpho
        assert_eq!(of(98.0, 89.0, -0.04), Relation::SwapAndMirror);
        assert_eq!(of(141.0, 62.0, -0.04), Relation::Mirror);
        assert_eq!(of(141.0, 62.0, 0.01), Relation::SameLayers);
        assert_eq!(of(200.0, 24.2, 0.04), Relation::Split);
        assert_eq!(of(275.0, 128.5, 0.04), Relation::Order { best: 1, other: 2 });
        assert_eq!(of(50.0, 110.0, 0.04), Relation::Other);
        assert_eq!(
            Relation::of(&[141.0, 62.0, 0.0, 0.5, 300.0], &[141.0, 62.0, 0.0, 0.5, 310.0], indices),
            Relation::SameLayers
        );
    }
}
