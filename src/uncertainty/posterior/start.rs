//! Where the walkers start: draws from the modes, kept in proportion to the density.

use super::ensemble::{Ensemble, evaluate};
use super::mixture::Mixture;
use super::settings::{Mode, SamplerError, SamplerSettings};
use crate::optimise::Bounds;
use nalgebra::DVector;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Draws for each walker, of which the likely ones are kept.
const CROWD: usize = 4;
/// If too few have a density, the modes are made wider by each of these in turn.
const WIDER: [f64; 5] = [1.0, 0.2, 3.0, 0.02, 10.0];
/// The weights given count so much at the start, equal weights the rest: they may be wrong.
const TRUST: f64 = 0.5;

/// Checked modes and settings.
pub(super) struct Start {
    pub(super) mixture: Mixture,
    pub(super) ensembles: usize,
    parameters: usize,
}

impl Start {
    pub(super) fn new(bounds: &Bounds, modes: &[Mode], settings: &SamplerSettings) -> Result<Self, SamplerError> {
        let d = bounds.len();
        if modes.is_empty() || d == 0 {
            return Err(SamplerError::Empty);
        }
        if settings.ensembles == 0 {
            return Err(SamplerError::Setting { setting: "the number of ensembles" });
        }
        if !(settings.effective > 0.0 && settings.effective.is_finite()) {
            return Err(SamplerError::Setting { setting: "the number of effective samples" });
        }
        let heaviest = modes.iter().map(|mode| mode.log_weight).fold(f64::NEG_INFINITY, f64::max);
        #[allow(clippy::cast_precision_loss, reason = "few modes")]
        let even = (1.0 - TRUST) / modes.len() as f64;
        let sum: f64 = modes.iter().map(|mode| (mode.log_weight - heaviest).exp()).sum();
        let mut parts = Vec::with_capacity(modes.len());
        for (index, mode) in modes.iter().enumerate() {
            let (rows, columns) = mode.covariance.shape();
            let centre = mode.centre.len();
            if [centre, rows, columns] != [d, d, d] {
                return Err(SamplerError::Dimension { mode: index, centre, rows, columns, bounds: d });
            }
            let weight = TRUST * (mode.log_weight - heaviest).exp() / sum + even;
            let part = (bounds.clamp(&mode.centre), mode.covariance.clone(), weight);
            let finite = mode.centre.iter().all(|value| value.is_finite()) && mode.log_weight.is_finite();
            if !finite || Mixture::new(vec![part.clone()]).is_none() {
                return Err(SamplerError::Mode { mode: index });
            }
            parts.push(part);
        }
        let mixture = Mixture::new(parts).ok_or(SamplerError::Empty)?;
        Ok(Self { mixture, ensembles: settings.ensembles, parameters: d })
    }

    /// Walkers of an ensemble: each half spans the space.
    pub(super) fn walkers(&self) -> usize {
        2 * (self.parameters + 1).max(3)
    }

    /// Ensembles at points of finite density; `None` if too few are found. `spent` counts the evaluations.
    ///
    /// Of several times as many draws from the modes, each is kept with a chance that grows with its weight
    /// `p/q`: the largest keys `ln(p/q) + g` with `g` of Gumbel's distribution (Efraimidis and Spirakis 2006,
    /// DOI 10.1016/j.ipl.2005.11.003). No two are equal, so the walkers span the space.
    pub(super) fn ensembles(
        &self,
        target: &(dyn Fn(&DVector<f64>) -> f64 + Sync),
        bounds: &Bounds,
        settings: &SamplerSettings,
        spent: &mut usize,
    ) -> Option<Vec<Ensemble>> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(settings.seed);
        let wanted = self.walkers() * self.ensembles;
        let mut found: Vec<(f64, (DVector<f64>, f64))> = Vec::new();
        for width in WIDER {
            let mixture = self.mixture.widened(width)?;
            for _ in 0..CROWD * wanted {
                if *spent >= settings.max_evaluations {
                    break;
                }
                let x = mixture.draw(&mut random);
                let gumbel = -(-random.random::<f64>().ln()).ln();
                if let Some(log_p) = evaluate(target, bounds, &x, spent) {
                    found.push((log_p - mixture.log_density(&x) + gumbel, (x, log_p)));
                }
            }
            if found.len() >= wanted {
                break;
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        if found.len() < wanted {
            return None;
        }
        // Dealt out like cards, so that no ensemble has the likely ones.
        let mut hands = vec![Vec::with_capacity(self.walkers()); self.ensembles];
        for (index, (_, start)) in found.into_iter().take(wanted).enumerate() {
            hands[index % self.ensembles].push(start);
        }
        let ensembles = hands.iter().map(|hand| {
            let own = random.clone();
            random.long_jump();
            Ensemble::new(hand, own)
        });
        Some(ensembles.collect())
    }
}
