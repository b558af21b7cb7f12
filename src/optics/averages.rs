//! What an instrument and a sample average over: a cone of light, a bandwidth, thicknesses, layers and tilts that differ.
//!
//! ```text
//! R = mean over the cone, the band, the spreads  of  R(wavelength + w, period + t, angle; deviation of each layer)
//! ```
//!
//! Each average is off until its width is above 0. They act on the stack of Model B, the sharpest function of the model; the
//! lobe, which is itself a spread of tilts, and Model A are taken in the middle. Indices are those of the middle of the band.
//!
//! Averages multiply, and each costs as many plane waves as it crosses fringes: their width is a share `1/M²` of the
//! wavelength at the edge of a band, and the phases of oblique rays fall behind as the square of the aperture. The counts
//! below hold R to 1e-3 (tests), most of it to 1e-4. Layers that differ by themselves are too many for that: see their field.

mod cone;
mod layers;
mod memory;

use crate::numerics::quadrature::{Node, normal_steps};
use crate::optics::error::{OpticsError, require};
use crate::optics::multilayer::{Period, SAndP, StackSlopes};
use crate::optics::{Join, Media, ReflectivityModel, Stack};
use crate::units::degrees;
use cone::{Beam, Cone};
use layers::{Disorder, MOST_LAYERS};
use memory::Memory;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::fmt;

/// Steps over a normal distribution for each `M²` times its relative width.
const STEPS: f64 = 30.0;
/// Steps at least and at most.
const FEWEST: usize = 16;
const MOST: usize = 1024;
/// Plane waves of all wavelengths beyond which an answer is remembered: some microseconds.
const DEAR: usize = 1000;
/// Full width at half maximum of a normal distribution over its standard deviation.
const WIDTH: f64 = 2.354_820_045_030_949;

/// Widths that a reading is averaged over; 0 is no average.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Averages {
    /// Numerical aperture of the objective that lights and gathers, `n sin` of its outermost ray, about the direction of each
    /// reading, 0 to 0.99. Its pupil is evenly filled, as the sine condition has it.
    pub numerical_aperture: f64,
    /// Full width at half maximum of the instrument's band, nm; normal. Over it the indices are those of its middle.
    pub bandwidth: f64,
    /// Standard deviation of the period over the spot, nm; both layers in proportion; normal.
    pub period_spread: f64,
    /// Standard deviation of each layer's thickness, of cuticle as of gap, nm: each by itself in every stack of the spot; normal,
    /// and a layer that would be thinner than nothing is left out.
    ///
    /// R is the mean over 961 fixed stacks, smooth in structure and angle, and is off from the mean over all stacks by
    ///
    /// | spread, nm | 9 layers: root mean square, largest | 20 layers |
    /// |---|---|---|
    /// | 1 | 1e-4, 2e-3 | 3e-4, 4e-3 |
    /// | 5 | 1e-3, 6e-3 | 2e-3, 1e-2 |
    /// | 15 | 2e-3, 1e-2 | 4e-3, 2e-2 |
    /// | 25 | 4e-3, 1e-2 | 4e-3, 2e-2 |
    ///
    /// against 262,144 random stacks in 384 readings of four structures at 0 to 75°, s and p, 385 to 729 nm. Beside other averages
    /// each of their plane waves has a share of these stacks, 31 at least. In spectra a reading costs some 1000 times that of equal layers.
    pub layer_spread: f64,
    /// Standard deviation of the tilt over the spot, rad; normal. Not beside a numerical aperture.
    pub tilt_spread: f64,
}

impl fmt::Display for Averages {
    /// What is averaged over, in the user's units; `plane waves on equal layers` without any.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tilt = (degrees(self.tilt_spread) * 1e9).round() / 1e9;
        let all = [
            (self.numerical_aperture, "numerical aperture ", ""),
            (self.bandwidth, "band ", " nm"),
            (self.period_spread, "period ± ", " nm"),
            (self.layer_spread, "each layer ± ", " nm"),
            (tilt, "tilt ± ", "°"),
        ];
        let told = all.iter().filter(|(value, ..)| *value > 0.0);
        let told: Vec<String> = told.map(|(value, before, after)| format!("{before}{value}{after}")).collect();
        if told.is_empty() { out.write_str("plane waves on equal layers") } else { out.write_str(&told.join(", ")) }
    }
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
    /// spread of the tilt outside 0 to 0.5 rad, or above 0 beside a numerical aperture.
    pub fn validate(&self) -> Result<(), OpticsError> {
        let Self { numerical_aperture, bandwidth, period_spread, layer_spread, tilt_spread } = *self;
        require((0.0..=0.99).contains(&numerical_aperture), "numerical aperture", numerical_aperture, "", "0 to 0.99")?;
        require((0.0..=200.0).contains(&bandwidth), "bandwidth", bandwidth, "nm", "0 to 200")?;
        require((0.0..=200.0).contains(&period_spread), "spread of the period", period_spread, "nm", "0 to 200")?;
        require((0.0..=200.0).contains(&layer_spread), "spread of the layers", layer_spread, "nm", "0 to 200")?;
        let tilt = degrees(tilt_spread);
        require((0.0..=0.5).contains(&tilt_spread), "spread of the tilt", tilt, "deg", "0 to 28.6")?;
        let one = numerical_aperture <= 0.0 || tilt_spread <= 0.0;
        require(one, "spread of the tilt beside a numerical aperture", tilt, "deg", "0")
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
    cone: Cone,
    /// The stacks of unequal layers; none where all are equal.
    disorder: Option<Disorder>,
    memory: Memory,
}

