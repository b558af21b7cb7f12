//! The `hybrid` model: one reciprocal reflectance for every direction, of which a white stack gives back no more than its
//! lamellae fill.
//!
//! ```text
//! f = R · E T · min(G_x, 2) · min(G_y, F) · a²/(lambda b) · sinc²(k a u_x / 2) · P(u_y - v tan(delta))          1/sr
//! (u_x, u_y, v) = w_i + w_o,   k = 2 pi / lambda,   P(p) = pi/(4 w) · cos(pi/2 · p/w)  for |p| < w, else 0,   w = 2 sin(phi_alpha / 2)
//! G = (c_i + c_o)² / (4 c_i c_o);   of G_x  c² = z² + max(r_i², r_o²) - r²,   of G_y  c² = r²,   r² = x² + z²
//! F = max(0, min(J_i, J_o)) / min(1, 1/2 + pi m / (4 w)),   J = 1 + tan(delta) y/z,   m = max of both 1 - |y| + z |tan(delta)|
//! E = 1 + lambda / (20 pi² a),   T = min(1, sqrt(3) / |tan(delta)|)
//! ```
//!
//! `w_i` and `w_o` are the unit vectors (x, y, z) from the surface to source and detector: x across the ridges, y along them, z
//! normal. `b` is the distance of the ridges, R the stack's reflectivity for `cos = v/2`, lambda the wavelength in the
//! ambient medium. Across the ridges f is the slit of a lamella, along them a lobe about the mirror beam of the layers.
//!
//! - **Tilt.** Layers tilted by `delta` mirror where `u_y = v tan(delta)`: in the plane along the ridges that is exactly
//!   `phi = 2 delta - theta`. `u_y` and `v` are sums over both directions, so exchanging them changes nothing.
//! - **Lobe.** `P` has the integral 1, and the shape of the paper's lobe. A layer turned by `phi_alpha / 2` sends light back
//!   along its own normal at `u_y = 2 sin(phi_alpha / 2)`; near the normal this is a half-width of `phi_alpha` in `phi`.
//! - **Obliquity.** In either of the two planes, and between directions of one `|y|`, `G_x G_y` is `v² / (4 z_i z_o)`. It is 1 in
//!   the mirror direction of layers without tilt, and grows without end where one direction grazes and the other does not.
//! - **Energy.** `du_x du_y = cos_o dΩ`, so slit and lobe have at most the mass `a/b`. J is what turns `dy` into the argument of P;
//!   the smaller of both is what layers that shadow and mask each other leave, as facets do. `m` is how far P reaches before the
//!   horizon, at most: light that grazes along the ridges meets half of an even lobe below it, light that grazes across them half
//!   of the slit (hence the 2). The albedo of a white stack (R = 1) is then at most `a/b`, and so at most 1 (a lamella wider than the spacing is refused):
//!   0.9986 of it where a narrow lobe of wide lamellae (30 wavelengths) grazes, and less everywhere else in searches over incidence,
//!   lobe and tilt. Steep layers are dimmed by T: from 60° on the light that they mirror grazes both ways.
//! - **Compensation.** What the limits take, E shares out among all directions: they take 0 to 0.06 of `lambda / (pi² a)`, by the
//!   incidence, and E gives 1/20. At 470 nm, in the limit of a narrow lobe, lamellae of 300 nm keep the albedo that `v² / (4 z_i z_o)`
//!   has at 0, 40 and 75°, 0.14 to 0.35, to 0.002; near the horizon that one has no bound.
//! - **Grazing.** Along the horizon f is finite, and 0 where the layers are in their own shadow (`J <= 0`); below it 0. Where both
//!   directions graze, tilted layers have no one limit, nor a bound.
//!
//! In the plane of incidence a detector reads `f cos_o · 1 sr`: the share of the incident power that reaches it, as `phi`
//! of the other models, for a detector of 1 sr that looks at all of the spot.

