//! Trial frames, and results of earlier ones.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use pellucid_core::progress::Progress;
use serde::{Deserialize, Serialize};

use super::limit;
use super::renderers::Renderers;
use super::survey::TrialResult;
use super::table::MeasuredSetting;
use super::{ChoiceFrame, Figures};
use crate::area::{self, Against};
use crate::candidates::{Formation, Occasion, Setting, formation};
use pellucid_core::image::LinearImage;
use pellucid_core::metrics;
use pellucid_engine::methods::{self, Frame, Rendered, Renderer, Stop, Upload, linear};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::profile::median;
use pellucid_engine::totals::{self, Effort};
use pellucid_engine::{Result, identity};
use pellucid_gpu as gpu;
use pellucid_gpu::{Device, Yardstick};
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{Detail, Method};

/// Frames behind a median where two settings are close.
const FRAMES: usize = 7;
/// Frames behind a median if a frame takes more than a second.
const SLOW_FRAMES: usize = 3;
/// Timed frames of a first look at a setting.
const LOOKS: usize = 2;
/// Ratio to the best time so far up to which a setting gets a second trial.
const CLOSE: f64 = 1.4;
/// Folder of the cache.
const KIND: &str = "choices";

/// Spread of times of a setting above which a busy machine is to be suspected: the slowest frame took half as long
/// again as the fastest one.
const BUSY: f64 = 0.5;

/// Measurements of one setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Record {
    rmse: f64,
    gpu_ms: Vec<f64>,
    peak_device_bytes: u64,
}

impl Record {
    /// The figures with the median time. With few frames the minimum is used, since disturbances only make frames
    /// slower.
    fn figures(&self) -> Figures {
        let gpu_ms = if self.is_settled() { median(self.gpu_ms.clone()) } else { self.least() };
        Figures { rmse: self.rmse, gpu_ms }
    }

    /// Returns the difference between the slowest and the fastest frame, relative to the fastest; `None` for a single
    /// one.
    fn spread(&self) -> Option<f64> {
        let most = self.gpu_ms.iter().copied().fold(0.0, f64::max);
        (self.gpu_ms.len() > 1).then(|| most / self.least() - 1.0)
    }

    /// True if other work on the machine has to be suspected behind the spread.
    fn is_busy(&self) -> bool {
        self.spread().is_some_and(|spread| spread > BUSY)
    }

    fn least(&self) -> f64 {
        self.gpu_ms.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// True if more frames would add little information.
    fn is_settled(&self) -> bool {
        self.gpu_ms.len() >= if self.least() > 1e3 { SLOW_FRAMES } else { FRAMES }
    }
}

/// The cached measurements of a scene.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct CachedRecords {
    max_list: u32,
    /// Keyed by [`Setting::key`].
    records: BTreeMap<String, Record>,
    /// The setting that was chosen, by what was wished for.
    #[serde(default)]
    chosen: BTreeMap<String, String>,
}

impl CachedRecords {
    /// Returns the records without those measured on a busy machine, except those of a chosen setting: a constraint
    /// keeps its choice.
    fn kept(&self) -> Self {
        let is_chosen = |key: &String| self.chosen.values().any(|chosen| chosen == key);
        let mut kept = self.clone();
        kept.records.retain(|key, record| !record.is_busy() || is_chosen(key));
        kept
    }
}

/// Everything that is measured of one scene: by a choice, or setting by setting for whoever compares images.
pub struct Trials<'a> {
    device: &'a Device,
    clouds: Clouds<'a>,
    subject: &'a ChoiceFrame<'a>,
    progress: &'a Progress,
    /// The frame of the exact method.
    frame: Frame,
    /// Samples of a pixel in the reference.
    samples: u32,
    formation: Formation,
    key: String,
    known: CachedRecords,
    /// Settings that could not be rendered, and why the last of them could not.
    refused: BTreeSet<String>,
    pub(super) refusal: Option<methods::Error>,
    renderer: Renderer,
    /// Rendered once anything has to be compared with it.
    reference: Option<LinearImage>,
    /// Rendered so far.
    pub(super) frames: usize,
}

