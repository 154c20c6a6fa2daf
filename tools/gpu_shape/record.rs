//! The pipelines that frames create, each as its pass and the place of its variant in the pass's list.

use pellucid_core::progress::Progress;
use pellucid_engine::methods::{Frame, FrameProfile, Renderer};
use pellucid_engine::{NUMBERS, key_without_numbers, plan};
use pellucid_gpu as gpu;
use pellucid_gpu::shader::Shader;
use pellucid_gpu::{Blend, Device, DeviceOptions, Format, Outputs, PipelineSource, Preferences, Variant};
use pellucid_lab::check::{self, Lack, MethodScene};
use pellucid_scene::{self as scene, Method, Overrides, Scene, procedural};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A pipeline, in the form in which one process sends it to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// The label under which it ran first, as in `abuffer/resolve-8`.
    pub label: String,
    /// Place of the pass among all.
    pass: usize,
    /// Place of the variant among those of its subgroup size.
    variant: usize,
    /// Invocations of its subgroups when it was recorded; `None` where it has no say in them.
    pub subgroup: Option<u32>,
    /// Values that a frame decided, by override.
    numbers: Vec<(String, f64)>,
    /// Index of a draw's outputs among all that there can be.
    outputs: Option<usize>,
}

/// A frame of the built-in scene, for estimates.
pub struct Recording {
    pub method: &'static str,
    pub profile: FrameProfile,
    pub pipelines: Vec<Recorded>,
}

/// All passes.
pub fn shaders() -> Vec<Shader> {
    pellucid_engine::shaders().into_iter().chain(gpu::shaders()).collect()
}

/// Devices that share the recording: lavapipe keeps less than a core busy in scenes as small as these.
const DEVICES: usize = 2;

/// Pipelines of the scenes of all methods and of `pellucid check`.
pub fn everything() -> Result<Vec<Recorded>, String> {
    eprintln!("recording the scenes of all methods and of `pellucid check`");
    let shares = (0..DEVICES).into_par_iter().map(share).collect::<Result<Vec<_>, _>>()?;
    Ok(shares.concat())
}

/// Pipelines of one of [`DEVICES`] shares.
fn share(first: usize) -> Result<Vec<Recorded>, String> {
    let device = open()?;
    let mut renderer = Renderer::new(&device).map_err(|e| e.to_string())?;
    for subject in check::subjects().into_iter().skip(first).step_by(DEVICES) {
        match subject.render(&mut renderer) {
            Err(error) if Lack::in_error(&error).is_none() => return Err(format!("{}: {error}", subject.name)),
            _ => {}
        }
    }
    drop(renderer);
    let mut stage = check::CaseRenderer::new(&device).map_err(|e| e.to_string())?;
    for case in check::cases().into_iter().skip(first).step_by(DEVICES) {
        case.run(&mut stage);
    }
    of_device(&device)
}

/// A frame of the built-in scene by each method, each on a device of its own.
pub fn frames() -> Result<Vec<Recording>, String> {
    if gpu::checks() {
        return Err("a debug build checks the device's work, which adds to a frame's: set PELLUCID_CHECKS=0".into());
    }
    Method::all().into_iter().map(|method| frame(method.name())).collect()
}

fn frame(method: &'static str) -> Result<Recording, String> {
    eprintln!("recording the built-in scene by {method}");
    let error = |e: pellucid_engine::Error| format!("garden, {method}: {e}");
    let mut overrides = Overrides::default();
    overrides.set("gpu-shape", "method.name", method).map_err(|e| error(e.into()))?;
    overrides.set("gpu-shape", "image.size", "[1280, 720]").map_err(|e| error(e.into()))?;
    let generated = procedural::build("garden", &[], 0).map_err(|e| error(scene::Error::from(e).into()))?;
    let scene =
        Scene::from_toml_with(&generated.scene_toml, "garden".as_ref(), &overrides).map_err(|e| error(e.into()))?;
    let clouds = scene::take_generated(&scene, &generated).map_err(|e| error(e.into()))?;
    let up = scene::up_axis(&clouds);
    let points = scene::assemble(&scene, clouds, true, &Progress::hidden()).map_err(|e| error(e.into()))?;
    let (camera, _) = scene::camera(&scene, &points, up).map_err(|e| error(e.into()))?;
    let frame = Frame { method: plan::resolve(scene.method, &points).0, ..Frame::of_scene(&scene, camera, 0) };
    let subject = MethodScene { name: method.to_owned(), clouds: vec![points], choice: scene.method, frame };
    let device = open()?;
    let mut renderer = Renderer::new(&device).map_err(|e| error(e.into()))?;
    let rendered = subject.render(&mut renderer).map_err(|e| error(e.into()))?;
    drop(renderer);
    Ok(Recording { method, profile: rendered.profile, pipelines: of_device(&device)? })
}

/// The device that the environment gives, with work shaped as a GPU prefers it.
fn open() -> Result<Device, String> {
    let options = DeviceOptions { prefers: Some(Preferences::GPU), ..DeviceOptions::from_env() };
    Device::open(&options).map_err(|e| e.to_string())
}

