//! A device with the scene on it, shared by `render`, `profile` and `plan`.

use std::io::Write;
use std::path::Path;

use serde_json::Value;

use super::bar::Bar;
use pellucid_engine::gpu::{Device, DeviceOptions};
use pellucid_engine::image::Image;
use pellucid_engine::methods::brightness::{self, Applied};
use pellucid_engine::methods::see_through::{self, Found};
#[cfg(feature = "mpi")]
use pellucid_engine::methods::{DrawnPart, SamplePart};
use pellucid_engine::methods::{Frame, PassProfile, Rendered, Renderer, Stop};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::profile::Profile;
use pellucid_engine::progress::{Phase, Progress};
use pellucid_engine::scene::{Detail, made};
use pellucid_engine::{Result, output, plan};
use pellucid_lab::frame_notes;

use super::console::Console;
use super::loaded::Resolved;
use super::opacity_notes;
use super::{DeviceArgs, MeasureArgs};

pub struct Session {
    pub device: Device,
    pub renderer: Renderer,
    pub cloud: DeviceCloud,
    pub frame: Frame,
    /// The reason for the method.
    pub why: String,
    /// The opacity that `--see-through` asked for.
    pub see_through: Option<Found>,
    /// Of the whole command.
    progress: Progress,
}

impl Session {
    /// Opens the device, uploads the points and decides the method.
    pub fn open(args: &DeviceArgs, resolved: &Resolved, fragments: bool, stop: Stop, progress: &Bar) -> Result<Self> {
        let mut session = Self::upload(args, resolved, fragments, stop, progress)?;
        // On a device that was not met before, `auto` measures it first.
        progress.begin(Phase::Frame);
        progress.stage("choosing the method");
        let Self { renderer, cloud, frame, .. } = &mut session;
        (session.frame.method, session.why) =
            plan::choose(renderer, cloud, resolved.points(), resolved.scene.method, frame)?;
        session.find_opacity(resolved, progress)?;
        progress.stage("rendering");
        Ok(session)
    }

    /// Finds the opacity that `--see-through` asks for.
    pub fn find_opacity(&mut self, resolved: &Resolved, progress: &Bar) -> Result<()> {
        let Some(share) = resolved.see_through else { return Ok(()) };
        if let Some(found) = resolved.opacity_found {
            self.see_through = Some(found);
            self.frame.factors.opacity = found.factor;
            return Ok(());
        }
        progress.stage("finding the opacity");
        let Self { renderer, cloud, frame, .. } = self;
        self.see_through =
            see_through::find(renderer, cloud, frame, share, see_through::largest_factor(resolved.points()))?;
        frame.factors.opacity = self.see_through.map_or(1.0, |found| found.factor);
        self.device.check_validation()?;
        Ok(())
    }

    /// Opens the device and uploads the points; the method is the scene's, or for `auto` one of the same image.
    pub fn upload(args: &DeviceArgs, resolved: &Resolved, fragments: bool, stop: Stop, progress: &Bar) -> Result<Self> {
        progress.begin(Phase::Upload);
        progress.stage("uploading");
        let options = DeviceOptions { device: args.device.clone(), ..DeviceOptions::from_env() };
        let device = Device::open(&options)?;
        let mut frame = Frame {
            memory_budget: args.memory_budget.map(|b| b.as_u64()),
            fragments,
            stop,
            ..Frame::of_scene(&resolved.scene, resolved.camera, resolved.seed)
        };
        if resolved.see_through.is_some() {
            // Before it is found, the opacity is one that can be seen through: `auto` takes a method for that.
            frame.factors.opacity = 0.5;
        }
        let renderer = Renderer::new(&device)?;
        let cloud = match &resolved.arranged {
            Arranged::Canonical(points) if resolved.by_windows => renderer.supply_held(points)?,
            arranged => renderer.upload_for(&frame.detail, arranged, resolved.shadow_texture.as_ref())?,
        };
        Ok(Self {
            device,
            renderer,
            cloud,
            frame,
            why: String::new(),
            see_through: None,
            progress: (**progress).clone(),
        })
    }

    /// Reports the device, the method, and the size of the input.
    pub fn describe(&self, console: Console) {
        let info = self.device.info();
        console.detail(format_args!("device {} ({})", info.name, info.driver));
        console.detail(format_args!("method {}: {}", self.frame.method.name(), self.why));
        let [width, height] = self.frame.size;
        console.detail(format_args!("{} points, {width} × {height} pixels", self.cloud.total()));
    }

    /// Says which opacity was found, and warns of clouds that don't come out as asked.
    pub fn warn(&self, resolved: &Resolved, console: Console) {
        if let Some(share) = resolved.see_through {
            opacity_notes::describe(share, self.see_through, resolved, console);
        }
        let names = made::cloud_names(&resolved.scene, &resolved.arranged);
        let warnings = frame_notes::warnings(&names, &resolved.arranged, &self.cloud, &self.frame, &self.why);
        warnings.iter().for_each(|warning| console.warn(warning));
    }

