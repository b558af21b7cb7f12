//! Ranges, ticks and tick labels of one axis.

use super::super::PlotError;

/// Values beyond this, and those that are not finite, are not drawn; so no sum or difference below can overflow.
const LARGEST: f64 = 1e300;

/// Ranges narrower than this are taken as a single value, because their step could not be written as a number.
const NARROWEST: f64 = 1e-302;

/// Ranges narrower than this part of their values are taken as one value: finer ticks would need labels of more
/// than ten digits, and near 1e-16 there are no numbers left in between.
const FINEST: f64 = 1e-9;

/// From this size on, and below [`SMALL`], labels are written with a common power of ten.
const LARGE: f64 = 1e5;
const SMALL: f64 = 1e-3;

/// True if the value can have a place on an axis.
pub(super) fn is_drawable(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// The range that holds all drawable values with some air at both ends, or none if there is no such value.
pub(super) fn range_of(values: impl IntoIterator<Item = f64>, air: f64) -> Option<(f64, f64)> {
    let (low, high) = values
        .into_iter()
        .filter(|&value| is_drawable(value))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return None;
    }
    let (low, high) = widened(low, high);
    let margin = air * (high - low);
    Some((low - margin, high + margin))
}

/// A range in which numbers can be told apart: a single value gets a tenth of itself on both sides, zero gets one.
pub(super) fn widened(low: f64, high: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    if high - low > NARROWEST && high - low > FINEST * size {
        return (low, high);
    }
    let room = if size > NARROWEST { 0.1 * size } else { 1.0 };
    (low - room, high + room)
}

/// The largest power of ten that is a number with room to spare.
const MOST_POWER: f64 = 300.0;

/// One tick: its place as a part of the axis (0 at the low end, 1 at the high end) and its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) place: f64,
    pub(super) label: String,
}

/// An axis with its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    pub(super) ticks: Vec<Tick>,
    /// The power of ten by which all labels are to be multiplied, such as `×10⁶`; empty if there is none.
    pub(super) factor: String,
}

impl Axis {
    /// The axis from `low` to `high` with at most `most + 1` ticks, on steps of 1, 2 or 5 times a power of ten.
    pub(super) fn new(low: f64, high: f64, most: usize) -> Self {
        let (low, high) = widened(low.max(-LARGEST), high.min(LARGEST));
        let step = Step::at_least((high - low) / most.max(1) as f64);
        let size = low.abs().max(high.abs());
        let power = if (SMALL..LARGE).contains(&size) { 0 } else { whole(size.log10().floor()) };
        let mut axis = Self { low, high, ticks: Vec::new(), factor: factor(power) };
        let (first, last) = (whole((low / step.value() - 1e-9).ceil()), whole((high / step.value() + 1e-9).floor()));
        for count in first..=last {
            let place = axis.place(count as f64 * step.value()).clamp(0.0, 1.0);
            axis.ticks.push(Tick { place, label: decimal(count * step.mantissa, power - step.exponent) });
        }
        axis
    }

    /// The axis of decimal logarithms from `low` to `high`, with ticks at about `most` powers of ten.
    pub(super) fn powers((low, high): (f64, f64), most: usize) -> Self {
        let (low, high) = widened(low.max(-MOST_POWER), high.min(MOST_POWER));
        Self { low, high, ticks: ratio_ticks(10f64.powf(low), 10f64.powf(high), most), factor: String::new() }
    }

    /// The axis with as many ticks as fit: `gap` must remain between neighbouring labels on an axis of `length`.
    pub(super) fn fitting(
        (low, high): (f64, f64),
        length: f64,
        gap: f64,
        most: usize,
        width: impl Fn(&str) -> Result<f64, PlotError>,
    ) -> Result<Self, PlotError> {
        for most in (1..=most).rev() {
            let axis = Self::new(low, high, most);
            let mut free_from = f64::NEG_INFINITY;
            let mut fits = true;
            for tick in &axis.ticks {
                let half = width(&tick.label)? / 2.0;
                let middle = tick.place * length;
                fits &= middle - half >= free_from;
                free_from = middle + half + gap;
            }
            if fits {
                return Ok(axis);
            }
        }
        Ok(Self::new(low, high, 1))
    }

