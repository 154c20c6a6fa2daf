//! The output of a sweep: tables for programs, figures and a page for people.

use std::io::{self, Write};
use std::path::Path;

use maud::html;
use serde::Serialize;
use serde_json::{Value, json};

use super::{Cell, Settings, Skipped, Slope, Sweep, Workload, page};
use crate::report::page::{Drawn, add, mib};
use crate::report::plot::{Axis, Figure, Guide, PANEL, Panel, Point, Series};
use crate::report::records::{self, record};
use pellucid_gpu::DeviceInfo;
use pellucid_io::output::{self, Files};

/// Errors below are drawn at this value: an error of 0 has no place on a logarithmic axis.
const ERROR_FLOOR: f64 = 1e-9;

/// More slopes would hide a panel's points; the table has all.
const MOST_NOTES: usize = 5;

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

/// Columns of `stress.csv`. A skipped cell has its reason in place of figures.
const COLUMNS: &str = "
    scene=workload side pixels layers fragments method points
    gpu_ms/min gpu_ms/median gpu_ms/max wall_ms/min wall_ms/median wall_ms/max mfragments_per_s
    peak_device_bytes bytes_per_fragment fragment_bytes bands error/max error/rmse error/pixels kind bound
    error/standard_errors holds skipped=reason";

/// A measured cell with what follows from it.
#[derive(Serialize)]
struct MeasuredCell<'a> {
    #[serde(flatten)]
    cell: &'a Cell,
    mfragments_per_s: f64,
    bytes_per_fragment: f64,
    bound: Option<f64>,
    holds: Option<bool>,
}

impl<'a> MeasuredCell<'a> {
    fn new(cell: &'a Cell) -> Self {
        Self {
            cell,
            mfragments_per_s: cell.mfragments_per_s(),
            bytes_per_fragment: cell.bytes_per_fragment(),
            bound: cell.bound(),
            holds: cell.holds(),
        }
    }
}

/// A skipped cell with what follows from it.
#[derive(Serialize)]
struct Left<'a> {
    #[serde(flatten)]
    skipped: &'a Skipped,
    pixels: u64,
    fragments: u64,
}

impl<'a> Left<'a> {
    fn new(skipped: &'a Skipped) -> Self {
        let pixels = u64::from(skipped.side) * u64::from(skipped.side);
        Self { skipped, pixels, fragments: pixels * u64::from(skipped.layers) }
    }
}

impl Report<'_> {
    /// The document of `stress.json`.
    pub fn json(&self) -> Value {
        let Self { sweep, settings, device, command } = self;
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
                "methods": settings.entries.iter().map(|entry| entry.name).collect::<Vec<_>>(),
                "frames": settings.frames,
                "max_fragments": settings.max_fragments,
                "max_seconds": settings.max_seconds,
                "seed": settings.seed,
                "memory_budget": settings.memory_budget,
            },
            "cells": sweep.cells.iter().map(MeasuredCell::new).collect::<Vec<_>>(),
            "slopes": sweep.slopes(),
            "skipped": sweep.skipped,
            "areas": sweep.areas,
        })
    }

    fn csv(&self, file: impl Write) -> io::Result<()> {
        let measured = self.sweep.cells.iter().map(|cell| record(&MeasuredCell::new(cell)));
        let left = self.sweep.skipped.iter().map(|skipped| record(&Left::new(skipped)));
        records::csv(file, COLUMNS, measured.chain(left))
    }

    /// The figures with their captions.
    pub(super) fn figures(&self) -> Result<Vec<Drawn>, output::Error> {
        let slopes = self.sweep.slopes();
        let time = |cell: &Cell| [cell.gpu_ms.median, cell.gpu_ms.min, cell.gpu_ms.max];
        let throughput = |cell: &Cell| time(cell).map(|ms| cell.fragments as f64 / (1e3 * ms));
        let memory = |cell: &Cell| [mib(cell.peak_device_bytes); 3];
        let error = |cell: &Cell| [cell.error.max; 3];
        let scale = |label| Axis::tens(label, 0.0);
        Ok(vec![
            Drawn::new(
                "time.svg",
                &self.figure(scale("device time in ms"), &slopes, time),
                html! {
                    b { "Device time of a frame. " }
                    "Points are medians, bars reach from the shortest to the longest time, slopes, if there is room, are those of the table. The dashed line is parallel to everything that "
                    "grows in proportion to the layers."
                },
            )?,
            Drawn::new(
                "throughput.svg",
                &self.figure(scale("million fragments per s"), &[], throughput),
                html! {
                    b { "Fragments over device time. " }
                    "The line is level where each further layer costs as much as the one before; it rises where a frame's fixed cost still counts."
                },
            )?,
            Drawn::new(
                "memory.svg",
                &self.figure(scale("peak device memory in MiB"), &[], memory),
                html! {
                    b { "Largest amount of device memory at any time of a frame, " }
                    "cloud and image included, as the allocator reserves it: in blocks of 8 MiB. The line is level where fragments no longer "
                    "fit and the image is cut into bands."
                },
            )?,
            Drawn::new(
                "error.svg",
                &self.figure(Axis::tens("largest error", ERROR_FLOOR), &[], error),
                html! {
                    b { "Largest difference in linear R, G, B and A from the exact picture in float64, " }
                    "over the pixels compared. That of exact methods is rounding, that of the others is their own. Below 10⁻⁹, equality "
                    "included, it is drawn at 10⁻⁹."
                },
            )?,
        ])
    }

    /// A panel for each scene and size, with (value, least, greatest) of each method over the layers.
    fn figure(&self, y: Axis, slopes: &[Slope], values: impl Fn(&Cell) -> [f64; 3]) -> Figure {
        let names: Vec<_> = self.settings.entries.iter().map(|entry| entry.name).collect();
        let panel = |workload: Workload, side: u32| {
            let series = names.iter().enumerate().map(|(name, method)| {
                let point = |cell: &&Cell| {
                    let [y, low, high] = values(cell);
                    Point { range_y: [low, high], ..Point::new(cell.layers.into(), y) }
                };
                let points = self.sweep.series(workload, side, method);
                let slope = slopes.iter().find(|s| (s.workload, s.side, s.method) == (workload, side, *method));
                let note = |s: &Slope| format!("slope {:.2}", s.law.exponent);
                let slope = slope.filter(|_| names.len() <= MOST_NOTES);
                Series { note: slope.map(note).unwrap_or_default(), ..Series::new(name, points.iter().map(point)) }
            });
            let title = format!("{}, {side} × {side} pixels", workload.name());
            Panel { is_guided: true, ..Panel::new(title, series) }
        };
        let sides = || self.settings.sides.iter().copied();
        Figure {
            x: Axis::twos("layers per pixel"),
            y,
            guide: (!slopes.is_empty()).then_some(Guide { name: "in proportion to the layers", exponent: 1.0 }),
            front: "",
            panel: PANEL,
            columns: self.settings.sides.len(),
            panels: Workload::ALL.iter().flat_map(|workload| sides().map(|side| panel(*workload, side))).collect(),
            names: names.into_iter().map(str::to_owned).collect(),
        }
    }
}

/// Files of the report; `.svg` stands for all figures.
pub const FILES: &[&str] = &["report.html", "stress.csv", "stress.json", ".svg"];

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
    add(&mut files, folder, &figures, &html)?;
    files.publish()
}
