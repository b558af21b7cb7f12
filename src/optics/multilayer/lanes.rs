//! The closed form at many wavelengths of one angle, in vector registers, with its derivatives.
//!
//! Along a spectrum only the phases change: cosines and admittances stand still. Blocks of wavelengths go through each
//! step together, without a branch, in loops that compilers turn into vector code. Sines and cosines are taken up to a
//! common sign: half a turn more turns the sign of the whole period, which no reflectivity sees.
//!
//! The derivatives are those of [`super::periodic`]'s formulas, backwards from R to the two phases and the admittances
//! (reverse mode): three columns for little more than the value. The same bits with every set of vector instructions:
//! nothing is fused.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::trigonometry::sin_cos_up_to_sign;
use crate::optics::multilayer::periodic::{Admittances, Incidence, Rule};
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::stack::Media;
use multiversion::multiversion;

/// Wavelengths that go together: enough for vector code, few enough for the shortest spectra.
const BLOCK: usize = 32;

type Block = [f64; BLOCK];

/// What stands still along a spectrum, for one set of admittances.
#[derive(Debug, Clone, Copy)]
struct Fixed {
    /// `y_gap / y_cuticle` and its inverse.
    ratio: f64,
    inverse_ratio: f64,
    ambient: f64,
    base: f64,
    /// `y_a y_b m12 - m21` by its two products of sines and cosines: that of cos(cuticle) sin(gap), of sin(cuticle) cos(gap).
    cos_sin: f64,
    sin_cos: f64,
    /// `4 y_ambient y_base`.
    through: f64,
}

impl Fixed {
    fn new(y: &Admittances) -> Self {
        let product = y.ambient * y.base;
        Self {
            ratio: y.gap / y.cuticle,
            inverse_ratio: y.cuticle / y.gap,
            ambient: y.ambient,
            base: y.base,
            cos_sin: product / y.gap - y.gap,
            sin_cos: product / y.cuticle - y.cuticle,
            through: 4.0 * product,
        }
    }

    /// Derivatives of [`Fixed::new`]'s values along `slopes` of the admittances.
    fn slopes(y: &Admittances, slopes: &Admittances) -> Self {
        let product = y.ambient * y.base;
        let by_product = slopes.ambient * y.base + y.ambient * slopes.base;
        let of = |y: f64, slope: f64| by_product / y - product * slope / (y * y) - slope;
        let ratio = y.gap / y.cuticle;
        let by_ratio = (slopes.gap - ratio * slopes.cuticle) / y.cuticle;
        Self {
            ratio: by_ratio,
            inverse_ratio: -by_ratio / (ratio * ratio),
            ambient: slopes.ambient,
            base: slopes.base,
            cos_sin: of(y.gap, slopes.gap),
            sin_cos: of(y.cuticle, slopes.cuticle),
            through: 4.0 * by_product,
        }
    }
}

/// Optical path of each layer of a period, `n d cos` in nm, and its derivatives by the thickness and by the angle.
#[derive(Debug, Clone, Copy)]
struct Paths {
    cuticle: f64,
    gap: f64,
    by_thickness: (f64, f64),
    by_angle: (f64, f64),
}

impl Paths {
    fn new(media: &Media, incidence: &Incidence, period: Period) -> Self {
        let (cosines, slopes) = (&incidence.cosines, &incidence.slopes);
        let by_thickness = (media.cuticle.re * cosines.cuticle, media.gap.re * cosines.gap);
        Self {
            cuticle: by_thickness.0 * period.cuticle,
            gap: by_thickness.1 * period.gap,
            by_thickness,
            by_angle: (media.cuticle.re * period.cuticle * slopes.cuticle, media.gap.re * period.gap * slopes.gap),
        }
    }
}

/// R at each of `wavenumbers` (`2 pi / wavelength`, 1/nm), with one rule for both polarizations or one for each.
pub(crate) fn values(
    media: &Media,
    incidence: &Incidence,
    period: Period,
    layers: usize,
    rules: Rules,
    wavenumbers: &[f64],
    out: &mut [SAndP],
) {
    let paths = Paths::new(media, incidence, period);
    let fixed = |rule| Fixed::new(&Admittances::each(media, &incidence.cosines, rule));
    match rules {
        Rules::Mean => one(fixed(Rule::Mean), paths, wavenumbers, layers, out),
        Rules::Each => both([fixed(Rule::S), fixed(Rule::P)], paths, wavenumbers, layers, out),
    }
}

/// Derivatives of [`values`] by both thicknesses and the angle.
pub(crate) fn slopes(
    media: &Media,
    incidence: &Incidence,
    period: Period,
    layers: usize,
    rules: Rules,
    wavenumbers: &[f64],
    out: &mut [StackSlopes],
) {
    let paths = Paths::new(media, incidence, period);
    let fixed = |rule: Rule| {
        let y = Admittances::each(media, &incidence.cosines, rule);
        (Fixed::new(&y), Fixed::slopes(&y, &incidence.admittance_slopes(media, rule)))
    };
    match rules {
        Rules::Mean => slopes_of_one(fixed(Rule::Mean), paths, wavenumbers, layers, out),
        Rules::Each => slopes_of_both([fixed(Rule::S), fixed(Rule::P)], paths, wavenumbers, layers, out),
    }
}

