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
//! Where the machine has fused multiply-add it is used: the bits are the same on one machine, but not with every set of
//! vector instructions; 1e-11 apart for some hundred layers, and as their square beyond.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

mod row;
mod slopes;

use crate::numerics::blocks::{padded, put};
use crate::numerics::fused::{fused_or_not, mul_add};
use crate::numerics::trigonometry::sin_cos_fused;
use crate::optics::multilayer::periodic::{Admittances, Incidence, Rule};
use crate::optics::multilayer::{Period, SAndP};
use crate::optics::stack::Media;
use multiversion::multiversion;
use row::{Fixed, Lanes, Paths, Row, Same, rows_of};
pub(crate) use slopes::slopes;

/// Wavelengths that go together.
const WIDE: usize = 32;
/// The same at the end of a spectrum: one register of the widest machines.
const NARROW: usize = 8;

type Block<const N: usize> = [f64; N];

/// Where N of `R = N / (N + 4 Y Y)` passes this, R is 1; the product of two such numbers does not overflow.
const OPAQUE: f64 = 1e140;

/// R at each of `wavenumbers` (`2 pi / wavelength`, 1/nm), with one rule for both polarizations or one for each.
///
/// Media and their incidence are one value for all wavenumbers or one for each.
pub(crate) fn values(
    media: &[Media],
    incidences: &[Incidence],
    period: Period,
    layers: usize,
    rules: Rules,
    wavenumbers: &[f64],
    out: &mut [SAndP],
) {
    let row = |(media, incidence): (&Media, &Incidence)| {
        let of = |rule| Fixed::new(&Admittances::each(media, &incidence.cosines, rule));
        Row { y: rules.each().map(of), paths: Paths::new(media, incidence, period) }
    };
    let fill = if rules == Rules::Mean { one } else { both };
    match (media, incidences) {
        ([media], [incidence]) => fill(&[row((media, incidence))], wavenumbers, layers, out),
        _ => fill(&media.iter().zip(incidences).map(row).collect::<Vec<_>>(), wavenumbers, layers, out),
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

impl Rules {
    fn each(self) -> [Rule; 2] {
        match self {
            Self::Each => [Rule::S, Rule::P],
            Self::Mean => [Rule::Mean; 2],
        }
    }
}

/// The mean of s and p, as [`values`] with [`Rules::Each`] in media that are the same at all wavenumbers.
pub(crate) fn means(
    media: &Media,
    incidence: &Incidence,
    period: Period,
    layers: usize,
    wavenumbers: &[f64],
    out: &mut [f64],
) {
    let of = |rule| Fixed::new(&Admittances::each(media, &incidence.cosines, rule));
    mean(
        &[Row { y: Rules::Each.each().map(of), paths: Paths::new(media, incidence, period) }],
        wavenumbers,
        layers,
        out,
    );
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn one(rows: &[Row<Fixed>], wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    fused_or_not!(values_of_one(rows, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn both(rows: &[Row<Fixed>], wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    fused_or_not!(values_of_both(rows, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn mean(rows: &[Row<Fixed>], wavenumbers: &[f64], layers: usize, out: &mut [f64]) {
    fused_or_not!(values_of_both(rows, wavenumbers, layers, out));
}

/// Calls `$block` for all of a spectrum: wide blocks, then narrow ones, of which the last lies over those before, or is filled
/// up where there is no whole one. A macro: what closures do in other functions is not compiled for vector instructions.
macro_rules! along {
    ($length:expr, $block:ident::<$fused:ident>($($argument:expr),*)) => {
        let (length, mut first) = ($length, 0);
        while length - first >= WIDE {
            $block::<$fused, WIDE>($($argument,)* first);
            first += WIDE;
        }
        while first < length {
            $block::<$fused, NARROW>($($argument,)* first.min(length.saturating_sub(NARROW)));
            first += NARROW;
        }
    };
}
use along;

#[inline(always)]
fn values_of_one<const FUSED: bool>(rows: &[Row<Fixed>], wavenumbers: &[f64], layers: usize, out: &mut [SAndP]) {
    along!(wavenumbers.len(), block_of_one::<FUSED>(rows, wavenumbers, layers, out));
}

#[inline(always)]
fn block_of_one<const FUSED: bool, const N: usize>(
    rows: &[Row<Fixed>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [SAndP],
    first: usize,
) {
    let k = padded::<N>(wavenumbers, first);
    let found = if let [row] = rows {
        one_of::<FUSED, N>(&Same(row.y[0]), &Same(row.paths), &k, layers)
    } else {
        let (y, _, paths) = rows_of::<_, N>(rows, first);
        one_of::<FUSED, N>(&y, &paths, &k, layers)
    };
    put(&found, out, first);
}

#[inline(always)]
fn one_of<const FUSED: bool, const N: usize>(
    y: &impl Lanes<Fixed>,
    paths: &impl Lanes<Paths>,
    k: &Block<N>,
    layers: usize,
) -> [SAndP; N] {
    let lost = Phases::new::<FUSED>(k, paths).lost::<FUSED>(y, layers);
    let mut found = [SAndP { s: 0.0, p: 0.0 }; N];
    for i in 0..N {
        found[i] = SAndP::both(lost[i] / (lost[i] + y.at(i).through));
    }
    found
}

#[inline(always)]
fn values_of_both<const FUSED: bool>(rows: &[Row<Fixed>], wavenumbers: &[f64], layers: usize, out: &mut [impl Answer]) {
    along!(wavenumbers.len(), block_of_both::<FUSED>(rows, wavenumbers, layers, out));
}

#[inline(always)]
fn block_of_both<const FUSED: bool, const N: usize>(
    rows: &[Row<Fixed>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [impl Answer],
    first: usize,
) {
    let k = padded::<N>(wavenumbers, first);
    let found = if let [Row { y: [s, p], paths }] = rows {
        both_of::<FUSED, _, N>([&Same(*s), &Same(*p)], &Same(*paths), &k, layers)
    } else {
        let (s, p, paths) = rows_of::<_, N>(rows, first);
        both_of::<FUSED, _, N>([&s, &p], &paths, &k, layers)
    };
    put(&found, out, first);
}

#[inline(always)]
fn both_of<const FUSED: bool, A: Answer, const N: usize>(
    y: [&impl Lanes<Fixed>; 2],
    paths: &impl Lanes<Paths>,
    k: &Block<N>,
    layers: usize,
) -> [A; N] {
    let phases = Phases::new::<FUSED>(k, paths);
    let (s, p) = (phases.lost::<FUSED>(y[0], layers), phases.lost::<FUSED>(y[1], layers));
    let mut found = [A::NONE; N];
    for i in 0..N {
        found[i] = A::of([s[i], p[i]], [s[i] + y[0].at(i).through, p[i] + y[1].at(i).through]);
    }
    found
}

/// What is told of the reflectivities for s and p.
trait Answer: Copy {
    const NONE: Self;

    /// From the two parts of `R = lost / whole` for each, with one division for both: it costs as much as a sine.
    fn of(lost: [f64; 2], whole: [f64; 2]) -> Self;
}

impl Answer for SAndP {
    const NONE: Self = Self { s: 0.0, p: 0.0 };

    #[inline(always)]
    fn of([s, p]: [f64; 2], [whole_s, whole_p]: [f64; 2]) -> Self {
        let inverse = 1.0 / (whole_s * whole_p);
        let (s, p) = (s * (whole_p * inverse), p * (whole_s * inverse));
        Self { s: if s < 1.0 { s } else { 1.0 }, p: if p < 1.0 { p } else { 1.0 } }
    }
}

/// Their mean: unpolarized light.
impl Answer for f64 {
    const NONE: Self = 0.0;

    #[inline(always)]
    fn of([s, p]: [f64; 2], [whole_s, whole_p]: [f64; 2]) -> Self {
        let mean = 0.5 * (s * whole_p + p * whole_s) / (whole_s * whole_p);
        if mean < 1.0 { mean } else { 1.0 }
    }
}

/// Products of the cosines and sines of both phases, the cuticle's first.
struct Phases<const N: usize> {
    cos_cos: Block<N>,
    sin_sin: Block<N>,
    cos_sin: Block<N>,
    sin_cos: Block<N>,
}

impl<const N: usize> Phases<N> {
    #[inline(always)]
    fn new<const FUSED: bool>(k: &Block<N>, paths: &impl Lanes<Paths>) -> Self {
        let zero = [0.0; N];
        let mut phases = Self { cos_cos: zero, sin_sin: zero, cos_sin: zero, sin_cos: zero };
        for i in 0..N {
            let (sin_c, cos_c) = sin_cos_fused::<FUSED>(k[i] * paths.at(i).cuticle);
            let (sin_g, cos_g) = sin_cos_fused::<FUSED>(k[i] * paths.at(i).gap);
            phases.cos_cos[i] = cos_c * cos_g;
            phases.sin_sin[i] = sin_c * sin_g;
            phases.cos_sin[i] = cos_c * sin_g;
            phases.sin_cos[i] = sin_c * cos_g;
        }
        phases
    }

    #[inline(always)]
    fn trace<const FUSED: bool>(&self, y: &impl Lanes<Fixed>) -> Block<N> {
        let mut trace = [0.0; N];
        for i in 0..N {
            trace[i] = mul_add::<FUSED>(-y.at(i).ratios, self.sin_sin[i], 2.0 * self.cos_cos[i]);
        }
        trace
    }

    /// The numerator N of [`super::periodic`]'s R, at most [`OPAQUE`], which what overflows is taken for.
    #[inline(always)]
    fn lost<const FUSED: bool>(&self, y: &impl Lanes<Fixed>, layers: usize) -> Block<N> {
        let (u, trace) = power::<FUSED, N>(&self.trace::<FUSED>(y), layers);
        let mut lost = [0.0; N];
        for i in 0..N {
            let y = y.at(i);
            let real = mul_add::<FUSED>(y.half_step, trace[i], u[i] * (y.contrast * self.sin_sin[i]));
            let off_diagonal = mul_add::<FUSED>(y.cos_sin, self.cos_sin[i], y.sin_cos * self.sin_cos[i]);
            let imaginary = u[i] * off_diagonal;
            let numerator = mul_add::<FUSED>(real, real, imaginary * imaginary);
            lost[i] = if numerator < OPAQUE { numerator } else { OPAQUE };
        }
        lost
    }
}

/// `U_(M-1)(x)` and `2 T_M(x)`, the trace of M periods, for `trace = 2 x`.
///
/// ```text
/// U_(2m-1) = U_(m-1) 2 T_m,   2 T_2m = (2 T_m)² - 2,   U_m = x U_(m-1) + T_m,   2 T_(m+1) = x 2 T_m + 2 (x² - 1) U_(m-1)
/// ```
#[inline(always)]
fn power<const FUSED: bool, const N: usize>(trace: &Block<N>, periods: usize) -> (Block<N>, Block<N>) {
    let (mut u, mut of_all): (Block<N>, Block<N>) = ([1.0; N], *trace);
    for odd in doublings(periods) {
        for i in 0..N {
            u[i] *= of_all[i];
            of_all[i] = mul_add::<FUSED>(of_all[i], of_all[i], -2.0);
        }
        if odd {
            for i in 0..N {
                let half = 0.5 * trace[i];
                let next = mul_add::<FUSED>(half, u[i], 0.5 * of_all[i]);
                of_all[i] = mul_add::<FUSED>(half, of_all[i], mul_add::<FUSED>(trace[i], half, -2.0) * u[i]);
                u[i] = next;
            }
        }
    }
    (u, of_all)
}

/// The binary digits of M below the first: a doubling for each, and one period more where it is `true`.
#[inline(always)]
fn doublings(periods: usize) -> impl Iterator<Item = bool> {
    let digits = usize::BITS - periods.leading_zeros();
    (0..digits.saturating_sub(1)).rev().map(move |digit| (periods >> digit) & 1 == 1)
}

#[cfg(test)]
mod tests;
