//! Many fits with the same choices: what data sets of one design share is compiled once.

use crate::dataset::{Dataset, Reading};
use crate::inversion::compiled::Compiled;
use crate::inversion::fit::{FitError, THINNED, check, fit_compiled, solve};
use crate::inversion::nuisance::LinearPart;
use crate::inversion::outcome::{Fit, FitOutcome};
use crate::inversion::plan::Plan;
use crate::inversion::settings::{FitSettings, Search};
use crate::optics::{OpticsError, ReflectivityModel};
use std::sync::{Arc, RwLock};

/// Fits data sets one after another or side by side, each to the same bits as [`fit`](crate::inversion::fit) does.
///
/// Data sets whose readings have the same wavelengths, angles, polarizations and curves, as the pixels of a map do, share
/// what the readings see of the model. The last design is kept: where designs take turns each is compiled again, as in a fit
/// by itself.
///
/// ```
/// use morpho_fit::inversion::{FitSettings, Fitter};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::synthetic::{Scan, simulate};
///
/// let (model, blue) = (BlendModel::default(), Structure::blue());
/// let fitter = Fitter::new(FitSettings::default())?;
/// for (seed, d_air) in [(1, 135.0), (2, 141.0)] {
///     let pixel = Structure { d_air, ..blue };
///     let data = simulate(&model, &pixel, &Scan::full_design(&model, &blue)?, 1.0, 0.01, seed)?;
///     let found = fitter.fit(&data, &|_| {})?.outcome.parameters.d_air;
///     assert!((found.value.unwrap() - d_air).abs() < 4.0 * found.sigma.unwrap());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Fitter {
    settings: FitSettings,
    model: Arc<dyn ReflectivityModel>,
    /// Of the data set before.
    design: RwLock<Option<Arc<Design>>>,
}

/// A design of measurement, compiled.
#[derive(Debug)]
struct Design {
    /// What each reading sees.
    keys: Vec<[u64; 5]>,
    curves: usize,
    whole: Part,
    thinned: Option<Part>,
}

/// Some of a design's readings, compiled.
#[derive(Debug)]
struct Part {
    rows: Vec<usize>,
    plan: Plan<'static>,
    linear: LinearPart,
}

impl Fitter {
    /// For fits by `settings`.
    ///
    /// # Errors
    /// [`FitError`] for choices that cannot be fitted.
    pub fn new(settings: FitSettings) -> Result<Self, FitError> {
        settings.validate()?;
        let model = settings.forward()?.into();
        Ok(Self { settings, model, design: RwLock::new(None) })
    }

    /// Fits `data`; any number of threads may ask.
    ///
    /// # Errors
    /// As [`fit`](crate::inversion::fit).
    pub fn fit(&self, data: &Dataset, progress: &(dyn Fn(&str) + Sync)) -> Result<Fit, FitError> {
        self.with_compiled(data, |whole, thinned| fit_compiled(whole, thinned, progress))
    }

    /// [`Fitter::fit`] without the curves and what further questions need, which a map of many pixels does not keep.
    ///
    /// # Errors
    /// As [`fit`](crate::inversion::fit).
    pub fn outcome(&self, data: &Dataset, progress: &(dyn Fn(&str) + Sync)) -> Result<FitOutcome, FitError> {
        self.with_compiled(data, |whole, thinned| solve(whole, thinned, progress).map(|(_, summary)| summary.outcome))
    }

    fn with_compiled<T>(
        &self,
        data: &Dataset,
        ask: impl FnOnce(&Compiled<'_>, Option<&Compiled<'_>>) -> Result<T, FitError>,
    ) -> Result<T, FitError> {
        check(data)?;
        let known = self.design.read().ok().and_then(|design| design.clone()).filter(|design| design.is_of(data));
        let design = match known {
            Some(design) => design,
            None => {
                let made = Arc::new(Design::new(data, &self.settings, &self.model)?);
                if let Ok(mut kept) = self.design.write() {
                    *kept = Some(Arc::clone(&made));
                }
                made
            }
        };
        let of = |part: &Part| part.with(data, &self.settings);
        ask(&of(&design.whole), design.thinned.as_ref().map(of).as_ref())
    }
}

impl Design {
    fn new(data: &Dataset, settings: &FitSettings, model: &Arc<dyn ReflectivityModel>) -> Result<Self, OpticsError> {
        let part = |rows| Part::new(data, settings, model, rows);
        let thinned = match settings.search {
            Search::Global => Some(part(Plan::thinned_rows(data, THINNED))?),
            Search::Local => None,
        };
        let whole = part((0..data.readings().len()).collect())?;
        let keys = data.readings().iter().map(key).collect();
        Ok(Self { keys, curves: data.curves().len(), whole, thinned })
    }

    /// Whether the readings of `data` differ from these in intensity and sigma alone.
    fn is_of(&self, data: &Dataset) -> bool {
        self.curves == data.curves().len()
            && self.keys.len() == data.readings().len()
            // Bit by bit without a branch: a comparison of arrays would be a call for each reading.
            && self.keys.iter().zip(data.readings()).all(|(own, other)| {
                own.iter().zip(key(other)).fold(0, |unlike, (own, other)| unlike | (own ^ other)) == 0
            })
    }
}

