//! `--simulate`: how long frames would take on any number of ranks, from what parts of them take here.

mod measure;
mod model;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use pellucid_engine::{Result, output};
use pellucid_lab::report::plot::{Axis, Figure, Panel, Point, Series, Steps};

use self::model::{Parts, Prediction, Scaling};
use super::link::Link;
use super::ranks::Ranks;
use super::stage::Stage;
use crate::commands::console::{Console, print};

/// Job that is simulated.
#[derive(Debug, Clone, Args)]
pub struct SimulateArgs {
    /// Predict the time of a frame on 1, 2, 4 … up to RANKS ranks.
    ///
    /// Measures the parts of the frame on the first rank's device and assumes that every rank has an equally fast one. Prints CSV
    /// and writes no picture.
    #[arg(long, value_name = "RANKS", value_parser = clap::value_parser!(u32).range(1..=1 << 20), help_heading = "Simulation")]
    simulate: Option<u32>,
    /// Number of ranks that run at full speed at the same time, for ranks on one machine.
    #[arg(long, value_name = "N", requires = "simulate", value_parser = clap::value_parser!(u32).range(1..), help_heading = "Simulation")]
    at_once: Option<u32>,
    /// Latency of an empty message in seconds.
    ///
    /// Default: measured between the first two ranks; with one rank 30e-6.
    #[arg(long, value_name = "SECONDS", requires = "simulate", value_parser = positive, help_heading = "Simulation")]
    latency: Option<f64>,
    /// Bandwidth of messages in bytes per second.
    ///
    /// Default: measured between the first two ranks; with one rank 2e9.
    #[arg(long, value_name = "BYTES", requires = "simulate", value_parser = positive, help_heading = "Simulation")]
    bandwidth: Option<f64>,
    /// Also draw speedup and efficiency to an SVG file.
    #[arg(long, value_name = "FILE.svg", requires = "simulate", help_heading = "Simulation")]
    plot: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0).ok_or_else(|| "expected a number above 0".into())
}

impl SimulateArgs {
    /// True if nothing is to be rendered.
    pub fn is_asked(&self) -> bool {
        self.simulate.is_some()
    }

    /// Refuses files that could not be written in the end.
    pub fn check(&self) -> Result<()> {
        self.plot.iter().try_for_each(|path| output::check_folder(path))?;
        Ok(())
    }

    fn link(&self, known: Link) -> Link {
        Link { latency: self.latency.unwrap_or(known.latency), bandwidth: self.bandwidth.unwrap_or(known.bandwidth) }
    }
}

/// Measures the first of some frames on the first rank, which prints predictions.
///
/// # Errors
/// Those of rendering and of writing.
pub fn run(args: &SimulateArgs, stage: &mut Stage, frames: usize, ranks: &Ranks, console: Console) -> Result<ExitCode> {
    if !ranks.is_first() {
        return Ok(ExitCode::SUCCESS);
    }
    let most = args.simulate.unwrap_or(1);
    let measured = measure::measure(stage, frames)?;
    let link = args.link(stage.link);
    let at_once = args.at_once.map_or(usize::MAX, |count| count as usize);
    console.note(format_args!(
        "a frame takes {:.1} ms on this device; messages: {:.1} µs each, {:.2} GB/s",
        1e3 * measured.alone,
        1e6 * link.latency,
        1e-9 * link.bandwidth
    ));
    if let Parts::Windows(parts) = &measured.parts {
        parts.iter().for_each(|part| console.detail(part));
    }
    let counts = (0..).map(|power| 1usize << power).take_while(|count| *count <= most as usize);
    let predictions: Vec<Prediction> =
        counts.flat_map(|count| measured.predict(&stage.job, count, at_once, link)).collect();
    print(&csv(&predictions))?;
    if let Some(path) = &args.plot {
        let svg = figure(&predictions).svg().map_err(|error| std::io::Error::other(error.to_string()));
        output::write_atomically(path, |file| file.write_all(svg?.as_bytes()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn csv(predictions: &[Prediction]) -> String {
    let line = |p: &Prediction| {
        format!(
            "{},{},{},{:.4},{:.4},{:.4},{:.3},{:.4}\n",
            p.ranks,
            p.share,
            p.scaling,
            1e3 * p.seconds,
            1e3 * p.work,
            1e3 * p.gather,
            p.speedup,
            p.efficiency()
        )
    };
    let head = "ranks,share,scaling,ms,work_ms,gather_ms,speedup,efficiency\n";
    head.to_owned() + &predictions.iter().map(line).collect::<String>()
}

/// Speedup of the strong scaling, efficiency of both.
fn figure(predictions: &[Prediction]) -> Figure {
    let mut names: Vec<String> = Vec::new();
    for p in predictions {
        if !names.contains(&p.share.to_string()) {
            names.push(p.share.to_string());
        }
    }
    let series = |scaling: Scaling, y: fn(&Prediction) -> f64| -> Vec<Series> {
        let of = |(name, share): (usize, &String)| {
            let own = predictions.iter().filter(|p| p.scaling == scaling && p.share.to_string() == *share);
            Series { name, points: own.map(|p| Point::new(p.ranks as f64, y(p))).collect(), note: String::new() }
        };
        names.iter().enumerate().map(of).collect()
    };
    let panel = |title: &str, series| Panel { title: title.to_owned(), series, front: Vec::new(), is_guided: false };
    let panels = vec![
        panel("one scene on more ranks: frames per second, of one rank's", series(Scaling::Strong, |p| p.speedup)),
        panel("one scene on more ranks: of the ideal", series(Scaling::Strong, Prediction::efficiency)),
        panel("as much for each rank: of the ideal", series(Scaling::Weak, Prediction::efficiency)),
    ];
    Figure {
        x: Axis { label: "ranks", floor: 1.0, steps: Steps::Twos },
        y: Axis { label: "times one rank", floor: 1e-3, steps: Steps::Tens },
        names,
        guide: None,
        front: "",
        panel: [380, 290],
        columns: 3,
        panels,
    }
}
