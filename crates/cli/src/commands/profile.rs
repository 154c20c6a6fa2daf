//! `pellucid profile`.

use std::path::PathBuf;

use clap::Args;
use pellucid_core::camera::StatedCamera;
use pellucid_engine::methods::{Outputs, Rendered, Stop};
use pellucid_engine::pipelines::Pipelines;
use pellucid_engine::totals::Effort;
use pellucid_engine::{Result, profile};
use pellucid_gpu::{Capture, DeviceOptions};
use pellucid_session::{FrameRequest, Measuring, Prepared, Request, Session};

use super::along::{Along, PathArgs};
use super::bar::Bar;
use super::console::Console;
use super::input::InputArgs;
use super::limit::usage;
use super::measured::FrameProfiles;
use super::options::{self, DeviceArgs, MeasureArgs, one_of};
use super::touched::{Touched, Touches};

#[derive(Debug, Args)]
pub struct ProfileArgs {
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub measure: MeasureArgs,
    /// Write the time of each pass and of each phase on the CPU as JSON; the same as --profile.
    #[arg(short, long, value_name = "FILE.json", conflicts_with = "profile")]
    output: Option<PathBuf>,
    /// Number of frames to measure; by default 5.
    ///
    /// With --path or --turntable the number of frames on the path. Each is measured once, and the JSON has its camera.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000), help_heading = super::headings::FRAMES)]
    pub frames: Option<u32>,
    #[command(flatten)]
    pub along: PathArgs,
    /// Measure frames whose counts are foreseen, as those of a window or a film.
    ///
    /// `totals` has the times of 30 more of them, or of so many as --frames says, without timestamps between passes and
    /// after 0.3 s of warm-up; those of a device whose clock moved meanwhile are marked and must not be used.
    ///
    /// Such a frame waits for the device once at most. Without this option each frame waits for its own counts, as a
    /// single picture does. Frames of clouds that stay in their files, of pictures in several parts, and frames longer
    /// than a second wait in any case; a note then says so, and `frames[].waits` has the number.
    #[arg(long, help_heading = super::headings::FRAMES)]
    pub steady: bool,
    /// Accuracy of the frames, that of an EXR or that of a PNG.
    ///
    /// For an EXR every fragment that changes a bit is blended. For a PNG the methods sorted and abuffer stop when no
    /// 8-bit value would change by more than a quarter of a step. Other methods take the same time for both.
    #[arg(long = "for", value_name = "FORMAT", default_value = "exr")]
    #[arg(value_parser = one_of(&[("exr", Stop::Exact), ("png", Stop::EightBit { transparent: false })]))]
    stop: Stop,
    /// Show what the driver's compiler made of each pass: registers, spills, shared memory, size of the code.
    ///
    /// Shaders are compiled anew. Where the driver doesn't tell (VK_KHR_pipeline_executable_properties) a sentence says
    /// so.
    #[arg(long, help_heading = super::headings::MEASUREMENTS)]
    pub pipelines: bool,
    /// Have RenderDoc capture frame N, counted from 1.
    ///
    /// Start pellucid from RenderDoc or by `renderdoccmd capture`, or set ENABLE_VULKAN_RENDERDOC_CAPTURE=1. The frame
    /// is rendered once more for it, so that its times are those without. --debug-shaders shows the source of shaders.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    #[arg(help_heading = super::headings::MEASUREMENTS)]
    pub capture: Option<u32>,
    /// Print JSON instead of the table, as --profile writes it.
    #[arg(long)]
    pub json: bool,
}

/// Default number of frames of a camera at rest.
pub const DEFAULT_FRAMES: u32 = 5;

impl ProfileArgs {
    /// The files of measurements, of which `-o` may name one.
    pub fn files(&mut self) -> &MeasureArgs {
        if let Some(output) = self.output.take() {
            self.measure.profile = Some(output);
        }
        &self.measure
    }

    /// Length of the measurement at a steady clock: as many frames as are asked for, if any are.
    fn effort(&self) -> Effort {
        let frames = self.frames.map_or(Effort::RELIABLE.frames, |frames| frames as usize);
        Effort { frames, ..Effort::RELIABLE }
    }

    /// Reads the inputs, and finds the camera of each frame.
    pub fn prepare(&self, progress: &Bar) -> Result<(Prepared, Vec<StatedCamera>)> {
        let (memory_budget, stop) = (self.device.budget(), self.stop);
        let frame = FrameRequest { memory_budget, counts: true, stop, ..FrameRequest::default() };
        let along = self.along.course(self.frames, &self.input, progress.console)?;
        let size = along.as_ref().and_then(Along::size);
        let request = Request { frame, ..self.input.request(size, progress)? };
        if let Some(along) = along {
            return along.prepare(request, progress);
        }
        let prepared = Prepared::new(request, progress, progress)?;
        let cameras = vec![prepared.camera; self.frames.unwrap_or(DEFAULT_FRAMES) as usize];
        Ok((prepared, cameras))
    }
}

