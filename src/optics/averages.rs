//! What an instrument and a sample average over: a cone of light, a bandwidth, thicknesses and tilts that differ.
//!
//! ```text
//! R = mean over the cone, the band, the spread  of  R(wavelength + w, thicknesses + t, angle)
//! ```
//!
//! Each average is off until its width is above 0. They act on the stack of Model B, the sharpest function of the model; the
//! lobe, which is itself a spread of tilts, and Model A are taken in the middle. Averages multiply: each costs its number
//! of [nodes](Averages) times the stack.

use crate::numerics::quadrature::{Node, even, normal};
use crate::optics::error::{OpticsError, require};
use crate::optics::multilayer::{Period, SAndP, StackSlopes, THICKNESSES};
use crate::optics::{Media, ReflectivityModel, Stack};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Nodes from the axis of the cone to its edge: to 1e-4 of R for stacks of 3 µm and a numerical aperture of 0.9.
const RADIAL: usize = 12;
/// Nodes around half of the cone; the other half is its mirror image in the plane of incidence.
const AROUND: usize = 6;
/// Nodes of the other averages: to 1e-4 of R where the width is below a quarter of a fringe.
const ACROSS: usize = 7;
/// Full width at half maximum of a normal distribution over its standard deviation.
const WIDTH: f64 = 2.354_820_045_030_949;

/// Widths that a reading is averaged over; 0 is no average.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Averages {
    /// Numerical aperture of the objective that lights and gathers, `n sin` of its outermost ray, about the direction of each
    /// reading: 0 to 0.99 of the ambient medium's index. Its pupil is evenly filled, as the sine condition has it.
    pub numerical_aperture: f64,
    /// Full width at half maximum of the instrument's band, nm; normal.
    pub bandwidth: f64,
    /// Standard deviation of the period over the spot, nm; both layers in proportion; normal.
    pub period_spread: f64,
    /// Standard deviation of the tilt over the spot, rad; normal.
    pub tilt_spread: f64,
}

impl Averages {
    /// Whether nothing is averaged.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Checks each width.
    ///
    /// # Errors
    /// [`OpticsError::OutOfRange`] for a numerical aperture outside 0 to 0.99, a bandwidth or spread outside 0 to 200 nm, or a
    /// spread of the tilt outside 0 to 0.5 rad.
    pub fn validate(&self) -> Result<(), OpticsError> {
        let Self { numerical_aperture, bandwidth, period_spread, tilt_spread } = *self;
        require((0.0..=0.99).contains(&numerical_aperture), "numerical aperture", numerical_aperture, "", "0 to 0.99")?;
        require((0.0..=200.0).contains(&bandwidth), "bandwidth", bandwidth, "nm", "0 to 200")?;
        require((0.0..=200.0).contains(&period_spread), "spread of the period", period_spread, "nm", "0 to 200")?;
        require((0.0..=0.5).contains(&tilt_spread), "spread of the tilt", tilt_spread, "rad", "0 to 0.5")
    }
}

/// A forward model whose stack is averaged.
///
/// ```
/// use morpho_fit::optics::{AveragedModel, Averages, BlendModel, ReflectivityModel, multilayer::Period};
/// let averages = Averages { numerical_aperture: 0.5, ..Averages::default() };
/// let model = AveragedModel::new(Box::new(BlendModel::default()), averages)?;
/// let (media, period) = (model.stack().media(583.0)?, Period { cuticle: 100.0, gap: 135.0 });
/// let seen = model.stack_reflectivity(&media, period, 0.0)?;
/// assert!(seen.s < 0.9985); // oblique rays leave the band: a plane wave reads 0.9986
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
#[derive(Debug)]
pub struct AveragedModel {
    model: Box<dyn ReflectivityModel>,
    averages: Averages,
    /// Products of the nodes of band, period and tilt: relative shift of the wavenumber is by wavelength, so nm.
    shifts: Vec<Shift>,
    /// Polar angle in the ambient medium and azimuth of each ray of the cone, with its share.
    rays: Vec<Ray>,
}

#[derive(Debug, Clone, Copy)]
struct Shift {
    wavelength: f64,
    period: f64,
    tilt: f64,
    share: f64,
}

#[derive(Debug, Clone, Copy)]
struct Ray {
    /// Sine of the angle from the axis times the index of the ambient medium.
    aperture: f64,
    /// Cosine of the azimuth from the plane of incidence.
    cos_azimuth: f64,
    share: f64,
}