use crate::geometry::{Geometry, Polarization};
use crate::optics::error::require;
use crate::optics::lamella::slit_factor;
use crate::optics::multilayer::{self, Period, SAndP, StackSlopes};
use crate::optics::{Join, Media, OpticsError, ReflectivityModel, Stack, Structure};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::ops::RangeInclusive;

/// Distances of ridges, nm.
const SPACINGS: RangeInclusive<f64> = 1.0..=1e6;

/// `E - 1` of a lamella as wide as the wavelength: see the [module](self).
const COMPENSATION: f64 = 1.0 / (20.0 * PI * PI);

/// Tangent of the tilt from which T dims.
const STEEP: f64 = 1.732_050_807_568_877_2;

/// Cosine that stands in for smaller ones in a slope, so that a rounded direction along x has none along y.
const HORIZON: f64 = 1e-9;

/// Squared lengths of a unit vector, to the rounding of a file with seven digits.
const UNIT: RangeInclusive<f64> = 1.0 - 1e-6..=1.0 + 1e-6;

/// Both planes as one product: see the [module](self).
///
/// ```
/// use morpho_fit::geometry::Polarization;
/// use morpho_fit::optics::{HybridModel, Structure};
/// let (model, blue) = (HybridModel::default(), Structure::blue());
/// let (up, side) = ([0.0, 0.0, 1.0], [0.6, 0.0, 0.8]);
/// let there = model.brdf(&blue, up, side, Polarization::Unpolarized, 470.0)?;
/// let back = model.brdf(&blue, side, up, Polarization::Unpolarized, 470.0)?;
/// assert!(there > 0.0 && (there - back).abs() < 1e-15);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct HybridModel {
    /// Media and layer count.
    pub stack: Stack,
    /// Distance of the ridges `b`, nm, 1 to 1e6.
    pub ridge_spacing: f64,
}

impl HybridModel {
    /// Distance of the ridges of a *Morpho*, nm.
    pub const RIDGE_SPACING: f64 = 750.0;

    /// The bidirectional reflectance distribution function, 1/sr.
    ///
    /// - `incoming`, `outgoing`: unit vectors from the surface to source and detector: x across the ridges, y along them, z
    ///   along the scale normal. Exchanging them changes nothing. Below the horizon it is 0.
    /// - `polarization`: against the plane that holds both of them, in which the layers reflect.
    /// - `wavelength` in vacuum, nm.
    ///
    /// # Errors
    /// [`OpticsError::OutOfRange`] for input out of range, such as a vector whose length is not 1.
    pub fn brdf(
        &self,
        structure: &Structure,
        incoming: [f64; 3],
        outgoing: [f64; 3],
        polarization: Polarization,
        wavelength: f64,
    ) -> Result<f64, OpticsError> {
        self.validate()?;
        structure.validate()?;
        require_narrow(structure, self.ridge_spacing)?;
        for (quantity, [x, y, z]) in
            [("squared length of incoming", incoming), ("squared length of outgoing", outgoing)]
        {
            let squared = x * x + y * y + z * z;
            require(UNIT.contains(&squared), quantity, squared, "", "1: give a unit vector")?;
        }
        let media = self.stack.media(wavelength)?;
        if incoming[2] < 0.0 || outgoing[2] < 0.0 {
            return Ok(0.0);
        }
        let node = HybridNode::new(incoming, outgoing, wavelength / media.ambient);
        let both = self.stack_reflectivity(&media, Period::of(structure), node.angle)?;
        let (s, p) = polarization.shares();
        Ok((s * both.s + p * both.p) * node.spread(structure, self.ridge_spacing))
    }
}

/// Checks that a lamella is no wider than the distance of the ridges.
pub(crate) fn require_narrow(structure: &Structure, ridge_spacing: f64) -> Result<(), OpticsError> {
    let width = structure.lamella_width;
    require(width <= ridge_spacing, "lamella_width", width, "nm", "at most the spacing of the ridges")
}

impl Default for HybridModel {
    /// The default stack with ridges 750 nm apart.
    fn default() -> Self {
        Self { stack: Stack::default(), ridge_spacing: Self::RIDGE_SPACING }
    }
}

