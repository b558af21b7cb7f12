//! The global stage: a grid over the bounds, the swap partners of its best cells, and a polish of each.
//!
//! The landscape has 15 to 50 minima in a box of 20–300 nm, and a minimum is as narrow as a fringe of the spectrum. The
//! grid samples it several times a fringe with the linear nuisances eliminated; the solver does the rest.

use crate::inversion::compiled::Compiled;
use crate::inversion::nuisance::LinearPart;
use crate::inversion::parameter::{COUNT, Parameter, inside};
use crate::inversion::plan::Plan;
use crate::inversion::problem::Problem;
use crate::inversion::screening::{OfLobe, OfPart, OfStack, Screening};
use crate::inversion::settings::FitSettings;
use crate::inversion::space::Space;
use crate::optimise::{Minimum, Tolerances, merge_equal, merge_near, multistart};
use crate::uncertainty::goodness::excess;
use lobes::other_lobes;
use nalgebra::DVector;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use rustc_hash::FxHashMap;

mod lobes;

/// Spacing of the grid in each thickness, nm. A fringe of nine layers is about 40 nm of thickness wide; at 28 nm one
/// truth in a few hundred is missed, below 10 nm the grid costs more than all polishing.
const THICKNESS_STEP: f64 = 14.0;
/// Cells of thickness at most; wider bounds get a coarser grid.
const MAX_CELLS: usize = 6000;
/// Tilts, lobe widths and lamella widths on the grid; the widths evenly on a logarithmic scale.
const COARSER: [usize; 3] = [5, 3, 4];
/// Cells polished.
const POLISHED: usize = 24;
/// Of these the best, whose swap partners are polished too.
const SWAPPED: usize = 8;
/// Random starts beside the grid, against structure in the landscape that follows the grid.
const RANDOM: usize = 8;
/// Minima of the first polish that are refined on all data.
const REFINED: usize = 10;

/// Of these, so many are refined however bad they are.
const ALWAYS_REFINED: usize = 3;
/// A rough minimum with so many times the sum of squares of the best is not refined.
const HOPELESS: f64 = 3.0;

/// Refined minima nearer than this share of a change that matters are one: the kinks of the lobe at its edges leave
/// several little ones about each.
pub(crate) const APART: f64 = 0.2;
/// Inner grid of the cells that are polished: tilts, lobe widths, lamella widths.
const FINER: [usize; 3] = [9, 4, 4];
/// Mirror images in the tilt are polished for so many of the best cells: many designs cannot tell its sign.
const MIRRORED: usize = 4;

/// A best minimum whose chi² exceeds the stated noise by so many standard deviations may not be the best; noise alone
/// does so in one data set of 200.
const SUSPICIOUS: f64 = 2.6;
/// Then the search goes on, so many times as deep, as it does where the data leave something open.
const DEEPER: usize = 6;

/// Of the best minima so many are looked at with other lobes, then.
const LOBES: usize = 4;

/// Tolerances of the first polish: enough to rank the minima.
pub(crate) const COARSE: Tolerances =
    Tolerances { cost: 1e-4, step: 1e-5, gradient: 1e-8, max_evaluations: 60, escapes: 0 };
/// Tolerances of the last: the cost to 1e-10 of itself, far below what noise can tell.
pub(crate) const FINE: Tolerances =
    Tolerances { cost: 1e-10, step: 1e-10, gradient: 1e-13, max_evaluations: 400, escapes: 20 };

/// Minima of the whole box, by way of thinned readings, in up to two rounds.
pub(crate) struct GlobalSearch<'a> {
    compiled: &'a Compiled<'a>,
    thin: &'a Compiled<'a>,
    space: &'a Space,
    cells: Vec<Cell>,
    /// Where runs began.
    begun: Vec<DVector<f64>>,
    /// Where they ended, on the thinned readings.
    rough: Vec<Minimum>,
    refined: Vec<DVector<f64>>,
    found: Vec<Minimum>,
    is_deep: bool,
}

