//! Queries and edits of the scene for the panel.

use std::sync::Arc;

use super::Model;
use crate::controls::ControlExtent;
use crate::statistics::Statistics;
use pellucid_scene::{Change, Error, Scene, Setting, method_keys};

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

    /// Sets a key of the scene file, or removes it; a value the scene rejects becomes a message.
    pub fn set(&mut self, key: &str, value: impl Into<Option<Setting>>) {
        self.change(&[(key.to_owned(), value.into())]);
    }

    /// Sets or removes keys of the scene file, all at once; changes the scene rejects become a message.
    pub fn change(&mut self, changes: &[Change]) {
        let changed = self.document.change(changes);
        self.follow(changed);
    }

    /// Switches the method. Keys shared with the previous method stay, except for values the new one doesn't allow.
    pub fn set_method(&mut self, name: &str) {
        let set = ("method.name".to_owned(), Some(Setting::Word(name.to_owned())));
        let out = |key: &&str| (format!("method.{key}"), None);
        let keys = method_keys(name);
        let each = keys.iter().map(|key| vec![out(key), set.clone()]);
        let attempts = std::iter::once(vec![set.clone()]).chain(each);
        let attempts = attempts.chain([keys.iter().map(out).chain([set.clone()]).collect()]);
        let mut changed = Ok(Scene::clone(&self.scene));
        for edits in attempts {
            changed = self.document.change(&edits);
            if changed.is_ok() {
                break;
            }
        }
        self.follow(changed);
    }

    /// Shows the changed document, or the reason why the change failed.
    fn follow(&mut self, changed: Result<Scene, Error>) {
        match changed {
            Ok(scene) => {
                self.message = None;
                self.scene = Arc::new(scene);
                self.touch();
            }
            Err(error) => self.show_error(error.to_string()),
        }
    }
}
