//! The cost of frames on the device, pass by pass, as measured by the engine itself.
//!
//! ```sh
//! cargo bench --bench frame                                    # the built-in scenes, then compute against hardware
//! PELLUCID_BENCH=scan.laz:scene.toml cargo bench --bench frame # your clouds (opacity 0.2) and scenes before these
//! PELLUCID_BENCH_FRAMES=20 cargo bench --bench frame           # frames behind every median, 5 without it
//! ```
//!
//! How to read it. Part one prints the table of `pellucid profile`; look at the median and at how far min and max lie
//! from it, and compare only tables of one machine, driver and commit, which the first line names. A pass near 100% of
//! the copy rate is limited by memory. Part two lets the two ways of visiting pixels race on the same random discs. The
//! ratio is hardware / compute: above 1 the compute shaders are faster, below 1 the rasterizer is. `auto / best` says
//! how good the choice of `raster = "auto"` was; 1.1 is 10% slower than the better of the two, and what differs from 1
//! although the choice was right is noise. The three runs alternate and ratios are taken round by round, so that a
//! machine that slows down slows them all. On a CPU driver the rasterizer is software as well: its ratios say nothing
//! about a GPU's.

mod common;

use std::process::{Command, ExitCode};

use comfy_table::{CellAlignment, Table, presets};
use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Cloud;
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::methods::opaque::Nearest;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_engine::passes::bands::Band;
use pellucid_engine::passes::project::{DeviceCloud, Footprint, Projecting};
use pellucid_engine::passes::raster::{self, Chunk, Walker};
use pellucid_engine::passes::tiles::Tiles;
use pellucid_engine::profile::{self, Profile};
use pellucid_engine::{Result, plan};
use pellucid_gpu::{Buffer, Device, DeviceOptions, Memory};
use pellucid_scene::prepare::order;
use pellucid_scene::{self as scene, Discs, Method, Overrides, Raster, Scene, ScreenSplats, procedural};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A built-in scene: name, parameters, keys of the scene file.
type Builtin = (&'static str, &'static [(&'static str, f64)], &'static [(&'static str, &'static str)]);

const BUILTINS: [Builtin; 6] = [
    ("garden", &[], &[]),
    ("tori", &[], &[]),
    ("volume", &[("layers", 32.0)], &[]),
    ("volume", &[("layers", 128.0)], &[]),
    ("stack", &[], &[]),
    ("plane", &[], &[("method.name", "points")]),
];

/// Diameters in pixels of the discs in the race.
const DIAMETERS: [f64; 5] = [1.0, 3.0, 5.0, 15.0, 100.0];
/// Discs in the race, if they are small.
const MOST_DISCS: f64 = 1e6;
/// Fragments in the race: so many fit one binding of 128 MiB, so that every frame has one batch of fragments.
const MOST_FRAGMENTS: f64 = 15e6;
/// Width and height of the race's image.
const SIDE: u32 = 1024;

fn main() -> ExitCode {
    common::measure(run)
}

fn run() -> Result<()> {
    let frames = frame_count()?;
    let device = Device::open(&DeviceOptions::from_env())?;
    let info = device.info();
    println!("{} ({}), pellucid {} {}", info.name, info.driver, env!("CARGO_PKG_VERSION"), commit());
    let copy_rate = profile::copy_rate(&device)?;
    for path in std::env::var_os("PELLUCID_BENCH").iter().flat_map(std::env::split_paths) {
        let mut overrides = Overrides::default();
        let scene = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
            Scene::read(&path, &overrides)?
        } else {
            overrides.set("PELLUCID_BENCH", "cloud.*.opacity", "0.2")?;
            Scene::from_clouds(std::slice::from_ref(&path), &overrides)?
        };
        let clouds = scene::load_clouds(&scene, &Progress::hidden())?;
        println!("\n== {}", path.display());
        print_passes(&device, scene, clouds, frames, copy_rate)?;
    }
    for (name, parameters, keys) in BUILTINS {
        let parameters: Vec<_> = parameters.iter().map(|(key, value)| ((*key).to_owned(), *value)).collect();
        let mut overrides = Overrides::default();
        keys.iter().try_for_each(|(key, value)| overrides.set("bench", key, value))?;
        let generated = procedural::build(name, &parameters, 0).map_err(scene::Error::from)?;
        let scene = Scene::from_toml_with(&generated.scene_toml, name.as_ref(), &overrides)?;
        let clouds = scene::take_generated(&scene, &generated)?;
        let with = parameters.iter().map(|(key, value)| format!(", {key} = {value}")).collect::<String>();
        println!("\n== {name}{with}, {}", scene.method.name());
        print_passes(&device, scene, clouds, frames, copy_rate)?;
    }
    println!("\n== compute against hardware rasterization, medians of {frames} frames");
    race_all(&device, frames)
}

fn frame_count() -> Result<usize> {
    let Ok(text) = std::env::var("PELLUCID_BENCH_FRAMES") else { return Ok(5) };
    let problem = || scene::Error::Usage(format!("PELLUCID_BENCH_FRAMES={text}: expected a number from 1"));
    Ok(text.parse().ok().filter(|n| *n > 0).ok_or_else(problem)?)
}

/// The commit that is measured, if this is a git checkout.
fn commit() -> String {
    let described = Command::new("git").args(["describe", "--always", "--dirty"]).output();
    described.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}

/// Prints the passes of a scene.
fn print_passes(device: &Device, scene: Scene, clouds: Vec<Cloud>, frames: usize, copy_rate: f64) -> Result<()> {
    let up = scene::up_axis(&clouds);
    let points = scene::assemble(&scene, clouds, scene.method.needs_radii(), &Progress::hidden())?;
    let (camera, _) = scene::camera(&scene, &points, up)?;
    let frame = Frame {
        shading: scene.shading,
        color: scene.image.color_space(),
        ..Frame::new(camera, scene.image.size, plan::resolve(scene.method, &points).0)
    };
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(&points)?;
    // The first frame pays for pipelines and buffers.
    let first = renderer.render(&mut cloud, &frame)?;
    renderer.recycle(first.image);
    let mut profile = Profile::new(device, &frame);
    for _ in 0..frames {
        let rendered = renderer.render(&mut cloud, &frame)?;
        profile.add(&rendered);
        renderer.recycle(rendered.image);
    }
    println!("{}", pellucid_lab::profile_table(&profile, Some(copy_rate)));
    Ok(())
}

/// Milliseconds of one contest by rounds (compute, hardware, auto), and what `auto` took.
struct Race {
    rounds: Vec<[f64; 3]>,
    picked: &'static str,
}

impl Race {
    /// Runs the three in turn, `frames` times after a warm-up. `measure` gives milliseconds and who visited the pixels.
    fn run(frames: usize, mut measure: impl FnMut(Raster) -> Result<(f64, &'static str)>) -> Result<Self> {
        let (mut rounds, mut picked) = (Vec::new(), "");
        for round in 0..=frames {
            let (compute, _) = measure(Raster::Compute)?;
            let (hardware, _) = measure(Raster::Hardware)?;
            let (auto, who) = measure(Raster::Auto)?;
            picked = who;
            // The first round pays for pipelines and buffers.
            if round > 0 {
                rounds.push([compute, hardware, auto]);
            }
        }
        Ok(Self { rounds, picked })
    }

    fn median(&self, of: impl Fn(&[f64; 3]) -> f64) -> f64 {
        median(self.rounds.iter().map(of).collect())
    }

    /// Medians; those of ratios are over the ratios of each round.
    fn cells(&self) -> [String; 6] {
        let [compute, hardware, auto] = [0, 1, 2].map(|i| self.median(|round| round[i]));
        let best = usize::from(hardware < compute);
        [
            format!("{compute:.2}"),
            format!("{hardware:.2}"),
            format!("{:.2}", self.median(|round| round[1] / round[0])),
            self.picked.to_owned(),
            format!("{auto:.2}"),
            format!("{:.2}", self.median(|round| round[2] / round[best])),
        ]
    }
}

/// Median of at least one number.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

fn race_all(device: &Device, frames: usize) -> Result<()> {
    if !device.info().fragment_atomics {
        println!("no race: {} has no fragmentStoresAndAtomics", device.info().name);
        return Ok(());
    }
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header([
        "diameter px",
        "discs",
        "fragments",
        "passes",
        "compute ms",
        "hardware ms",
        "hardware / compute",
        "auto took",
        "auto ms",
        "auto / best",
    ]);
    for diameter in DIAMETERS {
        let points = discs(diameter);
        let mut renderer = Renderer::new(device)?;
        let mut cloud = renderer.upload(&points)?;
        let mut fragments = 0;
        let transparent = Race::run(frames, |raster| {
            let method = Method::ABuffer(Discs { raster, ..Discs::default() });
            let rendered = renderer.render(&mut cloud, &frame(method))?;
            fragments = rendered.facts.fragments;
            Ok((milliseconds(&rendered, &["abuffer/count", "abuffer/store"]), rendered.facts.raster))
        })?;
        let mut add = |passes: &str, race: &Race| {
            let row = [format!("{diameter}"), points.len().to_string(), fragments.to_string(), passes.to_owned()];
            table.add_row(row.into_iter().chain(race.cells()));
        };
        add("abuffer/count + store", &transparent);
        if device.info().int64_atomics {
            add("opaque/nearest", &race_opaque(device, &mut renderer, &mut cloud, frames)?);
        }
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("{table}");
    Ok(())
}

/// Random discs over the whole image at random depths; a world unit is a pixel.
fn discs(diameter: f64) -> Points {
    let fragments_each = 0.25 * std::f64::consts::PI * diameter * diameter;
    let count = MOST_DISCS.min(MOST_FRAGMENTS / fragments_each) as usize;
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let half = 0.5 * f64::from(SIDE);
    let mut place = || {
        DVec3::new(random.random_range(-half..half), random.random_range(-half..half), random.random_range(0.0..1.0))
    };
    order::canonical(Points {
        positions: (0..count).map(|_| place()).collect(),
        colors: vec![Vec3::ONE; count],
        opacities: vec![0.2; count],
        radii: vec![0.5 * diameter as f32; count],
        ..Points::default()
    })
}

fn frame(method: Method) -> Frame {
    let projection = Projection::Orthographic { height: SIDE.into() };
    let camera = Camera::look_at(DVec3::new(0.0, 0.0, 2.0), DVec3::ZERO, DVec3::Y, projection, 0.5, 2.5);
    Frame::new(camera.expect("Y is not along the view"), [SIDE; 2], method)
}

/// Device time of some passes of a frame.
fn milliseconds(rendered: &Rendered, passes: &[&str]) -> f64 {
    let passes = rendered.profile.passes.iter().filter(|pass| passes.contains(&pass.name));
    passes.map(|pass| pass.gpu.as_secs_f64() * 1e3).sum()
}

/// The race of opaque splats. Their method always chooses by itself, so that the two ways are recorded here by hand.
fn race_opaque(device: &Device, renderer: &mut Renderer, cloud: &mut DeviceCloud, frames: usize) -> Result<Race> {
    let opaque = ScreenSplats { max_pixel_radius: f32::MAX, ..ScreenSplats::default() };
    let automatic = frame(Method::Circles(opaque));
    let mut course = Course::new(device)?;
    Race::run(frames, |raster| {
        let walker = match raster {
            Raster::Compute => Walker::Compute,
            Raster::Hardware => Walker::Hardware,
            Raster::Auto => {
                let rendered = renderer.render(cloud, &automatic)?;
                return Ok((milliseconds(&rendered, &["opaque/nearest"]), rendered.facts.raster));
            }
        };
        Ok((course.nearest(device, cloud, walker)?, ""))
    })
}

/// The resources of `opaque/nearest` besides the cloud.
struct Course {
    tiles: Tiles,
    nearest: Buffer<u64>,
}

impl Course {
    fn new(device: &Device) -> Result<Self> {
        let pixels = u64::from(SIDE) * u64::from(SIDE);
        Ok(Self { tiles: Tiles::new(device)?, nearest: device.buffer("nearest splats", pixels, Memory::Device)? })
    }

    /// Milliseconds of `opaque/nearest`.
    fn nearest(&mut self, device: &Device, cloud: &mut DeviceCloud, walker: Walker) -> Result<f64> {
        let window = [0, 0, SIDE, SIDE];
        let how = Projecting::plain(Footprint::Disc);
        cloud.set_view(&frame(Method::Points).camera, [SIDE; 2], window, &how);
        let cloud = &*cloud;
        let mut recorder = device.recorder()?;
        cloud.record_project(&mut recorder, &how)?;
        recorder.submit("project/splats")?;

        let stats = cloud.stats();
        self.tiles.reserve(device, &stats)?;
        let raster =
            raster::Raster { cloud, stats: &stats, tiles: &self.tiles, walker, footprint: Footprint::Disc, window };
        let mut recorder = device.recorder()?;
        recorder.fill("project/clear", self.nearest.all(), u32::MAX)?;
        raster.record_tiles(&mut recorder)?;
        raster.record(&mut recorder, &Band::whole(window, 0), |chunk: Chunk<'_>| Nearest {
            chunk,
            nearest: self.nearest.all(),
        })?;
        let passes = recorder.submit("opaque/nearest")?.passes;
        Ok(passes.iter().filter(|pass| pass.name == "opaque/nearest").map(|pass| pass.gpu.as_secs_f64() * 1e3).sum())
    }
}