impl<'a> GlobalSearch<'a> {
    /// Scans the grid, and polishes its best cells; once more, deeper, if the best minimum is suspicious.
    pub(crate) fn new(
        compiled: &'a Compiled<'a>,
        thin: &'a Compiled<'a>,
        space: &'a Space,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Self {
        progress("searching the grid");
        let cells = grid(space, &thin.plan, &thin.linear);
        let (begun, rough, refined, found) = Default::default();
        let mut search = Self { compiled, thin, space, cells, begun, rough, refined, found, is_deep: false };
        search.round(1, progress);
        let best = search.found.iter().map(|minimum| minimum.sum_of_squares).fold(f64::INFINITY, f64::min);
        let dof = compiled.plan.len().saturating_sub(space.freedom.free.len());
        if compiled.data.has_sigma() && excess(best, dof) >= SUSPICIOUS {
            search.deepen(progress);
        }
        search
    }

    /// Polishes more of the cells; returns whether it had not yet.
    pub(crate) fn deepen(&mut self, progress: &(dyn Fn(&str) + Sync)) -> bool {
        let is_new = !std::mem::replace(&mut self.is_deep, true);
        if is_new {
            self.round(DEEPER, progress);
            let known = merge_near(self.found.clone(), &self.space.scales, APART);
            let best = known.iter().take(LOBES);
            let other = best.flat_map(|minimum| other_lobes(self.compiled, self.space, minimum));
            self.found.extend(other);
        }
        is_new
    }

    /// Polishes `effort` times as many cells as usual, where it has not begun yet.
    fn round(&mut self, effort: usize, progress: &(dyn Fn(&str) + Sync)) {
        let Self { compiled, thin, space, .. } = *self;
        let mut starts = starts_from(thin, space, &self.cells, effort);
        starts.retain(|start| !self.begun.contains(start));
        progress("polishing the best cells");
        self.rough.extend(runs(thin, space, &starts, COARSE));
        self.begun.extend(starts);
        self.rough = merge_equal(std::mem::take(&mut self.rough), &space.scales);
        let hopeless = HOPELESS * self.rough.first().map_or(0.0, |minimum| minimum.sum_of_squares);
        let mut chosen: Vec<DVector<f64>> = (self.rough.iter().enumerate())
            .filter(|(place, run)| *place < ALWAYS_REFINED * effort || run.sum_of_squares < hopeless)
            .map(|(_, run)| run.parameters.clone())
            .take(REFINED * effort)
            .collect();
        chosen.retain(|start| !self.refined.contains(start));
        progress("refining the minima");
        self.found.extend(runs(compiled, space, &chosen, FINE));
        self.refined.extend(chosen);
    }

    /// The distinct minima, best first, with those next to the aliases of the best.
    pub(crate) fn minima(&self) -> Vec<Minimum> {
        let mut found = self.found.clone();
        if let Some(best) = found.iter().min_by(|a, b| a.sum_of_squares.total_cmp(&b.sum_of_squares)) {
            found.extend(aliases(self.compiled, self.space, best));
        }
        merge_near(found, &self.space.scales, APART)
    }
}

/// The distinct minima that runs from `starts` end in, best first.
fn runs(compiled: &Compiled<'_>, space: &Space, starts: &[DVector<f64>], tolerances: Tolerances) -> Vec<Minimum> {
    merge_equal(multistart(|| Problem::new(compiled, space, &[]), starts, tolerances), &space.scales)
}

/// The minimum next to the user's start.
pub(crate) fn local_minimum(compiled: &Compiled<'_>, space: &Space) -> Vec<Minimum> {
    runs(compiled, space, &[start(compiled.settings, space)], FINE)
}

/// The minima next to the aliases of `best`: its swap partner, its mirror image in the tilt, and both in one.
///
/// They may be far above the best; a report tells how far.
fn aliases(compiled: &Compiled<'_>, space: &Space, best: &Minimum) -> Vec<Minimum> {
    let values = space.freedom.expand(&best.parameters);
    let ratio = index_ratio(compiled.settings);
    let swapped = swap_partner(&values, ratio, space);
    let both = swapped.as_ref().and_then(|swapped| mirrored(&space.freedom.expand(swapped), space));
    let starts: Vec<DVector<f64>> = swapped.into_iter().chain(mirrored(&values, space)).chain(both).collect();
    multistart(|| Problem::new(compiled, space, &[]), &starts, FINE)
}

