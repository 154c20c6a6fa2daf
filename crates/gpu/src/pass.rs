//! Bindings of a pass, declared once in Rust and compared with its shader.

use ash::vk;
use bytemuck::Pod;

use super::shader::Sources;
use super::{GpuType, RawSlice, Shape};

/// Access of a shader to a binding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// `var<uniform>`
    Uniform,
    /// `var<storage, read>`
    Read,
    /// `var<storage, read_write>`
    ReadWrite,
    /// `var` of a texture that is only loaded from.
    Texture,
}

/// A bound resource.
#[derive(Debug, Clone, Copy)]
pub enum Resource {
    /// A range of a buffer.
    Buffer(RawSlice),
    /// An attachment, to be read.
    Texture(vk::ImageView),
}

impl From<RawSlice> for Resource {
    fn from(slice: RawSlice) -> Self {
        Self::Buffer(slice)
    }
}

/// One binding of group 0; its number is its place in the list.
#[derive(Debug, Clone)]
pub struct Binding {
    /// The variable's name in WGSL.
    pub name: &'static str,
    /// Access of the shader.
    pub access: Access,
    /// Shape of the element (storage: a runtime-sized array of it; uniform, texture: itself).
    pub shape: Shape,
}

/// Push constants of a pass: a struct made by [`gpu_struct!`](crate::gpu_struct), or `()` where it has none.
pub trait PushConstants: Pod {
    /// Returns the shape of the push constants; `None` if there are none.
    fn push_shape() -> Option<Shape>;
}

impl PushConstants for () {
    fn push_shape() -> Option<Shape> {
        None
    }
}

impl<T: GpuType> PushConstants for T {
    fn push_shape() -> Option<Shape> {
        Some(T::shape())
    }
}

/// Bytes of push constants that every device has.
pub const PUSH_BYTES: usize = 128;

/// Names, bindings and push constants of a pass. Code that takes them as data is compiled once, and not for each of
/// some hundred passes.
#[derive(Debug, Clone, Copy)]
pub struct Declaration {
    /// Method and stage, as in `abuffer/store`: the timing label too.
    pub name: &'static str,
    /// Stem of the shader file under shaders/.
    pub shader: &'static str,
    /// The shared piece that stands in for `#piece` in that file.
    pub piece: Option<&'static str>,
    /// The shader files of the crate that declares the pass.
    pub sources: &'static Sources,
    /// The bindings.
    pub bindings: fn() -> Vec<Binding>,
    /// The shape of the push constants.
    pub push_shape: fn() -> Option<Shape>,
}

