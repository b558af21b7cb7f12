//! The `paper` model: the printed formulas, with a switch for each of their faults.

use crate::optics::error::require;
use crate::optics::multilayer::periodic::{self, Admittances, Cosines, Incidence, Phases, Rule};
use crate::optics::multilayer::{Period, Rules, SAndP, StackSlopes, lanes};
use crate::optics::{Media, OpticsError, ReflectivityModel, Stack};
use serde::{Deserialize, Serialize};

/// Which way up Snell's law is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Snell {
    /// `sin(cuticle) = sin(theta - delta) n_gap / n_cuticle`.
    #[default]
    Right,
    /// As printed, `n_cuticle / n_gap`: no solution beyond 39.87° for 1.56.
    Printed,
}

/// How the two polarizations become one reflectivity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Admittance {
    /// As printed: one admittance, the mean `(n cos + n / cos) / 2`. Good to 20°, with a false zero at 69.4° for 1.56.
    #[default]
    Mean,
    /// One recurrence for each polarization; the mean of the two reflectivities is exact.
    PerPolarization,
}

/// What Model A is divided by: as printed it is an area, and drowns the dimensionless Model B.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LamellaUnit {
    /// Its own peak, `a²/2 N M²`.
    #[default]
    Peak,
    /// The peak of a lamella `width` nm wide: a wider one is brighter by `(a / width)²`.
    Reference {
        /// Reference width, nm, 0.001 to 1e6.
        width: f64,
    },
    /// Nothing: the printed value in nm² for `ridges` trees.
    Printed {
        /// Number of trees N, above 0 and at most 1e9.
        ridges: f64,
    },
}

/// The formulas of paper section 2 as printed.
///
/// The stack is evaluated by the closed form, to which the printed recurrence is equal to rounding (it is
/// [`multilayer::intensity`](crate::optics::multilayer::intensity)) for any admittance.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PaperModel {
    /// Media and layer count; indices must be real.
    pub stack: Stack,
    /// Which way up Snell's law is.
    pub snell: Snell,
    /// How the polarizations are joined.
    pub admittance: Admittance,
    /// What Model A is divided by.
    pub lamella_unit: LamellaUnit,
}

impl PaperModel {
    fn rules(&self) -> Rules {
        match self.admittance {
            Admittance::Mean => Rules::Mean,
            Admittance::PerPolarization => Rules::Each,
        }
    }

    fn incidence(&self, media: &Media, angle: f64) -> Result<Incidence, OpticsError> {
        let model = "paper";
        if let Some((medium, k)) = media.absorbing() {
            return Err(OpticsError::Absorbing { model, medium, k });
        }
        let (sin, cos) = angle.sin_cos();
        match self.snell {
            Snell::Right => Incidence::refracted(media, angle).ok_or(OpticsError::NoRefractedRay {
                model,
                medium: "stack",
                sine: sin * media.ambient / media.cuticle.re.min(media.gap.re).min(media.base.re),
            }),
            Snell::Printed => {
                // As printed, gaps and base share the angle of the ambient medium.
                let ratio = media.cuticle.re / media.gap.re;
                let sine = sin * ratio;
                let squared = 1.0 - sine * sine;
                if squared <= 0.0 {
                    return Err(OpticsError::NoRefractedRay { model, medium: "cuticle", sine });
                }
                let cuticle = squared.sqrt();
                Ok(Incidence {
                    cosines: Cosines { ambient: cos, cuticle, gap: cos, base: cos },
                    slopes: Cosines { ambient: -sin, cuticle: -sine * ratio * cos / cuticle, gap: -sin, base: -sin },
                })
            }
        }
    }
}

impl ReflectivityModel for PaperModel {
    fn name(&self) -> &'static str {
        "paper"
    }

    fn stack(&self) -> &Stack {
        &self.stack
    }

    fn validate(&self) -> Result<(), OpticsError> {
        match self.lamella_unit {
            LamellaUnit::Peak => Ok(()),
            LamellaUnit::Reference { width } => {
                require((1e-3..=1e6).contains(&width), "reference width", width, "nm", "0.001 to 1e6")
            }
            LamellaUnit::Printed { ridges } => {
                require(ridges > 0.0 && ridges <= 1e9, "ridges", ridges, "", "above 0, at most 1e9")
            }
        }
    }

    fn lamella_factor(&self, lamella_width: f64) -> f64 {
        match self.lamella_unit {
            LamellaUnit::Peak => 1.0,
            LamellaUnit::Reference { width } => (lamella_width / width).powi(2),
            LamellaUnit::Printed { ridges } => {
                #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
                let layers = self.stack.layers as f64;
                0.5 * lamella_width * lamella_width * ridges * layers * layers
            }
        }
    }

    fn lamella_factor_slope(&self, lamella_width: f64) -> f64 {
        match self.lamella_unit {
            LamellaUnit::Peak => 0.0,
            // proportional to the square of the width
            _ => 2.0 * self.lamella_factor(lamella_width) / lamella_width,
        }
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        let cos = angle.cos();
        if cos <= 0.0 {
            return Ok(SAndP::both(if cos < 0.0 { 0.0 } else { 1.0 }));
        }
        let (cosines, layers) = (self.incidence(media, angle)?.cosines, self.stack.layers);
        let phases = Phases::new(media, &cosines, period);
        let with = |rule| periodic::reflectivity(&Admittances::each(media, &cosines, rule), &phases, layers);
        Ok(match self.admittance {
            Admittance::Mean => SAndP::both(with(Rule::Mean)),
            Admittance::PerPolarization => SAndP { s: with(Rule::S), p: with(Rule::P) },
        })
    }

    fn stack_reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        let cos = angle.cos();
        if cos <= 0.0 {
            out.fill(SAndP::both(if cos < 0.0 { 0.0 } else { 1.0 }));
            return Ok(());
        }
        let incidences = media.iter().map(|media| self.incidence(media, angle)).collect::<Result<Vec<_>, _>>()?;
        lanes::values(media, &incidences, period, self.stack.layers, self.rules(), wavenumbers, out);
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
        let each = media.iter().map(|media| self.incidence(media, angle));
        let incidences = each.collect::<Result<Vec<_>, _>>().ok().filter(|_| angle.cos() > 0.0);
        if let Some(incidences) = &incidences {
            lanes::slopes(media, incidences, period, self.stack.layers, self.rules(), wavenumbers, out);
        }
        incidences.is_some()
    }
}
