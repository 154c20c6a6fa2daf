//! Device, and scenes on it.

use pellucid_gpu::{self as gpu, Device, DeviceOptions};
use pellucid_session::{Prepared, Session};

use crate::error::of_engine;
use crate::observer::Watcher;
use crate::{FrameBuilder, Observer, Result, Scene};

/// Returns the names of the Vulkan devices of this machine, in the order in which [`Renderer::open_device`] counts
/// them.
///
/// # Errors
/// Returns an error if the Vulkan loader is missing. The message names the package to install.
pub fn devices() -> Result<Vec<String>> {
    let (devices, _) = gpu::devices(None).map_err(of_engine)?;
    Ok(devices.into_iter().map(|device| device.name).collect())
}

/// Device that renders scenes.
#[derive(Clone)]
pub struct Renderer {
    device: Device,
    watcher: Watcher,
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
        let options = DeviceOptions { device, ..DeviceOptions::from_env() };
        Ok(Self { device: Device::open(&options).map_err(of_engine)?, watcher: Watcher::default() })
    }

    /// Reports progress, warnings and notes of loading and rendering to an observer. The observer may cancel a frame,
    /// which ends within one submission to the device, and loading between its steps. Scenes loaded before keep
    /// rendering as if nothing had been canceled.
    #[must_use]
    pub fn observed_by(self, observer: impl Observer + 'static) -> Self {
        Self { watcher: Watcher::new(observer), ..self }
    }

    /// Returns the device's name.
    pub fn device_name(&self) -> &str {
        &self.device.info().name
    }

    /// Returns the driver's name and version.
    pub fn driver_name(&self) -> &str {
        &self.device.info().driver
    }

    /// Loads a scene on the device: reads files, estimates missing radii, orders the points and uploads them. The
    /// method is decided here, and so is the opacity of a scene that asks for a share of light.
    ///
    /// # Errors
    /// Returns an error if a file can't be read, if the scene has no points, if its settings contradict each other, if
    /// the device has no room for it, and if an observer canceled the work.
    pub fn load(&self, scene: &Scene) -> Result<Loaded> {
        let (progress, watcher) = (self.watcher.progress(), self.watcher.clone());
        let prepared = Prepared::new(scene.request()?, &watcher, &progress).map_err(of_engine)?;
        let session = Session::open(&self.device, prepared, &watcher, &progress).map_err(of_engine)?;
        Ok(Loaded { session, scene: scene.clone(), watcher })
    }
}

/// Scene on a device, ready to render any number of frames.
pub struct Loaded {
    pub(crate) session: Session,
    pub(crate) scene: Scene,
    pub(crate) watcher: Watcher,
}

impl Loaded {
    /// Begins a frame. Camera, size and method are those of the scene unless you set them on the builder.
    pub fn frame(&mut self) -> FrameBuilder<'_> {
        FrameBuilder::new(self)
    }

    /// Takes over changed settings of the scene: makes again only what depends on them.
    ///
    /// # Errors
    /// Returns the errors of [`Renderer::load`].
    pub fn update(&mut self, scene: &Scene) -> Result<()> {
        let (request, progress) = (scene.request()?, self.watcher.progress());
        self.session.update(request, &self.watcher, &progress).map_err(of_engine)?;
        self.scene = scene.clone();
        Ok(())
    }

    /// Returns the name of the method in force.
    pub fn method(&self) -> &'static str {
        self.session.frame.method.name()
    }

    /// Returns the reason for the method in force.
    pub fn reason(&self) -> &str {
        &self.session.why
    }

    /// Returns the number of points, those without finite coordinates left out.
    pub fn len(&self) -> u64 {
        self.session.uploaded.cloud.total()
    }

    /// Returns `true` if there are no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
