//! The first frames of a setting: memory, errors, pictures, and about how long a frame takes.

use std::time::Instant;

use pellucid_core::image::{Image, LinearImage};
use pellucid_core::metrics::{self, difference_picture};
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Facts, Rendered, Renderer};
use pellucid_scene::prepare::Arranged;

use super::limit::{self, Account, Spent};
use super::{ALONE_SHARE, FRAME_SHARE, Options, TradeoffRun};
use crate::report::tradeoff::partial::{SettingResults, Timed};
use crate::report::tradeoff::repeats::Seeds;
use crate::report::tradeoff::{DIFFERENCE_GAIN, Errors, Row, analytic};
use pellucid_session::candidates::Setting;

/// The images of a stochastic setting take at most 1/`SEEDS_SHARE` of the time, beyond the two that it needs.
const SEEDS_SHARE: f64 = 80.0;
/// Part of the time for first frames, errors and seeds.
const TRIALS_SHARE: f64 = 0.6;

impl TradeoffRun<'_> {
    /// The first frames of all settings; those that were not skipped, in their order.
    pub(super) fn trials(&mut self, settings: &[Setting]) -> Result<Vec<Setting>> {
        let order = match self.options.end {
            Some(_) => limit::method_by_method(settings),
            None => (0..settings.len()).collect(),
        };
        let mut taken: Vec<usize> = Vec::new();
        for at in order {
            let before: Vec<&Setting> = taken.iter().map(|at| &settings[*at]).collect();
            self.progress.set_message(format!("errors, {}", settings[at].key()));
            if self.trial(&settings[at], &before)? {
                taken.push(at);
            }
            self.progress.inc(1);
        }
        taken.sort_unstable();
        Ok(taken.into_iter().map(|at| settings[at].clone()).collect())
    }

    /// The first frames of a setting, unless they are there already; false if it was skipped. `before` are the settings
    /// that were not.
    fn trial(&mut self, setting: &Setting, before: &[&Setting]) -> Result<bool> {
        if self.partial.content.settings.contains_key(&setting.key()) {
            return Ok(true);
        }
        if let Some(reason) = self.too_slow(setting, before) {
            self.skipped.push(setting.too_slow(reason));
            return Ok(false);
        }
        let begin = Instant::now();
        match self.first_frames(setting) {
            Ok(measured) => {
                self.device.check_validation()?;
                self.tried.push(Spent { frame: measured.seconds, whole: begin.elapsed().as_secs_f64() });
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

    /// Returns the reason why a setting would take too long, by those before, if it would.
    fn too_slow(&self, setting: &Setting, before: &[&Setting]) -> Option<String> {
        let frame = self.predicted(setting, before);
        frame.and_then(|seconds| self.slow_frame(seconds, before)).or_else(|| self.late(frame, before))
    }

    /// Seconds of a frame of a setting, by the steps of its ladder before.
    fn predicted(&self, setting: &Setting, before: &[&Setting]) -> Option<f64> {
        let times: Vec<(f64, f64)> = before
            .iter()
            .filter(|other| other.series == setting.series)
            .filter_map(|other| Some((other.effort?, self.first(other)?.seconds)))
            .collect();
        predict(&times, setting.effort?).or_else(|| {
            // Of fewer samples in a pixel, in proportion.
            let fewer = before.iter().rev().filter(|other| other.is_like(setting));
            let known = fewer.filter_map(|other| Some((f64::from(other.samples?), self.first(other)?.seconds))).next();
            let (count, seconds) = known?;
            Some(seconds * f64::from(setting.samples?) / count)
        })
    }

    /// The first frames of a setting, if they are there.
    fn first(&self, setting: &Setting) -> Option<&SettingResults> {
        self.partial.content.settings.get(&setting.key())
    }

    /// Returns the reason why a setting does not fit the time that is left for everything; `frame` are the predicted
    /// seconds of a frame.
    fn late(&self, frame: Option<f64>, before: &[&Setting]) -> Option<String> {
        let left = self.left()?;
        let Options { seconds, rounds, .. } = *self.options;
        let account = Account { tried: &self.tried, alone: seconds / ALONE_SHARE, rounds };
        let owed: f64 = before.iter().filter_map(|other| Some(account.in_turns(self.first(other)?.seconds))).sum();
        limit::refusal(account.needed(frame)?, left - owed, seconds)
    }

    /// Seconds that are left before the report is written; `None` without an end.
    pub(super) fn left(&self) -> Option<f64> {
        Some(limit::left(self.options.end?, Instant::now(), self.options.seconds))
    }

    /// Returns the reason why a frame of so many seconds takes too long, if it does.
    fn slow_frame(&self, seconds: f64, before: &[&Setting]) -> Option<String> {
        let all = self.options.seconds;
        let about = format!("a frame would take about {seconds:.1} s by the settings before; of {all} s in all");
        let most = all / FRAME_SHARE;
        if seconds > most {
            return Some(format!("{about} one may take {most:.1} s"));
        }
        let images = |first: &SettingResults| first.row.repeats.map_or(2, |repeats| repeats.seeds.max(2));
        let spent: f64 = before
            .iter()
            .filter_map(|other| self.first(other))
            .map(|first| f64::from(images(first)) * first.seconds)
            .sum();
        // Two of them, as of every setting.
        let left = TRIALS_SHARE * all - spent;
        (2.0 * seconds > left).then(|| format!("{about} {:.1} s are left for first frames", left.max(0.0)))
    }

    /// Renders a setting with fresh buffers: measures memory, errors, pictures, and the approximate time of a frame,
    /// which is final for slow settings.
    fn first_frames(&mut self, setting: &Setting) -> Result<SettingResults> {
        let mut renderer = Renderer::new(self.device)?;
        let first = self.render(&mut renderer, setting, 0)?;
        let image = self.linear(&first.image)?;
        let silhouette = self.made.silhouette.as_ref();
        let holes = silhouette.and_then(|silhouette| silhouette.holes(&first.image));
        let rmse_inside = silhouette.and_then(|silhouette| silhouette.rmse(&self.made.reference, &image));
        let look = self.look(setting, &image)?;
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
            self.add(&mut seeds, &second.image)?;
            renderer.recycle(second.image);
            let allowed = (self.options.seconds / SEEDS_SHARE / with_upload) as u32;
            for number in 2..allowed.min(self.options.seeds) {
                let rendered = self.render_anew(&mut renderer, setting, number)?;
                self.add(&mut seeds, &rendered.image)?;
                renderer.recycle(rendered.image);
            }
            (seeds.errors(), Some(seeds.repeats()), seeds.rmse_analytic())
        } else {
            (errors, None, self.rmse_analytic(&image))
        };
        // Written last, so that a skipped setting leaves no pictures.
        let [picture, difference] = self.pictures(setting, &image)?;
        let Facts { peak_device_bytes, fragment_bytes, .. } = first.facts;
        let row = Row {
            method: setting.method.name().to_owned(),
            setting: setting.text.clone(),
            step: setting.step.map(|(key, value)| (key.to_owned(), value)),
            thinning: setting.thinning,
            stochastic: setting.is_stochastic(),
            peak_device_bytes,
            fragment_bytes,
            errors,
            repeats,
            rmse_analytic,
            holes,
            rmse_inside,
            look,
            picture,
            difference,
            ..Row::default()
        };
        Ok(SettingResults { row, seconds, frames })
    }

    /// Renders like [`TradeoffRun::render`], but shuffles points into other ensembles: their choice is as random as the
    /// samples.
    fn render_anew(
        &mut self,
        renderer: &mut Renderer,
        setting: &Setting,
        image: u32,
    ) -> Result<Rendered, methods::Error> {
        match self.subject.arranged {
            Arranged::Dealt(dealt) => {
                let frame = self.frame_of(setting, image);
                let mut cloud = renderer.upload(&Arranged::Dealt(dealt.again(frame.seed)))?;
                renderer.render(&mut cloud, &frame)
            }
            Arranged::Canonical(_) | Arranged::Supplied(_) => self.render(renderer, setting, image),
        }
    }

    fn add(&self, seeds: &mut Seeds, image: &Image) -> Result<()> {
        let image = self.linear(image)?;
        seeds.add(&image.pixels, &self.made.reference.pixels, self.errors(&image), self.rmse_analytic(&image));
        Ok(())
    }

    fn rmse_analytic(&self, image: &LinearImage) -> Option<f64> {
        self.analytic.as_ref().map(|analytic| analytic::rmse(analytic.color, image))
    }

    /// All errors of an image.
    fn errors(&self, image: &LinearImage) -> Errors {
        let all = metrics::compare(&self.made.reference, image).expect("both are frames of one size");
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

    fn pictures(&self, setting: &Setting, image: &LinearImage) -> Result<[String; 2]> {
        let names = [format!("{}.png", setting.stem()), format!("{}-difference.png", setting.stem())];
        self.write_picture(&names[0], &image.pixels)?;
        let difference = difference_picture(&self.made.reference.pixels, &image.pixels, DIFFERENCE_GAIN);
        self.write_picture(&names[1], &difference)?;
        Ok(names)
    }
}

/// Predicts the seconds of a frame with this effort from (effort, seconds) of earlier steps: on the line through the
/// last two, or in proportion to the effort. `None` without earlier steps.
fn predict(times: &[(f64, f64)], effort: f64) -> Option<f64> {
    let &(last, seconds) = times.last()?;
    Some(match times.iter().rev().find(|(before, _)| *before < last) {
        Some((before, less)) => seconds + ((seconds - less) / (last - before)).max(0.0) * (effort - last),
        None => seconds * effort / last,
    })
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
