//! Decides which task the worker gets, and when: drafts while things move, finer pictures at rest, then a measurement
//! of their accuracy.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Model, PictureState};
use crate::accuracy::Exactness;
use crate::draft::Effort;
use crate::messages::{Request, Task};
use pellucid_scene::Scene;

/// Factor between the time of a picture at rest and that of the one before it: all drafts together take a third of the
/// last one's time.
const REFINING: f64 = 4.0;

/// Milliseconds for the first picture at rest if the budget while things move is less: a delay the eye hardly notices.
const FIRST_AT_REST_MS: f64 = 250.0;

/// Pictures at rest after which nothing is left out any more.
pub(super) const MOST_REFINED: u32 = 6;

/// Time for which nothing may move before the picture is compared with the exact one.
pub const STILL: Duration = Duration::from_millis(500);

impl Model {
    /// The worker's next task, if any is due.
    pub fn next_task(&mut self, now: Instant) -> Option<Task> {
        if let Some(task) = self.tasks.pop_front() {
            return Some(task);
        }
        let effort = self.effort(now).filter(|_| !self.busy && !self.viewport.size.contains(&0));
        let Some((effort, refined)) = effort else { return self.measure(now) };
        self.serial += 1;
        self.picture_state = PictureState::Requested(self.serial, refined);
        let mut scene = Scene::clone(&self.scene);
        scene.image.size = self.viewport.size;
        scene.settle_for(|cloud| self.statistics().get(cloud)?.blend_space);
        self.explained = self.shows.explains_colors();
        let (scene, pose, serial, legend) = (Arc::new(scene), self.pose, self.serial, self.explained);
        Some(Task::Show(Box::new(Request { scene, pose, effort, serial, legend })))
    }

    /// The effort the next picture may take, if one is due, and its refinement count.
    fn effort(&self, now: Instant) -> Option<(Effort, u32)> {
        let moving = now < self.rest_at();
        match self.picture_state {
            // However late this is asked: a long frame may have kept the window waiting.
            PictureState::Stale => Some((Effort::Moving(self.budget_ms), 0)),
            PictureState::Draft(_) if moving => None,
            PictureState::Draft(MOST_REFINED) => Some((Effort::Whole, MOST_REFINED)),
            PictureState::Draft(refined) => {
                let first = (REFINING * self.budget_ms).max(FIRST_AT_REST_MS);
                Some((Effort::Refining(first * REFINING.powi(refined as i32)), refined + 1))
            }
            PictureState::Current | PictureState::Requested(..) => None,
        }
    }

    /// A measurement of the picture at rest, if it is an approximation and has not been measured.
    fn measure(&mut self, now: Instant) -> Option<Task> {
        let serial = self.unmeasured().filter(|_| !self.busy && now >= self.changed_at + STILL)?;
        self.measured = Some(serial);
        Some(Task::Measure(serial))
    }

    fn unmeasured(&self) -> Option<u64> {
        let picture = self.picture.as_deref().filter(|_| self.picture_state == PictureState::Current)?;
        let approximates = matches!(picture.accuracy.exactness, Some(Exactness::Approximation(_)));
        (approximates && self.measured != Some(picture.serial)).then_some(picture.serial)
    }

    /// Returns the time at which to look again, if nothing happens before.
    pub fn due_at(&self, now: Instant) -> Option<Instant> {
        let still_at = self.unmeasured().map(|_| self.changed_at + STILL);
        [Some(self.rest_at()), still_at].into_iter().flatten().find(|at| *at > now)
    }
}
