//! Results so far, kept in the report's folder until the report is written, so that an interrupted run can be resumed.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::causes::area::AreaErrors;
use super::{Cause, Reference, Row, Shaded};
use pellucid_core::atomic::Staged;
use pellucid_io::output;

const NAME: &str = "tradeoff.partial.json";

/// A frame that was timed among those of the other settings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Timed {
    /// The run of the command, counted from 1.
    pub sitting: u32,
    pub gpu_ms: f64,
    pub wall_ms: f64,
    pub passes: Vec<(String, f64)>,
}

/// Results of a setting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SettingResults {
    /// Results of the first frames: all but times and the front.
    pub row: Row,
    /// Host time of a frame whose buffers and shaders were ready.
    pub seconds: f64,
    pub frames: Vec<Timed>,
}

/// Results of a scene, as the file holds them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Content {
    /// Identifies the scene, the device and the program, see [`pellucid_engine::identity`].
    pub identity: String,
    /// Runs of the command so far.
    pub sittings: u32,
    pub reference: Option<Reference>,
    pub shaded: Option<Shaded>,
    /// Causes of the error of Gaussian splats.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// The error of looking at points of pixels.
    #[serde(default)]
    pub area: Option<AreaErrors>,
    /// Keyed by [`pellucid_session::candidates::Setting::key`].
    pub settings: BTreeMap<String, SettingResults>,
}

/// The file and what it holds.
pub(super) struct Partial {
    folder: PathBuf,
    pub content: Content,
}

impl Partial {
    /// The results of an earlier run with the same identity, or none.
    pub fn open(folder: &Path, identity: String) -> Self {
        // This is a cache: unreadable content counts as absent.
        let read = || -> Option<Content> {
            let content: Content = serde_json::from_slice(&std::fs::read(folder.join(NAME)).ok()?).ok()?;
            (content.identity == identity).then_some(content)
        };
        let mut content = read().unwrap_or(Content { identity: identity.clone(), ..Content::default() });
        // Pictures may have been cleared away.
        content.settings.retain(|_, measured| {
            [&measured.row.picture, &measured.row.difference].iter().all(|name| folder.join(name).is_file())
        });
        content.sittings += 1;
        Self { folder: folder.to_owned(), content }
    }

    /// Saves the results; called after every frame, so that it doesn't wait for the disk.
    pub fn save(&self) -> Result<(), output::Error> {
        let path = self.folder.join(NAME);
        let staged = Staged::write_quickly(&path, |file| {
            serde_json::to_writer(&mut *file, &self.content)?;
            writeln!(file)
        });
        let written = staged.and_then(|staged| staged.publish(&path));
        written.map_err(|source| output::Error::Write { path, source })
    }
}

/// Removes the stored results once the report contains them.
///
/// # Errors
/// The file exists and can't be removed.
pub fn discard(folder: &Path) -> Result<(), output::Error> {
    let path = folder.join(NAME);
    match std::fs::remove_file(&path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(output::Error::Write { path, source }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_belongs_to_the_same_scene_is_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut partial = Partial::open(folder.path(), "a".to_owned());
        let measured = |picture: &str| SettingResults {
            row: Row { picture: picture.to_owned(), difference: picture.to_owned(), ..Row::default() },
            seconds: 0.25,
            frames: Vec::new(),
        };
        std::fs::write(folder.path().join("there.png"), "").unwrap();
        for (key, picture) in [("kept", "there.png"), ("lost", "gone.png")] {
            partial.content.settings.insert(key.to_owned(), measured(picture));
        }
        partial.save().unwrap();
        let again = Partial::open(folder.path(), "a".to_owned());
        assert_eq!(again.content.sittings, 2);
        assert_eq!(again.content.settings.keys().collect::<Vec<_>>(), ["kept"]);
        assert!(Partial::open(folder.path(), "b".to_owned()).content.settings.is_empty(), "another scene");
        std::fs::write(folder.path().join(NAME), "{").unwrap();
        assert!(Partial::open(folder.path(), "a".to_owned()).content.settings.is_empty(), "cut short");
        discard(folder.path()).unwrap();
        discard(folder.path()).unwrap();
        assert!(!folder.path().join(NAME).exists());
    }
}
