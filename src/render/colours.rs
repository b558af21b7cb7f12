//! The colour of any pair of directions: a table of two axes, or three, times a factor.

use super::error::RenderError;
use super::spectra::Spectra;
use crate::colorimetry::Integration;
use crate::optics::hybrid::{Pair, Shape};
use crate::optics::{ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;

/// Intervals of each axis of directions to begin with, and of the gap.
const FIRST: usize = 16;
const FIRST_GAPS: usize = 1;
/// An axis that is too coarse gets one interval more for each of so many: half as many again, which makes it 2.25 times as good.
const GROWTH: usize = 2;
/// Nodes at most, 128 MB.
const MOST_NODES: usize = 1 << 23;
/// Part of the tolerance that a midpoint on one axis may take: the errors of two axes add.
const OF_ONE_AXIS: f64 = 0.5;
/// Random directions whose spectra choose the wavelengths.
const PROBES: usize = 400;

/// What the colours are seen with.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// Wavelengths of the spectra, nm.
    pub wavelengths: &'a Wavelengths,
    /// Observer and light at these.
    pub integration: &'a Integration,
}

/// How far interpolated colours are from those of spectra at the same wavelengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookupError {
    /// Largest CIEDE2000 difference of pixels. Their light holds `cos_i`, which is at most `min(1, v)`: the colour is taken
    /// times that, and the brightest of the table as light as white.
    pub worst: f64,
    /// Mean difference.
    pub mean: f64,
    /// Random pairs of directions (and gaps) that were compared.
    pub compared: usize,
}

/// XYZ of `pi f`, for any pair of directions and any gap within a range.
///
/// ```text
/// pi f -> XYZ = shape(w_i, w_o) · T(d_air, v, |u_x|),   T = pi sum_λ w(λ) R(λ, v) E(λ) sinc²(k a u_x / 2) / λ
/// ```
///
/// T is linear in the gap, in `sqrt(v / 2)` and in `|u_x|` between regular nodes, as many as a tolerance needs; the shape is exact.
/// Near `v = 0` the light grazes the layers and R rises steeply to 1: the root puts more nodes there.
///
/// ```
/// use morpho_fit::colorimetry::{Illuminant, Integration, Observer};
/// use morpho_fit::optics::{HybridModel, Structure};
/// use morpho_fit::render::{ColourLookup, Seen};
/// use morpho_fit::spectrum::Wavelengths;
/// let wavelengths = Wavelengths::visible(10.0)?;
/// let integration = Integration::new(&wavelengths, Observer::Cie1931, &Illuminant::D65)?;
/// let seen = Seen { wavelengths: &wavelengths, integration: &integration };
/// let blue = ColourLookup::new(&HybridModel::default(), &Structure::blue(), [141.0; 2], &seen, 0.5)?;
/// let [x, y, z] = blue.xyz([0.0, 0.0, 1.0], [0.0, 0.0, 1.0], 141.0);
/// assert!(z > x && z > y && blue.error().worst < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct ColourLookup {
    pub(super) shape: Shape,
    /// First gap and last, nm.
    pub(super) gaps: [f64; 2],
    /// Nodes of gap, v and `|u_x|`.
    pub(super) nodes: [usize; 3],
    /// Nodes for each nm of gap and each unit of the directions.
    pub(super) scale: [f32; 3],
    pub(super) values: Vec<[f32; 4]>,
    pub(super) error: LookupError,
}

impl ColourLookup {
    /// The table of `structure`, whose `d_air` may be anything from `gaps[0]` to `gaps[1]`, nm, in unpolarized light.
    ///
    /// # Errors
    /// [`RenderError`] for a model that is a sum of planes, a structure or a range out of range, and for a `tolerance`
    /// (CIEDE2000) that is not above 0 or asks for more than 8 million nodes.
    pub fn new(
        model: &dyn ReflectivityModel,
        structure: &Structure,
        gaps: [f64; 2],
        seen: &Seen<'_>,
        tolerance: f64,
    ) -> Result<Self, RenderError> {
        let is_tolerance = tolerance > 0.0;
        if !is_tolerance {
            let quantity = "the tolerance, ΔE₀₀,";
            return Err(RenderError::OutOfRange { quantity, found: tolerance, allowed: "above 0" });
        }
        let spectra = Spectra::new(model, structure, gaps, seen.wavelengths)?.weighted_by(seen.integration)?;
        let mut intervals = [if gaps[1] > gaps[0] { FIRST_GAPS } else { 0 }, FIRST, FIRST];
        loop {
            let mut table = spectra.table(intervals)?;
            let gap = if intervals[0] > 0 { spectra.midpoints(&table, 0)? } else { 0.0 };
            let offsets = [gap, spectra.midpoints(&table, 1)?, spectra.midpoints(&table, 2)?];
            if offsets.iter().all(|offset| *offset <= OF_ONE_AXIS * tolerance) {
                table.error = spectra.judged(&table)?;
                if table.error.worst <= tolerance {
                    return Ok(table);
                }
            }
            // More intervals for the axis that is worst.
            let worst = (0..3).max_by(|&a, &b| offsets[a].total_cmp(&offsets[b])).unwrap_or_default();
            intervals[worst] += intervals[worst].div_ceil(GROWTH);
            let nodes = intervals.iter().map(|count| count + 1).product();
            if nodes > MOST_NODES {
                return Err(RenderError::TooLarge { nodes, worst: offsets[worst], tolerance });
            }
        }
    }

