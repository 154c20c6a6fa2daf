//! What the panel asks of the scene and does to it.

use std::sync::Arc;

use super::Model;
use crate::census::Census;
use crate::controls::Extent;
use pellucid_engine::scene::{Change, Error, Scene, Setting, method_keys};

impl Model {
    /// What is known of the clouds, in the scene's order; nothing as long as nobody has looked.
    pub fn census(&self) -> Arc<[Census]> {
        self.census.clone()
    }

    /// How large the scene of the last picture is, and its soft points.
    pub fn extent(&self) -> Extent {
        let Some(picture) = &self.picture else { return Extent::default() };
        let diagonal = Some(picture.subject.bounds.diagonal()).filter(|diagonal| *diagonal > 0.0);
        let median_radius = picture.field.as_ref().map_or(0.0, |field| field.parts.median_radius);
        Extent { diagonal: diagonal.unwrap_or(1.0), median_radius }
    }

    /// Whether a key of the scene file is given; of `cloud.*` whether any cloud has it.
    pub fn is_given(&self, key: &str) -> bool {
        self.document.has(key)
    }

    /// Gives a key of the scene file a value; what the scene doesn't allow is said.
    pub fn set(&mut self, key: &str, value: Setting) {
        self.change(&[(key.to_owned(), Some(value))]);
    }

    /// Gives keys of the scene file values, or takes them out, all at once; what the scene doesn't allow is said.
    pub fn change(&mut self, changes: &[Change]) {
        let changed = self.document.change(changes);
        self.follow(changed);
    }

    /// Another method. The keys that it shares with the one before stay, but for values that are none of its own.
    pub fn set_method(&mut self, name: &str) {
        let set = ("method.name".to_owned(), Some(Setting::Word(name.to_owned())));
        let out = |key: &&str| (format!("method.{key}"), None);
        let keys = method_keys(name);
        let each = keys.iter().map(|key| vec![out(key), set.clone()]);
        let ways = std::iter::once(vec![set.clone()]).chain(each);
        let ways = ways.chain([keys.iter().map(out).chain([set.clone()]).collect()]);
        let mut changed = Ok(Scene::clone(&self.scene));
        for way in ways {
            changed = self.document.change(&way);
            if changed.is_ok() {
                break;
            }
        }
        self.follow(changed);
    }

    /// Shows what the document has become, or says why it hasn't.
    fn follow(&mut self, changed: Result<Scene, Error>) {
        match changed {
            Ok(scene) => {
                self.message = None;
                self.scene = Arc::new(scene);
                self.touch();
            }
            Err(error) => self.message = Some((error.to_string(), true)),
        }
    }
}