impl Declaration {
    /// Returns the declaration of a pass whose push constants are a `P`, which every device must have room for.
    pub const fn new<P: PushConstants>(
        [name, shader]: [&'static str; 2],
        piece: Option<&'static str>,
        sources: &'static Sources,
        bindings: fn() -> Vec<Binding>,
    ) -> Self {
        assert!(size_of::<P>() <= PUSH_BYTES, "more push constants than every device has");
        Self { name, shader, piece, sources, bindings, push_shape: P::push_shape }
    }
}

/// A pass: a struct of named buffers and textures. Made by [`pass!`](crate::pass).
pub trait Pass {
    /// Names, bindings and push constants.
    const DECLARATION: Declaration;
    /// The push constants that every run and draw takes.
    type Push: PushConstants;
    /// The buffers and textures in the order of the bindings.
    fn resources(&self) -> Vec<Resource>;
}

/// Bindings that several passes share, in their order. Made by [`group!`](crate::group).
pub trait Group {
    /// The buffers.
    type At<'a>;
    /// The declared bindings.
    fn bindings() -> Vec<Binding>;
    /// The buffers in the order of the bindings.
    fn resources(buffers: &Self::At<'_>) -> Vec<Resource>;
}

/// Parts that a buffer of unlimited length is bound in, as bindings `name_0` to `name_3`.
pub const PARTS: usize = 4;

/// Declares passes: after `@from` the crate's [`Sources`], which a crate's own macro of this name puts there; then for
/// each pass the name of the timing label, the shader file if it is called otherwise, the shared piece that it takes,
/// push constants, bindings. Passes with the same bindings stand before them one after another, with commas between. A
/// field is `Uniform<T>`, `Read<T>`, `ReadWrite<T>`, `Parts<T>`: [`PARTS`] read bindings `name_0`, `name_1`, …,
/// `Texture<T>`: an attachment, read as the type of WGSL that `T` stands for, or `Shared<G>`: all bindings of a
/// [`Group`].
///
/// ```text
/// pass! {
///     /// Puts each splat's fragments into their slots.
///     pub Store(StorePush) = "abuffer/store" {
///         splats: Read<Splat>,
///         fragments: ReadWrite<[u32; 2]>,
///     }
/// }
/// ```
#[macro_export]
macro_rules! pass {
    (@from $sources:path; $(
        $(
            $(#[$doc:meta])* $vis:vis $name:ident $(($push:ty))? =
                $label:literal $(in $shader:literal)? $(with $piece:literal)?
        ),+
        { $($fields:tt)* }
    )*) => {
        $($crate::pass! {
            @each $sources; { $($fields)* }
            $([$(#[$doc])* $vis $name [$crate::pass!(@push $($push)?)] [$label] [$($shader,)? $label] [$($piece)?]])+
        })*
    };
    (@each $sources:path; $fields:tt $([$($head:tt)*])+) => { $($crate::pass! { @one $sources; $($head)* $fields })+ };
    (@one $sources:path; $(#[$doc:meta])* $vis:vis $name:ident
        [$push:ty] [$label:literal] [$($shader:literal),+] [$($piece:literal)?]
    {
        $($(#[$field_doc:meta])* $field:ident : $access:ident<$type:ty>),* $(,)?
    }) => {
        $(#[$doc])*
        #[allow(missing_docs, reason = "comments beside them, or the shader, explain the members")]
        $vis struct $name<'a> {
            $($(#[$field_doc])* pub $field: $crate::pass!(@type $access 'a, $type)),*
        }
        impl $crate::Pass for $name<'_> {
            const DECLARATION: $crate::Declaration = {
                fn bindings() -> Vec<$crate::Binding> {
                    [$($crate::pass!(@bind $field, $access, $type)),*].concat()
                }
                let piece = $crate::pass!(@option $($piece)?);
                $crate::Declaration::new::<$push>([$label, [$($shader),+][0]], piece, &$sources, bindings)
            };
            type Push = $push;
            fn resources(&self) -> Vec<$crate::Resource> {
                [$($crate::pass!(@resource self.$field, $access, $type)),*].concat()
            }
        }
    };
    (@type Shared $life:lifetime, $type:ty) => { <$type as $crate::Group>::At<$life> };
    (@bind $field:ident, Shared, $type:ty) => { <$type as $crate::Group>::bindings() };
    (@resource $buffers:expr, Shared, $type:ty) => { <$type as $crate::Group>::resources(&$buffers) };
    (@option) => { None };
    (@option $value:literal) => { Some($value) };
    (@push) => { () };
    (@push $push:ty) => { $push };
    (@type Texture $life:lifetime, $type:ty) => { &$life $crate::Attachment };
    (@bind $field:ident, Texture, $type:ty) => {
        vec![$crate::Binding {
            name: stringify!($field),
            access: $crate::Access::Texture,
            shape: $crate::Shape::Plain(<$type as $crate::Texture>::WGSL),
        }]
    };
    (@resource $texture:expr, Texture, $type:ty) => { vec![$texture.texture()] };
    (@type Parts $life:lifetime, $type:ty) => { [$crate::Slice<$life, $type>; $crate::PARTS] };
    (@type $access:ident $life:lifetime, $type:ty) => { $crate::Slice<$life, $type> };
    (@bind $field:ident, Parts, $type:ty) => {
        [
            concat!(stringify!($field), "_0"),
            concat!(stringify!($field), "_1"),
            concat!(stringify!($field), "_2"),
            concat!(stringify!($field), "_3"),
        ]
        .map(|name| $crate::Binding {
            name,
            access: $crate::Access::Read,
            shape: <$type as $crate::GpuType>::shape(),
        })
        .to_vec()
    };
    (@bind $field:ident, $access:ident, $type:ty) => {
        vec![$crate::Binding {
            name: stringify!($field),
            access: $crate::Access::$access,
            shape: <$type as $crate::GpuType>::shape(),
        }]
    };
    (@resource $slices:expr, Parts, $type:ty) => { $slices.map(|s| s.raw().into()).to_vec() };
    (@resource $slice:expr, $access:ident, $type:ty) => { vec![$slice.raw().into()] };
}

/// Declares bindings that several passes share: for each group a struct of buffers, and the type that stands for it in
/// `Shared<…>`.
#[macro_export]
macro_rules! group {
    ($($(#[$doc:meta])* $vis:vis $name:ident as $group:ident {
        $($(#[$field_doc:meta])* $field:ident : $access:ident<$type:ty>),* $(,)?
    })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[allow(missing_docs, reason = "comments beside them, or the shader, explain the members")]
        $vis struct $name<'a> {
            $($(#[$field_doc])* pub $field: $crate::pass!(@type $access 'a, $type)),*
        }
        #[doc = concat!("Stands for [`", stringify!($name), "`] in the declaration of a pass.")]
        $vis struct $group;
        impl $crate::Group for $group {
            type At<'a> = $name<'a>;
            fn bindings() -> Vec<$crate::Binding> {
                [$($crate::pass!(@bind $field, $access, $type)),*].concat()
            }
            fn resources(buffers: &$name<'_>) -> Vec<$crate::Resource> {
                [$($crate::pass!(@resource buffers.$field, $access, $type)),*].concat()
            }
        }
    )*};
}
