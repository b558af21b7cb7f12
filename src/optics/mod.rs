//! Forward models: what a structure reflects, by wavelength and geometry.
//!
//! A model joins two planes (paper section 2.4, printed with `cos 2 omega`):
//!
//! ```text
//! I = I_A cos²(omega) + I_B sin²(omega)
//! I_A = factor(a) · cos²(theta) · A² · S²      lamella diffraction, [`lamella`]
//! I_B = R(wavelength, theta - delta) · L       reflection of the tilted stack, [`multilayer`], spread by the [`lobe`]
//! ```
//!
//! [`BlendModel`] is the paper's structure with its physics put right, [`PaperModel`] the printed formulas.
//! [`HybridModel`] is one product that holds both planes. Each is a [`ReflectivityModel`], whose terms are named
//! [`Contribution`]s. [`AveragedModel`] takes the mean of any of them over what an instrument or a sample averages. What is
//! left out: scattering between ridges, and roughness.

mod averages;
mod blend;
mod error;
pub mod hybrid;
pub mod lamella;
pub mod lobe;
mod material;
pub mod multilayer;
mod paper;
mod readings;
mod stack;
mod structure;

pub use averages::{AveragedModel, Averages};
pub use blend::BlendModel;
pub use error::OpticsError;
pub use hybrid::HybridModel;
pub use material::{IndexTable, Material};
pub use paper::{Admittance, LamellaUnit, PaperModel, Snell};
pub use stack::{MAX_LAYERS, Media, Stack};
pub use structure::Structure;

use crate::geometry::{Geometry, Polarization};
use multilayer::{Period, SAndP, StackSlopes};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Name of Model A's contribution.
pub const LAMELLA: &str = "lamella";
/// Name of Model B's contribution.
pub const MULTILAYER: &str = "multilayer";

/// One named term of a model at one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contribution {
    /// [`LAMELLA`] or [`MULTILAYER`].
    pub name: &'static str,
    /// Its part of the intensity, dimensionless, with its share of the plane in it.
    pub intensity: f64,
}

/// How a model joins lamellae and multilayer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Join {
    /// A sum of the two, each with the share of its plane; see the [module](self).
    Planes,
    /// One product in every plane; see [`hybrid`].
    Product {
        /// Distance of the ridges, nm.
        ridge_spacing: f64,
    },
}

/// A forward model: intensity from structure, geometry and wavelength.
///
/// A model says how strong Model A is and what the stack reflects; the rest is common.
pub trait ReflectivityModel: std::fmt::Debug + Send + Sync {
    /// The word that chooses the model on the command line.
    fn name(&self) -> &'static str;

    /// The stack's media and layer count.
    fn stack(&self) -> &Stack;

    /// Checks what the model itself adds to its stack.
    ///
    /// # Errors
    /// [`OpticsError::OutOfRange`] with the first setting that is out of range.
    fn validate(&self) -> Result<(), OpticsError> {
        Ok(())
    }

    /// How lamellae and multilayer are joined.
    fn join(&self) -> Join {
        Join::Planes
    }

    /// Factor of Model A beside `cos²(theta) A² S²`, for a lamella `lamella_width` nm wide; 1 where it is divided by its peak.
    fn lamella_factor(&self, _lamella_width: f64) -> f64 {
        1.0
    }

    /// Derivative of [`lamella_factor`](Self::lamella_factor) by the width, 1/nm.
    fn lamella_factor_slope(&self, _lamella_width: f64) -> f64 {
        0.0
    }

    /// Whether the stack reflects what [`multilayer`] says, so that an average may take layers that differ.
    fn is_exact(&self) -> bool {
        false
    }

    /// Whether what the stack reflects is a mean over many plane waves: then it pays to ask for few angles.
    fn is_average(&self) -> bool {
        false
    }

    /// Reflectivity of the stack at `angle = theta - delta` (rad) from the normal of its layers.
    ///
    /// The inner loop of a fit, for input that was checked: [`contributions`](Self::contributions) checks it.
    ///
    /// # Errors
    /// [`OpticsError`] where the model has no answer.
    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError>;

