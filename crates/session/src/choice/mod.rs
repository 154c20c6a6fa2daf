//! Chooses a method and its setting by error or by time, from measurements on the very image to be rendered.
//!
//! Every setting is measured as it will be rendered: same points, camera, size and seed. Its error is the RMSE on
//! composed linear R, G, B, in float64, against the exact method (`abuffer` or `soft-base`) or against the limit that
//! ensembles converge to. Its time is the median device time of frames. These are the two axes of `tradeoff`'s Pareto
//! front. Measurements are cached by scene, device and version: another constraint on the same scene only measures what
//! is missing, and the same constraint measures nothing.
//!
//! **By error**: the exact methods first; then each ladder of approximations from its cheap end, until a step is
//! accurate enough or slower than the fastest accurate one. Stochastic errors fall as samples^(−1/2), so two small
//! steps predict the next one to try, and that one is measured, too. **By time**: the fastest exact method if it fits,
//! else each ladder until a step takes too long. In the end all candidates close to the best take turns with it for a
//! few more frames.
//!
//! **Against the area** of pixels the reference has [`area::MOST`] samples in a pixel, and each setting is tried with
//! [`area::CHOSEN`]. The exact methods tell how many samples an error takes; fewer are not tried with the others, whose
//! own errors would come on top.

mod climb;
mod limit;
mod renderers;
mod survey;
mod table;
mod trials;

use glam::Vec3;
use pellucid_core::metrics::error_text;
use pellucid_core::progress::Progress;
use serde_json::{Value, json};

use crate::messages::Messages;

use crate::area::{self, Against};
use crate::candidates::{Ladders, Setting, formation, settings, with_samples};
pub use limit::{ensembles, image_of};
use pellucid_core::points::Points;
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Frame};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::plan;
use pellucid_gpu::Device;
use pellucid_scene::prepare::Arranged;
use pellucid_scene::{self as scene, Detail, Method, Scene};
pub use renderers::Renderers;
pub use survey::{Lists, TrialResult};
pub use table::MeasuredSetting;
pub use trials::Trials;

/// RMSE up to this is rounding: settings below it count as equally accurate, and the fastest of them wins.
pub const EXACT: f64 = 1e-6;

/// The requested limits. If both are given, the error decides and the time is only checked.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wish {
    /// The largest RMSE allowed: the fastest setting that keeps to it.
    pub max_error: Option<f64>,
    /// The largest allowed device time of a frame, in ms; the most accurate setting within it is chosen.
    pub budget_ms: Option<f64>,
    /// The picture that errors are measured against. Against the area settings are tried with several numbers of
    /// samples of a pixel, in place of the scene's own.
    pub against: Against,
}

impl Wish {
    /// True if any limit is given.
    pub fn is_any(&self) -> bool {
        self.max_error.is_some() || self.budget_ms.is_some()
    }

    /// Returns the reason why limits have no effect for a scene of these points; `None` if they have one.
    pub fn hindrance(scene: &Scene, points: &Points) -> Option<String> {
        let taken = plan::resolve(scene.method, points).0;
        let stays = format!("{} stays the method", taken.name());
        if scene.shadows.is_some() && taken.takes_shadows() {
            Some(format!("with shadows: {stays}"))
        } else if scene.shading.edl.edl {
            Some(format!("with eye-dome lighting, which only some methods have: {stays}"))
        } else if formation(&scene.method.representative(), points).is_err() {
            Some(format!("with method {}, because no other method draws the same image", scene.method.name()))
        } else {
            None
        }
    }
}

/// The frame to choose for.
#[derive(Debug, Clone, Copy)]
pub struct ChoiceFrame<'a> {
    /// The scene's points, which `cloud` holds.
    pub arranged: &'a Arranged,
    /// The frame; of its method only whose image formation counts.
    pub frame: Frame,
    /// Linear RGB.
    pub background: Vec3,
    /// The only allowed method.
    pub only: Option<&'a str>,
}

/// Measurements of a setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// RMSE against the exact method, on this image: its picture with the same samples, or with those of the area.
    pub rmse: f64,
    /// Median device time of a frame.
    pub gpu_ms: f64,
}

/// The chosen setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The method with its setting.
    pub method: Method,
    /// The points that it leaves out; those that the frame leaves out anyway if there are none.
    pub detail: Detail,
    /// Samples of a pixel's area, where they were chosen as well.
    pub samples: Option<u32>,
    /// The setting as options of the command line would give it; empty for the defaults.
    pub setting: String,
    /// Measurements of the setting.
    pub figures: Figures,
    /// The constraint.
    pub wish: Wish,
    /// The unfulfilled part of the constraint, in words.
    pub warning: Option<String>,
    /// The best settings of those measured, the best one first.
    pub best: Vec<MeasuredSetting>,
    /// The number of settings with measurements.
    pub known: usize,
    /// Frames that were rendered to choose; 0 if all was known before.
    pub frames: usize,
}

impl Choice {
    /// Reports the choice, and what it was chosen among.
    pub(crate) fn describe(&self, messages: &dyn Messages) {
        messages.detail(&format_args!(
            "chosen among {} measured settings; frames rendered for it now: {}",
            self.known, self.frames
        ));
        let chosen = format!("{} {}", self.method.name(), self.setting);
        let Figures { rmse, gpu_ms } = self.figures;
        let rmse = error_text(rmse);
        messages.note(&format_args!("{}: RMSE {rmse}, {gpu_ms:.2} ms on the device", chosen.trim_end()));
        if let Some(warning) = &self.warning {
            messages.warn(warning);
        }
        messages.note(&table::listed(&self.best));
    }

