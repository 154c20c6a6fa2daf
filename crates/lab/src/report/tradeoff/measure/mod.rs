//! Measures the settings of a scene on a device.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use glam::Vec3;
use pellucid_engine::progress::Progress;

use super::analytic::{self, Planes};
use super::partial::{Measured, Partial, Timed, Trial};
use super::renderers::Renderers;
use super::repeats::Seeds;
use super::settings::{Formation, Ladders, Occasion, Setting, compared, settings};
use super::surfaces::shadows::{self, Effort};
use super::surfaces::{self, Clouds, Silhouette, supersampled};
use super::{
    Analytic, DIFFERENCE_GAIN, Errors, Reference, Row, Shaded, Skipped, Surveyed, Tradeoff, findings, summary,
};
use crate::report::truth::{self, Truth, soft_spheres};
use pellucid_engine::gpu::Device;
use pellucid_engine::image::Image;
use pellucid_engine::image::LinearImage;
use pellucid_engine::methods::{self, Facts, Frame, FrameProfile, Rendered, Renderer, Stop};
use pellucid_engine::metrics::{self, difference_picture};
use pellucid_engine::output::{self, linear, write_rgb_png};
use pellucid_engine::prepare::Arranged;
use pellucid_engine::{Result, identity};

/// Predicts the seconds of a frame with this effort from (effort, seconds) of earlier steps: on the line through the
/// last two, or in proportion to the effort. `None` without earlier steps.
fn predict(times: &[(f64, f64)], effort: f64) -> Option<f64> {
    let &(last, seconds) = times.last()?;
    Some(match times.iter().rev().find(|(before, _)| *before < last) {
        Some((before, less)) => seconds + ((seconds - less) / (last - before)).max(0.0) * (effort - last),
        None => seconds * effort / last,
    })
}

/// The scene to measure.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The scene's points.
    pub arranged: &'a Arranged,
    /// The frame. Its method defines the image formation that is compared; blending never stops early.
    pub frame: Frame,
    /// Linear RGB.
    pub background: Vec3,
    /// The inputs as they were named.
    pub scene: &'a str,
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
    /// Frames behind a median, if time permits, at least 1.
    pub rounds: usize,
    /// Images of a stochastic setting with seeds of their own, if time permits, at least 2.
    pub seeds: u32,
    /// The command line.
    pub command: String,
}

/// See [`Options::seconds`].
pub const FRAME_SHARE: f64 = 8.0;
/// A frame that takes more than 1/`ALONE_SHARE` of the time is timed once, where it is first rendered, instead of in
/// turns.
pub const ALONE_SHARE: f64 = 60.0;
/// The images of a stochastic setting take at most 1/`SEEDS_SHARE` of the time, beyond the two that it needs.
const SEEDS_SHARE: f64 = 80.0;
/// Part of the time for first frames, errors and seeds.
const TRIALS_SHARE: f64 = 0.6;
/// Part of the time for frames that are timed in turns.
const ROUNDS_SHARE: f64 = 0.35;

/// Measures every applicable setting, and resumes an interrupted run on the same scene and device. Results are stored
/// in `folder`, which is created if needed, after every frame; so are the pictures. Once the report is written,
/// [`super::discard`] removes the stored results. `progress` counts settings and frames.
///
/// # Errors
/// A method of another image formation, a folder that can't be written to, a frame that the reference can't render, a
/// lost device, a message of the validation layers. Failures of a single setting only skip it.
pub fn run(
    device: &Device,
    subject: &Subject<'_>,
    options: &Options,
    folder: &Path,
    progress: &Progress,
) -> Result<Tradeoff> {
    let formation = compared(&subject.frame.method, subject.arranged.points())?;
    // Goes again if the first frame fails already.
    let _new = output::make_folder(folder)?;
    let frame = Frame { method: formation.exact(), stop: Stop::Exact, fragments: false, ..subject.frame };
    // Shadows are measured with the scene's own method.
    let own = frame.shadows.map(|_| subject.frame.method);
    let formed = format!("{formation:?} {own:?}");
    let identity = identity::hash(subject.arranged, &frame, subject.background, &formed, device.info());
    let partial = Partial::open(folder, identity);

    let thinning = if matches!(formation, Formation::Surfaces(_)) { options.ladders.thinning } else { &[1] };
    let mut clouds = Clouds::new(subject.arranged, thinning, frame.seed);
    progress.set_message("the reference");
    let made = Made::new(device, subject, &formation, &frame, &mut clouds)?;
    let Made { reference, silhouette, facts, .. } = &made;
    let occasion = Occasion::new(subject.arranged.points(), formation, facts.max_list);
    let planes = Planes::from_points(subject.arranged, &frame);
    let analytic = planes.map(|planes| planes.about(subject.background, reference));
    let surveyed = silhouette.as_ref().map(|silhouette| Surveyed {
        samples_across: made.samples_across,
        silhouette: silhouette.pixels,
        clouds: thinning.iter().map(|one_of| (*one_of, clouds.len(*one_of))).collect(),
    });
    let skipped = Vec::new();
    let mut run =
        Run { device, subject, options, folder, progress, frame, partial, clouds, made, analytic, surveyed, skipped };
    run.keep_reference()?;

    let (mut settings, skipped) = settings(&occasion, &options.ladders);
    let asked = |name: &str| options.only.is_empty() || options.only.iter().any(|only| only == name);
    settings.retain(|setting| asked(setting.method.name()));
    run.skipped = skipped.into_iter().filter(|skipped| asked(&skipped.method)).collect();
    progress.set_length(settings.len() as u64);
    let mut taken = Vec::new();
    for setting in settings {
        progress.set_message(format!("errors, {}", setting.key()));
        if run.trial(&setting, &taken)? {
            taken.push(setting);
        }
        progress.inc(1);
    }
    run.rounds(&taken)?;
    run.shade()?;
    Ok(run.report(&taken))
}

