//! Opens a scene and its clouds from the inputs of a command.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pellucid_core::progress::{Phase, Progress};

use super::document::Document;
use super::procedural::Generated;
use super::{Error, OpenError, Overrides, Scene, load_clouds, procedural, take_generated};
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

/// Where the clouds of a scene are. Clones share what is in memory.
#[derive(Debug, Clone)]
pub enum Input {
    /// Clouds in the files that the scene names.
    Files,
    /// Generated clouds in memory, by their names in a built-in scene.
    Generated(Arc<Generated>),
    /// Clouds in memory, in the scene's order.
    Clouds(Arc<[Arc<Cloud>]>),
}

impl Input {
    /// Returns the clouds of a scene, in its order; those in files are read.
    ///
    /// # Errors
    /// Returns an error if a file can't be read, or if a generated cloud has another name.
    pub fn load(&self, scene: &Scene, progress: &Progress) -> Result<Vec<Arc<Cloud>>, OpenError> {
        match self {
            Self::Files => Ok(load_clouds(scene, progress)?.into_iter().map(Arc::new).collect()),
            Self::Generated(generated) => Ok(take_generated(scene, generated)?.into_iter().map(Arc::new).collect()),
            Self::Clouds(clouds) => Ok(clouds.to_vec()),
        }
    }

    /// Returns the bytes of memory that all points of a scene take, as far as its files say how many they have; `None`
    /// for clouds that are in memory already.
    ///
    /// # Errors
    /// Returns an error if a file can't be opened.
    pub fn needed_memory(&self, scene: &Scene) -> Result<Option<u64>, OpenError> {
        if !matches!(self, Self::Files) {
            return Ok(None);
        }
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

/// A scene, and where its clouds are.
#[derive(Debug, Clone)]
pub struct Named {
    /// The inputs as they were named.
    pub name: String,
    /// The keys of the scene.
    pub document: Document,
    /// The place of the clouds.
    pub input: Input,
}

impl Named {
    /// Returns a scene of that name, whose clouds are the files that it names.
    pub fn of_files(name: String, document: Document) -> Self {
        Self { name, document, input: Input::Files }
    }

    /// Returns `true` if the clouds were generated, so that no file contains them.
    pub fn is_generated(&self) -> bool {
        matches!(self.input, Input::Generated(_))
    }

    /// Reads the clouds.
    ///
    /// # Errors
    /// Returns an error if a file can't be read.
    fn load(self, progress: &Progress) -> Result<Opened, OpenError> {
        let scene = self.document.scene()?;
        let clouds = self.input.load(&scene, progress)?.into_iter().map(Arc::unwrap_or_clone).collect();
        Ok(Opened { generated: self.is_generated(), name: self.name, document: self.document, clouds })
    }
}

/// Reads one scene file, or point clouds; without any input generates the built-in scene by `seed`. Options override
/// it.
///
/// # Errors
/// A scene file among other inputs, an invalid scene, and unreadable files.
pub fn open(inputs: &[PathBuf], overrides: &Overrides, seed: u64, progress: &Progress) -> Result<Opened, OpenError> {
    progress.begin(Phase::Read);
    name(inputs, overrides, seed)?.load(progress)
}

/// Like [`open`], but reads no clouds.
///
/// # Errors
/// A scene file among other inputs, and an invalid scene.
pub fn name(inputs: &[PathBuf], overrides: &Overrides, seed: u64) -> Result<Named, OpenError> {
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let document = match inputs {
        [] => {
            let generated = procedural::build(DEFAULT_SCENE, &[], seed).map_err(Error::from)?;
            let document = Document::from_toml(&generated.scene_toml, Path::new(DEFAULT_SCENE), overrides)?;
            return Ok(Named {
                name: DEFAULT_SCENE.to_owned(),
                document,
                input: Input::Generated(Arc::new(generated)),
            });
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
    Ok(Named::of_files(names.join(" "), document))
}
