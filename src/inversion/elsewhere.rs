//! What an estimate owes to other structures that fit as well.

use crate::inversion::estimates::Found;
use crate::inversion::intervals::Quantiles;
use crate::inversion::outcome::{Estimate, Status};
use crate::inversion::parameter::COUNT;
use crate::optimise::Minimum;

/// A value at another minimum is another value if it lies off by more standard deviations than this.
const APART: f64 = 3.0;

/// Minima that fit as well as the best, itself left out.
pub(crate) fn as_good<'a>(found: &Found<'a>, unit: f64) -> impl Iterator<Item = &'a Minimum> {
    let (best, level) = (found.minima[0].sum_of_squares, found.settings.level);
    found.minima[1..].iter().filter(move |other| other.sum_of_squares - best <= level * unit * unit)
}

/// A quantity at another minimum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Elsewhere {
    /// In the unit of the estimate.
    pub(crate) value: f64,
    /// chi² above that of the best, in squared standard deviations of a residual.
    pub(crate) gap: f64,
}

/// A quantity at the minima that fit as well as the best.
pub(crate) fn elsewhere(found: &Found<'_>, unit: f64, quantity: impl Fn(&[f64; COUNT]) -> f64) -> Vec<Elsewhere> {
    let best = found.minima[0].sum_of_squares;
    let of = |minimum: &Minimum| Elsewhere {
        value: quantity(&found.searched.freedom.expand(&minimum.parameters)),
        gap: (minimum.sum_of_squares - best) / (unit * unit),
    };
    as_good(found, unit).map(of).collect()
}

impl Estimate {
    /// Takes those values for others that lie farther than `far` from the own and from each other.
    fn take_others(&mut self, value: f64, elsewhere: &[Elsewhere], far: f64) {
        for other in elsewhere {
            let is_far = |known: &f64| (other.value - known).abs() > far;
            if is_far(&value) && self.others.iter().all(is_far) {
                self.others.push(other.value);
            }
        }
    }

    /// Marks a value as ambiguous if it is another at other minima that fit as well: its intervals then span them all. Nearer
    /// ones widen intervals and standard deviation.
    ///
    /// Each minimum is taken for a parabola of chi² with the curvature of the best, so that an interval to the quantile q is
    ///
    /// ```text
    /// union over minima i with gap_i < q² of value_i ± sigma sqrt(q² - gap_i)
    /// ```
    ///
    /// The interval of 95 % holds the value of every minimum that fits, too, and the whole of one that is apart.
    ///
    /// - `noticeable`: a difference below this is none, in the same unit.
    pub(crate) fn allow_for(&mut self, elsewhere: &[Elsewhere], noticeable: f64, quantiles: &Quantiles) {
        let (Some(value), Some(sigma)) = (self.value, self.sigma) else { return };
        self.take_others(value, elsewhere, (APART * sigma).max(noticeable));
        let is_ambiguous = !self.others.is_empty();
        if is_ambiguous {
            self.status = Status::Ambiguous;
        }
        let bounds = self.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let intervals = [&mut self.interval_68, &mut self.interval_95];
        for (interval, quantile) in intervals.into_iter().zip([quantiles.sixty_eight, quantiles.ninety_five]) {
            let Some([low, high]) = interval else { continue };
            for other in elsewhere {
                let is_apart = is_ambiguous || (other.value - value).abs() > APART * sigma;
                let left = if is_apart { quantile * quantile } else { quantile * quantile - other.gap };
                if left > 0.0 || quantile > quantiles.sixty_eight {
                    let reach = sigma * left.max(0.0).sqrt();
                    *low = low.map(|end| end.min(other.value - reach)).filter(|end| *end > bounds[0]);
                    *high = high.map(|end| end.max(other.value + reach)).filter(|end| *end < bounds[1]);
                }
            }
        }
        if !is_ambiguous {
            self.widen_to_interval(quantiles.ninety_five);
        }
        self.mark_open_ends();
    }

    /// Makes the standard deviation no less than half the interval of 95 % over its `quantile`.
    pub(crate) fn widen_to_interval(&mut self, quantile: f64) {
        let (Some(value), Some(sigma), Some(interval)) = (self.value, self.sigma, self.interval_95) else { return };
        let half = match interval {
            [Some(low), Some(high)] => 0.5 * (high - low),
            [Some(end), None] | [None, Some(end)] => (end - value).abs(),
            [None, None] => 0.0,
        };
        self.sigma = Some(sigma.max(half / quantile));
    }

    /// Marks a value on a bound: ambiguous if a value inside fits as well, since then the data do not ask for wider bounds.
    pub(crate) fn stopped_at_bound(&mut self, elsewhere: &[Elsewhere], noticeable: f64) {
        self.status = Status::AtBound;
        let (Some(value), Some([lower, upper])) = (self.value, self.bounds) else { return };
        if elsewhere.iter().any(|other| other.value - lower > noticeable && upper - other.value > noticeable) {
            self.status = Status::Ambiguous;
            self.take_others(value, elsewhere, noticeable);
        }
    }

