//! What stands still along a spectrum, or changes with the indices only.

use crate::optics::multilayer::Period;
use crate::optics::multilayer::periodic::{Admittances, Incidence};
use crate::optics::stack::Media;

/// What stands still along a spectrum, for one set of admittances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fixed {
    /// `y_gap / y_cuticle + y_cuticle / y_gap`.
    pub(super) ratios: f64,
    /// `(y_ambient - y_base) / 2`.
    pub(super) half_step: f64,
    /// `(y_ambient + y_base)(y_cuticle / y_gap - y_gap / y_cuticle) / 2`.
    pub(super) contrast: f64,
    /// `y_ambient y_base m12 - m21` by its two products of sines and cosines: that of cos(cuticle) sin(gap), of
    /// sin(cuticle) cos(gap).
    pub(super) cos_sin: f64,
    pub(super) sin_cos: f64,
    /// `4 y_ambient y_base`.
    pub(super) through: f64,
}

impl Fixed {
    pub(super) fn new(y: &Admittances) -> Self {
        let product = y.ambient * y.base;
        let (ratio, inverse) = (y.gap / y.cuticle, y.cuticle / y.gap);
        Self {
            ratios: ratio + inverse,
            half_step: 0.5 * (y.ambient - y.base),
            contrast: 0.5 * (y.ambient + y.base) * (inverse - ratio),
            cos_sin: product / y.gap - y.gap,
            sin_cos: product / y.cuticle - y.cuticle,
            through: 4.0 * product,
        }
    }

    /// Derivatives of [`Fixed::new`]'s values along `slopes` of the admittances.
    pub(super) fn slopes(y: &Admittances, slopes: &Admittances) -> Self {
        let product = y.ambient * y.base;
        let by_product = slopes.ambient * y.base + y.ambient * slopes.base;
        let of = |y: f64, slope: f64| by_product / y - product * slope / (y * y) - slope;
        let (ratio, inverse) = (y.gap / y.cuticle, y.cuticle / y.gap);
        let by_ratio = (slopes.gap - ratio * slopes.cuticle) / y.cuticle;
        let by_inverse = -by_ratio * inverse * inverse;
        Self {
            ratios: by_ratio + by_inverse,
            half_step: 0.5 * (slopes.ambient - slopes.base),
            contrast: 0.5
                * ((slopes.ambient + slopes.base) * (inverse - ratio) + (y.ambient + y.base) * (by_inverse - by_ratio)),
            cos_sin: of(y.gap, slopes.gap),
            sin_cos: of(y.cuticle, slopes.cuticle),
            through: 4.0 * by_product,
        }
    }
}

/// Optical path of each layer of a period, `n d cos` in nm, and its derivatives by the thickness and by the angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paths {
    pub(super) cuticle: f64,
    pub(super) gap: f64,
    pub(super) by_thickness: (f64, f64),
    pub(super) by_angle: (f64, f64),
}

impl Paths {
    pub(super) fn new(media: &Media, incidence: &Incidence, period: Period) -> Self {
        let (cosines, slopes) = (&incidence.cosines, &incidence.slopes);
        let by_thickness = (media.cuticle.re * cosines.cuticle, media.gap.re * cosines.gap);
        Self {
            cuticle: by_thickness.0 * period.cuticle,
            gap: by_thickness.1 * period.gap,
            by_thickness,
            by_angle: (media.cuticle.re * period.cuticle * slopes.cuticle, media.gap.re * period.gap * slopes.gap),
        }
    }
}

/// What one medium or wavelength needs: `F` for s and for p, and the paths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<F> {
    pub(super) y: [F; 2],
    pub(super) paths: Paths,
}

/// What the wavelengths of a block have, each or all the same.
pub(super) trait Lanes<T> {
    fn at(&self, lane: usize) -> T;
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Same<T>(pub(super) T);

impl<T: Copy> Lanes<T> for Same<T> {
    #[inline(always)]
    fn at(&self, _lane: usize) -> T {
        self.0
    }
}

impl<T: Copy, const N: usize> Lanes<T> for [T; N] {
    #[inline(always)]
    fn at(&self, lane: usize) -> T {
        self[lane]
    }
}

/// The rows of a block that starts at `start`; the last one fills it.
#[inline(always)]
pub(super) fn rows_of<F: Copy, const N: usize>(rows: &[Row<F>], start: usize) -> ([F; N], [F; N], [Paths; N]) {
    let last = rows.len() - 1;
    let (mut s, mut p, mut paths) = ([rows[last].y[0]; N], [rows[last].y[1]; N], [rows[last].paths; N]);
    for i in 0..N {
        let row = &rows[(start + i).min(last)];
        (s[i], p[i], paths[i]) = (row.y[0], row.y[1], row.paths);
    }
    (s, p, paths)
}
