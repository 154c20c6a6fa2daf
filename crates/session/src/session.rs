//! A scene on a device: from a request to a frame, and from a frame to a picture.

mod sampling;

use std::ops::Range;

use glam::Vec3;
use pellucid_core::camera::StatedCamera;
use pellucid_core::image::Image;
use pellucid_core::points::{Changes, Points};
use pellucid_core::progress::{Phase, Progress};
use pellucid_engine::Result;
use pellucid_engine::methods::brightness::{self, Applied};
use pellucid_engine::methods::see_through::{self, OpacityFactor};
use pellucid_engine::methods::{
    DrawnPart, Error as FrameError, Frame, Outputs, PassProfile, Rendered, Renderer, SamplePart,
};
use pellucid_engine::passes::project::{DeviceCloud, Parts};
use pellucid_engine::plan;
use pellucid_engine::profile::{self, Profile};
use pellucid_engine::totals::{self, Effort, Totals};
use pellucid_gpu::{Device, Yardstick};
use pellucid_io::output::WriteOptions;
use pellucid_io::peak_memory;
use pellucid_scene::stored::Stored;
use pellucid_scene::{self as scene, Method, MethodChoice, Samples, Scene};

use crate::assembled::Assembled;
use crate::choice::{self, Choice, ChoiceFrame, Wish};
use crate::messages::{Messages, Told};
use crate::prepared::Prepared;
use crate::request::Request;
use crate::samples::{self, SettledSamples};
use crate::uploaded::Uploaded;
use crate::{notes, prepared, soft_points};

/// Factor on opacities before one is found: a scene that can be seen through, so that `auto` takes a method for that.
const UNKNOWN_OPACITY: f32 = 0.5;

/// A way to render a frame.
type Render = fn(&mut Renderer, &mut DeviceCloud, &Frame) -> Result<Rendered, FrameError>;

/// A scene on a device, and the frame that was requested last.
pub struct Session {
    /// The device.
    pub device: Device,
    /// The renderer of its frames.
    pub renderer: Renderer,
    /// The request with points and camera.
    pub prepared: Prepared,
    /// The frame of the request.
    pub frame: Frame,
    /// Reason for the method.
    pub why: String,
    /// Opacity that a share of light was requested for.
    pub found: Option<OpacityFactor>,
    /// Opacity found for a larger scene that this one is a part of; then none is looked for.
    pub opacity_of_whole: Option<OpacityFactor>,
    /// `true` for a part of a larger scene. Whatever doesn't come out as requested is said of the whole.
    pub is_part: bool,
    /// Method chosen by error or time.
    pub choice: Option<Choice>,
    /// Samples per pixel that `image.samples = "auto"` was settled to ([`Self::settle`]).
    pub settled: Option<SettledSamples>,
    /// The points on the device.
    pub uploaded: Uploaded,
    /// Facts that method and opacity follow from.
    decided: Option<Decided>,
    /// The threshold of the method, and how many points it makes soft.
    parts: Option<(f32, Parts)>,
    /// `true` once a picture was judged by its opacities.
    is_judged: bool,
    /// Warnings that were given already.
    told: Told,
    progress: Progress,
}

/// Everything that method and opacity follow from, given the points.
#[derive(PartialEq)]
struct Decided {
    method: MethodChoice,
    background: Vec3,
    frame: Frame,
    see_through: Option<f64>,
    wish: Option<Wish>,
    only: Option<String>,
    samples: Samples,
    sampling_error: f32,
}

impl Session {
    /// Brings a prepared request to a device, and decides method and opacity.
    ///
    /// # Errors
    /// Returns an error if the device has no room for the points or fails, or if no method can render the frame.
    pub fn open(device: &Device, prepared: Prepared, messages: &dyn Messages, progress: &Progress) -> Result<Self> {
        let mut session = Self::upload(device, prepared, false, progress)?;
        session.decide(messages)?;
        Ok(session)
    }

