//! Measures which method is the fastest, by the mean length of lists and the wanted error: every setting of every
//! method on a few scenes. Writes docs/which-method.md.
//!
//! ```sh
//! cargo run --release --example study -- -o tools/study/measured --data ../shared/data          # measures
//! cargo run --release --example study -- --page docs/which-method.md
//! cargo run --release --example study -- -o DIR --only tori --means 5,50 --budget-minutes 4     # a part of it
//! ```
//!
//! Each driver has a file of lines in the folder, to which a line is added for every setting. What is there isn't
//! measured again: a run that was ended goes on where it was. `VK_DRIVER_FILES` picks the driver. Without `--data`, or
//! where a file is missing, the scenes of real data are left out with a note. A page needs no device.

mod figure;
mod map;
mod measure;
mod page;
mod rows;
mod scenes;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use clap::builder::PossibleValuesParser;
use pellucid_io::output::Error;

/// Folder of this project's measurements, from its root.
const MEASURED: &str = "tools/study/measured";

#[derive(Debug, Parser)]
struct Args {
    /// Measures; the folder for a file of this driver, created if it isn't there.
    #[arg(short, long, value_name = "DIR", required_unless_present = "page")]
    output: Option<PathBuf>,
    /// Only this scene; repeatable.
    #[arg(long, value_name = "SCENE", value_parser = PossibleValuesParser::new(scenes::names()))]
    only: Vec<String>,
    /// Size of the images, in pixels.
    #[arg(long, value_name = "WxH", default_value = "320x240", value_parser = size)]
    size: [u32; 2],
    /// Wanted mean lists of the covered pixels.
    #[arg(long, value_delimiter = ',', default_value = "5,15,50,150,500", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    means: Vec<u32>,
    /// Frames behind a median: at most so many, of 2 s.
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u64).range(1..=1000))]
    frames: u64,
    /// Milliseconds of frames before those: clocks of GPUs take a while to rise.
    #[arg(long, default_value_t = 300, value_parser = clap::value_parser!(u64).range(..=10_000))]
    warm_up_ms: u64,
    /// Ends after about so many minutes, which all scenes and means share; what is missing is measured by the next run.
    #[arg(long, value_name = "N", value_parser = minutes)]
    budget_minutes: Option<f64>,
    /// The folder of real data: scenes of files are left out without it.
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// Writes the page, and its figures to images/which-method beside it, from all files of DIR, or of
    /// tools/study/measured.
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT from 1x1 to 16384x16384, as in 320x240".to_owned())
}

fn minutes(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|minutes| (0.0..=1e6).contains(minutes));
    number.ok_or_else(|| "expected a number of minutes, as in 4 or 0.5".to_owned())
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

fn run(args: &Args) -> pellucid_engine::Result<()> {
    if let Some(folder) = &args.output {
        measure::run(args, folder)?;
    }
    let Some(path) = &args.page else { return Ok(()) };
    let studies = rows::read_all(args.output.as_deref().unwrap_or(Path::new(MEASURED)))?;
    let figures = path.parent().unwrap_or(Path::new("")).join(page::FIGURES);
    std::fs::create_dir_all(&figures).map_err(|source| Error::Write { path: figures.clone(), source })?;
    for (name, svg) in page::figures(&studies) {
        write(&figures.join(name), &svg)?;
    }
    write(path, &page::text(&studies))
}

fn write(path: &Path, text: &str) -> pellucid_engine::Result<()> {
    Ok(std::fs::write(path, text).map_err(|source| Error::Write { path: path.to_owned(), source })?)
}
