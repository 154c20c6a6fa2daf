//! The table's data sets, with a camera and a light.

use std::path::{Path, PathBuf};

use pellucid_core::camera::Camera;
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_io as io;
use pellucid_scene::procedural::{self, Generated, iso};
use pellucid_scene::{self as scene, Light, Overrides, Scene, Shading, ShadingModel};

use crate::table::COLUMNS;

pub const TORI: &str = "tori";
/// Data sets, in the order of the paper's table.
pub const NAMES: [&str; 6] = ["blade", "buddha", "dragon", TORI, "neghip", "hydrogen"];

/// Points of what is generated, in the paper.
const TORI_POINTS: f64 = 6e6;
const NEGHIP_POINTS: f64 = 128e3;
const HYDROGEN_POINTS: f64 = 535e3;

/// Frames per second at 512² and at 1024².
type Rates = [[f64; COLUMNS]; 2];
/// A scanned surface: name, files of the data folder, of which the first that is there counts, points and rates in the
/// paper.
type Scan = (&'static str, &'static [&'static str], u32, Rates);

const SCANS: [Scan; 3] = [
    ("blade", &["models/turbine_blade_883k.ply", "models/turbine_blade_100k.ply"], 883_000, BLADE),
    ("buddha", &["models/happy_buddha_543k.ply", "models/happy_vrip.ply"], 543_000, BUDDHA),
    ("dragon", &["models/stanford_dragon_437k.ply"], 437_000, DRAGON),
];

// Table 3.
const BLADE: Rates = [[52.0, 17.6, 8.8, 26.0, 9.0, 5.0], [52.0, 17.5, 8.8, 25.0, 9.0, 5.0]];
const BUDDHA: Rates = [[83.0, 28.0, 14.0, 40.0, 14.0, 7.0], [64.0, 22.0, 11.0, 39.0, 14.0, 7.0]];
const DRAGON: Rates = [[103.0, 35.0, 18.0, 50.0, 18.0, 9.6], [68.0, 23.0, 12.0, 49.0, 17.0, 9.0]];
const THREE_TORI: Rates = [[8.0, 2.7, 1.4, 4.0, 1.3, 0.6], [8.0, 2.7, 1.4, 3.7, 1.1, 0.6]];
const NEGHIP: Rates = [[235.0, 83.0, 43.0, 145.0, 62.0, 35.0], [82.0, 27.0, 14.0, 64.0, 35.0, 22.0]];
const HYDROGEN: Rates = [[72.0, 24.0, 12.0, 40.0, 14.0, 8.0], [48.0, 15.0, 8.0, 31.0, 14.0, 7.5]];

/// A cloud as it is rendered.
pub struct Subject {
    pub name: &'static str,
    pub points: Points,
    pub camera: Camera,
    pub shading: Shading,
    /// The paper's.
    pub paper: Rates,
}

/// Folder of real data: `PELLUCID_TEST_DATA`, else `shared/data` beside the repository, as for the tests.
pub fn data() -> PathBuf {
    let named = std::env::var_os("PELLUCID_TEST_DATA").map(PathBuf::from);
    named.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"))
}

/// A data set, or why it is left out.
pub enum Loaded {
    Subject(Box<Subject>),
    Missing(String),
}

impl Loaded {
    fn missing(name: &str, points: impl std::fmt::Display, files: &[&str]) -> Self {
        let files = files.join(" or ");
        Self::Missing(format!("{name} ({points} points in the paper): no file {files} in {}", data().display()))
    }
}

/// A data set from a folder. `scale` multiplies the points of generated ones.
pub fn load(name: &'static str, folder: &Path, scale: f64, seed: u64) -> Result<Loaded> {
    let points = |count: f64| vec![("points".to_owned(), (scale * count).round().max(100.0))];
    if let Some((_, files, count, paper)) = SCANS.iter().find(|(scan, ..)| *scan == name) {
        let Some(path) = files.iter().map(|file| folder.join(file)).find(|path| path.is_file()) else {
            return Ok(Loaded::missing(name, count, files));
        };
        let scene = Scene::from_clouds(&[path], &Overrides::default())?;
        let clouds = scene::load_clouds(&scene, &Progress::hidden())?;
        return Ok(Loaded::Subject(Box::new(subject(name, &scene, clouds, *paper)?)));
    }
    match name {
        TORI => {
            let made = procedural::build("tori", &points(TORI_POINTS), seed).map_err(scene::Error::from)?;
            generated(name, &made, THREE_TORI)
        }
        "neghip" => {
            let parameters = [points(NEGHIP_POINTS), vec![("surfaces".to_owned(), 1.0)]].concat();
            let file = "volumes/neghip_64x64x64_uint8.raw";
            surfaces(name, (folder, file, NEGHIP_POINTS), &parameters, seed, NEGHIP)
        }
        _ => {
            let file = "volumes/hydrogen_64x64x64_float32.raw";
            surfaces(name, (folder, file, HYDROGEN_POINTS), &points(HYDROGEN_POINTS), seed, HYDROGEN)
        }
    }
}

fn surfaces(
    name: &'static str,
    (folder, file, points): (&Path, &str, f64),
    parameters: &[(String, f64)],
    seed: u64,
    paper: [[f64; COLUMNS]; 2],
) -> Result<Loaded> {
    let path = folder.join(file);
    if !path.is_file() {
        return Ok(Loaded::missing(name, points, &[file]));
    }
    let volume = io::volume::read(&path, None, None)?;
    let made = iso::build_iso(&volume, &[], parameters, seed).map_err(scene::Error::from)?;
    generated(name, &made, paper)
}

fn generated(name: &'static str, made: &Generated, paper: [[f64; COLUMNS]; 2]) -> Result<Loaded> {
    let scene = Scene::from_toml(&made.scene_toml, Path::new(name))?;
    let clouds = scene::take_generated(&scene, made)?;
    Ok(Loaded::Subject(Box::new(subject(name, &scene, clouds, paper)?)))
}

/// Makes a subject with Phong shading and a light from above that casts shadows, if it is asked for some.
fn subject(name: &'static str, scene: &Scene, clouds: Vec<Cloud>, paper: [[f64; COLUMNS]; 2]) -> Result<Subject> {
    let up = scene::up_axis(&clouds);
    let points = scene::assemble(scene, clouds, false, &Progress::hidden())?;
    let (camera, _) = scene::camera(scene, &points, up)?;
    let light = Light::Direction(camera.forward - 0.6 * camera.up + 0.4 * camera.right);
    let shading = Shading { model: ShadingModel::Phong, specular: 0.2, light, ..Shading::default() };
    Ok(Subject { name, points, camera, shading, paper })
}