    /// Brings a prepared request to a device; the method is the scene's, or for `auto` one of the same image. With
    /// `by_windows` points in memory come to the device window by window, even if it has room for all.
    ///
    /// # Errors
    /// Returns an error if the device has no room for the points.
    pub fn upload(device: &Device, prepared: Prepared, by_windows: bool, progress: &Progress) -> Result<Self> {
        progress.begin(Phase::Upload);
        progress.set_message("uploading");
        let mut renderer = Renderer::new(device)?;
        renderer.progress = progress.clone();
        let uploaded = Uploaded::new(&renderer, &prepared.assembled, &prepared.scene().detail, by_windows)?;
        Ok(Self::of(renderer, prepared, uploaded, progress))
    }

    /// Returns the session of a prepared request whose points a renderer has brought to the device; the method is that
    /// of [`Self::upload`].
    pub fn of(renderer: Renderer, prepared: Prepared, uploaded: Uploaded, progress: &Progress) -> Self {
        let frame = undecided(&prepared);
        Self {
            device: renderer.device().clone(),
            renderer,
            prepared,
            frame,
            why: String::new(),
            found: None,
            opacity_of_whole: None,
            is_part: false,
            choice: None,
            settled: None,
            uploaded,
            decided: None,
            parts: None,
            is_judged: false,
            told: Told::default(),
            progress: progress.clone(),
        }
    }

    /// Makes everything ready for the frame of another request of the same clouds: makes again only what depends on
    /// keys that changed ([`Recipe`](pellucid_scene::Recipe)).
    /// Returns `true` if method and opacity were decided anew.
    ///
    /// # Errors
    /// Returns the errors of [`Opened::prepare`](crate::Opened::prepare) and [`Self::open`]. The next request is then
    /// decided anew.
    pub fn update(&mut self, request: Request, messages: &dyn Messages, progress: &Progress) -> Result<bool> {
        prepared::check(&request, messages)?;
        self.renderer.progress = progress.clone();
        self.progress = progress.clone();
        let decided = self.decided.take();
        let is_other_form = request.wanted.radii != self.prepared.assembled.wanted().radii;
        let followed = if is_other_form { None } else { self.follow(&request, progress)? };
        // Method and opacity follow from the points.
        let decided = decided.filter(|_| followed.is_some_and(|changes| !changes.any()));
        if followed.is_none() {
            self.make_again(request, messages, progress)?;
        } else {
            let camera = self.camera(&request.scene, messages)?;
            self.prepared.request = request;
            self.prepared.camera = camera;
            let once = self.told.to(messages);
            self.prepared.scene().warnings.iter().for_each(|warning| once.warn(warning));
        }
        let Self { uploaded, renderer, prepared, .. } = self;
        uploaded.allow_detail(renderer, &prepared.assembled, &prepared.assembled.scene.detail)?;
        self.decide_after(decided, messages)
    }

    /// Turns the points into those of a request of the same clouds. Returns the changes since the last success, or
    /// `None` if the points must be made again. Request, camera and frame stay those from before.
    ///
    /// # Errors
    /// Returns the errors of [`Uploaded::follow`], and an error if a file can't be read.
    pub fn follow(&mut self, request: &Request, progress: &Progress) -> Result<Option<Changes>> {
        let Self { renderer, uploaded, prepared, decided, .. } = self;
        *decided = None;
        let Prepared { assembled, sources, .. } = prepared;
        sources.complete(&request.scene, progress)?;
        uploaded.follow(renderer, assembled, sources, (&request.scene, request.wanted.seed), progress)
    }

    /// Makes the points of a request, again from clouds in memory, or from their files.
    fn make_again(&mut self, request: Request, messages: &dyn Messages, progress: &Progress) -> Result<()> {
        let once = self.told.to(messages);
        if request.wanted.is_edited {
            self.prepared.make_again(request, &once, progress)?;
        } else {
            self.prepared = Prepared::new(request, &once, progress)?;
        }
        progress.begin(Phase::Upload);
        progress.set_message("uploading");
        let detail = self.prepared.scene().detail;
        self.uploaded = Uploaded::new(&self.renderer, &self.prepared.assembled, &detail, false)?;
        Ok(())
    }

