//! Quantiles of a sample.

/// Probability within one standard deviation of a normal distribution.
pub const SIXTY_EIGHT: f64 = 0.682_689_492_137_085_9;
/// The usual other one.
pub const NINETY_FIVE: f64 = 0.95;

/// The quantile of `share` of a rising sample, linear between its members; `None` for an empty one.
///
/// # Source
/// Hyndman and Fan 1996, DOI 10.1080/00031305.1996.10473566, definition 7.
///
/// ```
/// use morpho_fit::numerics::quantile::quantile;
/// assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), Some(3.0));
/// ```
#[must_use]
pub fn quantile(rising: &[f64], share: f64) -> Option<f64> {
    let last = rising.len().checked_sub(1)?;
    #[allow(clippy::cast_precision_loss, reason = "sizes of samples are below 2^53")]
    let place = share.clamp(0.0, 1.0) * last as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to last")]
    let below = place.floor() as usize;
    let (low, high) = (rising.get(below)?, rising.get((below + 1).min(last))?);
    let part = place - place.floor();
    Some((1.0 - part) * low + part * high)
}

/// The two ends between which the middle `share` of a rising sample lies.
///
/// ```
/// use morpho_fit::numerics::quantile::central;
/// let rising: Vec<f64> = (0..=100).map(f64::from).collect();
/// let [low, high] = central(&rising, 0.5).unwrap();
/// assert!((low - 25.0).abs() < 1e-12 && (high - 75.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn central(rising: &[f64], share: f64) -> Option<[f64; 2]> {
    let tail = 0.5 * (1.0 - share);
    Some([quantile(rising, tail)?, quantile(rising, 1.0 - tail)?])
}