    /// The wish, the setting and its figures as one JSON object: the image's `pellucid:choice`.
    pub fn json(&self) -> Value {
        let Self { method, setting, figures, wish, .. } = self;
        let mut json = json!({
            "max_error": wish.max_error,
            "budget_ms": wish.budget_ms,
            "method": method.name(),
            "setting": setting,
            "rmse": figures.rmse,
            "gpu_ms": figures.gpu_ms,
        });
        if let Some(samples) = self.samples {
            json["against"] = wish.against.word().into();
            json["samples"] = samples.into();
        }
        json
    }
}

/// Chooses. `recalibrate`: forgets what was known of this scene. `progress` ticks only.
///
/// # Errors
/// A method of another image formation, no setting of `only`, a frame that the exact method can't render, a lost
/// device.
pub fn choose(
    device: &Device,
    cloud: &mut DeviceCloud,
    subject: &ChoiceFrame<'_>,
    wish: Wish,
    recalibrate: bool,
    progress: &Progress,
) -> Result<Choice> {
    let mut trials = Trials::open_against(wish.against, device, cloud, subject, recalibrate, progress)?;
    let occasion = trials.occasion();
    let (mut all, _) = settings(&occasion, &Ladders::FINE);
    // Who asks for a detail has the choice of methods for that.
    all.retain(|setting| setting.detail.is_whole() || subject.frame.detail.is_whole());
    all.retain(|setting| subject.only.is_none_or(|only| only == setting.method.name()));
    if wish.against == Against::Area {
        all = with_samples(&all, &area::CHOSEN);
    }
    // If both limits are given, the error decides.
    let asked =
        format!("{:?} {:?} {:?}", wish.max_error, wish.budget_ms.filter(|_| wish.max_error.is_none()), subject.only);
    let found = match (trials.chosen(&asked, &all), wish.max_error, wish.budget_ms) {
        (Some(found), _, _) => Some(found),
        (None, Some(most), _) => climb::by_error(&mut trials, &all, most)?,
        (None, None, budget) => climb::by_time(&mut trials, &all, budget.unwrap_or(f64::INFINITY))?,
    };
    if let Some((setting, _)) = &found {
        trials.choose(asked, setting);
    }
    trials.store();
    let (setting, figures) = found.ok_or_else(|| none(subject.only, trials.refusal.take()))?;
    let warning = unfulfilled(wish, figures, subject.frame.size);
    let best = table::best(trials.rows(&all), wish);
    let Setting { method, text, detail, samples, .. } = setting;
    let detail = if detail.is_whole() { subject.frame.detail } else { detail };
    let (known, frames) = (trials.known(), trials.frames);
    Ok(Choice { method, detail, samples, setting: text, figures, wish, warning, best, known, frames })
}

/// Returns the error that says why nothing could be chosen.
fn none(only: Option<&str>, refusal: Option<methods::Error>) -> pellucid_engine::Error {
    let unknown = || {
        scene::Error::Usage(format!(
            "{}: this method is not among those compared for this scene",
            only.unwrap_or("any")
        ))
    };
    refusal.map_or_else(|| unknown().into(), Into::into)
}

/// The limits that the chosen setting misses, and what would help.
fn unfulfilled(wish: Wish, Figures { rmse, gpu_ms }: Figures, size: [u32; 2]) -> Option<String> {
    let error = wish.max_error.filter(|most| rmse > *most);
    let time = wish.budget_ms.filter(|most| gpu_ms > *most);
    let missed = match (error, time, wish.max_error) {
        (Some(most), _, _) => {
            Some(format!("no setting has an RMSE of at most {most}; the most accurate one is used, with {rmse:.1e}"))
        }
        (None, Some(most), Some(error)) => Some(format!(
            "no setting with an RMSE of at most {error} takes at most {most} ms; this one takes {gpu_ms:.1} ms"
        )),
        (None, Some(most), None) => {
            Some(format!("no setting takes at most {most} ms; the fastest one is used, with {gpu_ms:.1} ms"))
        }
        (None, None, _) => None,
    }?;
    let advice = time.and_then(|most| table::smaller(size, gpu_ms, most));
    Some([Some(missed), table::no_picture(rmse), advice].into_iter().flatten().collect::<Vec<_>>().join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missed_limits_are_reported() {
        let figures = Figures { rmse: 0.01, gpu_ms: 20.0 };
        let said = |max_error, budget_ms| {
            let wish = Wish { max_error, budget_ms, against: Against::Center };
            unfulfilled(wish, figures, [40, 30]).unwrap_or_default()
        };
        assert_eq!(said(Some(0.01), Some(20.0)), "");
        assert!(said(Some(0.001), Some(1.0)).contains("the most accurate one"));
        assert!(said(None, Some(1.0)).contains("the fastest one"));
        assert!(said(None, Some(5.0)).ends_with("; try about 20x15 pixels, or 1 of every 4 points"));
        assert!(said(Some(0.1), Some(1.0)).contains("takes at most 1 ms"));
    }
}
