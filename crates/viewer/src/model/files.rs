//! Files that are opened and saved.

use std::path::{Path, PathBuf};

use super::{Model, Pose, Setting, Task};
use crate::messages::Saving;
use pellucid_core::camera::import;
use pellucid_core::camera::path::CameraPath;
use pellucid_engine::Result;
use pellucid_scene::Document;

/// Files that were saved.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Saved {
    /// Absolute paths of the files, the scene first.
    pub files: Vec<PathBuf>,
    /// The command that makes a film of them, if there is a path among them.
    pub command: Option<String>,
    /// The message about the saved files.
    message: String,
}

impl Saved {
    /// True if a message says no more than this.
    pub fn says(&self, message: &str) -> bool {
        self.message == message
    }
}

impl Model {
    /// Opens other files: a scene or clouds instead of what is shown, and cameras as the keys of the path.
    pub fn open(&mut self, files: Vec<PathBuf>) {
        let names: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        let (cameras, files): (Vec<_>, Vec<_>) = files.into_iter().partition(|file| import::is_cameras(file));
        if cameras.len() > 1 {
            return self.show_error("only one camera path can be open: give one file of cameras");
        }
        self.show_note(format!("reading {}", names.join(", ")));
        if !files.is_empty() {
            self.ask_for(Task::Open(files));
        }
        cameras.into_iter().for_each(|file| self.ask_for(Task::Cameras(file)));
    }

    /// Takes away the names of the files that were saved last, also where the message still says them.
    pub fn dismiss_saved(&mut self) {
        if let Some(saved) = self.saved.take() {
            self.message.take_if(|(text, _)| saved.says(text));
        }
    }

    /// Asks for files to be read or written.
    pub(super) fn ask_for(&mut self, task: Task) {
        self.pending.push_back(matches!(task, Task::Open(_)));
        self.busy = true;
        self.tasks.push_back(task);
    }

    /// The first files that were asked for are read or written, or can't be.
    pub(super) fn take_answer(&mut self) {
        self.pending.pop_front();
        self.busy = !self.pending.is_empty();
    }

    /// The stem of the names of saved files.
    fn stem(&self) -> String {
        // Either one file, whose name may contain spaces, or the first of several.
        let whole = PathBuf::from(&self.name);
        let first = if whole.exists() { whole } else { PathBuf::from(self.name.split(' ').next().unwrap_or_default()) };
        first.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Writes the scene as shown, with or without its picture, once the camera is known.
    pub fn save(&mut self, picture: bool) {
        self.save_to(picture, None);
    }

    /// Saves like [`Model::save`], to a file of this name.
    pub fn save_to(&mut self, picture: bool, to: Option<PathBuf>) {
        if self.navigator.is_none() || self.viewport.size.contains(&0) {
            return self.show_note("no picture yet to save");
        }
        self.ask_to_save(self.document_as_shown(), picture, None, to);
    }

    /// Asks for a scene to be written, unless another one is being opened: its clouds are not the current ones.
    pub(super) fn ask_to_save(
        &mut self,
        document: Result<Document>,
        picture: bool,
        path: Option<CameraPath>,
        to: Option<PathBuf>,
    ) {
        if self.pending.contains(&true) {
            return self.show_error("not saved: another scene is being read");
        }
        match document {
            Ok(document) => {
                let saving = Saving { document, stem: self.stem(), picture, path, to };
                self.ask_for(Task::Save(Box::new(saving)));
            }
            Err(error) => self.show_error(error.to_string()),
        }
    }

    /// The scene with the size of the picture.
    pub(super) fn document_of_size(&self) -> Result<Document> {
        let mut document = self.document.clone();
        document.put("image.size", Setting::Integers(self.viewport.size.to_vec()))?;
        Ok(document)
    }

    /// The scene with the camera and the size of the picture.
    ///
    /// # Errors
    /// A camera that is no setting of a scene.
    pub fn document_as_shown(&self) -> Result<Document> {
        let mut document = self.document_of_size()?;
        let shown = match (self.pose, &self.navigator) {
            (Pose::Scene, _) | (Pose::View(_), None) => None,
            (Pose::View(_), Some(navigator)) => Some(navigator.settings(self.scene.camera.near, self.scene.camera.far)),
            (Pose::At(camera), _) => Some(camera),
        };
        if let Some(camera) = shown {
            ["fov_y", "height", "ortho"].iter().for_each(|key| document.remove("camera", key));
            // A key of a path may have depths of its own.
            for key in camera.keys().into_iter().filter(|key| key.name != "ortho") {
                if let Some(value) = key.value {
                    document.put(&format!("camera.{}", key.name), value)?;
                }
            }
        }
        Ok(document)
    }

    /// Asks for a file for the scene.
    pub fn ask_where_to_save(&mut self) {
        self.dialog.save(&format!("{}.toml", self.stem()));
    }

    /// Writes the scene to a file that was chosen; a name without an end gets that of scenes, and then nothing is
    /// written over.
    pub fn save_as(&mut self, file: PathBuf) {
        if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            return self.save_to(false, Some(file));
        }
        let mut named = file.into_os_string();
        named.push(".toml");
        let named = PathBuf::from(named);
        if named.exists() {
            self.show_error(format!("{} exists; enter its full name to replace it", named.display()));
        } else {
            self.save_to(false, Some(named));
        }
    }

    /// Lists the files that were written, with the command that makes a film of a path.
    pub(super) fn note_saved(&mut self, files: &[PathBuf]) {
        let names: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
        let path = files.iter().find(|file| file.extension().is_some_and(|e| e == "json"));
        let command = path.zip(files.first()).map(|(path, scene)| {
            let frames = path.with_extension("");
            let (scene, path) = (word(scene), word(path));
            let frames = word(Path::new(&format!("{}_%04d.png", frames.display())));
            format!("pellucid render {scene} --path {path} --frames {} -o {frames}", self.route.frames())
        });
        let mut message = format!("saved {}", names.join(" and "));
        if let Some(command) = &command {
            message = format!("{message}; {command}");
        }
        let whole = |file: &PathBuf| std::path::absolute(file).unwrap_or_else(|_| file.clone());
        self.saved = Some(Saved { files: files.iter().map(whole).collect(), command, message: message.clone() });
        self.show_note(message);
    }
}

/// A path as a shell takes it.
fn word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+%".contains(c);
    if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}
