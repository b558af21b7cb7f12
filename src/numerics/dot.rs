//! The sum of products of two lists, in vector code.

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

#[cfg(test)]
mod tests {
    use super::*;

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
