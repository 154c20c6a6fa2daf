//! Runs the sweep on a device.

use std::time::Duration;

use glam::Vec3;
use pellucid_core::progress::Progress;

use super::{Area, Cell, Entry, PassSpread, Settings, Skipped, Spread, Sweep, Workload};
use crate::report::truth::Truth;
use crate::report::unique;
use pellucid_core::camera::Camera;
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Frame, FrameProfile, Rendered, Renderer};
use pellucid_gpu::Device;
use pellucid_scene::{self as scene, Scene, procedural};
use pellucid_session::area::{self, Sampling};

/// World units that soft spheres are farther away than discs, which is more than the largest radius.
const BACK: f64 = 2.0;
/// A frame that takes less is not predicted from: it shows what a frame costs, not what its fragments do.
const NOISE_SECONDS: f64 = 0.01;

/// Part of the longest time of a frame that all pictures of several samples in a pixel may take together.
const AREA_SHARE: f64 = 0.1;

/// Measures every cell within the limits. `progress` counts cells.
///
/// # Errors
/// Errors that end all work: a lost device, a message of the validation layers. Failures of a single method only skip
/// its cell.
pub fn run(device: &Device, settings: &Settings, progress: &Progress) -> Result<Sweep> {
    let mut sweep = Sweep::default();
    for workload in Workload::ALL {
        for &side in &settings.sides {
            for &layers in &settings.layers {
                progress.set_message(format!("{}, {side} × {side} pixels, {layers} layers", workload.name()));
                SweepPosition { workload, side, layers }.measure(device, settings, &mut sweep)?;
                progress.inc(1);
            }
        }
    }
    Ok(sweep)
}

/// A position in the sweep.
#[derive(Debug, Clone, Copy)]
struct SweepPosition {
    workload: Workload,
    side: u32,
    layers: u32,
}

impl SweepPosition {
    fn pixels(self) -> u64 {
        u64::from(self.side) * u64::from(self.side)
    }

    fn fragments(self) -> u64 {
        self.pixels() * u64::from(self.layers)
    }

    /// Adds one cell, measured or skipped, for each entry.
    fn measure(self, device: &Device, settings: &Settings, sweep: &mut Sweep) -> Result<()> {
        let mut entries = Vec::new();
        for &entry in &settings.entries {
            match self.limit(settings, sweep, entry) {
                Some(reason) => sweep.skipped.push(self.skipped(entry, reason)),
                None => entries.push(entry),
            }
        }
        let (soft, discs): (Vec<Entry>, Vec<Entry>) = entries.into_iter().partition(Entry::is_soft);
        for alike in [discs, soft] {
            self.measure_alike(device, settings, sweep, &alike)?;
        }
        Ok(())
    }

