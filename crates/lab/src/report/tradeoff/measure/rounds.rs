//! Timed frames of all settings, in turns.

use std::collections::BTreeMap;

use pellucid_engine::Result;
use pellucid_engine::methods::{FrameProfile, Renderer};

use super::{ALONE_SHARE, TradeoffRun};
use crate::report::tradeoff::partial::Timed;
use crate::report::tradeoff::summary;
use pellucid_session::candidates::Setting;
use pellucid_session::choice::Renderers;

/// Part of the time for frames that are timed in turns.
const ROUNDS_SHARE: f64 = 0.35;

impl TradeoffRun<'_> {
    /// Times frames of all settings in turns, so that a machine that slows down affects all of them. Rounds timed by an
    /// earlier run are kept; only the missing frames are rendered.
    pub(super) fn rounds(&mut self, settings: &[Setting]) -> Result<()> {
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
                if missing(self, setting, round) && !self.is_late(setting) {
                    self.progress.set_message(format!("times, {}", setting.key()));
                    let renderer = renderers.for_method(setting.method.name())?;
                    self.time(renderer, setting, round)?;
                    self.progress.inc(1);
                }
            }
        }
        Ok(self.device.check_validation()?)
    }

    /// True if no time is left for a further frame of a setting.
    fn is_late(&self, setting: &Setting) -> bool {
        let is_timed = !self.partial.content.settings[&setting.key()].frames.is_empty();
        is_timed && self.left().is_some_and(|left| left <= 0.0)
    }

    fn time(&mut self, renderer: &mut Renderer, setting: &Setting, round: usize) -> Result<()> {
        if !self.clouds.are_on_device(setting.thinning, &setting.detail) {
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
    /// time, and one for those that are timed alone. Without an end it depends only on the trials, so that an
    /// interrupted run arrives at the same numbers.
    fn wanted(&self, settings: &[Setting]) -> BTreeMap<String, usize> {
        let seconds = |setting: &Setting| self.partial.content.settings[&setting.key()].seconds;
        let most = self.options.seconds / ALONE_SHARE;
        let (in_turns, alone): (Vec<&Setting>, Vec<&Setting>) = settings.iter().partition(|s| seconds(s) <= most);
        let costs: Vec<f64> = in_turns.iter().map(|setting| seconds(setting)).collect();
        let share = ROUNDS_SHARE * self.options.seconds;
        let counts = summary::frames(&costs, self.options.rounds, self.left().map_or(share, |left| left.min(share)));
        let in_turns = in_turns.iter().map(|setting| setting.key()).zip(counts);
        in_turns.chain(alone.iter().map(|setting| (setting.key(), 1))).collect()
    }

    fn peak(&self, setting: &Setting) -> u64 {
        self.partial.content.settings[&setting.key()].row.peak_device_bytes
    }
}

impl Timed {
    pub(super) fn new(profile: &FrameProfile, sitting: u32) -> Self {
        let ms = |time: std::time::Duration| time.as_secs_f64() * 1e3;
        let passes = profile.passes.iter().map(|pass| (pass.name.to_owned(), ms(pass.gpu))).collect();
        Self { sitting, gpu_ms: ms(profile.gpu()), wall_ms: ms(profile.wall), passes }
    }
}
