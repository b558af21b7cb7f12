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
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::{Join, Media, ReflectivityModel, Stack};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Nodes from the axis of the cone to its edge: so many, and so many times the square of the numerical aperture, as the
/// phases of oblique rays fall behind. To 1e-4 of R for stacks of 2 µm.
const RADIAL: [f64; 2] = [8.0, 56.0];
/// Nodes around half of the cone; the other half is its mirror image in the plane of incidence.
const AROUND: usize = 16;
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
    /// Products of the nodes of band, period and tilt.
    shifts: Vec<Shift>,
    /// Rays of the cone, ring by ring.
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

    /// The rays about `angle`; those of equal angle are one at normal incidence.
    fn beams(&self, media: &Media, angle: f64) -> Vec<Beam> {
        if self.averages.numerical_aperture <= 0.0 {
            return vec![Beam { angle, slope: 1.0, share: 1.0 }];
        }
        let (sin, cos) = angle.sin_cos();
        let of = |ray: &Ray| {
            let sin_ray = (ray.aperture / media.ambient).min(1.0);
            let cos_ray = (1.0 - sin_ray * sin_ray).sqrt();
            let beam = (cos * cos_ray + sin * sin_ray * ray.cos_azimuth).clamp(-1.0, 1.0).acos();
            let slope = (sin * cos_ray - cos * sin_ray * ray.cos_azimuth) / beam.sin().max(f64::MIN_POSITIVE);
            Beam { angle: beam, slope, share: ray.share }
        };
        if sin.abs() < f64::EPSILON {
            // All azimuths are one: the rays come in rings, whose slopes cancel.
            let ring =
                |rays: &[Ray]| Beam { slope: 0.0, share: rays.iter().map(|ray| ray.share).sum(), ..of(&rays[0]) };
            return self.rays.chunks(AROUND).map(ring).collect();
        }
        self.rays.iter().map(of).collect()
    }
}

/// One plane wave of a cone.
#[derive(Debug, Clone, Copy)]
struct Beam {
    /// Angle from the normal of the layers in the ambient medium, rad.
    angle: f64,
    /// Its derivative by the angle of the cone's axis.
    slope: f64,
    share: f64,
}

/// Rays of a pupil that is evenly filled: even in the square of the sine, and in azimuth.
fn rays(numerical_aperture: f64) -> Vec<Ray> {
    let mut rays = Vec::new();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "8 to 63")]
    let radial = (RADIAL[0] + RADIAL[1] * numerical_aperture * numerical_aperture).ceil() as usize;
    for Node { at, share } in even(radial) {
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

/// Both layers of a period longer by `by` nm in proportion, and the derivative of the factor by either thickness.
fn longer(period: Period, by: f64) -> (Period, f64, f64) {
    let whole = period.cuticle + period.gap;
    let factor = 1.0 + by / whole;
    if whole <= 0.0 || factor <= 0.0 {
        return (Period { cuticle: 0.0, gap: 0.0 }, 0.0, 0.0);
    }
    let slope = -by / (whole * whole);
    (Period { cuticle: period.cuticle * factor, gap: period.gap * factor }, factor, slope)
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

    fn join(&self) -> Join {
        self.model.join()
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
            let (period, ..) = longer(period, shift.period);
            let shifted = shifted(wavenumbers, shift.wavelength);
            for beam in self.beams(media, angle - shift.tilt) {
                self.model.stack_reflectivities(media, &shifted, period, beam.angle, &mut one)?;
                let share = beam.share * shift.share;
                for (out, one) in out.iter_mut().zip(&one) {
                    out.s += share * one.s;
                    out.p += share * one.p;
                }
            }
        }
        Ok(())
    }

    fn stack_slopes(
        &self,
        media: &Media,
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [StackSlopes],
    ) -> bool {
        out.fill(StackSlopes::default());
        let mut one = vec![StackSlopes::default(); wavenumbers.len()];
        for shift in &self.shifts {
            let (longer, factor, slope) = longer(period, shift.period);
            let shifted = shifted(wavenumbers, shift.wavelength);
            for beam in self.beams(media, angle - shift.tilt) {
                if !self.model.stack_slopes(media, &shifted, longer, beam.angle, &mut one) {
                    return false;
                }
                let share = beam.share * shift.share;
                for (out, one) in out.iter_mut().zip(&one) {
                    // Either thickness also changes the factor of both.
                    let common = |part: fn(&SAndP) -> f64| {
                        slope * (period.cuticle * part(&one.cuticle) + period.gap * part(&one.gap))
                    };
                    let (common_s, common_p) = (common(|both| both.s), common(|both| both.p));
                    out.cuticle.s += share * (factor * one.cuticle.s + common_s);
                    out.cuticle.p += share * (factor * one.cuticle.p + common_p);
                    out.gap.s += share * (factor * one.gap.s + common_s);
                    out.gap.p += share * (factor * one.gap.p + common_p);
                    out.angle.s += share * beam.slope * one.angle.s;
                    out.angle.p += share * beam.slope * one.angle.p;
                }
            }
        }
        true
    }
}

