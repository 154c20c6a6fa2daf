//! Every shader and variant parses, validates and agrees with its Rust declaration. No device is needed.

use std::collections::{BTreeSet, HashSet};
use std::sync::LazyLock;

use pellucid_engine::passes::scan;
use pellucid_engine::{SHADERS, pass};
use pellucid_gpu as gpu;
use pellucid_gpu::gpu_struct;
use pellucid_gpu::shader::{self, Reflection, Shader, ShaderStage, WORKGROUP};
use pellucid_gpu::{Pass, Variant};

/// The vertex shader of every pass that draws, which no pass names.
const QUAD: &str = "raster/quad.vert";

/// Every pass of the engine and of the device layer.
fn shaders() -> Vec<Shader> {
    let mut all = pellucid_engine::shaders();
    all.extend(gpu::shaders());
    all
}

/// A variant for each text that a shader has: what overrides say changes none.
fn texts(shader: &Shader) -> impl Iterator<Item = &Variant> {
    let mut known = HashSet::new();
    shader.variants.iter().filter(move |v| known.insert(Variant { overrides: Vec::new(), ..(*v).clone() }.key()))
}

/// A pass with a variant for each text, and what the text says.
type Reflected = (Shader, Vec<(Variant, Reflection)>);

static REFLECTED: LazyLock<Vec<Reflected>> = LazyLock::new(|| {
    let reflected = |shader: Shader| {
        let of = |variant: &Variant| (variant.clone(), shader.reflection(variant).expect("a valid shader"));
        let all = texts(&shader).map(of).collect();
        (shader, all)
    };
    shaders().into_iter().map(reflected).collect()
});

/// Checks shaders against their passes; returns the number of variants.
fn checked(shaders: Vec<Shader>) -> usize {
    let check = |shader: Shader| {
        assert!(!shader.variants.is_empty(), "{}", shader.pass.name);
        shader.check().unwrap_or_else(|e| panic!("{}: {e}", shader.pass.name));
        shader.variants.len()
    };
    shaders.into_iter().map(check).sum()
}

/// A variant that a frame runs and that is in no pair here is compiled, and validated, by the tests of its method.
#[test]
fn every_shader_matches_its_pass_in_every_pair_of_choices() {
    let shaders = shaders();
    let all: usize = shaders.iter().map(|shader| shader.variants.len()).sum();
    let checked = checked(shaders.into_iter().map(Shader::in_pairs_of_choices).collect());
    println!("{checked} of {all} variants");
    assert!(checked < all);
}

#[test]
#[ignore = "takes minutes: SPIR-V of every variant, of which the test above takes every pair of choices"]
fn every_shader_matches_its_pass_in_every_variant() {
    println!("{} variants", checked(shaders()));
}

#[test]
fn every_shader_that_knows_quarters_of_pixels_is_valid_with_them() {
    let text = |variant: &Variant| Variant { overrides: Vec::new(), ..variant.clone() }.key();
    let mut knowing = HashSet::new();
    for (shader, texts) in &*REFLECTED {
        let knows = texts.iter().filter(|(_, known)| known.overrides.iter().any(|name| name == GIVEN));
        knowing.extend(knows.map(|(variant, _)| (shader.pass.shader, text(variant))));
    }
    let given = |shader: Shader| {
        let Shader { pass, variants } = shader.in_pairs_of_choices();
        let variants = variants.into_iter().filter(|variant| knowing.contains(&(pass.shader, text(variant))));
        Shader { variants: variants.map(|variant| variant.with(GIVEN, 1)).collect(), pass }
    };
    let given: Vec<Shader> = shaders().into_iter().map(given).filter(|shader| !shader.variants.is_empty()).collect();
    assert!(given.len() > 30, "{}", given.len());
    println!("{} variants", checked(given));
}

/// Opcode and length of each instruction, without those that only debuggers read.
fn computing(words: &[u32]) -> Vec<(u32, u32)> {
    // OpSourceContinued to OpLine, and OpNoLine.
    const DEBUG: [u32; 8] = [2, 3, 4, 5, 6, 7, 8, 317];
    let mut rest = &words[5..];
    let mut all = Vec::new();
    while let [first, ..] = rest {
        let (opcode, length) = (first & 0xffff, first >> 16);
        all.extend((!DEBUG.contains(&opcode)).then_some((opcode, length)));
        rest = &rest[length as usize..];
    }
    all
}

/// So all corrections of SPIR-V are made with names and source, too: nothing may be contracted, and lengths of arrays
/// leave the guard out.
#[test]
fn shaders_with_names_and_source_have_the_instructions_of_those_without() {
    for (shader, texts) in &*REFLECTED {
        let (variant, reflection) = &texts[0];
        let compiled = |debug| match reflection.stage {
            ShaderStage::Compute => vec![shader::compile(&shader.pass, variant, debug).expect("a valid shader")],
            _ => shader::compile_draw(&shader.pass, variant, debug).expect("valid shaders").to_vec(),
        };
        for (plain, debug) in compiled(false).iter().zip(compiled(true)) {
            assert!(computing(plain) == computing(&debug), "{}", shader.pass.name);
            // `main`, as OpName of the entry point, and the source are longer than nothing.
            assert!(debug.len() > plain.len() + 10, "{}", shader.pass.name);
        }
    }
}

