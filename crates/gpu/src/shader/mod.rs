//! WGSL to SPIR-V by naga, and a pass's declaration compared with its shader by reflection. Needs no device.
//!
//! # Files
//!
//! A crate that declares passes embeds its WGSL as [`Sources`]. `abuffer/store` is the stem of
//! shaders/abuffer/store.wgsl: one entry point called [`ENTRY`]. Pieces that several shaders use lie under
//! shaders/shared; they open with what they need from the shader that imports them.
//!
//! # Directives
//!
//! A line of a shader that begins with `#` is the composer's. Everything else is plain WGSL, whose declarations may
//! come in any order.
//!
//! | line | becomes |
//! |------|---------|
//! | `#import NAME` | shared/NAME.wgsl, once however often it is imported |
//! | `#push` | the struct `Push` with the members that the pass declares, and the variable `push` of push constants |
//! | `#main {` | the head of an entry point with `workgroup`, `groups` and `local`, for workgroups of [`WORKGROUP`] |
//! | `#main NAME {` | the same, and NAME = the number of the invocation among all (`#import dispatch`) |
//! | `#piece` | the shared piece that the pass names: `pass! { … = "label" in "stem" with "piece" { … } }` |
//! | `#walker` | the shared piece that the variant names ([`Variant::walker`]) |
//! | `#each NAME LINE` | LINE as often as the variant says of that name ([`Variant::each`]), with `{NAME}` = 0, 1, … |
//! | `#each NAME` | the lines up to `#end` as often, which may repeat lines themselves |
//! | `#repeat LINE` | LINE for each input of the variant's sorting network ([`Variant::network`]), `{i}` = 0, 1, … |
//! | `#comparators` | what sorts the variables x0, x1, … of that network by the shader's function `before` |
//!
//! # Numbers and variants
//!
//! A constant that Rust and WGSL share stands in Rust alone ([`Sources::constants`]): it is written before the source
//! of every shader that mentions it, as are [`WORKGROUP`] by the name of `WG_SIZE`, a variant's own constants
//! ([`Variant::constant`]), and `SUBGROUP` ([`Variant::subgroup`]). What else differs between the variants of a shader
//! are WGSL's `override` values ([`Variant::with`]). A text constant serves where WGSL takes no override, as for the
//! length of an array.
//!
//! [`Shader`] lists a pass with all its variants.

mod composer;
mod network;
mod prune;
mod reflect;
mod variant;

use std::collections::HashMap;

use naga::back::spv;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use self::composer::source;
use self::prune::prune;
use self::reflect::check_declaration;
use crate::{Declaration, Error, cache, guard, spirv};

pub use self::composer::Sources;
pub use self::variant::{SUBGROUPS, Shader, Variant};
pub use naga::ShaderStage;

/// Entry point of every shader file.
pub const ENTRY: &str = "main";
/// Invocations of every compute workgroup that is not a subgroup; also the constant `WG_SIZE` in WGSL.
pub const WORKGROUP: u32 = 64;

fn error(name: &str, message: impl Into<String>) -> Error {
    Error::Shader { name: name.to_owned(), message: message.into() }
}

/// SPIR-V of a pass's compute shader, checked against the pass's declaration; from the disk cache if it is there. With
/// `debug` it has names and source, which change nothing that it computes.
pub fn compile(pass: &Declaration, variant: &Variant, debug: bool) -> Result<Vec<u32>, Error> {
    compile_stage(pass, pass.shader, variant, (true, debug))
}

/// The vertex shader of every pass that draws: two triangles over each splat's rectangle.
pub(crate) const QUAD: &str = "raster/quad.vert";

/// SPIR-V of the vertex and fragment shaders of a pass that draws. The vertex shader uses only some of the bindings.
pub fn compile_draw(pass: &Declaration, variant: &Variant, debug: bool) -> Result<[Vec<u32>; 2], Error> {
    let vertex = compile_stage(pass, QUAD, &Variant::plain(), (false, debug))?;
    Ok([vertex, compile_stage(pass, pass.shader, variant, (true, debug))?])
}

fn compile_stage(
    pass: &Declaration,
    stem: &str,
    variant: &Variant,
    (all_bindings, debug): (bool, bool),
) -> Result<Vec<u32>, Error> {
    let (source, bindings, push) = (source(pass, stem, variant)?, (pass.bindings)(), (pass.push_shape)());
    // The declaration is part of the key: a cached shader was compared with the same one.
    let (version, key) = ((env!("CARGO_PKG_VERSION"), spirv::REVISION, debug), variant.key());
    let identity = format!("{version:?}\n{}\n{source}\n{key}\n{bindings:?}\n{push:?}", guard::bytes());
    let key = blake3::hash(identity.as_bytes()).to_hex().to_string();
    if let Some(words) =
        cache::load("spirv", &key).and_then(|bytes| bytemuck::try_cast_slice(&bytes).map(<[u32]>::to_vec).ok())
    {
        return Ok(words);
    }
    let module = parse(stem, &source)?;
    check_declaration(stem, &module, &bindings, push.as_ref(), all_bindings)?;
    let info = validated(stem, &source, &module)?;
    let debug_source = debug.then_some(source.as_str());
    let words = spirv::correct(&generate(stem, &module, &info, &variant.overrides, debug_source)?);
    cache::store("spirv", &key, bytemuck::cast_slice(&words));
    Ok(words)
}

