//! Queries and edits of the scene for the panel.

use std::sync::Arc;

use super::Model;
use crate::controls::{self, ControlExtent};
use crate::statistics::Statistics;
use pellucid_scene::{Change, Document, Error, Scene, Setting, method_keys};

impl Model {
    /// Statistics of the clouds, in the scene's order; empty until they are gathered.
    pub fn statistics(&self) -> Arc<[Statistics]> {
        self.statistics.clone()
    }

    /// The extent of the last picture's scene and its soft points.
    pub fn extent(&self) -> ControlExtent {
        let Some(picture) = &self.picture else { return ControlExtent::default() };
        let diagonal = Some(picture.subject.bounds.diagonal()).filter(|diagonal| *diagonal > 0.0);
        let median_radius = picture.field.as_ref().map_or(0.0, |field| field.parts.median_radius);
        ControlExtent { diagonal: diagonal.unwrap_or(1.0), median_radius }
    }

    /// True if a key of the scene file is given; for `cloud.*`, if any cloud has it.
    pub fn is_given(&self, key: &str) -> bool {
        self.document.has(key)
    }

    /// True if a key of the scene file has another value than in the scene that was opened. For keys of `[method]`, if
    /// that scene has another method, true if the key is given.
    pub fn is_changed(&self, key: &str) -> bool {
        if self.is_of_another_method(key) { self.document.has(key) } else { self.document.differs(&self.opened.0, key) }
    }

    fn is_of_another_method(&self, key: &str) -> bool {
        key.starts_with("method.") && self.opened.1.method.name() != self.scene.method.name()
    }

    /// True if the scene that was opened gives a key.
    pub fn opened_has(&self, key: &str) -> bool {
        !self.is_of_another_method(key) && self.opened.0.has(key)
    }

    /// The scene as it was opened.
    pub fn opened_scene(&self) -> &Scene {
        &self.opened.1
    }

    /// Gives keys the values of the scene that was opened, all at once.
    pub fn reset(&mut self, keys: &[impl AsRef<str>]) {
        let changed = self.try_reset(keys);
        self.follow(keys.last().map_or("", AsRef::as_ref), changed);
    }

    /// Gives a key of the method its value in the scene that was opened; if another key excludes that value, that one,
    /// too.
    pub fn reset_method(&mut self, key: &str) {
        let dotted = |key: &str| format!("method.{key}");
        let mut changed = self.try_reset(&[dotted(key)]);
        if let (Err(_), Some(other)) = (&changed, controls::rival(key)) {
            changed = self.try_reset(&[dotted(key), dotted(other)]);
        }
        self.follow(&dotted(key), changed);
    }

    fn try_reset(&self, keys: &[impl AsRef<str>]) -> Result<(Document, Scene), Error> {
        let mut document = self.document.clone();
        for key in keys.iter().map(AsRef::as_ref) {
            match key.rsplit_once('.').filter(|_| self.is_of_another_method(key)) {
                Some((table, key)) => document.remove(table, key),
                None => document.restore(&self.opened.0, key),
            }
        }
        let scene = document.scene()?;
        Ok((document, scene))
    }

    /// Sets a key of the scene file, or removes it; a value the scene rejects becomes a message.
    pub fn set(&mut self, key: &str, value: impl Into<Option<Setting>>) {
        self.change(&[(key.to_owned(), value.into())]);
    }

    /// Sets or removes keys of the scene file, all at once; changes the scene rejects become a message. For undo, the
    /// last one is the subject.
    pub fn change(&mut self, changes: &[Change]) {
        let changed = self.try_change(changes);
        self.follow(changes.last().map_or("", |(key, _)| key), changed);
    }

    fn try_change(&self, changes: &[Change]) -> Result<(Document, Scene), Error> {
        let mut document = self.document.clone();
        let scene = document.change(changes)?;
        Ok((document, scene))
    }

    /// Gives all clouds a mean opacity; the ratios of opacities stay, those of classes included.
    pub fn set_mean_opacity(&mut self, mean: f64) {
        let changes = self.ratios.changes(&self.scene.clouds, mean);
        self.change(&changes);
    }

    /// Switches the method. Keys shared with the previous method stay, except for values the new one doesn't allow.
    pub fn set_method(&mut self, name: &str) {
        let set = ("method.name".to_owned(), Some(Setting::Word(name.to_owned())));
        let out = |key: &&str| (format!("method.{key}"), None);
        let keys = method_keys(name);
        let each = keys.iter().map(|key| vec![out(key), set.clone()]);
        let attempts = std::iter::once(vec![set.clone()]).chain(each);
        let attempts = attempts.chain([keys.iter().map(out).chain([set.clone()]).collect()]);
        let mut changed = self.try_change(&[]);
        for edits in attempts {
            changed = self.try_change(&edits);
            if changed.is_ok() {
                break;
            }
        }
        self.follow("method.name", changed);
    }

    /// Shows the document after a change of `subject`, or the reason why the change failed.
    fn follow(&mut self, subject: &str, changed: Result<(Document, Scene), Error>) {
        match changed {
            Ok((document, scene)) => {
                self.message = None;
                let before = std::mem::replace(&mut self.document, document);
                self.record_scene(subject, before);
                self.scene = Arc::new(scene);
                self.touch();
            }
            Err(error) => self.show_error(error.to_string()),
        }
    }
}
