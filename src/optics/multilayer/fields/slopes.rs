//! Derivatives of the mean of several stacks of gaps and cuticles by both thicknesses and the angle, in lanes, where every wave
//! travels and none is lost.
//!
//! There e and h are two real pairs, `(Re e, Im h)` and `(Im e, -Re h)`, which each layer turns by the same matrix, and
//!
//! ```text
//! T = [[cos, sin / Y], [-Y sin, cos]]     R = N / (N + 4 y Y_base)     N = |y e - h|²
//! ```
//!
//! Backwards from N with `a = dN/df` behind each layer (reverse mode), and the sums over both pairs:
//!
//! ```text
//! dN/d(phase) = (a_e f_h) / Y - (a_h f_e) Y       dN/d(ln Y) = (a_h f_h) after the layer - the same before it
//! ```
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::fused::{fused_or_not, mul_add};
use crate::numerics::trigonometry::sin_cos_fused;
use crate::optics::multilayer::fields::{BLOCK, Block, Layers, SCALED, Wave, ZERO, block_of, larger};
use crate::optics::multilayer::{CUTICLE, GAP, StackSlopes};
use multiversion::multiversion;

/// Both real pairs of a polarization: e and h of the first, e and h of the second.
type Pairs = [Block; 4];

/// Derivatives of [`values`](super::values) for light at an angle of this sine and cosine.
///
/// - `moves`: 1 for each kind of layer that is as much thicker as its middle, 0 for one that stays as it is.
#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
pub(crate) fn slopes(
    layers: &Layers<'_>,
    moves: &[f64],
    angle: (f64, f64),
    wavenumbers: &[f64],
    out: &mut [StackSlopes],
) {
    fused_or_not!(blocks(layers, moves, angle, wavenumbers, out));
}

