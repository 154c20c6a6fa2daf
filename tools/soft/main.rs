//! The experiments of the paper on soft transparency (Seemann et al. 2018, Section 5), and what a frame after a change
//! costs.
//!
//! ```sh
//! cargo run --release --example soft-experiments                             # built-in scenes, into target/soft
//! cargo run --release --example soft-experiments -- -o report vineyard.laz   # your clouds and scenes after these
//! cargo run --release --example soft-experiments -- --frames 20 --path 100   # frames of a median, of the path
//! ```
//!
//! It writes Markdown or SVG for people and CSV for programs:
//!
//! - `table` (Table 1): time of a frame of `splats` of all points (SP), of `one-layer` (OLT) and of `soft-express`
//!   (ST), beside the paper's.
//! - `path-time` and `path-fragments` (Fig. 8): a path around and into the first scene, by SP and the three models.
//! - `second` : frames of the first scene with another threshold, softness, modulation, radius or view, after the cloud
//!   was uploaded once, and the bytes that each of them uploads.
//!
//! How to read it. Every time is the device time of a frame (`second`: the time on the host's clock, so that nothing
//! hides); medians of frames that take turns, so that a machine that slows down slows all. Compare ratios, not times,
//! and run it on a machine that does nothing else. A scene file's soft method keeps its settings; where none is given,
//! the median of the field is the threshold, so that half of the points are soft.

mod path;
mod scenes;
mod second;
mod table;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use pellucid_engine::Result;
use pellucid_engine::methods::{Frame, Rendered, Renderer};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_gpu::{Device, DeviceOptions};
use pellucid_scene::Method;

#[derive(Debug, Parser)]
struct Args {
    /// Folder for what is found; made if it isn't there.
    #[arg(short, long, default_value = "target/soft")]
    output: PathBuf,
    /// Frames behind each median.
    #[arg(long, default_value_t = 7)]
    frames: usize,
    /// Frames of the path.
    #[arg(long, default_value_t = 48)]
    path: usize,
    /// Points of the built-in scenes over their number, and sides of the images over 640 × 480 pixels, from 0.02 to 1.
    #[arg(long, default_value_t = 1.0, value_parser = scale)]
    scale: f64,
    /// Scene files and clouds that are measured after the built-in scenes.
    inputs: Vec<PathBuf>,
}

fn scale(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| (0.02..=1.0).contains(x)).ok_or_else(|| "expected a number from 0.02 to 1".into())
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_status())
        }
    }
}

fn run(args: &Args) -> Result<()> {
    let device = Device::open(&DeviceOptions::from_env())?;
    let machine = format!("{} ({}), pellucid {}", device.info().name, device.info().driver, env!("CARGO_PKG_VERSION"));
    println!("{machine}");
    let failed = |source| pellucid_io::output::Error::Write { path: args.output.clone(), source };
    std::fs::create_dir_all(&args.output).map_err(failed)?;
    let mut rows = Vec::new();
    for (number, scene) in scenes::all(&args.inputs, args.scale).enumerate() {
        let subject = scene?;
        rows.push(table::measure(&device, &subject, args.frames)?);
        table::write(&args.output, &machine, &rows)?;
        if number == 0 {
            path::measure(&device, &subject, args.path, &args.output)?;
            second::measure(&device, &subject, args.frames, &args.output)?;
        }
    }
    println!("\nwritten to {}", args.output.display());
    Ok(())
}

/// Writes a file of the report.
fn write(folder: &Path, name: &str, text: &str) -> Result<()> {
    let path = folder.join(name);
    Ok(std::fs::write(&path, text).map_err(|source| pellucid_io::output::Error::Write { path, source })?)
}

/// A renderer that keeps the buffers of one method, and that method.
struct Contender {
    name: &'static str,
    method: Method,
    renderer: Renderer,
}

impl Contender {
    fn new(device: &Device, name: &'static str, method: Method) -> Result<Self> {
        Ok(Self { name, method, renderer: Renderer::new(device)? })
    }

    /// A frame; its picture is dropped.
    fn render(&mut self, cloud: &mut DeviceCloud, frame: &Frame) -> Result<Rendered> {
        Ok(self.renderer.render(cloud, &Frame { method: self.method, ..*frame })?)
    }
}

fn gpu_ms(rendered: &Rendered) -> f64 {
    rendered.profile.gpu().as_secs_f64() * 1e3
}
