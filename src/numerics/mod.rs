//! Numerical methods that know neither physics nor colour, without I/O.

pub(crate) mod blocks;
pub mod dot;
pub(crate) mod exponential;
pub(crate) mod fused;
pub mod nonnegative;
pub mod normal;
pub mod quadrature;
pub mod quantile;
pub mod side_by_side;
pub mod singular;
pub mod trigonometry;
