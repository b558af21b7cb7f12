//! Arrays in the file format of `numpy`.

use super::ExportError;

/// Bytes to a multiple of which the head is filled up.
const ALIGNMENT: usize = 64;

/// An array in single precision as an NPY file, version 1.0, which `numpy.load` reads.
///
/// ```text
/// \x93NUMPY, 1, 0, length of the head as u16, {'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }, values
/// ```
///
/// # Shape
/// `values` in C order: the last of `shape` fastest.
///
/// # Source
/// The documentation of `numpy.lib.format`.
///
/// # Errors
/// [`ExportError::Shape`] if there are not as many values as the shape says, or too many dimensions for the head.
///
/// ```
/// use morpho_fit::export::npy;
/// let file = npy(&[2, 3], &[0.0; 6])?;
/// assert!(file.starts_with(b"\x93NUMPY\x01\x00") && file.len() == 128 + 24);
/// # Ok::<(), morpho_fit::export::ExportError>(())
/// ```
pub fn npy(shape: &[usize], values: &[f32]) -> Result<Vec<u8>, ExportError> {
    let wrong = || ExportError::Shape { shape: shape.to_vec(), values: values.len() };
    let count = shape.iter().try_fold(1_usize, |count, &length| count.checked_mul(length));
    if count != Some(values.len()) {
        return Err(wrong());
    }
    // A tuple of one has its comma.
    let lengths: Vec<String> = shape.iter().map(|length| format!("{length},")).collect();
    let mut head = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}", lengths.join(" "));
    let before = 10;
    let filled = (before + head.len() + 1).next_multiple_of(ALIGNMENT) - before;
    head.push_str(&" ".repeat(filled - head.len() - 1));
    head.push('\n');
    let length = u16::try_from(head.len()).map_err(|_| wrong())?;
    let mut file = Vec::with_capacity(before + head.len() + size_of_val(values));
    file.extend(b"\x93NUMPY\x01\x00");
    file.extend(length.to_le_bytes());
    file.extend(head.as_bytes());
    for value in values {
        file.extend(value.to_le_bytes());
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Read by the rules of `numpy.lib.format`, not by those of the writer.
    #[test]
    fn the_head_is_that_of_the_format() {
        for shape in [vec![], vec![4], vec![2, 3], vec![7, 1, 2, 3]] {
            let count = shape.iter().product::<usize>();
            let values: Vec<f32> = (0..count).map(|index| index as f32 - 1.5).collect();
            let file = npy(&shape, &values).unwrap();
            assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
            let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
            assert_eq!((10 + length) % 64, 0, "the format asks for an aligned start of the values");
            let head = std::str::from_utf8(&file[10..10 + length]).unwrap();
            assert!(head.is_ascii() && head.ends_with('\n') && head.starts_with('{'));
            let dictionary = head.trim_end();
            assert!(dictionary.contains("'descr': '<f4'") && dictionary.contains("'fortran_order': False"));
            let tuple = dictionary.split(['(', ')']).nth(1).unwrap();
            let found: Vec<usize> = tuple
                .split(',')
                .map(str::trim)
                .filter(|text| !text.is_empty())
                .map(|text| text.parse().unwrap())
                .collect();
            assert_eq!(found, shape);
            let body: Vec<f32> =
                file[10 + length..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
            assert_eq!(body, values);
        }
    }

    #[test]
    fn a_shape_that_does_not_fit_is_refused() {
        assert!(matches!(npy(&[2, 2], &[0.0; 3]), Err(ExportError::Shape { values: 3, .. })));
        assert!(npy(&[usize::MAX, 3], &[0.0; 3]).is_err());
        assert!(npy(&[1; 40_000], &[0.0]).is_err(), "the head would be longer than version 1.0 can say");
    }
}
