//! The closed form at many wavelengths of one angle, in vector registers, with its derivatives.
//!
//! With `T_M`, Chebyshev's polynomial of the first kind, and `h = (Y_gap/Y_cuticle - Y_cuticle/Y_gap) / 2` the numerator of
//! [`super::periodic`] takes one product where `A11` and `A22` take four:
//!
//! ```text
//! N = (T_M (Y_ambient - Y_base) - U_(M-1) sin sin h (Y_ambient + Y_base))^2 + (U_(M-1) (Y_ambient Y_base m12 - m21))^2
//! ```
//!
//! Along a spectrum only the phases change: cosines and admittances stand still. Blocks of wavelengths go through each
//! step together, without a branch, in loops that compilers turn into vector code. Sines and cosines are taken up to a
//! common sign: half a turn more turns the sign of the whole period, which no reflectivity sees.
//!
//! The derivatives are those of [`super::periodic`]'s formulas, backwards from R to the two phases and the admittances
//! (reverse mode): three columns for little more than the value. Where the machine has fused multiply-add it is used: the bits are
//! the same on one machine, but not with every set of vector instructions, and 1e-11 apart at most.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::fused::{fused_or_not, mul_add};
use crate::numerics::trigonometry::sin_cos_fused;
use crate::optics::multilayer::periodic::{Admittances, Incidence, Rule};
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::stack::Media;
use multiversion::multiversion;

/// Wavelengths that go together: enough for vector code, few enough for the shortest spectra.
const BLOCK: usize = 32;

type Block = [f64; BLOCK];

/// Where N of `R = N / (N + 4 Y Y)` passes this, R is 1; the product of two such numbers does not overflow.
const OPAQUE: f64 = 1e140;

/// What stands still along a spectrum, for one set of admittances.
#[derive(Debug, Clone, Copy)]
struct Fixed {
    /// `y_gap / y_cuticle + y_cuticle / y_gap`.
    ratios: f64,
    /// `(y_ambient - y_base) / 2`.
    half_step: f64,
    /// `(y_ambient + y_base)(y_cuticle / y_gap - y_gap / y_cuticle) / 2`.
    contrast: f64,
    /// `y_ambient y_base m12 - m21` by its two products of sines and cosines: that of cos(cuticle) sin(gap), of
    /// sin(cuticle) cos(gap).
    cos_sin: f64,
    sin_cos: f64,
    /// `4 y_ambient y_base`.
    through: f64,
}