    /// Where a value lies as a part of the axis. Values far outside come out nearer, so that the result is finite.
    pub(super) fn place(&self, value: f64) -> f64 {
        ((value - self.low) / (self.high - self.low)).clamp(-1e6, 1e6)
    }

    /// The values at both ends.
    pub(super) fn ends(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// True if the value lies on the axis.
    pub(super) fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }
}

/// Ticks of a logarithmic axis from `low` to `high`, both positive: powers of ten, all or every so many; where there are
/// fewer than two of them, also twice and five times a power, or else tidy numbers.
pub(super) fn ratio_ticks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let span = high.log10() - low.log10();
    let place = |value: f64| (value.log10() - low.log10()) / span;
    let (first, last) = (whole((low.log10() - 1e-9).ceil()), whole((high.log10() + 1e-9).floor()));
    let stride = usize::try_from(last - first).unwrap_or(0) / most.max(1) + 1;
    let name = |mantissa: i64, power: i64| match power {
        -3..=3 => decimal(mantissa * 10_i64.pow(u32::try_from(power.max(0)).unwrap_or(0)), (-power).max(0)),
        _ if mantissa == 1 => factor(power).trim_start_matches('×').to_owned(),
        _ => format!("{mantissa}{}", factor(power)),
    };
    let tick = |(mantissa, power): (i64, i64)| {
        let value = mantissa as f64 * 10f64.powi(i32::try_from(power).unwrap_or(0));
        Tick { place: place(value), label: name(mantissa, power) }
    };
    let inside = |tick: &Tick| (-1e-9..=1.0 + 1e-9).contains(&tick.place);
    let mut ticks: Vec<Tick> =
        (first..=last).step_by(stride).map(|power| tick((1, power))).filter(|tick| inside(tick)).collect();
    if ticks.len() < 2 {
        let fine = (first - 1..=last).flat_map(|power| [1, 2, 5].map(|mantissa| (mantissa, power)));
        ticks = fine.map(tick).filter(inside).collect();
    }
    if ticks.len() < 2 {
        let value = |tick: &Tick| low + tick.place * (high - low);
        ticks = Axis::new(low, high, 2).ticks;
        ticks = ticks.into_iter().map(|tick| Tick { place: place(value(&tick)), ..tick }).collect();
    }
    for tick in &mut ticks {
        tick.place = tick.place.clamp(0.0, 1.0);
    }
    ticks
}

/// A step of `mantissa` times ten to the `exponent`.
struct Step {
    mantissa: i64,
    exponent: i64,
}

impl Step {
    /// The smallest step of 1, 2 or 5 times a power of ten that is not below `least`.
    fn at_least(least: f64) -> Self {
        let exponent = whole(least.log10().floor());
        let candidates = [(1, exponent), (2, exponent), (5, exponent)].map(|(m, e)| Self { mantissa: m, exponent: e });
        let enough = |step: &Self| step.value() >= least * (1.0 - 1e-9);
        candidates.into_iter().find(enough).unwrap_or(Self { mantissa: 1, exponent: exponent + 1 })
    }

    fn value(&self) -> f64 {
        let power = i32::try_from(self.exponent).unwrap_or(0);
        self.mantissa as f64 * 10f64.powi(power)
    }
}

/// `×10ⁿ`, or nothing for n = 0.
pub(in crate::plot) fn factor(power: i64) -> String {
    if power == 0 {
        return String::new();
    }
    let raised = |character| match character {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        _ => '⁰',
    };
    format!("×10{}", power.to_string().chars().map(raised).collect::<String>())
}

/// The integer divided by ten to the `places`, written exactly.
fn decimal(integer: i64, places: i64) -> String {
    let sign = if integer < 0 { "−" } else { "" };
    let mut digits = integer.unsigned_abs().to_string();
    let places = usize::try_from(places).unwrap_or_else(|_| {
        if integer != 0 {
            digits.extend((places..0).map(|_| '0'));
        }
        0
    });
    if places == 0 {
        return format!("{sign}{digits}");
    }
    let digits = format!("{digits:0>width$}", width = places + 1);
    let (before, after) = digits.split_at(digits.len() - places);
    format!("{sign}{before}.{after}")
}

