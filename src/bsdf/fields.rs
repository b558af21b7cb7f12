//! Fields of a measured material: from tensors, and checked.

use super::BsdfError;
use super::measured::{MeasuredFields, Plane};
use super::tensor::{TensorData, TensorFile};

/// Takes the fields of a material out of a file.
pub(super) fn of(mut file: TensorFile) -> Result<MeasuredFields, BsdfError> {
    let mut take = |name: &'static str| {
        let place = file.tensors.iter().position(|tensor| tensor.name == name);
        place.map(|place| file.tensors.swap_remove(place)).ok_or(BsdfError::Missing { name })
    };
    let mut f32s = |name: &'static str, dimensions: usize, expected: &'static str| {
        let tensor = take(name)?;
        match tensor.data {
            TensorData::F32(values) if tensor.shape.len() == dimensions => Ok((tensor.shape, values)),
            _ => Err(BsdfError::Shape { name, found: tensor.shape, expected }),
        }
    };
    let list = "numbers of single precision in one row are needed";
    let plane = "single precision in rows and columns is needed";
    let planes = "single precision in the shape [phi_i, theta_i, rows, columns] is needed";
    let (_, theta_i) = f32s("theta_i", 1, list)?;
    let (_, phi_i) = f32s("phi_i", 1, list)?;
    let (ndf_shape, ndf) = f32s("ndf", 2, plane)?;
    let (sigma_shape, sigma) = f32s("sigma", 2, plane)?;
    let (vndf_shape, vndf) = f32s("vndf", 4, planes)?;
    let (luminance_shape, luminance) = f32s("luminance", 4, planes)?;
    let wavelengths = match f32s("wavelengths", 1, list) {
        Ok((_, wavelengths)) => Some(wavelengths),
        Err(BsdfError::Missing { .. }) => None,
        Err(error) => return Err(error),
    };
    let name = if wavelengths.is_some() { "spectra" } else { "rgb" };
    let (shape, spectra) =
        f32s(name, 5, "single precision in the shape [phi_i, theta_i, channel, side, side] is needed")?;
    let [_, _, channels, side, other] = shape.as_slice() else {
        return Err(BsdfError::Shape { name, found: shape, expected: "five dimensions" });
    };
    let (slices, side) = ([phi_i.len(), theta_i.len()], *side);
    let fits = shape.starts_with(&slices) && *channels == wavelengths.as_ref().map_or(3, Vec::len) && side == *other;
    if !fits {
        return Err(BsdfError::Shape { name, found: shape, expected: "it must fit the axes, with square planes" });
    }
    if luminance_shape != [slices[0], slices[1], side, side] {
        return Err(BsdfError::Shape {
            name: "luminance",
            found: luminance_shape,
            expected: "it must fit the spectra",
        });
    }
    if !vndf_shape.starts_with(&slices) {
        return Err(BsdfError::Shape { name: "vndf", found: vndf_shape, expected: "it must fit the axes" });
    }
    let size = |shape: &[usize], from: usize| [0, 1].map(|axis| shape.get(from + axis).copied().unwrap_or(0));
    let description = take("description")?;
    let TensorData::U8(text) = description.data else {
        return Err(BsdfError::Shape { name: "description", found: description.shape, expected: "text is needed" });
    };
    let jacobian = take("jacobian")?;
    let (TensorData::U8(flag), [1]) = (&jacobian.data, jacobian.shape.as_slice()) else {
        return Err(BsdfError::Shape { name: "jacobian", found: jacobian.shape, expected: "one byte is needed" });
    };
    Ok(MeasuredFields {
        description: String::from_utf8_lossy(&text).into_owned(),
        theta_i,
        phi_i,
        wavelengths,
        ndf: Plane { size: size(&ndf_shape, 0), values: ndf },
        sigma: Plane { size: size(&sigma_shape, 0), values: sigma },
        vndf: Plane { size: size(&vndf_shape, 2), values: vndf },
        luminance,
        side,
        spectra,
        jacobian: flag.first().is_some_and(|flag| *flag != 0),
    })
}

/// Whether the fields make a material.
pub(super) fn check(fields: &MeasuredFields) -> Result<(), BsdfError> {
    let finite = |name: &'static str, values: &[f32]| match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(wrong(name, values, index, "is no finite number")),
        None => Ok(()),
    };
    let not_negative = |name: &'static str, values: &[f32]| match values.iter().position(|value| *value < 0.0) {
        Some(index) => Err(wrong(name, values, index, "is below 0")),
        None => Ok(()),
    };
    let ascending = |name: &'static str, values: &[f32]| {
        finite(name, values)?;
        match values.windows(2).position(|pair| pair[0] >= pair[1]) {
            Some(index) => Err(wrong(name, values, index + 1, "is not above the one before")),
            None if values.is_empty() => Err(BsdfError::Shape { name, found: vec![0], expected: "one value at least" }),
            None => Ok(()),
        }
    };
    let MeasuredFields { theta_i, phi_i, wavelengths, ndf, sigma, vndf, luminance, side, spectra, .. } = fields;
    ascending("theta_i", theta_i)?;
    ascending("phi_i", phi_i)?;
    if let Some(wavelengths) = wavelengths {
        ascending("wavelengths", wavelengths)?;
    }
    let slices = phi_i.len().checked_mul(theta_i.len());
    let filled = |name, planes: Option<usize>, size: [usize; 2], values: &[f32]| {
        let needed = size.iter().try_fold(planes.unwrap_or(0), |count, length| count.checked_mul(*length));
        if size.iter().all(|length| *length >= 2) && planes.is_some() && needed == Some(values.len()) {
            finite(name, values)
        } else {
            let expected = "at least 2 rows and 2 columns for each direction and channel";
            Err(BsdfError::Shape { name, found: size.to_vec(), expected })
        }
    };
    filled("ndf", Some(1), ndf.size, &ndf.values)?;
    filled("sigma", Some(1), sigma.size, &sigma.values)?;
    filled("vndf", slices, vndf.size, &vndf.values)?;
    filled("luminance", slices, [*side, *side], luminance)?;
    let name = if wavelengths.is_some() { "spectra" } else { "rgb" };
    filled(name, slices.and_then(|slices| slices.checked_mul(fields.channels())), [*side, *side], spectra)?;
    not_negative("ndf", &ndf.values)?;
    not_negative("sigma", &sigma.values)?;
    not_negative("vndf", &vndf.values)
}

fn wrong(name: &'static str, values: &[f32], index: usize, problem: &'static str) -> BsdfError {
    BsdfError::Value { name, index, found: values.get(index).copied().unwrap_or_default(), problem }
}
