//! `a b + c`, with one rounding where the code around it is compiled for a machine that does both in one instruction.

/// `a b + c`; in one instruction if `FUSED`.
///
/// `FUSED` is for code compiled with that instruction: without it the one rounding is a call into the system library, a
/// hundred times as slow.
#[inline(always)]
pub(crate) fn mul_add<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Calls a function with `FUSED`, its only generic, as true where the `multiversion` of the function around it has the instruction.
macro_rules! fused_or_not {
    ($body:ident($($argument:expr),*)) => {
        if multiversion::target::target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
            $body::<true>($($argument),*)
        } else {
            $body::<false>($($argument),*)
        }
    };
}
pub(crate) use fused_or_not;

#[cfg(test)]
mod tests {
    use super::mul_add;

    #[test]
    fn fused_rounds_once() {
        // (1 + e)(1 - e) - 1 = -e², of which two roundings leave nothing.
        let e = f64::EPSILON;
        assert!((mul_add::<true>(1.0 + e, 1.0 - e, -1.0) / (-e * e) - 1.0).abs() < 1e-15);
        assert!(mul_add::<false>(1.0 + e, 1.0 - e, -1.0).abs() <= e);
    }
}
