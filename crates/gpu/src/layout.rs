//! Types shared by Rust and WGSL, with enough of their shape to compare the two.

use bytemuck::Pod;

/// How a type lies in memory, as far as a shader sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// A scalar, vector or matrix by its WGSL name, as `vec2<f32>`; an atomic counts as its scalar.
    Plain(&'static str),
    /// A struct: size in bytes and each member's name and byte offset.
    Struct {
        /// Size of the Rust type, equal to the WGSL stride.
        size: usize,
        /// Name and offset of each member.
        members: Vec<(&'static str, usize)>,
    },
}

/// A type that can lie in a buffer.
pub trait GpuType: Pod + Send + Sync {
    /// Its shape.
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
    f32 => "f32",
    [u32; 2] => "vec2<u32>",
    [u32; 4] => "vec4<u32>",
    [f32; 4] => "vec4<f32>",
}

/// Declares a struct that lies in a buffer, without padding, with its members' offsets.
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$doc:meta])* $vis:vis struct $name:ident { $($(#[$member_doc:meta])* $member:ident : $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
        #[allow(missing_docs, reason = "the shader says what the members are")]
        $vis struct $name {
            $($(#[$member_doc])* pub $member: $type),*
        }
        impl $crate::GpuType for $name {
            fn shape() -> $crate::Shape {
                $crate::Shape::Struct {
                    size: std::mem::size_of::<$name>(),
                    members: vec![$((stringify!($member), std::mem::offset_of!($name, $member))),*],
                }
            }
        }
    };
}