#[inline(always)]
pub(super) fn blocks<const FUSED: bool>(
    layers: &Layers<'_>,
    moves: &[f64],
    (sin, cos): (f64, f64),
    wavenumbers: &[f64],
    out: &mut [StackSlopes],
) {
    let mut kinds = vec![Kind::NONE; layers.kinds.len()];
    let mut path = Path::default();
    #[allow(clippy::cast_precision_loss, reason = "a count of stacks is small")]
    let stacks = layers.stacks as f64;
    for (number, (chunk, out)) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)).enumerate() {
        let start = number * BLOCK;
        let (ambient, _) = block_of(layers.ambient, start);
        let base = Wave::new::<FUSED>(block_of(layers.base, start), &ambient, cos);
        let waves =
            [GAP, CUTICLE].map(|medium| Wave::new::<FUSED>(block_of(layers.media[medium], start), &ambient, cos));
        let mut k = [chunk[chunk.len() - 1]; BLOCK];
        k[..chunk.len()].copy_from_slice(chunk);
        // d(ln Y) / d(angle) of each medium, and d(phase) / d(angle) of 1 nm: kz² = n² - n_ambient² sin²
        let (mut relative, mut turned, mut base_relative) = ([ZERO; 2], [ZERO; 2], ZERO);
        for i in 0..BLOCK {
            let change = -ambient[i] * ambient[i] * sin * cos;
            for medium in [GAP, CUTICLE] {
                let along = waves[medium].admittances[0].0[i];
                relative[medium][i] = change / (along * along);
                turned[medium][i] = k[i] * change / along;
            }
            base_relative[i] = change / (base.admittances[0].0[i] * base.admittances[0].0[i]);
        }
        for (kind, &(medium, thickness)) in kinds.iter_mut().zip(layers.kinds) {
            kind.set::<FUSED>(&waves[medium], thickness, &k);
        }
        for polarization in [0, 1] {
            let mut outside = ZERO;
            for i in 0..BLOCK {
                outside[i] = if polarization == 0 { ambient[i] * cos } else { cos / ambient[i] };
            }
            let behind = &base.admittances[polarization].0;
            let (mut sums, mut angles) = ([ZERO; 2], ZERO);
            for order in layers.each() {
                path.forwards::<FUSED>(behind, &waves, polarization, (layers, &kinds), order);
                let (mut slope, factor, lost) = path.edge::<FUSED>(&outside);
                for i in 0..BLOCK {
                    angles[i] = mul_add::<FUSED>(-sin / cos, factor[i] * lost.1[i], angles[i]);
                }
                let mut next: Option<usize> = None;
                for (place, &number) in order.iter().enumerate().rev() {
                    let (medium, thickness) = layers.kinds[number];
                    let (y, z) =
                        (&waves[medium].admittances[polarization].0, &waves[medium].impedances[polarization].0);
                    let (kind, fields, moved) = (&kinds[number], &path.fields[place + 1], moves[number]);
                    let (relative_here, turned) = (&relative[medium], &turned[medium]);
                    let relative_next = next.map_or(&ZERO, |medium| &relative[medium]);
                    let sum = &mut sums[medium];
                    for i in 0..BLOCK {
                        let [e, h, f, g] = [slope[0][i], slope[1][i], slope[2][i], slope[3][i]];
                        let to_e = mul_add::<FUSED>(e, fields[1][i], f * fields[3][i]);
                        let to_h = mul_add::<FUSED>(h, fields[0][i], g * fields[2][i]);
                        let by_admittance = mul_add::<FUSED>(h, fields[1][i], g * fields[3][i]);
                        let by_phase = mul_add::<FUSED>(z[i], to_e, -y[i] * to_h);
                        sum[i] = mul_add::<FUSED>(moved, by_phase, sum[i]);
                        let changed = mul_add::<FUSED>(thickness * turned[i], by_phase, angles[i]);
                        angles[i] = mul_add::<FUSED>(relative_here[i] - relative_next[i], by_admittance, changed);
                        let (cos, by_h, by_e) = (kind.cos[i], kind.sin[i] * z[i], kind.sin[i] * y[i]);
                        slope[0][i] = mul_add::<FUSED>(cos, e, -by_e * h);
                        slope[1][i] = mul_add::<FUSED>(cos, h, by_h * e);
                        slope[2][i] = mul_add::<FUSED>(cos, f, -by_e * g);
                        slope[3][i] = mul_add::<FUSED>(cos, g, by_h * f);
                    }
                    if place % SCALED == SCALED - 1 {
                        let scale = &path.scales[place / SCALED];
                        for part in &mut slope {
                            for i in 0..BLOCK {
                                part[i] *= scale[i];
                            }
                        }
                    }
                    next = Some(medium);
                }
                let first = next.map_or(&ZERO, |medium| &relative[medium]);
                for i in 0..BLOCK {
                    // The fields at the base are (1, 0) and (0, -Y_base).
                    let by_base = -slope[3][i] * behind[i];
                    let own = mul_add::<FUSED>(-factor[i], lost.0[i], by_base);
                    angles[i] =
                        mul_add::<FUSED>(base_relative[i], own, mul_add::<FUSED>(-first[i], by_base, angles[i]));
                }
            }
            for (i, out) in out.iter_mut().enumerate() {
                let by = |medium: usize| k[i] * waves[medium].admittances[0].0[i] * sums[medium][i] / stacks;
                for (out, value) in
                    [(&mut out.gap, by(GAP)), (&mut out.cuticle, by(CUTICLE)), (&mut out.angle, angles[i] / stacks)]
                {
                    *(if polarization == 0 { &mut out.s } else { &mut out.p }) = value;
                }
            }
        }
    }
}

/// Cosine and sine of the phase of a kind of layer.
#[derive(Debug, Clone, Copy)]
struct Kind {
    cos: Block,
    sin: Block,
}

impl Kind {
    const NONE: Self = Self { cos: ZERO, sin: ZERO };

    #[inline(always)]
    fn set<const FUSED: bool>(&mut self, wave: &Wave, thickness: f64, k: &Block) {
        let along = &wave.admittances[0].0;
        for i in 0..BLOCK {
            (self.sin[i], self.cos[i]) = sin_cos_fused::<FUSED>(k[i] * thickness * along[i]);
        }
    }
}

