//! `pellucid compare`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use pellucid::metrics::{self, Comparison};
use pellucid::output::{self, LinearImage, read_image};
use pellucid::{Result, scene};
use serde_json::json;

use super::compare_profiles;
use super::talk::{Talk, print, print_json, say};

/// How much the difference picture is brightened.
const AMPLIFY: f64 = 10.0;

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// A picture (.png, .exr) or a profile (.json).
    a: PathBuf,
    /// Another of the same kind.
    b: PathBuf,
    /// Pictures: write the absolute difference of the linear values, 10 times as bright, as PNG.
    #[arg(short, long, value_name = "DIFF.png")]
    output: Option<PathBuf>,
    /// Print JSON. Pictures: {rmse, psnr, ssim, flip, max: {value, x, y}, above_1_255}, where the psnr of equal pictures
    /// and whatever is infinite are null, as are ssim and flip in this version. Profiles: {frame, passes}.
    #[arg(long)]
    json: bool,
    /// Exit with status 1 if the metric is above the value; repeatable. Pictures: rmse, psnr, max, above_1_255. Profiles:
    /// the ratio B/A of a pass by its name, or of `frame`.
    #[arg(long, value_name = "METRIC=VALUE")]
    fail_above: Vec<String>,
}

/// A metric and the largest value it may have.
pub struct Limit {
    pub metric: String,
    pub value: f64,
}

impl Limit {
    fn parse(text: &str) -> Result<Self, scene::Error> {
        let problem = || scene::Error::Usage(format!("--fail-above {text}: expected METRIC=VALUE, as in rmse=0.01"));
        // From the right: the names of passes may hold anything but end before the number.
        let (metric, value) = text.rsplit_once('=').ok_or_else(problem)?;
        let value = value.trim().parse().ok().filter(|value: &f64| !value.is_nan()).ok_or_else(problem)?;
        Ok(Self { metric: metric.trim().to_owned(), value })
    }

    /// Whether a measured value is above the limit, which is then said on standard error.
    pub fn is_broken_by(&self, measured: f64) -> bool {
        let broken = measured > self.value;
        if broken {
            say(format_args!("error: {} is {measured}, above the allowed {}", self.metric, self.value));
        }
        broken
    }
}

const METRICS: [&str; 4] = ["rmse", "psnr", "max", "above_1_255"];

fn value(comparison: &Comparison, metric: &str) -> Option<f64> {
    match metric {
        "rmse" => Some(comparison.rmse),
        "psnr" => Some(comparison.psnr),
        "max" => Some(comparison.max.value),
        "above_1_255" => Some(comparison.above_1_255),
        _ => None,
    }
}

pub fn run(args: CompareArgs, _talk: Talk) -> Result<ExitCode> {
    let limits = args.fail_above.iter().map(|text| Limit::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let is_profile = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let within = match (is_profile(&args.a), is_profile(&args.b)) {
        (true, true) if args.output.is_some() => {
            return Err(usage("-o: two profiles have no difference picture"));
        }
        (true, true) => compare_profiles::run(&args.a, &args.b, args.json, &limits)?,
        (false, false) => pictures(&args, &limits)?,
        _ => return Err(usage("a picture and a profile can't be compared; give two of a kind")),
    };
    Ok(if within { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

pub fn usage(problem: impl Into<String>) -> pellucid::Error {
    scene::Error::Usage(problem.into()).into()
}

/// Compares two pictures; false if a limit is broken.
fn pictures(args: &CompareArgs, limits: &[Limit]) -> Result<bool> {
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
    report(&comparison, args.json)?;
    // Every limit is looked at, so that all broken ones are named.
    let broken = limits
        .iter()
        .filter(|limit| value(&comparison, &limit.metric).is_some_and(|measured| limit.is_broken_by(measured)));
    Ok(broken.count() == 0)
}

fn check_metrics(limits: &[Limit]) -> Result<()> {
    for Limit { metric, .. } in limits {
        if ["ssim", "flip"].contains(&metric.as_str()) {
            let known = METRICS.join(", ");
            return Err(usage(format!("--fail-above {metric}: {metric} is not in this version; it has: {known}")));
        }
        if !METRICS.contains(&metric.as_str()) {
            return Err(usage(format!("--fail-above {metric}: unknown metric; there are: {}", METRICS.join(", "))));
        }
    }
    Ok(())
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

fn report(comparison: &Comparison, json: bool) -> Result<()> {
    let Comparison { rmse, psnr, max, above_1_255 } = comparison;
    if json {
        // JSON has no infinity: serde_json writes null for it.
        return print_json(&json!({
            "rmse": rmse,
            "psnr": psnr,
            "ssim": null,
            "flip": null,
            "max": { "value": max.value, "x": max.x, "y": max.y },
            "above_1_255": above_1_255,
        }));
    }
    print(&format!(
        "rmse         {rmse:.9}\npsnr         {psnr:.3} dB\nmax          {:.9} at ({}, {})\nabove_1_255  {above_1_255:.9}\n",
        max.value, max.x, max.y
    ))
}
