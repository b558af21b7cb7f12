//! A measured material in the layout of the RGL material database, and its values.
//!
//! ```text
//! f_r cos(theta_o) = spectra(warp⁻¹(m); phi_i, theta_i, λ) · (ndf(m) / (4 sigma(w_i)) if jacobian, else 1)
//! ```
//!
//! `m` is the half vector of both directions, in the unit square of [`MeasuredFields`]; the warp is that of `vndf`. Spectra are bilinear in
//! the square, linear in azimuth, angle and wavelength, and held beyond their ends.
//!
//! # Source
//! Dupuy, Jakob 2018, DOI 10.1145/3272127.3275059; `measured.cpp` of Mitsuba 3, whose values these are, in double precision.

use super::directions::{angles, direction, half, is_unit, square, unsquare};
use super::tabulate::share;
use super::tensor::{Tensor, TensorData, TensorFile};
use super::warp::{Between, Warp, bilinear, slices};
use super::{BsdfError, fields};
use crate::units::degrees;
use std::f64::consts::TAU;

/// What stands in the file.
///
/// The unit square has `x = sqrt(2 theta / pi)` along its last axis and `y = (phi + pi) / (2 pi)` along the one before, nodes at both ends.
/// `phi` is the azimuth of the half vector, counted from that of the incident light where the material is isotropic.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFields {
    /// What the material is.
    pub description: String,
    /// Angles of incidence from the normal, ascending, rad.
    pub theta_i: Vec<f32>,
    /// Azimuths of incidence, ascending, rad; one or two mean that the material is isotropic.
    pub phi_i: Vec<f32>,
    /// Wavelengths, ascending, nm; none where the channels are red, green and blue.
    pub wavelengths: Option<Vec<f32>>,
    /// Density of the facets' normals.
    pub ndf: Plane,
    /// Projected area of the facets, over the unit square of the incident direction.
    pub sigma: Plane,
    /// Density of the normals that the light sees, `[phi_i, theta_i]` planes one after the other.
    pub vndf: Plane,
    /// Weights for sampling, `[phi_i, theta_i]` square planes.
    pub luminance: Vec<f32>,
    /// Nodes along each side of the planes of spectra.
    pub side: usize,
    /// Values, `[phi_i, theta_i, channel]` square planes.
    pub spectra: Vec<f32>,
    /// Whether the values are to be multiplied by `ndf / (4 sigma)`.
    pub jacobian: bool,
}

/// Values over the unit square, perhaps many planes of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Rows and columns, at least 2 each.
    pub size: [usize; 2],
    /// `[plane, row, column]`.
    pub values: Vec<f32>,
}

impl MeasuredFields {
    /// Number of channels: wavelengths, or 3.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.wavelengths.as_ref().map_or(3, Vec::len)
    }

    /// The fields as a tensor file, which Mitsuba, pbrt and powitacq read.
    ///
    /// # Errors
    /// As [`TensorFile::to_bytes`].
    pub fn into_bytes(self) -> Result<Vec<u8>, BsdfError> {
        let (azimuths, angles, side, channels) = (self.phi_i.len(), self.theta_i.len(), self.side, self.channels());
        let f32s = |name: &str, shape: Vec<usize>, values: Vec<f32>| Tensor {
            name: name.to_owned(),
            shape,
            data: TensorData::F32(values),
        };
        let u8s = |name: &str, values: Vec<u8>| Tensor {
            name: name.to_owned(),
            shape: vec![values.len()],
            data: TensorData::U8(values),
        };
        let [rows, columns] = self.vndf.size;
        let mut tensors = vec![
            u8s("description", self.description.into_bytes()),
            f32s("phi_i", vec![azimuths], self.phi_i),
            f32s("theta_i", vec![angles], self.theta_i),
            f32s("ndf", self.ndf.size.to_vec(), self.ndf.values),
            f32s("sigma", self.sigma.size.to_vec(), self.sigma.values),
            f32s("vndf", vec![azimuths, angles, rows, columns], self.vndf.values),
            f32s("luminance", vec![azimuths, angles, side, side], self.luminance),
            u8s("jacobian", vec![u8::from(self.jacobian)]),
        ];
        let name = if self.wavelengths.is_some() { "spectra" } else { "rgb" };
        tensors.extend(self.wavelengths.map(|wavelengths| f32s("wavelengths", vec![channels], wavelengths)));
        tensors.push(f32s(name, vec![azimuths, angles, channels, side, side], self.spectra));
        TensorFile { tensors }.to_bytes()
    }

    /// The fields of a tensor file; fields that a material has not are left out.
    ///
    /// # Errors
    /// As [`TensorFile::read`]; [`BsdfError::Missing`] or [`BsdfError::Shape`] for a field.
    pub fn read(bytes: &[u8]) -> Result<Self, BsdfError> {
        fields::of(TensorFile::read(bytes)?)
    }
}