/// The reference that images are compared with.
struct Made {
    reference: LinearImage,
    /// The image of the device, if it must be checked against the float64 reference.
    unchecked: Option<Image>,
    /// The method that made it, in words.
    method: String,
    /// The facts of the exact method's frame.
    facts: Facts,
    /// For opaque points.
    silhouette: Option<Silhouette>,
    samples_across: u32,
}

impl Made {
    fn new(
        device: &Device,
        subject: &Subject<'_>,
        formation: &Formation,
        frame: &Frame,
        clouds: &mut Clouds<'_>,
    ) -> Result<Self> {
        let (name, background) = (frame.method.name(), subject.background);
        let mut renderer = Renderer::new(device)?;
        let cloud = clouds.on_device(&renderer, 1)?;
        if let Formation::Surfaces(_) = formation {
            let made = supersampled(&mut renderer, cloud, frame, background)?;
            let across = made.samples_across;
            return Ok(Self {
                reference: made.image,
                unchecked: None,
                method: format!("{name} of all points with {across} × {across} samples in a pixel"),
                facts: Facts::default(),
                silhouette: Some(made.silhouette),
                samples_across: across,
            });
        }
        let Rendered { image, facts, .. } = renderer.render(cloud, frame)?;
        drop(renderer);
        let in_float64 = match truth::ensembles(subject.arranged, frame) {
            Some(image) => Some(image),
            None => soft_spheres(device, subject.arranged.points(), frame)?,
        };
        let method = match (formation, &in_float64) {
            (_, None) => name.to_owned(),
            (Formation::Ensembles(_), _) => format!("{name} with ever more ensembles, in float64"),
            _ => format!("{name} in float64, before the solid points as the device splats them"),
        };
        let reference = linear(in_float64.as_ref().unwrap_or(&image), background, frame.color);
        let unchecked = in_float64.is_none().then_some(image);
        Ok(Self { reference, unchecked, method, facts, silhouette: None, samples_across: 1 })
    }
}

struct Run<'a> {
    device: &'a Device,
    subject: &'a Subject<'a>,
    options: &'a Options,
    folder: &'a Path,
    progress: &'a Progress,
    /// The reference frame.
    frame: Frame,
    partial: Partial,
    clouds: Clouds<'a>,
    made: Made,
    analytic: Option<Analytic>,
    surveyed: Option<Surveyed>,
    skipped: Vec<Skipped>,
}

