//! Compiles the shaders for a GPU, without a GPU: registers, scratch, occupancy, code size, and an estimate of each
//! pass's time (docs/gpu-shape.md).
//!
//! ```sh
//! cargo run --release --example gpu-shape                       # a table of all pipelines on navi21
//! cargo run --release --example gpu-shape -- --check            # fails beyond tools/gpu_shape/budget.txt
//! cargo run --release --example gpu-shape -- --page docs/gpu-shape.md
//! cargo run --release --example gpu-shape -- --driver radeon_icd.json,mesa25/usr/lib/x86_64-linux-gnu
//! ```
//!
//! Every pipeline that the small scenes of all methods and `pellucid check` create on the device that the environment
//! gives is recorded, with work shaped as a GPU prefers it; for a page those of the built-in scene as well. Mesa's RADV
//! compiles them again for a GPU that is not there: with `RADV_FORCE_FAMILY` it makes a null device, which runs nothing
//! but has the whole compiler (ACO). Debian's `mesa-vulkan-drivers` has RADV.
//!
//! The exit status is 1 if `--check` finds anything, 2 if a pipeline could not be recorded or compiled.

mod budget;
mod compile;
mod estimate;
mod page;
mod record;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

use compile::{Driver, Lanes};

/// GPU family for which the budget holds, and which the table shows.
const FAMILY: &str = "navi21";

#[derive(Debug, Parser)]
struct Args {
    /// RADV's manifest (JSON) and, behind a comma, the folder of libraries that it needs; Debian's own without it.
    #[arg(long, value_name = "MANIFEST[,LIBRARIES]", value_parser = Driver::parse)]
    driver: Option<Driver>,
    /// Compares the pipelines with the budget instead of printing a table.
    #[arg(long)]
    check: bool,
    /// Writes a page with the pipelines of each pass and the estimates of three GPUs.
    #[arg(long, value_name = "FILE", conflicts_with = "check")]
    page: Option<PathBuf>,
    /// Compiles the pipelines of this list and prints what became of them: what the children do.
    #[arg(long, hide = true)]
    compile: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let done = match &args.compile {
        Some(list) => compile::child(list).map(|()| true),
        None => run(&args),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(args: &Args) -> Result<bool, String> {
    let driver = args.driver.clone().unwrap_or_default();
    let mut recorded = record::everything()?;
    if let Some(path) = &args.page {
        let frames = record::frames()?;
        recorded.extend(frames.iter().flat_map(|frame| frame.pipelines.iter().cloned()));
        let recorded = record::distinct(recorded);
        let text = page::text(&driver, &recorded, &frames)?;
        std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))?;
        return Ok(true);
    }
    let recorded = record::distinct(recorded);
    let shapes = compile::on(&driver, FAMILY, Lanes::ThirtyTwo, &recorded)?;
    if args.check {
        let found = budget::beyond(&recorded, &shapes.pipelines)?;
        found.iter().for_each(|line| println!("{line}"));
        println!("{} pipelines on {}: {} beyond the budget", recorded.len(), shapes.device, found.len());
        return Ok(found.is_empty());
    }
    println!("{} pipelines on {}\n", recorded.len(), shapes.device);
    print!("{}", table::markdown(&table::by_label(&recorded, &shapes.pipelines)));
    Ok(true)
}