impl<'a> Trials<'a> {
    /// Renders the image of the exact method, unless measurements of this scene are known and not to be repeated.
    ///
    /// # Errors
    /// Errors of [`super::choose`].
    pub fn open(
        device: &'a Device,
        cloud: &'a mut DeviceCloud,
        subject: &'a ChoiceFrame<'a>,
        recalibrate: bool,
        progress: &'a Progress,
    ) -> Result<Self> {
        Self::open_against(Against::Center, device, cloud, subject, recalibrate, progress)
    }

    /// Like [`Self::open`], with errors against this picture.
    pub(super) fn open_against(
        against: Against,
        device: &'a Device,
        cloud: &'a mut DeviceCloud,
        subject: &'a ChoiceFrame<'a>,
        recalibrate: bool,
        progress: &'a Progress,
    ) -> Result<Self> {
        let formation = formation(&subject.frame.method, subject.arranged.points())?;
        // Errors are those of every bit, and lists are not counted for the trials.
        let frame = Frame { method: formation.exact(), stop: Stop::Exact, fragments: false, ..subject.frame };
        let (samples, formed) = match against {
            Against::Center => (frame.samples, format!("{formation:?}")),
            Against::Area => (area::MOST, format!("{formation:?} against the area")),
        };
        let key =
            identity::hash(subject.arranged, &Frame { samples, ..frame }, subject.background, &formed, device.info());
        let stored = gpu::cache::load(KIND, &key).filter(|_| !recalibrate);
        let known: Option<CachedRecords> = stored.and_then(|bytes| serde_json::from_slice(&bytes).ok());
        let renderer = Renderer::new(device)?;
        let (is_new, known) = (known.is_none(), known.unwrap_or_default());
        let mut trials = Self {
            device,
            clouds: Clouds { arranged: subject.arranged, cloud, levels: None },
            subject,
            progress,
            frame,
            samples,
            formation,
            key,
            known,
            refused: BTreeSet::new(),
            refusal: None,
            renderer,
            reference: None,
            frames: 0,
        };
        if is_new {
            trials.reference()?;
        }
        Ok(trials)
    }

    /// Keeps what is known for the next run.
    pub(super) fn store(&self) {
        if let Ok(bytes) = serde_json::to_vec(&self.known.kept()) {
            gpu::cache::store(KIND, &self.key, &bytes);
        }
    }

    /// The earlier choice for the same constraint. Times differ from run to run, but the choice must not.
    pub(super) fn chosen(&self, wish: &str, all: &[Setting]) -> Option<(Setting, Figures)> {
        let key = self.known.chosen.get(wish)?;
        let setting = all.iter().find(|setting| setting.key() == *key)?;
        Some((setting.clone(), self.figures(setting)?))
    }

    /// Takes note of a choice.
    pub(super) fn choose(&mut self, wish: String, setting: &Setting) {
        self.known.chosen.insert(wish, setting.key());
    }

