//! The output of a comparison: tables for programs, figures and a page for people.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

use super::pictures::Pictures;
use super::{Errors, Row, Tradeoff, figures, looks, page};
use crate::report::page::add;
use crate::report::popping;
use crate::report::records::{self, record};
use crate::report::stress::Spread;
use pellucid_io::output::{self, Files};

/// Columns of `tradeoff.csv`. A skipped setting has its reason in place of figures.
const COLUMNS: &str = "
    method setting key=step/0 step=step/1 thinning stochastic
    gpu_ms/min gpu_ms/median gpu_ms/max wall_ms/min wall_ms/median wall_ms/max frames
    peak_device_bytes fragment_bytes
    rmse=errors/rmse rmse_analytic nmse=errors/nmse psnr=errors/psnr ssim=errors/ssim flip=errors/flip max=errors/max
    above_1_255=errors/above_1_255 holes rmse_inside
    seeds=repeats/seeds noise=repeats/noise bias=repeats/bias bias_floor=repeats/bias_floor
    front picture difference skipped=reason";

/// Columns of `causes.csv`.
const CAUSES: &str = "cause setting against rmse flip max above_1_255 gpu_ms times difference meaning";

/// Shadows as a record: times are those of their passes, errors are against the same method's image with many samples.
#[derive(Serialize)]
struct Lit<'a> {
    method: &'a str,
    setting: String,
    step: (&'a str, f64),
    gpu_ms: Spread,
    errors: BTreeMap<&'a str, f64>,
}

fn csv(report: &Tradeoff, file: impl Write) -> io::Result<()> {
    // Unlike JSON, a table can say it.
    let exact = |errors: Errors| Errors { psnr: Some(errors.psnr.unwrap_or(f64::INFINITY)), ..errors };
    let measured = report.rows.iter().map(|row| record(&Row { errors: exact(row.errors), ..row.clone() }));
    let steps = report.shaded.iter().flat_map(|shaded| shaded.steps.iter().map(|step| (&shaded.method, step)));
    let shaded = steps.map(|(method, step)| {
        record(&Lit {
            method,
            setting: format!("shadows.samples={}", step.samples),
            step: ("shadows.samples", step.samples.into()),
            gpu_ms: step.ms,
            errors: [("rmse", step.rmse)].into(),
        })
    });
    records::csv(file, COLUMNS, measured.chain(report.skipped.iter().map(record)).chain(shaded))
}

/// Files of the report and of an interrupted run; `.svg` stands for all figures, `.png` for all pictures.
pub const FILES: &[&str] = &[
    "report.html",
    "tradeoff.csv",
    "tradeoff.json",
    "tradeoff.partial.json",
    "causes.csv",
    "popping.csv",
    ".svg",
    ".png",
];

/// Writes `tradeoff.csv`, `causes.csv` if any were measured, along a path `popping.csv`, `tradeoff.json`, the figures
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
        let causes = report.causes.iter().map(record);
        files.add(&folder.join("causes.csv"), |file| records::csv(file, CAUSES, causes))?;
    }
    if let Some(found) = &report.popping {
        files.add(&folder.join("popping.csv"), |file| popping::csv(found, file))?;
    }
    files.add(&folder.join("tradeoff.json"), |file| {
        serde_json::to_writer_pretty(&mut *file, report)?;
        writeln!(file)
    })?;
    add(&mut files, folder, &figures, &html)?;
    files.publish()
}
