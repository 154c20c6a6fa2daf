//! A single frame of a loaded scene.

use pellucid_engine::methods::brightness;
use pellucid_engine::methods::{Error, Frame};
use pellucid_engine::scene::camera_at;

use crate::{Camera, Loaded, Picture, Result};

/// The settings of a frame; [`render`](Self::render) renders it.
#[must_use]
pub struct FrameBuilder<'a> {
    loaded: &'a mut Loaded,
    frame: Frame,
    camera: Option<Camera>,
}

impl<'a> FrameBuilder<'a> {
    pub(crate) fn new(loaded: &'a mut Loaded) -> Self {
        let frame = loaded.frame;
        Self { loaded, frame, camera: None }
    }

    /// Looks from another camera.
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// Renders another number of columns and rows, each from 1 to 16384.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.frame.size = [width, height];
        self
    }

    /// Limits device memory beside points and image to this number of bytes.
    pub fn memory_budget(mut self, bytes: u64) -> Self {
        self.frame.memory_budget = Some(bytes);
        self
    }

    /// Has the picture carry the number of fragments of each pixel, and, of methods that peel, its layers.
    pub fn counts(mut self) -> Self {
        self.frame.fragments = true;
        self
    }

    /// Has the picture carry the median and the mean depth of each pixel, of methods whose pictures follow from sorted lists of all
    /// fragments: `abuffer`, `linked-list`, `peel` of all layers and `sorted` of flat discs. Each takes the time of another picture.
    pub fn depths(mut self) -> Self {
        self.frame.depths = true;
        self
    }

    /// Has stochastic methods take fewer samples than their settings say once the standard error of the image (root mean
    /// square over pixels and R, G, B) is at most this.
    pub fn max_error(mut self, error: f32) -> Self {
        self.frame.max_error = Some(error);
        self
    }

    /// Multiplies all radii and all opacities by factors, at least 0.
    pub fn factors(mut self, radius: f32, opacity: f32) -> Self {
        self.frame.factors.radius = radius;
        self.frame.factors.opacity = opacity;
        self
    }

    /// Renders the frame.
    ///
    /// # Errors
    /// A camera without a view (eye and target coincide, `up` along the view, a wrong angle), a frame that does not fit the
    /// device or the budget, a device that fails, and work that an observer cancelled.
    pub fn render(self) -> Result<Picture> {
        let Self { loaded, mut frame, camera } = self;
        if let (Some(camera), Some(bounds)) = (camera, &loaded.bounds) {
            let settings = camera.0;
            let found = camera.is_valid().then(|| camera_at(&settings, bounds, loaded.radius)).flatten();
            frame.camera = found.ok_or_else(|| {
                crate::Error::argument(
                    "camera: expected an eye apart from its target, `up` not along the view, an angle above 0° and below 180° or \
                     a height above 0, and 0 < near < far",
                )
            })?;
        }
        let Loaded { renderer, cloud, .. } = loaded;
        let mut rendered = renderer.render(cloud, &frame)?;
        brightness::apply(renderer, cloud, &frame, &mut rendered.image)?;
        renderer.device().check_validation().map_err(Error::from)?;
        Ok(Picture::new(rendered, &frame, loaded))
    }
}
