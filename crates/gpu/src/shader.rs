//! WGSL to SPIR-V by naga, and what naga's reflection says about bindings and struct layouts. Needs no device.
//!
//! The files come from [`Sources`], which a crate with passes embeds. `#import name` pastes shared/name.wgsl once. Variants are made by
//! `override` values and, for what WGSL does not let an override size (function-local arrays, optional bindings), by
//! text constants: lines `const NAME = VALUE;` put before the source. `#walker` pastes the piece that the variant names.
//! `#each NAME LINE` writes a line as often as the variant says of that name, with `{NAME}` = 0, 1, ….
//! For the sorting network of n inputs that a variant asks for, `#repeat LINE` writes a line n times with `{i}` = 0 … n − 1,
//! and `#comparators` sorts the variables x0 … x(n − 1).

use std::fmt::Write as _;

use include_dir::Dir;
use naga::back::spv;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, ImageClass, ImageDimension, ShaderStage, StorageAccess, TypeInner};

use super::{Access, Binding, Error, Pass, PushConstants, Shape, cache, guard, spirv};

/// The WGSL files of a crate that declares passes, embedded: `pass!` looks for them in `crate::SHADERS`.
#[derive(Debug)]
pub struct Sources(pub Dir<'static>);

/// Entry point of every shader file.
pub const ENTRY: &str = "main";
/// Invocations of every compute workgroup; also the constant `WG_SIZE` in WGSL.
pub const WORKGROUP: u32 = 64;

/// Which of a shader's variants: values of overrides by name, and text constants.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Variant {
    /// Overrides.
    pub overrides: Vec<(&'static str, f64)>,
    /// Text constants with their WGSL value, as `("CAPACITY", "256u")`.
    pub constants: Vec<(&'static str, String)>,
    /// Declarations that the host writes, put before the source.
    pub text: String,
    /// Inputs of the sorting network that `#comparators` and `#repeat` write out; a power of two.
    pub network: Option<u32>,
    /// The shared piece that stands in for `#walker`: who visits the pixels of splats.
    pub walker: Option<&'static str>,
    /// Names and counts for `#each`.
    pub counts: Vec<(&'static str, u32)>,
    /// Invocations of a subgroup, for shaders whose workgroup is one subgroup; also the constant `SUBGROUP` in WGSL.
    pub subgroup: Option<u32>,
}

impl Variant {
    /// The one variant of a shader that has no choices.
    pub fn plain() -> Self {
        Self::default()
    }

    /// Adds an override.
    pub fn with(mut self, name: &'static str, value: impl Into<f64>) -> Self {
        self.overrides.push((name, value.into()));
        self
    }

    /// Adds a text constant of type u32.
    pub fn constant(mut self, name: &'static str, value: u32) -> Self {
        self.constants.push((name, format!("{value}u")));
        self
    }

    /// Adds declarations.
    pub fn text(mut self, text: &str) -> Self {
        self.text.push_str(text);
        self
    }

    /// Sets the size of the sorting network.
    pub fn network(mut self, inputs: u32) -> Self {
        self.network = Some(inputs);
        self
    }

    /// Sets the walker.
    pub fn walker(mut self, name: &'static str) -> Self {
        self.walker = Some(name);
        self
    }

    /// Sets how often `#each name` writes its line.
    pub fn each(mut self, name: &'static str, count: u32) -> Self {
        self.counts.push((name, count));
        self
    }

    /// Sets the size of subgroups.
    pub fn subgroup(mut self, size: u32) -> Self {
        self.subgroup = Some(size);
        self
    }

    /// A key that differs for every variant.
    pub fn key(&self) -> String {
        format!("{self:?}")
    }
}

/// The shader files by stem (`abuffer/store`), the shared pieces left out.
pub fn stems(sources: &Sources) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![&sources.0];
    while let Some(folder) = folders.pop() {
        folders.extend(folder.dirs().filter(|d| !d.path().ends_with("shared")));
        found.extend(folder.files().filter_map(|f| Some(f.path().to_str()?.strip_suffix(".wgsl")?.to_owned())));
    }
    found.sort();
    found
}

fn file<'a>(sources: &'a Sources, stem: &str) -> Option<&'a str> {
    let name = format!("{stem}.wgsl");
    // The shared pieces of the device layer serve everybody.
    sources.0.get_file(&name).or_else(|| crate::SHADERS.0.get_file(&name))?.contents_utf8()
}