    /// A setting by the median of frames at a steady clock ([`totals::measure`]), whatever else is known of it; `None`
    /// if it can't be rendered. If a frame takes more than `most` ms, one is measured.
    ///
    /// # Errors
    /// A lost device, a message of the validation layers.
    pub fn measure(&mut self, setting: &Setting, effort: Effort, most: Option<f64>) -> Result<Option<TrialResult>> {
        match self.measured(setting, effort, most) {
            Ok(found) => {
                self.device.check_validation()?;
                Ok(Some(found))
            }
            Err(pellucid_engine::Error::Render(error)) if error.is_refusal() => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn measured(&mut self, setting: &Setting, effort: Effort, most: Option<f64>) -> Result<TrialResult> {
        // For the error, and for the most memory.
        let Record { rmse, gpu_ms, peak_device_bytes } = self.first_frames(setting, 1, None)?;
        let is_slow = most.is_some_and(|most| median(gpu_ms) > most);
        let effort = if is_slow { Effort { warm_up: Duration::ZERO, frames: 1, ..effort } } else { effort };
        let (cloud, detail) = self.clouds.of(&self.renderer, self.frame.detail, setting.detail)?;
        let samples = setting.samples.unwrap_or(self.frame.samples);
        let frame = Frame { method: setting.method, detail, samples, ..self.frame };
        // Whatever else runs on a CPU's cores disturbs every measurement there. Not kept: its memory would count for
        // that of the next setting.
        let yardstick = if self.device.info().is_cpu() { None } else { Some(Yardstick::new(self.device)?) };
        let totals = totals::measure(&mut self.renderer, cloud, &frame, yardstick.as_ref(), effort)?;
        self.frames += totals.device.count;
        let figures = Figures { rmse, gpu_ms: totals.device.median };
        Ok(TrialResult { figures, peak_device_bytes, is_steady: totals.is_steady() })
    }

    /// The properties of the scene that decide which settings apply.
    pub fn occasion(&self) -> Occasion {
        Occasion::new(self.subject.arranged.points(), self.formation, self.known.max_list)
    }

    /// The number of settings with measurements.
    pub(super) fn known(&self) -> usize {
        self.known.records.len()
    }

    /// A row for each setting that was measured.
    pub(super) fn rows(&self, all: &[Setting]) -> Vec<MeasuredSetting> {
        let row = |setting: &Setting| {
            let record = self.known.records.get(&setting.key())?;
            let name = format!("{} {}", setting.method.name(), setting.text).trim_end().to_owned();
            Some(MeasuredSetting { name, figures: record.figures(), spread: record.spread(), busy: record.is_busy() })
        };
        all.iter().filter_map(row).collect()
    }

    /// The figures of a setting that was measured.
    pub(super) fn figures(&self, setting: &Setting) -> Option<Figures> {
        self.known.records.get(&setting.key()).map(Record::figures)
    }

    /// The figures of a setting, measured now unless they are cached; `None` if it can't be rendered. `best` is the
    /// time of the best setting so far. The first frame pays for buffers and shaders; after it, a much slower setting
    /// gets one frame, others two.
    pub(super) fn look(&mut self, setting: &Setting, best: Option<f64>) -> Result<Option<Figures>> {
        if self.figures(setting).is_none() && !self.refused.contains(&setting.key()) {
            self.progress.set_message(format!("choosing the method: {}", setting.key()));
            match self.first_frames(setting, LOOKS, best) {
                Ok(record) => {
                    self.device.check_validation()?;
                    self.known.records.insert(setting.key(), record);
                }
                Err(pellucid_engine::Error::Render(error)) if error.is_refusal() => {
                    self.refused.insert(setting.key());
                    self.refusal = Some(error);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(self.figures(setting))
    }

    /// A frame that pays for buffers and shaders, then so many that are timed, up to one that is much slower than
    /// `best`.
    fn first_frames(&mut self, setting: &Setting, frames: usize, best: Option<f64>) -> Result<Record> {
        let first = self.render(setting.method, setting.detail, setting.samples)?;
        let image = linear(&first.image, self.subject.background, self.frame.color)?;
        self.renderer.recycle(first.image);
        self.reference()?;
        let reference = self.reference.as_ref().expect("rendered above");
        let rmse = metrics::rmse(&reference.pixels, &image.pixels);
        let peak_device_bytes = first.facts.peak_device_bytes;
        let mut gpu_ms = Vec::new();
        while gpu_ms.len() < frames {
            let rendered = self.render(setting.method, setting.detail, setting.samples)?;
            let ms = gpu(&rendered);
            self.renderer.recycle(rendered.image);
            gpu_ms.push(ms);
            if best.is_some_and(|best| ms > CLOSE * best) {
                break;
            }
        }
        Ok(Record { rmse, gpu_ms, peak_device_bytes })
    }

    /// A frame; of a detail that leaves nothing out with that of the scene.
    fn render(&mut self, method: Method, detail: Detail, samples: Option<u32>) -> Result<Rendered> {
        let (cloud, detail) = self.clouds.of(&self.renderer, self.frame.detail, detail)?;
        let samples = samples.unwrap_or(self.frame.samples);
        let rendered = self.renderer.render(cloud, &Frame { method, detail, samples, ..self.frame })?;
        self.frames += 1;
        Ok(rendered)
    }

    fn reference(&mut self) -> Result<()> {
        if self.reference.is_none() {
            if let Some(image) = limit::ensembles(self.subject.arranged, &Frame { samples: self.samples, ..self.frame })
            {
                self.reference = Some(linear(&image, self.subject.background, self.frame.color)?);
                return Ok(());
            }
            let rendered = self.render(self.frame.method, Detail::default(), Some(self.samples))?;
            self.known.max_list = rendered.facts.max_list;
            self.reference = Some(linear(&rendered.image, self.subject.background, self.frame.color)?);
        }
        Ok(())
    }

    /// The fastest of some measured settings: those close to it take turns until their medians are reliable.
    pub(super) fn fastest(&mut self, settings: &[&Setting]) -> Result<Option<(Setting, Figures)>> {
        let ms = |trials: &Self, setting: &Setting| trials.figures(setting).map_or(f64::INFINITY, |f| f.gpu_ms);
        let least = settings.iter().map(|setting| ms(self, setting)).fold(f64::INFINITY, f64::min);
        let close: Vec<&Setting> =
            settings.iter().copied().filter(|setting| ms(self, setting) <= CLOSE * least).collect();
        self.settle(&close)?;
        let fastest = close.into_iter().min_by(|a, b| ms(self, a).total_cmp(&ms(self, b)));
        Ok(fastest.and_then(|setting| Some((setting.clone(), self.figures(setting)?))))
    }

    /// Times settings in turns until their medians are reliable.
    pub(super) fn settle(&mut self, settings: &[&Setting]) -> Result<()> {
        let open = |trials: &Self, setting: &Setting| {
            trials.known.records.get(&setting.key()).is_some_and(|record| !record.is_settled())
        };
        let mut left: Vec<&Setting> = settings.iter().copied().filter(|setting| open(self, setting)).collect();
        let peak = |setting: &&Setting| {
            let record = self.known.records.get(&setting.key());
            (setting.method.name(), record.map_or(0, |record| record.peak_device_bytes))
        };
        let mut renderers = Renderers::new(self.device, left.iter().map(peak));
        let mut is_warm = false;
        while !left.is_empty() {
            for setting in &left {
                self.progress.set_message(format!("choosing the method: {} again", setting.key()));
                let renderer = renderers.for_method(setting.method.name())?;
                self.frames += 1;
                let (cloud, detail) = self.clouds.of(renderer, self.frame.detail, setting.detail)?;
                let samples = setting.samples.unwrap_or(self.frame.samples);
                let frame = Frame { method: setting.method, detail, samples, ..self.frame };
                if !setting.detail.is_whole() {
                    // Which points it has is found once.
                    renderer.render(cloud, &frame)?;
                }
                let rendered = renderer.render(cloud, &frame)?;
                let ms = gpu(&rendered);
                renderer.recycle(rendered.image);
                if let (true, Some(record)) = (is_warm, self.known.records.get_mut(&setting.key())) {
                    record.gpu_ms.push(ms);
                }
            }
            is_warm = true;
            left.retain(|setting| open(self, setting));
        }
        Ok(self.device.check_validation()?)
    }
}

/// The points on the device.
struct Clouds<'a> {
    arranged: &'a Arranged,
    cloud: &'a mut DeviceCloud,
    /// The points for frames that leave some out, if `cloud` has all of them on the device.
    levels: Option<DeviceCloud>,
}

impl Clouds<'_> {
    /// The points for frames of a detail, and the detail; that of the scene where it leaves nothing out.
    fn of(&mut self, renderer: &Renderer, own: Detail, detail: Detail) -> Result<(&mut DeviceCloud, Detail)> {
        if detail.is_whole() || self.cloud.supply().is_some() {
            return Ok((&mut *self.cloud, if detail.is_whole() { own } else { detail }));
        }
        let levels = match self.levels.take() {
            Some(levels) => levels,
            None => renderer.upload(Upload::with_detail(self.arranged, &detail))?,
        };
        Ok((self.levels.insert(levels), detail))
    }
}

/// Device time of a frame in ms.
fn gpu(rendered: &Rendered) -> f64 {
    rendered.profile.gpu().as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measurements_of_a_busy_machine_are_not_kept() {
        let record = |gpu_ms: &[f64]| Record { rmse: 0.1, gpu_ms: gpu_ms.to_vec(), peak_device_bytes: 1 };
        let records = [("calm", &[2.0, 2.5][..]), ("once", &[2.0]), ("busy", &[2.0, 3.1]), ("chosen", &[2.0, 9.0])];
        let known = CachedRecords {
            max_list: 3,
            records: records.map(|(key, times)| (key.to_owned(), record(times))).into(),
            chosen: [("a wish".to_owned(), "chosen".to_owned())].into(),
        };
        let kept = known.kept();
        assert_eq!(kept.records.keys().collect::<Vec<_>>(), ["calm", "chosen", "once"]);
        assert_eq!((kept.max_list, &kept.chosen), (3, &known.chosen));
    }
}