impl AveragedModel {
    /// `model` averaged over `averages`.
    ///
    /// # Errors
    /// As [`Averages::validate`], for a spread of the tilt of a model whose tilt moves the lobe alone, and for a spread of the
    /// layers of a model that is not [exact](ReflectivityModel::is_exact) or has more than 1000.
    pub fn new(model: Box<dyn ReflectivityModel>, averages: Averages) -> Result<Self, OpticsError> {
        averages.validate()?;
        let tilted = model.join() == Join::Planes || averages.tilt_spread <= 0.0;
        require(tilted, "spread of the tilt of the hybrid model", degrees(averages.tilt_spread), "deg", "0")?;
        let (layers, spread) = (model.stack().layers, averages.layer_spread);
        let exact = model.is_exact() || spread <= 0.0;
        require(exact, "spread of the layers of a model of printed formulas", spread, "nm", "0")?;
        require(layers <= MOST_LAYERS || spread <= 0.0, "spread of more than 1000 layers", spread, "nm", "0")?;
        let cone = Cone::new(layers, averages.numerical_aperture);
        let disorder = (spread > 0.0).then(|| Disorder::new(layers, spread));
        Ok(Self { model, averages, cone, disorder, memory: Memory::default() })
    }

    /// Steps over a normal distribution whose width is `relative` to the wavelength or period.
    fn steps(&self, relative: f64) -> Vec<Node> {
        if relative <= 0.0 {
            return vec![Node { at: 0.0, share: 1.0 }];
        }
        #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
        let needed = (STEPS * (self.model.stack().layers as f64).powi(2) * relative).ceil();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 1024")]
        let needed = needed.min(MOST as f64) as usize;
        // Powers of two: a count that follows the structure would put steps into what is fitted.
        normal_steps(needed.max(FEWEST).next_power_of_two() + 1)
    }

    /// The plane waves about `angle` for each tilt and ray.
    fn beams(&self, ambient: f64, angle: f64) -> Vec<Beam> {
        if self.averages.numerical_aperture > 0.0 {
            return self.cone.beams(ambient, angle);
        }
        let spread = self.averages.tilt_spread;
        // Relative change of the optical path with the angle, to second order.
        let relative = spread * angle.tan().abs().min(20.0) + spread * spread;
        let beam = |node: Node| Beam {
            angle: angle - node.at * spread,
            slope: 1.0,
            own: 1.0,
            own_slope: 0.0,
            share: node.share,
        };
        self.steps(relative).into_iter().map(beam).collect()
    }
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

/// The wavenumbers of wavelengths longer by `by` nm.
fn shifted(wavenumbers: &[f64], by: f64) -> Vec<f64> {
    wavenumbers.iter().map(|k| k / (1.0 + by * k / TAU).max(0.1)).collect()
}

impl AveragedModel {
    /// The index of the ambient medium; `None` where it is not one and the cone depends on it.
    fn common_ambient(&self, media: &[Media]) -> Option<f64> {
        let first = media.first().map_or(1.0, |media| media.ambient);
        let same = self.averages.numerical_aperture <= 0.0
            || media.iter().all(|media| media.ambient.to_bits() == first.to_bits());
        same.then_some(first)
    }

    /// Shifts of wavelength and period, nm, with their shares.
    fn shifts(&self, wavenumbers: &[f64], period: Period) -> Vec<(f64, f64, f64)> {
        let shortest = TAU / wavenumbers.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let (band, spread) = (self.averages.bandwidth / WIDTH, self.averages.period_spread);
        let periods = self.steps(spread / (period.cuticle + period.gap).max(1.0));
        let mut shifts = Vec::new();
        for band_node in self.steps(band / shortest) {
            for node in &periods {
                shifts.push((band_node.at * band, node.at * spread, band_node.share * node.share));
            }
        }
        shifts
    }