    /// Returns the camera of another scene of the same points.
    fn camera(&self, scene: &Scene, messages: &dyn Messages) -> Result<StatedCamera> {
        let known = &self.prepared.request.scene;
        if known.camera == scene.camera && known.image.size == scene.image.size {
            return Ok(self.prepared.camera);
        }
        let points = self.prepared.points();
        let given = self.prepared.bounds.filter(|_| !scene.camera.view.is_given());
        let given = given.and_then(|bounds| scene::stated_camera_at(&scene.camera, &bounds, points.largest_radius()));
        if let Some(camera) = given {
            return Ok(camera);
        }
        let (camera, warnings) = scene::stated_camera(scene, points, self.prepared.assembled.up)?;
        let once = self.told.to(messages);
        warnings.iter().for_each(|warning| once.warn(warning));
        Ok(camera)
    }

    /// Looks at the points through another camera, until a request asks for another one than the last did.
    pub fn look_through(&mut self, camera: StatedCamera) {
        self.prepared.camera = camera;
        self.frame.camera = camera.camera();
    }

    /// Decides method and opacity.
    ///
    /// # Errors
    /// Returns an error if a frame can't be rendered, or if the device fails.
    pub fn decide(&mut self, messages: &dyn Messages) -> Result<()> {
        self.decide_after(None, messages)?;
        Ok(())
    }

    /// Renders the request by a method that was decided before, for the reason `why`.
    pub fn keep_method(&mut self, method: Method, why: String) {
        (self.frame, self.why) = (Frame { method, ..undecided(&self.prepared) }, why);
        (self.found, self.choice, self.parts, self.settled) = (None, None, None, None);
    }

    /// Decides method and opacity, unless nothing changed of what the last ones followed from.
    fn decide_after(&mut self, last: Option<Decided>, messages: &dyn Messages) -> Result<bool> {
        let wish = self.wish(messages);
        let frame = undecided(&self.prepared);
        let Scene { method, image, .. } = self.prepared.scene();
        let asked = Decided {
            method: *method,
            background: image.background.color(),
            frame,
            see_through: self.prepared.see_through(),
            wish,
            only: self.prepared.request.choice.only.clone(),
            samples: image.samples,
            sampling_error: image.sampling_error,
        };
        let is_new = last.as_ref() != Some(&asked);
        if is_new {
            self.frame = frame;
            (self.found, self.choice, self.settled, self.is_judged) = (None, None, None, false);
            self.progress.begin(Phase::Frame);
            self.progress.set_message("choosing the method");
            match wish {
                Some(wish) => {
                    self.find_opacity()?;
                    self.choose(wish, messages)?;
                }
                None => {
                    let (method, points) = (self.prepared.scene().method, self.prepared.points());
                    (self.frame.method, self.why) =
                        plan::choose(&self.renderer, &self.uploaded.cloud, points, method, &self.frame);
                    self.find_opacity()?;
                }
            }
        }
        if let Some(found) = self.found {
            // Factors of the request, such as those of a slider, need no search.
            self.frame.factors.opacity = found.factor * self.prepared.request.frame.factors.opacity;
        }
        self.find_parts()?;
        self.progress.set_message("rendering");
        self.decided = Some(asked);
        Ok(is_new)
    }

    /// Counts soft points, if the method tells them from solid ones.
    fn find_parts(&mut self) -> Result<()> {
        self.parts = None;
        let Some(threshold) = self.frame.method.threshold().filter(|_| !self.is_part) else { return Ok(()) };
        let cloud = &mut self.uploaded.cloud;
        cloud.find_parts(threshold, &self.progress)?;
        self.parts = Some((threshold, cloud.parts(threshold)));
        Ok(())
    }

    /// Says so where no point is soft though the method is made for those.
    fn without_soft_points(&self) -> Option<String> {
        self.parts.and_then(|(threshold, parts)| soft_points::none(&parts, threshold))
    }