/// Returns `true` if the shader of a pass has an override of this name.
pub fn has_override(pass: &Declaration, variant: &Variant, name: &str) -> Result<bool, Error> {
    Ok(source(pass, pass.shader, variant)?.contains(&format!("override {name}:")))
}

/// Compiles variants of a pass's shader and compares them with the declaration, past the cache. Variants that differ in
/// overrides alone have the same text, which is composed and parsed once.
///
/// # Errors
/// If one is no valid WGSL, differs from the declaration, or lacks an override that it sets.
pub fn check(pass: &Declaration, variants: &[Variant]) -> Result<(), Error> {
    let mut texts: HashMap<String, Vec<&Variant>> = HashMap::new();
    for variant in variants {
        texts.entry(Variant { overrides: Vec::new(), ..variant.clone() }.key()).or_default().push(variant);
    }
    for variants in texts.into_values() {
        let source = source(pass, pass.shader, variants[0])?;
        let module = parse(pass.shader, &source)?;
        check_declaration(pass.shader, &module, &(pass.bindings)(), (pass.push_shape)().as_ref(), true)?;
        let info = validated(pass.shader, &source, &module)?;
        for variant in variants {
            generate(pass.shader, &module, &info, &variant.overrides, None)
                .map_err(|cause| error(pass.shader, format!("{variant:?}: {cause}")))?;
        }
    }
    Ok(())
}

fn parse(stem: &str, source: &str) -> Result<naga::Module, Error> {
    naga::front::wgsl::parse_str(source).map_err(|e| error(stem, e.emit_to_string(source)))
}

fn validated(stem: &str, source: &str, module: &naga::Module) -> Result<ModuleInfo, Error> {
    let capabilities = Capabilities::IMMEDIATES
        | Capabilities::SHADER_INT64
        | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS
        | Capabilities::MULTISAMPLED_SHADING
        | Capabilities::SUBGROUP
        | Capabilities::SUBGROUP_BARRIER;
    Validator::new(ValidationFlags::all(), capabilities)
        .validate(module)
        .map_err(|e| error(stem, e.emit_to_string(source)))
}

/// SPIR-V of a module, with names and source where `debug` has the source.
fn generate(
    stem: &str,
    module: &naga::Module,
    info: &ModuleInfo,
    overrides: &[(&'static str, f64)],
    debug: Option<&str>,
) -> Result<Vec<u32>, Error> {
    let known: Vec<&str> = module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
    if let Some((name, _)) = overrides.iter().find(|(name, _)| !known.contains(name)) {
        return Err(error(stem, format!("no override {name}")));
    }
    let constants = overrides.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let (module, _) = naga::back::pipeline_constants::process_overrides(module, info, None, &constants)
        .map_err(|e| error(stem, e.to_string()))?;
    let mut module = module.into_owned();
    prune(&mut module);
    let info = Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .map_err(|e| error(stem, e.to_string()))?;
    let file = format!("{stem}.wgsl");
    let options = spv::Options {
        lang_version: (1, 3),
        // Without ADJUST_COORDINATE_SPACE, which would flip y.
        flags: if debug.is_some() { spv::WriterFlags::DEBUG } else { spv::WriterFlags::empty() },
        debug_info: debug.map(|source_code| spv::DebugInfo {
            source_code,
            file_name: &file,
            // Validation layers of Vulkan 1.3.239 refuse that of WGSL, which is younger.
            language: spv::SourceLanguage::Unknown,
        }),
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        emit_int_div_checks: false,
        ..Default::default()
    };
    spv::write_vec(&module, &info, &options, None).map_err(|e| error(stem, e.to_string()))
}

/// naga's SPIR-V for a source text, without our corrections unless `corrected`.
#[cfg(test)]
pub(crate) fn to_spirv(
    stem: &str,
    source: &str,
    overrides: &[(&'static str, f64)],
    corrected: bool,
) -> Result<Vec<u32>, Error> {
    let module = parse(stem, source)?;
    let words = generate(stem, &module, &validated(stem, source, &module)?, overrides, None)?;
    Ok(if corrected { spirv::correct(&words) } else { words })
}

/// naga's SPIR-V with names and source, without our corrections.
#[cfg(test)]
pub(crate) fn to_debug_spirv(stem: &str, source: &str) -> Result<Vec<u32>, Error> {
    let module = parse(stem, source)?;
    generate(stem, &module, &validated(stem, source, &module)?, &[], Some(source))
}

/// A shader's entry point, and its overrides, as naga sees them.
#[derive(Debug, Clone)]
pub struct Reflection {
    /// Compute, fragment, ….
    pub stage: ShaderStage,
    /// Invocations in x, y, z.
    pub workgroup: [u32; 3],
    /// Names of the overrides.
    pub overrides: Vec<String>,
}

/// Says what the shader of a pass is.
///
/// # Errors
/// If it does not parse, or has more than one entry point.
pub fn reflection(pass: &Declaration, variant: &Variant) -> Result<Reflection, Error> {
    let module = parse(pass.shader, &source(pass, pass.shader, variant)?)?;
    let overrides = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
    match module.entry_points.as_slice() {
        [entry] if entry.name == ENTRY => {
            Ok(Reflection { stage: entry.stage, workgroup: entry.workgroup_size, overrides })
        }
        _ => Err(error(pass.shader, "wants exactly one entry point, called main")),
    }
}