/// What is polished: the best cells of the grid, the swap partners and mirror images of the best of these, and random
/// points; `effort` times as many of each as usual. Before them the user's start.
fn starts_from(thin: &Compiled<'_>, space: &Space, cells: &[Cell], effort: usize) -> Vec<DVector<f64>> {
    let settings = thin.settings;
    let best = finer(space, &thin.plan, &thin.linear, &cells[..cells.len().min(effort * POLISHED)]);
    let mut starts: Vec<DVector<f64>> = best.iter().map(|cell| space.freedom.restrict(&cell.values)).collect();
    let ratio = index_ratio(settings);
    starts.extend(best.iter().take(effort * SWAPPED).filter_map(|cell| swap_partner(&cell.values, ratio, space)));
    starts.extend(best.iter().take(effort * MIRRORED).filter_map(|cell| mirrored(&cell.values, space)));
    starts.extend(space.bounds.latin_hypercube(effort * RANDOM, settings.seed));
    // The swap partner or mirror image of a cell may be another cell, or itself.
    let mut met = vec![start(settings, space)];
    for start in starts {
        if !met.contains(&start) {
            met.push(start);
        }
    }
    met
}

/// The user's start, completed by the middle of the bounds.
fn start(settings: &FitSettings, space: &Space) -> DVector<f64> {
    DVector::from_fn(space.freedom.free.len(), |j, _| {
        let middle = 0.5 * (space.bounds.lower()[j] + space.bounds.upper()[j]);
        settings.start[space.freedom.free[j].index()].unwrap_or(middle)
    })
}

/// Index of the cuticle over that of the gap at green light, where the media have one there; else 1.56.
fn index_ratio(settings: &FitSettings) -> f64 {
    settings.stack.media(550.0).map_or(1.56, |media| media.cuticle.re / media.gap.re)
}

/// `(n d_cuticle, d_air / n)`: the structure whose layers have each other's optical thickness.
fn swap_partner(values: &[f64; COUNT], ratio: f64, space: &Space) -> Option<DVector<f64>> {
    let mut partner = *values;
    (partner[0], partner[1]) = (ratio * values[1], values[0] / ratio);
    let free = space.freedom.restrict(&partner);
    space.bounds.contain(&free).then_some(free)
}

/// The structure tilted the other way.
fn mirrored(values: &[f64; COUNT], space: &Space) -> Option<DVector<f64>> {
    let mut mirrored = *values;
    mirrored[2] = -mirrored[2];
    let free = space.freedom.restrict(&mirrored);
    space.bounds.contain(&free).then_some(free)
}

/// One cell of the grid: its best point and the sum of squares there.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    pub(crate) cost: f64,
    pub(crate) values: [f64; COUNT],
}

/// Middles of `count` equal slices of `[lower, upper]`, or slices of equal ratio.
fn middles(lower: f64, upper: f64, count: usize, by_ratio: bool) -> Vec<f64> {
    #[allow(clippy::cast_precision_loss, reason = "grid sizes are small")]
    let share = |slice: usize| (slice as f64 + 0.5) / count as f64;
    if by_ratio && lower > 0.0 {
        (0..count).map(|slice| lower * (upper / lower).powf(share(slice))).collect()
    } else {
        (0..count).map(|slice| lower + share(slice) * (upper - lower)).collect()
    }
}

