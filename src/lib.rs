//! Fits layer thicknesses to the angular reflectivity of structurally coloured surfaces.
//!
//! A wing scale of a *Morpho* butterfly carries trees of thin cuticle shelves with air between them. Its colour depends
//! on five numbers, and this library finds them from a measurement:
//!
//! | symbol | identifier | unit | meaning |
//! |---|---|---|---|
//! | `d_air` | `d_air` | nm | thickness of one air gap |
//! | `d_cuticle` | `d_cuticle` | nm | thickness of one cuticle layer |
//! | δ | `delta` | rad | mean tilt of the layers |
//! | `φ_α` | `phi_alpha` | rad | half-width of the lobe that their curvature makes |
//! | a | `lamella_width` | nm | width of a lamella |
//!
//! Given readings `y_i` with standard deviations `σ_i`, it minimises
//!
//! ```text
//! chi² = sum_i ((y_i - scale (weight I_A cos² ω + I_B sin² ω) - background) / σ_i)²
//! ```
//!
//! over the five within bounds, with scale, weight and background eliminated at each point, and says how sure each number
//! is, which of them the data cannot tell, and which other structures fit as well.
//!
//! ```
//! use morpho_fit::inversion::{FitSettings, fit};
//! use morpho_fit::optics::{BlendModel, Structure};
//! use morpho_fit::synthetic::{Scan, simulate};
//!
//! let (model, truth) = (BlendModel::default(), Structure::blue());
//! let data = simulate(&model, &truth, &Scan::full_design(&model, &truth)?, 1.0, 0.01, 1)?;
//! let outcome = fit(&data, &FitSettings::default(), &|_| {})?.outcome;
//! assert!((outcome.derived.period.value.unwrap() - 203.0).abs() < 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! - Inside the library a bare `f64` is in nanometres, in radians, or dimensionless; users write degrees, and results
//!   ([`inversion::FitOutcome`]) are in the user's units. Nothing guesses a unit.
//! - Angles of incidence and view are signed, from the scale normal, **both the same way round**: the mirror direction
//!   of an untilted surface is `φ = -θ`. `ω = 0` is the plane across the ridges, `ω = 90°` along them ([`geometry`]).
//! - Time factor `exp(-iωt)`: `n + ik` absorbs for `k > 0`. Unpolarised light is the mean of s and p.
//!
//! # Scope
//!
//! In: the two models of Iwasawa, Shichijo and Kawaguchi, *Rendering methods for models with complicated micro
//! structures*, as printed and put right; any stack `ambient | (cuticle, gap) × layers | base`; the fit. Out: full-wave
//! simulation, rough or random structures, pigment, and colour of anything that is not a layer.
//!
//! Imports run downwards: `units`, `numerics` · `geometry`, `spectrum` · `optics`, `colorimetry`, `dataset`, `optimise` ·
//! `uncertainty`, `synthetic`, `sweep`, `table`, `bsdf` · `inversion`, `render` · `tradeoff` · `plot`, `export` · `report` · `python`
//! (feature `python`). Only the program touches files, terminal and clock.
#![cfg_attr(
    not(test),
    warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout, clippy::print_stderr)
)]

pub mod bsdf;
pub mod colorimetry;
pub mod dataset;
pub mod export;
pub mod geometry;
pub mod inversion;
pub mod numerics;
pub mod optics;
pub mod optimise;
pub mod plot;
pub mod render;
pub mod report;
pub mod spectrum;
pub mod sweep;
pub mod synthetic;
pub mod table;
#[cfg(feature = "tradeoff")]
pub mod tradeoff;
pub mod uncertainty;
pub mod units;

#[cfg(feature = "python")]
mod python;
