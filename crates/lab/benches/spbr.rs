//! Speed of drawing ensembles of points, against the same points in the rasterizer.
//!
//! ```sh
//! cargo bench --bench spbr                          # 10 million points
//! cargo bench --bench spbr -- --points 1000000      # others
//! PELLUCID_BENCH_FRAMES=20 cargo bench --bench spbr # frames behind every median, 5 without it
//! ```
//!
//! How to read it. The first line is the rasterizer's: each point a quad of one pixel (two triangles, since WGSL knows
//! no size of points), its nearest found by the atomic minimum that `squares` takes too. Then the ensembles of the
//! same points, each once in an ensemble (k = 1): `draw` is the time of the passes over points, `Mpoints/s` slots over
//! that, `/ hardware` the ratio of both rates; `rest` is the share of everything else in the frame: clearing,
//! resolving, reading back. All times are the device's. Where the camera is perspective, half of the points are wider
//! than a pixel.

mod common;

use std::process::ExitCode;
use std::sync::Arc;

use comfy_table::{CellAlignment, Table, presets};
use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::opaque::Nearest;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_engine::passes::bands::Band;
use pellucid_engine::passes::project::{DeviceCloud, Footprint, Projecting};
use pellucid_engine::passes::raster::{self, Chunk, Walker};
use pellucid_engine::passes::tiles::Tiles;
use pellucid_gpu::{Buffer, Device, DeviceOptions, Memory};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::prepare::ensembles::{CloudSurface, Dealt};
use pellucid_scene::{Method, Spbr, SpbrSimplified};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Width and height of the image.
const SIDE: u32 = 1024;
const ENSEMBLES: [u32; 4] = [1, 10, 100, 1000];
/// Points of the rasterizer's part at most.
const MOST_QUADS: usize = 2_000_000;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let given = arguments.iter().position(|argument| argument == "--points").and_then(|i| arguments.get(i + 1));
    let points = given.and_then(|count| count.parse().ok()).unwrap_or(10_000_000);
    common::measure(|| run(points))
}

fn run(count: usize) -> Result<()> {
    let device = Device::open(&DeviceOptions::from_env())?;
    println!("{} ({}), pellucid {}", device.info().name, device.info().driver, env!("CARGO_PKG_VERSION"));
    let frames = std::env::var("PELLUCID_BENCH_FRAMES").ok().and_then(|n| n.parse().ok()).unwrap_or(5);
    let hardware = hardware(&device, count.min(MOST_QUADS), frames)?;
    println!("rasterizer, quads of one pixel: {:.1} Mpoints/s", hardware / 1e6);

    let dealt = dealt(count);
    let mut renderer = Renderer::new(&device)?;
    let mut cloud = renderer.upload(&Arranged::Dealt(dealt))?;
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["method", "camera", "L", "draw ms", "Mpoints/s", "/ hardware", "frame ms", "rest"]);
    for perspective in [false, true] {
        for ensembles in ENSEMBLES {
            for method in methods(ensembles) {
                let frame = frame(method, perspective);
                let found = measured(&mut renderer, &mut cloud, &frame, frames)?;
                let rate = found.slots as f64 / found.draw * 1e3;
                table.add_row([
                    method.name().to_owned(),
                    if perspective { "perspective" } else { "orthographic" }.to_owned(),
                    ensembles.to_string(),
                    format!("{:.1}", found.draw),
                    format!("{:.1}", rate / 1e6),
                    format!("{:.1}", rate / hardware),
                    format!("{:.1}", found.frame),
                    format!("{:.0}%", 100.0 * (1.0 - found.draw / found.frame)),
                ]);
            }
        }
    }
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    println!("{table}");
    Ok(())
}

/// Returns both methods; the opacity of the points in [`dealt`] makes k = 1 for L = 100.
fn methods(ensembles: u32) -> [Method; 2] {
    [
        Method::SpbrSimplified(SpbrSimplified { ensembles, ..SpbrSimplified::default() }),
        Method::Spbr(Spbr { ensembles, ..Spbr::default() }),
    ]
}

/// Medians of some frames.
struct FrameMedians {
    slots: u64,
    draw: f64,
    frame: f64,
}

