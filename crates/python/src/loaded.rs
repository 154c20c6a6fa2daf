//! Scene on a device, for Python.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyArray1;
use pellucid_engine::methods::brightness;
use pellucid_engine::output;
use pellucid_engine::profile::Profile;
use pellucid_lab::frame_notes;
use pyo3::prelude::*;

use crate::arrays;
use crate::devices::Device;
use crate::failure::Failure;
use crate::fork::Kept;
use crate::measures::{self, Extent};
use crate::picture::{self, CameraNumbers, Moved, Picture};
use crate::request::Ask;
use crate::scene::Scene;
use crate::session::Session;
use crate::talk::Talk;
use crate::work;

/// Scene on a device; one frame at a time.
#[pyclass(frozen, module = "pellucid._pellucid")]
pub struct Loaded(Mutex<Kept<Arc<Mutex<Session>>>>);

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
        let device = device.device().map_err(|failure| failure.raise(py))?;
        let state = scene.state().clone();
        let session = work::run(py, listener, move |talk| {
            ask.check()?;
            Session::open(device, state, &ask, with_radii, talk)
        })?;
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
        let (picture, image) = self.with(py, listener, move |session, talk| {
            ask.check()?;
            session.prepare(&ask, talk)?;
            render(session, &ask, talk)
        })?;
        Ok((picture, picture::moved(py, image)))
    }

    /// Measure frames and return the JSON of `pellucid profile`.
    #[pyo3(signature = (ask, frames, listener=None))]
    fn profile(&self, py: Python<'_>, ask: Ask, frames: u32, listener: Option<&Bound<'_, PyAny>>) -> PyResult<String> {
        self.with(py, listener, move |session, talk| {
            ask.check()?;
            session.prepare(&ask.with_fragments(), talk)?;
            measures::profile(session, frames, talk)
        })
    }

    /// Return the passes of a frame as the JSON of `pellucid plan`.
    #[pyo3(signature = (ask, listener=None))]
    fn plan(&self, py: Python<'_>, ask: Ask, listener: Option<&Bound<'_, PyAny>>) -> PyResult<String> {
        self.with(py, listener, move |session, talk| {
            ask.check()?;
            session.prepare(&ask.with_fragments(), talk)?;
            measures::plan(session)
        })
    }

    /// Compare methods and return the JSON of `pellucid tradeoff`, whose files go to `folder`.
    #[pyo3(signature = (ask, extent, folder, listener=None))]
    fn tradeoff(
        &self,
        py: Python<'_>,
        ask: Ask,
        extent: Extent,
        folder: PathBuf,
        listener: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        self.with(py, listener, move |session, talk| {
            ask.check()?;
            measures::tradeoff(session, &ask, &extent, &folder, talk)
        })
    }

    /// Return the camera of the last frame, or of the scene; see [`Picture`].
    fn camera(&self, py: Python<'_>) -> PyResult<CameraNumbers> {
        self.with(py, None, |session, _| Ok(picture::numbers(&session.frame.camera, distance(session))))
    }

    fn size(&self, py: Python<'_>) -> PyResult<[u32; 2]> {
        self.with(py, None, |session, _| Ok(session.frame.size))
    }

    /// Return the method of the last frame, and why; before the first frame, the method that `auto` stands for.
    fn method(&self, py: Python<'_>) -> PyResult<(&'static str, String)> {
        self.with(py, None, |session, _| Ok((session.frame.method.name(), session.why.clone())))
    }

    /// Return how clouds are colored, and why.
    fn colorings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, None, |session, _| Ok(session.made.colorings.clone()))
    }

    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let bounds = self.with(py, None, |session, _| Ok(session.bounds))?;
        Ok(bounds.map(|bounds| arrays::flat(py, vec![bounds.min.to_array(), bounds.max.to_array()])))
    }

    /// Return the number of points.
    fn count(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, None, |session, _| Ok(session.cloud.total()))
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
        work: impl FnOnce(&mut Session, &Talk) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let session = self.0.lock().unwrap_or_else(PoisonError::into_inner).get().cloned();
        let session = session.map_err(|failure| failure.raise(py))?;
        work::run(py, listener, move |talk| {
            let mut session = session.lock().unwrap_or_else(PoisonError::into_inner);
            work(&mut session, talk)
        })
    }
}

/// Returns the distance from the eye to the middle of the scene along the view.
fn distance(session: &Session) -> f64 {
    let camera = &session.frame.camera;
    session.bounds.map_or(1.0, |bounds| (bounds.center() - camera.eye).dot(camera.forward))
}

/// Renders the frame that the session is ready for.
fn render(session: &mut Session, ask: &Ask, talk: &Talk) -> Result<(Picture, pellucid_engine::image::Image), Failure> {
    session.frame.depths = ask.depths;
    let rendered = session.renderer.render(&mut session.cloud, &session.frame);
    session.frame.depths = false;
    let mut rendered = rendered?;
    session.device.check_validation()?;
    let empty = frame_notes::empty(&rendered.image, session.made.points());
    empty.into_iter().for_each(|message| talk.warn(message));
    let Session { renderer, cloud, frame, .. } = session;
    let brightness = brightness::apply(renderer, cloud, frame, &mut rendered.image)?;
    session.device.check_validation()?;
    let mut profile = Profile::new(&session.device, &session.frame);
    profile.add(&rendered);
    let method = session.frame.method.name();
    let device = &session.device.info().name;
    let mut metadata = output::tags(&session.state.name, method, &session.scene.settings, device, session.frame.seed);
    brightness.iter().filter_map(|applied| applied.warning()).for_each(|warning| talk.warn(warning));
    let Session { frame, cloud, found, .. } = &session;
    let clouds = &session.scene.clouds;
    metadata.extend(frame_notes::decisions(frame, cloud, clouds, brightness.as_ref(), found.as_ref()));
    let choice = session.choice.as_ref().map(|choice| choice.json());
    metadata.extend(choice.map(|json| ("pellucid:choice".to_owned(), json.to_string())));
    let picture = Picture {
        size: session.frame.size,
        background: session.scene.image.background,
        color: session.scene.image.color_space(),
        metadata,
        profile,
        camera: session.frame.camera,
        distance: distance(session),
        method,
        reason: session.why.clone(),
        stderr: rendered.image.standard_error(),
    };
    Ok((picture, rendered.image))
}
