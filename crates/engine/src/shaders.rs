//! The shaders of all stages: their files, the numbers that they share with Rust, and every variant in which they run.

use include_dir::include_dir;

use crate::gpu::Variant;
use crate::gpu::shader::{Shader, Sources};
use crate::methods::QUARTERS;
use crate::methods::{FAMILIES, abuffer, image_space, opaque, soft};
use crate::passes::{bin, compose, project, radix, scan, tiles};

/// The WGSL files under shaders/, and the constants that stand in Rust alone.
pub static SHADERS: Sources = Sources {
    files: include_dir!("$CARGO_MANIFEST_DIR/shaders"),
    constants: &[
        &abuffer::CONSTANTS,
        &bin::CONSTANTS,
        &compose::CONSTANTS,
        &image_space::CONSTANTS,
        &opaque::CONSTANTS,
        &radix::CONSTANTS,
        &scan::CONSTANTS,
        &project::CONSTANTS,
        &soft::CONSTANTS,
        &tiles::CONSTANTS,
    ],
    floats: &[&image_space::FLOATS],
};

/// Overrides whose values a frame or a device decides, be they whatever they may: a list of variants has some of them.
pub const NUMBERS: [&str; 2] = ["PART_LENGTH", "STRIPES"];

/// Returns a variant's key without the values of [`NUMBERS`], and without what a recording gives to every shader that
/// has it.
pub fn key_without_numbers(variant: &Variant) -> String {
    let mut variant = variant.clone();
    variant.overrides.retain(|(name, _)| *name != QUARTERS);
    variant.overrides.iter_mut().filter(|(name, _)| NUMBERS.contains(name)).for_each(|(_, value)| *value = 0.0);
    variant.key()
}

/// Returns every pass with all its variants, as each stage lists them.
pub fn shaders() -> Vec<Shader> {
    FAMILIES.iter().flat_map(|family| (family.shaders)()).collect()
}