/// The wavenumbers of wavelengths longer by `by` nm.
fn shifted(wavenumbers: &[f64], by: f64) -> Vec<f64> {
    wavenumbers.iter().map(|k| k / (1.0 + by * k / std::f64::consts::TAU).max(0.1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::BlendModel;
    use approx::assert_abs_diff_eq;

    const PERIOD: Period = Period { cuticle: 62.0, gap: 141.0 };

    fn averaged(averages: Averages) -> AveragedModel {
        AveragedModel::new(Box::new(BlendModel::default()), averages).unwrap()
    }

    fn blend(wavelength: f64, period: Period, angle: f64) -> f64 {
        let model = BlendModel::default();
        model.stack_reflectivity(&model.stack.media(wavelength).unwrap(), period, angle).unwrap().mean()
    }

    fn mean_of(averages: Averages, wavelength: f64, angle: f64) -> f64 {
        let model = averaged(averages);
        model.stack_reflectivity(&model.stack().media(wavelength).unwrap(), PERIOD, angle).unwrap().mean()
    }

    #[test]
    fn no_average_changes_nothing() {
        for angle in [0.0, 0.4] {
            assert_abs_diff_eq!(
                mean_of(Averages::default(), 480.0, angle),
                blend(480.0, PERIOD, angle),
                epsilon = 1e-14
            );
        }
        assert!(Averages::default().is_none());
    }

    /// Against a sum over 400 × 400 even places, or 4001 places of the normal distribution to six deviations.
    #[test]
    fn each_average_is_that_of_a_fine_sum() {
        let normal = |function: &dyn Fn(f64) -> f64| {
            let places = (-2000..=2000).map(|i| f64::from(i) * 3e-3);
            let (sum, weight) = places.fold((0.0, 0.0), |(sum, weight), x| {
                let own = (-0.5 * x * x).exp();
                (sum + own * function(x), weight + own)
            });
            sum / weight
        };
        for wavelength in [430.0, 480.0, 520.0] {
            let band = Averages { bandwidth: 5.0, ..Averages::default() };
            let fine = normal(&|x| blend(wavelength + x * 5.0 / WIDTH, PERIOD, 0.2));
            assert_abs_diff_eq!(mean_of(band, wavelength, 0.2), fine, epsilon = 1e-4);
            let spread = Averages { period_spread: 3.0, ..Averages::default() };
            let fine = normal(&|x| blend(wavelength, longer(PERIOD, 3.0 * x).0, 0.2));
            assert_abs_diff_eq!(mean_of(spread, wavelength, 0.2), fine, epsilon = 1e-4);
            let tilt = Averages { tilt_spread: 0.05, ..Averages::default() };
            let fine = normal(&|x| blend(wavelength, PERIOD, 0.2 - 0.05 * x));
            assert_abs_diff_eq!(mean_of(tilt, wavelength, 0.2), fine, epsilon = 1e-4);
            for angle in [0.0, 0.3_f64] {
                let cone = Averages { numerical_aperture: 0.75, ..Averages::default() };
                let mut fine = 0.0;
                for ring in 0..400 {
                    let sin = 0.75 * ((f64::from(ring) + 0.5) / 400.0).sqrt();
                    for step in 0..400 {
                        let azimuth = PI * (f64::from(step) + 0.5) / 400.0;
                        let cos = angle.cos() * (1.0 - sin * sin).sqrt() + angle.sin() * sin * azimuth.cos();
                        fine += blend(wavelength, PERIOD, cos.acos()) / 160_000.0;
                    }
                }
                assert_abs_diff_eq!(mean_of(cone, wavelength, angle), fine, epsilon = 1e-4);
            }
        }
    }

    #[test]
    fn slopes_are_differences_of_the_means() {
        let averages = Averages { numerical_aperture: 0.4, bandwidth: 4.0, period_spread: 5.0, tilt_spread: 0.03 };
        let model = averaged(averages);
        let media = model.stack().media(480.0).unwrap();
        let wavenumbers = [std::f64::consts::TAU / 470.0, std::f64::consts::TAU / 500.0];
        let at = |period: Period, angle: f64| {
            let mut out = [SAndP::default(); 2];
            model.stack_reflectivities(&media, &wavenumbers, period, angle, &mut out).unwrap();
            out
        };
        let mut found = [StackSlopes::default(); 2];
        assert!(model.stack_slopes(&media, &wavenumbers, PERIOD, 0.25, &mut found));
        let step = 1e-3;
        let moved = |cuticle, gap| Period { cuticle: PERIOD.cuticle + cuticle, gap: PERIOD.gap + gap };
        for (i, found) in found.iter().enumerate() {
            let slope = |above: [SAndP; 2], below: [SAndP; 2], step: f64| (above[i].p - below[i].p) / (2.0 * step);
            let cuticle = slope(at(moved(step, 0.0), 0.25), at(moved(-step, 0.0), 0.25), step);
            let gap = slope(at(moved(0.0, step), 0.25), at(moved(0.0, -step), 0.25), step);
            let angle = slope(at(PERIOD, 0.25 + 1e-5), at(PERIOD, 0.25 - 1e-5), 1e-5);
            assert_abs_diff_eq!(found.cuticle.p, cuticle, epsilon = 1e-7);
            assert_abs_diff_eq!(found.gap.p, gap, epsilon = 1e-7);
            assert_abs_diff_eq!(found.angle.p, angle, epsilon = 1e-6);
        }
    }

    #[test]
    fn widths_out_of_range_are_errors() {
        for averages in [
            Averages { numerical_aperture: 1.2, ..Averages::default() },
            Averages { bandwidth: -1.0, ..Averages::default() },
            Averages { period_spread: f64::NAN, ..Averages::default() },
            Averages { tilt_spread: 1.0, ..Averages::default() },
        ] {
            assert!(averages.validate().is_err(), "{averages:?}");
        }
    }
}
