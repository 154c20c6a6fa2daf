//! Times of the last frames, and the median of those comparable with the last one.

use std::collections::VecDeque;

use super::messages::WindowPicture;
use pellucid_engine::profile::median;

/// Number of frames whose times are kept.
pub const HISTORY: usize = 120;

/// Number of frames the median covers.
const RECENT: usize = 15;

/// The time of a frame.
#[derive(Debug, Clone)]
struct FrameTime {
    method: &'static str,
    /// The description of its draft.
    draft: String,
    wall_ms: f64,
    /// Milliseconds of each pass.
    passes: Vec<(&'static str, f64)>,
}

/// Medians of frames alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Medians {
    /// Milliseconds from submission to read-back.
    pub wall_ms: f64,
    /// Milliseconds of each pass, in the order of the last frame.
    pub passes: Vec<(&'static str, f64)>,
    /// Number of frames behind the medians.
    pub frames: usize,
}

/// The times of the last frames.
#[derive(Debug, Default)]
pub struct Times(VecDeque<FrameTime>);

impl Times {
    /// Adds a frame.
    pub fn add(&mut self, picture: &WindowPicture) {
        let profile = &picture.profile;
        self.push(FrameTime {
            method: picture.method,
            draft: picture.draft.clone(),
            wall_ms: profile.wall.as_secs_f64() * 1e3,
            passes: profile.passes.iter().map(|pass| (pass.name, pass.gpu.as_secs_f64() * 1e3)).collect(),
        });
    }

    fn push(&mut self, frame: FrameTime) {
        self.0.push_back(frame);
        if self.0.len() > HISTORY {
            self.0.pop_front();
        }
    }

    /// Milliseconds of each frame, the last one last.
    pub fn walls(&self) -> impl ExactSizeIterator<Item = f64> {
        self.0.iter().map(|frame| frame.wall_ms)
    }

    /// Medians of recent frames with the same method and draft as the last one, because a draft's time says nothing
    /// about the whole picture. `None` before the first frame.
    pub fn medians(&self) -> Option<Medians> {
        let last = self.0.back()?;
        let alike = |frame: &&FrameTime| frame.method == last.method && frame.draft == last.draft;
        let frames: Vec<&FrameTime> = self.0.iter().rev().filter(alike).take(RECENT).collect();
        let median_of = |name: &'static str| {
            let runs = frames.iter().flat_map(|frame| &frame.passes).filter(|(other, _)| *other == name);
            (name, median(runs.map(|(_, ms)| *ms).collect()))
        };
        let passes = last.passes.iter().map(|(name, _)| median_of(name)).collect();
        let wall_ms = median(frames.iter().map(|frame| frame.wall_ms).collect());
        Some(Medians { wall_ms, passes, frames: frames.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(draft: &str, wall_ms: f64) -> FrameTime {
        FrameTime { method: "abuffer", draft: draft.into(), wall_ms, passes: vec![("a", 0.5 * wall_ms), ("b", 1.0)] }
    }

    #[test]
    fn medians_are_those_of_frames_alike() {
        let mut times = Times::default();
        assert_eq!(times.medians(), None);
        for ms in [100.0, 300.0, 200.0] {
            times.push(frame("whole", ms));
            times.push(frame("4 × 4 pixels as one", ms / 10.0));
        }
        let medians = times.medians().unwrap();
        assert_eq!((medians.wall_ms, medians.passes, medians.frames), (20.0, vec![("a", 10.0), ("b", 1.0)], 3));
        times.push(frame("whole", 400.0));
        assert_eq!(times.medians().map(|medians| (medians.wall_ms, medians.frames)), Some((250.0, 4)));
        times.push(FrameTime { method: "sorted", ..frame("whole", 7.0) });
        assert_eq!(times.medians().map(|medians| (medians.wall_ms, medians.frames)), Some((7.0, 1)));
        (0..2 * HISTORY).for_each(|i| times.push(frame("whole", i as f64)));
        assert_eq!((times.walls().len(), times.walls().last()), (HISTORY, Some((2 * HISTORY - 1) as f64)));
        assert_eq!(times.medians().map(|medians| (medians.wall_ms, medians.frames)), Some((232.0, RECENT)));
    }
}