/// Returns each pipeline once, in order of the labels.
pub fn distinct(mut all: Vec<Recorded>) -> Vec<Recorded> {
    all.sort_by(|a, b| a.label.cmp(&b.label));
    let mut found: Vec<Recorded> = Vec::new();
    for recorded in all {
        if !found.contains(&recorded) {
            found.push(recorded);
        }
    }
    found
}

/// Lists the pipelines that a device has made.
fn of_device(device: &Device) -> Result<Vec<Recorded>, String> {
    let shaders = shaders();
    device.made().iter().map(|made| recorded(&shaders, made)).collect()
}

fn recorded(shaders: &[Shader], made: &PipelineSource) -> Result<Recorded, String> {
    let unlisted = || format!("{}: no pass lists this variant: {}", made.label, made.variant.key());
    let wanted = key_without_numbers(&made.variant);
    // Passes of several methods may share a name, or a file.
    let named = |shader: &Shader| shader.pass.name == made.pass && shader.pass.shader == made.stem;
    for (pass, shader) in shaders.iter().enumerate().filter(|(_, shader)| named(shader)) {
        let found = sized(shader, made.variant.subgroup).iter().position(|v| key_without_numbers(v) == wanted);
        if let Some(variant) = found {
            let numbers = made.variant.overrides.iter().filter(|(name, _)| NUMBERS.contains(name));
            let outputs =
                made.outputs.map(|outputs| all_outputs().iter().position(|o| *o == outputs).ok_or_else(unlisted));
            return Ok(Recorded {
                label: made.label.to_owned(),
                pass,
                variant,
                subgroup: made.variant.subgroup,
                numbers: numbers.map(|(name, value)| ((*name).to_owned(), *value)).collect(),
                outputs: outputs.transpose()?,
            });
        }
    }
    Err(unlisted())
}

/// A pass's variants for subgroups of one size, in the order of the list, which is the same for every size.
fn sized(shader: &Shader, subgroup: Option<u32>) -> Vec<&Variant> {
    shader.variants.iter().filter(|variant| variant.subgroup == subgroup).collect()
}

impl Recorded {
    /// Returns the pass, the variant for subgroups of `lanes` where it has a say in them, and its outputs.
    pub fn rebuilt<'a>(&self, shaders: &'a [Shader], lanes: u32) -> (&'a Shader, Variant, Option<Outputs>) {
        let shader = &shaders[self.pass];
        let mut variant = sized(shader, self.subgroup.map(|_| lanes))[self.variant].clone();
        for (name, value) in &mut variant.overrides {
            *value = self.numbers.iter().find(|(known, _)| known == name).map_or(*value, |(_, value)| *value);
        }
        (shader, variant, self.outputs.map(|place| all_outputs()[place]))
    }
}

/// All outputs that a draw can have.
fn all_outputs() -> Vec<Outputs> {
    let formats = [Format::Depth, Format::Number, Format::Color];
    let blends = [Blend::Replace, Blend::Add, Blend::Cover];
    let colors = formats.iter().flat_map(|format| blends.map(|blend| Some((*format, blend))));
    let colors: Vec<_> = std::iter::once(None).chain(colors).collect();
    let mut all = Vec::new();
    for samples in [1, 2, 4, 8] {
        for depth in [false, true] {
            all.extend(colors.iter().map(|color| Outputs { color: *color, depth, samples }));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_gpu::shader::SUBGROUPS;

    #[test]
    fn every_pass_lists_its_variants_in_one_order_for_all_sizes_of_subgroups() {
        // Constants that depend on the size are derived from it: without them, the lists must be the same.
        let plain = |variant: &Variant| {
            let derived = ["LANE_COLUMNS", "LANE_ROWS", "PICKED", "REGION_COLUMNS"];
            let mut variant = Variant { subgroup: None, network: None, counts: Vec::new(), ..variant.clone() };
            variant.constants.retain(|(name, _)| !derived.contains(name));
            variant.overrides.retain(|(name, _)| *name != "TAKEN");
            variant.key()
        };
        let mut with_subgroups = 0;
        for shader in shaders() {
            let of = |size| sized(&shader, Some(size)).into_iter().map(plain).collect::<Vec<_>>();
            let first = of(SUBGROUPS[0]);
            with_subgroups += usize::from(!first.is_empty());
            for size in SUBGROUPS {
                assert!(first == of(size), "{}: another order for {size}", shader.pass.name);
            }
        }
        assert!(with_subgroups > 10, "{with_subgroups}");
    }

    #[test]
    fn a_pipeline_is_rebuilt_for_other_lanes() {
        let shaders = shaders();
        let place = shaders.iter().position(|shader| shader.pass.name == "radix/scatter").expect("it sorts");
        let made = PipelineSource {
            label: "radix/scatter",
            pass: "radix/scatter",
            stem: "radix/scatter",
            variant: sized(&shaders[place], Some(8))[0].clone(),
            outputs: None,
        };
        let found = recorded(&shaders, &made).expect("listed");
        let (shader, variant, outputs) = found.rebuilt(&shaders, 32);
        assert_eq!((shader.pass.name, variant.subgroup, outputs), ("radix/scatter", Some(32), None));
        let (_, same, _) = found.rebuilt(&shaders, 8);
        assert_eq!(same, made.variant);
        let made_up = PipelineSource { variant: made.variant.clone().with("NOWHERE", 1), ..made };
        assert!(recorded(&shaders, &made_up).is_err());
    }
}