fn measured(renderer: &mut Renderer, cloud: &mut DeviceCloud, frame: &Frame, frames: usize) -> Result<FrameMedians> {
    // The first one compiles.
    let slots = renderer.render(cloud, frame)?.facts.slots;
    let (mut draws, mut all) = (Vec::new(), Vec::new());
    for _ in 0..frames {
        let rendered = renderer.render(cloud, frame)?;
        draws.push(milliseconds(&rendered, |name| {
            name != "spbr/resolve" && name != "spbr/clear" && name.starts_with("spbr/")
        }));
        all.push(milliseconds(&rendered, |_| true));
        renderer.recycle(rendered.image);
    }
    Ok(FrameMedians { slots, draw: median(&mut draws), frame: median(&mut all) })
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Device time of some passes of a frame.
fn milliseconds(rendered: &Rendered, wanted: impl Fn(&str) -> bool) -> f64 {
    rendered.profile.passes.iter().filter(|p| wanted(p.name)).map(|p| p.gpu.as_secs_f64() * 1e3).sum()
}

/// Points per second of the rasterizer.
fn hardware(device: &Device, count: usize, frames: usize) -> Result<f64> {
    let mut cloud = DeviceCloud::new(device, &points(count))?;
    let how = Projecting::plain(Footprint::Point);
    let window = [0, 0, SIDE, SIDE];
    cloud.set_view(&frame(Method::Points, false).camera, [SIDE; 2], window, &how);
    let mut recorder = device.recorder()?;
    cloud.record_project(&mut recorder, &how)?;
    recorder.submit("project/splats")?;
    let stats = cloud.stats();
    let mut tiles = Tiles::new(device)?;
    tiles.reserve(device, &stats)?;
    let nearest: Buffer<u64> = device.buffer("nearest", u64::from(SIDE) * u64::from(SIDE), Memory::Device)?;
    let (cloud, footprint, walker) = (&cloud, Footprint::Point, Walker::Hardware);
    let raster = raster::Raster { cloud, stats: &stats, tiles: &tiles, walker, footprint, window };
    let mut times = Vec::new();
    for _ in 0..=frames {
        let mut recorder = device.recorder()?;
        recorder.fill("project/clear", nearest.all(), u32::MAX)?;
        raster.record(&mut recorder, &Band::whole(window, 0), |chunk: Chunk<'_>| Nearest {
            chunk,
            nearest: nearest.all(),
        })?;
        let passes = recorder.submit("opaque/nearest")?.passes;
        times.push(passes.iter().filter(|p| p.name == "opaque/nearest").map(|p| p.gpu.as_secs_f64()).sum());
    }
    Ok(count as f64 / median(&mut times[1..]))
}

/// Random points over the whole image at random depths; a world unit is a pixel.
fn points(count: usize) -> Points {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let half = 0.5 * f64::from(SIDE);
    let mut place = || DVec3::from_array([half, half, 0.25 * half].map(|side| random.random_range(-side..side)));
    let positions: Vec<DVec3> = (0..count).map(|_| place()).collect();
    let color = |p: &DVec3| (p.as_vec3() / (2.0 * half as f32) + 0.5).clamp(Vec3::ZERO, Vec3::ONE);
    Points {
        colors: positions.iter().map(color).collect(),
        positions,
        opacities: vec![0.095_162_6; count],
        radii: vec![0.0; count],
        ..Points::default()
    }
}

/// Makes the points with a density that asks for each point once: 1 - exp(-0.1) is their opacity.
fn dealt(count: usize) -> Dealt {
    let points = points(count);
    let surface =
        CloudSurface { points: 0..count as u64, center: DVec3::ZERO, density: 10.0, opacity: points.opacities[0] };
    Dealt { points: Arc::new(points), surfaces: vec![surface] }
}

fn frame(method: Method, perspective: bool) -> Frame {
    let side = f64::from(SIDE);
    let projection = if perspective {
        Projection::Perspective { fov_y: 2.0 * 0.25f64.atan() }
    } else {
        Projection::Orthographic { height: side }
    };
    let camera = Camera::look_at(DVec3::Z * 2.0 * side, DVec3::ZERO, DVec3::Y, projection, 0.5 * side, 4.0 * side);
    Frame::new(camera.expect("Y is not along the view"), [SIDE; 2], method)
}
