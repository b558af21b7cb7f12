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
use crate::optics::multilayer::fields::{BLOCK, Block, Layers, Matrix, SCALED, Wave, ZERO, block_of, larger};
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
    let mut matrices = vec![Matrix::NONE; layers.kinds.len()];
    let mut path = Vec::new();
    #[allow(clippy::cast_precision_loss, reason = "a count of stacks is small")]
    let stacks = layers.stacks as f64;
    for (number, (chunk, out)) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)).enumerate() {
        let start = number * BLOCK;
        let (ambient, _) = block_of(layers.ambient, start);
        let wave = |row| Wave::new::<FUSED>(block_of(row, start), &ambient, cos);
        let base = wave(layers.base);
        let waves = [GAP, CUTICLE].map(|medium| wave(layers.media[medium]));
        let mut k = [chunk[chunk.len() - 1]; BLOCK];
        k[..chunk.len()].copy_from_slice(chunk);
        for (matrix, &(medium, thickness)) in matrices.iter_mut().zip(layers.kinds) {
            matrix.set::<FUSED>(&waves[medium], thickness, &k);
        }
        for polarization in [0, 1] {
            let mut outside = ZERO;
            for i in 0..BLOCK {
                outside[i] = if polarization == 0 { ambient[i] * cos } else { cos / ambient[i] };
            }
            let edge = Edge { polarization, outside, base: &base, waves: &waves };
            let mut whole = Whole::NONE;
            for order in layers.each() {
                edge.forwards::<FUSED>(&matrices, order, &mut path);
                edge.backwards::<FUSED>(layers, &matrices, moves, order, &path, &mut whole);
            }
            for (i, out) in out.iter_mut().enumerate() {
                // kz² = n² - n_ambient² sin²
                let turned = -ambient[i] * ambient[i] * sin * cos;
                let along = |wave: &Wave| wave.admittances[0].0[i];
                let relative = |wave: &Wave| turned / (along(wave) * along(wave));
                let by = |medium: usize| k[i] * along(&waves[medium]) * whole.phase[medium][i] / stacks;
                let mut angle = whole.base[i] * relative(&base) - whole.outside[i] * sin / cos;
                for medium in [GAP, CUTICLE] {
                    let phases = k[i] * along(&waves[medium]) * whole.length[medium][i];
                    angle += relative(&waves[medium]) * (phases + whole.admittance[medium][i]);
                }
                for (out, value) in
                    [(&mut out.gap, by(GAP)), (&mut out.cuticle, by(CUTICLE)), (&mut out.angle, angle / stacks)]
                {
                    *(if polarization == 0 { &mut out.s } else { &mut out.p }) = value;
                }
            }
        }
    }
}

/// Sums over all stacks of derivatives of R: by the phases of the layers of a medium that move, by phases times thickness, by the
/// logarithms of the admittances of the media, of the base and of the ambient medium.
struct Whole {
    phase: [Block; 2],
    length: [Block; 2],
    admittance: [Block; 2],
    base: Block,
    outside: Block,
}

impl Whole {
    const NONE: Self = Self { phase: [ZERO; 2], length: [ZERO; 2], admittance: [ZERO; 2], base: ZERO, outside: ZERO };
}

/// What is about the layers of all stacks, of one polarization.
struct Edge<'a> {
    polarization: usize,
    outside: Block,
    base: &'a Wave,
    waves: &'a [Wave; 2],
}