impl ReflectivityModel for HybridModel {
    fn name(&self) -> &'static str {
        "hybrid"
    }

    fn stack(&self) -> &Stack {
        &self.stack
    }

    fn join(&self) -> Join {
        Join::Product { ridge_spacing: self.ridge_spacing }
    }

    fn validate(&self) -> Result<(), OpticsError> {
        let found = self.ridge_spacing;
        require(SPACINGS.contains(&found), "ridge spacing", found, "nm", "1 to 1e6")
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn stack_reflectivity(&self, media: &Media, period: Period, angle: f64) -> Result<SAndP, OpticsError> {
        Ok(multilayer::reflectivity_unchecked(media, period, self.stack.layers, angle))
    }

    fn stack_reflectivities(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [SAndP],
    ) -> Result<(), OpticsError> {
        multilayer::reflectivities_unchecked(media, wavenumbers, period, self.stack.layers, angle, out);
        Ok(())
    }

    fn stack_slopes(
        &self,
        media: &[Media],
        wavenumbers: &[f64],
        period: Period,
        angle: f64,
        out: &mut [StackSlopes],
    ) -> bool {
        multilayer::slopes_unchecked(media, wavenumbers, period, self.stack.layers, angle, out)
    }
}

/// Two directions as the product sees them at every wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    /// `w_i + w_o` across the ridges, along them and along the normal.
    pub(crate) u_x: f64,
    u_y: f64,
    pub(crate) v: f64,
    /// `min(G_x, 2)`.
    across: f64,
    /// `G_y`; infinite where one direction grazes along the ridges.
    along: f64,
    /// `y / z` of both directions.
    slopes: [f64; 2],
    /// `1 - |y|` and z of both.
    margins: [[f64; 2]; 2],
}

/// `(one + other)² / (4 one other)`; infinite where one is 0, and 1 where both are.
#[inline]
fn obliquity(one: f64, other: f64) -> f64 {
    let (sum, product) = (one + other, one * other);
    if sum > 0.0 { sum * sum / (4.0 * product) } else { 1.0 }
}

impl Pair {
    /// Of two unit vectors above the horizon.
    #[inline]
    pub(crate) fn new(incoming: [f64; 3], outgoing: [f64; 3]) -> Self {
        let [u_x, u_y, v] = std::array::from_fn(|axis| incoming[axis] + outgoing[axis]);
        let both = [incoming, outgoing];
        let slopes = both.map(|[_, y, z]| y / z.max(HORIZON));
        let margins = both.map(|[_, y, z]| [1.0 - y.abs(), z]);
        let radii = both.map(|[x, _, z]| x * x + z * z);
        let largest = radii[0].max(radii[1]);
        let cosine = |place: usize| (both[place][2].powi(2) + (largest - radii[place])).sqrt();
        let across = obliquity(cosine(0), cosine(1)).min(2.0);
        let along = obliquity(radii[0].sqrt(), radii[1].sqrt());
        Self { u_x, u_y, v, across, along, slopes, margins }
    }
}

/// The part of f that is the same at every wavelength, of one structure: `T min(G_x, 2) min(G_y, F) · a²/b · P`, nm/sr.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shape {
    /// `T a²/b`, nm.
    strength: f64,
    tilt: f64,
    half_width: f64,
}

impl Shape {
    #[inline]
    pub(crate) fn of(structure: &Structure, ridge_spacing: f64) -> Self {
        let Structure { delta, phi_alpha, lamella_width, .. } = *structure;
        let tilt = delta.tan();
        let dimmed = (STEEP / tilt.abs()).min(1.0);
        Self {
            strength: dimmed * lamella_width * lamella_width / ridge_spacing,
            tilt,
            half_width: 2.0 * (0.5 * phi_alpha).sin(),
        }
    }

