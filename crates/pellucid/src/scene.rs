//! Point clouds and the settings for rendering them.

use std::path::{Path, PathBuf};

use pellucid_io as io;
use pellucid_scene::{self as engine, Document, Input, Named, Overrides};
use pellucid_session::{Limits, Request, Residence, SeeThrough, SeeThroughBy};

use crate::error::of_engine;
use crate::{Cloud, Result};

/// Point clouds and the settings for rendering them. Clones share the points.
#[derive(Debug, Clone)]
pub struct Scene {
    named: Named,
    seed: u64,
    see_through: Option<f64>,
    host_memory: Option<u64>,
}

/// Value of a setting: a number, a whole number, true or false, a word, or an array of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting(engine::Setting);

macro_rules! settings {
    ($($type:ty),+) => {
        $(impl From<$type> for Setting {
            fn from(value: $type) -> Self {
                Self(value.into())
            }
        })+
    };
}

settings!(f64, u32, bool, &str);

impl<const N: usize> From<[f64; N]> for Setting {
    fn from(values: [f64; N]) -> Self {
        Self(values.into())
    }
}

impl<const N: usize> From<[u32; N]> for Setting {
    fn from(values: [u32; N]) -> Self {
        Self(values.into())
    }
}

impl Scene {
    /// Opens a scene file (`.toml`), or a single cloud. Points are read when the scene is loaded.
    ///
    /// # Errors
    /// Returns an error with line and column if something is wrong with the scene file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let named = engine::name(&[path.as_ref().to_owned()], &Overrides::default(), 0).map_err(of_engine)?;
        named.document.scene().map_err(of_engine)?;
        Ok(Self::of(named))
    }

    /// Creates a scene of clouds with default settings.
    ///
    /// # Errors
    /// Returns an error if there is no cloud.
    pub fn from_clouds(clouds: impl IntoIterator<Item = Cloud>) -> Result<Self> {
        let clouds: Vec<Cloud> = clouds.into_iter().collect();
        let names: Vec<PathBuf> = (0..clouds.len()).map(|i| PathBuf::from(format!("cloud-{i}"))).collect();
        let mut document = Document::from_clouds(&names, &Overrides::default()).map_err(of_engine)?;
        for (i, cloud) in clouds.iter().enumerate() {
            let color = cloud.color.map(|color| color.map(f64::from).into());
            let numbers = [("opacity", cloud.opacity), ("radius", cloud.radius)];
            let numbers = numbers.map(|(key, value)| (key, value.map(|value| f64::from(value).into())));
            for (key, value) in [("color", color)].into_iter().chain(numbers) {
                if let Some(value) = value {
                    document.set(&format!("cloud.{i}.{key}"), value).map_err(of_engine)?;
                }
            }
        }
        let input = Input::Clouds(clouds.into_iter().map(|cloud| cloud.columns).collect());
        Ok(Self::of(Named { name: String::new(), document, input }))
    }

    fn of(named: Named) -> Self {
        Self { named, seed: 0, see_through: None, host_memory: None }
    }

    /// Sets the value of a setting, by its name in a scene file, such as `method.samples` or `cloud.0.opacity`.
    ///
    /// # Errors
    /// Returns an error for a name or a value that is not possible in a scene file. The scene is then unchanged.
    pub fn set(&mut self, key: &str, value: impl Into<Setting>) -> Result<&mut Self> {
        self.named.document.set(key, value.into().0).map_err(of_engine)?;
        Ok(self)
    }

    /// Sets the seed of stochastic methods, 0 by default.
    pub fn set_seed(&mut self, seed: u64) -> &mut Self {
        self.seed = seed;
        self
    }

    /// Has the opacity found at which half of the covered pixels let at least this share of the light through, from 0
    /// to 1.
    pub fn set_see_through(&mut self, share: f64) -> &mut Self {
        self.see_through = Some(share);
        self
    }

    /// Limits host memory for points to this number of bytes: larger clouds stay in their files, and frames read the
    /// points that they show. By default it is half of the free memory.
    pub fn set_host_memory(&mut self, bytes: u64) -> &mut Self {
        self.host_memory = Some(bytes);
        self
    }

    /// Returns the settings as the text of a scene file. Clouds made from arrays have names in place of files.
    ///
    /// # Errors
    /// Returns an error if the working directory can't be found.
    pub fn to_toml(&self) -> Result<String> {
        self.named.document.to_toml(Path::new(".")).map_err(of_engine)
    }

    /// Returns the request for a picture of this scene.
    pub(crate) fn request(&self) -> Result<Request> {
        if let Some(share) = self.see_through.filter(|share| !(0.0..=1.0).contains(share)) {
            return Err(crate::Error::argument(format!("see-through: expected a share from 0 to 1, found {share}")));
        }
        let memory = self.host_memory.map_or_else(io::memory_for_points, |bytes| bytes.max(io::LEAST_MEMORY));
        let limits = Limits { memory, residence: Residence::Levels };
        let mut request = Request::new(&self.named, limits, self.seed).map_err(of_engine)?;
        request.see_through = self.see_through.map(|share| SeeThrough { share, by: SeeThroughBy::Option });
        Ok(request)
    }

    /// Returns the keys of the scene with another method.
    pub(crate) fn with_method(&self, method: crate::Method) -> Result<engine::Scene> {
        let mut document = self.named.document.clone();
        document.set("method.name", method.name().into()).map_err(of_engine)
    }
}