/// Grid values of each free parameter; one value where the data cannot see it.
///
/// - `counts`: tilts, lobe widths, lamella widths.
fn axes(space: &Space, plan: &Plan<'_>, counts: [usize; 3]) -> Vec<Vec<f64>> {
    let is_thickness = |parameter: &Parameter| matches!(parameter, Parameter::DAir | Parameter::DCuticle);
    let thicknesses: Vec<f64> = (space.freedom.free.iter())
        .zip(&space.ranges)
        .filter(|(parameter, _)| is_thickness(parameter))
        .map(|(_, &range)| (range / THICKNESS_STEP).ceil().max(2.0))
        .collect();
    #[allow(clippy::cast_precision_loss, reason = "a constant")]
    let excess = (thicknesses.iter().product::<f64>() / MAX_CELLS as f64).max(1.0);
    #[allow(clippy::cast_precision_loss, reason = "at most two")]
    let coarser = excess.powf(1.0 / thicknesses.len().max(1) as f64);
    (space.freedom.free.iter().enumerate())
        .map(|(j, parameter)| {
            let (lower, upper) = (space.bounds.lower()[j], space.bounds.upper()[j]);
            let (count, by_ratio) = match parameter {
                Parameter::DAir | Parameter::DCuticle => {
                    let count = (space.ranges[j] / THICKNESS_STEP).ceil().max(2.0) / coarser;
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 6000")]
                    let count = count.ceil() as usize;
                    (count, false)
                }
                Parameter::Delta if plan.sees(*parameter) => (counts[0], false),
                Parameter::PhiAlpha if plan.sees(*parameter) => (counts[1], true),
                Parameter::LamellaWidth if plan.sees(*parameter) => (counts[2], true),
                Parameter::Delta | Parameter::PhiAlpha | Parameter::LamellaWidth => (1, false),
            };
            middles(lower, upper, count, by_ratio)
        })
        .collect()
}

/// All combinations of one value from each axis.
fn combinations(axes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    axes.iter().fold(vec![Vec::new()], |head, axis| {
        let longer = |front: &Vec<f64>, value: &f64| front.iter().copied().chain([*value]).collect::<Vec<f64>>();
        head.iter().flat_map(|front| axis.iter().map(|value| longer(front, value)).collect::<Vec<_>>()).collect()
    })
}

/// The grid's cells of thickness, each with the best of its other parameters, best first.
fn grid(space: &Space, plan: &Plan<'_>, linear: &LinearPart) -> Vec<Cell> {
    let axes = axes(space, plan, COARSER);
    let outer = thicknesses(space);
    scan(space, plan, linear, &combinations(&axes[..outer]), &combinations(&axes[outer..]))
}

/// The same thicknesses with a finer grid of the other parameters.
fn finer(space: &Space, plan: &Plan<'_>, linear: &LinearPart, cells: &[Cell]) -> Vec<Cell> {
    let axes = axes(space, plan, FINER);
    let outer = thicknesses(space);
    let of = |cell: &Cell| space.freedom.restrict(&cell.values).as_slice()[..outer].to_vec();
    scan(space, plan, linear, &cells.iter().map(of).collect::<Vec<_>>(), &combinations(&axes[outer..]))
}

/// The best of the other parameters, on the grid, for each of `thicknesses`, in their order; of infinite cost where the
/// model has no value.
pub(crate) fn best_of_the_rest(
    space: &Space,
    plan: &Plan<'_>,
    linear: &LinearPart,
    thicknesses: &[Vec<f64>],
) -> Vec<Cell> {
    let axes = axes(space, plan, COARSER);
    let inner = combinations(&axes[self::thicknesses(space)..]);
    cells(space, plan, linear, thicknesses, &inner)
}

/// How many of the free parameters are thicknesses; they come first.
fn thicknesses(space: &Space) -> usize {
    space.freedom.free.iter().take_while(|p| matches!(p, Parameter::DAir | Parameter::DCuticle)).count()
}

/// A cell for each of `outers`, the thicknesses, with the best of the other parameters in `inner`; best first.
fn scan(space: &Space, plan: &Plan<'_>, linear: &LinearPart, outers: &[Vec<f64>], inner: &[Vec<f64>]) -> Vec<Cell> {
    let mut cells = cells(space, plan, linear, outers, inner);
    cells.retain(|cell| cell.cost.is_finite());
    cells.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    cells
}