/// Wavelength, angles, curve and polarization of a reading.
fn key(reading: &Reading) -> [u64; 5] {
    let at = reading.geometry;
    let [wavelength, theta, phi, omega] = [reading.wavelength, at.theta, at.phi, at.omega].map(f64::to_bits);
    [wavelength, theta, phi, omega, ((reading.curve as u64) << 2) | reading.polarization as u64]
}

impl Part {
    fn new(
        data: &Dataset,
        settings: &FitSettings,
        model: &Arc<dyn ReflectivityModel>,
        rows: Vec<usize>,
    ) -> Result<Self, OpticsError> {
        let compiled = Compiled::of_rows(data, settings, model.as_ref(), &rows)?;
        Ok(Self { rows, plan: compiled.plan.keeping(Arc::clone(model)), linear: compiled.linear })
    }

    fn with<'a>(&self, data: &'a Dataset, settings: &'a FitSettings) -> Compiled<'a> {
        let plan = self.plan.with_readings(self.rows.iter().map(|&row| &data.readings()[row]));
        Compiled { data, settings, plan, linear: self.linear.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::fit::fit;
    use crate::inversion::nuisance::{Extent, Nuisances};
    use crate::inversion::settings::ModelChoice;
    use crate::optics::{BlendModel, Structure};
    use crate::optimise::Loss;
    use crate::synthetic::{Scan, simulate};
    use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

    /// Of one design, of another one and back, with other noise, each to the last bit.
    #[test]
    fn each_fit_is_what_it_is_alone() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let full = Scan::full_design(&model, &blue).unwrap();
        let pixel = |d_air, seed, scans: &[Scan]| {
            simulate(&model, &Structure { d_air, ..blue }, scans, 1.0, 0.01 * seed as f64, seed).unwrap()
        };
        let sets =
            [pixel(141.0, 1, &full), pixel(135.0, 2, &full), pixel(138.0, 3, &full[..4]), pixel(150.0, 4, &full)];
        for (search, model) in
            [(Search::Global, ModelChoice::Blend), (Search::Local, ModelChoice::Hybrid { ridge_spacing: 750.0 })]
        {
            let settings = FitSettings { search, model, ..FitSettings::default() };
            let fitter = Fitter::new(settings.clone()).unwrap();
            for data in &sets {
                let (alone, together) = (fit(data, &settings, &|_| {}).unwrap(), fitter.fit(data, &|_| {}).unwrap());
                assert_eq!(format!("{:?}", alone.outcome), format!("{:?}", together.outcome));
                assert_eq!(alone.readings, together.readings);
                let outcome = fitter.outcome(data, &|_| {}).unwrap();
                assert_eq!(format!("{outcome:?}"), format!("{:?}", together.outcome));
            }
        }
    }

    /// With sigma, without and with it again, curves that take turns with scales of their own, a robust loss; many threads at
    /// once.
    #[test]
    fn what_is_shared_is_the_design_alone() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let scans = Scan::full_design(&model, &blue).unwrap();
        let data = simulate(&model, &blue, &scans, 1.0, 0.01, 5).unwrap();
        let changed = |change: &dyn Fn(usize, &mut Reading)| {
            let mut readings = data.readings().to_vec();
            readings.iter_mut().enumerate().for_each(|(row, reading)| change(row, reading));
            let curves = readings.iter().map(|reading| reading.curve).max().unwrap() + 1;
            Dataset::from_readings(readings, data.curves()[..curves].to_vec()).unwrap()
        };
        let sets = [
            changed(&|_, _| {}),
            changed(&|_, reading| reading.sigma = None),
            changed(&|row, reading| reading.sigma = Some(if row % 2 == 0 { 0.01 } else { 0.02 })),
            changed(&|row, reading| reading.curve = (reading.curve + row) % 2),
            changed(&|row, reading| reading.intensity *= if row == 7 { 3.0 } else { 1.0 }),
        ];
        let nuisances = Nuisances { scale: Extent::PerCurve, ..Nuisances::default() };
        for settings in [
            FitSettings { nuisances, ..FitSettings::default() },
            FitSettings { loss: Loss::Huber, ..FitSettings::default() },
        ] {
            let fitter = Fitter::new(settings.clone()).unwrap();
            let text = |fit: Result<Fit, FitError>| format!("{:?}", fit.map(|fit| fit.outcome));
            let together: Vec<String> = sets.par_iter().map(|data| text(fitter.fit(data, &|_| {}))).collect();
            for (data, together) in sets.iter().zip(together) {
                assert_eq!(text(fit(data, &settings, &|_| {})), together);
                assert_eq!(text(fitter.fit(data, &|_| {})), together);
            }
        }
    }

    #[test]
    fn choices_that_cannot_be_fitted_are_refused_at_once() {
        let model = ModelChoice::Hybrid { ridge_spacing: -1.0 };
        assert!(Fitter::new(FitSettings { model, ..FitSettings::default() }).is_err());
    }
}