    /// Measures entries that all draw the same: discs, or soft spheres.
    fn measure_alike(self, device: &Device, settings: &Settings, sweep: &mut Sweep, entries: &[Entry]) -> Result<()> {
        let Some(first) = entries.first() else { return Ok(()) };
        let (points, camera) = self.scene(settings.seed, first.is_soft())?;
        let frame = |entry: &Entry| Frame {
            memory_budget: settings.memory_budget,
            seed: settings.seed,
            ..Frame::new(camera, [self.side; 2], entry.for_layers(self.opacity()))
        };
        let uploaded = Renderer::new(device).and_then(|renderer| Ok((renderer.upload(&points)?, renderer)));
        let (mut cloud, mut renderer) = match uploaded {
            Ok(uploaded) => uploaded,
            Err(error) => {
                let reason = refusal(error)?;
                sweep.skipped.extend(entries.iter().map(|entry| self.skipped(*entry, reason.clone())));
                return Ok(());
            }
        };
        // Before anything else is on the device.
        let mut runs = Vec::new();
        for entry in entries {
            match Renderer::new(device).and_then(|mut renderer| renderer.render(&mut cloud, &frame(entry))) {
                Ok(first) => runs.push(CellRun { entry: *entry, first, frames: Vec::new() }),
                Err(error) => sweep.skipped.push(self.skipped(*entry, refusal(error)?)),
            }
            device.check_validation()?;
        }
        for round in 0..=settings.frames {
            for mut run in std::mem::take(&mut runs) {
                // The first round pays for buffers, and standard errors take passes of their own.
                let spread = round == 0 && run.entry.method.is_sampled();
                match renderer.render(&mut cloud, &Frame { spread, ..frame(&run.entry) }) {
                    Ok(rendered) => {
                        if spread {
                            run.first.image = rendered.image;
                        } else if round > 0 {
                            run.frames.push(rendered.profile);
                        }
                        runs.push(run);
                    }
                    Err(error) => sweep.skipped.push(self.skipped(run.entry, refusal(error)?)),
                }
            }
        }
        device.check_validation()?;
        let exact = frame(&Entry { method: first.exact(self.opacity()), ..*first });
        let truth = match first.exact(self.opacity()).as_soft() {
            Some(method) => Truth::of_spheres(&points, &exact, method, self.layers, settings.seed),
            None => Truth::new(&points, &exact, settings.seed),
        };
        sweep.cells.extend(runs.into_iter().map(|run| self.cell(points.len(), run, &truth)));
        let seconds = AREA_SHARE * settings.max_seconds;
        match area::sampling(&mut renderer, &mut cloud, &points, (&exact, Vec3::ZERO), seconds) {
            Ok(Sampling::Known(error)) => {
                let Self { workload, side, layers } = self;
                sweep.areas.push(Area { workload, side, layers, error });
            }
            Ok(Sampling::TooSlow(_) | Sampling::Nothing) => {}
            Err(error) => drop(refusal(error)?),
        }
        Ok(())
    }

    fn skipped(self, entry: Entry, reason: String) -> Skipped {
        let Self { workload, side, layers } = self;
        Skipped { workload, side, layers, method: entry.name, reason }
    }

    /// The opacity of a layer: all of them let half of the light through.
    fn opacity(self) -> f64 {
        1.0 - 0.5f64.powf(1.0 / f64::from(self.layers))
    }

    /// Returns the reason why this cell is too much for an entry, if it is.
    fn limit(self, settings: &Settings, sweep: &Sweep, entry: Entry) -> Option<String> {
        let (fragments, most) = (self.fragments(), settings.max_fragments);
        if fragments > most {
            return Some(format!("{fragments} fragments, more than the limit of {most}"));
        }
        let times: Vec<_> = sweep
            .series(self.workload, self.side, entry.name)
            .iter()
            .map(|cell| (f64::from(cell.layers), cell.wall_ms.median / 1e3))
            .collect();
        let seconds = predict(&times, self.layers.into())?;
        (seconds > settings.max_seconds).then(|| {
            let most = settings.max_seconds;
            format!("a frame would take about {seconds:.2} s by the cells before, more than the limit of {most} s")
        })
    }

    /// Points and camera. Soft spheres are seen from farther away, so that none reaches to the near plane.
    fn scene(self, seed: u64, is_soft: bool) -> Result<(Points, Camera)> {
        let name = self.workload.name();
        let parameters = [("layers", self.layers.into()), ("size", self.side.into()), ("opacity", self.opacity())];
        let parameters = parameters.map(|(key, value): (&str, f64)| (key.to_owned(), value));
        let generated = procedural::build(name, &parameters, seed).map_err(scene::Error::from)?;
        let scene = Scene::from_toml(&generated.scene_toml, name.as_ref())?;
        let clouds = scene::take_generated(&scene, &generated)?;
        let up = scene::up_axis(&clouds);
        let mut points = scene::assemble(&scene, clouds, true, &Progress::hidden())?;
        let (mut camera, _) = scene::camera(&scene, &points, up)?;
        if is_soft {
            points.fields = vec![1.0; points.len()];
            camera.eye -= BACK * camera.forward;
            camera.far += BACK;
        }
        Ok((points, camera))
    }