/// The same in the order of `outers`, those without a value too.
fn cells(space: &Space, plan: &Plan<'_>, linear: &LinearPart, outers: &[Vec<f64>], inner: &[Vec<f64>]) -> Vec<Cell> {
    let full = |outer: &[f64], inner: &[f64]| {
        let free = DVector::from_iterator(outer.len() + inner.len(), outer.iter().chain(inner).copied());
        space.freedom.expand(&free)
    };
    let key = |value: f64| value.to_bits();
    let screening = Screening::new(plan, linear);
    // Lobes and slits are the same in every cell, unless they are linked to a thickness: compute them once.
    let mut lobes: FxHashMap<[u64; 3], OfLobe> = FxHashMap::default();
    let product = plan.is_product();
    let lobe_key = |delta, phi_alpha, width| [key(delta), key(phi_alpha), if product { key(width) } else { 0 }];
    let lobe_of = |delta, phi_alpha, width| screening.lobe(&plan.lobe(delta, phi_alpha, width));
    let mut slits: FxHashMap<u64, Vec<f64>> = FxHashMap::default();
    for values in outers.iter().take(1).flat_map(|outer| inner.iter().map(|inner| full(outer, inner))) {
        let [.., delta, phi_alpha, width] = values;
        lobes.entry(lobe_key(delta, phi_alpha, width)).or_insert_with(|| lobe_of(delta, phi_alpha, width));
        slits.entry(key(values[4])).or_insert_with(|| plan.diffraction(values[4]));
    }
    let cell = |outer: &Vec<f64>| {
        let mut best = Cell { cost: f64::INFINITY, values: [f64::NAN; COUNT] };
        let (mut equations, mut products) = (linear.no_equations(), Vec::new());
        let mut interference: Option<(u64, Vec<f64>)> = None;
        // A thickness may be linked to an inner parameter: it is a part of the keys.
        let mut stacks: FxHashMap<[u64; 3], OfStack> = FxHashMap::default();
        let mut lamellae: FxHashMap<[u64; 2], OfPart> = FxHashMap::default();
        let mut multilayers: FxHashMap<([u64; 2], [u64; 3]), OfPart> = FxHashMap::default();
        let mut free = DVector::zeros(space.freedom.free.len());
        free.rows_mut(0, outer.len()).copy_from_slice(outer);
        for inner in inner {
            free.rows_mut(outer.len(), inner.len()).copy_from_slice(inner);
            let values = space.freedom.expand(&free);
            let [d_air, d_cuticle, delta, phi_alpha, lamella_width] = values;
            if !inside(&values) {
                continue;
            }
            let [air, cuticle] = [d_air, d_cuticle].map(key);
            let lamella = lamellae.entry([d_air + d_cuticle, lamella_width].map(key)).or_insert_with(|| {
                let period = d_air + d_cuticle;
                let interference = match &mut interference {
                    Some((known, values)) if *known == key(period) => &*values,
                    other => &other.insert((key(period), plan.interference(period))).1,
                };
                let own_slit;
                let diffraction = match slits.get(&key(lamella_width)) {
                    Some(slit) => slit,
                    None => {
                        own_slit = plan.diffraction(lamella_width);
                        &own_slit
                    }
                };
                let product: Vec<f64> =
                    interference.iter().zip(diffraction).map(|(array, slit)| array * slit).collect();
                screening.lamella(&product)
            });
            let lobe_key = lobe_key(delta, phi_alpha, lamella_width);
            let multilayer = multilayers.entry(([air, cuticle], lobe_key)).or_insert_with(|| {
                // Of a product the tilt moves the lobe alone.
                let tilt = if product { 0 } else { key(delta) };
                let stack = || screening.stack(&plan.stack(d_air, d_cuticle, delta));
                let stack = stacks.entry([air, cuticle, tilt]).or_insert_with(stack);
                let own_lobe;
                let lobe = match lobes.get(&lobe_key) {
                    Some(lobe) => lobe,
                    None => {
                        own_lobe = lobe_of(delta, phi_alpha, lamella_width);
                        &own_lobe
                    }
                };
                screening.multilayer(stack, lobe)
            });
            equations.clear();
            screening.join(lamella, multilayer, &mut products, |curve, sums| linear.add(&mut equations, curve, sums));
            let cost = equations.best_sum_of_squares();
            if cost < best.cost {
                best = Cell { cost, values };
            }
        }
        best
    };
    outers.par_iter().map(cell).collect()
}

#[cfg(test)]
mod tests;
