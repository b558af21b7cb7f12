//! The constants of a model: numbers that a fit is told, and that [`over_constant`](super::intervals::over_constant) can fit.

use crate::inversion::fit::FitError;
use crate::inversion::settings::{FitSettings, ModelChoice};
use crate::optics::{Averages, Material};
use crate::units;
use serde::{Deserialize, Serialize};

/// A number that a fit is told of media, layers, ridges or instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Constant {
    /// Refractive index of the cuticle.
    NCuticle,
    /// Extinction coefficient of the cuticle.
    KCuticle,
    /// Refractive index of the gaps.
    NGap,
    /// Refractive index behind the last gap.
    NBase,
    /// Share of a layer that is cuticle.
    Filling,
    /// Distance of the ridges of the `hybrid` model.
    RidgeSpacing,
    /// Numerical aperture that lights and gathers.
    NumericalAperture,
    /// Full width at half maximum of the instrument's band.
    Bandwidth,
    /// Standard deviation of the period over the spot.
    PeriodSpread,
    /// Standard deviation of each layer's thickness by itself.
    LayerSpread,
    /// Standard deviation of the tilt over the spot.
    TiltSpread,
}

impl Constant {
    /// All, in order.
    pub const ALL: [Self; 11] = [
        Self::NCuticle,
        Self::KCuticle,
        Self::NGap,
        Self::NBase,
        Self::Filling,
        Self::RidgeSpacing,
        Self::NumericalAperture,
        Self::Bandwidth,
        Self::PeriodSpread,
        Self::LayerSpread,
        Self::TiltSpread,
    ];

