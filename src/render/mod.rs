//! Pictures of a wing: a square with relief, ridges that turn over it and a mask, lit by the sun (the paper's Fig. 15).
//!
//! ```text
//! XYZ(pixel) = mean over its samples of  coverage · cos_i · (share · pi · sum_λ w(λ) f(λ; w_i, w_o) + base)
//! f = [R(λ, v) · E(λ) · sinc²(k a u_x / 2) / λ] · shape(w_i, w_o),   w = illuminant · observer
//! ```
//!
//! f is the BRDF of [`HybridModel`](crate::optics::HybridModel). Only the bracket depends on the wavelength, and only through
//! `v` and `|u_x|`: the colour of any pair of directions is a table of two axes ([`ColourLookup`]) times an exact factor, so a
//! picture costs the same for any number of wavelengths. A white diffuser turned to the sun has Y = 1.
//!
//! [`Scene`] says where sun and camera are, [`Maps`] what lies on the square, [`default_maps`] makes a butterfly, [`trace`] takes
//! the picture, [`Picture::bytes`] shows it on a display.
//!
//! Relief turns normals, and neither hides, shades nor shifts. A vertical sun shades nothing. Rays marched through the relief of
//! the butterfly (`cargo run --release --example relief`) met, beside the flat square with its normals:
//!
//! | view | of the wing hidden | mean shift, sides | `ΔE₀₀` of blocks of 4 × 4 rays, mean and median |
//! |---|---|---|---|
//! | 10° | 0.00 % | 0.0004 | 0.4, 0.1 |
//! | 30° | 0.10 % | 0.0012 | 1.2, 0.6 |
//! | 50° | 0.41 % | 0.0024 | 2.0, 1.1 |
//! | 60° | 0.66 % | 0.0035 | 1.5, 0.6 |
//!
//! Less than 1 % is hidden; the differences are those of a pattern that lies two pixels further up.
//!
//! Left out: light that is scattered twice, the sky, the thickness of the wing, transmitted light and depth of field.

mod base;
mod colours;
mod error;
mod frames;
mod generate;
mod image;
mod layers;
mod maps;
mod mesh;
mod outline;
mod raster;
mod scene;
mod spectra;
mod trace;

pub use base::BROWN;
pub use colours::{ColourLookup, LookupError, Seen};
pub use error::RenderError;
pub use frames::{Turning, turned};
pub use generate::{Wing, default_maps, plain_maps};
pub use image::{Background, exposure};
pub use layers::Layers;
pub use maps::{GapMap, Maps, Point, Surface};
pub use mesh::Mesh;
pub use raster::{MOST_PIXELS, MOST_SIDE, Raster};
pub use scene::{CAMERA_DISTANCE, FIELD_OF_VIEW, HALF_SIDE, Scene};
pub use trace::{Picture, trace};