#[test]
fn every_shader_file_belongs_to_a_pass() {
    let passes = shaders();
    let stems = SHADERS.stems().into_iter().chain(gpu::SHADERS.stems());
    let forgotten: Vec<String> =
        stems.filter(|stem| stem != QUAD && passes.iter().all(|shader| shader.pass.shader != stem)).collect();
    assert_eq!(forgotten, Vec::<String>::new());
}

#[test]
fn every_compute_shader_has_the_common_workgroup_or_subgroups() {
    const SINGLE: [&str; 2] = ["abuffer/run_groups", "peel/next"];
    for (shader, texts) in &*REFLECTED {
        for (variant, reflection) in texts {
            if shader.pass.shader.starts_with("stochastic/draw_") {
                assert_eq!(reflection.stage, ShaderStage::Fragment, "{}", shader.pass.shader);
            } else if reflection.stage == ShaderStage::Fragment {
                assert_eq!(variant.walker, Some("walk_fragment"), "{}", shader.pass.shader);
            } else {
                let single = SINGLE.contains(&shader.pass.shader);
                let team = variant.constants.iter().find(|(name, _)| *name == "TEAM").map_or("1u", |(_, team)| team);
                let team: u32 = team.trim_end_matches('u').parse().expect("a number of subgroups");
                let wanted = if single { 1 } else { variant.subgroup.map_or(WORKGROUP, |lanes| lanes * team) };
                assert_eq!(reflection.workgroup, [wanted, 1, 1], "{}", shader.pass.shader);
            }
        }
    }
}

/// Numbers that a stage sets once and for all, or that a frame decides: not choices.
const NUMBERS: [&str; 6] = ["PART_LENGTH", "RUN", "SHARED", "STEP", "STRIPES", "TAKEN"];

/// A choice of the frame, which recordings give to every pass whose shader has it.
const GIVEN: &str = "QUARTERS";

/// Choices that a shader shares with others and that its pass makes in one way alone: flat discs in order of depth,
/// spheres and opaque splats without a falloff.
const FIXED: [(&str, &str); 20] = [
    ("abuffer/count_tiles", "SHAPE"),
    ("abuffer/resolve_ordered", "SHAPE"),
    ("abuffer/store_tiles", "SHAPE"),
    ("ellipsoids/blend_runs", "SHAPE"),
    ("ellipsoids/count", "SHAPE"),
    ("ellipsoids/link", "SHAPE"),
    ("ellipsoids/median", "SHAPE"),
    ("ellipsoids/samples", "SHAPE"),
    ("ellipsoids/store", "SHAPE"),
    ("ellipsoids/sum_runs", "SHAPE"),
    ("soft/blend_runs", "FALLOFF"),
    ("soft/express", "SHAPE"),
    ("soft/resolve_merge", "FALLOFF"),
    ("soft/resolve_network", "FALLOFF"),
    ("soft/resolve_sorted", "FALLOFF"),
    ("soft/samples", "FALLOFF"),
    ("soft/segments", "FALLOFF"),
    ("soft/sum_runs", "FALLOFF"),
    ("splats/attributes", "FALLOFF"),
    ("splats/visibility", "FALLOFF"),
];

/// A choice that no variant makes, or that all variants of a shader make alike, is one that their list forgot.
#[test]
fn variants_make_every_choice_in_more_than_one_way() {
    let (mut declared, mut made, mut alike) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (shader, texts) in &*REFLECTED {
        for (_, reflection) in texts {
            for name in &reflection.overrides {
                let value = |v: &Variant| v.overrides.iter().find(|(n, _)| n == name).map(|(_, value)| value.to_bits());
                let values: HashSet<Option<u64>> = shader.variants.iter().map(value).collect();
                if values.iter().any(Option::is_some) {
                    made.insert(name.clone());
                    if values.len() == 1 && !NUMBERS.contains(&name.as_str()) {
                        alike.insert((shader.pass.shader, name.clone()));
                    }
                }
                declared.insert(name.clone());
            }
        }
    }
    assert_eq!(declared.difference(&made).collect::<Vec<_>>(), [GIVEN]);
    assert_eq!(alike, BTreeSet::from(FIXED.map(|(stem, name)| (stem, name.to_owned()))));
}

/// Every WGSL file of the engine and of the device layer, with its path.
fn files() -> Vec<(std::path::PathBuf, String)> {
    let mut folders =
        ["crates/engine/shaders", "crates/gpu/shaders"].map(|name| pellucid_testing::root().join(name)).to_vec();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder of shaders") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let text = std::fs::read_to_string(&path).expect("a shader");
                found.push((path, text));
            }
        }
    }
    assert!(found.len() > 100, "{}", found.len());
    found
}

