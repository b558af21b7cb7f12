//! Model A at many nodes, in vector registers, with its derivatives.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::blocks::{padded, put};
use crate::numerics::fused::{fused_or_not, mul_add};
use crate::numerics::trigonometry::sin_cos_fused;
use crate::optics::lamella::{CHEBYSHEV_LAYERS, array_factor};
use multiversion::multiversion;

/// Nodes that go together.
const BLOCK: usize = 8;

/// `array_factor(half_kv · period)²` of many nodes, into `out`, as long as these.
#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
pub(crate) fn interference(half_kv: &[f64], period: f64, layers: usize, out: &mut [f64]) {
    fused_or_not!(interference_of(half_kv, period, layers, out));
}

#[inline(always)]
fn interference_of<const FUSED: bool>(half_kv: &[f64], period: f64, layers: usize, out: &mut [f64]) {
    if layers > CHEBYSHEV_LAYERS {
        for (out, half_kv) in out.iter_mut().zip(half_kv) {
            *out = array_factor(half_kv * period, layers).powi(2);
        }
        return;
    }
    #[allow(clippy::cast_precision_loss, reason = "at most 16")]
    let per_count = 1.0 / layers.max(1) as f64;
    for first in (0..out.len()).step_by(BLOCK) {
        let phases = padded::<BLOCK>(half_kv, first);
        let mut twice_cos = [0.0; BLOCK];
        for lane in 0..BLOCK {
            twice_cos[lane] = 2.0 * sin_cos_fused::<FUSED>(phases[lane] * period).1;
        }
        let (mut u, mut before) = ([1.0; BLOCK], [0.0; BLOCK]);
        for _ in 1..layers {
            for lane in 0..BLOCK {
                (u[lane], before[lane]) = (mul_add::<FUSED>(twice_cos[lane], u[lane], -before[lane]), u[lane]);
            }
        }
        for lane in 0..BLOCK {
            u[lane] = (u[lane] * per_count) * (u[lane] * per_count);
        }
        put(&u, out, first);
    }
}

/// `factor · obliquity · slit_factor(half_ku · lamella_width)²` of many nodes, into `out`, as long as these.
#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
pub(crate) fn diffraction(half_ku: &[f64], obliquity: &[f64], lamella_width: f64, factor: f64, out: &mut [f64]) {
    fused_or_not!(diffraction_of(half_ku, obliquity, lamella_width, factor, out));
}

#[inline(always)]
fn diffraction_of<const FUSED: bool>(
    half_ku: &[f64],
    obliquity: &[f64],
    lamella_width: f64,
    factor: f64,
    out: &mut [f64],
) {
    // A loop, not an iterator: what closures do inside other functions is not compiled for these instructions.
    for ((square, &half_ku), &obliquity) in out.iter_mut().zip(half_ku).zip(obliquity) {
        let slit = slit::<FUSED>(half_ku * lamella_width);
        *square = factor * obliquity * (slit * slit);
    }
}

/// The nodes of many readings, each of the same length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LamellaNodes<'a> {
    pub(crate) half_kv: &'a [f64],
    pub(crate) half_ku: &'a [f64],
    pub(crate) obliquity: &'a [f64],
}

/// What Model A is asked for: `factor` with its derivative by the width.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lamella {
    pub(crate) period: f64,
    pub(crate) layers: usize,
    pub(crate) width: f64,
    pub(crate) factor: (f64, f64),
}

/// The product of [`interference`] and [`diffraction`] at many nodes, into `out`, as long as these.
pub(crate) fn intensity(nodes: LamellaNodes<'_>, of: Lamella, out: &mut [f64]) {
    if of.layers <= CHEBYSHEV_LAYERS {
        return chebyshev_intensity(nodes, of, out);
    }
    diffraction(nodes.half_ku, nodes.obliquity, of.width, of.factor.0, out);
    for (out, half_kv) in out.iter_mut().zip(nodes.half_kv) {
        *out *= array_factor(half_kv * of.period, of.layers).powi(2);
    }
}

