//! Model A in many directions at once, in vector code: each block of directions goes through all wavelengths in registers.
//!
//! The same bits with every set of vector instructions: nothing is fused.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::blocks::padded;
use crate::optics::lamella::{CHEBYSHEV_LAYERS, array_factor, chebyshev, slit_factor};
use multiversion::multiversion;

/// Directions that go together.
const BLOCK: usize = 16;

/// The lamellae as the kernel sees them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lamellae {
    pub(super) period: f64,
    pub(super) width: f64,
    pub(super) layers: usize,
}

impl Lamellae {
    /// `A² S²` of a block of directions at one wavelength.
    #[inline(always)]
    fn block(&self, half_k: f64, u: &[f64; BLOCK], v: &[f64; BLOCK]) -> [f64; BLOCK] {
        let (by_period, by_width) = (half_k * self.period, half_k * self.width);
        let mut arguments = [0.0; BLOCK];
        for lane in 0..BLOCK {
            arguments[lane] = by_period * v[lane];
        }
        let combs = if self.layers <= CHEBYSHEV_LAYERS {
            chebyshev(arguments, self.layers)
        } else {
            arguments.map(|argument| array_factor(argument, self.layers))
        };
        let mut found = [0.0; BLOCK];
        for lane in 0..BLOCK {
            let amplitude = combs[lane] * slit_factor(by_width * u[lane]);
            found[lane] = amplitude * amplitude;
        }
        found
    }
}

/// Sums of `A² S²` over wavelengths by three lists of weights, one for each direction.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn colours(
    of: Lamellae,
    half_k: &[f64],
    weights: &[Vec<f64>; 3],
    u: &[f64],
    v: &[f64],
    out: &mut [[f64; 3]],
) {
    for (number, out) in out.chunks_mut(BLOCK).enumerate() {
        let (u, v) = (padded(u, number * BLOCK), padded(v, number * BLOCK));
        let mut sums = [[0.0; BLOCK]; 3];
        for (((&half_k, &x), &y), &z) in half_k.iter().zip(&weights[0]).zip(&weights[1]).zip(&weights[2]) {
            let found = of.block(half_k, &u, &v);
            for lane in 0..BLOCK {
                sums[0][lane] += x * found[lane];
                sums[1][lane] += y * found[lane];
                sums[2][lane] += z * found[lane];
            }
        }
        for (lane, out) in out.iter_mut().enumerate() {
            *out = [sums[0][lane], sums[1][lane], sums[2][lane]];
        }
    }
}

/// `A² S²` at each wavelength, `[direction][wavelength]`.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn spectra(of: Lamellae, half_k: &[f64], u: &[f64], v: &[f64], out: &mut [f64]) {
    let count = half_k.len();
    for (number, out) in out.chunks_mut(BLOCK * count).enumerate() {
        let (u, v) = (padded(u, number * BLOCK), padded(v, number * BLOCK));
        for (index, &half_k) in half_k.iter().enumerate() {
            let found = of.block(half_k, &u, &v);
            for (spectrum, found) in out.chunks_mut(count).zip(found) {
                spectrum[index] = found;
            }
        }
    }
}
