//! Numbers of a buffer, as an accessor describes them.

use super::super::{float, short, word};
use super::buffers::Buffers;
use super::document::Document;

/// Numbers of one attribute, some for each splat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: Kind,
    normalized: bool,
    pub count: usize,
}

/// Types of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Kind {
    fn of(component_type: u32) -> Option<Self> {
        Some(match component_type {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number that means 1 where numbers are normalized.
    fn one(self) -> f64 {
        match self {
            Self::I8 => i8::MAX.into(),
            Self::U8 => u8::MAX.into(),
            Self::I16 => i16::MAX.into(),
            Self::U16 => u16::MAX.into(),
            Self::U32 => u32::MAX.into(),
            Self::F32 => 1.0,
        }
    }
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
        let kind = Kind::of(accessor.component_type).ok_or_else(|| {
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
        let element = kind.size() as u64 * width(shape) as u64;
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
        Ok(Self { bytes, stride, kind, normalized: accessor.normalized, count })
    }

    /// Returns some numbers of an element.
    pub fn get<const N: usize>(&self, element: usize) -> [f64; N] {
        std::array::from_fn(|part| self.number(element * self.stride + part * self.kind.size()))
    }

    fn number(&self, at: usize) -> f64 {
        let byte = || self.bytes.get(at).copied().unwrap_or(0);
        let number = match self.kind {
            Kind::I8 => byte().cast_signed().into(),
            Kind::U8 => byte().into(),
            Kind::I16 => short(self.bytes, at).cast_signed().into(),
            Kind::U16 => short(self.bytes, at).into(),
            Kind::U32 => word(self.bytes, at).into(),
            Kind::F32 => return float(self.bytes, at),
        };
        if self.normalized { f64::max(number / self.kind.one(), -1.0) } else { number }
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
