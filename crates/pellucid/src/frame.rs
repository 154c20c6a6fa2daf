//! Single frame of a loaded scene.

use pellucid_engine::methods::brightness;
use pellucid_engine::methods::{Error, Frame};
use pellucid_engine::scene::camera_at;

use crate::{Camera, Loaded, Picture, Result};

/// Settings of a frame; [`render`](Self::render) renders it.
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

    /// Sets the camera.
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// Sets the width and height in pixels, each from 1 to 16384.
    pub fn size(mut self, width: u32, height: u32) -> Self {
        self.frame.size = [width, height];
        self
    }

    /// Limits device memory, other than that of points and image, to this number of bytes.
    pub fn memory_budget(mut self, bytes: u64) -> Self {
        self.frame.memory_budget = Some(bytes);
        self
    }

    /// Requests the number of fragments of each pixel, and for methods that peel, the number of layers.
    pub fn counts(mut self) -> Self {
        self.frame.fragments = true;
        self
    }

    /// Requests the median and the mean depth of each pixel. Methods that have them sort lists of all fragments:
    /// `abuffer`, `linked-list`, `peel` of all layers and `sorted` of flat discs. Each depth takes the time of another
    /// picture.
    pub fn depths(mut self) -> Self {
        self.frame.depths = true;
        self
    }

    /// Ends stochastic methods before they have taken all samples of their settings, once the standard error of the
    /// image (root mean square over pixels and R, G, B) is at most `error`.
    pub fn max_error(mut self, error: f32) -> Self {
        self.frame.max_error = Some(error);
        self
    }

    /// Multiplies all radii and all opacities by factors, each at least 0.
    pub fn factors(mut self, radius: f32, opacity: f32) -> Self {
        self.frame.factors.radius = radius;
        self.frame.factors.opacity = opacity;
        self
    }

    /// Renders the frame.
    ///
    /// # Errors
    /// Returns an error for a camera without a view (eye and target coincide, `up` along the view, a wrong angle), for
    /// a frame that does not fit in the device or the budget, if the device fails, and if an observer canceled the
    /// work.
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
