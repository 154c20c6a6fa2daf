//! The file dialog: chooses files to open, or where to save the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Context, vec2};
use egui_file_dialog::{DialogState, FileDialog};

use pellucid_core::camera::import::is_cameras;
use pellucid_io as io;

/// The user's choice.
pub enum Chosen {
    /// Files to open: at least one.
    Files(Vec<PathBuf>),
    /// Path to which the scene is saved.
    Scene(PathBuf),
}

/// The dialog, while it is open.
#[derive(Default)]
pub struct Dialog(Option<FileDialog>);

impl Dialog {
    /// True while the dialog is open.
    pub fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Asks for files to open.
    pub fn open(&mut self) {
        let readable = |path: &Path| kind(path).is_some();
        let mut dialog = dialog()
            .title("Open a scene, clouds or a camera path")
            .add_file_filter("all supported files", Arc::new(readable));
        for (name, of) in KINDS {
            dialog = dialog.add_file_filter(name, Arc::new(move |path: &Path| kind(path) == Some(of)));
        }
        let mut dialog = dialog.default_file_filter("all supported files").show_new_folder_button(false);
        dialog.pick_multiple();
        self.0 = Some(dialog);
    }

    /// Asks where to save the scene; `name` is the proposal.
    pub fn save(&mut self, name: &str) {
        let dialog = dialog().title("Save the scene as").default_file_name(name);
        let mut dialog = dialog.add_save_extension("scene", "toml").default_save_extension("scene");
        dialog.save_file();
        self.0 = Some(dialog);
    }

    /// Draws the dialog and returns the choice, once.
    pub fn show(&mut self, ctx: &Context) -> Option<Chosen> {
        let dialog = self.0.as_mut()?;
        let room = ctx.content_rect().size() - vec2(80.0, 120.0);
        dialog.config_mut().max_size = Some(room.max(dialog.config_mut().min_size));
        dialog.update(ctx);
        if let DialogState::Open = dialog.state() {
            return None;
        }
        let mut dialog = self.0.take()?;
        let files = dialog.take_picked_multiple().filter(|files| !files.is_empty());
        let files = files.map(|files| Chosen::Files(files.iter().map(|file| from_here(file)).collect()));
        files.or_else(|| dialog.take_picked().map(|file| Chosen::Scene(from_here(&file))))
    }
}

/// Settings shared by both dialogs: neither creates folders nor remembers any.
fn dialog() -> FileDialog {
    let dialog = FileDialog::new().default_size([720.0, 420.0]).anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0]);
    dialog.show_pinned_folders(false).show_system_files_option(false)
}

/// The name of a file as one would type it: relative to the current folder if the file is inside it.
fn from_here(file: &Path) -> PathBuf {
    let here = std::env::current_dir().and_then(|here| here.canonicalize()).unwrap_or_default();
    file.strip_prefix(here).unwrap_or(file).to_owned()
}

/// Kinds of files, by name.
#[derive(Debug, Clone, Copy, PartialEq)]
enum FileKind {
    Scene,
    Cloud,
    Cameras,
}

const KINDS: [(&str, FileKind); 3] = [
    ("scenes (.toml)", FileKind::Scene),
    ("point clouds", FileKind::Cloud),
    ("camera paths (.json)", FileKind::Cameras),
];

/// The kind of a file, judged by its name, if it can be opened.
fn kind(path: &Path) -> Option<FileKind> {
    match path {
        _ if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) => Some(FileKind::Scene),
        _ if is_cameras(path) => Some(FileKind::Cameras),
        _ => io::is_cloud(path).then_some(FileKind::Cloud),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_their_names() {
        for (name, expected) in [
            ("a.toml", Some(FileKind::Scene)),
            ("a.TOML", Some(FileKind::Scene)),
            ("transforms.json", Some(FileKind::Cameras)),
            ("a.copc.laz", Some(FileKind::Cloud)),
            ("a.XYZ", Some(FileKind::Cloud)),
            ("a.e57", Some(FileKind::Cloud)),
            ("a.png", None),
            ("toml", None),
        ] {
            assert_eq!(kind(Path::new(name)), expected, "{name}");
        }
    }

    #[test]
    fn names_are_as_one_would_type_them() {
        let here = std::env::current_dir().unwrap().canonicalize().unwrap();
        assert_eq!(from_here(&here.join("scans/a.ply")), Path::new("scans/a.ply"));
        assert_eq!(from_here(Path::new("/elsewhere/a.ply")), Path::new("/elsewhere/a.ply"));
    }
}