impl Run<'_> {
    fn linear(&self, image: &Image) -> LinearImage {
        linear(image, self.subject.background, self.frame.color)
    }

    /// Writes the reference's picture. One of the device that others are to equal is checked against the float64 reference,
    /// once.
    fn keep_reference(&mut self) -> Result<()> {
        let picture = "reference.png".to_owned();
        self.write_picture(&picture, &self.made.reference.pixels)?;
        let unchecked = self.made.unchecked.take();
        if self.partial.content.reference.is_none() {
            let (checked_pixels, largest_error) = unchecked.map_or((0, 0.0), |image| {
                self.progress.set_message("checking the reference in float64");
                let points = self.subject.arranged.points();
                let deviation = Truth::new(points, &self.frame, self.frame.seed).deviation(&image);
                (deviation.pixels, deviation.max)
            });
            let method = self.made.method.clone();
            self.partial.content.reference = Some(Reference { method, picture, checked_pixels, largest_error });
            self.partial.save()?;
        }
        Ok(())
    }

    fn write_picture(&self, name: &str, pixels: &[[f32; 3]]) -> Result<()> {
        Ok(write_rgb_png(&self.folder.join(name), [self.made.reference.width, self.made.reference.height], pixels)?)
    }

    /// The first frames of a setting, unless they are there already; false if it was skipped. `before` are the settings that
    /// were not.
    fn trial(&mut self, setting: &Setting, before: &[Setting]) -> Result<bool> {
        if self.partial.content.settings.contains_key(&setting.key()) {
            return Ok(true);
        }
        if let Some(reason) = self.too_slow(setting, before) {
            self.skipped.push(setting.skipped(reason));
            return Ok(false);
        }
        match self.first_frames(setting) {
            Ok(measured) => {
                self.device.check_validation()?;
                self.partial.content.settings.insert(setting.key(), measured);
                self.partial.save()?;
                Ok(true)
            }
            Err(pellucid_engine::Error::Render(error)) if error.is_refusal() => {
                self.skipped.push(setting.skipped(error.to_string()));
                Ok(false)
            }
            Err(error) => Err(error),
        }
    }

    /// Why a setting would take too long, by the steps of its ladder before.
    fn too_slow(&self, setting: &Setting, before: &[Setting]) -> Option<String> {
        let all = self.options.seconds;
        let trial = |other: &Setting| Some(&self.partial.content.settings.get(&other.key())?.trial);
        let times: Vec<(f64, f64)> = before
            .iter()
            .filter(|other| other.series == setting.series)
            .filter_map(|other| Some((other.effort?, trial(other)?.seconds)))
            .collect();
        let seconds = predict(&times, setting.effort?)?;
        let about = format!("a frame would take about {seconds:.1} s by the settings before; of {all} s in all");
        let most = all / FRAME_SHARE;
        if seconds > most {
            return Some(format!("{about} one may take {most:.1} s"));
        }
        let images = |trial: &Trial| trial.repeats.as_ref().map_or(2, |repeats| repeats.seeds.max(2));
        let spent: f64 = before.iter().filter_map(trial).map(|trial| f64::from(images(trial)) * trial.seconds).sum();
        // Two of them, as of every setting.
        let left = TRIALS_SHARE * all - spent;
        (2.0 * seconds > left).then(|| format!("{about} {:.1} s are left for first frames", left.max(0.0)))
    }

    fn frame_of(&self, setting: &Setting, image: u32) -> Frame {
        // Wraps around like any seed would.
        let seed = self.subject.frame.seed.wrapping_add(image.into());
        Frame { method: setting.method, seed, ..self.frame }
    }

    /// Renders a setting with fresh buffers: measures memory, errors, pictures, and the approximate time of a frame,
    /// which is final for slow settings.
    fn first_frames(&mut self, setting: &Setting) -> Result<Measured> {
        let mut renderer = Renderer::new(self.device)?;
        let first = self.render(&mut renderer, setting, 0)?;
        let image = self.linear(&first.image);
        let silhouette = self.made.silhouette.as_ref();
        let holes = silhouette.and_then(|silhouette| silhouette.holes(&first.image));
        let rmse_inside = silhouette.and_then(|silhouette| silhouette.rmse(&self.made.reference, &image));
        renderer.recycle(first.image);
        // The first one paid for shaders and buffers.
        let start = Instant::now();
        let second = self.render_anew(&mut renderer, setting, 1)?;
        let with_upload = start.elapsed().as_secs_f64();
        let seconds = second.profile.wall.as_secs_f64();
        let alone = seconds > self.options.seconds / ALONE_SHARE;
        let frames = alone.then(|| Timed::new(&second.profile, self.partial.content.sittings)).into_iter().collect();
        let errors = self.errors(&image);
        let (errors, repeats, rmse_analytic) = if setting.is_stochastic() {
            let mut seeds = Seeds::new(image.pixels.len());
            seeds.add(&image.pixels, &self.made.reference.pixels, errors, self.rmse_analytic(&image));
            self.add(&mut seeds, &second.image);
            renderer.recycle(second.image);
            let allowed = (self.options.seconds / SEEDS_SHARE / with_upload) as u32;
            for number in 2..allowed.min(self.options.seeds) {
                let rendered = self.render_anew(&mut renderer, setting, number)?;
                self.add(&mut seeds, &rendered.image);
                renderer.recycle(rendered.image);
            }
            (seeds.errors(), Some(seeds.repeats()), seeds.rmse_analytic())
        } else {
            (errors, None, self.rmse_analytic(&image))
        };
        // Written last, so that a skipped setting leaves no pictures.
        let [picture, difference] = self.pictures(setting, &image)?;
        let Facts { peak_device_bytes, fragment_bytes, .. } = first.facts;
        let trial = Trial {
            peak_device_bytes,
            fragment_bytes,
            errors,
            repeats,
            rmse_analytic,
            holes,
            rmse_inside,
            picture,
            difference,
            seconds,
        };
        Ok(Measured { trial, frames })
    }

    fn render(&mut self, renderer: &mut Renderer, setting: &Setting, image: u32) -> Result<Rendered, methods::Error> {
        let frame = self.frame_of(setting, image);
        renderer.render(self.clouds.on_device(renderer, setting.thinning)?, &frame)
    }

    /// Like [`Run::render`], but deals points to other ensembles: their choice is as random as the samples.
    fn render_anew(
        &mut self,
        renderer: &mut Renderer,
        setting: &Setting,
        image: u32,
    ) -> Result<Rendered, methods::Error> {
        match self.subject.arranged {
            Arranged::Dealt(dealt) => {
                let frame = self.frame_of(setting, image);
                let mut cloud = renderer.upload_dealt(&dealt.again(frame.seed))?;
                renderer.render(&mut cloud, &frame)
            }
            Arranged::Canonical(_) => self.render(renderer, setting, image),
        }
    }

    fn add(&self, seeds: &mut Seeds, image: &Image) {
        let image = self.linear(image);
        seeds.add(&image.pixels, &self.made.reference.pixels, self.errors(&image), self.rmse_analytic(&image));
    }

    fn rmse_analytic(&self, image: &LinearImage) -> Option<f64> {
        self.analytic.as_ref().map(|analytic| analytic::rmse(analytic.color, image))
    }

    fn errors(&self, image: &LinearImage) -> Errors {
        errors(&self.made.reference, image)
    }

    fn pictures(&self, setting: &Setting, image: &LinearImage) -> Result<[String; 2]> {
        let names = [format!("{}.png", setting.stem()), format!("{}-difference.png", setting.stem())];
        self.write_picture(&names[0], &image.pixels)?;
        let difference = difference_picture(&self.made.reference.pixels, &image.pixels, DIFFERENCE_GAIN);
        self.write_picture(&names[1], &difference)?;
        Ok(names)
    }

    /// Times frames of all settings in turns, so that a machine that slows down affects all of them. Rounds timed by an
    /// earlier run are kept; only the missing frames are rendered.
    fn rounds(&mut self, settings: &[Setting]) -> Result<()> {
        let rounds = self.options.rounds;
        let wanted = self.wanted(settings);
        let missing = |run: &Self, setting: &Setting, round: usize| {
            let due = (round + 1) * wanted[&setting.key()];
            // Fewer frames than rounds are spread over them.
            run.partial.content.settings[&setting.key()].frames.len() < (due + rounds / 2) / rounds
        };
        let due: Vec<&Setting> = settings.iter().filter(|setting| missing(self, setting, rounds - 1)).collect();
        let frames = |run: &Self, s: &Setting| wanted[&s.key()] - run.partial.content.settings[&s.key()].frames.len();
        let total: usize = due.iter().map(|setting| 1 + frames(self, setting)).sum();
        self.progress.inc_length(total as u64);
        let mut renderers = Renderers::new(self.device, due.iter().map(|s| (s.method.name(), self.peak(s))));
        // Buffers and shaders.
        for setting in &due {
            self.progress.set_message(format!("warming up, {}", setting.key()));
            let renderer = renderers.for_method(setting.method.name())?;
            let rendered = self.render(renderer, setting, 0)?;
            renderer.recycle(rendered.image);
            self.progress.inc(1);
        }
        for round in 0..rounds {
            for setting in &due {
                if missing(self, setting, round) {
                    self.progress.set_message(format!("times, {}", setting.key()));
                    let renderer = renderers.for_method(setting.method.name())?;
                    self.time(renderer, setting, round)?;
                    self.progress.inc(1);
                }
            }
        }
        Ok(self.device.check_validation()?)
    }

    /// Shadows of more and fewer samples, unless an earlier run has them.
    fn shade(&mut self) -> Result<()> {
        let Options { ladders, rounds, seconds, .. } = self.options;
        let has_all = |shaded: &Shaded| shaded.steps.iter().map(|step| &step.samples).eq(ladders.shadow_samples);
        if self.surveyed.is_some() && !self.partial.content.shaded.as_ref().is_some_and(has_all) {
            self.progress.set_message("shadows");
            let effort = Effort { samples: ladders.shadow_samples, frames: *rounds, seconds: *seconds };
            let frame = Frame { method: self.subject.frame.method, ..self.frame };
            self.partial.content.shaded =
                shadows::measure(self.device, &mut self.clouds, &frame, self.subject.background, effort)?;
            self.device.check_validation()?;
            self.partial.save()?;
        }
        Ok(())
    }

    fn peak(&self, setting: &Setting) -> u64 {
        self.partial.content.settings[&setting.key()].trial.peak_device_bytes
    }

    fn time(&mut self, renderer: &mut Renderer, setting: &Setting, round: usize) -> Result<()> {
        if !self.clouds.are_on_device(setting.thinning) {
            // Work done once per cloud is not part of a frame's time.
            let rendered = self.render(renderer, setting, round as u32)?;
            renderer.recycle(rendered.image);
        }
        let rendered = self.render(renderer, setting, round as u32)?;
        let timed = Timed::new(&rendered.profile, self.partial.content.sittings);
        renderer.recycle(rendered.image);
        if let Some(measured) = self.partial.content.settings.get_mut(&setting.key()) {
            measured.frames.push(timed);
        }
        Ok(self.partial.save()?)
    }

    /// The number of timed frames per setting: one per round, but fewer for the slowest settings, so that all fit the
    /// time, and one for those that are timed alone. It depends only on the trials, so that an interrupted run arrives
    /// at the same numbers.
    fn wanted(&self, settings: &[Setting]) -> BTreeMap<String, usize> {
        let seconds = |setting: &Setting| self.partial.content.settings[&setting.key()].trial.seconds;
        let most = self.options.seconds / ALONE_SHARE;
        let (in_turns, alone): (Vec<&Setting>, Vec<&Setting>) = settings.iter().partition(|s| seconds(s) <= most);
        let costs: Vec<f64> = in_turns.iter().map(|setting| seconds(setting)).collect();
        let counts = summary::frames(&costs, self.options.rounds, ROUNDS_SHARE * self.options.seconds);
        let in_turns = in_turns.iter().map(|setting| setting.key()).zip(counts);
        in_turns.chain(alone.iter().map(|setting| (setting.key(), 1))).collect()
    }

    fn report(self, settings: &[Setting]) -> Tradeoff {
        let Self { device, subject, options, partial, made, analytic, surveyed, skipped, .. } = self;
        let facts = made.facts;
        let content = partial.content;
        let row = |setting: &Setting| summary::row(setting, &content.settings[&setting.key()]);
        let mut rows: Vec<Row> = settings.iter().map(row).collect();
        summary::mark_front(&mut rows);
        // An image of one sample in a pixel tends to no reference with many.
        let convergence = if surveyed.is_some() { Vec::new() } else { summary::convergence(settings, &rows) };
        let analytic = analytic.map(|known| Analytic { slope: analytic::slope(&rows, known.dealt_once), ..known });
        let findings = match surveyed {
            Some(_) => surfaces::findings::check_statements(&rows),
            None => findings::check_statements(&rows, analytic.as_ref()),
        };
        let info = device.info();
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
            rows,
            skipped,
            convergence,
            findings,
        }
    }
}

