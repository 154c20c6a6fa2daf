//! The experiments of the papers on stochastic point-based rendering (Tanaka et al. 2016; Uchida et al. 2020).
//!
//! ```sh
//! cargo run --release --example spbr-experiments                 # a quarter of the papers' sides, into target/spbr
//! cargo run --release --example spbr-experiments -- --scale 1    # their sizes: 8 GB of memory
//! ```
//!
//! Figures, as SVG or PNG for people and as CSV for programs:
//!
//! - `opacity` (Tanaka, Fig. 5): mean and spread of the pixels of a white plane of opacity α, for two numbers of
//!   points.
//! - `noise` (Uchida, Fig. 6): NMSE of a plane with a tenth of its points moved and red, against the plane without
//!   noise, over the number of ensembles.
//! - `outliers` (Uchida, Fig. 10): share of the ensembles in which a pixel that only stray points hit is hit.
//! - `colors` (Uchida, Section 4.2.2): NMSE of a plane and of the garden with noise in the colors of a tenth of the
//!   points.
//! - `choice` (Uchida, Eq. 9): noise of a pixel with as many ensembles as are to bring it below β.
//! - `series` (Uchida, Figs. 8 and 9): pictures of the noisy garden with 1, 10, 50 and 100 ensembles.
//! - `pairs` (Uchida, Figs. 11 to 15): opaque points beside 100 ensembles, of the garden and the landscape.
//! - `tables` (Table 1 of both): α, L, original and adjusted points, k, times, in Markdown too. Points are the papers'
//!   over the same areas; a scene of more than 2·10⁸ of them is left out.
//!
//! `--scale` changes sides of images and with them numbers of points, so that points per pixel, which all of this
//! depends on, stay the papers'. Beside each value stands the one that theory expects.

mod chart;
mod choice;
mod colors;
mod noise;
mod opacity;
mod outliers;
mod scans;
mod series;
mod stage;
mod tables;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use pellucid_engine::Result;

use stage::Stage;

/// Measures at a scale and writes into a folder.
type Experiment = fn(&mut Stage, f64, &Path) -> Result<()>;

const EXPERIMENTS: [(&str, Experiment); 8] = [
    ("opacity", opacity::measure),
    ("noise", noise::measure),
    ("outliers", outliers::measure),
    ("colors", colors::measure),
    ("choice", choice::measure),
    ("series", series::measure),
    ("pairs", series::measure_pairs),
    ("tables", tables::measure),
];

#[derive(Debug, Parser)]
struct Args {
    /// Folder for what is found; made if it isn't there.
    #[arg(short, long, default_value = "target/spbr")]
    output: PathBuf,
    /// Sides of images over the papers', from 0.02 to 1.
    #[arg(long, default_value_t = 0.25, value_parser = scale)]
    scale: f64,
    /// Only this experiment.
    #[arg(long, value_parser = EXPERIMENTS.map(|(name, _)| name))]
    only: Option<String>,
    /// Seed of clouds and ensembles.
    #[arg(long, default_value_t = 1)]
    seed: u64,
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
    let mut stage = Stage::open(args.seed)?;
    println!("{}, scale {}", stage.machine(), args.scale);
    let failed = |source| pellucid_io::output::Error::Write { path: args.output.clone(), source };
    std::fs::create_dir_all(&args.output).map_err(failed)?;
    for (name, measure) in EXPERIMENTS {
        if args.only.as_deref().is_none_or(|only| only == name) {
            println!("\n== {name}");
            measure(&mut stage, args.scale, &args.output)?;
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
