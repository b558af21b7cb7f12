//! A surface by its values in pairs of directions, and the light that it gives back.

use super::directions::{direction, dot, jacobian, mirrored, unsquare};
use super::tabulate::share;
use super::{BsdfError, MeasuredBsdf, Source};
use rayon::prelude::*;

/// Anything with `f cos(theta_o)` in a number of channels.
///
/// ```
/// use morpho_fit::bsdf::{BsdfError, MeasuredBsdf, Size, Surface, tabulate};
/// use std::f64::consts::FRAC_1_PI;
///
/// /// White paper, at one wavelength.
/// struct Paper;
///
/// impl Surface for Paper {
///     fn channels(&self) -> usize {
///         1
///     }
///     fn wavelengths(&self) -> Option<Vec<f64>> {
///         Some(vec![550.0])
///     }
///     fn values(&self, _: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
///         out.fill(FRAC_1_PI * outgoing[2].max(0.0));
///         Ok(())
///     }
/// }
///
/// let size = Size { azimuths: 17, angles: 16, side: 32, channels: 1 };
/// let table = MeasuredBsdf::new(tabulate(&Paper, &size, "paper")?.fields)?;
/// assert!((table.albedo(0.5, 0.0, 93)?[0] - 1.0).abs() < 0.02);
/// # Ok::<(), BsdfError>(())
/// ```
pub trait Surface: Sync {
    /// Number of channels.
    fn channels(&self) -> usize;

    /// Wavelengths of the channels, ascending, nm; none where they are red, green and blue.
    fn wavelengths(&self) -> Option<Vec<f64>>;

    /// `f cos(theta_o)` in each channel, 1/sr, of two unit vectors; 0 below the horizon.
    ///
    /// # Shape
    /// `out`: one value for each channel.
    ///
    /// # Errors
    /// [`BsdfError`] where there is no value.
    fn values(&self, incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError>;

    /// Whether there is light in any channel.
    ///
    /// # Errors
    /// As [`Surface::values`].
    fn lit(&self, incoming: [f64; 3], outgoing: [f64; 3]) -> Result<bool, BsdfError> {
        let mut values = vec![0.0; self.channels()];
        self.values(incoming, outgoing, &mut values)?;
        Ok(values.iter().any(|value| *value > 0.0))
    }

    /// Share of the light from `(theta, phi)`, rad, that leaves again, in each channel, summed over at least `points` half vectors along
    /// each side of their square.
    ///
    /// # Errors
    /// [`BsdfError`] where there is no value.
    fn albedo(&self, theta: f64, phi: f64, points: usize) -> Result<Vec<f64>, BsdfError> {
        let incoming = direction(theta, phi);
        let (mut sums, mut values) = (vec![0.0; self.channels()], vec![0.0; self.channels()]);
        let step = 0.5 * share(1, points + 1);
        for row in 0..points {
            for column in 0..points {
                // The middle of each cell.
                let place = [column, row].map(|index| share(index, points + 1) + step);
                let [theta_m, phi_m] = unsquare(place);
                let normal = direction(theta_m, phi_m);
                let Some(outgoing) = mirrored(incoming, normal) else { continue };
                self.values(incoming, outgoing, &mut values)?;
                let solid = 4.0 * step * step * jacobian(place[0], theta_m, dot(incoming, normal));
                sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += solid * value);
            }
        }
        Ok(sums)
    }
}

/// [`Surface::albedo`] of many incidences `[theta, phi]`, rad, in parallel.
///
/// # Shape
/// `[incidence][channel]`.
///
/// # Errors
/// [`BsdfError`] where there is no value.
pub fn albedos(surface: &dyn Surface, incidences: &[[f64; 2]], points: usize) -> Result<Vec<Vec<f64>>, BsdfError> {
    incidences.par_iter().map(|&[theta, phi]| surface.albedo(theta, phi, points)).collect()
}

impl Surface for Source<'_> {
    fn channels(&self) -> usize {
        Source::channels(self)
    }

    fn wavelengths(&self) -> Option<Vec<f64>> {
        Source::wavelengths(self).map(<[f64]>::to_vec)
    }

    fn values(&self, incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        self.evaluate(incoming, outgoing, out)
    }

    fn lit(&self, incoming: [f64; 3], outgoing: [f64; 3]) -> Result<bool, BsdfError> {
        Ok(self.lights(incoming, outgoing))
    }
}

impl Surface for MeasuredBsdf {
    fn channels(&self) -> usize {
        self.fields().channels()
    }

    fn wavelengths(&self) -> Option<Vec<f64>> {
        self.fields().wavelengths.as_ref().map(|all| all.iter().copied().map(f64::from).collect())
    }

    fn values(&self, incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        self.evaluate(incoming, outgoing, out)
    }
}
