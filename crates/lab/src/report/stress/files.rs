//! The output of a sweep: tables for programs, figures and a page for people.

use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;
use serde_json::{Value, json};

use super::{Cell, Settings, Skipped, Slope, Sweep, Workload, page};
use crate::report::plot::{Axis, Figure, Guide, PANEL, Panel, Point, Series, Steps};
use pellucid_engine::gpu::DeviceInfo;
use pellucid_engine::output::{self, Files};

/// A sweep with what it takes to understand it.
#[derive(Debug, Clone)]
pub struct Report<'a> {
    /// The results.
    pub sweep: &'a Sweep,
    /// The requested settings.
    pub settings: &'a Settings,
    /// The device it ran on.
    pub device: &'a DeviceInfo,
    /// The command line.
    pub command: &'a str,
}

/// A line of `stress.csv`. A skipped cell has its reason in place of figures.
#[derive(Debug, Default, Serialize)]
struct Row<'a> {
    scene: &'a str,
    side: u32,
    pixels: u64,
    layers: u32,
    fragments: u64,
    method: &'a str,
    points: Option<u64>,
    gpu_ms_min: Option<f64>,
    gpu_ms_median: Option<f64>,
    gpu_ms_max: Option<f64>,
    wall_ms_min: Option<f64>,
    wall_ms_median: Option<f64>,
    wall_ms_max: Option<f64>,
    mfragments_per_s: Option<f64>,
    peak_device_bytes: Option<u64>,
    bytes_per_fragment: Option<f64>,
    fragment_bytes: Option<u64>,
    bands: Option<u64>,
    error_max: Option<f64>,
    error_rmse: Option<f64>,
    error_pixels: Option<usize>,
    skipped: &'a str,
}

impl<'a> Row<'a> {
    fn measured(cell: &Cell) -> Self {
        Self {
            scene: cell.workload.name(),
            side: cell.side,
            pixels: cell.pixels,
            layers: cell.layers,
            fragments: cell.fragments,
            method: cell.method,
            points: Some(cell.points),
            gpu_ms_min: Some(cell.gpu_ms.min),
            gpu_ms_median: Some(cell.gpu_ms.median),
            gpu_ms_max: Some(cell.gpu_ms.max),
            wall_ms_min: Some(cell.wall_ms.min),
            wall_ms_median: Some(cell.wall_ms.median),
            wall_ms_max: Some(cell.wall_ms.max),
            mfragments_per_s: Some(cell.mfragments_per_s()),
            peak_device_bytes: Some(cell.peak_device_bytes),
            bytes_per_fragment: Some(cell.bytes_per_fragment()),
            fragment_bytes: Some(cell.fragment_bytes),
            bands: Some(cell.bands),
            error_max: Some(cell.error.max),
            error_rmse: Some(cell.error.rmse),
            error_pixels: Some(cell.error.pixels),
            skipped: "",
        }
    }

    fn skipped(skipped: &'a Skipped) -> Self {
        let pixels = u64::from(skipped.side) * u64::from(skipped.side);
        Self {
            scene: skipped.workload.name(),
            side: skipped.side,
            pixels,
            layers: skipped.layers,
            fragments: pixels * u64::from(skipped.layers),
            method: skipped.method,
            skipped: &skipped.reason,
            ..Self::default()
        }
    }
}

