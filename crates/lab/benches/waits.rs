//! Cost of waiting for counts and of timing passes, per frame.
//!
//! ```sh
//! cargo bench --bench waits                            # random discs in two sizes of image, every method
//! PELLUCID_BENCH_FRAMES=100 cargo bench --bench waits  # frames behind every median, 30 without it
//! ```
//!
//! How to read it. Three renderers take turns, frame by frame: one waits for each count and times its passes, as the
//! first frame of a command does; one predicts its counts and times; one predicts and doesn't time. Times are medians
//! of whole frames, with the image on the host; the last two columns are medians of the ratios of frames that followed
//! one another. Below 1 the way to the right is faster. On a CPU driver a wait is a thread's sleep; on a GPU it drains
//! the device.

mod common;

use std::process::ExitCode;
use std::time::Instant;

use comfy_table::{CellAlignment, Table, presets};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Renderer};
use pellucid_engine::profile::median;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_scene::{self as scene, Method, Overrides, Scene, procedural};

/// Layers of the scene `volume`, and sides of the image.
const SIZES: [(f64, u32); 2] = [(2.0, 96), (8.0, 384)];

fn main() -> ExitCode {
    common::measure(run)
}

fn run() -> Result<()> {
    let frames = std::env::var("PELLUCID_BENCH_FRAMES").ok().and_then(|text| text.parse().ok()).unwrap_or(30);
    let device = Device::open(&DeviceOptions::from_env())?;
    println!("{} ({})", device.info().name, device.info().driver);
    for (layers, side) in SIZES {
        let overrides = Overrides::default();
        let generated = procedural::build("volume", &[("layers".to_owned(), layers)], 0).map_err(scene::Error::from)?;
        let scene = Scene::from_toml_with(&generated.scene_toml, "volume".as_ref(), &overrides)?;
        let clouds = scene::take_generated(&scene, &generated)?;
        let up = scene::up_axis(&clouds);
        let points = scene::assemble(&scene, clouds, true, &Progress::hidden())?;
        let (camera, _) = scene::camera(&scene, &points, up)?;
        println!("\n== {} discs, {side} × {side} pixels, medians of {frames} frames", points.len());
        let mut table = Table::new();
        table.load_style(presets::UTF8_HORIZONTAL_ONLY);
        table.set_header(["method", "waiting ms", "waits", "foreseen ms", "waits", "plain ms", "f / w", "plain / f"]);
        for method in Method::all().into_iter().filter(|method| !method.is_dealt()) {
            let frame = Frame { camera, size: [side; 2], method, ..Frame::of_scene(&scene, camera, 0) };
            let Some(rounds) = rounds(&device, &points, &frame, frames)? else { continue };
            let of = |value: &dyn Fn(&[FrameWaits; 3]) -> f64| median(rounds.iter().map(value).collect());
            let [waiting, foreseen, plain] = [0, 1, 2].map(|way| format!("{:.2}", of(&|round| round[way].ms)));
            let [waits, once] = [0, 1].map(|way| of(&|round| round[way].waits as f64).to_string());
            let [saved, untimed] = [1, 2].map(|way| format!("{:.3}", of(&|round| round[way].ms / round[way - 1].ms)));
            table.add_row([method.name().to_owned(), waiting, waits, foreseen, once, plain, saved, untimed]);
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        println!("{table}");
    }
    Ok(())
}

/// A frame.
struct FrameWaits {
    ms: f64,
    waits: u64,
}

/// Frames by three renderers that take turns; `None` if the device cannot render the method.
fn rounds(device: &Device, points: &Points, frame: &Frame, frames: usize) -> Result<Option<Vec<[FrameWaits; 3]>>> {
    let way = || -> Result<_> {
        let renderer = Renderer::new(device)?;
        let cloud = renderer.upload(points)?;
        Ok((renderer, cloud))
    };
    let mut ways = [way()?, way()?, way()?];
    ways[2].0.timed = false;
    let mut rounds = Vec::with_capacity(frames);
    // The first frames pay for pipelines, buffers and foresight.
    for number in 0..frames + 3 {
        let mut round = Vec::with_capacity(3);
        for (way, (renderer, cloud)) in ways.iter_mut().enumerate() {
            if way == 0 {
                renderer.forget();
            }
            let begin = Instant::now();
            let rendered = match renderer.render(cloud, frame) {
                Ok(rendered) => rendered,
                Err(error) if error.is_refusal() => {
                    println!("{}: {error}", frame.method.name());
                    return Ok(None);
                }
                Err(error) => return Err(error.into()),
            };
            round.push(FrameWaits { ms: begin.elapsed().as_secs_f64() * 1e3, waits: rendered.profile.waits });
            renderer.recycle(rendered.image);
        }
        if let (true, Ok(round)) = (number >= 3, round.try_into()) {
            rounds.push(round);
        }
    }
    Ok(Some(rounds))
}
