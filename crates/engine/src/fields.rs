//! Structs with the first value of each field beside its type.

/// Declares a struct, and its first value: `Default`, or `new(device)` where some fields are made by a device.
///
/// ```text
/// fields! {
///     /// Buffers, kept from frame to frame.
///     pub struct Splatter {
///         limits: Scratch<f32> = Scratch::new("limits of depth", Memory::Device),
///     }
/// }
/// ```
macro_rules! fields {
    ($(#[$doc:meta])* $vis:vis struct $name:ident {
        $($(#[$field_doc:meta])* $field_vis:vis $field:ident : $type:ty = $value:expr),* $(,)?
    }) => {
        $crate::fields!(@struct $(#[$doc])* $vis $name { $($(#[$field_doc])* $field_vis $field: $type),* });
        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $value),* }
            }
        }
    };
    ($(#[$doc:meta])* $vis:vis struct $name:ident by $device:ident {
        $($(#[$field_doc:meta])* $field_vis:vis $field:ident : $type:ty = $value:expr),* $(,)?
    }) => {
        $crate::fields!(@struct $(#[$doc])* $vis $name { $($(#[$field_doc])* $field_vis $field: $type),* });
        impl $name {
            /// Allocates the small buffers alone.
            $vis fn new($device: &$crate::gpu::Device) -> Result<Self, $crate::gpu::Error> {
                Ok(Self { $($field: $value),* })
            }
        }
    };
    (@struct $(#[$doc:meta])* $vis:vis $name:ident { $($fields:tt)* }) => {
        $(#[$doc])*
        $vis struct $name { $($fields)* }
    };
}
pub(crate) use fields;