#[test]
fn every_constant_of_rust_is_mentioned_by_a_shader() {
    let files = files();
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let code = files.iter().flat_map(|(_, text)| text.lines()).map(|line| line.split("//").next().unwrap_or_default());
    let words: HashSet<&str> = code.flat_map(|line| line.split(|c: char| !part(c))).collect();
    let integers = SHADERS.constants.iter().chain(gpu::SHADERS.constants).copied().flatten().map(|(name, _)| *name);
    let floats = SHADERS.floats.iter().chain(gpu::SHADERS.floats).copied().flatten().map(|(name, _)| *name);
    for name in integers.chain(floats) {
        assert!(words.contains(name), "{name}");
    }
}

gpu_struct! {
    /// A member renamed.
    pub struct Renamed {
        amount: u32,
    }
}

pass! {
    /// The true declaration.
    Right(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another name.
    WrongName(scan::ScanPush) = "scan/reduce" { value: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another access.
    WrongAccess(scan::ScanPush) = "scan/reduce" { values: ReadWrite<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// Another element.
    WrongElement(scan::ScanPush) = "scan/reduce" { values: Read<f32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// A binding too few.
    TooFew(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32> }
}
pass! {
    /// A binding too many.
    TooMany(scan::ScanPush) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32>, rest: Read<u32> }
}
pass! {
    /// Push constants with another name.
    WrongPush(Renamed) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
gpu_struct! {
    /// A member of another type.
    pub struct Floating {
        count: f32,
    }
}

pass! {
    /// Push constants of another type, with the same name and size.
    WrongPushType(Floating) = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}
pass! {
    /// No push constants.
    NoPush = "scan/reduce" { values: Read<u32>, sums: ReadWrite<u32>, overflow: ReadWrite<u32> }
}

#[test]
fn a_declaration_that_differs_from_its_shader_is_refused() {
    fn result<P: Pass>() -> Result<(), String> {
        shader::check(&P::DECLARATION, &[Variant::plain()]).map_err(|e| e.to_string())
    }
    result::<Right>().expect("the declaration in earnest");
    let refusals = [
        (result::<WrongName>(), "\"values\" in WGSL and \"value\""),
        (result::<WrongAccess>(), "Read in WGSL, ReadWrite"),
        (result::<WrongElement>(), "u32 in WGSL, f32 in Rust"),
        (result::<TooFew>(), "no binding 2"),
        (result::<TooMany>(), "\"rest\" is missing"),
        (result::<WrongPush>(), "push.count"),
        (result::<WrongPushType>(), "push.count"),
        (result::<NoPush>(), "no push constants"),
    ];
    for (result, part) in refusals {
        let message = result.expect_err(part);
        assert!(message.contains(part), "{message:?} should say {part:?}");
    }
}

/// Operations that drivers compute differently, or in another order, are written out in shared/elementary.wgsl. A sum
/// of two products has only one order, so `dot` of two components is allowed.
#[test]
fn no_shader_leaves_to_the_driver_what_drivers_do_differently() {
    const OWN: &[&str] = &[
        "exp",
        "exp2",
        "log",
        "log2",
        "pow",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "inverseSqrt",
        "length",
        "distance",
        "normalize",
        "cross",
        "determinant",
        "reflect",
        "refract",
        "mix",
        "smoothstep",
        "fma",
        "pack4x8unorm",
        "pack4x8snorm",
        "pack2x16unorm",
        "pack2x16float",
        "round",
    ];
    /// Calls of any of these in a line, without its comment.
    fn calls(line: &str) -> Vec<&str> {
        let code = line.split("//").next().unwrap_or_default();
        let words = code.split('(').filter_map(|part| {
            part.rsplit(|c: char| !c.is_ascii_alphanumeric() && c != '_').next().filter(|word| OWN.contains(word))
        });
        // Behind the last parenthesis comes no call.
        words.take(code.matches('(').count()).collect()
    }
    assert_eq!(calls("let a = exp(-x) + my_log(y) / length3(v); // pow(x)"), ["exp"]);
    assert_eq!(calls("let a = length3(cross(b, c)) + cross3(b, c).x;"), ["cross"]);
    assert_eq!(calls("fn f(length: f32) { return length; }"), Vec::<&str>::new());

    for (path, text) in files() {
        for (line, number) in text.lines().zip(1..) {
            assert_eq!(calls(line), Vec::<&str>::new(), "{}, line {number}: {line}", path.display());
        }
    }
}

#[test]
fn an_unknown_override_is_refused() {
    let error =
        shader::check(&Right::DECLARATION, &[Variant::plain().with("NO_SUCH", 1)]).expect_err("no such override");
    assert!(error.to_string().contains("NO_SUCH"));
}
