//! Device, and scenes on it.

use std::sync::Arc;

use pellucid_engine::cloud::Bounds;
use pellucid_engine::gpu::{self, Device, DeviceOptions};
use pellucid_engine::methods::{self, Frame};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::plan;
use pellucid_engine::prepare::Arranged;
use pellucid_engine::progress::{Observer, Progress};
use pellucid_engine::scene as engine;

use crate::{FrameBuilder, Result, Scene};

/// Returns the names of the Vulkan devices of this machine, in the order in which [`Renderer::open_device`] counts
/// them.
///
/// # Errors
/// Returns an error if the Vulkan loader is missing. The message names the package to install.
pub fn devices() -> Result<Vec<String>> {
    let (devices, _) = gpu::devices(None)?;
    Ok(devices.into_iter().map(|device| device.name).collect())
}

/// Device that renders scenes.
#[derive(Clone)]
pub struct Renderer {
    device: Device,
    progress: Progress,
}

impl Renderer {
    /// Opens the best device: a GPU, else a driver that runs on the CPU.
    ///
    /// # Errors
    /// Returns an error if the loader or a device is missing. The message names the package to install.
    pub fn open() -> Result<Self> {
        Self::open_with(None)
    }

    /// Opens the device with that index in [`devices`], counted from 0, or the one whose name contains the text.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`], and an error if there is no such device.
    pub fn open_device(device: &str) -> Result<Self> {
        Self::open_with(Some(device.to_owned()))
    }

    fn open_with(device: Option<String>) -> Result<Self> {
        let device = Device::open(&DeviceOptions { device, ..DeviceOptions::from_env() })?;
        Ok(Self { device, progress: Progress::hidden() })
    }

    /// Reports the progress of loading and rendering to an observer. The observer may cancel a frame, which ends within
    /// one submission to the device, and loading between its steps. Scenes loaded before keep rendering as if nothing
    /// had been canceled.
    #[must_use]
    pub fn observed_by(self, observer: impl Observer + 'static) -> Self {
        Self { progress: Progress::observed(observer), ..self }
    }

    /// Returns the device's name.
    pub fn device_name(&self) -> &str {
        &self.device.info().name
    }

    /// Returns the driver's name and version.
    pub fn driver_name(&self) -> &str {
        &self.device.info().driver
    }

    /// Returns an error if the observer cancels the work.
    fn go_on(&self) -> Result<()> {
        Ok(self.progress.check().map_err(methods::Error::from)?)
    }

    /// Loads a scene on the device: estimates missing radii, orders the points and uploads them. If the scene's method
    /// is `auto`, the method is decided here.
    ///
    /// # Errors
    /// Returns an error if the scene has no points, its settings contradict each other, or the device has no room for
    /// it, and if an observer canceled the work.
    pub fn load(&self, scene: &Scene) -> Result<Loaded> {
        self.go_on()?;
        let mut settings = scene.document.scene()?;
        settings.settle(&scene.clouds);
        let (texture, _) = engine::shadow_texture(&settings, &scene.clouds, scene.seed);
        let up = engine::up_axis(&scene.clouds);
        let arranged = engine::arrange(&settings, scene.clouds.clone(), scene.seed, &self.progress)?;
        self.go_on()?;
        let (camera, _) = engine::camera(&settings, arranged.points(), up)?;
        let mut renderer = methods::Renderer::new(&self.device)?;
        renderer.progress = self.progress.clone();
        let mut cloud = renderer.upload_for(&settings.detail, &arranged, texture.as_ref())?;
        let mut frame = Frame::of_scene(&settings, camera, scene.seed);
        let (method, reason) = plan::choose(&mut renderer, &mut cloud, arranged.points(), settings.method, &frame)?;
        frame.method = method;
        let radius = arranged.points().largest_radius();
        let bounds = arranged.points().bounds();
        let arranged = Arc::new(arranged);
        Ok(Loaded { renderer, cloud, frame, reason, settings, arranged, bounds, radius })
    }
}

/// Scene on a device, ready to render any number of frames.
pub struct Loaded {
    pub(crate) renderer: methods::Renderer,
    pub(crate) cloud: DeviceCloud,
    pub(crate) frame: Frame,
    pub(crate) reason: String,
    pub(crate) settings: engine::Scene,
    /// Points that are partitioned into ensembles stay on the host, too.
    #[allow(dead_code, reason = "kept for what the device reads of it")]
    arranged: Arc<Arranged>,
    pub(crate) bounds: Option<Bounds>,
    pub(crate) radius: f64,
}

impl Loaded {
    /// Begins a frame. Camera, size and method are those of the scene unless you set them on the builder.
    pub fn frame(&mut self) -> FrameBuilder<'_> {
        FrameBuilder::new(self)
    }

    /// Returns the method in force.
    pub fn method(&self) -> &'static str {
        self.frame.method.name()
    }

    /// Returns the reason for the method in force.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// Returns the number of points, those without finite coordinates left out.
    pub fn len(&self) -> u64 {
        self.cloud.total()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