/// Which admittances a stack is computed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rules {
    /// Those of s and of p.
    Each,
    /// Their mean for both, as the paper prints it.
    Mean,
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn one(fixed: Fixed, paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let phases = Phases::new(&padded(chunk), paths);
        let found = phases.reflectivity(&fixed, layers);
        for (out, found) in out.iter_mut().zip(found) {
            *out = SAndP::both(found);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn both(fixed: [Fixed; 2], paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let phases = Phases::new(&padded(chunk), paths);
        let s = phases.reflectivity(&fixed[0], layers);
        let p = phases.reflectivity(&fixed[1], layers);
        for ((out, s), p) in out.iter_mut().zip(s).zip(p) {
            *out = SAndP { s, p };
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn slopes_of_one(fixed: (Fixed, Fixed), paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [StackSlopes]) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let k = padded(chunk);
        let [cuticle, gap, angle] = Phases::new(&k, paths).slopes(&fixed, paths, &k, layers);
        for (i, out) in out.iter_mut().enumerate() {
            let [cuticle, gap, angle] = [cuticle[i], gap[i], angle[i]].map(SAndP::both);
            *out = StackSlopes { cuticle, gap, angle };
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn slopes_of_both(
    fixed: [(Fixed, Fixed); 2],
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let k = padded(chunk);
        let phases = Phases::new(&k, paths);
        let s = phases.slopes(&fixed[0], paths, &k, layers);
        let p = phases.slopes(&fixed[1], paths, &k, layers);
        for (i, out) in out.iter_mut().enumerate() {
            let [cuticle, gap, angle] = [0, 1, 2].map(|by| SAndP { s: s[by][i], p: p[by][i] });
            *out = StackSlopes { cuticle, gap, angle };
        }
    }
}

#[inline(always)]
fn padded(chunk: &[f64]) -> Block {
    let mut block = [0.0; BLOCK];
    block[..chunk.len()].copy_from_slice(chunk);
    block
}

/// Products of the cosines and sines of both phases, the cuticle's first.
struct Phases {
    cos_cos: Block,
    sin_sin: Block,
    cos_sin: Block,
    sin_cos: Block,
}

impl Phases {
    #[inline(always)]
    fn new(k: &Block, paths: Paths) -> Self {
        let zero = [0.0; BLOCK];
        let mut phases = Self { cos_cos: zero, sin_sin: zero, cos_sin: zero, sin_cos: zero };
        for i in 0..BLOCK {
            let (sin_c, cos_c) = sin_cos_up_to_sign(k[i] * paths.cuticle);
            let (sin_g, cos_g) = sin_cos_up_to_sign(k[i] * paths.gap);
            phases.cos_cos[i] = cos_c * cos_g;
            phases.sin_sin[i] = sin_c * sin_g;
            phases.cos_sin[i] = cos_c * sin_g;
            phases.sin_cos[i] = sin_c * cos_g;
        }
        phases
    }

    #[inline(always)]
    fn trace(&self, y: &Fixed) -> Block {
        let mut trace = [0.0; BLOCK];
        let ratios = y.ratio + y.inverse_ratio;
        for i in 0..BLOCK {
            trace[i] = 2.0 * self.cos_cos[i] - self.sin_sin[i] * ratios;
        }
        trace
    }

    /// As [`super::periodic::reflectivity`], without a branch. What overflows is opaque, and 0/0 is grazing: both are 1.
    #[inline(always)]
    fn reflectivity(&self, y: &Fixed, layers: usize) -> Block {
        let (u, v) = power(&self.trace(y), layers);
        let mut found = [0.0; BLOCK];
        for i in 0..BLOCK {
            let m11 = self.cos_cos[i] - self.sin_sin[i] * y.ratio;
            let m22 = self.cos_cos[i] - self.sin_sin[i] * y.inverse_ratio;
            let real = y.ambient * (u[i] * m11 - v[i]) - y.base * (u[i] * m22 - v[i]);
            let imaginary = u[i] * (y.cos_sin * self.cos_sin[i] + y.sin_cos * self.sin_cos[i]);
            let numerator = real * real + imaginary * imaginary;
            let ratio = numerator / (numerator + y.through);
            found[i] = if ratio <= 1.0 { ratio } else { 1.0 };
        }
        found
    }

    /// Backwards from R, its derivatives by the thickness of cuticle and gap and by the angle. Where R is 1 they are 0.
    #[inline(always)]
    fn slopes(&self, (y, by_angle): &(Fixed, Fixed), paths: Paths, k: &Block, layers: usize) -> [Block; 3] {
        let (u, v, by_u, by_v) = power_and_slope(&self.trace(y), layers);
        let (mut cuticle, mut gap, mut angle) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        let ratios = y.ratio + y.inverse_ratio;
        for i in 0..BLOCK {
            let (cc, ss, cs, sc) = (self.cos_cos[i], self.sin_sin[i], self.cos_sin[i], self.sin_cos[i]);
            let (m11, m22) = (cc - ss * y.ratio, cc - ss * y.inverse_ratio);
            let (a11, a22) = (u[i] * m11 - v[i], u[i] * m22 - v[i]);
            let real = y.ambient * a11 - y.base * a22;
            let off_diagonal = y.cos_sin * cs + y.sin_cos * sc;
            let imaginary = u[i] * off_diagonal;
            let numerator = real * real + imaginary * imaginary;
            let whole = 1.0 / (numerator + y.through);
            let value = numerator * whole;
            // Each name is the derivative of R by the value of that name.
            let (d_numerator, d_through) = (y.through * whole * whole, -value * whole);
            let (d_real, d_imaginary) = (2.0 * real * d_numerator, 2.0 * imaginary * d_numerator);
            let d_u = d_real * (y.ambient * m11 - y.base * m22) + d_imaginary * off_diagonal;
            let d_v = d_real * (y.base - y.ambient);
            let d_trace = d_u * by_u[i] + d_v * by_v[i];
            let (d_m11, d_m22) = (d_real * y.ambient * u[i], -d_real * y.base * u[i]);
            let d_cc = d_m11 + d_m22 + 2.0 * d_trace;
            let d_ss = -(d_m11 * y.ratio + d_m22 * y.inverse_ratio + d_trace * ratios);
            let d_off = d_imaginary * u[i];
            let (d_cs, d_sc) = (d_off * y.cos_sin, d_off * y.sin_cos);
            let d_cuticle = d_ss * cs + d_sc * cc - d_cc * sc - d_cs * ss;
            let d_gap = d_ss * sc + d_cs * cc - d_cc * cs - d_sc * ss;
            let d_angle = k[i] * (d_cuticle * paths.by_angle.0 + d_gap * paths.by_angle.1)
                + d_real * (a11 * by_angle.ambient - a22 * by_angle.base)
                - ss * ((d_m11 + d_trace) * by_angle.ratio + (d_m22 + d_trace) * by_angle.inverse_ratio)
                + d_off * (cs * by_angle.cos_sin + sc * by_angle.sin_cos)
                + d_through * by_angle.through;
            let inside = value < 1.0;
            cuticle[i] = if inside { d_cuticle * k[i] * paths.by_thickness.0 } else { 0.0 };
            gap[i] = if inside { d_gap * k[i] * paths.by_thickness.1 } else { 0.0 };
            angle[i] = if inside { d_angle } else { 0.0 };
        }
        [cuticle, gap, angle]
    }
}

/// `(U_(M-1)(x), U_(M-2)(x))` for `trace = 2 x`, by doubling.
#[inline(always)]
fn power(trace: &Block, periods: usize) -> (Block, Block) {
    let (mut u, mut v): (Block, Block) = ([1.0; BLOCK], [0.0; BLOCK]);
    let bits = usize::BITS - periods.leading_zeros();
    for bit in (0..bits.saturating_sub(1)).rev() {
        let odd = (periods >> bit) & 1 == 1;
        for i in 0..BLOCK {
            let doubled = u[i] * (trace[i] * u[i] - 2.0 * v[i]);
            let before = (u[i] - v[i]) * (u[i] + v[i]);
            let next = trace[i] * doubled - before;
            (u[i], v[i]) = if odd { (next, doubled) } else { (doubled, before) };
        }
    }
    (u, v)
}

/// [`power`] and its derivatives by the trace.
#[inline(always)]
fn power_and_slope(trace: &Block, periods: usize) -> (Block, Block, Block, Block) {
    let (mut u, mut v): (Block, Block) = ([1.0; BLOCK], [0.0; BLOCK]);
    let (mut by_u, mut by_v): (Block, Block) = ([0.0; BLOCK], [0.0; BLOCK]);
    let bits = usize::BITS - periods.leading_zeros();
    for bit in (0..bits.saturating_sub(1)).rev() {
        let odd = (periods >> bit) & 1 == 1;
        for i in 0..BLOCK {
            let factor = trace[i] * u[i] - 2.0 * v[i];
            let doubled = u[i] * factor;
            let by_doubled = by_u[i] * factor + u[i] * (u[i] + trace[i] * by_u[i] - 2.0 * by_v[i]);
            let before = (u[i] - v[i]) * (u[i] + v[i]);
            let by_before = 2.0 * (u[i] * by_u[i] - v[i] * by_v[i]);
            let next = trace[i] * doubled - before;
            let by_next = doubled + trace[i] * by_doubled - by_before;
            (u[i], v[i]) = if odd { (next, doubled) } else { (doubled, before) };
            (by_u[i], by_v[i]) = if odd { (by_next, by_doubled) } else { (by_doubled, by_before) };
        }
    }
    (u, v, by_u, by_v)
}

#[cfg(test)]
mod tests;