/// The whole source of a shader: text constants, then the file with its imports pasted in.
pub fn source(sources: &Sources, stem: &str, variant: &Variant) -> Result<String, Error> {
    let text = file(sources, stem).ok_or_else(|| error(stem, "no such file under shaders/"))?;
    let mut out = format!("const WG_SIZE = {WORKGROUP}u;\n");
    for (name, value) in &variant.constants {
        let _ = writeln!(out, "const {name} = {value};");
    }
    if let Some(size) = variant.subgroup {
        let _ = writeln!(out, "const SUBGROUP = {size}u;");
    }
    out.push_str(&variant.text);
    paste(sources, stem, text, variant, &mut out, &mut Vec::new())?;
    Ok(out)
}

fn paste<'a>(
    sources: &'a Sources,
    stem: &str,
    text: &'a str,
    variant: &Variant,
    out: &mut String,
    pasted: &mut Vec<&'a str>,
) -> Result<(), Error> {
    for line in text.lines() {
        let name = match line.strip_prefix("#import ") {
            Some(name) => name.trim(),
            None if line == "#walker" => variant.walker.ok_or_else(|| error(stem, "the variant names no walker"))?,
            None if line == "#comparators" => {
                out.push_str(&comparator_text(inputs(stem, variant)?));
                continue;
            }
            None if line.starts_with("#repeat ") => {
                write_lines(&line["#repeat ".len()..], "i", inputs(stem, variant)?, out);
                continue;
            }
            None if line.starts_with("#each ") => {
                let (name, line) = line["#each ".len()..].split_once(' ').unwrap_or_default();
                let count = variant.counts.iter().find(|(known, _)| *known == name).map(|(_, count)| *count);
                let count = count.ok_or_else(|| error(stem, format!("the variant does not say how often {name:?}")))?;
                write_lines(line, name, count, out);
                continue;
            }
            None => {
                out.push_str(line);
                out.push('\n');
                continue;
            }
        };
        if !pasted.contains(&name) {
            let shared = file(sources, &format!("shared/{name}"))
                .ok_or_else(|| error(stem, format!("no shared piece {name:?}")))?;
            pasted.push(name);
            paste(sources, stem, shared, variant, out, pasted)?;
        }
    }
    Ok(())
}

/// Writes a line `count` times with `{name}` = 0, 1, ….
fn write_lines(line: &str, name: &str, count: u32, out: &mut String) {
    let place = format!("{{{name}}}");
    for i in 0..count {
        out.push_str(&line.replace(&place, &i.to_string()));
        out.push('\n');
    }
}

/// Pairs of Batcher's odd-even merge sort of `n` inputs (a power of two), in order: the smaller goes to the first place.
fn comparators(n: u32) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    let mut p = 1;
    while p < n {
        let mut k = p;
        while k >= 1 {
            for j in (k % p..n - k).step_by(2 * k as usize) {
                for i in 0..k.min(n - j - k) {
                    if (i + j) / (2 * p) == (i + j + k) / (2 * p) {
                        pairs.push((i + j, i + j + k));
                    }
                }
            }
            k /= 2;
        }
        p *= 2;
    }
    pairs
}

/// WGSL that sorts the variables x0, x1, … by the shader's function `before`.
fn comparator_text(inputs: u32) -> String {
    let mut out = String::new();
    for (number, (a, b)) in comparators(inputs).into_iter().enumerate() {
        let _ = writeln!(out, "    let s{number} = before(x{b}, x{a});");
        let _ = writeln!(out, "    let t{number} = select(x{a}, x{b}, s{number});");
        let _ = writeln!(out, "    x{b} = select(x{b}, x{a}, s{number});");
        let _ = writeln!(out, "    x{a} = t{number};");
    }
    out
}

fn inputs(stem: &str, variant: &Variant) -> Result<u32, Error> {
    variant.network.ok_or_else(|| error(stem, "the variant has no sorting network"))
}

fn error(name: &str, message: impl Into<String>) -> Error {
    Error::Shader { name: name.to_owned(), message: message.into() }
}

/// SPIR-V of a pass's compute shader, checked against the pass's declaration; from the disk cache if it is there.
pub fn compile<P: Pass>(variant: &Variant) -> Result<Vec<u32>, Error> {
    compile_stage::<P>(P::SHADER, variant, true)
}

/// The vertex shader of every pass that draws: two triangles over each splat's rectangle.
const QUAD: &str = "splat/quad.vert";

/// SPIR-V of the vertex and fragment shaders of a pass that draws. The vertex shader uses only some of the bindings.
pub fn compile_draw<P: Pass>(variant: &Variant) -> Result<[Vec<u32>; 2], Error> {
    Ok([compile_stage::<P>(QUAD, &Variant::plain(), false)?, compile_stage::<P>(P::SHADER, variant, true)?])
}

