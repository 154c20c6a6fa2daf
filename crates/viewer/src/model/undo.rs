//! Steps of the scene and of the path that are undone and done again.

use std::sync::Arc;

use super::Model;
use crate::history::Before;
use crate::route::Route;
use pellucid_scene::Document;

impl Model {
    /// Ends the step of changes so far: the next change is another one. Until then, changes of the same key are one.
    pub fn end_step(&mut self) {
        self.history.close();
    }

    /// Takes the last step of the scene or the path back. The camera stays where it is.
    pub fn undo(&mut self) {
        self.travel(true, "nothing to undo");
    }

    /// Does the step again that was undone last.
    pub fn redo(&mut self) {
        self.travel(false, "nothing to redo");
    }

    fn travel(&mut self, back: bool, without: &str) {
        match self.history.take(back) {
            None => self.show_note(without),
            Some(Before::Scene(document)) => self.return_to(document, back),
            Some(Before::Path(mut route)) => {
                std::mem::swap(&mut self.route, &mut route);
                self.message = None;
                self.history.keep(back, Before::Path(Box::new(route.at_rest())));
            }
        }
    }

    /// Returns to another state of the scene. It was valid once, but a file that it names may be gone.
    fn return_to(&mut self, document: Document, back: bool) {
        match document.scene() {
            Ok(scene) => {
                let replaced = std::mem::replace(&mut self.document, document);
                self.history.keep(back, Before::Scene(replaced));
                self.scene = Arc::new(scene);
                self.message = None;
                self.touch();
            }
            Err(error) => {
                self.history.keep(!back, Before::Scene(document));
                self.show_error(error.to_string());
            }
        }
    }

    /// Records that the last change of the scene, of the key `subject`, began from this document.
    pub(super) fn record_scene(&mut self, subject: &str, before: Document) {
        if self.document.differs(&before, "") {
            self.history.record(subject, Before::Scene(before));
        }
    }

    /// Changes the path in a way that needs no look at the scene.
    pub fn edit_route(&mut self, edit: impl FnOnce(&mut Route)) {
        let before = self.route.at_rest();
        edit(&mut self.route);
        self.record_route(before);
    }

    /// Records that the last change of the path began from this one.
    pub(super) fn record_route(&mut self, before: Route) {
        if self.route.differs(&before) {
            self.history.record("path", Before::Path(Box::new(before)));
        }
    }
}