    /// R of plane waves of which this is one of so many nodes, of stacks whose layers are as unequal as they are.
    fn plane_waves(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        (period, angle): (Period, f64),
        node: (usize, usize),
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        let Some(disorder) = &self.disorder else {
            return self.model.stack_reflectivities(media, wavenumbers, period, angle, out);
        };
        disorder.reflectivities(media, wavenumbers, (period, angle), node, out);
        Ok(())
    }
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

    fn is_average(&self) -> bool {
        !self.averages.is_none()
    }

    fn lamella_factor(&self, lamella_width: f64) -> f64 {
        self.model.lamella_factor(lamella_width)
    }

    fn lamella_factor_slope(&self, lamella_width: f64) -> f64 {
        self.model.lamella_factor_slope(lamella_width)
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        let mut mean = [SAndP::default()];
        self.stack_reflectivities(&[*media], &[TAU / media.wavelength], period, angle, &mut mean)?;
        Ok(mean[0])
    }

    fn stack_reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        let Some(ambient) = self.common_ambient(media) else {
            for ((media, wavenumber), out) in media.chunks(1).zip(wavenumbers.chunks(1)).zip(out.chunks_mut(1)) {
                self.stack_reflectivities(media, wavenumber, period, angle, out)?;
            }
            return Ok(());
        };
        let (beams, shifts) = (self.beams(ambient, angle), self.shifts(wavenumbers, period));
        let is_dear = self.disorder.is_some() || beams.len() * shifts.len() * wavenumbers.len() > DEAR;
        let question = is_dear.then(|| Memory::question(media, wavenumbers, period, angle));
        if question.as_ref().is_some_and(|question| self.memory.recall(question, out)) {
            return Ok(());
        }
        out.fill(SAndP::default());
        let mut one = vec![SAndP::default(); wavenumbers.len()];
        for (place, &(band, longer_by, share)) in shifts.iter().enumerate() {
            let (period, ..) = longer(period, longer_by);
            let shifted = shifted(wavenumbers, band);
            for (number, beam) in beams.iter().enumerate() {
                let node = (place * beams.len() + number, shifts.len() * beams.len());
                self.plane_waves(media, &shifted, (period, beam.angle), node, &mut one)?;
                let (own, other) = (share * beam.share * beam.own, share * beam.share * (1.0 - beam.own));
                for (out, one) in out.iter_mut().zip(&one) {
                    out.s += own * one.s + other * one.p;
                    out.p += own * one.p + other * one.s;
                }
            }
        }
        if let Some(question) = question {
            self.memory.keep(question, out);
        }
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
        // Of stacks whose layers differ exact slopes cost what differences do.
        if self.disorder.is_some() {
            return false;
        }
        let Some(ambient) = self.common_ambient(media) else {
            let each = media.chunks(1).zip(wavenumbers.chunks(1)).zip(out.chunks_mut(1));
            let mut each = each.map(|((media, k), out)| self.stack_slopes(media, k, period, angle, out));
            return each.all(|known| known);
        };
        out.fill(StackSlopes::default());
        let mut one = vec![StackSlopes::default(); wavenumbers.len()];
        let mut values = vec![SAndP::default(); wavenumbers.len()];
        let beams = self.beams(ambient, angle);
        for (band, longer_by, share) in self.shifts(wavenumbers, period) {
            let (longer, factor, slope) = longer(period, longer_by);
            let shifted = shifted(wavenumbers, band);
            for beam in &beams {
                // The values are for what a turn exchanges between the polarizations.
                let turns = beam.own_slope.abs() > 0.0;
                if !self.model.stack_slopes(media, &shifted, longer, beam.angle, &mut one)
                    || turns
                        && self.model.stack_reflectivities(media, &shifted, longer, beam.angle, &mut values).is_err()
                {
                    return false;
                }
                let share = share * beam.share;
                let mixed = |both: &SAndP| SAndP {
                    s: share * (beam.own * both.s + (1.0 - beam.own) * both.p),
                    p: share * (beam.own * both.p + (1.0 - beam.own) * both.s),
                };
                for ((out, one), value) in out.iter_mut().zip(&one).zip(&values) {
                    let (cuticle, gap, turned) = (mixed(&one.cuticle), mixed(&one.gap), mixed(&one.angle));
                    // Either thickness also changes the factor of both.
                    let common_s = slope * (period.cuticle * cuticle.s + period.gap * gap.s);
                    let common_p = slope * (period.cuticle * cuticle.p + period.gap * gap.p);
                    out.cuticle.s += factor * cuticle.s + common_s;
                    out.cuticle.p += factor * cuticle.p + common_p;
                    out.gap.s += factor * gap.s + common_s;
                    out.gap.p += factor * gap.p + common_p;
                    let exchanged = share * beam.own_slope * (value.s - value.p);
                    out.angle.s += beam.slope * turned.s + exchanged;
                    out.angle.p += beam.slope * turned.p - exchanged;
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests;
