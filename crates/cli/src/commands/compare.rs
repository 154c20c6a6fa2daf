//! `pellucid compare`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use pellucid_core::image::LinearImage;
use pellucid_core::metrics::{self, Comparison};
use pellucid_engine::Result;
use pellucid_io::output::{self, Inputs, read_image};
use serde_json::json;

use super::compare_profiles;
use super::console::Console;
use super::limit::{Limit, Slower, usage};
use super::touched::{Touched, Touches};

/// Amplification of the difference picture.
const AMPLIFY: f64 = 10.0;

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// Reference: a picture (.png, .exr) or a profile (.json).
    a: PathBuf,
    /// Picture or profile to compare with the reference.
    b: PathBuf,
    /// Pictures: write the difference as a PNG, 10 times as bright.
    ///
    /// It is the absolute difference of the linear values.
    #[arg(short, long, value_name = "DIFF.png")]
    output: Option<PathBuf>,
    /// Print JSON.
    ///
    /// Pictures: {rmse, nmse, psnr, ssim, flip, max: {value, x, y}, above_1_255}; infinite values are null, as the psnr
    /// of equal pictures. Profiles: {frame, passes}, each {name, a_ms, b_ms, ratio, interval: [low, high], share,
    /// verdict}; unknown values are null.
    #[arg(long)]
    json: bool,
    /// Profiles: compare them even if points, pixels, method, device or --steady differ.
    ///
    /// Otherwise such a difference is an error (status 1), since the times are of different work.
    #[arg(long)]
    anyway: bool,
    /// Exit with status 1 if the metric is above the value; repeatable.
    ///
    /// Metrics of pictures: rmse, nmse, psnr, ssim, flip, max, above_1_255. Of profiles: the ratio B/A of a pass by its
    /// name, or of `frame`.
    #[arg(long, value_name = "METRIC=VALUE")]
    fail_above: Vec<String>,
    /// Exit with status 1 if the metric is below the value; repeatable.
    ///
    /// For psnr and ssim, which grow as the pictures become more similar. All other metrics shrink.
    #[arg(long, value_name = "METRIC=VALUE")]
    fail_below: Vec<String>,
    /// Profiles: exit with status 1 if B is slower by RATIO beyond the noise; repeatable.
    ///
    /// RATIO applies to the frame and to each pass of at least 1% of it, PASS=RATIO to one pass, however short. A time
    /// counts as slower if the whole interval of B/A is above RATIO. The interval lies between opposite ends of the
    /// medians' 95% confidence intervals by order statistics. With 5 frames, the smallest number that is enough, its
    /// lower end is the fastest frame of B over the slowest of A. To include the noise between runs, alternate runs of
    /// A and B and merge the frames of each.
    #[arg(long, value_name = "[PASS=]RATIO")]
    fail_slower: Vec<String>,
}

/// Returns a metric of two pictures.
type Metric = fn(&Comparison) -> f64;

/// The metrics of pictures that have a limit.
const METRICS: [(&str, Metric); 7] = [
    ("rmse", |found| found.rmse),
    ("nmse", |found| found.nmse),
    ("psnr", |found| found.psnr),
    ("ssim", |found| found.ssim),
    ("flip", |found| found.flip),
    ("max", |found| found.max.value),
    ("above_1_255", |found| found.above_1_255),
];

impl Touches for CompareArgs {
    fn touched(&self) -> Result<Touched> {
        let inputs = Inputs::default().with([&self.a, &self.b]);
        Ok(Touched::reads(inputs).writes("-o", self.output.as_deref()))
    }
}

pub fn run(args: CompareArgs, console: Console) -> Result<ExitCode> {
    let limits = Limit::all(&args.fail_above, &args.fail_below)?;
    let slower = args.fail_slower.iter().map(|text| Slower::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let is_profile = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let within = match (is_profile(&args.a), is_profile(&args.b)) {
        (true, true) if args.output.is_some() => {
            return Err(usage("-o: profiles have no difference picture; give two pictures"));
        }
        (true, true) => {
            let files = [args.a.as_path(), args.b.as_path()];
            compare_profiles::run(files, (args.json, args.anyway), &limits, &slower, console)?
        }
        (false, false) if args.anyway => {
            return Err(usage("--anyway: only pictures of one size can be compared; it is for profiles"));
        }
        (false, false) if !slower.is_empty() => {
            return Err(usage("--fail-slower: pictures have no passes; give two profiles"));
        }
        (false, false) => pictures(&args, &limits, console)?,
        _ => return Err(usage("a picture and a profile can't be compared; give two pictures or two profiles")),
    };
    Ok(if within { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Compares two pictures; false if a limit is broken.
fn pictures(args: &CompareArgs, limits: &[Limit], console: Console) -> Result<bool> {
    check_metrics(limits)?;
    if let Some(path) = &args.output {
        check_difference_target(path)?;
    }
    let (a, b) = (read_image(&args.a)?, read_image(&args.b)?);
    let comparison = metrics::compare(&a, &b).ok_or_else(|| sizes_differ(args, &a, &b))?;
    if let Some(path) = &args.output {
        let picture = metrics::difference_picture(&a.pixels, &b.pixels, AMPLIFY);
        output::write_rgb_png(path, [a.width, a.height], &picture)?;
    }
    report(&comparison, args.json, console)?;
    // Every limit is looked at, so that all broken ones are named.
    let broken = limits.iter().filter(|limit| {
        let metric = METRICS.iter().find(|(name, _)| *name == limit.metric);
        metric.is_some_and(|(_, value)| limit.is_broken_by(value(&comparison), console))
    });
    Ok(broken.count() == 0)
}

fn check_metrics(limits: &[Limit]) -> Result<()> {
    let names = METRICS.map(|(name, _)| name);
    match limits.iter().find(|limit| !names.contains(&limit.metric.as_str())) {
        Some(limit) => Err(limit.unusable(&format!("unknown metric; expected one of {}", names.join(", ")))),
        None => Ok(()),
    }
}

fn check_difference_target(path: &Path) -> Result<()> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        Ok(output::check_folder(path)?)
    } else {
        Err(usage(format!("-o {}: the difference picture is a .png", path.display())))
    }
}

fn sizes_differ(args: &CompareArgs, a: &LinearImage, b: &LinearImage) -> output::Error {
    output::Error::SizesDiffer {
        a: args.a.clone(),
        a_width: a.width,
        a_height: a.height,
        b: args.b.clone(),
        b_width: b.width,
        b_height: b.height,
    }
}

fn report(comparison: &Comparison, json: bool, console: Console) -> Result<()> {
    if json {
        // JSON has no infinity: serde_json writes null for it.
        return console.print_json(&json!(comparison));
    }
    let Comparison { rmse, nmse, psnr, ssim, flip, max, above_1_255 } = comparison;
    let lines = [
        format!("rmse         {rmse:.9}"),
        format!("nmse         {nmse:.9}"),
        format!("psnr         {psnr:.3} dB"),
        format!("ssim         {ssim:.9}"),
        format!("flip         {flip:.9}"),
        format!("max          {:.9} at ({}, {})", max.value, max.x, max.y),
        format!("above_1_255  {above_1_255:.9}"),
    ];
    console.print(&(lines.join("\n") + "\n"))
}
