//! What the estimates owe to a bound that another parameter ended on: had it gone on, they would have moved with it.

use crate::inversion::estimates::Found;
use crate::inversion::outcome::{Derived, Estimate, Status};
use crate::inversion::parameter::{COUNT, Parameter};
use crate::inversion::quantity::{indices, with_estimates};
use crate::uncertainty::covariance::covariance;
use nalgebra::DVector;

/// A bound costs something if chi² would fall by more than this beyond it.
const COSTS: f64 = 4.0;
/// What would move by more than this share of its standard deviation is not told.
const MOVED: f64 = 0.5;

/// Takes interval and standard deviation from what depends on a bound: the values would be others if the parameters that ended
/// on one ([`Status::AtBound`]) were let go. Their step is Gauss and Newton's, `-(J' J)⁻¹ J' r` over all free parameters.
/// `unit` is the standard deviation of a weighted residual. Returns whether a bound costs something.
pub(crate) fn beyond(found: &Found<'_>, unit: f64, estimates: &mut [Estimate; COUNT], derived: &mut Derived) -> bool {
    let free = &found.space.freedom.free;
    let stopped: Vec<usize> =
        (0..free.len()).filter(|&j| estimates[free[j].index()].status == Status::AtBound).collect();
    if stopped.is_empty() {
        return false;
    }
    let Some((step, _)) = step_beyond(found, unit, &stopped).filter(|(_, gain)| *gain > COSTS) else { return false };
    let names: Vec<String> = stopped.iter().map(|&j| free[j].name().to_owned()).collect();
    let indices = indices(found.data, &found.settings.stack);
    for (quantity, estimate) in with_estimates(indices, estimates, derived) {
        let moved = quantity.outside(quantity.slopes(found.space).dot(&step).abs());
        // An ambiguous one has its own others, and a linked one its parameter.
        let may_depend =
            estimate.status.is_determined() || [Status::OneSided, Status::AtBound].contains(&estimate.status);
        if may_depend && estimate.sigma.is_some_and(|sigma| moved > MOVED * sigma) {
            estimate.depend_on_a_bound(&names);
        }
    }
    true
}

/// Whether a thickness lies on a bound that costs nothing: it is then no better known than one inside. Of tilt, lobe and width other
/// values were tried ([`Undetermined`](crate::inversion::undetermined::Undetermined)).
pub(crate) fn is_free_on_bound(found: &Found<'_>, unit: f64, j: usize) -> bool {
    let is_thickness = matches!(found.space.freedom.free[j], Parameter::DAir | Parameter::DCuticle);
    is_thickness && step_beyond(found, unit, &[j]).is_some_and(|(_, gain)| gain <= COSTS)
}

/// How the free parameters would move if those of `stopped` could, and by how much chi² would fall, in squared standard deviations of a
/// residual; `None` without a covariance.
fn step_beyond(found: &Found<'_>, unit: f64, stopped: &[usize]) -> Option<(DVector<f64>, f64)> {
    let mut gradient = DVector::zeros(found.best.gradient.len());
    for &j in stopped {
        gradient[j] = found.best.gradient[j];
    }
    let step = -(covariance(&found.best.triangle)? * &gradient);
    let gain = -step.dot(&gradient) / (unit * unit);
    Some((step, gain))
}

impl Estimate {
    /// Keeps the value alone, which holds for the bounds that the parameters `with` ended on.
    fn depend_on_a_bound(&mut self, with: &[String]) {
        self.status = Status::AtBound;
        self.with = with.to_vec();
        (self.sigma, self.widened_by, self.interval_68, self.interval_95) = Default::default();
    }
}
