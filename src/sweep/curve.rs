//! Both contributions of a model along a line of readings.

use crate::geometry::{Geometry, Polarization};
use crate::optics::{Contribution, OpticsError, ReflectivityModel, Structure};

/// The two contributions at one reading, dimensionless, each with its share of the plane in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Model A's.
    pub lamella: f64,
    /// Model B's.
    pub multilayer: f64,
}

impl Terms {
    /// What a measurement of scale 1 would read.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.lamella + self.multilayer
    }
}

/// Readings along a line, and the contributions there.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Geometry and wavelength (nm) of each reading.
    pub readings: Vec<(Geometry, f64)>,
    /// The contributions at each of them; `None` where the model has no answer.
    pub terms: Vec<Option<Terms>>,
}

impl Curve {
    /// The contributions of `model` at each of `readings`, `(geometry, wavelength in nm)`.
    ///
    /// Where no refracted ray exists, as with Snell's law as the paper prints it, there is `None`.
    ///
    /// # Errors
    /// [`OpticsError`] for input out of range.
    ///
    /// ```
    /// use morpho_fit::geometry::{Geometry, Polarization};
    /// use morpho_fit::optics::{BlendModel, Structure};
    /// use morpho_fit::sweep::Curve;
    /// let along = Geometry { theta: 0.0, phi: 0.0, omega: std::f64::consts::FRAC_PI_2 };
    /// let readings = vec![(along, 480.0), (along, 583.0)];
    /// let curve = Curve::of(&BlendModel::default(), &Structure::table1(), Polarization::Unpolarized, readings)?;
    /// let multilayer = curve.terms[1].unwrap().multilayer;
    /// assert!(multilayer > 0.9 && curve.terms[0].unwrap().multilayer < multilayer);
    /// # Ok::<(), morpho_fit::optics::OpticsError>(())
    /// ```
    pub fn of(
        model: &dyn ReflectivityModel,
        structure: &Structure,
        polarization: Polarization,
        readings: Vec<(Geometry, f64)>,
    ) -> Result<Self, OpticsError> {
        let one = |found: Result<[Contribution; 2], OpticsError>| match found {
            Ok([lamella, multilayer]) => {
                Ok(Some(Terms { lamella: lamella.intensity, multilayer: multilayer.intensity }))
            }
            Err(OpticsError::NoRefractedRay { .. }) => Ok(None),
            Err(error) => Err(error),
        };
        let found = model.contributions_at(structure, polarization, &readings)?;
        let terms = found.into_iter().map(one).collect::<Result<_, _>>()?;
        Ok(Self { readings, terms })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{PaperModel, Snell};
    use crate::units::radians;

    #[test]
    fn snells_law_as_printed_has_no_answer_beyond_its_angle() {
        // sin(theta - delta) = 1/1.56: 39.87° from the normal of the layers, which are tilted by 2.5°.
        let printed = PaperModel { snell: Snell::Printed, ..PaperModel::default() };
        let at = |theta: f64| (Geometry { theta: radians(theta), phi: radians(-theta), omega: radians(90.0) }, 500.0);
        let of = |readings| Curve::of(&printed, &Structure::table1(), Polarization::Unpolarized, readings);
        let found = of(vec![at(42.3), at(42.4)]).unwrap();
        assert!(found.terms[0].is_some() && found.terms[1].is_none());
        assert!(of(vec![at(95.0)]).is_err());
    }
}
