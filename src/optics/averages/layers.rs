//! Stacks whose layers differ: each thickness by itself, normal about that of its kind.
//!
//! The mean is over 31² stacks of an orthogonal array. Layer `j` of the stack `(a, b)` has the thickness
//!
//! ```text
//! d_j = max(0, d + spread z(P_j(a j + b mod 31)))
//! ```
//!
//! with 31 levels z as likely as each other and `P_j` a permutation of them, drawn once for all. Of any two of 31 layers each of the
//! 31² pairs of levels is met once: what each layer does, and any two together, is the mean over all levels, and only what three
//! or more do together is a sample. Levels and permutations are odd, so that with each stack goes the one that is as much
//! thinner where it is thicker, and no odd power of the deviations is left. The 62 matrices of all layers are computed once.
//!
//! # Source
//! Owen 1992, *Orthogonal arrays for computer experiments, integration and visualization*, Statistica Sinica 2, 439–452;
//! the array is that of Bose 1938.

use crate::numerics::normal::normal_quantile;
use crate::optics::Media;
use crate::optics::multilayer::fields::pairs::Pairs;
use crate::optics::multilayer::{CUTICLE, GAP, Order, Period, SAndP, ordered_unchecked};
use rand::{RngCore, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::ops::Range;

/// Levels of each thickness, a prime; the matrices of both kinds of layers on all levels just fit the kernel's memory.
const LEVELS: usize = 31;
/// The largest deviation from the middle level.
const HALF: usize = LEVELS / 2;
/// Stacks of more layers would take seconds for a reading.
pub(super) const MOST_LAYERS: usize = 1000;
/// Seed of the permutations: the least error of 160 over two structures; two others gave the same.
const SEED: u64 = 59;
/// Where other averages are taken too, so many times 31 stacks at least go to all their plane waves together.
const TOGETHER: usize = 124;

/// The thicknesses of all stacks.
#[derive(Debug)]
pub(super) struct Disorder {
    /// Deviations from the middle, nm.
    levels: Vec<f64>,
    /// Kinds of the layers of each stack, from the base to the light; the first [`LEVELS`] are gaps.
    order: Vec<usize>,
    /// Its neighbours, a gap and the cuticle on it.
    pairs: Pairs,
    /// Layers of a stack.
    length: usize,
}

impl Disorder {
    /// Of stacks of `layers` periods, at most [`MOST_LAYERS`], with this standard deviation, nm.
    pub(super) fn new(layers: usize, spread: f64) -> Self {
        let length = 2 * layers;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(SEED);
        let mut order = vec![0; LEVELS * LEVELS * length];
        for place in 0..length {
            let permuted = odd_permutation(&mut random);
            let first = LEVELS * if place.is_multiple_of(2) { GAP } else { CUTICLE };
            for (row, stack) in order.chunks_exact_mut(length).enumerate() {
                let (a, b) = (row / LEVELS, row % LEVELS);
                stack[place] = first + permuted[(a * place + b) % LEVELS];
            }
        }
        let pairs = Pairs::of(&order);
        Self { levels: levels().iter().map(|level| level * spread).collect(), order, pairs, length }
    }

    /// Mean R of the stacks whose middle is `period`; where it is one of `nodes` plane waves of a reading, of a share of them that
    /// differs from one to the next.
    pub(super) fn reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        (period, angle): (Period, f64),
        (node, nodes): (usize, usize),
        out: &mut [SAndP],
    ) {
        let kinds = self.kinds(period);
        let (places, stacks) = self.share(node, nodes);
        let order = &self.order[places.clone()];
        let layers = Order { kinds: &kinds, order, repeats: 1, stacks, pairs: self.pairs.within(places) };
        ordered_unchecked(media, wavenumbers, layers, angle, out);
    }

    /// Thicknesses of all kinds about a period.
    fn kinds(&self, period: Period) -> Vec<(usize, f64)> {
        let of = |medium, middle: f64| self.levels.iter().map(move |level| (medium, (middle + level).max(0.0)));
        of(GAP, period.gap).chain(of(CUTICLE, period.cuticle)).collect()
    }

    /// Places in the order of the stacks for one of so many plane waves, and the number of these stacks: whole rows `a` of the array, in
    /// each of which a layer takes each level once.
    fn share(&self, node: usize, nodes: usize) -> (Range<usize>, usize) {
        let rows = if nodes > 1 { TOGETHER.div_ceil(nodes).min(LEVELS) } else { LEVELS };
        let first = node * rows % (LEVELS - rows + 1);
        let row = LEVELS * self.length;
        (first * row..(first + rows) * row, LEVELS * rows)
    }
}

