//! From the inputs of a command to a scene and its clouds.

use std::path::{Path, PathBuf};

use crate::progress::{Phase, Progress};

use super::document::Document;
use super::{Error, Overrides, load_clouds, procedural, take_generated};
use crate::cloud::Cloud;

/// The built-in scene used without input.
pub const DEFAULT_SCENE: &str = "garden";

/// A scene and its clouds as they were read.
#[derive(Debug, Clone)]
pub struct Opened {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The clouds of the scene, in its order.
    pub clouds: Vec<Cloud>,
    /// True if the clouds were generated, so that no file contains them.
    pub generated: bool,
}

/// Reads one scene file, or point clouds; without any input generates the built-in scene by `seed`. Options override
/// it.
///
/// # Errors
/// A scene file among other inputs, an invalid scene, and unreadable files.
pub fn open(inputs: &[PathBuf], overrides: &Overrides, seed: u64, progress: &Progress) -> crate::Result<Opened> {
    progress.begin(Phase::Read);
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let document = match inputs {
        [] => {
            let generated = procedural::build(DEFAULT_SCENE, &[], seed).map_err(Error::from)?;
            let document = Document::from_toml(&generated.scene_toml, Path::new(DEFAULT_SCENE), overrides)?;
            let clouds = take_generated(&document.scene()?, &generated)?;
            return Ok(Opened { name: DEFAULT_SCENE.to_owned(), document, clouds, generated: true });
        }
        [path] if is_scene(path) => Document::read(path, overrides)?,
        inputs if inputs.iter().any(is_scene) => {
            let problem = "a scene file (.toml) comes alone: give either one scene file or point clouds";
            return Err(Error::Usage(problem.into()).into());
        }
        inputs => Document::from_clouds(inputs, overrides)?,
    };
    let clouds = load_clouds(&document.scene()?, progress)?;
    let names: Vec<_> = inputs.iter().map(|input| input.display().to_string()).collect();
    Ok(Opened { name: names.join(" "), document, clouds, generated: false })
}