    /// Marks a value on a bound that fits as well elsewhere, at values some of which lie inside: told on one side, or on none if they
    /// reach the other bound. The interval is the range of these values.
    pub(crate) fn open_from_bound(&mut self, elsewhere: &[f64], noticeable: f64) {
        let (Some(value), Some([lower, upper])) = (self.value, self.bounds) else { return };
        let is_inside = |x: &f64| x - lower > noticeable && upper - x > noticeable;
        if !elsewhere.iter().any(is_inside) {
            return;
        }
        let (least, most) = elsewhere.iter().fold((value, value), |(least, most), &x| (least.min(x), most.max(x)));
        self.others.clear();
        self.status = Status::OneSided;
        let interval = [(least > lower + noticeable).then_some(least), (most < upper - noticeable).then_some(most)];
        (self.interval_68, self.interval_95) = (Some(interval), Some(interval));
        self.mark_open_ends();
    }

    /// Share of the bounds within a quantile of the value or of another that fits.
    pub(crate) fn covered(&self, quantile: f64) -> f64 {
        let (Some(value), Some(sigma), Some([lower, upper])) = (self.value, self.sigma, self.bounds) else {
            return 0.0;
        };
        let mut all: Vec<f64> = self.others.iter().copied().chain([value]).collect();
        all.sort_by(f64::total_cmp);
        let (mut covered, mut end) = (0.0, lower);
        for at in all {
            let (low, high) = ((at - quantile * sigma).max(end), (at + quantile * sigma).min(upper));
            covered += (high - low).max(0.0);
            end = end.max(high);
        }
        covered / (upper - lower)
    }

