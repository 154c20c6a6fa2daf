//! Undo and redo: what the scene and the path were before each step.

use std::collections::VecDeque;

use super::route::Route;
use pellucid_scene::Document;

/// Most steps that are kept.
const MOST: usize = 200;

/// Most values that all steps together hold, some 100 bytes each. A scene of thousands of clouds has fewer steps.
const ROOM: usize = 200_000;

/// Values of a key frame.
const OF_A_KEY: usize = 16;

/// A state that a step replaced.
#[derive(Debug, Clone)]
pub enum Before {
    /// The scene.
    Scene(Document),
    /// The path of key frames.
    Path(Box<Route>),
}

impl Before {
    /// The values that it holds.
    fn values(&self) -> usize {
        match self {
            Self::Scene(document) => document.nodes(),
            Self::Path(route) => OF_A_KEY * route.keys().len(),
        }
    }
}

/// The steps that can be undone, and those that were undone.
#[derive(Debug, Default)]
pub struct History {
    past: VecDeque<Before>,
    future: Vec<Before>,
    /// The subject of the last step, while further changes of it belong to the same step.
    open: Option<String>,
}

impl History {
    /// Records that `subject` is about to change, by what was there before. Changes of one subject are one step until
    /// [`History::close`].
    pub fn record(&mut self, subject: &str, before: Before) {
        self.future.clear();
        if self.open.as_deref() == Some(subject) && !self.past.is_empty() {
            return;
        }
        self.open = Some(subject.to_owned());
        self.past.push_back(before);
        let mut values: usize = self.past.iter().map(Before::values).sum();
        while self.past.len() > MOST || values > ROOM && self.past.len() > 1 {
            values -= self.past.pop_front().map_or(0, |oldest| oldest.values());
        }
    }

    /// Ends the step: the next change begins another one.
    pub fn close(&mut self) {
        self.open = None;
    }

    /// Takes the last step out, or with `back` false the one that was undone last.
    pub fn take(&mut self, back: bool) -> Option<Before> {
        self.close();
        if back { self.past.pop_back() } else { self.future.pop() }
    }

    /// Keeps what a step that was taken has replaced in turn, so that the other direction leads there.
    pub fn keep(&mut self, back: bool, replaced: Before) {
        if back {
            self.future.push(replaced);
        } else {
            self.past.push_back(replaced);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_scene::{Overrides, Setting};

    fn document(opacity: u32) -> Document {
        let mut document = Document::from_clouds(["a.ply"], &Overrides::default()).unwrap();
        document.put("cloud.0.neighbors", Setting::Integer(opacity)).unwrap();
        document
    }

    fn neighbors(step: Option<Before>) -> Option<usize> {
        match step? {
            Before::Scene(document) => document.scene().unwrap().clouds[0].neighbors,
            Before::Path(_) => None,
        }
    }

    #[test]
    fn memory_is_bounded() {
        let mut history = History::default();
        for i in 1..=2 * MOST as u32 {
            history.close();
            history.record("a", Before::Scene(document(i)));
        }
        assert_eq!(history.past.len(), MOST);
        assert_eq!(neighbors(history.past.front().cloned()), Some(MOST + 1));
        // Scenes of very many clouds: few steps, but the last one always.
        let many = (0..ROOM / 8).map(|i| format!("{i}.ply"));
        let large = Document::from_clouds(many, &Overrides::default()).unwrap();
        for _ in 0..5 {
            history.close();
            history.record("a", Before::Scene(large.clone()));
        }
        let held: usize = history.past.iter().map(Before::values).sum();
        assert!(held <= ROOM && history.past.len() == 3, "{held} in {}", history.past.len());
        let huge = Document::from_clouds((0..ROOM).map(|i| format!("{i}.ply")), &Overrides::default()).unwrap();
        history.close();
        history.record("a", Before::Scene(huge));
        assert_eq!(history.past.len(), 1);
    }

    #[test]
    fn changes_of_one_thing_are_a_step_until_it_is_closed() {
        let mut history = History::default();
        for (subject, i) in [("a", 1), ("a", 2), ("b", 3), ("b", 4), ("a", 5)] {
            history.record(subject, Before::Scene(document(i)));
        }
        history.close();
        history.record("a", Before::Scene(document(6)));
        let all: Vec<_> = std::iter::from_fn(|| neighbors(history.take(true))).collect();
        assert_eq!(all, [6, 5, 3, 1]);
    }
}
