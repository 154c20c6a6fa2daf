//! Single frame of a loaded scene.

use std::time::Duration;

use pellucid_engine::methods::{Outputs, SAMPLES, Stop};
use pellucid_scene::camera_at;
use pellucid_session::FrameRequest;

use crate::error::of_engine;
use crate::{Camera, Error, Loaded, Method, Picture, Profile, Result};

/// Settings of a frame; [`render`](Self::render) renders it.
#[must_use]
pub struct FrameBuilder<'a> {
    loaded: &'a mut Loaded,
    frame: FrameRequest,
    camera: Option<Camera>,
    size: Option<[u32; 2]>,
    samples: Option<Samples>,
    method: Option<Method>,
    largest_rmse: Option<f64>,
    longest_time: Option<Duration>,
    timed: bool,
}

/// Samples of each pixel's area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Samples {
    /// Enough for a stated error: they double from 4 to at most 64, until the picture changes by no more than
    /// `image.sampling_error` (RMSE).
    Auto,
    /// Fixed number: 1, 2, 4, 8, 16, 32 or 64.
    Count(u32),
}

impl From<u32> for Samples {
    fn from(count: u32) -> Self {
        Self::Count(count)
    }
}

/// Accuracy of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Accuracy {
    /// Every fragment that changes a bit is blended.
    #[default]
    Exact,
    /// Blending ends once no 8-bit value would change by more than a quarter of a step, as in a PNG of
    /// `pellucid render`.
    EightBit,
}

impl<'a> FrameBuilder<'a> {
    pub(crate) fn new(loaded: &'a mut Loaded) -> Self {
        let frame = FrameRequest::default();
        Self {
            loaded,
            frame,
            camera: None,
            size: None,
            samples: None,
            method: None,
            largest_rmse: None,
            longest_time: None,
            timed: false,
        }
    }

    /// Sets the camera.
    pub fn camera(self, camera: Camera) -> Self {
        Self { camera: Some(camera), ..self }
    }

    /// Sets the width and height in pixels, each from 1 to 16384.
    pub fn size(self, width: u32, height: u32) -> Self {
        Self { size: Some([width, height]), ..self }
    }

    /// Sets the samples of each pixel's area, by default those of the scene, else 1: the center alone. The picture is
    /// the mean of so many images, each moved by a fraction of a pixel: edges are smooth, and points smaller than a
    /// pixel have their share of it.
    pub fn samples(self, samples: impl Into<Samples>) -> Self {
        Self { samples: Some(samples.into()), ..self }
    }

    /// Sets the method; its settings are those of the scene.
    pub fn method(self, method: Method) -> Self {
        Self { method: Some(method), ..self }
    }

    /// Sets the accuracy, [`Accuracy::Exact`] by default.
    pub fn accuracy(mut self, accuracy: Accuracy) -> Self {
        self.frame.stop = match accuracy {
            Accuracy::Exact => Stop::Exact,
            Accuracy::EightBit => Stop::EightBit { transparent: false },
        };
        self
    }

    /// Takes the fastest method and settings with at most this RMSE on linear R, G, B, measured on this frame.
    pub fn largest_rmse(self, rmse: f64) -> Self {
        Self { largest_rmse: Some(rmse), ..self }
    }

    /// Takes the most accurate method and settings with at most this device time, measured on this frame.
    pub fn longest_time(self, time: Duration) -> Self {
        Self { longest_time: Some(time), ..self }
    }

    /// Limits device memory, other than that of points and image, to this number of bytes.
    pub fn memory_budget(mut self, bytes: u64) -> Self {
        self.frame.memory_budget = Some(bytes);
        self
    }

    /// Requests the number of fragments of each pixel, and for methods that peel, the number of layers.
    pub fn counts(mut self) -> Self {
        self.frame.counts = true;
        self
    }

    /// Requests the median and the mean depth of each pixel. Methods that have them sort lists of all fragments:
    /// `abuffer`, `linked-list`, `peel` of all layers and `sorted` of flat discs. Each depth takes the time of another
    /// picture.
    pub fn depth_channels(mut self) -> Self {
        self.frame.depths = true;
        self
    }

    /// Ends stochastic methods before they have taken all samples of their settings, once the standard error of the
    /// image (root mean square over pixels and R, G, B) is at most `error`.
    pub fn standard_error(mut self, error: f32) -> Self {
        self.frame.max_error = Some(error);
        self
    }

    /// Times each pass and counts its invocations ([`Profile::passes`]). Timestamps keep passes apart that may run at
    /// the same time, so the frame takes a little longer.
    pub fn timed(self) -> Self {
        Self { timed: true, ..self }
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
    /// Returns an error for a number of samples other than 1, 2, 4, 8, 16, 32 and 64, for a camera without a view (eye
    /// and target coincide, `up` along the view, a wrong angle), for a frame that does not fit in the device or the
    /// budget, if the device fails, and if an observer canceled the work.
    pub fn render(self) -> Result<Picture> {
        let Self { loaded, frame, camera, size, samples, method, largest_rmse, longest_time, timed } = self;
        let Loaded { session, scene, watcher } = loaded;
        let mut request = scene.request()?;
        if let Some(method) = method {
            request.scene = scene.with_method(method)?;
        }
        if let Some(size) = size {
            request.scene.image.size = size;
        }
        match samples {
            Some(Samples::Auto) => request.scene.image.samples = pellucid_scene::Samples::Auto,
            Some(Samples::Count(count)) if SAMPLES.contains(&count) => {
                request.scene.image.samples = pellucid_scene::Samples::Count(count);
            }
            Some(Samples::Count(count)) => {
                return Err(Error::argument(format!("samples: expected 1, 2, 4, 8, 16, 32 or 64, found {count}")));
            }
            None => {}
        }
        if let (Some(camera), Some(bounds)) = (camera, &session.prepared.bounds) {
            let radius = session.points().largest_radius();
            let found = camera.is_valid().then(|| camera_at(&camera.0, bounds, radius)).flatten();
            if found.is_none() {
                return Err(Error::argument(
                    "camera: expected an eye apart from its target, `up` not along the view, an angle above 0° and below 180° or \
                     a height above 0, and 0 < near < far",
                ));
            }
            request.scene.camera = camera.0;
        }
        request.frame = frame;
        request.choice.wish.max_error = largest_rmse;
        request.choice.wish.budget_ms = longest_time.map(|time| time.as_secs_f64() * 1e3);
        request.choice.only = method.filter(|method| *method != Method::Auto).map(|method| method.name().to_owned());
        session.renderer.timed = timed;
        if session.update(request, watcher, &watcher.progress()).map_err(of_engine)? {
            session.warn(watcher);
        }
        let (rendered, options) = session.picture(Outputs::default(), Vec::new(), watcher).map_err(of_engine)?;
        let mut profile = session.profile();
        profile.add(&rendered);
        Ok(Picture {
            image: rendered.image,
            options,
            method: session.frame.method.name(),
            reason: session.why.clone(),
            profile: Profile(profile),
        })
    }
}