    /// Takes back a value whose interval is open on both sides, and marks one that is on one.
    pub(crate) fn mark_open_ends(&mut self) {
        let is_told = self.status.is_determined() || self.status == Status::OneSided;
        match self.interval_95.filter(|_| is_told) {
            Some([None, None]) => self.withdraw(),
            Some([None, _] | [_, None]) => {
                self.status = Status::OneSided;
                self.with.clear();
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::outcome::SigmaSource;
    use approx::assert_relative_eq;

    /// 10 ± 1 within 0 to 20.
    fn ten(status: Status) -> (Estimate, Quantiles) {
        let quantiles = Quantiles::new(SigmaSource::Stated, 100);
        let [a, b] = [quantiles.sixty_eight, quantiles.ninety_five];
        let mut estimate = Estimate::new(10.0, "nm");
        (estimate.sigma, estimate.bounds, estimate.status) = (Some(1.0), Some([0.0, 20.0]), status);
        estimate.interval_68 = Some([Some(10.0 - a), Some(10.0 + a)]);
        estimate.interval_95 = Some([Some(10.0 - b), Some(10.0 + b)]);
        (estimate, quantiles)
    }

    fn allowing(status: Status, elsewhere: &[Elsewhere]) -> Estimate {
        let (mut estimate, quantiles) = ten(status);
        estimate.allow_for(elsewhere, 0.1, &quantiles);
        estimate
    }

    #[test]
    fn a_near_structure_that_fits_exactly_as_well_moves_both_intervals_and_the_deviation() {
        let found = allowing(Status::Ok, &[Elsewhere { value: 12.0, gap: 0.0 }]);
        assert_eq!((found.status, found.others.len()), (Status::Ok, 0));
        let [Some(low), Some(high)] = found.interval_68.unwrap() else { panic!("{found:?}") };
        assert_relative_eq!(low, 9.0, epsilon = 1e-3);
        assert_relative_eq!(high, 13.0, epsilon = 1e-3);
        let [Some(low), Some(high)] = found.interval_95.unwrap() else { panic!("{found:?}") };
        assert_relative_eq!(low, 10.0 - 1.96, epsilon = 1e-3);
        assert_relative_eq!(high, 12.0 + 1.96, epsilon = 1e-3);
        // Half of 5.92 over 1.96.
        assert_relative_eq!(found.sigma.unwrap(), 1.5102, epsilon = 1e-4);
    }

    /// chi² of the other rises from 3: above 1 it says nothing at 68 %, below 3.84 a little at 95 %.
    #[test]
    fn a_near_structure_that_fits_worse_reaches_less_far() {
        let (before, _) = ten(Status::Ok);
        let found = allowing(Status::Ok, &[Elsewhere { value: 8.0, gap: 3.0 }]);
        assert_eq!(found.interval_68, before.interval_68);
        let [Some(low), Some(high)] = found.interval_95.unwrap() else { panic!("{found:?}") };
        assert_relative_eq!(low, 8.0 - (1.96_f64 * 1.96 - 3.0).sqrt(), epsilon = 1e-3);
        assert_eq!(Some(high), before.interval_95.unwrap()[1]);
        let hardly = allowing(Status::Ok, &[Elsewhere { value: 7.5, gap: 4.0 }]);
        assert_eq!(hardly.interval_95.unwrap()[0], Some(7.5));
        assert_eq!(hardly.interval_68, before.interval_68);
        assert_eq!(allowing(Status::Ok, &[Elsewhere { value: 9.0, gap: 4.0 }]), before);
    }

    #[test]
    fn a_value_on_a_bound_is_open_as_far_as_others_fit_and_some_lie_inside() {
        let on_bound = |elsewhere: &[f64]| {
            let mut estimate = Estimate::new(20.0, "deg");
            (estimate.bounds, estimate.status) = (Some([0.0, 20.0]), Status::AtBound);
            estimate.open_from_bound(elsewhere, 0.1);
            (estimate.status, estimate.interval_95)
        };
        assert_eq!(on_bound(&[]), (Status::AtBound, None));
        assert_eq!(on_bound(&[19.95]), (Status::AtBound, None));
        // The mirror image on the other bound, and nothing between.
        assert_eq!(on_bound(&[0.0]), (Status::AtBound, None));
        assert_eq!(on_bound(&[17.0, 12.0]), (Status::OneSided, Some([Some(12.0), None])));
        assert_eq!(on_bound(&[10.0, 0.0]), (Status::NotIdentifiable, None));
    }

    #[test]
    fn what_is_covered_is_counted_once() {
        let (mut estimate, _) = ten(Status::Ambiguous);
        assert_relative_eq!(estimate.covered(2.0), 4.0 / 20.0);
        estimate.others = vec![11.0, 20.0];
        assert_relative_eq!(estimate.covered(2.0), 7.0 / 20.0);
    }

    /// Four standard deviations off, but by less than matters.
    #[test]
    fn a_structure_apart_is_spanned_although_it_is_no_other_answer() {
        let (mut estimate, quantiles) = ten(Status::Ok);
        estimate.allow_for(&[Elsewhere { value: 14.0, gap: 6.0 }], 5.0, &quantiles);
        assert_eq!((estimate.status, estimate.others.len()), (Status::Ok, 0));
        let [Some(_), Some(high)] = estimate.interval_95.unwrap() else { panic!("{estimate:?}") };
        assert_relative_eq!(high, 14.0 + 1.96, epsilon = 1e-3);
        assert_relative_eq!(estimate.sigma.unwrap(), 0.5 * (4.0 + 2.0 * 1.96) / 1.96, epsilon = 1e-3);
    }

    #[test]
    fn a_far_structure_is_another_answer_and_its_interval_is_spanned() {
        let found = allowing(Status::Ok, &[Elsewhere { value: 15.0, gap: 8.0 }]);
        assert_eq!((found.status, found.others.as_slice(), found.sigma), (Status::Ambiguous, &[15.0][..], Some(1.0)));
        let [Some(low), Some(high)] = found.interval_95.unwrap() else { panic!("{found:?}") };
        assert_relative_eq!(low, 10.0 - 1.96, epsilon = 1e-3);
        assert_relative_eq!(high, 15.0 + 1.96, epsilon = 1e-3);
    }

    #[test]
    fn ends_that_reach_a_bound_are_open_and_told_as_open() {
        let (mut near_bound, quantiles) = ten(Status::Correlated);
        (near_bound.bounds, near_bound.with) = (Some([7.5, 20.0]), vec!["d_air".to_owned()]);
        near_bound.allow_for(&[Elsewhere { value: 9.0, gap: 0.0 }], 0.1, &quantiles);
        assert_eq!((near_bound.status, near_bound.with.len()), (Status::OneSided, 0));
        assert!(matches!(near_bound.interval_95, Some([None, Some(_)])));
        // The other end as well: nothing is told.
        near_bound.bounds = Some([7.5, 13.0]);
        near_bound.allow_for(&[Elsewhere { value: 12.0, gap: 0.0 }], 0.1, &quantiles);
        assert_eq!((near_bound.status, near_bound.value), (Status::NotIdentifiable, None));
        assert_eq!((near_bound.held_at, near_bound.interval_95), (Some(10.0), None));
    }

    #[test]
    fn a_bound_is_blamed_unless_a_value_inside_fits() {
        let on_bound = |elsewhere: &[Elsewhere]| {
            let mut estimate = Estimate::new(20.0, "nm");
            estimate.bounds = Some([0.0, 20.0]);
            estimate.stopped_at_bound(elsewhere, 0.1);
            (estimate.status, estimate.others)
        };
        let at = |value| Elsewhere { value, gap: 1.0 };
        assert_eq!(on_bound(&[]), (Status::AtBound, vec![]));
        assert_eq!(on_bound(&[at(0.0), at(19.95)]), (Status::AtBound, vec![]));
        assert_eq!(on_bound(&[at(0.0), at(7.0)]), (Status::Ambiguous, vec![0.0, 7.0]));
    }
}