impl Report<'_> {
    /// The document of `stress.json`.
    pub fn json(&self) -> Value {
        let Self { sweep, settings, device, command } = self;
        let cell = |cell: &Cell| {
            let mut value = json!(cell);
            value["mfragments_per_s"] = json!(cell.mfragments_per_s());
            value["bytes_per_fragment"] = json!(cell.bytes_per_fragment());
            value
        };
        json!({
            "version": 1,
            "pellucid": env!("CARGO_PKG_VERSION"),
            "command": command,
            "device": {
                "name": device.name,
                "driver": device.driver,
                "timestamp_period_ns": device.timestamp_period_ns,
            },
            "settings": {
                "sides": settings.sides,
                "layers": settings.layers,
                "methods": settings.methods.iter().map(|method| method.name()).collect::<Vec<_>>(),
                "frames": settings.frames,
                "max_fragments": settings.max_fragments,
                "max_seconds": settings.max_seconds,
                "seed": settings.seed,
                "memory_budget": settings.memory_budget,
            },
            "cells": sweep.cells.iter().map(cell).collect::<Vec<_>>(),
            "slopes": sweep.slopes(),
            "skipped": sweep.skipped,
        })
    }

    fn csv(&self, file: impl Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(file);
        let measured = self.sweep.cells.iter().map(Row::measured);
        for row in measured.chain(self.sweep.skipped.iter().map(Row::skipped)) {
            writer.serialize(row).map_err(io::Error::other)?;
        }
        writer.flush()
    }

    /// The figures by the names of their files.
    pub(super) fn figures(&self) -> Result<Vec<(&'static str, String)>, output::Error> {
        let slopes = self.sweep.slopes();
        let time = |cell: &Cell| [cell.gpu_ms.median, cell.gpu_ms.min, cell.gpu_ms.max];
        let throughput = |cell: &Cell| time(cell).map(|ms| cell.fragments as f64 / (1e3 * ms));
        let memory = |cell: &Cell| [cell.peak_device_bytes as f64 / f64::from(1 << 20); 3];
        let error = |cell: &Cell| [cell.error.max; 3];
        let figures = [
            ("time.svg", "device time in ms", 0.0, self.figure(&slopes, time)),
            ("throughput.svg", "million fragments per s", 0.0, self.figure(&[], throughput)),
            ("memory.svg", "peak device memory in MiB", 0.0, self.figure(&[], memory)),
            ("error.svg", "largest error", page::ERROR_FLOOR, self.figure(&[], error)),
        ];
        let drawn = figures.into_iter().map(|(name, label, floor, mut figure)| {
            figure.y.label = label;
            figure.y.floor = floor;
            let failed = |error| output::Error::Report { reason: format!("{name}: {error}") };
            Ok((name, figure.svg().map_err(failed)?))
        });
        drawn.collect()
    }

    /// A panel for each scene and size, with (value, least, greatest) of each method over the layers.
    fn figure(&self, slopes: &[Slope], values: impl Fn(&Cell) -> [f64; 3]) -> Figure {
        let names: Vec<_> = self.settings.methods.iter().map(|method| method.name()).collect();
        let panel = |workload: Workload, side: u32| {
            let series = names.iter().enumerate().map(|(name, method)| {
                let point = |cell: &&Cell| {
                    let [y, low, high] = values(cell);
                    Point { range_y: [low, high], ..Point::new(cell.layers.into(), y) }
                };
                let points = self.sweep.series(workload, side, method).iter().map(point).collect();
                let slope = slopes.iter().find(|s| (s.workload, s.side, s.method) == (workload, side, *method));
                let note = |s: &Slope| format!("slope {:.2}", s.law.exponent);
                Series { name, points, note: slope.map(note).unwrap_or_default() }
            });
            let title = format!("{}, {side} × {side} pixels", workload.name());
            Panel { title, series: series.collect(), front: Vec::new(), is_guided: true }
        };
        let sides = || self.settings.sides.iter().copied();
        let axis = Axis { label: "layers per pixel", floor: 0.0, steps: Steps::Twos };
        Figure {
            x: axis,
            y: Axis { steps: Steps::Tens, ..axis },
            guide: (!slopes.is_empty()).then_some(Guide { name: "in proportion to the layers", exponent: 1.0 }),
            front: "",
            panel: PANEL,
            columns: self.settings.sides.len(),
            panels: Workload::ALL.iter().flat_map(|workload| sides().map(|side| panel(*workload, side))).collect(),
            names: names.into_iter().map(str::to_owned).collect(),
        }
    }
}

/// Writes `stress.csv`, `stress.json`, the figures and, last, `report.html` into a folder, which is created if needed.
/// No file gets its final name before all are complete.
///
/// # Errors
/// Writing fails; the earlier files then remain.
pub fn write(folder: &Path, report: &Report<'_>) -> Result<(), output::Error> {
    let figures = report.figures()?;
    let html = page::html(report, &figures);
    let _new = output::make_folder(folder)?;
    let mut files = Files::default();
    files.add(&folder.join("stress.csv"), |file| report.csv(file))?;
    files.add(&folder.join("stress.json"), |file| writeln!(file, "{:#}", report.json()))?;
    for (name, svg) in &figures {
        files.add(&folder.join(name), |file| file.write_all(svg.as_bytes()))?;
    }
    files.add(&folder.join("report.html"), |file| file.write_all(html.as_bytes()))?;
    files.publish()
}