    /// [`stack_reflectivity`](Self::stack_reflectivity) at many `wavenumbers`, `2 pi / wavelength` in 1/nm, of one angle, in
    /// media whose indices are those of `media`: one for all wavenumbers, or one for each.
    ///
    /// # Shape
    /// One value for each wavenumber; `out` is as long as they are, and there is at least one of the media.
    ///
    /// # Errors
    /// As [`stack_reflectivity`](Self::stack_reflectivity).
    fn stack_reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        let Some(&last) = media.last() else { return Ok(()) };
        let media = media.iter().copied().chain(std::iter::repeat(last));
        for ((out, wavenumber), media) in out.iter_mut().zip(wavenumbers).zip(media) {
            *out = self.stack_reflectivity(&Media { wavelength: TAU / wavenumber, ..media }, period, angle)?;
        }
        Ok(())
    }

    /// Derivatives of [`stack_reflectivities`](Self::stack_reflectivities) in exact form; `false`, and nothing written, where
    /// the model has none there: then differences stand in.
    fn stack_slopes(
        &self,
        _media: &[Media],
        _wavenumbers: &[f64],
        _period: Period,
        _angle: f64,
        _out: &mut [StackSlopes],
    ) -> bool {
        false
    }

    /// Both contributions at one reading.
    ///
    /// - `wavelength` in vacuum, nm; angles in rad, at most pi/2 in size.
    ///
    /// # Errors
    /// [`OpticsError`] for input out of range, or where the model has no answer.
    fn contributions(
        &self,
        structure: &Structure,
        geometry: &Geometry,
        polarization: Polarization,
        wavelength: f64,
    ) -> Result<[Contribution; 2], OpticsError> {
        readings::contributions(self, structure, geometry, polarization, wavelength)
    }

    /// [`contributions`](Self::contributions) at many readings of one structure, `(geometry, wavelength in nm)`: the stack is
    /// computed once for all of an angle and wavelength, and all wavelengths of an angle together.
    ///
    /// A model with contributions of its own needs both. The same as one by one to rounding; of an average over a band to the accuracy of its steps, which follow the shortest
    /// wavelength of an angle.
    ///
    /// # Shape
    /// One result for each reading, in their order.
    ///
    /// # Errors
    /// [`OpticsError`] for a model or structure out of range; that of a reading stands in its place.
    ///
    /// ```
    /// use morpho_fit::geometry::{Geometry, Polarization};
    /// use morpho_fit::optics::{AveragedModel, Averages, BlendModel, ReflectivityModel, Structure};
    /// let averages = Averages { layer_spread: 8.0, ..Averages::default() };
    /// let model = AveragedModel::new(Box::new(BlendModel::default()), averages)?;
    /// let along = Geometry { omega: std::f64::consts::FRAC_PI_2, ..Geometry::default() };
    /// let readings = [(along, 440.0), (along, 480.0)];
    /// let (blue, light) = (Structure::blue(), Polarization::Unpolarized);
    /// let found = model.contributions_at(&blue, light, &readings)?;
    /// let alone = model.contributions(&blue, &along, light, 480.0)?;
    /// assert!((found[1].clone()?[1].intensity - alone[1].intensity).abs() < 1e-14);
    /// # Ok::<(), morpho_fit::optics::OpticsError>(())
    /// ```
    fn contributions_at(
        &self,
        structure: &Structure,
        polarization: Polarization,
        readings: &[(Geometry, f64)],
    ) -> Result<Vec<Result<[Contribution; 2], OpticsError>>, OpticsError> {
        readings::contributions_at(self, structure, polarization, readings)
    }

    /// The sum of the [`contributions`](Self::contributions): what a measurement of scale 1 would read.
    ///
    /// # Errors
    /// As [`contributions`](Self::contributions).
    fn reflectivity(
        &self,
        structure: &Structure,
        geometry: &Geometry,
        polarization: Polarization,
        wavelength: f64,
    ) -> Result<f64, OpticsError> {
        let terms = self.contributions(structure, geometry, polarization, wavelength)?;
        Ok(terms.iter().map(|term| term.intensity).sum())
    }
}

/// Checks that no angle passes pi/2.
fn check_geometry(geometry: &Geometry) -> Result<(), OpticsError> {
    let Geometry { theta, phi, omega } = *geometry;
    for (quantity, angle) in [("theta", theta), ("phi", phi), ("omega", omega)] {
        let within = angle.abs() <= FRAC_PI_2 * (1.0 + f64::EPSILON);
        error::require(within, quantity, angle, "rad", "at most pi/2 in size")?;
    }
    Ok(())
}