    #[inline]
    pub(crate) fn at(&self, pair: &Pair) -> f64 {
        let Self { strength, tilt, half_width } = *self;
        let offset = pair.u_y - pair.v * tilt;
        if offset.abs() >= half_width {
            return 0.0;
        }
        let lobe = FRAC_PI_4 / half_width * (FRAC_PI_2 * offset / half_width).cos();
        let facing = (1.0 + tilt * pair.slopes[0]).min(1.0 + tilt * pair.slopes[1]).max(0.0);
        let [one, other] = pair.margins.map(|[margin, z]| margin + z * tilt.abs());
        let above = (0.5 + FRAC_PI_4 * one.max(other) / half_width).min(1.0);
        strength * pair.across * pair.along.min(facing / above) * lobe
    }
}

/// The part of f beside R that depends on the wavelength, `E · sinc²(k a u_x / 2) / lambda`, 1/nm.
///
/// - `half_ku`: `u_x k / 2`, 1/nm; `wavelength` in the ambient medium, nm.
#[inline]
pub(crate) fn slit_share(half_ku: f64, lamella_width: f64, wavelength: f64) -> f64 {
    let slit = slit_factor(half_ku * lamella_width);
    (wavelength.recip() + COMPENSATION / lamella_width) * slit * slit
}

/// The two directions of one reading at its wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HybridNode {
    /// Angle of the light from the layers' normal, `acos(v / 2)`, rad.
    pub(crate) angle: f64,
    /// `u_x k / 2`, 1/nm.
    half_ku: f64,
    /// In the ambient medium, nm.
    wavelength: f64,
    /// What a reading has beside f: `cos_o` times 1 sr, or 1.
    obliquity: f64,
    pair: Pair,
}

impl HybridNode {
    /// Of two unit vectors above the horizon, for f; `wavelength` in the ambient medium, nm.
    pub(crate) fn new(incoming: [f64; 3], outgoing: [f64; 3], wavelength: f64) -> Self {
        let pair = Pair::new(incoming, outgoing);
        let half_ku = PI * pair.u_x / wavelength;
        Self { angle: layer_angle(pair.v), half_ku, wavelength, obliquity: 1.0, pair }
    }

    /// The same directions at another wavelength, of a node that was made for 1 nm.
    pub(crate) fn at_wavelength(&self, wavelength: f64) -> Self {
        Self { half_ku: self.half_ku / wavelength, wavelength, ..*self }
    }

    /// Of a reading in the plane of incidence, for `f cos_o`; angles at most pi/2 in size.
    pub(crate) fn in_plane(geometry: &Geometry, wavelength: f64) -> Self {
        let Geometry { theta, phi, omega } = *geometry;
        let (sin, cos) = omega.sin_cos();
        let of = |angle: f64| [angle.sin() * cos, angle.sin() * sin, angle.cos().max(0.0)];
        let [incoming, outgoing] = [of(theta), of(phi)];
        let node = Self::new(incoming, outgoing, wavelength);
        // At the mirror direction u is 0, which the sum of two rounded sines need not be.
        let u = if (theta + phi).abs() < f64::EPSILON { 0.0 } else { theta.sin() + phi.sin() };
        let half_ku = PI * u * cos / wavelength;
        let pair = Pair { u_x: u * cos, u_y: u * sin, ..node.pair };
        Self { half_ku, pair, obliquity: outgoing[2], ..node }
    }

    /// All of the product but R: 1/sr of the BRDF, or what a detector of 1 sr reads; NaN for a lamella wider than the
    /// spacing of the ridges.
    #[inline]
    pub(crate) fn spread(&self, structure: &Structure, ridge_spacing: f64) -> f64 {
        let lamella_width = structure.lamella_width;
        if lamella_width > ridge_spacing {
            return f64::NAN;
        }
        let shape = Shape::of(structure, ridge_spacing).at(&self.pair);
        if shape <= 0.0 {
            0.0
        } else {
            self.obliquity * shape * slit_share(self.half_ku, lamella_width, self.wavelength)
        }
    }
}

/// Angle of the light from the layers' normal, `acos(v / 2)`, rad.
#[inline]
pub(crate) fn layer_angle(v: f64) -> f64 {
    (0.5 * v).min(1.0).acos()
}
