//! The `morpho-fit` program.
fn main() {}
