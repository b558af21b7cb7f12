//! Samples in bins, in one and two dimensions.

use crate::numerics::quantile;

/// Number of bins of a histogram: Freedman and Diaconis, within bounds that a small panel can show.
///
/// ```text
/// width = 2 IQR / n^(1/3)
/// ```
///
/// # Source
/// Freedman and Diaconis (1981), Z. Wahrscheinlichkeitstheorie verw. Gebiete 57, 453.
/// <https://doi.org/10.1007/BF01025868>
pub(super) fn bins(sorted: &[f64], (least, most): (usize, usize)) -> usize {
    let (Some(low), Some(high)) = (sorted.first(), sorted.last()) else { return least };
    let width = 2.0 * (quantile(sorted, 0.75) - quantile(sorted, 0.25)) / (sorted.len() as f64).cbrt();
    let wanted = (high - low) / width;
    if wanted.is_nan() || wanted <= 0.0 {
        return least;
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates; clamped")]
    let bins = wanted.ceil() as usize;
    bins.clamp(least, most)
}

/// The quantile of ascending values at a share of them, linear between neighbours; not a number without values.
pub(super) fn quantile(sorted: &[f64], share: f64) -> f64 {
    quantile::quantile(sorted, share).unwrap_or(f64::NAN)
}

/// `bins + 1` equally spaced edges.
pub(super) fn edges((low, high): (f64, f64), bins: usize) -> Vec<f64> {
    let share = |edge: usize| edge as f64 / bins.max(1) as f64;
    (0..=bins).map(|edge| low * (1.0 - share(edge)) + high * share(edge)).collect()
}

/// The bin of a value; beyond the ends the nearest one, so that nothing is lost.
pub(super) fn bin(value: f64, (low, high): (f64, f64), bins: usize) -> usize {
    let place = (value - low) / (high - low) * bins as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates; clamped")]
    let index = place as usize;
    index.min(bins.saturating_sub(1))
}

/// Numbers of values in the bins.
pub(super) fn counts(values: &[f64], range: (f64, f64), bins: usize) -> Vec<f64> {
    let mut counts = vec![0.0; bins];
    for &value in values {
        if let Some(count) = counts.get_mut(bin(value, range, bins)) {
            *count += 1.0;
        }
    }
    counts
}

/// Numbers of pairs in the cells of a square grid, row by row.
pub(super) fn grid_counts(x: &[f64], y: &[f64], ranges: [(f64, f64); 2], bins: usize) -> Vec<f64> {
    let mut counts = vec![0.0; bins * bins];
    for (&x, &y) in x.iter().zip(y) {
        if let Some(count) = counts.get_mut(bin(y, ranges[1], bins) * bins + bin(x, ranges[0], bins)) {
            *count += 1.0;
        }
    }
    counts
}

/// A square grid smoothed with weights 1, 4, 6, 4, 1 in both directions (a standard deviation of one cell), with a
/// border of two empty cells around it, so that lines of equal height close. The sum is kept.
pub(super) fn smoothed(counts: &[f64], bins: usize) -> Vec<f64> {
    const WEIGHTS: [f64; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];
    const BORDER: usize = 2;
    let side = bins + 2 * BORDER;
    let mut padded = vec![0.0; side * side];
    for (row, cells) in counts.chunks(bins.max(1)).enumerate() {
        for (column, &count) in cells.iter().enumerate() {
            if let Some(cell) = padded.get_mut((row + BORDER) * side + column + BORDER) {
                *cell = count;
            }
        }
    }
    for stride in [1, side] {
        let mut next = vec![0.0; side * side];
        for (index, &value) in padded.iter().enumerate().filter(|(_, value)| **value > 0.0) {
            for (step, weight) in WEIGHTS.iter().enumerate() {
                // Only cells at least a border away from the edge hold something along this direction.
                if let Some(cell) = (index + step * stride).checked_sub(BORDER * stride).and_then(|at| next.get_mut(at))
                {
                    *cell += weight * value;
                }
            }
        }
        padded = next;
    }
    padded
}

/// The height above which the given share of all counts lies, the highest cells first; none without counts.
pub(super) fn enclosing_level(counts: &[f64], share: f64) -> Option<f64> {
    let mut sorted = counts.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let wanted = share * sorted.iter().sum::<f64>();
    let mut sum = 0.0;
    let level = sorted.into_iter().find(|count| {
        sum += count;
        sum >= wanted
    });
    level.filter(|&level| level > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_lands_in_a_bin() {
        let values: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.7).sin() * 3.0 + 5.0).collect();
        for bins in [1, 7, 40] {
            assert!((counts(&values, (2.0, 8.0), bins).iter().sum::<f64>() - 1000.0).abs() < 1e-9);
            let grid = grid_counts(&values, &values, [(2.0, 8.0), (3.0, 4.0)], bins);
            assert!((grid.iter().sum::<f64>() - 1000.0).abs() < 1e-9);
            assert!((smoothed(&grid, bins).iter().sum::<f64>() - 1000.0).abs() < 1e-9);
        }
        assert_eq!((bin(2.0, (2.0, 8.0), 3), bin(4.0, (2.0, 8.0), 3), bin(8.0, (2.0, 8.0), 3)), (0, 1, 2));
    }

    #[test]
    fn quantiles_are_those_of_numpy() {
        // numpy.quantile([1, 2, 4, 8], [0, 0.25, 0.5, 0.9, 1])
        let found = [0.0, 0.25, 0.5, 0.9, 1.0].map(|share| quantile(&[1.0, 2.0, 4.0, 8.0], share));
        found.iter().zip([1.0, 1.75, 3.0, 6.8, 8.0]).for_each(|(found, right)| assert!((found - right).abs() < 1e-12));
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_level_encloses_its_share() {
        assert_eq!(enclosing_level(&[1.0, 5.0, 3.0, 1.0], 0.5), Some(5.0));
        assert_eq!(enclosing_level(&[1.0, 5.0, 3.0, 1.0], 0.8), Some(3.0));
        assert_eq!(enclosing_level(&[0.0; 4], 0.5), None);
    }

    #[test]
    fn equal_values_and_few_values_have_the_least_bins() {
        assert_eq!((bins(&[2.0; 9], (8, 40)), bins(&[], (8, 40)), bins(&[1.0, 1.0, 1.0, 9.0], (8, 40))), (8, 8, 8));
    }
}
