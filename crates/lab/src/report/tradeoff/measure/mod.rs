//! Measures the settings of a scene on a device.

mod limit;
mod looks;
mod reference;
mod rounds;
mod trial;

use std::path::Path;
use std::time::{Duration, Instant};

use glam::Vec3;
use pellucid_core::camera::Camera;
use pellucid_core::image::{Image, LinearImage};
use pellucid_core::progress::Progress;
use pellucid_engine::methods::{self, Frame, Rendered, Renderer, Stop, linear};
use pellucid_engine::{Result, identity};
use pellucid_gpu::Device;
use pellucid_io::output::{self, write_rgb_png};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Detail, Method};

pub use self::limit::method_by_method;

use self::limit::Spent;
use self::reference::{ReferenceImage, Samples};
use super::analytic::{self, Planes};
use super::causes::{self, Effort as CausesEffort};
use super::partial::Partial;
use super::surfaces::shadows::{self, Effort};
use super::surfaces::{self, Clouds};
use super::{Analytic, Reference, Row, Shaded, Skipped, Surveyed, Tradeoff, findings, summary};
use crate::report::popping::{self, Film, Popping};
use crate::report::truth::Truth;
use pellucid_session::area::{self, Against};
use pellucid_session::candidates::{Formation, Ladders, Occasion, Setting, compared, settings, with_samples};
use pellucid_session::without_soft_points;

/// The scene to measure.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredScene<'a> {
    /// The scene's points.
    pub arranged: &'a Arranged,
    /// The frame. Its method defines the image formation that is compared; blending never stops early.
    pub frame: Frame,
    /// Linear RGB.
    pub background: Vec3,
    /// The inputs as they were named.
    pub scene: &'a str,
    /// The cameras of a path along which errors are followed ([`Tradeoff::popping`]); empty for none.
    pub cameras: &'a [Camera],
}

/// The extent of the measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// The settings of the methods.
    pub ladders: Ladders,
    /// Names of methods; empty for all.
    pub only: Vec<String>,
    /// Approximate limit on the total rendering time, in seconds. A setting is skipped if one frame is predicted to
    /// take more than a [`FRAME_SHARE`]th of it, or if no time is left.
    pub seconds: f64,
    /// Time at which all of it should be over, the report included; then `seconds` are those of the whole comparison.
    /// Settings that don't fit, by what was measured so far, are skipped; the first one is not. `None` limits the
    /// rendering time alone.
    pub end: Option<Instant>,
    /// Frames behind a median, if time permits, at least 1.
    pub rounds: usize,
    /// Images of a stochastic setting with seeds of their own, if time permits, at least 2.
    pub seeds: u32,
    /// The command line.
    pub command: String,
    /// The picture that errors are measured against. Against the area each setting is measured with
    /// [`area::COMPARED`] samples of a pixel.
    pub against: Against,
}

impl Options {
    /// The extent of a comparison, or of a quick look at one, that began at this time. By default a comparison renders
    /// for 360 s, and a quick look takes 55 s in all.
    pub fn new(is_quick: bool, begin: Instant, only: Vec<String>, seconds: Option<f64>, command: String) -> Self {
        let (ladders, rounds, seeds, most) =
            if is_quick { (Ladders::QUICK, 3, 4, 55.0) } else { (Ladders::FULL, 10, 8, 360.0) };
        let seconds = seconds.unwrap_or(most);
        // A time beyond what a clock can hold is no limit.
        let end = Duration::try_from_secs_f64(seconds).ok().and_then(|time| begin.checked_add(time));
        let against = Against::Center;
        Self { ladders, only, seconds, end: end.filter(|_| is_quick), rounds, seeds, command, against }
    }
}

/// See [`Options::seconds`].
pub const FRAME_SHARE: f64 = 8.0;
/// A frame that takes more than 1/`ALONE_SHARE` of the time is timed once, where it is first rendered, instead of in
/// turns.
pub const ALONE_SHARE: f64 = 60.0;
/// Part of the time after which no further cause of errors is measured.
const CAUSES_SHARE: f64 = 0.2;
/// Part of the time for the exact pictures of several samples in a pixel, as a reference and as a cause of errors.
const AREA_SHARE: f64 = 0.1;