/// All errors of an image.
fn errors(reference: &LinearImage, image: &LinearImage) -> Errors {
    let all = metrics::compare(reference, image).expect("both are frames of one size");
    Errors {
        rmse: all.rmse,
        nmse: all.nmse,
        psnr: Some(all.psnr).filter(|psnr| psnr.is_finite()),
        ssim: all.ssim,
        flip: all.flip,
        max: all.max.value,
        above_1_255: all.above_1_255,
    }
}

impl Timed {
    fn new(profile: &FrameProfile, sitting: u32) -> Self {
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
        let passes = profile.passes.iter().map(|pass| (pass.name.to_owned(), ms(pass.gpu))).collect();
        Self { sitting, gpu_ms: ms(profile.gpu()), wall_ms: ms(profile.wall), passes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_settings_are_seen_coming() {
        assert_eq!(predict(&[], 4.0), None);
        assert_eq!(predict(&[(1.0, 2.0)], 4.0), Some(8.0));
        // One and four samples are both one stratum.
        assert_eq!(predict(&[(1.0, 2.0), (1.0, 2.5)], 4.0), Some(10.0));
        assert_eq!(predict(&[(1.0, 2.0), (1.0, 2.5), (4.0, 4.0)], 16.0), Some(10.0));
        assert_eq!(predict(&[(1.0, 3.0), (4.0, 2.0)], 16.0), Some(2.0));
    }
}
