//! Vector code over the readings of a run.

#![allow(clippy::needless_range_loop, reason = "one index into several arrays is the loop that becomes vector code")]

use multiversion::multiversion;

/// `out_i += w_i factor x_i`
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn add_scaled(out: &mut [f64], weights: &[f64], factor: f64, x: &[f64]) {
    let length = out.len();
    let (weights, x) = (&weights[..length], &x[..length]);
    for i in 0..length {
        out[i] += weights[i] * factor * x[i];
    }
}

/// `out_i += w_i factor x_i y_i`
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn add_both(out: &mut [f64], weights: &[f64], factor: f64, x: &[f64], y: &[f64]) {
    let length = out.len();
    let (weights, x, y) = (&weights[..length], &x[..length], &y[..length]);
    for i in 0..length {
        out[i] += weights[i] * factor * x[i] * y[i];
    }
}

/// Both thicknesses by the period, and the width.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn add_lamella(columns: [&mut [f64]; 3], weights: &[f64], factor: f64, slopes: [&[f64]; 2]) {
    let [air, cuticle, width] = columns;
    let length = weights.len();
    let (air, cuticle, width) = (&mut air[..length], &mut cuticle[..length], &mut width[..length]);
    let [by_period, by_width] = slopes.map(|slope| &slope[..length]);
    for i in 0..length {
        let weight = weights[i] * factor;
        air[i] += weight * by_period[i];
        cuticle[i] += weight * by_period[i];
        width[i] += weight * by_width[i];
    }
}

/// Of `R L`, where each list begins with the value; R is the same for all readings.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn along_the_lobe(
    columns: [&mut [f64]; 4],
    weights: &[f64],
    factor: f64,
    stack: [f64; 4],
    lobe: [&[f64]; 3],
) {
    add_multilayer(columns, weights, factor, stack, lobe);
}

/// L is the same for all readings.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn along_the_stack(
    columns: [&mut [f64]; 4],
    weights: &[f64],
    factor: f64,
    stack: [&[f64]; 4],
    lobe: [f64; 3],
) {
    add_multilayer(columns, weights, factor, stack, lobe);
}

/// Both differ from one reading to the next.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(super) fn along_both(
    columns: [&mut [f64]; 4],
    weights: &[f64],
    factor: f64,
    stack: [&[f64]; 4],
    lobe: [&[f64]; 3],
) {
    add_multilayer(columns, weights, factor, stack, lobe);
}

#[inline(always)]
fn add_multilayer<R: At, L: At>(columns: [&mut [f64]; 4], weights: &[f64], factor: f64, stack: [R; 4], lobe: [L; 3]) {
    let length = weights.len();
    let [air, cuticle, tilt, half_width] = columns.map(|column| &mut column[..length]);
    let [r, r_air, r_cuticle, r_tilt] = stack.map(|values| values.first(length));
    let [l, l_tilt, l_half_width] = lobe.map(|values| values.first(length));
    for i in 0..length {
        let weight = weights[i] * factor;
        let weighted = weight * l.at(i);
        air[i] += weighted * r_air.at(i);
        cuticle[i] += weighted * r_cuticle.at(i);
        tilt[i] += weighted * r_tilt.at(i) + weight * r.at(i) * l_tilt.at(i);
        half_width[i] += weight * r.at(i) * l_half_width.at(i);
    }
}

/// A quantity of each reading, or one for all.
trait At: Copy {
    fn first(self, length: usize) -> Self;
    fn at(self, reading: usize) -> f64;
}

impl At for f64 {
    #[inline(always)]
    fn first(self, _: usize) -> Self {
        self
    }

    #[inline(always)]
    fn at(self, _: usize) -> f64 {
        self
    }
}

impl At for &[f64] {
    #[inline(always)]
    fn first(self, length: usize) -> Self {
        &self[..length]
    }

    #[inline(always)]
    fn at(self, reading: usize) -> f64 {
        self[reading]
    }
}

/// Weighted residuals, `on_a A + on_b B + background w - w y`, of readings with the same factors.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(crate) fn residuals(out: &mut [f64], factors: (f64, f64, f64), parts: [&[f64]; 2], weighted: [&[f64]; 2]) {
    let (on_a, on_b, background) = factors;
    let length = out.len();
    let [a, b] = parts.map(|values| &values[..length]);
    let [weights, intensities] = weighted.map(|values| &values[..length]);
    for i in 0..length {
        out[i] = on_a * a[i] + on_b * b[i] + background * weights[i] - intensities[i];
    }
}