/// Measures every applicable setting, and resumes an interrupted run on the same scene and device. Results are stored
/// in `folder`, which is created if needed, after every frame; so are the pictures. Once the report is written,
/// [`super::discard`] removes the stored results. `progress` counts settings and frames.
///
/// # Errors
/// A method of another image formation, a folder that can't be written to, a frame that the reference can't render, a
/// lost device, a message of the validation layers. Failures of a single setting only skip it.
pub fn run(
    device: &Device,
    subject: &MeasuredScene<'_>,
    options: &Options,
    folder: &Path,
    progress: &Progress,
) -> Result<Tradeoff> {
    let formation = compared(&subject.frame.method, subject.arranged.points())?;
    // Goes again if the first frame fails already.
    let _new = output::make_folder(folder)?;
    // Errors are those against all points.
    let (method, detail) = (formation.exact(), Detail::default());
    let frame = Frame { method, detail, stop: Stop::Exact, fragments: false, ..subject.frame };
    // Shadows are measured with the scene's own method.
    let own = frame.shadows.map(|_| subject.frame.method);
    let against = if options.against == Against::Area { " against the area" } else { "" };
    let formed = format!("{formation:?} {own:?}{against}");
    let identity = identity::hash(subject.arranged, &frame, subject.background, &formed, device.info());
    let partial = Partial::open(folder, identity);

    let thinning = if matches!(formation, Formation::Surfaces(_)) { options.ladders.thinning } else { &[1] };
    let mut clouds = Clouds::new(subject.arranged, thinning, frame.seed);
    progress.set_message("the reference");
    // An interrupted run goes on with the reference that it had.
    let known = partial.content.reference.as_ref().map(|reference| reference.samples);
    let wanted = match options.against {
        Against::Center => Samples::Own,
        Against::Area => known.map_or(Samples::Within(AREA_SHARE * options.seconds), Samples::Exactly),
    };
    let made = ReferenceImage::new(device, subject, &formation, (&frame, wanted), &mut clouds)?;
    let ReferenceImage { reference, silhouette, facts, .. } = &made;
    let occasion = Occasion::new(subject.arranged.points(), formation, facts.max_list);
    let planes = Planes::from_points(subject.arranged, &frame);
    let analytic = planes.map(|planes| planes.about(subject.background, reference));
    let surveyed = silhouette.as_ref().map(|silhouette| Surveyed {
        samples_across: made.samples_across,
        silhouette: silhouette.pixels,
        clouds: thinning.iter().map(|one_of| (*one_of, clouds.len(*one_of))).collect(),
    });
    let (skipped, tried) = (Vec::new(), Vec::new());
    let mut run = TradeoffRun {
        device,
        subject,
        options,
        folder,
        progress,
        frame,
        partial,
        clouds,
        made,
        occasion,
        unordered: None,
        analytic,
        surveyed,
        skipped,
        tried,
    };
    run.keep_reference()?;

    let (mut settings, skipped) = settings(&occasion, &options.ladders);
    let asked = |name: &str| options.only.is_empty() || options.only.iter().any(|only| only == name);
    settings.retain(|setting| asked(setting.method.name()));
    if options.against == Against::Area {
        let surveyed = run.surveyed.is_some();
        let fewer = area::COMPARED.into_iter().filter(|count| surveyed || *count < run.made.samples);
        settings = with_samples(&settings, &fewer.collect::<Vec<_>>());
    }
    run.skipped = skipped.into_iter().filter(|skipped| asked(&skipped.method)).collect();
    progress.set_length(settings.len() as u64);
    let asked_exact = asked(run.frame.method.name());
    if asked_exact {
        run.find_causes()?;
    }
    run.find_area(if asked_exact { &area::COMPARED } else { &[] })?;
    let taken = run.trials(&settings)?;
    run.rounds(&taken)?;
    run.shade()?;
    let popping = run.follow()?;
    Ok(run.report(&taken, popping))
}

struct TradeoffRun<'a> {
    device: &'a Device,
    subject: &'a MeasuredScene<'a>,
    options: &'a Options,
    folder: &'a Path,
    progress: &'a Progress,
    /// The reference frame.
    frame: Frame,
    partial: Partial,
    clouds: Clouds<'a>,
    made: ReferenceImage,
    occasion: Occasion,
    /// The image without order, once it was tried.
    unordered: Option<Option<LinearImage>>,
    analytic: Option<Analytic>,
    surveyed: Option<Surveyed>,
    skipped: Vec<Skipped>,
    /// Times of the settings that this run tried.
    tried: Vec<Spent>,
}