impl Edge<'_> {
    /// The fields behind the first layer and after each, with what they were divided by there.
    #[inline(always)]
    fn forwards<const FUSED: bool>(
        &self,
        matrices: &[Matrix],
        order: &[usize],
        path: &mut Vec<(Pairs, Option<Block>)>,
    ) {
        let base = &self.base.admittances[self.polarization].0;
        let mut fields: Pairs = [[1.0; BLOCK], ZERO, ZERO, ZERO];
        for i in 0..BLOCK {
            fields[3][i] = -base[i];
        }
        path.clear();
        path.push((fields, None));
        for (place, &kind) in order.iter().enumerate() {
            let matrix = &matrices[kind];
            let (same, by_h, by_e) =
                (&matrix.same.0, &matrix.by_h[self.polarization].0, &matrix.by_e[self.polarization].0);
            for i in 0..BLOCK {
                let [e, h, f, g] = [fields[0][i], fields[1][i], fields[2][i], fields[3][i]];
                fields[0][i] = mul_add::<FUSED>(same[i], e, by_h[i] * h);
                fields[1][i] = mul_add::<FUSED>(same[i], h, -by_e[i] * e);
                fields[2][i] = mul_add::<FUSED>(same[i], f, by_h[i] * g);
                fields[3][i] = mul_add::<FUSED>(same[i], g, -by_e[i] * f);
            }
            let scale = (place % SCALED == SCALED - 1).then(|| {
                let mut scale = ZERO;
                for i in 0..BLOCK {
                    let e = larger(fields[0][i].abs(), fields[2][i].abs());
                    scale[i] = 1.0 / larger(e, larger(fields[1][i].abs(), fields[3][i].abs()));
                    for part in &mut fields {
                        part[i] *= scale[i];
                    }
                }
                scale
            });
            path.push((fields, scale));
        }
    }

    #[inline(always)]
    fn backwards<const FUSED: bool>(
        &self,
        layers: &Layers<'_>,
        matrices: &[Matrix],
        moves: &[f64],
        order: &[usize],
        path: &[(Pairs, Option<Block>)],
        whole: &mut Whole,
    ) {
        let Some((last, _)) = path.last() else { return };
        let mut slope: Pairs = [ZERO; 4];
        // dR = (D - N) / D² · (dN - N d(ln y Y_base)),  D = N + 4 y Y_base
        let (mut factor, mut numerator) = (ZERO, ZERO);
        for i in 0..BLOCK {
            let (y, [e, h, f, g]) = (self.outside[i], [last[0][i], last[1][i], last[2][i], last[3][i]]);
            let (re, im) = (mul_add::<FUSED>(y, e, g), mul_add::<FUSED>(y, f, -h));
            let (other_re, other_im) = (mul_add::<FUSED>(y, e, -g), mul_add::<FUSED>(y, f, h));
            numerator[i] = mul_add::<FUSED>(re, re, im * im);
            let inverse = 1.0 / mul_add::<FUSED>(other_re, other_re, other_im * other_im);
            factor[i] = (1.0 - numerator[i] * inverse) * inverse;
            for (slope, value) in slope.iter_mut().zip([y * re, -im, y * im, re]) {
                slope[i] = 2.0 * factor[i] * value;
            }
            whole.outside[i] += factor[i] * (2.0 * y * mul_add::<FUSED>(re, e, im * f) - numerator[i]);
        }
        let mut after = ZERO;
        for i in 0..BLOCK {
            after[i] = mul_add::<FUSED>(slope[1][i], last[1][i], slope[3][i] * last[3][i]);
        }
        for (place, &kind) in order.iter().enumerate().rev() {
            let (Some((fields, scale)), Some((before, _)), Some(&(medium, thickness))) =
                (path.get(place + 1), path.get(place), layers.kinds.get(kind))
            else {
                return;
            };
            let (matrix, wave) = (&matrices[kind], &self.waves[medium]);
            let (same, by_h, by_e) =
                (&matrix.same.0, &matrix.by_h[self.polarization].0, &matrix.by_e[self.polarization].0);
            let (y, z) = (&wave.admittances[self.polarization].0, &wave.impedances[self.polarization].0);
            let (phase, length, admittance) =
                (&mut whole.phase[medium], &mut whole.length[medium], &mut whole.admittance[medium]);
            for i in 0..BLOCK {
                let [e, h, f, g] = [slope[0][i], slope[1][i], slope[2][i], slope[3][i]];
                let to_e = mul_add::<FUSED>(e, fields[1][i], f * fields[3][i]);
                let to_h = mul_add::<FUSED>(h, fields[0][i], g * fields[2][i]);
                let by_phase = mul_add::<FUSED>(z[i], to_e, -y[i] * to_h);
                phase[i] = mul_add::<FUSED>(moves[kind], by_phase, phase[i]);
                length[i] = mul_add::<FUSED>(thickness, by_phase, length[i]);
                slope[0][i] = mul_add::<FUSED>(same[i], e, -by_e[i] * h);
                slope[1][i] = mul_add::<FUSED>(same[i], h, by_h[i] * e);
                slope[2][i] = mul_add::<FUSED>(same[i], f, -by_e[i] * g);
                slope[3][i] = mul_add::<FUSED>(same[i], g, by_h[i] * f);
            }
            if let Some(scale) = scale {
                for part in &mut slope {
                    for i in 0..BLOCK {
                        part[i] *= scale[i];
                    }
                }
            }
            for i in 0..BLOCK {
                let own = mul_add::<FUSED>(slope[1][i], before[1][i], slope[3][i] * before[3][i]);
                admittance[i] += after[i] - own;
                after[i] = own;
            }
        }
        let base = &self.base.admittances[self.polarization].0;
        for i in 0..BLOCK {
            whole.base[i] += mul_add::<FUSED>(-slope[3][i], base[i], -factor[i] * numerator[i]);
        }
    }
}

#[cfg(test)]
mod tests;
