//! Reference problems from outside, shared by the test binaries.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses its part")]

pub mod disorder;
pub mod misses;
pub mod more_garbow_hillstrom;
pub mod nist;
pub mod stacks;