/// The fields behind the first layer and after each, and what they were divided by after so many.
#[derive(Debug, Default)]
struct Path {
    fields: Vec<Pairs>,
    scales: Vec<Block>,
}

impl Path {
    #[inline(always)]
    fn forwards<const FUSED: bool>(
        &mut self,
        behind: &Block,
        waves: &[Wave; 2],
        polarization: usize,
        (layers, kinds): (&Layers<'_>, &[Kind]),
        order: &[usize],
    ) {
        self.fields.resize(order.len() + 1, [ZERO; 4]);
        self.scales.resize(order.len() / SCALED, ZERO);
        let mut last: Pairs = [[1.0; BLOCK], ZERO, ZERO, ZERO];
        for i in 0..BLOCK {
            last[3][i] = -behind[i];
        }
        self.fields[0] = last;
        for (place, &number) in order.iter().enumerate() {
            let (kind, wave) = (&kinds[number], &waves[layers.kinds[number].0]);
            let (y, z) = (&wave.admittances[polarization].0, &wave.impedances[polarization].0);
            let after = &mut self.fields[place + 1];
            for i in 0..BLOCK {
                let [e, h, f, g] = [last[0][i], last[1][i], last[2][i], last[3][i]];
                let (cos, by_h, by_e) = (kind.cos[i], kind.sin[i] * z[i], kind.sin[i] * y[i]);
                let e_after = mul_add::<FUSED>(cos, e, by_h * h);
                let h_after = mul_add::<FUSED>(cos, h, -by_e * e);
                let f_after = mul_add::<FUSED>(cos, f, by_h * g);
                let g_after = mul_add::<FUSED>(cos, g, -by_e * f);
                (last[0][i], last[1][i], last[2][i], last[3][i]) = (e_after, h_after, f_after, g_after);
                (after[0][i], after[1][i], after[2][i], after[3][i]) = (e_after, h_after, f_after, g_after);
            }
            if place % SCALED == SCALED - 1 {
                let scale = &mut self.scales[place / SCALED];
                for i in 0..BLOCK {
                    let e = larger(last[0][i].abs(), last[2][i].abs());
                    scale[i] = 1.0 / larger(e, larger(last[1][i].abs(), last[3][i].abs()));
                    for part in &mut last {
                        part[i] *= scale[i];
                    }
                }
                *after = last;
            }
        }
    }

    /// dR/d(fields) where the light comes in, the factor `(D - N) / D²`, and N and its part by the ambient medium,
    ///
    /// ```text
    /// dR = (D - N) / D² · (dN - N d(ln y Y_base)),   D = N + 4 y Y_base
    /// ```
    #[inline(always)]
    fn edge<const FUSED: bool>(&self, outside: &Block) -> (Pairs, Block, (Block, Block)) {
        let (mut slope, mut factor, mut lost): (Pairs, _, _) = ([ZERO; 4], ZERO, (ZERO, ZERO));
        let fields = &self.fields[self.fields.len() - 1];
        for i in 0..BLOCK {
            let (y, [e, h, f, g]) = (outside[i], [fields[0][i], fields[1][i], fields[2][i], fields[3][i]]);
            let (re, im) = (mul_add::<FUSED>(y, e, g), mul_add::<FUSED>(y, f, -h));
            let (other_re, other_im) = (mul_add::<FUSED>(y, e, -g), mul_add::<FUSED>(y, f, h));
            let numerator = mul_add::<FUSED>(re, re, im * im);
            let inverse = 1.0 / mul_add::<FUSED>(other_re, other_re, other_im * other_im);
            factor[i] = (1.0 - numerator * inverse) * inverse;
            let twice = 2.0 * factor[i];
            (slope[0][i], slope[1][i]) = (twice * y * re, -twice * im);
            (slope[2][i], slope[3][i]) = (twice * y * im, twice * re);
            lost.0[i] = numerator;
            lost.1[i] = mul_add::<FUSED>(2.0 * y, mul_add::<FUSED>(re, e, im * f), -numerator);
        }
        (slope, factor, lost)
    }
}

#[cfg(test)]
mod tests;
