//! The shaders of all stages: their files, the numbers that they share with Rust, and every variant in which they run.

use include_dir::include_dir;

use crate::gpu::Variant;
use crate::gpu::shader::{Shader, Sources};
use crate::{methods, passes};

/// Something that each of these modules has by the same name.
macro_rules! each {
    (&$what:ident of $($room:ident::{$($stage:ident),* $(,)?}),*) => { [$($(&$room::$stage::$what),*),*] };
    ($what:ident of $($room:ident::{$($stage:ident),* $(,)?}),*) => { [$($($room::$stage::$what),*),*] };
}

/// The WGSL files under shaders/, and the constants that stand in Rust alone.
pub static SHADERS: Sources = Sources {
    files: include_dir!("$CARGO_MANIFEST_DIR/shaders"),
    constants: &each!(&CONSTANTS of passes::{bin, compose, project, radix, scan, tiles}, methods::{
        abuffer, image_space, opaque, soft, sorted, spbr,
    }),
    floats: &[&methods::image_space::FLOATS],
};

/// Overrides whose values a frame or a device decides, be they whatever they may: a list of variants has some of them.
pub const NUMBERS: [&str; 5] = ["PART_LENGTH", "STRIPES", "SHELLS", "SHELL_BITS", "PIXELS_PER_SHELL"];

/// Returns a variant's key without the values of [`NUMBERS`].
pub fn key_without_numbers(variant: &Variant) -> String {
    let mut variant = variant.clone();
    variant.overrides.iter_mut().filter(|(name, _)| NUMBERS.contains(name)).for_each(|(_, value)| *value = 0.0);
    variant.key()
}

/// Returns every pass with all its variants, as each stage lists them.
pub fn shaders() -> Vec<Shader> {
    let stages = each!(shaders of passes::{bin, project, radix, scan, tiles}, methods::{
        abuffer, approximate, edl, ellipsoids, encode, fading, image_space, linked_list, one_layer, opaque, peel,
        peel_layers, points, shadows, soft, sorted, spbr, splats, stochastic,
    });
    stages.iter().flat_map(|stage| stage()).collect()
}
