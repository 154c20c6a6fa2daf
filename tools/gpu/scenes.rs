//! Scenes that rows are measured on, and which methods and sizes each has.

use std::path::PathBuf;

use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::Frame;
use pellucid_lab::check::MethodScene;
use pellucid_scene::{self as scene, Method, Overrides, Scene, procedural};

/// Source of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// A built-in scene with these parameters.
    BuiltIn(&'static str, &'static [(&'static str, f64)]),
    /// A file, from the root of the repository.
    File(&'static str),
}

/// A scene in one size, with the methods by which it is rendered.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Name in the rows.
    pub scene: &'static str,
    pub source: Source,
    pub size: [u32; 2],
    pub methods: &'static [&'static str],
}

/// Methods of each kind, in order of value.
const MAIN: [&str; 10] =
    ["sorted", "abuffer", "weighted", "peel", "spbr", "stochastic", "points", "hybrid", "mlab", "moments"];
const LISTS: [&str; 5] = ["sorted", "abuffer", "weighted", "linked-list", "peel"];
const GAUSSIANS: [&str; 4] = ["sorted", "abuffer", "weighted", "stochastic"];
const OPAQUE: [&str; 3] = ["points", "circles", "hqs"];
/// All the others, of the garden alone.
const OTHERS: [&str; 18] = [
    "linked-list",
    "average",
    "unsorted",
    "wavelet",
    "circles",
    "paraboloid",
    "splats",
    "hqs",
    "image-space",
    "peel-layers",
    "spbr-simplified",
    "one-layer",
    "cone",
    "sphere",
    "squares",
    "soft-base",
    "soft-concentric",
    "soft-express",
];

const HD: [u32; 2] = [1280, 720];
const FULL_HD: [u32; 2] = [1920, 1080];
const SQUARE: [u32; 2] = [1024, 1024];
const FOUR_K: [u32; 2] = [3840, 2160];

const GARDEN: Source = Source::BuiltIn("garden", &[]);
const SOUP: Source = Source::File("tests/data/splats/soup.ply");

/// Everything, in order of value: the time may be short.
pub const ALL: [Plan; 14] = [
    Plan { scene: "garden", source: GARDEN, size: FULL_HD, methods: &MAIN },
    plan("volume-32", Source::BuiltIn("volume", &[("layers", 32.0)]), SQUARE, &LISTS),
    plan("volume-128", Source::BuiltIn("volume", &[("layers", 128.0)]), SQUARE, &LISTS),
    plan("volume-512", Source::BuiltIn("volume", &[("layers", 512.0)]), SQUARE, &LISTS),
    // Frames of 5 and 50 splats: their cost without any work.
    plan("stack-5", Source::BuiltIn("stack", &[("layers", 5.0)]), HD, &LISTS),
    plan("stack-50", Source::BuiltIn("stack", &[("layers", 50.0)]), HD, &LISTS),
    plan("soup", SOUP, HD, &GAUSSIANS),
    plan("tori", Source::BuiltIn("tori", &[]), FULL_HD, &LISTS),
    plan("garden", GARDEN, FOUR_K, &MAIN),
    plan("garden", GARDEN, FULL_HD, &OTHERS),
    plan("garden-3M", Source::BuiltIn("garden", &[("points", 3e6)]), FULL_HD, &["sorted", "abuffer", "points"]),
    plan("plane-5M", Source::BuiltIn("plane", &[("points", 5e6)]), FULL_HD, &OPAQUE),
    plan("garden", GARDEN, HD, &LISTS),
    plan("soup", SOUP, FOUR_K, &GAUSSIANS),
];

/// A little of everything, for a driver on a CPU.
pub const QUICK: [Plan; 3] = [
    plan("garden", Source::BuiltIn("garden", &[("points", 5000.0)]), [96, 64], &MAIN),
    plan("stack-5", Source::BuiltIn("stack", &[("layers", 5.0), ("size", 64.0)]), [64, 64], &["sorted", "abuffer"]),
    plan("soup", SOUP, [64, 64], &["sorted"]),
];

const fn plan(scene: &'static str, source: Source, size: [u32; 2], methods: &'static [&'static str]) -> Plan {
    Plan { scene, source, size, methods }
}

/// A scene that is loaded: its points and a frame of it.
pub struct Loaded {
    pub source: Source,
    scene: MethodScene,
}

impl Loaded {
    /// Loads a scene.
    pub fn new(plan: &Plan) -> Result<Self> {
        let progress = Progress::hidden();
        let mut overrides = Overrides::default();
        overrides.set("gpu-table", "image.size", &format!("[{}, {}]", plan.size[0], plan.size[1]))?;
        overrides.set("gpu-table", "method.name", "abuffer")?;
        let (scene, clouds) = match plan.source {
            Source::File(path) => {
                let scene = Scene::from_clouds(&[PathBuf::from(path)], &overrides)?;
                let clouds = scene::load_clouds(&scene, &progress)?;
                (scene, clouds)
            }
            Source::BuiltIn(name, parameters) => {
                let parameters: Vec<_> = parameters.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect();
                let made = procedural::build(name, &parameters, 0).map_err(scene::Error::from)?;
                let scene = Scene::from_toml_with(&made.scene_toml, name.as_ref(), &overrides)?;
                let clouds = scene::take_generated(&scene, &made)?;
                (scene, clouds)
            }
        };
        let up = scene::up_axis(&clouds);
        let points = scene::assemble(&scene, clouds, true, &progress)?;
        let (camera, _) = scene::camera(&scene, &points, up)?;
        // Methods have neither of these in common.
        let mut frame = Frame { shadows: None, ..Frame::of_scene(&scene, camera, 0) };
        frame.shading.edl.edl = false;
        let name = plan.scene.to_owned();
        let scene = MethodScene { name, clouds: vec![points], choice: scene.method, frame };
        Ok(Self { source: plan.source, scene })
    }

    /// The scene for a method with its default settings, in a size.
    pub fn with(&self, method: Method, size: [u32; 2]) -> MethodScene {
        MethodScene { frame: Frame { method, size, ..self.scene.frame }, ..self.scene.clone() }
    }
}

/// A method of this name, with its default settings.
pub fn method(name: &str) -> Option<Method> {
    Method::all().into_iter().find(|method| method.name() == name)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn all_methods_are_measured_once_in_a_scene_and_size() {
        let rows = || ALL.iter().flat_map(|plan| plan.methods.iter().map(move |name| (plan.scene, plan.size, *name)));
        assert_eq!(rows().collect::<BTreeSet<_>>().len(), rows().count());
        let measured: BTreeSet<&str> = rows().map(|(_, _, name)| name).collect();
        let all: BTreeSet<&str> = Method::all().iter().map(Method::name).collect();
        assert_eq!(measured, all);
    }

    #[test]
    fn measure_sh_knows_the_number_of_quick_rows() {
        let rows: usize = QUICK.iter().map(|plan| plan.methods.len()).sum();
        assert!(include_str!("measure.sh").contains(&format!("quick_rows={rows}\n")), "{rows} rows");
    }
}
