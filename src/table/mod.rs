//! Colours or spectra of a structure over incidence, view and plane, tabled: a pixel looks them up.
//!
//! ```text
//! table[θ][ψ][ω] = cos² ω · A(θ, φ) + sin² ω · L(θ + φ) · B(θ),   ψ = θ + φ (or φ itself)
//! ```
//!
//! A colour is linear in its spectrum and the model is a sum of two planes, so that Model B's colour is computed once for each
//! θ, Model A's once for each direction, and two planes hold every ω ([`Source`]). Between the nodes a table is linear in θ, in
//! ψ and in sin² ω ([`Table`]). The peak, the lobe and its edge stand at fixed angles ψ from the mirror direction; on an axis of
//! φ they run diagonally through the cells, which then must be finer by far. [`choose`] takes as many nodes as a CIEDE2000
//! tolerance needs, wherever they are needed, and measures what is left.
//!
//! A model that is one product ([`Join::Product`](crate::optics::Join::Product)) has no such sum: its tables are linear in ω
//! between as many planes as it takes.

mod adaptive;
mod error;
mod lamellae;
mod lookup;
mod nodes;
mod source;

pub use adaptive::{Judged, Needs, Range, choose, judge};
pub use error::TableError;
pub use lookup::Table;
pub use nodes::{Across, Nodes, Turn};
pub use source::{Quantity, Source};
