//! The `blend` model: the paper's structure with its physics put right.

use crate::optics::multilayer::{self, Period, SAndP, StackSlopes};
use crate::optics::{Media, OpticsError, ReflectivityModel, Stack};

/// Model A divided by its peak, and Model B exact for s and p.
///
/// Departs from the paper in four places: Snell's law the right way up; the mean of `R_s` and `R_p`, where the paper takes
/// the mean of their admittances; Model A divided by its peak `a²/2 N M²`, so that both planes are dimensionless; complex
/// indices allowed.
///
/// ```
/// use morpho_fit::geometry::{Geometry, Polarization};
/// use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
/// use morpho_fit::units::radians;
/// let model = BlendModel::default();
/// let along = Geometry { theta: radians(0.0), phi: radians(5.0), omega: radians(90.0) };
/// let intensity = model.reflectivity(&Structure::table1(), &along, Polarization::Unpolarized, 583.0)?;
/// assert!(intensity > 0.99); // on the mirror direction of a stack tilted by 2.5°
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BlendModel {
    /// Media and layer count.
    pub stack: Stack,
}

impl ReflectivityModel for BlendModel {
    fn name(&self) -> &'static str {
        "blend"
    }

    fn stack(&self) -> &Stack {
        &self.stack
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        Ok(multilayer::reflectivity_unchecked(media, period, self.stack.layers, angle))
    }

    fn stack_reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        multilayer::reflectivities_unchecked(media, wavenumbers, period, self.stack.layers, angle, out);
        Ok(())
    }

    fn stack_slopes(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [StackSlopes],
    ) -> bool {
        multilayer::slopes_unchecked(media, wavenumbers, period, self.stack.layers, angle, out)
    }
}