impl Touches for ProfileArgs {
    fn touched(&self) -> Result<Touched> {
        Ok(Touched::reads(self.along.reads(&self.input))
            .and(self.measure.writes())
            .writes("-o", self.output.as_deref()))
    }
}

pub fn run(mut args: ProfileArgs, console: Console) -> Result<()> {
    args.files().check()?;
    let progress = console.progress();
    let (prepared, cameras) = args.prepare(&progress)?;
    let options = DeviceOptions { statistics: args.pipelines, ..args.device.options() };
    let device = options::open(&options, &progress)?;
    let capture = args.capture.map(|number| capture(number, cameras.len())).transpose()?;
    let mut session = Session::open(&device, prepared, &progress, &progress)?;
    session.describe(&progress);
    // The first frame pays for pipelines and buffers.
    session.renderer.notes_tiles = true;
    let first = session.first(Outputs::default(), &progress)?;
    session.renderer.notes_tiles = false;
    let shadows = first.profile.passes.iter().filter(|pass| pass.name.starts_with("shadows/"));
    let casting_ms = shadows.map(|pass| pass.gpu.as_secs_f64() * 1e3).sum::<f64>();
    if first.facts.light_views > 0 {
        let views = first.facts.light_views;
        console.note(format_args!(
            "shadows: {casting_ms:.2} ms on the device for {views} image(s) of a light, in the first frame only (not in the \
             table)"
        ));
    }
    let mut profile = session.profile();
    profile.steady = Some(args.steady);
    profile.tile_histogram = Some(first.facts.tile_histogram.clone());
    let counted_facts = (first.facts.fragments, first.facts.max_list);
    let histogram = first.image.fragments.as_deref().map(profile::histogram).unwrap_or_default();
    let on_demand = session.frame.counts_on_demand();
    // Windows and films don't ask for the lengths of lists either.
    let uncounted = on_demand || args.steady;
    if uncounted {
        // The first frame counted the lists, which the method itself has no use for.
        session.frame.fragments = false;
    }
    session.renderer.recycle(first.image);
    progress.counted("measuring", cameras.len() as u64);
    let mut measured = FrameProfiles::default();
    let moves = args.along.option().is_some();
    let mut measuring = Measuring::new(args.steady);
    let mut hindrance = None;
    for (number, camera) in cameras.iter().enumerate() {
        session.look_through(*camera);
        let counted = if moves && uncounted { Some(count_lists(&mut session)?) } else { None };
        if let Some((_, capture)) = capture.as_ref().filter(|(captured, _)| *captured == number) {
            console.note(format_args!("frame {} is captured: {}", number + 1, captured(capture, &mut session)?));
        }
        let mut rendered = measuring.frame(&mut session)?;
        hindrance = hindrance.or(measuring.hindrance(&session, &rendered));
        if let Some(counted) = counted {
            rendered.facts.fragments = counted.facts.fragments;
            rendered.facts.max_list = counted.facts.max_list;
            rendered.image.fragments = counted.image.fragments;
        }
        profile.add(&rendered);
        if moves {
            measured.add(number, camera, None, &session, &rendered);
        }
        progress.inc(1);
    }
    if args.steady && !moves {
        profile.totals = Some(session.totals(args.effort())?);
    }
    session.add_phases(&mut profile);
    if args.pipelines {
        profile.pipelines = Pipelines::of(&session.device)?;
    }
    // The table's alone.
    let copy_rate = if args.json { None } else { Some(profile::copy_rate(&session.device)?) };
    progress.finish_and_clear();
    if let Some(reason) = hindrance {
        console.note(format_args!("--steady: the frames wait for their counts, because {reason}"));
    }
    if !moves {
        (profile.facts.fragments, profile.facts.max_list) = counted_facts;
        profile.list_histogram = histogram;
    }
    let json = if moves { measured.to_json(&profile) } else { profile.to_json() };
    args.measure.write(&json, || profile.to_trace())?;
    if args.json {
        return console.print_json(&json);
    }
    console.print(&format!("{}\n", pellucid_lab::profile_table(&profile, copy_rate)))
}

/// Finds RenderDoc, and the place of frame `number` among those that there are.
fn capture(number: u32, frames: usize) -> Result<(usize, Capture)> {
    let place = number as usize - 1;
    if place >= frames {
        return Err(usage(format!("--capture {number}: there are only {frames} frames")));
    }
    Ok((place, Capture::open()?))
}

/// Renders a frame that RenderDoc captures; returns the path of the capture.
fn captured(capture: &Capture, session: &mut Session) -> Result<String> {
    let (rendered, path) = capture.around(|| session.render());
    session.renderer.recycle(rendered?.image);
    Ok(path?)
}

/// Renders a frame with counted lists, for methods that don't need the counts; its times must not be used.
fn count_lists(session: &mut Session) -> Result<Rendered> {
    session.frame.fragments = true;
    let counted = session.render();
    session.frame.fragments = false;
    counted
}
