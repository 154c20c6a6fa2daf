//! From the inputs of a command to a scene and its clouds.

use std::path::{Path, PathBuf};

use pellucid_core::progress::{Phase, Progress};

use super::document::Document;
use super::procedural::Generated;
use super::{Error, Overrides, load_clouds, procedural, take_generated};
use pellucid_core::cloud::Cloud;
use pellucid_core::cloud::gaussians::Gaussians;
use pellucid_io::store;

/// The built-in scene used without input.
pub const DEFAULT_SCENE: &str = "garden";

/// Bytes of memory for each point of a cloud that is read as a whole, at the most that are taken at once.
const BYTES_OF_POINT: u64 = 90;

/// A scene and its clouds as they were read.
#[derive(Debug, Clone)]
pub struct Opened {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The clouds of the scene, in its order.
    pub clouds: Vec<Cloud>,
    /// `true` if the clouds were generated, so that no file contains them.
    pub generated: bool,
}

/// A scene, and where its clouds are.
#[derive(Debug, Clone)]
pub struct Named {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The clouds of the built-in scene, which no file contains.
    generated: Option<Generated>,
}

impl Named {
    /// Returns a scene of that name, whose clouds are the files that it names.
    pub fn of_files(name: String, document: Document) -> Self {
        Self { name, document, generated: None }
    }

    /// Reads the clouds.
    ///
    /// # Errors
    /// Files that can't be read.
    pub fn load(self, progress: &Progress) -> Result<Opened, crate::OpenError> {
        let scene = self.document.scene()?;
        let clouds = match &self.generated {
            Some(generated) => take_generated(&scene, generated)?,
            None => load_clouds(&scene, progress)?,
        };
        Ok(Opened { name: self.name, document: self.document, clouds, generated: self.generated.is_some() })
    }

    /// Returns bytes of memory for all points that the clouds announce, as far as their files say how many they have;
    /// `None` of the built-in scene.
    ///
    /// # Errors
    /// Files that can't be opened.
    pub fn needed_memory(&self) -> Result<Option<u64>, crate::OpenError> {
        if self.generated.is_some() {
            return Ok(None);
        }
        let scene = self.document.scene()?;
        let mut all = 0_u64;
        for cloud in &scene.clouds {
            let (points, degree) = store::announced(&cloud.path, &cloud.hints())?.unwrap_or_default();
            // Splats are in the columns of the file and in those of the scene at once.
            let bytes = BYTES_OF_POINT + degree.map_or(0, |degree| 2 * Gaussians::bytes_each(degree));
            all = all.saturating_add(points.saturating_mul(bytes));
        }
        Ok(Some(all))
    }
}

/// Reads one scene file, or point clouds; without any input generates the built-in scene by `seed`. Options override
/// it.
///
/// # Errors
/// A scene file among other inputs, an invalid scene, and unreadable files.
pub fn open(
    inputs: &[PathBuf],
    overrides: &Overrides,
    seed: u64,
    progress: &Progress,
) -> Result<Opened, crate::OpenError> {
    progress.begin(Phase::Read);
    name(inputs, overrides, seed)?.load(progress)
}

/// Like [`open`], but reads no clouds.
///
/// # Errors
/// A scene file among other inputs, and an invalid scene.
pub fn name(inputs: &[PathBuf], overrides: &Overrides, seed: u64) -> Result<Named, crate::OpenError> {
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let document = match inputs {
        [] => {
            let generated = procedural::build(DEFAULT_SCENE, &[], seed).map_err(Error::from)?;
            let document = Document::from_toml(&generated.scene_toml, Path::new(DEFAULT_SCENE), overrides)?;
            return Ok(Named { name: DEFAULT_SCENE.to_owned(), document, generated: Some(generated) });
        }
        [path] if is_scene(path) => Document::read(path, overrides)?,
        inputs if inputs.iter().any(is_scene) => {
            let problem = "a scene file (.toml) can't be combined with other inputs: give either one scene file or point \
                 clouds";
            return Err(Error::Usage(problem.into()).into());
        }
        inputs => Document::from_clouds(inputs, overrides)?,
    };
    let names: Vec<_> = inputs.iter().map(|input| input.display().to_string()).collect();
    Ok(Named { name: names.join(" "), document, generated: None })
}
