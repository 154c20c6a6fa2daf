//! The output of a comparison: tables for programs, figures and a page for people.

use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

use super::pictures::Pictures;
use super::{Row, Shaded, ShadedStep, Skipped, Tradeoff, causes, figures, looks, page};
use crate::report::popping;
use pellucid_engine::output::{self, Files};

/// A line of `tradeoff.csv`. A skipped setting has its reason in place of figures.
#[derive(Debug, Default, Serialize)]
struct Line<'a> {
    method: &'a str,
    setting: &'a str,
    key: &'a str,
    step: Option<f64>,
    thinning: Option<u32>,
    stochastic: Option<bool>,
    gpu_ms_min: Option<f64>,
    gpu_ms_median: Option<f64>,
    gpu_ms_max: Option<f64>,
    wall_ms_min: Option<f64>,
    wall_ms_median: Option<f64>,
    wall_ms_max: Option<f64>,
    frames: Option<usize>,
    peak_device_bytes: Option<u64>,
    fragment_bytes: Option<u64>,
    rmse: Option<f64>,
    rmse_analytic: Option<f64>,
    nmse: Option<f64>,
    psnr: Option<f64>,
    ssim: Option<f64>,
    flip: Option<f64>,
    max: Option<f64>,
    above_1_255: Option<f64>,
    holes: Option<f64>,
    rmse_inside: Option<f64>,
    seeds: Option<u32>,
    noise: Option<f64>,
    bias: Option<f64>,
    bias_floor: Option<f64>,
    front: Option<bool>,
    picture: &'a str,
    difference: &'a str,
    skipped: &'a str,
}

impl<'a> Line<'a> {
    fn measured(row: &'a Row) -> Self {
        let (key, step) = row.step.as_ref().map_or(("", None), |(key, step)| (key.as_str(), Some(*step)));
        Self {
            method: &row.method,
            setting: &row.setting,
            key,
            step,
            thinning: Some(row.thinning),
            stochastic: Some(row.stochastic),
            gpu_ms_min: Some(row.gpu_ms.min),
            gpu_ms_median: Some(row.gpu_ms.median),
            gpu_ms_max: Some(row.gpu_ms.max),
            wall_ms_min: Some(row.wall_ms.min),
            wall_ms_median: Some(row.wall_ms.median),
            wall_ms_max: Some(row.wall_ms.max),
            frames: Some(row.frames),
            peak_device_bytes: Some(row.peak_device_bytes),
            fragment_bytes: Some(row.fragment_bytes),
            rmse: Some(row.errors.rmse),
            rmse_analytic: row.rmse_analytic,
            nmse: Some(row.errors.nmse),
            // Unlike JSON, a table can say it.
            psnr: Some(row.errors.psnr.unwrap_or(f64::INFINITY)),
            ssim: Some(row.errors.ssim),
            flip: Some(row.errors.flip),
            max: Some(row.errors.max),
            above_1_255: Some(row.errors.above_1_255),
            holes: row.holes,
            rmse_inside: row.rmse_inside,
            seeds: row.repeats.map(|repeats| repeats.seeds),
            noise: row.repeats.map(|repeats| repeats.noise),
            bias: row.repeats.map(|repeats| repeats.bias),
            bias_floor: row.repeats.map(|repeats| repeats.bias_floor),
            front: Some(row.front),
            picture: &row.picture,
            difference: &row.difference,
            skipped: "",
        }
    }

    /// Times are those of the passes of shadows, errors are against the same method's image with many samples.
    fn shaded(method: &'a str, setting: &'a str, step: &ShadedStep) -> Self {
        Self {
            method,
            setting,
            key: "shadows.samples",
            step: Some(step.samples.into()),
            gpu_ms_min: Some(step.ms.min),
            gpu_ms_median: Some(step.ms.median),
            gpu_ms_max: Some(step.ms.max),
            rmse: Some(step.rmse),
            ..Self::default()
        }
    }

    fn skipped(skipped: &'a Skipped) -> Self {
        let Skipped { method, setting, reason, .. } = skipped;
        Self { method, setting, skipped: reason, ..Self::default() }
    }
}

fn csv(report: &Tradeoff, file: impl Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(file);
    let measured = report.rows.iter().map(Line::measured);
    // Uses names that live as long as the lines do.
    let settings =
        |shaded: &Shaded| shaded.steps.iter().map(|step| format!("shadows.samples={}", step.samples)).collect();
    let settings: Vec<String> = report.shaded.as_ref().map_or_else(Vec::new, settings);
    let shaded = report.shaded.iter().flat_map(|shaded| shaded.steps.iter().map(|step| (shaded.method.as_str(), step)));
    let shaded = shaded.zip(&settings).map(|((method, step), setting)| Line::shaded(method, setting, step));
    for line in measured.chain(report.skipped.iter().map(Line::skipped)).chain(shaded) {
        writer.serialize(line).map_err(io::Error::other)?;
    }
    writer.flush()
}

/// Writes `tradeoff.csv`, for Gaussian splats `causes.csv`, along a path `popping.csv`, `tradeoff.json`, the figures
/// and, last, `report.html` into the folder of the pictures. No file gets its final name before all are complete.
///
/// # Errors
/// A picture of the report is missing or damaged, or writing fails.
pub fn write(folder: &Path, report: &Tradeoff) -> Result<(), output::Error> {
    let figures = figures::draw(report)?;
    let pictures = Pictures::read(folder, report)?;
    let html = page::html(report, &figures, &pictures, &looks::Crops::read(folder, report)?);
    let mut files = Files::default();
    files.add(&folder.join("tradeoff.csv"), |file| csv(report, file))?;
    if !report.causes.is_empty() {
        files.add(&folder.join("causes.csv"), |file| causes::csv(&report.causes, file))?;
    }
    if let Some(found) = &report.popping {
        files.add(&folder.join("popping.csv"), |file| popping::csv(found, file))?;
    }
    files.add(&folder.join("tradeoff.json"), |file| {
        serde_json::to_writer_pretty(&mut *file, report)?;
        writeln!(file)
    })?;
    for figure in &figures {
        files.add(&folder.join(figure.name), |file| file.write_all(figure.svg.as_bytes()))?;
    }
    files.add(&folder.join("report.html"), |file| file.write_all(html.as_bytes()))?;
    files.publish()
}
