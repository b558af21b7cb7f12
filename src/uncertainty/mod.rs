//! How sure a minimum is: covariance and identifiability of a least-squares problem. Knows no optics.

pub mod covariance;
pub mod discrepancy;
pub mod goodness;
pub mod identifiability;