fn compile_stage<P: Pass>(stem: &str, variant: &Variant, all_bindings: bool) -> Result<Vec<u32>, Error> {
    let source = source(P::sources(), stem, variant)?;
    // The declaration is part of the key: a cached shader was compared with the same one.
    let (version, key) = (env!("CARGO_PKG_VERSION"), variant.key());
    let identity =
        format!("{version}\n{}\n{source}\n{key}\n{:?}\n{:?}", guard::BYTES, P::bindings(), P::Push::push_shape());
    let key = blake3::hash(identity.as_bytes()).to_hex().to_string();
    if let Some(words) =
        cache::load("spirv", &key).and_then(|bytes| bytemuck::try_cast_slice(&bytes).map(<[u32]>::to_vec).ok())
    {
        return Ok(words);
    }
    let module = parse(stem, &source)?;
    check_bindings(stem, &module, &P::bindings(), P::Push::push_shape().as_ref(), all_bindings)?;
    let words = spirv::correct(&generate(stem, &source, &module, &variant.overrides)?);
    cache::store("spirv", &key, bytemuck::cast_slice(&words));
    Ok(words)
}

/// Compiles a pass's shader and compares it with the declaration, past the cache: for tests.
pub fn check<P: Pass>(variant: &Variant) -> Result<(), Error> {
    let source = source(P::sources(), P::SHADER, variant)?;
    let module = parse(P::SHADER, &source)?;
    check_bindings(P::SHADER, &module, &P::bindings(), P::Push::push_shape().as_ref(), true)?;
    generate(P::SHADER, &source, &module, &variant.overrides).map(|_| ())
}

fn parse(stem: &str, source: &str) -> Result<naga::Module, Error> {
    naga::front::wgsl::parse_str(source).map_err(|e| error(stem, e.emit_to_string(source)))
}

fn validated(stem: &str, source: &str, module: &naga::Module) -> Result<ModuleInfo, Error> {
    let capabilities = Capabilities::IMMEDIATES
        | Capabilities::SHADER_INT64
        | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS
        | Capabilities::MULTISAMPLED_SHADING
        | Capabilities::SUBGROUP;
    Validator::new(ValidationFlags::all(), capabilities)
        .validate(module)
        .map_err(|e| error(stem, e.emit_to_string(source)))
}

