//! The phases of a command: how long each took.

use std::time::Duration;

use serde_json::{Value, json};

use super::Profile;
use crate::gpu::Compilation;
use crate::progress::{Phase, Span};

impl Profile {
    /// Adds the phases of a command, and the pipelines that its device made meanwhile.
    pub fn add_host(&mut self, phases: Vec<Span>, compilations: &[Compilation]) {
        self.host.extend(phases);
        let span = |made: &Compilation| Span { phase: Phase::Compile, begin: made.begin, length: made.time };
        self.host.extend(compilations.iter().map(span));
    }

    /// Returns the time of each phase, by [`Phase::ALL`]. Making pipelines does not count for the phase that it lies
    /// within.
    pub fn host_times(&self) -> [Duration; Phase::ALL.len()] {
        let mut times = [Duration::ZERO; Phase::ALL.len()];
        for span in &self.host {
            times[span.phase as usize] += span.length;
        }
        for compile in self.host.iter().filter(|span| span.phase == Phase::Compile) {
            if let Some(around) = self.host.iter().find(|span| encloses(span, compile)) {
                let time = &mut times[around.phase as usize];
                *time = time.saturating_sub(compile.length);
            }
        }
        times
    }

    /// Returns a line for people: the phases that took time, in milliseconds.
    pub fn host_text(&self) -> String {
        let phase = |(phase, time): (Phase, Duration)| format!("{} {:.1} ms", phase.name(), time.as_secs_f64() * 1e3);
        let phases: Vec<String> = self.shown_phases().map(phase).collect();
        format!("host: {}", phases.join(", "))
    }

    /// Returns the phases that took time, and those that every command has, with their milliseconds.
    pub(super) fn host_json(&self) -> Vec<Value> {
        let phase = |(phase, time): (Phase, Duration)| json!({"name": phase.name(), "ms": time.as_secs_f64() * 1e3});
        self.shown_phases().map(phase).collect()
    }

    fn shown_phases(&self) -> impl Iterator<Item = (Phase, Duration)> {
        let is_shown =
            |(phase, time): &(Phase, Duration)| !time.is_zero() || matches!(phase, Phase::Read | Phase::Frame);
        Phase::ALL.into_iter().zip(self.host_times()).filter(is_shown)
    }
}

/// Returns `true` if a phase runs while pipelines are made.
fn encloses(span: &Span, compile: &Span) -> bool {
    span.phase != Phase::Compile && (span.begin..span.begin + span.length).contains(&compile.begin)
}
