//! `.bsdf` files: a surface as today's renderers load it, and measured materials that come in this form.
//!
//! - [`TensorFile`]: named arrays, the container of the RGL material database.
//! - [`MeasuredBsdf`]: a material in it, evaluated as the renderers do; spectral or red, green and blue, isotropic or not.
//! - [`tabulate`]: the [`hybrid`](crate::optics::hybrid) model as such a material, with as many nodes as a tolerance needs ([`size`]).
//! - [`certify`]: what the table keeps of the model: reciprocity, energy, values.
//!
//! The model is written with a density of facets of which four fifths lie where it has light, the same for all incidences, so that the warp of the
//! format lays the nodes of `f cos(theta_o)` there; the other factors of the format are 1.
//! No file is opened here: bytes come in, bytes go out.

mod certificate;
mod density;
mod directions;
mod error;
mod fields;
mod measured;
mod sizing;
mod source;
mod surface;
mod tabulate;
mod tensor;
mod warp;

pub use certificate::{Albedo, Certificate, Trial, certify};
pub use error::BsdfError;
pub use measured::{MeasuredBsdf, MeasuredFields, Plane};
pub use sizing::{Needs, Size, Sized, size};
pub use source::Source;
pub use surface::{Surface, albedos};
pub use tabulate::{Tabulated, tabulate};
pub use tensor::{Element, Tensor, TensorData, TensorFile};
