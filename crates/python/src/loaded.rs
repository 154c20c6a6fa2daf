//! Scene on a device, for Python.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyArray1;
use pellucid_core::image::Image;
use pellucid_session::Session;
use pyo3::prelude::*;

use crate::arrays;
use crate::devices::Device;
use crate::failure::Failure;
use crate::fork::Kept;
use crate::measures::{self, TradeoffExtent};
use crate::picture::{self, CameraNumbers, Moved, Picture};
use crate::request::Ask;
use crate::scene::Scene;
use crate::session::SceneSession;
use crate::talk::Talk;
use crate::work;

/// Scene on a device; one frame at a time.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Loaded(Mutex<Kept<Arc<Mutex<SceneSession>>>>);

#[pymethods]
impl Loaded {
    /// Load a scene on a device; `with_radii` finds radii even if its method doesn't need them.
    #[new]
    #[pyo3(signature = (device, scene, ask, with_radii=false, listener=None))]
    fn new(
        py: Python<'_>,
        device: &Device,
        scene: &Scene,
        ask: Ask,
        with_radii: bool,
        listener: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let device = device.device()?;
        let state = scene.state().clone();
        let session = work::run(py, listener, move |talk| SceneSession::open(&device, state, &ask, with_radii, talk))?;
        Ok(Self(Mutex::new(Kept::new("scene", Arc::new(Mutex::new(session))))))
    }

    /// Render a frame.
    #[pyo3(signature = (ask, listener=None))]
    fn frame<'py>(
        &self,
        py: Python<'py>,
        ask: Ask,
        listener: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(Picture, Moved<'py>)> {
        let (picture, image) = self.with(py, listener, move |work, talk| {
            work.prepare(&ask, talk)?;
            render(&mut work.session, talk)
        })?;
        Ok((picture, picture::moved(py, image)))
    }

    /// Measure frames and return the JSON of `pellucid profile`.
    #[pyo3(signature = (ask, frames, steady, listener=None))]
    fn profile(
        &self,
        py: Python<'_>,
        ask: Ask,
        frames: u32,
        steady: bool,
        listener: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        self.with(py, listener, move |work, talk| {
            work.prepare(&ask.with_fragments(), talk)?;
            measures::profile(&mut work.session, (frames, steady), talk)
        })
    }

    /// Return the passes of a frame as the JSON of `pellucid plan`.
    #[pyo3(signature = (ask, listener=None))]
    fn plan(&self, py: Python<'_>, ask: Ask, listener: Option<&Bound<'_, PyAny>>) -> PyResult<String> {
        self.with(py, listener, move |work, talk| {
            work.prepare(&ask.with_fragments(), talk)?;
            measures::plan(&mut work.session, talk)
        })
    }

    /// Compare methods and return the JSON of `pellucid tradeoff`, whose files go to `folder`.
    #[pyo3(signature = (ask, extent, folder, listener=None))]
    fn tradeoff(
        &self,
        py: Python<'_>,
        ask: Ask,
        extent: TradeoffExtent,
        folder: PathBuf,
        listener: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        self.with(py, listener, move |work, talk| measures::tradeoff(work, &ask, &extent, &folder, talk))
    }

    /// Return the camera of the last frame, or of the scene; see [`Picture`].
    fn camera(&self, py: Python<'_>) -> PyResult<CameraNumbers> {
        self.with(py, None, |work, _| Ok(picture::numbers(&work.session.prepared.camera)))
    }

    fn size(&self, py: Python<'_>) -> PyResult<[u32; 2]> {
        self.with(py, None, |work, _| Ok(work.session.frame.size))
    }

    /// Return the method of the last frame, and why; before the first frame, the method that `auto` stands for.
    fn method(&self, py: Python<'_>) -> PyResult<(&'static str, String)> {
        self.with(py, None, |work, _| Ok((work.session.frame.method.name(), work.session.why.clone())))
    }

    /// Return how clouds are colored, and why.
    fn colorings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, None, |work, _| Ok(work.session.assembled().colorings.clone()))
    }

    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let bounds = self.with(py, None, |work, _| Ok(work.session.prepared.bounds))?;
        Ok(bounds.map(|bounds| arrays::flat(py, vec![bounds.min.to_array(), bounds.max.to_array()])))
    }

    /// Return the number of points.
    fn count(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, None, |work, _| Ok(work.session.uploaded.cloud.total()))
    }

    /// Free the device memory, once a frame that is still in work has ended, without waiting for that.
    fn close(&self, py: Python<'_>) {
        py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).close());
    }
}

impl Loaded {
    /// Runs work with the session, once others have finished with it.
    fn with<T: Send + 'static>(
        &self,
        py: Python<'_>,
        listener: Option<&Bound<'_, PyAny>>,
        task: impl FnOnce(&mut SceneSession, &Talk) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let session = self.0.lock().unwrap_or_else(PoisonError::into_inner).get().cloned();
        let session = session?;
        work::run(py, listener, move |talk| {
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            task(&mut session, talk)
        })
    }
}

/// Renders the frame that the session is ready for.
fn render(session: &mut Session, talk: &Talk) -> Result<(Picture, Image), Failure> {
    let (rendered, options) = session.picture(pellucid_engine::methods::Outputs::default(), Vec::new(), talk)?;
    let mut profile = session.profile();
    profile.add(&rendered);
    let picture = Picture {
        size: session.frame.size,
        options,
        profile,
        camera: session.prepared.camera,
        method: session.frame.method.name(),
        reason: session.why.clone(),
        stderr: rendered.image.standard_error(),
        samples: rendered.image.samples.max(1),
    };
    Ok((picture, rendered.image))
}