/// A material that can be evaluated.
///
/// ```
/// use morpho_fit::bsdf::{BsdfError, MeasuredBsdf, MeasuredFields, Plane};
/// // f_r cos(theta_o) = 0.2 everywhere.
/// let flat = |value: f32| Plane { size: [2, 2], values: vec![value; 4] };
/// let fields = MeasuredFields {
///     description: "flat".into(),
///     theta_i: vec![0.0],
///     phi_i: vec![0.0],
///     wavelengths: Some(vec![400.0, 700.0]),
///     ndf: flat(4.0),
///     sigma: flat(1.0),
///     vndf: flat(1.0),
///     luminance: vec![1.0; 4],
///     side: 2,
///     spectra: vec![0.2; 8],
///     jacobian: true,
/// };
/// let material = MeasuredBsdf::new(MeasuredFields::read(&fields.into_bytes()?)?)?;
/// let mut values = [0.0; 2];
/// material.evaluate([0.0, 0.0, 1.0], [0.6, 0.0, 0.8], &mut values)?;
/// assert!(values.iter().all(|value| (value - 0.2).abs() < 1e-7));
/// # Ok::<(), BsdfError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredBsdf {
    fields: MeasuredFields,
    warp: Warp,
    /// The material looks the same when it is turned by this part of a turn.
    symmetry: u32,
}

/// Where a pair of directions falls in the tables.
struct Place {
    slices: [(usize, f64); 4],
    cell: [(usize, f64); 4],
    factor: f64,
}

impl MeasuredBsdf {
    /// Checks the fields and prepares the warp.
    ///
    /// # Errors
    /// [`BsdfError::Shape`] if lengths do not agree, [`BsdfError::Value`] for a value that is not finite, axes that do not ascend, or a
    /// density below 0.
    pub fn new(fields: MeasuredFields) -> Result<Self, BsdfError> {
        fields::check(&fields)?;
        let warp = Warp::new(&fields.vndf.values, fields.vndf.size);
        let span = fields.phi_i.last().zip(fields.phi_i.first()).map_or(TAU, |(last, first)| f64::from(last - first));
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held within 1 and 64")]
        let symmetry = (TAU / span).round_ties_even().clamp(1.0, 64.0) as u32;
        Ok(Self { fields, warp, symmetry })
    }

    /// What stands in the file.
    #[must_use]
    pub fn fields(&self) -> &MeasuredFields {
        &self.fields
    }

    /// What stands in the file, without the rest.
    #[must_use]
    pub fn into_fields(self) -> MeasuredFields {
        self.fields
    }

    /// Whether turning the material about its normal changes nothing.
    #[must_use]
    pub fn is_isotropic(&self) -> bool {
        self.fields.phi_i.len() <= 2
    }

    /// `f_r cos(theta_o)` in each channel, 1/sr; 0 below the horizon.
    ///
    /// - `incoming`, `outgoing`: unit vectors from the surface. `incoming` is the direction that the table has as `theta_i`, `phi_i`: where
    ///   a renderer has its camera, and a goniometer its lamp.
    ///
    /// # Shape
    /// `out`: one value for each channel.
    ///
    /// # Errors
    /// [`BsdfError::Direction`] for a vector whose length is not 1, [`BsdfError::NoArea`] where the file has no value,
    /// [`BsdfError::Channels`] for another number of channels.
    pub fn evaluate(&self, incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        if out.len() != self.fields.channels() {
            return Err(BsdfError::Channels("one value is needed for each channel of the file"));
        }
        match self.place(incoming, outgoing)? {
            None => out.fill(0.0),
            Some(place) => out.iter_mut().enumerate().for_each(|(channel, out)| *out = self.value(&place, channel)),
        }
        Ok(())
    }