    /// XYZ of `pi f` (a white diffuser has Y = 1) for unit vectors to source and eye: x across the ridges, y along them, z along
    /// the normal. Below the horizon it is black. A gap beyond the range is taken at its end.
    #[inline]
    #[must_use]
    pub fn xyz(&self, incoming: [f64; 3], outgoing: [f64; 3], gap: f64) -> [f64; 3] {
        if incoming[2] < 0.0 || outgoing[2] < 0.0 {
            return [0.0; 3];
        }
        let pair = Pair::new(incoming, outgoing);
        let shape = self.shape.at(&pair);
        // Vectors that are none, such as of NaN, are black too.
        if shape > 0.0 && shape.is_finite() {
            self.interpolated(gap, pair.v, pair.u_x.abs()).map(|value| shape * f64::from(value))
        } else {
            [0.0; 3]
        }
    }

    /// Spectra of the light of pixels ([`LookupError::worst`]) in random pairs of directions and gaps, by 1 nm
    /// ([`Wavelengths::finest`]), the brightest value among them being 1: what [`Sampling::coarsest`](crate::sweep::Sampling::coarsest) chooses the wavelengths by.
    ///
    /// # Shape
    /// `[spectrum][401]`.
    ///
    /// # Errors
    /// As [`ColourLookup::new`].
    pub fn probes(
        model: &dyn ReflectivityModel,
        structure: &Structure,
        gaps: [f64; 2],
    ) -> Result<Vec<Vec<f64>>, RenderError> {
        let spectra = Spectra::new(model, structure, gaps, &Wavelengths::finest())?;
        let mut found = Vec::with_capacity(PROBES);
        for [gap, v, u] in spectra.random(PROBES) {
            let reflectivity = spectra.reflectivity(gap, v)?;
            found.push(
                reflectivity.iter().zip(spectra.slits(u)).map(|(value, slit)| value * slit).collect::<Vec<f64>>(),
            );
        }
        let brightest = found.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        found.iter_mut().flatten().for_each(|value| *value /= brightest);
        Ok(found)
    }

    /// Nodes of the gap, of `v` and of `|u_x|`.
    #[must_use]
    pub fn nodes(&self) -> [usize; 3] {
        self.nodes
    }

    /// Bytes of the table.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// How far it is from spectra.
    #[must_use]
    pub fn error(&self) -> LookupError {
        self.error
    }

    #[inline]
    pub(super) fn interpolated(&self, gap: f64, v: f64, u: f64) -> [f32; 3] {
        let [gaps, rows, columns] = self.nodes;
        let (row, down) = place((0.5 * v).sqrt(), self.scale[1], rows);
        let (column, right) = place(u, self.scale[2], columns);
        let plane = |plane: usize| {
            let first = (plane * rows + row) * columns + column;
            mix(self.between(first, right), self.between(first + columns, right), down)
        };
        let [x, y, z, _] = if gaps > 1 {
            let (first, share) = place(gap - self.gaps[0], self.scale[0], gaps);
            mix(plane(first), plane(first + 1), share)
        } else {
            plane(0)
        };
        [x, y, z]
    }

    /// The value between node `first` and the next one.
    #[inline]
    fn between(&self, first: usize, share: f32) -> [f32; 4] {
        match self.values.get(first..first + 2) {
            Some([near, far]) => mix(*near, *far, share),
            _ => [0.0; 4],
        }
    }
}

/// The node below `at`, at most the last but one, and the share of the next one.
#[inline]
fn place(at: f64, scale: f32, nodes: usize) -> (usize, f32) {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the axis")]
    #[allow(clippy::cast_precision_loss, reason = "at most some thousand nodes")]
    let (at, last) = ((at as f32 * scale).max(0.0), (nodes - 1) as f32);
    let at = at.min(last);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the axis")]
    let below = (at as usize).min(nodes.saturating_sub(2));
    #[allow(clippy::cast_precision_loss, reason = "at most some thousand nodes")]
    let share = at - below as f32;
    (below, share)
}

#[inline]
fn mix(near: [f32; 4], far: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|channel| near[channel] + share * (far[channel] - near[channel]))
}