    /// Returns the limits by which the method is chosen, and says so where they have no effect.
    fn wish(&self, messages: &dyn Messages) -> Option<Wish> {
        let wish = Some(self.prepared.request.choice.wish).filter(Wish::is_any)?;
        let Some(reason) = Wish::hindrance(self.scene(), self.points()) else { return Some(wish) };
        let [error, time] = ["max-error", "budget"].map(|option| messages.name(option));
        self.told.to(messages).warn(&format_args!("{error} and {time} have no effect {reason}"));
        None
    }

    /// Chooses the method and its setting by the limits that they must keep to.
    fn choose(&mut self, wish: Wish, messages: &dyn Messages) -> Result<()> {
        let Self { device, renderer, prepared, frame, uploaded, progress, .. } = self;
        let request = &prepared.request.choice;
        let subject = ChoiceFrame {
            arranged: prepared.assembled.arranged(),
            frame: *frame,
            background: prepared.scene().image.background.color(),
            only: request.only.as_deref(),
        };
        let choice = choice::choose(device, &mut uploaded.cloud, &subject, wish, request.recalibrate, progress)?;
        progress.set_message("rendering");
        choice.describe(messages);
        uploaded.allow_detail(renderer, &prepared.assembled, &choice.detail)?;
        (self.frame.method, self.frame.detail) = (choice.method, choice.detail);
        self.frame.samples = choice.samples.unwrap_or(self.frame.samples);
        self.why = "chosen by what was measured on this scene".to_owned();
        self.choice = Some(choice);
        Ok(())
    }

    /// Finds the opacity at which the median covered pixel lets the requested share of the light through.
    ///
    /// # Errors
    /// Returns an error if a frame can't be rendered, or if the device fails.
    pub fn find_opacity(&mut self) -> Result<()> {
        let Some(share) = self.prepared.see_through() else { return Ok(()) };
        if let Some(found) = self.opacity_of_whole {
            self.found = Some(found);
            self.frame.factors.opacity = found.factor;
            return Ok(());
        }
        self.progress.set_message("finding the opacity");
        let Self { renderer, uploaded, frame, prepared, .. } = self;
        let largest = see_through::largest_factor(prepared.points());
        self.found = see_through::find(renderer, &mut uploaded.cloud, frame, share, largest)?;
        self.frame.factors.opacity = self.found.map_or(1.0, |found| found.factor);
        self.device.check_validation()?;
        Ok(())
    }

    /// Returns all points on the host, or a sample of those that stay in files.
    pub fn points(&self) -> &Points {
        self.prepared.points()
    }

    /// Returns the points and facts about them.
    pub fn assembled(&self) -> &Assembled {
        &self.prepared.assembled
    }

    /// Returns the scene in force.
    pub fn scene(&self) -> &Scene {
        self.prepared.scene()
    }

    /// Reports the device, the method, and the size of the input, and what [`Self::warn`] does.
    pub fn describe(&self, messages: &dyn Messages) {
        let info = self.device.info();
        messages.detail(&format_args!("device {} ({})", info.name, info.driver));
        messages.detail(&format_args!("method {}: {}", self.frame.method.name(), self.why));
        let [width, height] = self.frame.size;
        messages.detail(&format_args!("{} points, {width} × {height} pixels", self.uploaded.cloud.total()));
        if let Some((threshold, parts)) = &self.parts {
            messages.detail(&soft_points::count(parts, *threshold));
        }
        self.warn(messages);
    }

    /// Says which opacity was found, if one was looked for. Where the number of samples is still to be found, so is
    /// the opacity for it.
    pub fn describe_opacity(&self, messages: &dyn Messages) {
        if let Some(share) = self.prepared.see_through().filter(|_| !self.is_unsettled()) {
            notes::describe_opacity(share, self.found, &self.prepared, messages);
        }
    }