    /// Reports the counts and times of a frame.
    pub fn describe_frame(rendered: &Rendered, console: Console) {
        let Rendered { facts, profile, .. } = rendered;
        if facts.fragments > 0 {
            console.detail(format_args!(
                "{} fragments, the longest list {}, in {} band(s)",
                facts.fragments, facts.max_list, facts.bands
            ));
        }
        if facts.layers > 0 {
            console.detail(format_args!("{} layers peeled", facts.layers));
        }
        if facts.samples > 0 {
            console.detail(format_args!("{} samples per pixel", facts.samples));
        }
        console.detail(format_args!(
            "frame {:.1} ms, of which {:.1} ms in passes; device memory at most {}",
            profile.wall.as_secs_f64() * 1e3,
            profile.gpu().as_secs_f64() * 1e3,
            bytesize::ByteSize(facts.peak_device_bytes)
        ));
        let pass = |pass: &PassProfile| format!("{} {:.1} ms", pass.name, pass.gpu.as_secs_f64() * 1e3);
        let passes: Vec<String> = profile.passes.iter().map(pass).collect();
        console.detail(format_args!("passes: {}", passes.join(", ")));
    }

    /// Has frames leave points out, or none.
    pub fn take_detail(&mut self, detail: Detail, resolved: &Resolved) -> Result<()> {
        if !detail.is_whole() && self.cloud.supply().is_none() {
            self.cloud = self.renderer.upload_for(&detail, &resolved.arranged, None)?;
        }
        self.frame.detail = detail;
        Ok(())
    }

    /// Reports what was left out of the last frame.
    pub fn describe_detail(&self, console: Console) {
        if let Some(cut) = self.cloud.cut_in_force() {
            let (points, all, px) = (cut.points(), self.cloud.total(), cut.px());
            console.detail(format_args!("levels of detail: {points} of {all} points, at most {px:.2} pixels apart"));
        }
    }

    /// Renders one frame; validation messages are an error.
    pub fn render(&mut self) -> Result<Rendered> {
        self.progress.begin(Phase::Frame);
        let rendered = self.renderer.render(&mut self.cloud, &self.frame)?;
        self.device.check_validation()?;
        Ok(rendered)
    }

    /// Draws some of the samples of a frame; validation messages are an error.
    #[cfg(feature = "mpi")]
    pub fn draw_part(&mut self, samples: std::ops::Range<u32>) -> Result<DrawnPart> {
        self.progress.begin(Phase::Frame);
        let drawn = self.renderer.draw_part(&mut self.cloud, &self.frame, samples)?;
        self.device.check_validation()?;
        Ok(drawn)
    }

    /// The frame whose samples were drawn in parts.
    #[cfg(feature = "mpi")]
    pub fn resolve(&mut self, parts: &SamplePart) -> Result<Rendered> {
        let rendered = self.renderer.resolve_parts(&self.cloud, &self.frame, parts)?;
        self.device.check_validation()?;
        Ok(rendered)
    }

    /// Brightens a frame's image if its method is to do so; by how much.
    pub fn brighten(&mut self, image: &mut Image) -> Result<Option<Applied>> {
        let applied = brightness::apply(&mut self.renderer, &mut self.cloud, &self.frame, image)?;
        self.device.check_validation()?;
        Ok(applied)
    }

    /// A profile without frames.
    pub fn profile(&self) -> Profile {
        Profile::new(&self.device, &self.frame)
    }

    /// The rest of the command writes what was rendered.
    pub fn begin_writing(&self) {
        self.progress.begin(Phase::Write);
    }

    /// Adds the phases of the command so far to a profile.
    pub fn add_phases(&self, profile: &mut Profile) {
        profile.add_host(self.progress.spans(), &self.device.compilations());
    }
}

impl MeasureArgs {
    /// Writes the files that were asked for.
    pub fn write(&self, profile: &Profile) -> Result<()> {
        self.write_profile(&profile.to_json())?;
        self.write_trace(profile)
    }

    /// Writes the profile, if it was asked for.
    pub fn write_profile(&self, profile: &Value) -> Result<()> {
        match &self.profile {
            Some(path) => write_json(path, profile),
            None => Ok(()),
        }
    }

    /// Writes the trace, if it was asked for.
    pub fn write_trace(&self, profile: &Profile) -> Result<()> {
        if let Some(path) = &self.trace {
            write_json(path, &profile.to_trace())?;
        }
        Ok(())
    }
}

/// Writes a value as JSON, all or nothing.
pub fn write_json(path: &Path, value: &Value) -> Result<()> {
    output::write_atomically(path, |file| writeln!(file, "{value:#}"))?;
    Ok(())
}
