//! Clouds and settings.

use std::path::{Path, PathBuf};

use pellucid_engine::cloud::Cloud as Columns;
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::{self as engine, Document, Overrides, Setting};

use crate::{Cloud, Result};

/// Clouds, and the settings by which they are rendered.
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
    /// Whatever is wrong with the file, with line and column, and clouds that can't be read.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let opened = engine::open(&[path.as_ref().to_owned()], &Overrides::default(), 0, &Progress::hidden())?;
        Ok(Self { clouds: opened.clouds, document: opened.document, seed: 0 })
    }

    /// A scene of some clouds with default settings.
    ///
    /// # Errors
    /// No cloud at all.
    pub fn from_clouds(clouds: impl IntoIterator<Item = Cloud>) -> Result<Self> {
        let clouds: Vec<Cloud> = clouds.into_iter().collect();
        let names = (0..clouds.len()).map(|i| PathBuf::from(format!("cloud-{i}")));
        let mut document = Document::from_clouds(names, &Overrides::default())?;
        for (i, opacity) in clouds.iter().enumerate().filter_map(|(i, cloud)| Some((i, cloud.opacity?))) {
            document.set(&format!("cloud.{i}.opacity"), Setting::Number(f64::from(opacity)))?;
        }
        Ok(Self { clouds: clouds.into_iter().map(|cloud| cloud.columns).collect(), document, seed: 0 })
    }

    /// Gives a setting a value, by the name that it has in a scene file, as in `method.samples` or `cloud.0.opacity`.
    ///
    /// # Errors
    /// A name or a value that a scene file could not have; the scene then stays as it was.
    pub fn set(&mut self, key: &str, value: impl Into<Setting>) -> Result<&mut Self> {
        self.document.set(key, value.into())?;
        Ok(self)
    }

    /// Sets the seed of stochastic methods; the default is 0.
    pub fn set_seed(&mut self, seed: u64) -> &mut Self {
        self.seed = seed;
        self
    }

    /// The settings as a scene file; clouds that came from arrays have names in place of files.
    ///
    /// # Errors
    /// A working directory that can't be found.
    pub fn to_toml(&self) -> Result<String> {
        Ok(self.document.to_toml(Path::new("."))?)
    }
}
