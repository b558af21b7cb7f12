//! The tensor file: named arrays, one after the other.
//!
//! Little endian: the text `tensor_file` and a 0 byte; version 1, 0 as two bytes; the number of fields as u32. For each field: length
//! of its name as u16, the name in UTF-8, number of dimensions as u16, type of elements as u8 (1 to 11), place of the values
//! from the start of the file as u64, and the shape as u64 each. Then the values in C order, each array from a multiple of 8 bytes.
//!
//! # Source
//! The readers of Mitsuba 3 (`src/core/tensor.cpp`) and of Dupuy and Jakob's `powitacq`.

use super::BsdfError;
use std::collections::HashSet;

const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Values begin at multiples of so many bytes.
const ALIGNMENT: usize = 8;

/// What an array is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Element {
    U8 = 1,
    I8 = 2,
    U16 = 3,
    I16 = 4,
    U32 = 5,
    I32 = 6,
    U64 = 7,
    I64 = 8,
    F16 = 9,
    F32 = 10,
    F64 = 11,
}

impl Element {
    const ALL: [Self; 11] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F16,
        Self::F32,
        Self::F64,
    ];

    /// Bytes of one element.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    fn of_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|element| *element as u8 == code)
    }
}

/// The values of an array, the last dimension fastest.
#[derive(Debug, Clone, PartialEq)]
pub enum TensorData {
    /// Bytes, such as text.
    U8(Vec<u8>),
    /// Single precision.
    F32(Vec<f32>),
    /// Anything else, as it stands in the file.
    Other {
        /// Type of the elements.
        element: Element,
        /// Their bytes, little endian.
        bytes: Vec<u8>,
    },
}

impl TensorData {
    /// Type of the elements.
    #[must_use]
    pub fn element(&self) -> Element {
        match self {
            Self::U8(_) => Element::U8,
            Self::F32(_) => Element::F32,
            Self::Other { element, .. } => *element,
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::F32(values) => size_of_val(values.as_slice()),
            Self::Other { bytes, .. } => bytes.len(),
        }
    }
}

/// One named array.
#[derive(Debug, Clone, PartialEq)]
pub struct Tensor {
    /// Its name, at most 65535 bytes.
    pub name: String,
    /// Length of each dimension, the slowest first.
    pub shape: Vec<usize>,
    /// Its values.
    pub data: TensorData,
}

/// Named arrays in the order of the file.
///
/// ```
/// use morpho_fit::bsdf::{Tensor, TensorData, TensorFile};
/// let angles = Tensor { name: "theta_i".into(), shape: vec![2], data: TensorData::F32(vec![0.0, 1.5]) };
/// let file = TensorFile { tensors: vec![angles] };
/// let bytes = file.to_bytes()?;
/// assert_eq!(TensorFile::read(&bytes)?, file);
/// assert!(TensorFile::read(&bytes[..40]).is_err());
/// # Ok::<(), morpho_fit::bsdf::BsdfError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TensorFile {
    /// The arrays; their names differ.
    pub tensors: Vec<Tensor>,
}

impl TensorFile {
    /// The array of this name.
    #[must_use]
    pub fn tensor(&self, name: &str) -> Option<&Tensor> {
        self.tensors.iter().find(|tensor| tensor.name == name)
    }

    /// The file as bytes; the same arrays make the same bytes.
    ///
    /// # Errors
    /// [`BsdfError::Tensor`] for a name that is empty, too long or there twice, a shape that its values do not fill, or more of either than
    /// the format counts.
    pub fn to_bytes(&self) -> Result<Vec<u8>, BsdfError> {
        let mut head = MAGIC.len() + VERSION.len() + 4;
        for (index, tensor) in self.tensors.iter().enumerate() {
            let Tensor { name, shape, data } = tensor;
            let wrong = |problem| BsdfError::Tensor { name: name.clone(), problem };
            if name.is_empty() || u16::try_from(name.len()).is_err() {
                return Err(wrong("a name has 1 to 65535 bytes"));
            }
            if self.tensors.iter().take(index).any(|other| other.name == *name) {
                return Err(wrong("the name is there twice"));
            }
            if u16::try_from(shape.len()).is_err() {
                return Err(wrong("the shape has more than 65535 dimensions"));
            }
            if bytes_of(data.element(), shape) != Some(data.bytes()) {
                return Err(wrong("there are not as many values as the shape says"));
            }
            head += 2 + name.len() + 2 + 1 + 8 + 8 * shape.len();
        }
        let count = u32::try_from(self.tensors.len())
            .map_err(|_| BsdfError::Tensor { name: String::new(), problem: "there are too many fields" })?;
        let all = self.tensors.iter().map(|tensor| tensor.data.bytes() + ALIGNMENT).sum::<usize>();
        let mut file = Vec::with_capacity(head + all);
        file.extend(MAGIC);
        file.extend(VERSION);
        file.extend(count.to_le_bytes());
        let mut offset = head.next_multiple_of(ALIGNMENT);
        for Tensor { name, shape, data } in &self.tensors {
            // Both lengths were checked.
            file.extend(u16::try_from(name.len()).unwrap_or(u16::MAX).to_le_bytes());
            file.extend(name.as_bytes());
            file.extend(u16::try_from(shape.len()).unwrap_or(u16::MAX).to_le_bytes());
            file.push(data.element() as u8);
            file.extend((offset as u64).to_le_bytes());
            file.extend(shape.iter().flat_map(|&length| (length as u64).to_le_bytes()));
            offset = (offset + data.bytes()).next_multiple_of(ALIGNMENT);
        }
        for Tensor { data, .. } in &self.tensors {
            file.resize(file.len().next_multiple_of(ALIGNMENT), 0);
            match data {
                TensorData::U8(values) | TensorData::Other { bytes: values, .. } => file.extend(values),
                TensorData::F32(values) => file.extend(values.iter().flat_map(|value| value.to_le_bytes())),
            }
        }
        Ok(file)
    }