    /// `f_r cos(theta_o)` at one wavelength, nm, linear between those of the file and held beyond them.
    ///
    /// # Errors
    /// As [`MeasuredBsdf::evaluate`]; [`BsdfError::Channels`] for a file of red, green and blue.
    pub fn evaluate_at(&self, incoming: [f64; 3], outgoing: [f64; 3], wavelength: f64) -> Result<f64, BsdfError> {
        let Some(wavelengths) = &self.fields.wavelengths else {
            return Err(BsdfError::Channels(
                "this file has red, green and blue, and no wavelengths: take the spectral one",
            ));
        };
        let Some(place) = self.place(incoming, outgoing)? else { return Ok(0.0) };
        let between = Between::of(wavelengths, wavelength).both();
        Ok(between.into_iter().map(|(channel, share)| share * self.value(&place, channel)).sum())
    }

    /// The half vector of a node, a unit vector; in an isotropic file its azimuth is that from the incident light. None beyond the last.
    ///
    /// - `slice`: number of the incidence, angles within azimuths; `index`: number of the node in the square plane of one channel.
    #[must_use]
    pub fn half_vector(&self, slice: usize, index: usize) -> Option<[f64; 3]> {
        let side = self.fields.side;
        let is_there = index < side * side && slice < self.fields.phi_i.len() * self.fields.theta_i.len();
        is_there.then(|| {
            let (place, _) = self.warp.forward([share(index % side, side), share(index / side, side)], slice);
            let [theta, phi] = unsquare(place);
            direction(theta, phi)
        })
    }

    fn place(&self, incoming: [f64; 3], outgoing: [f64; 3]) -> Result<Option<Place>, BsdfError> {
        if let Some(found) = [incoming, outgoing].into_iter().find(|vector| !is_unit(*vector)) {
            return Err(BsdfError::Direction { found });
        }
        if incoming[2] <= 0.0 || outgoing[2] <= 0.0 {
            return Ok(None);
        }
        let fields = &self.fields;
        let (mut incoming, mut outgoing) = (incoming, outgoing);
        if self.symmetry >= 2 && !self.is_isotropic() {
            // Azimuths below the x axis only; with the order 4, those of the third quadrant.
            let along_y = -1.0_f64.copysign(incoming[1]);
            let along_x = if self.symmetry == 4 { -1.0_f64.copysign(incoming[0]) } else { along_y };
            for vector in [&mut incoming, &mut outgoing] {
                vector[0] *= along_x;
                vector[1] *= along_y;
            }
        }
        let Some(normal) = half(incoming, outgoing) else { return Ok(None) };
        let ([theta_i, phi_i], [theta_m, phi_m]) = (angles(incoming), angles(normal));
        let normal = square(theta_m, if self.is_isotropic() { phi_m - phi_i } else { phi_m });
        let (azimuth, angle) = (Between::of(&fields.phi_i, phi_i), Between::of(&fields.theta_i, theta_i));
        let slices = slices(azimuth, angle, fields.theta_i.len());
        let [x, y] = self.warp.inverse(normal, &slices);
        let (x, y) = (Between::regular(fields.side, x).both(), Between::regular(fields.side, y).both());
        let corner = |up: usize, across: usize| (y[up].0 * fields.side + x[across].0, y[up].1 * x[across].1);
        let cell = [corner(0, 0), corner(0, 1), corner(1, 0), corner(1, 1)];
        let factor = if fields.jacobian {
            // The incident direction is not taken modulo a turn.
            let [x, _] = square(theta_i, 0.0);
            let area = bilinear(&fields.sigma.values, fields.sigma.size, [x, phi_i / TAU + 0.5]);
            if area.abs() < f64::MIN_POSITIVE {
                return Err(BsdfError::NoArea { theta_deg: degrees(theta_i) });
            }
            bilinear(&fields.ndf.values, fields.ndf.size, normal) / (4.0 * area)
        } else {
            1.0
        };
        Ok(Some(Place { slices, cell, factor }))
    }

    fn value(&self, place: &Place, channel: usize) -> f64 {
        let fields = &self.fields;
        let (plane, channels) = (fields.side * fields.side, fields.channels());
        let mut sum = 0.0;
        for (slice, share) in place.slices.into_iter().filter(|(_, share)| *share > 0.0) {
            let first = (slice * channels + channel) * plane;
            let corner = |(index, weight): (usize, f64)| {
                weight * fields.spectra.get(first + index).copied().map_or(0.0, f64::from)
            };
            sum += share * place.cell.map(corner).iter().sum::<f64>();
        }
        sum * place.factor
    }
}
