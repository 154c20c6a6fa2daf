//! Scene that is not on a device: keys, and clouds or their paths.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pellucid_core::cloud::Cloud as Columns;
use pellucid_scene::{self as engine, Document, Input, Key, Named, Overrides, View};
use pellucid_session::describe_cloud;
use pyo3::prelude::*;

use crate::cloud::Cloud;
use crate::failure::Failure;
use crate::request::{self, Changes, Direction};
use crate::talk::Talk;
use crate::{fork, work};

/// Scene; its keys may change.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Scene(Mutex<State>);

/// Contents of a scene. Clones share the clouds.
#[derive(Clone)]
pub struct State {
    /// Name of the inputs.
    pub name: String,
    pub document: Document,
    /// Place of the clouds: arrays of the caller, or files that are not read yet.
    pub input: Input,
    pub view: View,
    pub seed: u64,
}

impl State {
    fn new(named: Named, seed: u64) -> Self {
        let Named { name, document, input } = named;
        Self { name, document, input, view: View::default(), seed }
    }

    /// Reads clouds that are still in files.
    fn read(&mut self, talk: &Talk) -> Result<Vec<Arc<Columns>>, Failure> {
        if let Input::Clouds(clouds) = &self.input {
            return Ok(clouds.to_vec());
        }
        let scene = self.document.scene()?;
        let clouds = self.input.load(&scene, &talk.progress)?;
        for (settings, cloud) in scene.clouds.iter().zip(&clouds) {
            describe_cloud(&settings.path, cloud, talk);
        }
        self.input = Input::Clouds(clouds.as_slice().into());
        Ok(clouds)
    }
}

/// Key with its value in force, as TOML.
type Valued = (String, Option<String>);

#[pymethods]
impl Scene {
    /// Return a scene of clouds, which have names in place of files.
    #[staticmethod]
    fn of_clouds(clouds: Vec<PyRef<'_, Cloud>>, names: Vec<String>) -> PyResult<Self> {
        let document = Document::from_clouds(&names, &Overrides::default()).map_err(Failure::from)?;
        let input = Input::Clouds(clouds.iter().map(|cloud| Arc::clone(&cloud.0)).collect());
        Ok(Self(Mutex::new(State::new(Named { name: names.join(" "), document, input }, 0))))
    }

    /// Return the scene of a scene file or of clouds; without paths, the built-in scene by `seed`.
    #[staticmethod]
    fn of_files(py: Python<'_>, paths: Vec<PathBuf>, seed: u64) -> PyResult<Self> {
        let read = move || -> Result<State, Failure> {
            fork::enter()?;
            let named = engine::name(&paths, &Overrides::default(), seed)?;
            named.document.scene()?;
            Ok(State::new(named, seed))
        };
        Ok(Self(Mutex::new(py.detach(read)?)))
    }

    /// Return the scene of the text of a scene file, whose relative paths start from `folder`.
    #[staticmethod]
    fn of_toml(text: &str, folder: PathBuf) -> PyResult<Self> {
        let origin = folder.join("scene.toml");
        let document = Document::from_toml(text, &origin, &Overrides::default()).map_err(Failure::from)?;
        document.scene().map_err(Failure::from)?;
        let name = origin.display().to_string();
        Ok(Self(Mutex::new(State::new(Named::of_files(name, document), 0))))
    }

    /// Return another scene with the same clouds.
    fn copy(&self) -> Self {
        Self(Mutex::new(self.state().clone()))
    }

    /// Remove tables, then set keys; all or nothing.
    fn change(&self, drop: Vec<String>, changes: Changes) -> PyResult<()> {
        let changed = {
            let mut state = self.state();
            let mut document = state.document.clone();
            request::lay_over(&mut document, &drop, &changes).map(|_| state.document = document)
        };
        Ok(changed?)
    }

    /// Remove a dotted key, so that its default holds; all or nothing.
    fn remove(&self, key: &str) -> PyResult<()> {
        let changed = self.state().document.change(&[(key.to_owned(), None)]);
        Ok(changed.map(drop).map_err(Failure::from)?)
    }

    fn set_view(&self, direction: Direction) -> PyResult<()> {
        let view = direction.view()?;
        self.state().view = view;
        Ok(())
    }

    fn set_name(&self, name: String) {
        self.state().name = name;
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.state().seed
    }

    #[setter]
    fn set_seed(&self, seed: u64) {
        self.state().seed = seed;
    }

    fn to_toml(&self, folder: PathBuf) -> PyResult<String> {
        let text = self.state().document.to_toml(&folder);
        Ok(text.map_err(Failure::from)?)
    }

    /// Return the keys that were given, as JSON.
    fn given(&self) -> PyResult<String> {
        Ok(self.scene()?.settings)
    }

    /// Return the keys of a table with their values in force: `image`, `camera`, `shading`, `shadows`, `detail`,
    /// `method` or `cloud.0`.
    fn values(&self, table: &str) -> PyResult<Vec<Valued>> {
        let scene = self.scene()?;
        let keys: Vec<Key> = match table.split_once('.') {
            Some(("cloud", number)) => {
                let cloud = number.parse().ok().and_then(|number: usize| scene.clouds.get(number));
                cloud.map(|cloud| cloud.keys()).unwrap_or_default()
            }
            _ => match table {
                "image" => scene.image.keys(),
                "camera" => scene.camera.keys(),
                "shading" => scene.shading.keys(),
                "shadows" => scene.shadows.unwrap_or_default().keys(),
                "detail" => scene.detail.keys(),
                "method" => scene.method.keys(),
                _ => Vec::new(),
            },
        };
        let mut values: Vec<Valued> =
            keys.iter().map(|key| (key.name.to_owned(), key.value.as_ref().map(ToString::to_string))).collect();
        if table == "method" {
            values.insert(0, ("name".to_owned(), Some(format!("{:?}", scene.method.name()))));
        }
        Ok(values)
    }

    /// Return the numbers of clouds and of clips.
    fn counts(&self) -> PyResult<[usize; 2]> {
        let scene = self.scene()?;
        Ok([scene.clouds.len(), scene.clips.len()])
    }

    /// Return the clouds, and read them first if they weren't read.
    #[pyo3(signature = (listener=None))]
    fn clouds(&self, py: Python<'_>, listener: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Cloud>> {
        let mut state = self.state().clone();
        let (state, clouds) = work::run(py, listener, move |talk| {
            let clouds = state.read(talk)?;
            Ok((state, clouds))
        })?;
        self.state().input = state.input;
        Ok(clouds.into_iter().map(Cloud).collect())
    }
}

impl Scene {
    /// Locks the state. Don't call Python while it is locked: what Python then does, such as freeing objects, could
    /// wait for the lock.
    pub fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn scene(&self) -> Result<engine::Scene, Failure> {
        Ok(self.state().document.scene()?)
    }
}