fn whole(value: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation, reason = "rounded by the caller and below 1e12 by FINEST")]
    let whole = value as i64;
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(low: f64, high: f64, most: usize) -> Vec<String> {
        Axis::new(low, high, most).ticks.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn labels_are_tidy() {
        assert_eq!(labels(0.0, 0.5, 5), ["0.0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(labels(-1.0, 1.0, 4), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(380.0, 730.0, 8), ["400", "450", "500", "550", "600", "650", "700"]);
        assert_eq!(labels(-70.0, 70.0, 8), ["−60", "−40", "−20", "0", "20", "40", "60"]);
        assert_eq!(labels(0.29, 0.31, 2), ["0.29", "0.30", "0.31"]);
        assert_eq!(labels(12_000.0, 48_000.0, 4), ["20000", "30000", "40000"]);
    }

    #[test]
    fn large_and_small_numbers_share_a_power_of_ten() {
        let large = Axis::new(0.0, 4e5, 4);
        assert_eq!(large.factor, "×10⁵");
        assert_eq!(labels(0.0, 4e5, 4), ["0", "1", "2", "3", "4"]);
        assert_eq!(Axis::new(-1e-300, 3e-300, 4).factor, "×10⁻³⁰⁰");
        assert_eq!(Axis::new(0.0, 1e300, 5).factor, "×10³⁰⁰");
    }

    #[test]
    fn a_single_value_gets_room() {
        assert_eq!(widened(0.0, 0.0), (-1.0, 1.0));
        assert_eq!(widened(-20.0, -20.0), (-22.0, -18.0));
        assert_eq!(range_of([f64::NAN, f64::INFINITY, -1e301], 0.1), None);
        assert_eq!(range_of([1.0, f64::NAN, 2.0], 0.5), Some((0.5, 2.5)));
    }

    #[test]
    fn fewer_ticks_are_set_where_labels_would_touch() {
        let width = |label: &str| Ok(8.0 * label.chars().count() as f64);
        let narrow = Axis::fitting((300.0, 700.0), 100.0, 10.0, 8, width).unwrap();
        let wide = Axis::fitting((300.0, 700.0), 500.0, 10.0, 8, width).unwrap();
        assert_eq!((narrow.ticks.len(), wide.ticks.len()), (2, 9));
    }

    #[test]
    fn an_axis_of_logarithms_names_the_numbers() {
        let axis = Axis::powers((-2.0, 2.0), 8);
        let labels: Vec<&str> = axis.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
        assert!((axis.place(0.0) - 0.5).abs() < 1e-12, "1 is half way");
        assert!(Axis::powers((-1e9, 1e9), 4).ticks.len() >= 2);
    }

    #[test]
    fn a_logarithmic_axis_has_powers_of_ten() {
        let labels = |low, high, most| -> Vec<String> {
            ratio_ticks(low, high, most).into_iter().map(|tick| tick.label).collect()
        };
        assert_eq!(labels(0.1, 1e4, 8), ["0.1", "1", "10", "100", "1000", "10⁴"]);
        assert_eq!(labels(1e-300, 1e300, 3), ["10⁻³⁰⁰", "10⁻⁹⁹", "10¹⁰²"]);
        assert_eq!(labels(15.0, 90.0, 8), ["20", "50"]);
        assert_eq!(labels(1.1, 1.9, 8), ["1.5"]);
        let place = ratio_ticks(1.0, 100.0, 8)[1].place;
        assert!((place - 0.5).abs() < 1e-12, "ten is half way");
    }

    proptest! {
        #[test]
        fn any_range_has_few_ascending_ticks_inside(
            middle in prop::num::f64::NORMAL | prop::num::f64::ZERO | prop::num::f64::SUBNORMAL,
            span in prop::num::f64::NORMAL | prop::num::f64::ZERO,
            most in 0_usize..12,
        ) {
            let (low, high) = (middle.clamp(-1e300, 1e300), (middle + span.abs()).clamp(-1e300, 1e300));
            let axis = Axis::new(low, high, most);
            prop_assert!(axis.ticks.len() <= most.max(1) + 1);
            prop_assert!(axis.ticks.windows(2).all(|pair| pair[0].place < pair[1].place));
            prop_assert!(axis.ticks.iter().all(|tick| (0.0..=1.0).contains(&tick.place) && tick.label.len() < 20));
            prop_assert!(axis.place(f64::MAX).is_finite());
            let labels: std::collections::HashSet<_> = axis.ticks.iter().map(|tick| &tick.label).collect();
            prop_assert_eq!(labels.len(), axis.ticks.len());
        }
    }
}