fn generate(
    stem: &str,
    source: &str,
    module: &naga::Module,
    overrides: &[(&'static str, f64)],
) -> Result<Vec<u32>, Error> {
    let info = validated(stem, source, module)?;
    let known: Vec<&str> = module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
    if let Some((name, _)) = overrides.iter().find(|(name, _)| !known.contains(name)) {
        return Err(error(stem, format!("no override {name}")));
    }
    let constants = overrides.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let (module, info) = naga::back::pipeline_constants::process_overrides(module, &info, None, &constants)
        .map_err(|e| error(stem, e.to_string()))?;
    let options = spv::Options {
        lang_version: (1, 3),
        // Without ADJUST_COORDINATE_SPACE, which would flip y.
        flags: spv::WriterFlags::empty(),
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        emit_int_div_checks: false,
        ..Default::default()
    };
    spv::write_vec(&module, &info, &options, None).map_err(|e| error(stem, e.to_string()))
}

/// naga's SPIR-V for a source text, without our corrections unless `corrected`.
#[cfg(test)]
pub(super) fn to_spirv(
    stem: &str,
    source: &str,
    overrides: &[(&'static str, f64)],
    corrected: bool,
) -> Result<Vec<u32>, Error> {
    let words = generate(stem, source, &parse(stem, source)?, overrides)?;
    Ok(if corrected { spirv::correct(&words) } else { words })
}

/// Compares names, numbers, access and layouts of group 0 and the push constants.
fn check_bindings(
    stem: &str,
    module: &naga::Module,
    declared: &[Binding],
    push: Option<&Shape>,
    all_bindings: bool,
) -> Result<(), Error> {
    let mut seen = vec![false; declared.len()];
    for (_, variable) in module.global_variables.iter() {
        let name = variable.name.as_deref().unwrap_or_default();
        if variable.space == AddressSpace::Immediate {
            let shape = push.ok_or_else(|| error(stem, format!("{name}: the pass declares no push constants")))?;
            check_shape(stem, name, module, variable.ty, shape)?;
            continue;
        }
        let Some(place) = &variable.binding else { continue };
        let index = place.binding as usize;
        let Some(binding) = declared.get(index).filter(|_| place.group == 0) else {
            return Err(error(stem, format!("{name}: the pass has no binding {index} in group {}", place.group)));
        };
        if binding.name != name {
            return Err(error(stem, format!("binding {index} is {name:?} in WGSL and {:?} in the pass", binding.name)));
        }
        let access =
            access_of(variable.space).ok_or_else(|| error(stem, format!("{name}: neither a buffer nor a texture")))?;
        if access != binding.access {
            return Err(error(stem, format!("{name}: {access:?} in WGSL, {:?} in the pass", binding.access)));
        }
        check_shape(stem, name, module, element(module, variable.ty), &binding.shape)?;
        seen[index] = true;
    }
    match seen.iter().position(|s| !s) {
        Some(missing) if all_bindings => {
            Err(error(stem, format!("binding {:?} is missing in WGSL", declared[missing].name)))
        }
        _ => Ok(()),
    }
}

fn access_of(space: AddressSpace) -> Option<Access> {
    match space {
        AddressSpace::Uniform => Some(Access::Uniform),
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Some(Access::ReadWrite),
        AddressSpace::Storage { .. } => Some(Access::Read),
        AddressSpace::Handle => Some(Access::Texture),
        _ => None,
    }
}

/// The element of a runtime-sized array, else the type itself.
fn element(module: &naga::Module, ty: naga::Handle<naga::Type>) -> naga::Handle<naga::Type> {
    match module.types[ty].inner {
        TypeInner::Array { base, .. } => base,
        _ => ty,
    }
}

fn check_shape(
    stem: &str,
    name: &str,
    module: &naga::Module,
    ty: naga::Handle<naga::Type>,
    shape: &Shape,
) -> Result<(), Error> {
    match (&module.types[ty].inner, shape) {
        (TypeInner::Struct { members, span }, Shape::Struct { size, members: declared }) => {
            let found: Vec<(&str, usize)> =
                members.iter().map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize)).collect();
            if found != *declared || *span as usize != *size {
                return Err(error(
                    stem,
                    format!("{name}: {found:?} of {span} bytes in WGSL, {declared:?} of {size} bytes in Rust"),
                ));
            }
            Ok(())
        }
        (inner, Shape::Plain(wanted)) if plain_name(inner).as_deref() == Some(*wanted) => Ok(()),
        (inner, shape) => Err(error(stem, format!("{name}: {inner:?} in WGSL, {shape:?} in Rust"))),
    }
}

/// WGSL's name of a scalar or vector of 32- or 64-bit components, or of a texture of floats.
fn plain_name(inner: &TypeInner) -> Option<String> {
    let scalar_name = |s: naga::Scalar| match (s.kind, s.width) {
        (naga::ScalarKind::Float, 4) => Some("f32"),
        (naga::ScalarKind::Uint, 4) => Some("u32"),
        (naga::ScalarKind::Uint, 8) => Some("u64"),
        (naga::ScalarKind::Sint, 4) => Some("i32"),
        _ => None,
    };
    match *inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => scalar_name(scalar).map(str::to_owned),
        TypeInner::Vector { size, scalar } => Some(format!("vec{}<{}>", size as u8, scalar_name(scalar)?)),
        TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } => texture_name(class).map(str::to_owned),
        _ => None,
    }
}

/// WGSL's name of a two-dimensional texture.
fn texture_name(class: ImageClass) -> Option<&'static str> {
    match class {
        ImageClass::Sampled { kind: naga::ScalarKind::Float, multi: false } => Some("texture_2d<f32>"),
        ImageClass::Sampled { kind: naga::ScalarKind::Float, multi: true } => Some("texture_multisampled_2d<f32>"),
        ImageClass::Depth { multi: true } => Some("texture_depth_multisampled_2d"),
        _ => None,
    }
}

/// Stage and workgroup size of a shader's entry point: for tests.
pub fn entry_point(sources: &Sources, stem: &str, variant: &Variant) -> Result<(ShaderStage, [u32; 3]), Error> {
    let source = source(sources, stem, variant)?;
    let module = parse(stem, &source)?;
    match module.entry_points.as_slice() {
        [entry] if entry.name == ENTRY => Ok((entry.stage, entry.workgroup_size)),
        _ => Err(error(stem, "wants exactly one entry point, called main")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_sort_every_pattern_of_zeros_and_ones() {
        // By the zero-one principle that is every input.
        for n in [1u32, 2, 4, 8, 16] {
            let pairs = comparators(n);
            for pattern in 0u32..1 << n {
                let mut bits: Vec<u32> = (0..n).map(|i| pattern >> i & 1).collect();
                for &(a, b) in &pairs {
                    let (a, b) = (a as usize, b as usize);
                    (bits[a], bits[b]) = (bits[a].min(bits[b]), bits[a].max(bits[b]));
                }
                assert!(bits.is_sorted(), "{n} inputs, pattern {pattern:b}");
            }
        }
        // Knuth, TAOCP 3, 5.3.4: 191 comparators for 32 inputs.
        assert_eq!(comparators(32).len(), 191);
    }
}
