//! A device, and scenes on it.

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

/// Names of the Vulkan devices of this machine, in the order in which [`Renderer::open_device`] counts them.
///
/// # Errors
/// The Vulkan loader is missing; the message names the package to install.
pub fn devices() -> Result<Vec<String>> {
    let (devices, _) = gpu::devices(None)?;
    Ok(devices.into_iter().map(|device| device.name).collect())
}

/// A device that renders scenes.
#[derive(Clone)]
pub struct Renderer {
    device: Device,
    progress: Progress,
}

impl Renderer {
    /// Opens the best device: a GPU, else a driver that runs on the CPU.
    ///
    /// # Errors
    /// The loader or a device is missing; the message names the package to install.
    pub fn open() -> Result<Self> {
        Self::open_with(None)
    }

    /// Opens the device of that number in [`devices`], or whose name contains the text.
    ///
    /// # Errors
    /// As [`Self::open`], and no such device.
    pub fn open_device(device: &str) -> Result<Self> {
        Self::open_with(Some(device.to_owned()))
    }

    fn open_with(device: Option<String>) -> Result<Self> {
        let device = Device::open(&DeviceOptions { device, ..DeviceOptions::from_env() })?;
        Ok(Self { device, progress: Progress::hidden() })
    }

    /// Tells an observer how far loading and rendering are. It may cancel a frame, which ends within one submission to the
    /// device, and loading between its steps; what was loaded before renders on as if nothing had been cancelled.
    #[must_use]
    pub fn observed_by(self, observer: impl Observer + 'static) -> Self {
        Self { progress: Progress::observed(observer), ..self }
    }

    /// The device's name.
    pub fn device_name(&self) -> &str {
        &self.device.info().name
    }

    /// The driver's name and version.
    pub fn driver_name(&self) -> &str {
        &self.device.info().driver
    }

    /// An error if the observer wants the work to end.
    fn go_on(&self) -> Result<()> {
        Ok(self.progress.check().map_err(methods::Error::from)?)
    }

    /// Brings a scene to the device: estimates the radii that are missing, orders the points and uploads them. The scene's
    /// method is decided here, if it is `auto`.
    ///
    /// # Errors
    /// A scene without points, one whose settings contradict each other, one that the device has no room for, and work that
    /// an observer cancelled.
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

/// A scene on a device, ready to render any number of frames.
pub struct Loaded {
    pub(crate) renderer: methods::Renderer,
    pub(crate) cloud: DeviceCloud,
    pub(crate) frame: Frame,
    pub(crate) reason: String,
    pub(crate) settings: engine::Scene,
    /// Points that are dealt to ensembles stay on the host, too.
    #[allow(dead_code, reason = "kept for what the device reads of it")]
    arranged: Arc<Arranged>,
    pub(crate) bounds: Option<Bounds>,
    pub(crate) radius: f64,
}

impl Loaded {
    /// Begins a frame: the camera, the size and the method are those of the scene unless they are given here.
    pub fn frame(&mut self) -> FrameBuilder<'_> {
        FrameBuilder::new(self)
    }

    /// The method in force.
    pub fn method(&self) -> &'static str {
        self.frame.method.name()
    }

    /// Why this method is in force.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// Number of points, those without finite coordinates left out.
    pub fn len(&self) -> u64 {
        self.cloud.total()
    }

    /// True without points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
