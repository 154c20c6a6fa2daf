//! Time and memory over the number of points: stores of the built-in landscape of up to a billion points, made and
//! rendered within the same little memory (docs/large-clouds.md).
//!
//! ```sh
//! cargo build --release && cargo run --release --example sizes -- --folder /tmp/sizes
//! ```
//!
//! A billion points take 23 GB of disk. Commands run in processes of their own, one after the other: time is theirs
//! from start to end, memory the most that they had resident, with what a driver without a GPU takes of it for the
//! device. Standard output is Markdown; `time.svg` and `memory.svg` go to `--output`. Stores are kept for the next run
//! unless `--remove` is given.

mod child;
mod figure;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;

use child::{Cost, run};

#[derive(Debug, Parser)]
struct Args {
    /// Folder for stores and pictures; made if it isn't there.
    #[arg(long)]
    folder: PathBuf,
    /// Folder for the figures.
    #[arg(short, long, default_value = "docs/images/large")]
    output: PathBuf,
    /// Numbers of points.
    #[arg(long, value_delimiter = ',', default_value = "1e6,1e7,1e8,1e9")]
    sizes: Vec<f64>,
    /// Methods to render with.
    #[arg(long, value_delimiter = ',', default_value = "points,abuffer,spbr")]
    methods: Vec<String>,
    /// The program.
    #[arg(long, default_value = "target/release/pellucid")]
    program: PathBuf,
    /// Memory of the host for points.
    #[arg(long, default_value = "1GiB")]
    host_memory: String,
    /// Memory of the device.
    #[arg(long, default_value = "1GiB")]
    memory_budget: String,
    /// Removes each store when its pictures are there.
    #[arg(long)]
    remove: bool,
}

/// The command that makes a store.
const MAKES: &str = "scene terrain";

/// Costs of a command at each size.
struct Line {
    name: String,
    costs: Vec<(f64, Cost)>,
}

fn main() -> ExitCode {
    match measure(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(args: &Args) -> Result<(), String> {
    let names = std::iter::once(MAKES).chain(args.methods.iter().map(String::as_str));
    let mut lines: Vec<Line> = names.map(|name| Line { name: name.to_owned(), costs: Vec::new() }).collect();
    for &points in &args.sizes {
        let folder = args.folder.join(format!("{points:e}"));
        for line in &mut lines {
            let arguments = match line.name.as_str() {
                MAKES if folder.join("scene.toml").exists() => continue,
                MAKES => making(args, points, &folder),
                method => rendering(args, method, &folder),
            };
            line.costs.push((points, run(&args.program, &arguments)?));
        }
        if args.remove {
            std::fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        }
    }
    print!("{}", figure::markdown(&lines));
    figure::write(&args.output, &lines)
}

/// Makes a store in a folder.
fn making(args: &Args, points: f64, folder: &Path) -> Vec<OsString> {
    let words = format!("{MAKES} --set points={points} --store --host-memory {} -o", args.host_memory);
    words.split(' ').map(OsString::from).chain([folder.into()]).collect()
}

/// Renders the store of a folder: faint points, whose light no shading changes.
fn rendering(args: &Args, method: &str, folder: &Path) -> Vec<OsString> {
    let ensembles = if method.starts_with("spbr") { " --set method.ensembles=100" } else { "" };
    let words = format!(
        "render --method {method}{ensembles} --size 1920x1080 --set shading.model=none --set cloud.*.opacity=0.02 \
         --host-memory {} --memory-budget {} -o",
        args.host_memory, args.memory_budget
    );
    let paths = [folder.with_extension(format!("{method}.png")), folder.join("terrain")];
    words.split(' ').map(OsString::from).chain(paths.map(OsString::from)).collect()
}