/// [`intensity`] to the same bits, and its derivatives by the period and by the width of the lamella, 1/nm; `false`, and nothing
/// written, above [`CHEBYSHEV_LAYERS`].
pub(crate) fn intensity_and_slopes(
    nodes: LamellaNodes<'_>,
    of: Lamella,
    out: &mut [f64],
    slopes: [&mut [f64]; 2],
) -> bool {
    if of.layers <= CHEBYSHEV_LAYERS {
        chebyshev_intensity_and_slopes(nodes, of, out, slopes);
    }
    of.layers <= CHEBYSHEV_LAYERS
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn chebyshev_intensity(nodes: LamellaNodes<'_>, of: Lamella, out: &mut [f64]) {
    fused_or_not!(values_of(nodes, of, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn chebyshev_intensity_and_slopes(nodes: LamellaNodes<'_>, of: Lamella, out: &mut [f64], slopes: [&mut [f64]; 2]) {
    fused_or_not!(values_and_slopes_of(nodes, of, out, slopes));
}

#[inline(always)]
fn values_of<const FUSED: bool>(nodes: LamellaNodes<'_>, of: Lamella, out: &mut [f64]) {
    for first in (0..out.len()).step_by(BLOCK) {
        put(&block::<FUSED, false>(nodes, of, first)[0], out, first);
    }
}

#[inline(always)]
fn values_and_slopes_of<const FUSED: bool>(
    nodes: LamellaNodes<'_>,
    of: Lamella,
    out: &mut [f64],
    [by_period, by_width]: [&mut [f64]; 2],
) {
    for first in (0..out.len()).step_by(BLOCK) {
        let [found, period, width] = block::<FUSED, true>(nodes, of, first);
        put(&found, out, first);
        put(&period, by_period, first);
        put(&width, by_width, first);
    }
}

/// Values of the nodes from `first` on, and if `SLOPES` their derivatives by the period and the width.
#[inline(always)]
fn block<const FUSED: bool, const SLOPES: bool>(
    nodes: LamellaNodes<'_>,
    of: Lamella,
    first: usize,
) -> [[f64; BLOCK]; 3] {
    // One by one: what closures do in other functions is not compiled for vector instructions.
    let (k_v, k_u) = (padded::<BLOCK>(nodes.half_kv, first), padded::<BLOCK>(nodes.half_ku, first));
    let obliquity = padded::<BLOCK>(nodes.obliquity, first);
    #[allow(clippy::cast_precision_loss, reason = "at most 16")]
    let per_count = 1.0 / of.layers.max(1) as f64;
    let (mut twice_cos, mut twice_sin) = ([0.0; BLOCK], [0.0; BLOCK]);
    for lane in 0..BLOCK {
        let (sin, cos) = sin_cos_fused::<FUSED>(k_v[lane] * of.period);
        (twice_sin[lane], twice_cos[lane]) = (2.0 * sin, 2.0 * cos);
    }
    // U_(M-1) and its derivative by the cosine's double.
    let (mut u, mut before) = ([1.0; BLOCK], [0.0; BLOCK]);
    let (mut by_u, mut by_before) = ([0.0; BLOCK], [0.0; BLOCK]);
    for _ in 1..of.layers {
        for lane in 0..BLOCK {
            let next = mul_add::<FUSED>(twice_cos[lane], u[lane], -before[lane]);
            if SLOPES {
                let by_next = mul_add::<FUSED>(twice_cos[lane], by_u[lane], u[lane] - by_before[lane]);
                (by_u[lane], by_before[lane]) = (by_next, by_u[lane]);
            }
            (u[lane], before[lane]) = (next, u[lane]);
        }
    }
    let (mut found, mut by_period, mut by_width) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
    // dS²/da = 2 S (cos y - S) / a
    let twice_per_width = 2.0 * of.factor.0 / of.width;
    for lane in 0..BLOCK {
        let y = k_u[lane] * of.width;
        let at_zero = y.abs() < f64::MIN_POSITIVE;
        let safe = if at_zero { 1.0 } else { y };
        let (sin, cos) = sin_cos_fused::<FUSED>(safe);
        let slit = if at_zero { 1.0 } else { sin * (1.0 / safe) };
        let amplitude = u[lane] * per_count;
        let (array, open) = (amplitude * amplitude, of.factor.0 * obliquity[lane] * (slit * slit));
        found[lane] = array * open;
        if SLOPES {
            // (y cos y - sin y) / y = -y²/3 + ..., right to 2e-16 of 1: a slit that is so small beside its order has no slope.
            let by_logarithm = if at_zero { 0.0 } else { cos - slit };
            let by_array = -2.0 * amplitude * (by_u[lane] * per_count) * twice_sin[lane] * k_v[lane];
            by_period[lane] = by_array * open;
            let by_open = slit * mul_add::<FUSED>(of.factor.1, slit, twice_per_width * by_logarithm);
            by_width[lane] = array * (obliquity[lane] * by_open);
        }
    }
    [found, by_period, by_width]
}

/// [`slit_factor`](super::slit_factor).
#[inline(always)]
pub(super) fn slit<const FUSED: bool>(y: f64) -> f64 {
    // Chosen without a branch, so that a loop over nodes is vector code.
    let at_zero = y.abs() < f64::MIN_POSITIVE;
    let safe = if at_zero { 1.0 } else { y };
    let ratio = sin_cos_fused::<FUSED>(safe).0 * (1.0 / safe);
    if at_zero { 1.0 } else { ratio }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::lamella::LamellaNode;
    use approx::assert_abs_diff_eq;
    use std::f64::consts::PI;

    /// A list of `length`, filled.
    fn filled(length: usize, fill: impl FnOnce(&mut [f64])) -> Vec<f64> {
        let mut list = vec![f64::NAN; length];
        fill(&mut list);
        list
    }

    /// Values and both slopes.
    fn all_filled(length: usize, fill: impl FnOnce(&mut [f64], [&mut [f64]; 2])) -> [Vec<f64>; 3] {
        let (mut by_period, mut by_width) = (vec![f64::NAN; length], vec![f64::NAN; length]);
        let values = filled(length, |values| fill(values, [&mut by_period, &mut by_width]));
        [values, by_period, by_width]
    }

    /// Blocks and their rest, fused and portable, against one node at a time.
    #[test]
    fn blocks_are_what_single_nodes_are() {
        for length in [0, 1, 31, 33, 200] {
            let half_kv: Vec<f64> = (0..length).map(|i| f64::from(i) * 1.3e-3).chain([0.0, PI / 235.0]).collect();
            let half_ku: Vec<f64> = (0..length).map(|i| f64::from(i) * 2e-4).chain([1e-300, 1e-7]).collect();
            let (obliquity, count) = (vec![0.9; half_ku.len()], half_ku.len());
            let nodes = LamellaNodes { half_kv: &half_kv, half_ku: &half_ku, obliquity: &obliquity };
            let open = filled(count, |out| diffraction(&half_ku, &obliquity, 300.0, 2.0, out));
            let portable_open = filled(count, |out| diffraction_of::<false>(&half_ku, &obliquity, 300.0, 2.0, out));
            for layers in [0, 1, 2, 9, 16, 17] {
                let of = Lamella { period: 235.0, layers, width: 300.0, factor: (2.0, 0.1) };
                let array = filled(count, |out| interference(&half_kv, 235.0, layers, out));
                let portable = filled(count, |out| interference_of::<false>(&half_kv, 235.0, layers, out));
                let product = filled(count, |out| intensity(nodes, of, out));
                for i in 0..count {
                    let one = LamellaNode { half_kv: half_kv[i], half_ku: half_ku[i], obliquity: 0.9 };
                    let [of_array, of_slit] = [one.interference(235.0, layers), 1.8 * one.diffraction(300.0)];
                    assert_abs_diff_eq!(array[i], of_array, epsilon = 1e-13);
                    assert_abs_diff_eq!(portable[i], of_array, epsilon = 1e-13);
                    assert_abs_diff_eq!(open[i], of_slit, epsilon = 1e-14);
                    assert_abs_diff_eq!(portable_open[i], of_slit, epsilon = 1e-14);
                    assert_abs_diff_eq!(product[i], of_array * of_slit, epsilon = 2e-13);
                }
                let all = all_filled(count, |out, slopes| {
                    assert_eq!(intensity_and_slopes(nodes, of, out, slopes), layers <= CHEBYSHEV_LAYERS);
                });
                if layers <= CHEBYSHEV_LAYERS {
                    assert_eq!(all[0], product);
                    let portable =
                        all_filled(count, |out, slopes| values_and_slopes_of::<false>(nodes, of, out, slopes));
                    for (fused, portable) in all.iter().flatten().zip(portable.iter().flatten()) {
                        assert_abs_diff_eq!(fused, portable, epsilon = 2e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn slopes_are_differences_of_the_values() {
        // Both sides of the slit's series: y from 0 to 12.
        let half_kv: Vec<f64> = (0..200).map(|i| 1e-6 * f64::from(i * i)).collect();
        let half_ku: Vec<f64> = (0..200).map(|i| 1e-6 * f64::from(i * (i + 1))).collect();
        let (obliquity, count) = (vec![0.9; half_kv.len()], half_kv.len());
        let nodes = LamellaNodes { half_kv: &half_kv, half_ku: &half_ku, obliquity: &obliquity };
        let differences = |function: &dyn Fn(f64, &mut [f64]), at: f64| -> Vec<f64> {
            let [far_below, below, above, far_above] =
                [-2.0, -1.0, 1.0, 2.0].map(|steps| filled(count, |out| function(at + 0.01 * steps, out)));
            (0..below.len()).map(|i| (8.0 * (above[i] - below[i]) - (far_above[i] - far_below[i])) / 0.12).collect()
        };
        for factor in [|_: f64| 1.0, |width: f64| (width / 250.0).powi(2)] {
            let slope = (factor(300.5) - factor(299.5)) / 1.0;
            for layers in [1, 2, 9, 16] {
                let of = |period: f64, width: f64| Lamella { period, layers, width, factor: (factor(width), slope) };
                let [_, by_period, by_width] = all_filled(count, |out, slopes| {
                    intensity_and_slopes(nodes, of(235.0, 300.0), out, slopes);
                });
                let period = differences(&|period, out| intensity(nodes, of(period, 300.0), out), 235.0);
                let width = differences(&|width, out| intensity(nodes, of(235.0, width), out), 300.0);
                for i in 0..count {
                    assert_abs_diff_eq!(by_period[i], period[i], epsilon = 3e-9);
                    assert_abs_diff_eq!(by_width[i], width[i], epsilon = 1e-10);
                }
            }
        }
    }

    /// Near the mirror direction, against the series of the derivative.
    #[test]
    fn a_slit_seen_straight_has_no_slope_by_its_width() {
        for y in [0.0, 1e-300, 1e-12, 1e-5, 1e-3, 0.02_f64] {
            let nodes = LamellaNodes { half_kv: &[0.0], half_ku: &[y / 300.0], obliquity: &[1.0] };
            let of = Lamella { period: 235.0, layers: 9, width: 300.0, factor: (1.0, 0.0) };
            let [_, _, by_width] = all_filled(1, |out, slopes| {
                intensity_and_slopes(nodes, of, out, slopes);
            });
            // S² = 1 - y²/3 + 2 y⁴/45 - y⁶/315 + ...
            let series = (-2.0 / 3.0 * y.powi(2) + 8.0 / 45.0 * y.powi(4) - 2.0 / 105.0 * y.powi(6)) / 300.0;
            assert_abs_diff_eq!(by_width[0], series, epsilon = 5e-13 * y.powi(2) + 3e-18);
        }
    }
}