    /// Says which opacity was found, and warns of settings and clouds that don't come out as requested.
    pub fn warn(&self, messages: &dyn Messages) {
        if self.is_part {
            return;
        }
        self.describe_opacity(messages);
        let once = self.told.to(messages);
        let warnings = notes::warnings(&self.prepared, &self.uploaded.cloud, &self.frame, &self.why);
        warnings.iter().chain(&self.without_soft_points()).for_each(|warning| once.warn(warning));
    }

    /// Renders one frame; validation messages are an error.
    ///
    /// # Errors
    /// Returns an error if the frame does not fit, if it was canceled, or if the device fails.
    pub fn render(&mut self) -> Result<Rendered> {
        self.render_by(Renderer::render, self.frame.outputs)
    }

    /// Renders one frame like [`Self::render`], of which the host needs these outputs alone.
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`].
    pub fn render_for(&mut self, outputs: Outputs) -> Result<Rendered> {
        self.render_by(Renderer::render, outputs)
    }

    /// Renders one frame, and finds its device time as a whole ([`Renderer::render_whole`]).
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`].
    pub fn render_whole(&mut self) -> Result<Rendered> {
        self.render_by(Renderer::render_whole, self.frame.outputs)
    }

    /// Measures the session's frame at a steady clock ([`totals::measure`]).
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`], and an error if the device has no room for the calibration.
    pub fn totals(&mut self, effort: Effort) -> Result<Totals> {
        let yardstick = Yardstick::new(&self.device)?;
        let frame = self.frame;
        let found = totals::measure(&mut self.renderer, &mut self.uploaded.cloud, &frame, Some(&yardstick), effort)?;
        self.device.check_validation()?;
        Ok(found)
    }

    fn render_by(&mut self, render: Render, outputs: Outputs) -> Result<Rendered> {
        self.progress.begin(Phase::Frame);
        // Trial frames did without median and mean depths.
        let depths = self.frame.depths || self.prepared.request.frame.depths;
        let rendered = render(&mut self.renderer, &mut self.uploaded.cloud, &Frame { depths, outputs, ..self.frame })?;
        self.device.check_validation()?;
        Ok(rendered)
    }

    /// Says so where a picture is empty, or where nearly all of it looks opaque or empty though the points don't. Looks
    /// at the first picture of a decision only.
    ///
    /// # Errors
    /// Returns an error if a trial frame can't be rendered.
    pub fn judge(&mut self, image: &Image, messages: &dyn Messages) -> Result<()> {
        if self.is_part {
            return Ok(());
        }
        let holes = notes::shadow_holes(&self.uploaded.cloud, &self.frame);
        holes.iter().for_each(|warning| self.told.to(messages).warn(warning));
        if let Some(empty) = notes::empty(image, self.prepared.points(), &self.frame.method) {
            messages.warn(&empty);
        } else if !std::mem::replace(&mut self.is_judged, true) {
            let Self { renderer, uploaded, frame, prepared, .. } = self;
            notes::judge((renderer, &mut uploaded.cloud, frame), prepared, image, messages)?;
        }
        Ok(())
    }

    /// Renders a picture, reports what is odd about it, and returns it as it is written, with the way in which that is
    /// done; `own` is added to the metadata. Of the image the caller needs these outputs.
    ///
    /// # Errors
    /// Returns the errors of [`Self::render`], [`Self::judge`] and [`Self::finish`].
    pub fn picture(
        &mut self,
        outputs: Outputs,
        own: Vec<(String, String)>,
        messages: &dyn Messages,
    ) -> Result<(Rendered, WriteOptions)> {
        let mut rendered = self.first(outputs, messages)?;
        self.judge(&rendered.image, messages)?;
        let options = self.finish(&mut rendered, own, messages)?;
        Ok((rendered, options))
    }

    /// Brightens a frame's image if its method is to do so, reports the frame, and returns how the image is written,
    /// with its metadata; `own` is added to them.
    ///
    /// # Errors
    /// Returns an error if a trial frame can't be rendered, or if the device fails.
    pub fn finish(
        &mut self,
        rendered: &mut Rendered,
        own: Vec<(String, String)>,
        messages: &dyn Messages,
    ) -> Result<WriteOptions> {
        let applied = self.brighten(rendered)?;
        let options = self.write_options(applied.as_ref(), own);
        describe_frame(rendered, messages);
        self.describe_adjustment(rendered, messages);
        self.prepared.described_reads().iter().for_each(|reads| messages.detail(reads));
        self.describe_detail(messages);
        if let Some(applied) = &applied {
            if applied.found.is_some() {
                messages.note(&format_args!("brightness: colors times {}", applied.factor));
            }
            applied.warning().iter().for_each(|warning| messages.warn(warning));
        }
        Ok(options)
    }

    /// Brightens a frame's image if its method is to do so.
    ///
    /// # Errors
    /// Returns an error if a trial frame can't be rendered, or if the device fails.
    pub fn brighten(&mut self, rendered: &mut Rendered) -> Result<Option<Applied>> {
        let applied =
            brightness::apply(&mut self.renderer, &mut self.uploaded.cloud, &self.frame, &mut rendered.image)?;
        self.device.check_validation()?;
        Ok(applied)
    }

    /// Returns how the image of a frame is written, with its metadata; `own` is added to them.
    pub fn write_options(&self, applied: Option<&Applied>, own: Vec<(String, String)>) -> WriteOptions {
        let Self { uploaded, frame, found, prepared, device, choice, .. } = self;
        let scene = prepared.scene();
        let mut metadata = prepared.metadata(frame.method.name(), &device.info().name);
        metadata.extend(notes::decisions(frame, &uploaded.cloud, &scene.clouds, applied, found.as_ref()));
        let sampled = samples::metadata(frame.samples, self.settled.as_ref());
        metadata.extend(sampled.map(|json| (samples::SAMPLES_TAG.to_owned(), json.to_string())));
        let choice = choice.as_ref().map(Choice::json);
        metadata.extend(choice.map(|json| ("pellucid:choice".to_owned(), json.to_string())));
        metadata.push(prepared.camera_metadata());
        metadata.extend(own);
        WriteOptions {
            background: scene.image.background.color(),
            color: scene.image.color_space(),
            transparent: false,
            metadata,
            camera: Some(prepared.camera.camera()),
            inputs: prepared.request.inputs.clone(),
        }
    }

    /// Reports how the number of points of each cloud was adjusted to its opacity, for methods that do so.
    fn describe_adjustment(&self, rendered: &Rendered, messages: &dyn Messages) {
        let Some(adjusted) = &rendered.facts.adjusted else { return };
        adjusted.lines(&self.assembled().cloud_names()).iter().for_each(|line| messages.detail(line));
        let order = self.progress.spans().into_iter().filter(|span| span.phase == Phase::Order);
        messages.detail(&profile::adjustment_time(order.map(|span| span.length).sum()));
    }

    /// Reports how many points were left out of the last frame.
    pub fn describe_detail(&self, messages: &dyn Messages) {
        if let Some(cut) = self.uploaded.cloud.cut_in_force() {
            let (points, all, px) = (cut.points(), self.uploaded.cloud.total(), cut.px);
            messages.detail(&format_args!("levels of detail: {points} of {all} points, at most {px:.2} pixels apart"));
        }
    }

    /// Draws some of the samples of a frame; validation messages are an error.
    ///
    /// # Errors
    /// Returns an error if the frame does not fit, if it was canceled, or if the device fails.
    pub fn draw_part(&mut self, samples: Range<u32>) -> Result<DrawnPart> {
        self.progress.begin(Phase::Frame);
        let drawn = self.renderer.draw_part(&mut self.uploaded.cloud, &self.frame, samples)?;
        self.device.check_validation()?;
        Ok(drawn)
    }

    /// Returns the frame whose samples were drawn in parts.
    ///
    /// # Errors
    /// Returns an error if parts are missing, or if the device fails.
    pub fn resolve(&mut self, parts: &SamplePart) -> Result<Rendered> {
        let rendered = self.renderer.resolve_parts(&self.uploaded.cloud, &self.frame, parts)?;
        self.device.check_validation()?;
        Ok(rendered)
    }

    /// Returns the passes of the frame, each with its reason; that of the first, which takes the points, also says how
    /// clouds are colored, and where no point is soft though the method is made for those. Lists are counted as for a
    /// profile, except for methods without lists.
    ///
    /// # Errors
    /// Returns an error if the frame does not fit, if it was canceled, or if the device fails.
    pub fn plan(&mut self) -> Result<Vec<plan::Step>> {
        let frame = Frame { fragments: !self.frame.counts_on_demand(), ..self.frame };
        let facts = self.renderer.survey(&mut self.uploaded.cloud, &frame)?;
        let mut steps = plan::plan(&self.device, &frame, &facts, self.renderer.switches.wide_atomics, &self.why);
        if let Some(first) = steps.iter_mut().find(|step| step.on) {
            let colorings = self.assembled().colorings.iter().cloned();
            let reasons = [first.reason.clone()].into_iter().chain(colorings).chain(self.without_soft_points());
            let images = (frame.samples > 1).then(|| {
                let four = self.renderer.images(&frame).len() < frame.samples as usize;
                let each = if four { "every four of which are drawn at once" } else { "each of all passes" };
                format!("the picture is the mean of {} images, {each}: samples of a pixel's area", frame.samples)
            });
            let reasons = reasons.chain(images);
            first.reason = reasons.collect::<Vec<_>>().join("; ");
        }
        Ok(steps)
    }

    /// Returns a profile without frames.
    pub fn profile(&self) -> Profile {
        let mut profile = Profile::new(&self.device, &self.frame);
        profile.clouds = self.assembled().cloud_names();
        self.add_use(&mut profile);
        profile
    }

    /// Gives a profile what the work so far read of stores, and what host memory it took.
    pub fn add_use(&self, profile: &mut Profile) {
        profile.read = self.assembled().stored().map(Stored::reads).unwrap_or_default();
        profile.peak_host_bytes = peak_memory();
    }

    /// Begins the phase in which the rest of the work writes what was rendered.
    pub fn begin_writing(&self) {
        self.progress.begin(Phase::Write);
    }

    /// Adds the phases of the work so far to a profile, and what it took.
    pub fn add_phases(&self, profile: &mut Profile) {
        self.add_use(profile);
        profile.add_host(self.progress.spans(), &self.device.compilations());
    }
}

/// Returns the frame of a request before its method and opacity are decided.
fn undecided(prepared: &Prepared) -> Frame {
    let mut frame = prepared.frame();
    if prepared.see_through().is_some() {
        frame.factors.opacity = UNKNOWN_OPACITY;
    }
    frame
}

/// Reports the counts and times of a frame.
fn describe_frame(rendered: &Rendered, messages: &dyn Messages) {
    let Rendered { facts, profile, .. } = rendered;
    if facts.fragments > 0 {
        messages.detail(&format_args!(
            "{} fragments, the longest list {}, in {} band(s)",
            facts.fragments, facts.max_list, facts.bands
        ));
    }
    if facts.layers > 0 {
        messages.detail(&format_args!("{} layers peeled", facts.layers));
    }
    if facts.samples > 0 {
        messages.detail(&format_args!("{} random samples per pixel", facts.samples));
    }
    if rendered.image.samples > 1 {
        messages.detail(&format_args!("the mean of {} images: samples of each pixel's area", rendered.image.samples));
    }
    messages.detail(&format_args!(
        "frame {:.1} ms, of which {:.1} ms in passes; device memory at most {}",
        profile.wall.as_secs_f64() * 1e3,
        profile.gpu().as_secs_f64() * 1e3,
        bytesize::ByteSize(facts.peak_device_bytes)
    ));
    let pass = |pass: &PassProfile| format!("{} {:.1} ms", pass.name, pass.gpu.as_secs_f64() * 1e3);
    let passes: Vec<String> = profile.passes.iter().map(pass).collect();
    messages.detail(&format_args!("passes: {}", passes.join(", ")));
}