    /// The arrays of a file; nothing is made room for before the file is known to hold it.
    ///
    /// # Errors
    /// [`BsdfError`] with the place of the first fault: a file that is cut short, another format or version, a name, type or shape that is
    /// none, values outside the file or over one another.
    pub fn read(bytes: &[u8]) -> Result<Self, BsdfError> {
        let mut head = Head { bytes, at: 0 };
        let start = MAGIC.get(..bytes.len().min(MAGIC.len())).unwrap_or_default();
        if !bytes.starts_with(start) {
            return Err(BsdfError::NotATensorFile);
        }
        head.take(MAGIC.len(), "the start of the format")?;
        let [major, minor] = head.array("the version")?;
        if [major, minor] != VERSION {
            return Err(BsdfError::Version { major, minor });
        }
        let count = u32::from_le_bytes(head.array("the number of fields")?);
        let mut fields = Vec::new();
        for _ in 0..count {
            fields.push(head.field()?);
        }
        let (mut file, mut names) = (Self::default(), HashSet::new());
        // Fields over one another could ask for more memory than the file has bytes.
        let mut left = bytes.len().saturating_sub(head.at);
        for Field { name, shape, element, offset, length } in fields {
            let inside = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64);
            let place = inside.and_then(|end| Some(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
            let Some(values) = place.clone().and_then(|place| bytes.get(place)) else {
                let what = format!("the values of field `{name}`");
                return Err(BsdfError::CutShort { offset, what, needed: length, length: bytes.len() as u64 });
            };
            let free = place.is_some_and(|place| place.start >= head.at || place.is_empty());
            let Some(rest) = left.checked_sub(values.len()).filter(|_| free) else {
                return Err(BsdfError::Overlap { offset, name });
            };
            left = rest;
            if !names.insert(name.clone()) {
                return Err(BsdfError::Tensor { name, problem: "the name is there twice" });
            }
            let data = match element {
                Element::U8 => TensorData::U8(values.to_vec()),
                Element::F32 => {
                    TensorData::F32(values.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).collect())
                }
                element => TensorData::Other { element, bytes: values.to_vec() },
            };
            file.tensors.push(Tensor { name, shape, data });
        }
        Ok(file)
    }
}

/// Bytes of an array; none if they cannot be counted.
fn bytes_of(element: Element, shape: &[usize]) -> Option<usize> {
    shape.iter().try_fold(element.bytes(), |bytes, &length| bytes.checked_mul(length))
}

/// What the head says about one array.
struct Field {
    name: String,
    shape: Vec<usize>,
    element: Element,
    offset: u64,
    length: u64,
}

/// Reads on from a place in the file.
struct Head<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Head<'a> {
    fn take(&mut self, needed: usize, what: &str) -> Result<&'a [u8], BsdfError> {
        let found = self.at.checked_add(needed).and_then(|end| self.bytes.get(self.at..end));
        let found = found.ok_or_else(|| BsdfError::CutShort {
            offset: self.at as u64,
            what: what.to_owned(),
            needed: needed as u64,
            length: self.bytes.len() as u64,
        })?;
        self.at += needed;
        Ok(found)
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], BsdfError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N, what)?);
        Ok(array)
    }

    fn field(&mut self) -> Result<Field, BsdfError> {
        let offset = self.at as u64 + 2;
        let length = u16::from_le_bytes(self.array("the length of a field's name")?);
        let name = self.take(usize::from(length), "the name of a field")?;
        let name = match std::str::from_utf8(name) {
            Ok("") => return Err(BsdfError::Name { offset, problem: "empty" }),
            Ok(name) => name.to_owned(),
            Err(_) => return Err(BsdfError::Name { offset, problem: "not UTF-8" }),
        };
        let dimensions = usize::from(u16::from_le_bytes(self.array("the number of dimensions")?));
        let place = self.at as u64;
        let [code] = self.array("the type of elements")?;
        let Some(element) = Element::of_code(code) else {
            return Err(BsdfError::Element { offset: place, name, code });
        };
        let offset = u64::from_le_bytes(self.array("the place of values")?);
        let place = self.at as u64;
        let shape = self.take(8 * dimensions, "a shape")?.as_chunks::<8>().0.iter();
        let shape: Option<Vec<usize>> = shape.map(|length| usize::try_from(u64::from_le_bytes(*length)).ok()).collect();
        let counted = shape.and_then(|shape| Some((bytes_of(element, &shape)? as u64, shape)));
        let Some((length, shape)) = counted else { return Err(BsdfError::ShapeOverflow { offset: place, name }) };
        Ok(Field { name, shape, element, offset, length })
    }
}
