//! Point clouds and the settings for rendering them.

use std::path::{Path, PathBuf};

use pellucid_engine::cloud::Cloud as Columns;
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::{self as engine, Document, Overrides, Setting};

use crate::{Cloud, Result};

/// Point clouds and the settings for rendering them.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(crate) clouds: Vec<Columns>,
    pub(crate) document: Document,
    pub(crate) seed: u64,
}

impl Scene {
    /// Reads a scene file (`.toml`) and its clouds, or a single cloud.
    ///
    /// # Errors
    /// Returns an error with line and column if something is wrong with the file, or if a cloud can't be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let opened = engine::open(&[path.as_ref().to_owned()], &Overrides::default(), 0, &Progress::hidden())?;
        Ok(Self { clouds: opened.clouds, document: opened.document, seed: 0 })
    }

    /// Creates a scene of clouds with default settings.
    ///
    /// # Errors
    /// Returns an error if there is no cloud.
    pub fn from_clouds(clouds: impl IntoIterator<Item = Cloud>) -> Result<Self> {
        let clouds: Vec<Cloud> = clouds.into_iter().collect();
        let names = (0..clouds.len()).map(|i| PathBuf::from(format!("cloud-{i}")));
        let mut document = Document::from_clouds(names, &Overrides::default())?;
        for (i, opacity) in clouds.iter().enumerate().filter_map(|(i, cloud)| Some((i, cloud.opacity?))) {
            document.set(&format!("cloud.{i}.opacity"), Setting::Number(f64::from(opacity)))?;
        }
        Ok(Self { clouds: clouds.into_iter().map(|cloud| cloud.columns).collect(), document, seed: 0 })
    }

    /// Sets the value of a setting, by its name in a scene file, such as `method.samples` or `cloud.0.opacity`.
    ///
    /// # Errors
    /// Returns an error for a name or a value that is not possible in a scene file. The scene is then unchanged.
    pub fn set(&mut self, key: &str, value: impl Into<Setting>) -> Result<&mut Self> {
        self.document.set(key, value.into())?;
        Ok(self)
    }

    /// Sets the seed of stochastic methods, 0 by default.
    pub fn set_seed(&mut self, seed: u64) -> &mut Self {
        self.seed = seed;
        self
    }

    /// Returns the settings as the text of a scene file. Clouds made from arrays have names in place of files.
    ///
    /// # Errors
    /// Returns an error if the working directory can't be found.
    pub fn to_toml(&self) -> Result<String> {
        Ok(self.document.to_toml(Path::new("."))?)
    }
}
