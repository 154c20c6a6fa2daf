//! The scenes.

use std::path::{Path, PathBuf};

use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::Frame;
use pellucid_scene::{self as scene, Method, OneLayer, Overrides, Scene, Soft, procedural};

/// Name, points, field of all clouds.
type Builtin = (&'static str, f64, &'static str);

const BUILTINS: [Builtin; 3] = [
    ("garden", 500_000.0, "uncertainty"),
    ("tori", 600_000.0, "distance-to-axis"),
    ("volume", 200_000.0, "distance-to-axis"),
];

/// Sides of the images in pixels, which a CPU driver gets through in minutes, path and all.
const SIZE: [f64; 2] = [640.0, 480.0];

/// A scene with the settings of its soft points.
pub struct SoftScene {
    pub name: String,
    pub points: Points,
    /// Frame of method `soft-express`.
    pub frame: Frame,
    pub soft: Soft,
}

impl SoftScene {
    /// The one layer of the same points, as opaque as the soft ones are at most.
    pub fn one_layer(&self) -> Method {
        let softness = OneLayer::default().softness;
        Method::OneLayer(OneLayer { threshold: self.soft.threshold, softness })
    }

    fn new(name: String, scene: &Scene, clouds: Vec<Cloud>) -> Result<Self> {
        let up = scene::up_axis(&clouds);
        let points = scene::assemble(scene, clouds, true, &Progress::hidden())?;
        let (camera, _) = scene::camera(scene, &points, up)?;
        let given = scene.method.fixed().and_then(Method::soft).copied().unwrap_or_default();
        let is_default = given == Soft::default();
        let soft = if is_default { Soft { threshold: middle(&points.fields), ..given } } else { given };
        let frame = Frame {
            shading: scene.shading,
            color: scene.image.color_space(),
            ..Frame::new(camera, scene.image.size, Method::SoftExpress(soft))
        };
        let count = points.fields.iter().filter(|field| **field > soft.threshold).count();
        println!("\n== {name}: {} points, {count} of them soft (threshold {})", points.len(), soft.threshold);
        Ok(Self { name, points, frame, soft })
    }
}

/// The built-in scenes at a scale, then others.
pub fn all(inputs: &[PathBuf], scale: f64) -> impl Iterator<Item = Result<SoftScene>> {
    BUILTINS.iter().map(move |given| builtin(given, scale)).chain(inputs.iter().map(|path| from_path(path)))
}

fn builtin((name, points, field): &Builtin, scale: f64) -> Result<SoftScene> {
    let [width, height] = SIZE.map(|side| (side * scale).round());
    let size = format!("[{width}, {height}]");
    let overrides = overrides(&[("cloud.*.field", *field), ("image.size", &size)])?;
    let parameters = [("points".to_owned(), (points * scale).round())];
    let generated = procedural::build(name, &parameters, 0).map_err(scene::Error::from)?;
    let scene = Scene::from_toml_with(&generated.scene_toml, name.as_ref(), &overrides)?;
    let clouds = scene::take_generated(&scene, &generated)?;
    SoftScene::new((*name).to_owned(), &scene, clouds)
}

fn from_path(path: &Path) -> Result<SoftScene> {
    let scene = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        Scene::read(path, &Overrides::default())?
    } else {
        Scene::from_clouds(&[path.to_owned()], &overrides(&[])?)?
    };
    let clouds = scene::load_clouds(&scene, &Progress::hidden())?;
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    SoftScene::new(name, &scene, clouds)
}

/// Overrides that choose a soft method, so that fields are found.
fn overrides(keys: &[(&str, &str)]) -> Result<Overrides> {
    let mut overrides = Overrides::default();
    overrides.set("soft-experiments", "method.name", "soft-express")?;
    keys.iter().try_for_each(|(key, value)| overrides.set("soft-experiments", key, value))?;
    Ok(overrides)
}

/// The median field, but below 1, so that something is soft.
fn middle(fields: &[f32]) -> f32 {
    let mut sorted = fields.to_vec();
    sorted.sort_by(f32::total_cmp);
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or_default();
    let most = sorted.last().copied().unwrap_or_default();
    if median < most { median } else { Soft::default().threshold }
}