impl Fixed {
    fn new(y: &Admittances) -> Self {
        let product = y.ambient * y.base;
        let (ratio, inverse) = (y.gap / y.cuticle, y.cuticle / y.gap);
        Self {
            ratios: ratio + inverse,
            half_step: 0.5 * (y.ambient - y.base),
            contrast: 0.5 * (y.ambient + y.base) * (inverse - ratio),
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
        let (ratio, inverse) = (y.gap / y.cuticle, y.cuticle / y.gap);
        let by_ratio = (slopes.gap - ratio * slopes.cuticle) / y.cuticle;
        let by_inverse = -by_ratio * inverse * inverse;
        Self {
            ratios: by_ratio + by_inverse,
            half_step: 0.5 * (slopes.ambient - slopes.base),
            contrast: 0.5
                * ((slopes.ambient + slopes.base) * (inverse - ratio) + (y.ambient + y.base) * (by_inverse - by_ratio)),
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

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn one(fixed: Fixed, paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    fused_or_not!(values_of_one(&fixed, paths, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn both(fixed: [Fixed; 2], paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    fused_or_not!(values_of_both(&fixed, paths, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn slopes_of_one(fixed: (Fixed, Fixed), paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [StackSlopes]) {
    fused_or_not!(steepness_of_one(&fixed, paths, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn slopes_of_both(
    fixed: [(Fixed, Fixed); 2],
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    fused_or_not!(steepness_of_both(&fixed, paths, wavenumbers, layers, out));
}

#[inline(always)]
fn values_of_one<const FUSED: bool>(y: &Fixed, paths: Paths, wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let lost = Phases::new::<FUSED>(&padded(chunk), paths).lost::<FUSED>(y, layers);
        for (out, lost) in out.iter_mut().zip(lost) {
            *out = SAndP::both(lost / (lost + y.through));
        }
    }
}

#[inline(always)]
fn values_of_both<const FUSED: bool>(
    y: &[Fixed; 2],
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [SAndP],
) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let k = padded(chunk);
        // A whole block is written where it belongs.
        if let Ok(whole) = <&mut [SAndP; BLOCK]>::try_from(&mut *out) {
            block_of_both::<FUSED>(y, paths, &k, layers, whole);
        } else {
            let mut found = [SAndP { s: 0.0, p: 0.0 }; BLOCK];
            block_of_both::<FUSED>(y, paths, &k, layers, &mut found);
            out.copy_from_slice(&found[..out.len()]);
        }
    }
}

#[inline(always)]
fn block_of_both<const FUSED: bool>(y: &[Fixed; 2], paths: Paths, k: &Block, layers: usize, out: &mut [SAndP; BLOCK]) {
    let phases = Phases::new::<FUSED>(k, paths);
    let (s, p) = (phases.lost::<FUSED>(&y[0], layers), phases.lost::<FUSED>(&y[1], layers));
    for i in 0..BLOCK {
        // One division for both: it costs as much as a sine.
        let (whole_s, whole_p) = (s[i] + y[0].through, p[i] + y[1].through);
        let inverse = 1.0 / (whole_s * whole_p);
        let (s, p) = (s[i] * (whole_p * inverse), p[i] * (whole_s * inverse));
        out[i] = SAndP { s: if s < 1.0 { s } else { 1.0 }, p: if p < 1.0 { p } else { 1.0 } };
    }
}

#[inline(always)]
fn steepness_of_one<const FUSED: bool>(
    y: &(Fixed, Fixed),
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let k = padded(chunk);
        let [cuticle, gap, angle] = Phases::new::<FUSED>(&k, paths).slopes::<FUSED>(y, paths, &k, layers);
        for (i, out) in out.iter_mut().enumerate() {
            let [cuticle, gap, angle] = [cuticle[i], gap[i], angle[i]].map(SAndP::both);
            *out = StackSlopes { cuticle, gap, angle };
        }
    }
}

#[inline(always)]
fn steepness_of_both<const FUSED: bool>(
    y: &[(Fixed, Fixed); 2],
    paths: Paths,
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    for (chunk, out) in wavenumbers.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let k = padded(chunk);
        let phases = Phases::new::<FUSED>(&k, paths);
        let s = phases.slopes::<FUSED>(&y[0], paths, &k, layers);
        let p = phases.slopes::<FUSED>(&y[1], paths, &k, layers);
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
    fn new<const FUSED: bool>(k: &Block, paths: Paths) -> Self {
        let zero = [0.0; BLOCK];
        let mut phases = Self { cos_cos: zero, sin_sin: zero, cos_sin: zero, sin_cos: zero };
        for i in 0..BLOCK {
            let (sin_c, cos_c) = sin_cos_fused::<FUSED>(k[i] * paths.cuticle);
            let (sin_g, cos_g) = sin_cos_fused::<FUSED>(k[i] * paths.gap);
            phases.cos_cos[i] = cos_c * cos_g;
            phases.sin_sin[i] = sin_c * sin_g;
            phases.cos_sin[i] = cos_c * sin_g;
            phases.sin_cos[i] = sin_c * cos_g;
        }
        phases
    }

    #[inline(always)]
    fn trace<const FUSED: bool>(&self, y: &Fixed) -> Block {
        let mut trace = [0.0; BLOCK];
        for i in 0..BLOCK {
            trace[i] = mul_add::<FUSED>(-y.ratios, self.sin_sin[i], 2.0 * self.cos_cos[i]);
        }
        trace
    }

    /// The numerator N of [`super::periodic`]'s R, at most [`OPAQUE`], which what overflows is taken for.
    #[inline(always)]
    fn lost<const FUSED: bool>(&self, y: &Fixed, layers: usize) -> Block {
        let (u, trace) = power::<FUSED>(&self.trace::<FUSED>(y), layers);
        let mut lost = [0.0; BLOCK];
        for i in 0..BLOCK {
            let real = mul_add::<FUSED>(y.half_step, trace[i], u[i] * (y.contrast * self.sin_sin[i]));
            let off_diagonal = mul_add::<FUSED>(y.cos_sin, self.cos_sin[i], y.sin_cos * self.sin_cos[i]);
            let imaginary = u[i] * off_diagonal;
            let numerator = mul_add::<FUSED>(real, real, imaginary * imaginary);
            lost[i] = if numerator < OPAQUE { numerator } else { OPAQUE };
        }
        lost
    }

    /// Backwards from R, its derivatives by the thickness of cuticle and gap and by the angle. Where R is 1 they are 0.
    #[inline(always)]
    fn slopes<const FUSED: bool>(
        &self,
        (y, by_angle): &(Fixed, Fixed),
        paths: Paths,
        k: &Block,
        layers: usize,
    ) -> [Block; 3] {
        let (u, trace, by_u) = power_and_slope::<FUSED>(&self.trace::<FUSED>(y), layers);
        let (mut cuticle, mut gap, mut angle) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        let periods = count(layers);
        for i in 0..BLOCK {
            let (cc, ss, cs, sc) = (self.cos_cos[i], self.sin_sin[i], self.cos_sin[i], self.sin_cos[i]);
            let (u, trace) = (u[i], trace[i]);
            let real = mul_add::<FUSED>(y.half_step, trace, u * (y.contrast * ss));
            let off_diagonal = mul_add::<FUSED>(y.cos_sin, cs, y.sin_cos * sc);
            let imaginary = u * off_diagonal;
            let numerator = mul_add::<FUSED>(real, real, imaginary * imaginary);
            let whole = 1.0 / (numerator + y.through);
            let value = numerator * whole;
            // Each name is the derivative of R by the value of that name.
            let (d_numerator, d_through) = (y.through * whole * whole, -value * whole);
            let (d_real, d_imaginary) = (2.0 * real * d_numerator, 2.0 * imaginary * d_numerator);
            let d_u = mul_add::<FUSED>(d_real * y.contrast, ss, d_imaginary * off_diagonal);
            // The trace of M periods goes with that of one as M u.
            let d_period = mul_add::<FUSED>(d_u, by_u[i], d_real * y.half_step * (periods * u));
            let d_cc = 2.0 * d_period;
            let d_ss = mul_add::<FUSED>(d_real * y.contrast, u, -d_period * y.ratios);
            let d_off = d_imaginary * u;
            let (d_cs, d_sc) = (d_off * y.cos_sin, d_off * y.sin_cos);
            let d_cuticle = d_ss * cs + d_sc * cc - d_cc * sc - d_cs * ss;
            let d_gap = d_ss * sc + d_cs * cc - d_cc * cs - d_sc * ss;
            let d_angle = k[i] * (d_cuticle * paths.by_angle.0 + d_gap * paths.by_angle.1)
                + d_real * (trace * by_angle.half_step + u * ss * by_angle.contrast)
                - d_period * ss * by_angle.ratios
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

/// `U_(M-1)(x)` and `2 T_M(x)`, the trace of M periods, for `trace = 2 x`.
///
/// ```text
/// U_(2m-1) = U_(m-1) 2 T_m,   2 T_2m = (2 T_m)² - 2,   U_m = x U_(m-1) + T_m,   2 T_(m+1) = x 2 T_m + 2 (x² - 1) U_(m-1)
/// ```
#[inline(always)]
fn power<const FUSED: bool>(trace: &Block, periods: usize) -> (Block, Block) {
    let (mut u, mut of_all): (Block, Block) = ([1.0; BLOCK], *trace);
    for odd in doublings(periods) {
        for i in 0..BLOCK {
            u[i] *= of_all[i];
            of_all[i] = mul_add::<FUSED>(of_all[i], of_all[i], -2.0);
        }
        if odd {
            for i in 0..BLOCK {
                let half = 0.5 * trace[i];
                let next = mul_add::<FUSED>(half, u[i], 0.5 * of_all[i]);
                of_all[i] = mul_add::<FUSED>(half, of_all[i], mul_add::<FUSED>(trace[i], half, -2.0) * u[i]);
                u[i] = next;
            }
        }
    }
    (u, of_all)
}

/// [`power`], and the derivative of its first value by the trace; that of the second is `M U_(M-1)`.
#[inline(always)]
fn power_and_slope<const FUSED: bool>(trace: &Block, periods: usize) -> (Block, Block, Block) {
    let (mut u, mut of_all, mut by_u): (Block, Block, Block) = ([1.0; BLOCK], *trace, [0.0; BLOCK]);
    let mut so_far = 1.0;
    for odd in doublings(periods) {
        for i in 0..BLOCK {
            by_u[i] = mul_add::<FUSED>(by_u[i], of_all[i], so_far * u[i] * u[i]);
            u[i] *= of_all[i];
            of_all[i] = mul_add::<FUSED>(of_all[i], of_all[i], -2.0);
        }
        so_far *= 2.0;
        if odd {
            for i in 0..BLOCK {
                let half = 0.5 * trace[i];
                by_u[i] = mul_add::<FUSED>(half, by_u[i], 0.5 * (1.0 + so_far) * u[i]);
                let next = mul_add::<FUSED>(half, u[i], 0.5 * of_all[i]);
                of_all[i] = mul_add::<FUSED>(half, of_all[i], mul_add::<FUSED>(trace[i], half, -2.0) * u[i]);
                u[i] = next;
            }
            so_far += 1.0;
        }
    }
    (u, of_all, by_u)
}

/// The binary digits of M below the first: a doubling for each, and one period more where it is `true`.
#[inline(always)]
fn doublings(periods: usize) -> impl Iterator<Item = bool> {
    let digits = usize::BITS - periods.leading_zeros();
    (0..digits.saturating_sub(1)).rev().map(move |digit| (periods >> digit) & 1 == 1)
}

#[inline(always)]
fn count(layers: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
    let count = layers as f64;
    count
}

#[cfg(test)]
mod tests;
