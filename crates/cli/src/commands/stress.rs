//! `pellucid stress`.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use pellucid_core::image::MAX_SIDE;
use pellucid_engine::Result;
use pellucid_gpu::Device;
use pellucid_io::output::Output;
use pellucid_lab::report::page::{self, ReportTable};
use pellucid_lab::report::stress::{self, Cell, Entry, Report, Settings, Slope, Sweep};

use super::console::Console;
use super::options::{DeviceArgs, number};
use super::touched::{Touched, Touches};
use super::typed::command;

const ABOUT: &str = "\
Scenes: In both built-in scenes every pixel has one fragment per layer. In `stack` a layer is one disc over the whole image, in \
`mosaic` it is tiled by discs of 3 × 3 pixels. The sweep covers 1 to 4096 layers in factors of 2 on 64², 256² and 1024² pixels. \
The opacity is 1 − 2^(−1/layers), which keeps every layer visible. For soft methods the same points are soft spheres of that \
softness. Cells beyond a limit are skipped and listed with the reason.

Errors: Each method is compared with the exact picture in float64. An exact one must be within its roundings, and a stochastic one \
within its own standard errors: otherwise a warning says so. The error of an approximation is stated.

Pixel area: A line, and `areas` in stress.json, has the error of looking at the center of each pixel in place of its area: the exact \
picture with 1 sample against itself with 64, or with 16 where 64 would take more than a tenth of --max-seconds.

Methods of points that form surfaces (peel-layers, spbr, spbr-simplified), one-layer, and opaque methods are not among them: what they \
draw does not consist of these layers.

Output: report.html (self-contained), stress.csv, stress.json, and the figures as .svg.";

#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub struct StressArgs {
    /// Folder for the report; created if missing. Files of the same names are replaced.
    #[arg(short, long, value_name = "DIR", default_value = "pellucid-stress")]
    output: PathBuf,
    /// Run a small sweep, for a first look or for CI.
    ///
    /// 1 to 1024 layers in factors of 4, 64² and 256² pixels, 3 frames, at most 2^20 fragments.
    #[arg(long)]
    quick: bool,
    /// Measure only these methods, as in abuffer,mlab; repeatable. By default all.
    ///
    /// `abuffer` is measured twice, with `long_lists = "merge"` and `"in-place"`.
    #[arg(long, value_name = "NAME[,NAME]", value_delimiter = ',', value_parser = method_names())]
    method: Vec<String>,
    /// Measure only images of this size, as in 512x512, which must be square; repeatable.
    ///
    /// By default 64x64, 256x256 and 1024x1024.
    #[arg(long, value_name = "WxH", value_parser = side)]
    size: Vec<u32>,
    /// Number of frames per median; by default 5.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Skip cells with more fragments; by default 2^26.
    #[arg(long, value_name = "N")]
    max_fragments: Option<u64>,
    /// Skip cells whose frame is predicted to take longer; by default 2.
    ///
    /// The prediction comes from the times of the same method in smaller cells.
    #[arg(long, value_name = "SECONDS", value_parser = seconds())]
    max_seconds: Option<f64>,
    /// Seed of the scenes, and of the choice of pixels that are compared with the reference.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    device: DeviceArgs,
    /// Print the contents of stress.json instead of the summary.
    ///
    /// Its keys: version, pellucid, command, device, settings, cells, slopes, skipped, areas.
    #[arg(long)]
    json: bool,
}

fn method_names() -> PossibleValuesParser {
    Entry::methods().into()
}

/// The side of a square image.
fn side(size: &str) -> std::result::Result<u32, String> {
    let sides = size.split_once(['x', 'X', '×']);
    let number = |text: &str| text.trim().parse::<u32>().ok();
    match sides.and_then(|(width, height)| Some((number(width)?, number(height)?))) {
        Some((width, height)) if width == height && (1..=MAX_SIDE).contains(&width) => Ok(width),
        _ => Err(format!("expected a square size with sides from 1 to {MAX_SIDE}, as in 512x512")),
    }
}

pub fn seconds() -> impl TypedValueParser<Value = f64> {
    number(|x| *x > 0.0, "expected a number of seconds above 0")
}

impl StressArgs {
    fn settings(&self) -> Settings {
        let entries = Entry::of_methods(&self.method);
        let default = if self.quick { Settings::quick(entries) } else { Settings::full(entries) };
        let mut sides = self.size.clone();
        sides.sort_unstable();
        sides.dedup();
        Settings {
            sides: if sides.is_empty() { default.sides } else { sides },
            frames: self.frames.unwrap_or(default.frames),
            max_fragments: self.max_fragments.unwrap_or(default.max_fragments),
            max_seconds: self.max_seconds.unwrap_or(default.max_seconds),
            seed: self.seed,
            memory_budget: self.device.budget(),
            ..default
        }
    }
}