    fn cell(self, points: usize, run: CellRun, truth: &Truth) -> Cell {
        let Self { workload, side, layers } = self;
        let facts = &run.first.facts;
        let expected = run.entry.expected(layers);
        let ms = |time: fn(&FrameProfile) -> Duration| {
            Spread::from_values(run.frames.iter().map(|frame| time(frame).as_secs_f64() * 1e3).collect())
        };
        Cell {
            workload,
            side,
            layers,
            pixels: self.pixels(),
            points: points as u64,
            fragments: self.fragments(),
            counted: (facts.fragments > 0).then_some(facts.fragments),
            method: run.entry.name,
            gpu_ms: ms(FrameProfile::gpu),
            wall_ms: ms(|frame| frame.wall),
            peak_device_bytes: facts.peak_device_bytes,
            fragment_bytes: facts.fragment_bytes,
            bands: facts.bands,
            error: truth.deviation(&run.first.image, expected.roundings()),
            expected,
            passes: passes(&run.frames),
        }
    }
}

/// A method in a cell.
struct CellRun {
    entry: Entry,
    /// Rendered with fresh buffers; the image later has standard errors, if the method knows some.
    first: Rendered,
    frames: Vec<FrameProfile>,
}

/// The reason why a method can't render a cell, in words; fatal errors are passed on.
fn refusal(error: methods::Error) -> Result<String> {
    if error.is_refusal() { Ok(error.to_string()) } else { Err(error.into()) }
}

/// Seconds of a frame of `layers` layers, from (layers, seconds) of the same method before: the last one grown by the
/// power law through the last two, or in proportion to the layers. `None` without any.
pub(in crate::report) fn predict(times: &[(f64, f64)], layers: f64) -> Option<f64> {
    let &(last, seconds) = times.last()?;
    let before = times.iter().rev().nth(1).filter(|(_, before)| *before > NOISE_SECONDS);
    let exponent = before.map_or(1.0, |(layers, before)| (seconds / before).ln() / (last / layers).ln());
    Some(seconds * (layers / last).powf(exponent.max(1.0)))
}

fn passes(frames: &[FrameProfile]) -> Vec<PassSpread> {
    let names = unique(frames.iter().flat_map(|frame| &frame.passes).map(|pass| pass.name));
    let times = |name| frames.iter().flat_map(|f| &f.passes).filter(move |p| p.name == name);
    let ms = |name| Spread::from_values(times(name).map(|pass| pass.gpu.as_secs_f64() * 1e3).collect());
    names.into_iter().map(|name| PassSpread { name, gpu_ms: ms(name) }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_predicted_from_the_cells_before() {
        assert_eq!(predict(&[], 4.0), None);
        assert_eq!(predict(&[(2.0, 3.0)], 4.0), Some(6.0));
        // Quadratic: twice the layers, four times the time, and that again for one step and for two.
        let quadratic = [(1.0, 0.5), (2.0, 1.0), (4.0, 4.0)];
        assert!((predict(&quadratic, 8.0).unwrap() - 16.0).abs() < 1e-9);
        assert!((predict(&quadratic, 16.0).unwrap() - 64.0).abs() < 1e-9);
        // Times that hardly grew, or were too short, are assumed to grow with the layers.
        assert_eq!(predict(&[(1.0, 1.0), (2.0, 1.0)], 4.0), Some(2.0));
        assert_eq!(predict(&[(1.0, 0.001), (2.0, 1.0)], 4.0), Some(2.0));
    }

    #[test]
    fn a_limit_of_a_method_is_a_reason_and_a_lost_device_is_an_error() {
        let reason = refusal(methods::Error::PixelOverflow { x: 3, y: 4 }).unwrap();
        assert!(reason.contains("pixel (3, 4)"), "{reason}");
        assert!(refusal(pellucid_gpu::Error::Lost { during: "a test".into() }.into()).is_err());
    }
}
