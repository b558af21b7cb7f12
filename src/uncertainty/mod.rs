//! How sure a minimum is: covariance, identifiability, profile likelihood and posterior of a least-squares problem. Knows no
//! optics.

pub mod convergence;
pub mod covariance;
pub mod discrepancy;
pub mod goodness;
pub mod identifiability;
pub mod posterior;
pub mod profile;