/// The levels: those in the middle of equal shares of the normal distribution, brought to its second and fourth moment by a
/// common factor of all but the outermost, and by these.
fn levels() -> [f64; LEVELS] {
    #[allow(clippy::cast_precision_loss, reason = "31")]
    let count = LEVELS as f64;
    #[allow(clippy::cast_precision_loss, reason = "at most 31")]
    let mut levels = std::array::from_fn(|level| normal_quantile((level as f64 + 0.5) / count).unwrap_or_default());
    let inner = |power: i32| levels[1..LEVELS - 1].iter().map(|level: &f64| level.powi(power)).sum::<f64>() / count;
    // second x + 2 e / count = 1,  fourth x² + 2 e² / count = 3:  x the square of the factor, e that of the outermost
    let (second, fourth) = (inner(2), inner(4));
    let (square, linear) = (fourth + 0.5 * count * second * second, 0.5 * count * second);
    let factor = (linear - (linear * linear - square * (0.5 * count - 3.0)).sqrt()) / square;
    let outermost = (0.5 * count * (1.0 - factor * second)).sqrt();
    for level in &mut levels {
        *level *= factor.sqrt();
    }
    (levels[0], levels[LEVELS - 1]) = (-outermost, outermost);
    levels
}

/// For each residue modulo [`LEVELS`] a level; that of the opposite residue is the opposite level.
fn odd_permutation(random: &mut Xoshiro256PlusPlus) -> [usize; LEVELS] {
    let mut below = |count: usize| usize::try_from(random.next_u64() % count as u64).unwrap_or_default();
    let mut sizes: [usize; HALF] = std::array::from_fn(|place| place + 1);
    for last in (1..HALF).rev() {
        sizes.swap(last, below(last + 1));
    }
    let mut permuted = [HALF; LEVELS];
    for (place, size) in sizes.into_iter().enumerate() {
        let (one, other) = if below(2) == 0 { (HALF + size, HALF - size) } else { (HALF - size, HALF + size) };
        (permuted[place + 1], permuted[LEVELS - 1 - place]) = (one, other);
    }
    permuted
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn levels_have_the_moments_of_the_normal_distribution() {
        let moment = |power: i32| levels().iter().map(|level| level.powi(power)).sum::<f64>() / LEVELS as f64;
        for (power, expected) in [(1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0), (5, 0.0)] {
            assert_abs_diff_eq!(moment(power), expected, epsilon = 1e-12);
        }
        assert!(levels().is_sorted() && levels()[LEVELS - 1] < 2.5);
    }

    #[test]
    fn any_two_of_31_layers_meet_each_pair_of_levels_once() {
        let disorder = Disorder::new(16, 1.0);
        for one in 0..LEVELS {
            for other in 0..one {
                let mut met = [[0; LEVELS]; LEVELS];
                for stack in disorder.order.chunks(disorder.length) {
                    met[stack[one] % LEVELS][stack[other] % LEVELS] += 1;
                }
                assert_eq!(met, [[1; LEVELS]; LEVELS], "{one} {other}");
            }
        }
    }

    #[test]
    fn with_each_stack_goes_its_opposite_and_each_layer_is_of_its_kind() {
        let disorder = Disorder::new(40, 1.0);
        let stacks: std::collections::HashSet<&[usize]> = disorder.order.chunks(disorder.length).collect();
        assert_eq!(stacks.len(), LEVELS * LEVELS);
        for stack in &stacks {
            assert!(stack.iter().enumerate().all(|(place, kind)| kind / LEVELS == place % 2));
            let opposite: Vec<usize> =
                stack.iter().map(|kind| kind / LEVELS * LEVELS + LEVELS - 1 - kind % LEVELS).collect();
            assert!(stacks.contains(opposite.as_slice()));
        }
    }

    #[test]
    fn shares_are_within_the_array_and_all_together_are_all_of_it() {
        let disorder = Disorder::new(3, 1.0);
        assert_eq!(disorder.share(0, 1), (0..disorder.order.len(), LEVELS * LEVELS));
        for nodes in [2, 17, 65, 124, 1000] {
            let mut first = std::collections::HashSet::new();
            for node in 0..nodes {
                let (places, stacks) = disorder.share(node, nodes);
                assert!(places.end <= disorder.order.len() && places.len() == stacks * disorder.length);
                assert!(stacks.is_multiple_of(LEVELS));
                first.insert(places.start);
            }
            assert_eq!(first.len() > 1, nodes > 4, "{nodes}");
        }
    }
}