    /// The name in options, files and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NCuticle => "n_cuticle",
            Self::KCuticle => "k_cuticle",
            Self::NGap => "n_gap",
            Self::NBase => "n_base",
            Self::Filling => "filling",
            Self::RidgeSpacing => "ridge_spacing",
            Self::NumericalAperture => "numerical_aperture",
            Self::Bandwidth => "bandwidth",
            Self::PeriodSpread => "period_spread",
            Self::LayerSpread => "layer_spread",
            Self::TiltSpread => "tilt_spread",
        }
    }

    /// The constant of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|constant| constant.name() == name)
    }

    /// nm, deg, or nothing.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::RidgeSpacing | Self::Bandwidth | Self::PeriodSpread | Self::LayerSpread => "nm",
            Self::TiltSpread => "deg",
            _ => "",
        }
    }

    /// Least and largest value that it can have, user units: a range that ends there is not cut short.
    #[must_use]
    pub fn domain(self) -> (f64, f64) {
        match self {
            Self::NCuticle | Self::NGap | Self::NBase => (1e-3, 1e3),
            Self::KCuticle => (0.0, 1e3),
            Self::Filling => (0.0, 1.0),
            Self::RidgeSpacing => (1.0, 1e6),
            Self::NumericalAperture => (0.0, 0.99),
            Self::Bandwidth | Self::PeriodSpread | Self::LayerSpread => (0.0, 200.0),
            Self::TiltSpread => (0.0, units::degrees(0.5)),
        }
    }

    /// Its value in `settings`, user units; `None` where there is none: an index by a formula or a table, layers without a
    /// filling, ridges of another model than `hybrid`.
    #[must_use]
    pub fn of(self, settings: &FitSettings) -> Option<f64> {
        let index = |material: &Material| match material {
            Material::Constant { n, k } => Some((*n, *k)),
            Material::Cauchy { .. } | Material::Table(_) => None,
        };
        let (stack, averages) = (&settings.stack, &settings.averages);
        match self {
            Self::NCuticle => index(&stack.cuticle).map(|(n, _)| n),
            Self::KCuticle => index(&stack.cuticle).map(|(_, k)| k),
            Self::NGap => index(&stack.gap).map(|(n, _)| n),
            Self::NBase => index(&stack.base).map(|(n, _)| n),
            Self::Filling => stack.filling,
            Self::RidgeSpacing => match settings.model {
                ModelChoice::Hybrid { ridge_spacing } => Some(ridge_spacing),
                ModelChoice::Blend | ModelChoice::Paper { .. } => None,
            },
            Self::NumericalAperture => Some(averages.numerical_aperture),
            Self::Bandwidth => Some(averages.bandwidth),
            Self::PeriodSpread => Some(averages.period_spread),
            Self::LayerSpread => Some(averages.layer_spread),
            Self::TiltSpread => Some(units::degrees(averages.tilt_spread)),
        }
    }

    /// `settings` with another value, user units.
    ///
    /// # Errors
    /// [`FitError`] where the settings have no such number, and for a value that the optics refuse.
    ///
    /// ```
    /// use morpho_fit::inversion::{Constant, FitSettings};
    /// let thin = Constant::NCuticle.set(&FitSettings::default(), 1.5)?;
    /// assert_eq!(Constant::NCuticle.of(&thin), Some(1.5));
    /// assert!(Constant::RidgeSpacing.set(&thin, 700.0).is_err());
    /// # Ok::<(), morpho_fit::inversion::FitError>(())
    /// ```
    pub fn set(self, settings: &FitSettings, value: f64) -> Result<FitSettings, FitError> {
        let mut changed = settings.clone();
        let absent = |what| Err(FitError::NoConstant { constant: self.name(), what });
        let (stack, averages) = (&mut changed.stack, &mut changed.averages);
        let medium = match self {
            Self::NCuticle | Self::KCuticle => Some(&mut stack.cuticle),
            Self::NGap => Some(&mut stack.gap),
            Self::NBase => Some(&mut stack.base),
            _ => None,
        };
        match (self, medium) {
            (Self::KCuticle, Some(Material::Constant { k, .. })) => *k = value,
            (_, Some(Material::Constant { n, .. })) => *n = value,
            (_, Some(_)) => return absent("this index is a formula or a table"),
            (Self::Filling, _) => stack.filling = Some(value),
            (Self::RidgeSpacing, _) => match settings.model {
                ModelChoice::Hybrid { .. } => {
                    return Ok(settings.for_model(ModelChoice::Hybrid { ridge_spacing: value })?);
                }
                ModelChoice::Blend | ModelChoice::Paper { .. } => return absent("it is of the `hybrid` model"),
            },
            (Self::NumericalAperture, _) => averages.numerical_aperture = value,
            (Self::Bandwidth, _) => averages.bandwidth = value,
            (Self::PeriodSpread, _) => averages.period_spread = value,
            (Self::LayerSpread, _) => averages.layer_spread = value,
            (Self::TiltSpread, _) => *averages = Averages { tilt_spread: units::radians(value), ..*averages },
            (Self::NCuticle | Self::KCuticle | Self::NGap | Self::NBase, None) => {}
        }
        changed.averages.validate()?;
        Ok(changed)
    }
}

impl std::fmt::Display for Constant {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_found_again_and_nothing_else_moves() {
        let hybrid = FitSettings::default().for_model(ModelChoice::Hybrid { ridge_spacing: 750.0 }).unwrap();
        for constant in Constant::ALL {
            let value = if constant == Constant::RidgeSpacing { 640.0 } else { 0.4 };
            let base = if constant == Constant::TiltSpread { FitSettings::default() } else { hybrid.clone() };
            let changed = constant.set(&base, value).unwrap();
            assert!((constant.of(&changed).unwrap() - value).abs() < 1e-12, "{constant}");
            let others = Constant::ALL.into_iter().filter(|other| *other != constant);
            assert!(others.into_iter().all(|other| other.of(&changed) == other.of(&base)), "{constant}");
            assert_eq!(Constant::from_name(constant.name()), Some(constant));
        }
    }

    #[test]
    fn what_is_not_there_cannot_be_set() {
        let mut settings = FitSettings::default();
        settings.stack.cuticle = Material::Cauchy { a: 1.5, b: 8e3 };
        let refused = |constant: Constant, value| constant.set(&settings, value).unwrap_err().to_string();
        assert!(refused(Constant::NCuticle, 1.5).contains("a formula or a table"));
        assert!(refused(Constant::RidgeSpacing, 700.0).contains("`hybrid`"));
        assert!(refused(Constant::NumericalAperture, 1.5).contains("numerical aperture"));
        assert_eq!(Constant::NCuticle.of(&settings), None);
    }
}
