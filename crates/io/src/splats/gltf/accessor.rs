//! Numbers of a buffer, as an accessor describes them.

use super::buffers::Buffers;
use super::document::Document;
use crate::number::NumberType;

/// Numbers of one attribute, some for each splat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: NumberType,
    /// Bytes of a number.
    size: usize,
    normalized: bool,
    pub count: usize,
}

/// The type of a number by glTF's code.
fn kind(component_type: u32) -> Option<NumberType> {
    Some(match component_type {
        5120 => NumberType::Int8,
        5121 => NumberType::Uint8,
        5122 => NumberType::Int16,
        5123 => NumberType::Uint16,
        5125 => NumberType::Uint32,
        5126 => NumberType::Float,
        _ => return None,
    })
}

impl<'a> Numbers<'a> {
    /// Returns the numbers of an accessor whose elements have this shape, or what is wrong with it.
    pub fn find(document: &Document, buffers: &'a Buffers, number: usize, shape: &str) -> Result<Self, String> {
        let of = |what: &str, number: usize| format!("there is no {what} {number}");
        let accessor = document.accessors.get(number).ok_or_else(|| of("accessor", number))?;
        let named = format!("accessor {number}");
        if accessor.shape != shape {
            return Err(format!("{named} is of type {}, expected {shape}", accessor.shape));
        }
        if accessor.sparse.is_some() {
            return Err(format!("{named} is sparse, which is not supported"));
        }
        let of_code = kind(accessor.component_type).and_then(|kind| Some((kind, kind.bytes()?)));
        let (kind, size) = of_code.ok_or_else(|| {
            format!("{named} has componentType {}, which glTF does not define", accessor.component_type)
        })?;
        let view = accessor.buffer_view.ok_or_else(|| format!("{named} has no bufferView"))?;
        let view = document.buffer_views.get(view).ok_or_else(|| of("bufferView", view))?;
        let buffer = buffers.get(view.buffer).ok_or_else(|| of("buffer", view.buffer))?;
        let cut = |bytes: &'a [u8], from: u64, len: Option<u64>| {
            let rest = bytes.get(usize::try_from(from).ok()?..)?;
            len.map_or(Some(rest), |len| rest.get(..usize::try_from(len).ok()?))
        };
        let within = cut(buffer, view.byte_offset, Some(view.byte_length));
        let within = within.ok_or_else(|| format!("the bufferView of {named} reaches beyond its buffer"))?;
        let element = size as u64 * width(shape) as u64;
        let stride = view.byte_stride.unwrap_or(element).max(element);
        let last = accessor.count.saturating_sub(1).checked_mul(stride).and_then(|last| last.checked_add(element));
        let len = if accessor.count == 0 { Some(0) } else { last };
        let bytes = len.and_then(|len| cut(within, accessor.byte_offset, None)?.get(..usize::try_from(len).ok()?));
        let bytes = bytes.ok_or_else(|| {
            format!(
                "{named} has {} elements of {stride} bytes from byte {} on, but its bufferView has {} bytes",
                accessor.count, accessor.byte_offset, view.byte_length
            )
        })?;
        let (stride, count) = (stride as usize, accessor.count as usize);
        Ok(Self { bytes, stride, kind, size, normalized: accessor.normalized, count })
    }

    /// Returns some numbers of an element.
    pub fn get<const N: usize>(&self, element: usize) -> [f64; N] {
        std::array::from_fn(|part| self.number(element * self.stride + part * self.size))
    }

    fn number(&self, at: usize) -> f64 {
        let number = self.kind.read(self.bytes.get(at..).unwrap_or_default());
        // The number that means 1 where numbers are normalized.
        let one: f64 = match self.kind {
            _ if !self.normalized => return number,
            NumberType::Int8 => i8::MAX.into(),
            NumberType::Uint8 => u8::MAX.into(),
            NumberType::Int16 => i16::MAX.into(),
            NumberType::Uint16 => u16::MAX.into(),
            NumberType::Uint32 => u32::MAX.into(),
            _ => return number,
        };
        f64::max(number / one, -1.0)
    }
}

/// Numbers of an element.
fn width(shape: &str) -> usize {
    match shape {
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    }
}