impl Touches for StressArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::default().and([Output::folder("-o", &self.output, stress::FILES)]))
    }
}

pub fn run(args: StressArgs, console: Console) -> Result<()> {
    pellucid_io::output::check_report_folder(&args.output)?;
    let settings = args.settings();
    let progress = console.progress();
    let device = Device::open(&args.device.options())?;
    console.detail(format_args!("device {} ({})", device.info().name, device.info().driver));
    progress.counted("stress", settings.cells() as u64);
    let sweep = stress::run(&device, &settings, &progress)?;
    progress.finish_and_clear();
    for cell in &sweep.cells {
        if let Some(counted) = cell.counted.filter(|counted| *counted != cell.fragments) {
            let (scene, side, method) = (cell.workload.name(), cell.side, cell.method);
            console.warn(format_args!(
                "{scene}, {side} × {side} pixels, {} layers: {method} counted {counted} fragments instead of {}",
                cell.layers, cell.fragments
            ));
        }
    }
    for cell in sweep.cells.iter().filter(|cell| cell.holds() == Some(false)) {
        console.warn(format_args!("{}", beyond(cell)));
    }
    let command = command();
    let report = Report { sweep: &sweep, settings: &settings, device: device.info(), command: &command };
    stress::write(&args.output, &report)?;
    if args.json { console.print_json(&report.json()) } else { console.print(&summary(&sweep, &args.output)) }
}

/// A cell whose error is not as expected.
fn beyond(cell: &Cell) -> String {
    let (scene, side, layers, method) = (cell.workload.name(), cell.side, cell.layers, cell.method);
    let (max, rmse) = (cell.error.max, cell.error.rmse);
    let what = match (cell.bound(), cell.error.standard_errors) {
        (Some(bound), _) => format!("the largest error is {max:.1e}, more than the {bound:.1e} that roundings explain"),
        (None, Some(times)) => format!("the RMSE is {rmse:.1e}, {times:.1} times the standard error that it states"),
        (None, None) => format!("the RMSE is {rmse:.1e}, and no standard error is stated"),
    };
    format!("{scene}, {side} × {side} pixels, {layers} layers: {method}: {what}")
}

/// The end of each series, how much was skipped, and where the rest is.
fn summary(sweep: &Sweep, folder: &Path) -> String {
    let slopes = sweep.slopes();
    let slope = |cell: &Cell| Slope::of(&slopes, cell);
    let hundredths = |value: f64| format!("{value:.2}");
    let exponent = |slope: &Slope| hundredths(slope.law.exponent);
    let area = sweep.area_text().map_or_else(String::new, |text| format!("{text}\n"));
    let table = ReportTable::new(sweep.deepest())
        .text("scene", |cell| cell.workload.name())
        .text("pixels", |cell| format!("{0} × {0}", cell.side))
        .text("method", |cell| cell.method)
        .number("layers", page::count, |cell| f64::from(cell.layers))
        .number("median ms", hundredths, |cell| cell.gpu_ms.median)
        .number("Mfragments/s", hundredths, Cell::mfragments_per_s)
        .written("slope", |cell| (f64::NAN, slope(cell).map_or("-".to_owned(), exponent)))
        .number("peak MiB", |mib| format!("{mib:.1}"), |cell| page::mib(cell.peak_device_bytes))
        .number("largest error", |error| format!("{error:.1e}"), |cell| cell.error.max)
        .text("expected", stress::expected);
    format!(
        "{}\n\nEach line: the deepest cell measured, the slope of time over layers (log-log), - with fewer than three cells, and the\n\
         error against the exact picture, with what is expected of exact and stochastic methods.\n{area}\
         {} cells measured, {} skipped; reasons and all figures: {}\n",
        table.terminal(),
        sweep.cells.len(),
        sweep.skipped.len(),
        folder.join("report.html").display()
    )
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: StressArgs,
    }

    #[test]
    fn sizes_replace_those_of_the_sweep() {
        let sides = |words: &[&str]| {
            let line = Line::try_parse_from([&["stress"], words].concat());
            line.map(|line| line.args.settings().sides).map_err(|error| error.to_string())
        };
        assert_eq!(sides(&[]), Ok(vec![64, 256, 1024]));
        assert_eq!(sides(&["--quick", "--size", "512x512", "--size", "32X32"]), Ok(vec![32, 512]));
        for wrong in ["512", "512x256", "0x0", "16385x16385", "axb"] {
            assert!(sides(&["--size", wrong]).unwrap_err().contains("square size"), "{wrong}");
        }
    }
}