impl AveragedModel {
    /// `model` averaged over `averages`.
    ///
    /// # Errors
    /// As [`Averages::validate`].
    pub fn new(model: Box<dyn ReflectivityModel>, averages: Averages) -> Result<Self, OpticsError> {
        averages.validate()?;
        let across = |width: f64| if width > 0.0 { normal(ACROSS) } else { normal(1) };
        let mut shifts = Vec::new();
        for band in across(averages.bandwidth) {
            for period in across(averages.period_spread) {
                for tilt in across(averages.tilt_spread) {
                    shifts.push(Shift {
                        wavelength: band.at * averages.bandwidth / WIDTH,
                        period: period.at * averages.period_spread,
                        tilt: tilt.at * averages.tilt_spread,
                        share: band.share * period.share * tilt.share,
                    });
                }
            }
        }
        Ok(Self { model, averages, shifts, rays: rays(averages.numerical_aperture) })
    }

    /// Angles from the layers' normal of the rays about `angle`, with their shares; those of equal angle are one at normal
    /// incidence.
    fn angles(&self, media: &Media, angle: f64) -> Vec<(f64, f64)> {
        if self.averages.numerical_aperture <= 0.0 {
            return vec![(angle, 1.0)];
        }
        let (sin, cos) = angle.sin_cos();
        let of = |ray: &Ray| {
            let sin_ray = (ray.aperture / media.ambient).min(1.0);
            let cos_ray = (1.0 - sin_ray * sin_ray).sqrt();
            (cos * cos_ray + sin * sin_ray * ray.cos_azimuth).clamp(-1.0, 1.0).acos()
        };
        if sin.abs() < f64::EPSILON {
            // All azimuths are one: the rays come in rings.
            return self.rays.chunk_by(|a, b| a.aperture.to_bits() == b.aperture.to_bits())
                .map(|ring| (of(&ring[0]), ring.iter().map(|ray| ray.share).sum()))
                .collect();
        }
        self.rays.iter().map(|ray| (of(ray), ray.share)).collect()
    }
}

/// Rays of a pupil that is evenly filled: even in the square of the sine, and in azimuth.
fn rays(numerical_aperture: f64) -> Vec<Ray> {
    let mut rays = Vec::new();
    for Node { at, share } in even(RADIAL) {
        for step in 0..AROUND {
            #[allow(clippy::cast_precision_loss, reason = "a few nodes")]
            let azimuth = PI * (step as f64 + 0.5) / AROUND as f64;
            let aperture = numerical_aperture * (0.5 * (1.0 + at)).sqrt();
            #[allow(clippy::cast_precision_loss, reason = "a few nodes")]
            rays.push(Ray { aperture, cos_azimuth: azimuth.cos(), share: share / AROUND as f64 });
        }
    }
    rays
}

/// Both layers of a period that is longer by `by` nm; neither below the least thickness.
fn longer(period: Period, by: f64) -> (Period, f64) {
    let whole = period.cuticle + period.gap;
    let factor = if whole > 0.0 { (1.0 + by / whole).max(0.0) } else { 1.0 };
    let least = *THICKNESSES.start();
    (Period { cuticle: (period.cuticle * factor).max(least), gap: (period.gap * factor).max(least) }, factor)
}

impl ReflectivityModel for AveragedModel {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn stack(&self) -> &Stack {
        self.model.stack()
    }

    fn validate(&self) -> Result<(), OpticsError> {
        self.averages.validate()?;
        self.model.validate()
    }

    fn lamella_factor(&self, lamella_width: f64) -> f64 {
        self.model.lamella_factor(lamella_width)
    }

    fn lamella_factor_slope(&self, lamella_width: f64) -> f64 {
        self.model.lamella_factor_slope(lamella_width)
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        let mut mean = [SAndP::default()];
        self.stack_reflectivities(media, &[std::f64::consts::TAU / media.wavelength], period, angle, &mut mean)?;
        Ok(mean[0])
    }

    fn stack_reflectivities(
        &self,
        media: &Media,
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        out.fill(SAndP::default());
        let mut one = vec![SAndP::default(); wavenumbers.len()];
        for shift in &self.shifts {
            let (period, _) = longer(period, shift.period);
            let shifted = shifted(wavenumbers, shift.wavelength);
            for (angle, share) in self.angles(media, angle - shift.tilt) {
                self.model.stack_reflectivities(media, &shifted, period, angle, &mut one)?;
                let share = share * shift.share;
                for (out, one) in out.iter_mut().zip(&one) {
                    out.s += share * one.s;
                    out.p += share * one.p;
                }
            }
        }
        Ok(())
    }
}

/// The wavenumbers of wavelengths longer by `by` nm.
fn shifted(wavenumbers: &[f64], by: f64) -> Vec<f64> {
    wavenumbers.iter().map(|k| k / (1.0 + by * k / std::f64::consts::TAU).max(0.1)).collect()
}
