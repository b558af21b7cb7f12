//! Sums of products of lists, in vector code.

use crate::numerics::fused::{fused_or_not, mul_add};
use multiversion::multiversion;

/// Terms that are added up side by side: the order of the sum is fixed, whatever the vector registers.
const LANES: usize = 16;

/// `sum_i a_i b_i`; terms beyond the shorter list are left out.
///
/// ```
/// use morpho_fit::numerics::dot::dot;
/// assert_eq!(dot(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0]), 32.0);
/// ```
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    of_equal(&a[..length], &b[..length])
}

#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
fn of_equal(a: &[f64], b: &[f64]) -> f64 {
    let (a_chunks, a_rest) = a.as_chunks::<LANES>();
    let (b_chunks, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// `sum_i p_i x_i²` and `sum_i q_i x_i`; all as long as the first.
#[multiversion(targets("x86_64+avx512f+avx512dq", "x86_64+avx2"))]
pub(crate) fn square_and_product(x: &[f64], [p, q]: [&[f64]; 2]) -> (f64, f64) {
    let (whole, rest) = x.as_chunks::<LANES>();
    let [(p, p_rest), (q, q_rest)] = [p, q].map(|list| list[..x.len()].as_chunks::<LANES>());
    let (mut squares, mut products) = ([0.0; LANES], [0.0; LANES]);
    for ((x, p), q) in whole.iter().zip(p).zip(q) {
        for lane in 0..LANES {
            squares[lane] += p[lane] * x[lane] * x[lane];
            products[lane] += q[lane] * x[lane];
        }
    }
    let square: f64 = rest.iter().zip(p_rest).map(|(x, p)| p * x * x).sum();
    let product: f64 = rest.iter().zip(q_rest).map(|(x, q)| q * x).sum();
    (squares.iter().sum::<f64>() + square, products.iter().sum::<f64>() + product)
}

/// Terms of nine sums that are added up side by side: with more, the sums leave the registers of AVX2.
const FEW: usize = 4;

/// `sum_i x_ji y_ki` of three lists with three others, in half the time of nine [`dot`]; all as long as the first.
///
/// Wider registers were not faster.
#[multiversion(targets("x86_64+avx2+fma"))]
pub(crate) fn three_by_three(x: [&[f64]; 3], y: [&[f64]; 3]) -> [[f64; 3]; 3] {
    fused_or_not!(tile(x, y))
}

#[inline(always)]
fn tile<const FUSED: bool>([a, b, c]: [&[f64]; 3], [d, e, f]: [&[f64]; 3]) -> [[f64; 3]; 3] {
    let length = a.len();
    let whole = length / FEW;
    let ((a, a_rest), (b, b_rest), (c, c_rest)) = (chunks(a, length), chunks(b, length), chunks(c, length));
    let ((d, d_rest), (e, e_rest), (f, f_rest)) = (chunks(d, length), chunks(e, length), chunks(f, length));
    let mut sums = [[[0.0; FEW]; 3]; 3];
    for i in 0..whole {
        sums[0][0] = add::<FUSED>(a[i], d[i], sums[0][0]);
        sums[0][1] = add::<FUSED>(a[i], e[i], sums[0][1]);
        sums[0][2] = add::<FUSED>(a[i], f[i], sums[0][2]);
        sums[1][0] = add::<FUSED>(b[i], d[i], sums[1][0]);
        sums[1][1] = add::<FUSED>(b[i], e[i], sums[1][1]);
        sums[1][2] = add::<FUSED>(b[i], f[i], sums[1][2]);
        sums[2][0] = add::<FUSED>(c[i], d[i], sums[2][0]);
        sums[2][1] = add::<FUSED>(c[i], e[i], sums[2][1]);
        sums[2][2] = add::<FUSED>(c[i], f[i], sums[2][2]);
    }
    total(&sums, [a_rest, b_rest, c_rest], [d_rest, e_rest, f_rest])
}

#[inline(always)]
fn chunks(list: &[f64], length: usize) -> (&[[f64; FEW]], &[f64]) {
    let (whole, rest) = list[..length].as_chunks::<FEW>();
    (&whole[..length / FEW], rest)
}

#[inline(always)]
fn add<const FUSED: bool>(a: [f64; FEW], b: [f64; FEW], c: [f64; FEW]) -> [f64; FEW] {
    let mut sum = [0.0; FEW];
    for lane in 0..FEW {
        sum[lane] = mul_add::<FUSED>(a[lane], b[lane], c[lane]);
    }
    sum
}

/// The lanes together and what is left over; apart from the loop, whose sums then stay in registers.
#[inline(never)]
fn total(sums: &[[[f64; FEW]; 3]; 3], x: [&[f64]; 3], y: [&[f64]; 3]) -> [[f64; 3]; 3] {
    let mut all = [[0.0; 3]; 3];
    for (j, x) in x.iter().enumerate() {
        for (k, y) in y.iter().enumerate() {
            let rest: f64 = x.iter().zip(*y).map(|(x, y)| x * y).sum();
            all[j][k] = sums[j][k].iter().sum::<f64>() + rest;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_sums_are_those_of_each_pair() {
        for length in [0, 1, 4, 7, 100, 103] {
            let list = |phase: f64| (0..length).map(|i| (phase + 0.3 * f64::from(i)).sin()).collect::<Vec<f64>>();
            let (x, y) = ([0.0, 1.0, 2.0].map(list), [3.0, 4.0, 5.0].map(list));
            let (of_x, of_y) = (x.each_ref().map(Vec::as_slice), y.each_ref().map(Vec::as_slice));
            let (fast, plain) = (three_by_three(of_x, of_y), tile::<false>(of_x, of_y));
            for j in 0..3 {
                for k in 0..3 {
                    let expected: f64 = x[j].iter().zip(&y[k]).map(|(x, y)| x * y).sum();
                    assert!((fast[j][k] - expected).abs() < 1e-12 && (plain[j][k] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn squares_and_products_are_those_of_their_weights() {
        for length in [0_u32, 1, 15, 16, 17, 100] {
            let x: Vec<f64> = (0..length).map(f64::from).collect();
            let ones = vec![1.0; x.len()];
            // 0³ + 1³ + ... + (n - 1)³ and 0² + 1² + ... + (n - 1)²
            let n = f64::from(length);
            let (cubes, squares) = ((0.5 * n * (n - 1.0)).powi(2), (n - 1.0) * n * (2.0 * n - 1.0) / 6.0);
            let (square, product) = square_and_product(&x, [&x, &x]);
            assert!((square - cubes).abs() < 1e-6 && (product - squares).abs() < 1e-9);
            assert!((square_and_product(&x, [&ones, &x]).0 - squares).abs() < 1e-9);
        }
    }

    #[test]
    fn whole_and_broken_blocks_are_summed() {
        for length in [0_u32, 1, 15, 16, 17, 100] {
            let a: Vec<f64> = (0..length).map(f64::from).collect();
            // 0² + 1² + ... + (n - 1)²
            let n = f64::from(length);
            assert!((dot(&a, &a) - (n - 1.0) * n * (2.0 * n - 1.0) / 6.0).abs() < 1e-9);
        }
        assert!((dot(&[2.0; 20], &[3.0; 4]) - 24.0).abs() < 1e-12);
    }
}
