//! Types shared by Rust and WGSL, with enough of their shape to compare the two.

use std::fmt;

use bytemuck::Pod;

/// Layout of a type in memory, as far as a shader sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// A scalar, vector, matrix or texture by its WGSL name, as `vec2<f32>`; an atomic counts as its scalar.
    Plain(&'static str),
    /// An array of fixed length.
    Array {
        /// The shape of its elements.
        element: Box<Shape>,
        /// Number of elements.
        count: usize,
        /// Bytes from one to the next.
        stride: usize,
    },
    /// A struct.
    Struct {
        /// Name of the Rust type, and of the WGSL one where it is a member of push constants.
        name: &'static str,
        /// Size of the Rust type in bytes, equal to the WGSL stride.
        size: usize,
        /// The members in order.
        members: Vec<Member>,
    },
}

/// A member of a struct.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Name in Rust and WGSL.
    pub name: &'static str,
    /// Offset in bytes.
    pub offset: usize,
    /// Shape of the member.
    pub shape: Shape,
}

impl Shape {
    /// Returns the type as WGSL writes it.
    pub(crate) fn wgsl(&self) -> String {
        match self {
            Self::Plain(name) | Self::Struct { name, .. } => (*name).to_owned(),
            Self::Array { element, count, .. } => format!("array<{}, {count}>", element.wgsl()),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plain(name) => f.write_str(name),
            Self::Array { element, count, stride } => f.write_str(&array_text(&element.to_string(), *count, *stride)),
            Self::Struct { size, members, .. } => {
                let members = members.iter().map(|m| (m.name, m.offset, m.shape.to_string()));
                f.write_str(&struct_text(members, *size))
            }
        }
    }
}

/// Returns an array in words: element, length, and bytes from one to the next.
pub(crate) fn array_text(element: &str, count: usize, stride: usize) -> String {
    format!("array<{element}, {count}> every {stride} bytes")
}

/// Returns a struct in words, from names, offsets and types of its members.
pub(crate) fn struct_text<'a>(members: impl Iterator<Item = (&'a str, usize, String)>, size: usize) -> String {
    let members: Vec<String> = members.map(|(name, offset, shape)| format!("{name}: {shape} at {offset}")).collect();
    format!("{{ {} }} of {size} bytes", members.join(", "))
}

/// A type that can lie in a buffer.
pub trait GpuType: Pod + Send + Sync {
    /// Returns the shape of the type.
    fn shape() -> Shape;
}

macro_rules! plain {
    ($($rust:ty => $wgsl:literal),* $(,)?) => {
        $(impl GpuType for $rust {
            fn shape() -> Shape {
                Shape::Plain($wgsl)
            }
        })*
    };
}

plain! {
    u32 => "u32",
    u64 => "u64",
    i32 => "i32",
    f32 => "f32",
    [u32; 2] => "vec2<u32>",
    [u32; 4] => "vec4<u32>",
    [f32; 2] => "vec2<f32>",
    [f32; 4] => "vec4<f32>",
    [[f32; 4]; 4] => "mat4x4<f32>",
}

/// WGSL aligns a vector of three as one of four: three numbers are an array.
impl GpuType for [u32; 3] {
    fn shape() -> Shape {
        Shape::Array { element: Box::new(u32::shape()), count: 3, stride: size_of::<u32>() }
    }
}

/// Declares structs that lie in a buffer, without padding. Their members are types that lie there themselves.
#[macro_export]
macro_rules! gpu_struct {
    ($($(#[$doc:meta])* $vis:vis struct $name:ident { $($(#[$member_doc:meta])* $member:ident : $type:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
        #[allow(missing_docs, reason = "comments beside them, or the shader, explain the members")]
        $vis struct $name {
            $($(#[$member_doc])* pub $member: $type),*
        }
        impl $crate::GpuType for $name {
            fn shape() -> $crate::Shape {
                $crate::Shape::Struct {
                    name: stringify!($name),
                    size: std::mem::size_of::<$name>(),
                    members: vec![$($crate::layout::Member {
                        name: stringify!($member),
                        offset: std::mem::offset_of!($name, $member),
                        shape: <$type as $crate::GpuType>::shape(),
                    }),*],
                }
            }
        }
    )*};
}
