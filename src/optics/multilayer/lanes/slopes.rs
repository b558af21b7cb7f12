//! Derivatives of the closed form by both thicknesses and the angle, in lanes.
//!
//! Backwards from R to the two phases and the admittances (reverse mode): three columns for little more than the value.
#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use crate::numerics::blocks::{padded, put};
use crate::numerics::fused::{fused_or_not, mul_add};
use crate::optics::multilayer::lanes::row::{Fixed, Lanes, Paths, Row, Same, rows_of};
use crate::optics::multilayer::lanes::{Block, NARROW, Phases, Rules, WIDE, along, doublings};
use crate::optics::multilayer::periodic::{Admittances, Incidence};
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::stack::Media;
use multiversion::multiversion;

/// Derivatives of [`values`](super::values) by both thicknesses and the angle.
pub(crate) fn slopes(
    media: &[Media],
    incidences: &[Incidence],
    period: Period,
    layers: usize,
    rules: Rules,
    wavenumbers: &[f64],
    out: &mut [StackSlopes],
) {
    let row = |(media, incidence): (&Media, &Incidence)| {
        let of = |rule| {
            let y = Admittances::each(media, &incidence.cosines, rule);
            (Fixed::new(&y), Fixed::slopes(&y, &incidence.admittance_slopes(media, rule)))
        };
        Row { y: rules.each().map(of), paths: Paths::new(media, incidence, period) }
    };
    let fill = if rules == Rules::Mean { slopes_of_one } else { slopes_of_both };
    match (media, incidences) {
        ([media], [incidence]) => fill(&[row((media, incidence))], wavenumbers, layers, out),
        _ => fill(&media.iter().zip(incidences).map(row).collect::<Vec<_>>(), wavenumbers, layers, out),
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn slopes_of_one(rows: &[Row<(Fixed, Fixed)>], wavenumbers: &[f64], layers: usize, out: &mut [StackSlopes]) {
    fused_or_not!(steepness_of_one(rows, wavenumbers, layers, out));
}

#[multiversion(targets("x86_64+avx512f+avx512dq+fma", "x86_64+avx2+fma"))]
fn slopes_of_both(rows: &[Row<(Fixed, Fixed)>], wavenumbers: &[f64], layers: usize, out: &mut [StackSlopes]) {
    fused_or_not!(steepness_of_both(rows, wavenumbers, layers, out));
}

#[inline(always)]
fn steepness_of_one<const FUSED: bool>(
    rows: &[Row<(Fixed, Fixed)>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    along!(wavenumbers.len(), block_of_one::<FUSED>(rows, wavenumbers, layers, out));
}

#[inline(always)]
fn block_of_one<const FUSED: bool, const N: usize>(
    rows: &[Row<(Fixed, Fixed)>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
    first: usize,
) {
    let k = padded::<N>(wavenumbers, first);
    let one = if let [Row { y: [y, _], paths }] = rows {
        Phases::new::<FUSED>(&k, &Same(*paths)).slopes::<FUSED>(&Same(*y), &Same(*paths), &k, layers)
    } else {
        let (y, _, paths) = rows_of::<_, N>(rows, first);
        Phases::new::<FUSED>(&k, &paths).slopes::<FUSED>(&y, &paths, &k, layers)
    };
    put_both([&one, &one], out, first);
}

#[inline(always)]
pub(super) fn steepness_of_both<const FUSED: bool>(
    rows: &[Row<(Fixed, Fixed)>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
) {
    along!(wavenumbers.len(), block_of_both::<FUSED>(rows, wavenumbers, layers, out));
}

#[inline(always)]
fn block_of_both<const FUSED: bool, const N: usize>(
    rows: &[Row<(Fixed, Fixed)>],
    wavenumbers: &[f64],
    layers: usize,
    out: &mut [StackSlopes],
    first: usize,
) {
    let k = padded::<N>(wavenumbers, first);
    let [s, p] = if let [Row { y: [s, p], paths }] = rows {
        let phases = Phases::new::<FUSED>(&k, &Same(*paths));
        let paths = Same(*paths);
        [phases.slopes::<FUSED>(&Same(*s), &paths, &k, layers), phases.slopes::<FUSED>(&Same(*p), &paths, &k, layers)]
    } else {
        let (s, p, paths) = rows_of::<_, N>(rows, first);
        let phases = Phases::new::<FUSED>(&k, &paths);
        [phases.slopes::<FUSED>(&s, &paths, &k, layers), phases.slopes::<FUSED>(&p, &paths, &k, layers)]
    };
    put_both([&s, &p], out, first);
}

/// Writes the slopes of a block for s and for p.
#[inline(always)]
fn put_both<const N: usize>([s, p]: [&[Block<N>; 3]; 2], out: &mut [StackSlopes], first: usize) {
    let mut found = [StackSlopes::default(); N];
    for i in 0..N {
        let [cuticle, gap, angle] = [0, 1, 2].map(|by| SAndP { s: s[by][i], p: p[by][i] });
        found[i] = StackSlopes { cuticle, gap, angle };
    }
    put(&found, out, first);
}

impl<const N: usize> Phases<N> {
    /// Backwards from R, its derivatives by the thickness of cuticle and gap and by the angle. Where R is 1 they are 0.
    #[inline(always)]
    fn slopes<const FUSED: bool>(
        &self,
        y: &impl Lanes<(Fixed, Fixed)>,
        paths: &impl Lanes<Paths>,
        k: &Block<N>,
        layers: usize,
    ) -> [Block<N>; 3] {
        let mut trace = [0.0; N];
        for i in 0..N {
            trace[i] = mul_add::<FUSED>(-y.at(i).0.ratios, self.sin_sin[i], 2.0 * self.cos_cos[i]);
        }
        let (u, trace, by_u) = power_and_slope::<FUSED, N>(&trace, layers);
        let (mut cuticle, mut gap, mut angle) = ([0.0; N], [0.0; N], [0.0; N]);
        let periods = count(layers);
        for i in 0..N {
            let (cc, ss, cs, sc) = (self.cos_cos[i], self.sin_sin[i], self.cos_sin[i], self.sin_cos[i]);
            let (u, trace, (y, by_angle), paths) = (u[i], trace[i], y.at(i), paths.at(i));
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

/// [`power`](super::power), and the derivative of its first value by the trace; that of the second is `M U_(M-1)`.
#[inline(always)]
fn power_and_slope<const FUSED: bool, const N: usize>(
    trace: &Block<N>,
    periods: usize,
) -> (Block<N>, Block<N>, Block<N>) {
    let (mut u, mut of_all, mut by_u): (Block<N>, Block<N>, Block<N>) = ([1.0; N], *trace, [0.0; N]);
    let mut so_far = 1.0;
    for odd in doublings(periods) {
        for i in 0..N {
            by_u[i] = mul_add::<FUSED>(by_u[i], of_all[i], so_far * u[i] * u[i]);
            u[i] *= of_all[i];
            of_all[i] = mul_add::<FUSED>(of_all[i], of_all[i], -2.0);
        }
        so_far *= 2.0;
        if odd {
            for i in 0..N {
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

#[inline(always)]
fn count(layers: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
    let count = layers as f64;
    count
}
