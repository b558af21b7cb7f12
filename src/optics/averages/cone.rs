//! The rays of an objective's cone, with the polarization that each has at the layers.

use crate::numerics::quadrature::{Node, even};
use std::f64::consts::PI;

/// Rays from the axis of the cone to its edge at least, and how many more for each layer and the numerical aperture.
const RADIAL: [f64; 2] = [8.0, 1.5];
/// How many more for the square of the numerical aperture, and for that and each layer where this is more: each layer adds to
/// the path by which oblique rays fall behind. The last is for a cone about the normal, where more rays cost little.
const BEHIND: [f64; 3] = [56.0, 9.0, 16.0];
/// Rays from the axis to the edge at most.
const RINGS: f64 = 512.0;
/// Rays around half of the cone, whose other half is its mirror image in the plane of incidence: so many, and so many times the
/// numerical aperture and the sine of incidence.
const AROUND: [f64; 2] = [24.0, 160.0];
/// Step of the angle for the derivative of a ray's share of s, rad.
const TURN: f64 = 1e-6;

/// One plane wave of a reading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beam {
    /// Angle from the normal of the layers in the ambient medium, rad.
    pub(super) angle: f64,
    /// Its derivative by the angle of the cone's axis.
    pub(super) slope: f64,
    /// Share of the light of either polarization that is the same of the ray itself; the rest is the other.
    pub(super) own: f64,
    /// Its derivative by the angle of the cone's axis, 1/rad.
    pub(super) own_slope: f64,
    pub(super) share: f64,
}

/// A cone of light on layers.
#[derive(Debug)]
pub(super) struct Cone {
    aperture: f64,
    /// Square of the sine of each ring of rays over that of the outermost, with its share: of a cone about the normal.
    about_normal: Vec<Node>,
    /// The same of any other cone.
    oblique: Vec<Node>,
}

impl Cone {
    /// The cone of numerical aperture `aperture` on a stack of `layers`.
    pub(super) fn new(layers: usize, aperture: f64) -> Self {
        let [about_normal, oblique] = [BEHIND[2], BEHIND[1]].map(|of_layer| rings(layers, aperture, of_layer));
        Self { aperture, about_normal, oblique }
    }

    /// The rays about an axis at `angle`.
    pub(super) fn beams(&self, ambient: f64, angle: f64) -> Vec<Beam> {
        let aperture = self.aperture;
        let sine = |ring: &Node| (aperture / ambient * (0.5 * (1.0 + ring.at)).sqrt()).min(1.0);
        if angle.sin().abs() < f64::EPSILON {
            // All azimuths are one, with half of either polarization; what one side gains by a turn the other loses.
            let beam = |ring: &Node| Beam {
                angle: sine(ring).asin(),
                slope: 0.0,
                own: 0.5,
                own_slope: 0.0,
                share: ring.share,
            };
            return self.about_normal.iter().map(beam).collect();
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "32 to 256")]
        let around = (AROUND[0] + AROUND[1] * aperture * angle.sin().abs()).ceil() as usize;
        let around = around.next_power_of_two();
        let mut beams = Vec::with_capacity(around * self.oblique.len());
        for ring in &self.oblique {
            for step in 0..around {
                #[allow(clippy::cast_precision_loss, reason = "a few rays")]
                let (azimuth, share) = (PI * (step as f64 + 0.5) / around as f64, ring.share / around as f64);
                let [(below, own_below), (at, own), (above, own_above)] =
                    [angle - TURN, angle, angle + TURN].map(|angle| ray(angle, sine(ring), azimuth));
                let (slope, own_slope) = ((above - below) / (2.0 * TURN), (own_above - own_below) / (2.0 * TURN));
                beams.push(Beam { angle: at, slope, own, own_slope, share });
            }
        }
        beams
    }
}

/// The rings of a cone of `aperture` that falls on `layers`.
fn rings(layers: usize, aperture: f64, of_layer: f64) -> Vec<Node> {
    #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
    let layers = layers as f64;
    let count = RADIAL[0] + RADIAL[1] * layers * aperture + BEHIND[0].max(of_layer * layers) * aperture * aperture;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "8 to 512")]
    even(count.ceil().min(RINGS) as usize)
}

/// Angle from the layers' normal of the ray of `azimuth` whose angle from the axis has the sine `sine`, and the share of its
/// light that is s there if the pupil is lit with s, or p if with p; the axis is at `angle`.
fn ray(angle: f64, sine: f64, azimuth: f64) -> (f64, f64) {
    let ((sin, cos), cosine) = (angle.sin_cos(), (1.0 - sine * sine).sqrt());
    let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
    // Frame: the layers' normal is z, the axis (sin, 0, cos), x' = (-cos, 0, sin) and y across the plane of incidence.
    let direction =
        [sine * cos_azimuth * -cos + cosine * sin, sine * sin_azimuth, cosine * cos + sine * cos_azimuth * sin];
    let polar =
        [cosine * cos_azimuth * -cos - sine * sin, cosine * sin_azimuth, cosine * cos_azimuth * sin - sine * cos];
    let azimuthal = [sin_azimuth * cos, cos_azimuth, -sin_azimuth * sin];
    // An objective turns each ray's field about the azimuthal direction: the pupil's y is cos and sin of the azimuth in the two.
    let field: [f64; 3] = std::array::from_fn(|axis| cos_azimuth * azimuthal[axis] + sin_azimuth * polar[axis]);
    let across = direction[0].hypot(direction[1]);
    let along_s = if across > 0.0 { (field[1] * direction[0] - field[0] * direction[1]) / across } else { 1.0 };
    (across.atan2(direction[2]), along_s * along_s)
}