impl TradeoffRun<'_> {
    fn linear(&self, image: &Image) -> Result<LinearImage, methods::Error> {
        linear(image, self.subject.background, self.frame.color)
    }

    /// Writes the reference's picture. One of the device that others are to equal is checked against the float64
    /// reference, once.
    fn keep_reference(&mut self) -> Result<()> {
        let picture = "reference.png".to_owned();
        self.write_picture(&picture, &self.made.reference.pixels)?;
        let unchecked = self.made.unchecked.take();
        if self.partial.content.reference.is_none() {
            let (checked_pixels, largest_error) = unchecked.map_or((0, 0.0), |image| {
                self.progress.set_message("checking the reference in float64");
                let points = self.subject.arranged.points();
                let frame = Frame { samples: self.made.samples, ..self.frame };
                let deviation = Truth::new(points, &frame, self.frame.seed).deviation(&image, 0.0);
                (deviation.pixels, deviation.max)
            });
            let method = self.made.method.clone();
            let samples = self.made.samples;
            let reference = Reference { method, picture, checked_pixels, largest_error, samples };
            self.partial.content.reference = Some(reference);
            self.partial.save()?;
        }
        Ok(())
    }

    fn write_picture(&self, name: &str, pixels: &[[f32; 3]]) -> Result<()> {
        Ok(write_rgb_png(&self.folder.join(name), [self.made.reference.width, self.made.reference.height], pixels)?)
    }

    fn frame_of(&self, setting: &Setting, image: u32) -> Frame {
        // Wraps around like any seed would.
        let seed = self.subject.frame.seed.wrapping_add(image.into());
        let samples = setting.samples.unwrap_or(self.frame.samples);
        Frame { method: setting.method, detail: setting.detail, seed, samples, ..self.frame }
    }

    fn render(&mut self, renderer: &mut Renderer, setting: &Setting, image: u32) -> Result<Rendered, methods::Error> {
        let frame = self.frame_of(setting, image);
        renderer.render(self.clouds.on_device(renderer, setting.thinning, &setting.detail)?, &frame)
    }

    /// Shadows of more and fewer samples, unless an earlier run has them.
    fn shade(&mut self) -> Result<()> {
        let Options { ladders, rounds, seconds, .. } = self.options;
        let seconds = self.left().map_or(*seconds, |left| left.clamp(0.0, *seconds));
        let has_all = |shaded: &Shaded| shaded.steps.iter().map(|step| &step.samples).eq(ladders.shadow_samples);
        if self.surveyed.is_some() && !self.partial.content.shaded.as_ref().is_some_and(has_all) {
            self.progress.set_message("shadows");
            let effort = Effort { samples: ladders.shadow_samples, frames: *rounds, seconds };
            let frame = Frame { method: self.subject.frame.method, ..self.frame };
            self.partial.content.shaded =
                shadows::measure(self.device, &mut self.clouds, &frame, self.subject.background, effort)?;
            self.device.check_validation()?;
            self.partial.save()?;
        }
        Ok(())
    }

    /// Measures the change of errors along the path, if there is one.
    fn follow(&mut self) -> Result<Option<Popping>> {
        let MeasuredScene { arranged, background, cameras, .. } = *self.subject;
        let own = self.subject.frame.method;
        let reference = popping::reference(&own, arranged.points()).filter(|_| !cameras.is_empty());
        let Some(method) = reference else { return Ok(None) };
        // The memory of the others first.
        self.clouds.forget();
        let frame = Frame { method, ..self.frame };
        let candidates = popping::candidates(&own, arranged.points(), &self.options.only);
        let film = Film { arranged, frame: &frame, background, cameras };
        Ok(Some(popping::measure(self.device, &film, &candidates, self.progress)?))
    }

    /// Finds the cost of each approximation of Gaussian splats, unless an earlier run has it.
    fn find_causes(&mut self) -> Result<()> {
        let (points, frame) = (self.subject.arranged.points(), self.frame);
        let (Method::ABuffer(discs), Some(gaussians)) = (&frame.method, &points.gaussians) else { return Ok(()) };
        // Of points that come some at a time the others have harmonics as well.
        let degree = if points.whole.is_some() { 0 } else { gaussians.degree };
        let changes = causes::changes(discs, frame.method.order(), degree, &frame.camera.projection);
        let known = self.partial.content.causes.iter().map(|cause| (&cause.setting, cause.against.as_str()));
        if known.eq(changes.iter().map(|change| (&change.setting, change.against))) {
            return Ok(());
        }
        // Against the area the reference has more samples than these images.
        let own = match self.options.against {
            Against::Center => None,
            Against::Area => Some(self.render_exact()?),
        };
        let effort = CausesEffort {
            frame: &frame,
            reference: own.as_ref().unwrap_or(&self.made.reference),
            background: self.subject.background,
            arranged: self.subject.arranged,
            folder: self.folder,
            seconds: CAUSES_SHARE * self.options.seconds,
        };
        let (found, skipped) = causes::measure(self.device, &mut self.clouds, effort, &changes, self.progress)?;
        self.skipped.extend(skipped);
        self.partial.content.causes = found;
        Ok(self.partial.save()?)
    }

    /// The image of the exact method with the scene's own samples.
    fn render_exact(&mut self) -> Result<LinearImage> {
        let mut renderer = Renderer::new(self.device)?;
        let cloud = self.clouds.on_device(&renderer, 1, &self.frame.detail)?;
        let rendered = renderer.render(cloud, &self.frame)?;
        Ok(self.linear(&rendered.image)?)
    }

    /// Finds the error of looking at these numbers of points of each pixel, and of the scene's own, unless an earlier
    /// run has it. Opaque points have a reference with many samples anyway.
    fn find_area(&mut self, counts: &[u32]) -> Result<()> {
        let known = self.partial.content.area.as_ref();
        let has_all = known.is_some_and(|known| known.causes.len() > 1 || counts.is_empty());
        if self.surveyed.is_some() || has_all {
            return Ok(());
        }
        let frame = self.frame;
        let effort = CausesEffort {
            frame: &frame,
            reference: &self.made.reference,
            background: self.subject.background,
            arranged: self.subject.arranged,
            folder: self.folder,
            seconds: AREA_SHARE * self.options.seconds,
        };
        let timed = (effort, self.options.seconds);
        match causes::area::measure(self.device, &mut self.clouds, timed, counts, self.progress)? {
            Ok(found) => self.partial.content.area = Some(found),
            Err(skipped) => self.skipped.push(skipped),
        }
        Ok(self.partial.save()?)
    }

    fn report(self, settings: &[Setting], popping: Option<Popping>) -> Tradeoff {
        let Self { device, subject, options, frame, partial, made, analytic, surveyed, skipped, .. } = self;
        let facts = made.facts;
        let content = partial.content;
        let row = |setting: &Setting| summary::row(&content.settings[&setting.key()]);
        let mut rows: Vec<Row> = settings.iter().map(row).collect();
        summary::mark_front(&mut rows);
        // An image of one sample in a pixel tends to no reference with many.
        let convergence = if surveyed.is_some() { Vec::new() } else { summary::convergence(settings, &rows) };
        let analytic = analytic.map(|known| Analytic { slope: analytic::slope(&rows, known.dealt_once), ..known });
        let findings = match surveyed {
            Some(_) => surfaces::findings::check_statements(&rows, popping.as_ref()),
            None => {
                let without = without_soft_points(subject.arranged.points(), &subject.frame.method);
                findings::check_statements(&rows, analytic.as_ref(), without.as_deref())
            }
        };
        let info = device.info();
        let asked = options.only.is_empty() || options.only.iter().any(|only| only == frame.method.name());
        let area_causes =
            content.area.iter().filter(|_| asked).flat_map(|area| area.causes.clone()).collect::<Vec<_>>();
        Tradeoff {
            version: 1,
            pellucid: env!("CARGO_PKG_VERSION").to_owned(),
            command: options.command.clone(),
            scene: subject.scene.to_owned(),
            device: info.name.clone(),
            driver: info.driver.clone(),
            size: subject.frame.size,
            points: subject.arranged.points().len() as u64,
            fragments: facts.fragments,
            max_list: facts.max_list,
            sittings: content.sittings,
            reference: content.reference.expect("kept before any setting was tried"),
            analytic,
            surveyed,
            shaded: content.shaded,
            against: options.against.word().to_owned(),
            area: content.area.as_ref().map(|area| area.picture.clone()),
            causes: content.causes.into_iter().chain(area_causes).collect(),
            popping,
            rows,
            skipped,
            convergence,
            findings,
        }
    }
}
