//! A request with its clouds read, its points arranged and its camera found: all that is known without a device.

use bytesize::ByteSize;
use glam::Vec3;
use pellucid_core::camera::StatedCamera;
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{Factors, Frame, Stop, see_through};
use pellucid_io::output;
use pellucid_scene::{self as scene, Background, Error, Scene};

use crate::assembled::Assembled;
use crate::choice::Wish;
use crate::messages::Messages;
use crate::request::{Request, SeeThrough, SeeThroughBy};
use crate::sources::Sources;
use crate::sparse;

/// A request whose clouds were read.
#[derive(Clone)]
pub struct Opened {
    /// The request.
    pub request: Request,
    /// The clouds of the request.
    pub sources: Sources,
}

impl Opened {
    /// Reads the clouds of a request.
    ///
    /// # Errors
    /// Returns an error if a file can't be read, or if the request contradicts itself.
    pub fn new(request: Request, messages: &dyn Messages, progress: &Progress) -> Result<Self> {
        check(&request, messages)?;
        let sources = Sources::open(&request.input, &request.scene, request.limits, messages, progress)?;
        Ok(Self { request, sources })
    }

    /// Returns the scene with the first `count` of its clouds alone.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        let mut first = self.clone();
        first.request.scene.clouds.truncate(count);
        first.sources.truncate(count);
        first
    }

    /// Makes points of the clouds, and finds the camera of the scene.
    ///
    /// # Errors
    /// Returns an error if no point is left, if a cloud lacks what the scene needs, or if the scene has no camera.
    pub fn prepare(self, messages: &dyn Messages, progress: &Progress) -> Result<Prepared> {
        self.prepare_by(|scene, points, up| find_camera(scene, points, up, messages), messages, progress)
    }

    /// Makes points of the clouds, and has the camera found for these and the clouds' vertical. `find` returns warnings
    /// as well.
    ///
    /// # Errors
    /// Returns the errors of [`Self::prepare`] and of `find`.
    pub fn prepare_by(
        self,
        find: impl FnOnce(&Scene, &Points, UpAxis) -> Result<(StatedCamera, Vec<String>)>,
        messages: &dyn Messages,
        progress: &Progress,
    ) -> Result<Prepared> {
        let Self { request, mut sources } = self;
        let (assembled, camera) = assemble(&request, &mut sources, find, messages, progress)?;
        let bounds = assembled.points().bounds();
        Ok(Prepared { request, assembled, camera, bounds, sources })
    }
}

/// Refuses a share of light for a method without opacity.
pub(crate) fn check(request: &Request, messages: &dyn Messages) -> Result<()> {
    let Some(SeeThrough { share, by: SeeThroughBy::Option }) = request.see_through else { return Ok(()) };
    see_through::refusal(request.scene.method).map_or(Ok(()), |reason| {
        Err(Error::Usage(format!("{}: {reason}", messages.option("see-through", &share))).into())
    })
}

/// Makes points of the clouds of a request, and has the camera found.
fn assemble(
    request: &Request,
    sources: &mut Sources,
    find: impl FnOnce(&Scene, &Points, UpAxis) -> Result<(StatedCamera, Vec<String>)>,
    messages: &dyn Messages,
    progress: &Progress,
) -> Result<(Assembled, StatedCamera)> {
    let assembled = Assembled::new(sources, &request.scene, request.wanted, messages, progress)?;
    let (camera, warnings) = find(&assembled.scene, assembled.points(), assembled.up)?;
    messages.detail(&format_args!("[camera]\n{}", camera.to_toml().trim_end()));
    let odd = scene::odd_sizes(&assembled.scene, assembled.points());
    for warning in assembled.scene.warnings.iter().chain(&warnings).chain(&odd) {
        messages.warn(warning);
    }
    Ok((assembled, camera))
}

/// Finds the camera of a scene, and says what is to be known of it.
fn find_camera(
    scene: &Scene,
    points: &Points,
    up: UpAxis,
    messages: &dyn Messages,
) -> Result<(StatedCamera, Vec<String>)> {
    scene::camera_notes(scene, points, up).iter().for_each(|note| messages.note(note));
    Ok(scene::stated_camera(scene, points, up)?)
}

/// A request with its points and camera.
pub struct Prepared {
    /// The request.
    pub request: Request,
    /// The points on the host.
    pub assembled: Assembled,
    /// The camera, given or automatic: the one that pictures hold in their metadata.
    pub camera: StatedCamera,
    /// The box of all points.
    pub bounds: Option<Bounds>,
    /// The clouds.
    pub sources: Sources,
}

impl Prepared {
    /// Reads the clouds of a request, makes points of them, and finds the camera.
    ///
    /// # Errors
    /// Returns the errors of [`Opened::new`] and [`Opened::prepare`].
    pub fn new(request: Request, messages: &dyn Messages, progress: &Progress) -> Result<Self> {
        Opened::new(request, messages, progress)?.prepare(messages, progress)
    }

    /// Makes points again for another request of the same clouds, which stayed in memory.
    pub(crate) fn make_again(&mut self, request: Request, messages: &dyn Messages, progress: &Progress) -> Result<()> {
        let find = |scene: &Scene, points: &Points, up: UpAxis| find_camera(scene, points, up, messages);
        let (assembled, camera) = assemble(&request, &mut self.sources, find, messages, progress)?;
        self.bounds = assembled.points().bounds();
        (self.request, self.assembled, self.camera) = (request, assembled, camera);
        Ok(())
    }

    /// Returns the scene with what its clouds decide.
    pub fn scene(&self) -> &Scene {
        &self.assembled.scene
    }

    /// Returns all points, or a sample of those that stay in files.
    pub fn points(&self) -> &Points {
        self.assembled.points()
    }

    /// Returns the share of the light that is to get through.
    pub fn see_through(&self) -> Option<f64> {
        self.request.see_through?.share(self.assembled.scene.method, self.assembled.is_classified)
    }

    /// Returns the factor on the radii with which the discs of a sparse cloud stay apart in a picture that is to be
    /// seen through; 1 of other clouds and pictures, of scene files, and where anything is said of radii.
    pub fn radius_factor(&self) -> f32 {
        let names_clouds = self.assembled.scene.names_clouds;
        if self.see_through().is_none() || !names_clouds || !self.assembled.has_estimated_radii() {
            return 1.0;
        }
        sparse::radius_factor(self.points(), &self.camera, self.assembled.scene.image.size[1])
    }

    /// Returns the limits by which the method is chosen, if they are meaningful for the scene's method.
    pub fn wish(&self) -> Option<Wish> {
        let wish = Some(self.request.choice.wish).filter(Wish::is_any)?;
        Wish::hindrance(&self.assembled.scene, self.points()).is_none().then_some(wish)
    }

    /// Returns the frame of a request, whose method and opacity are still those of the scene.
    pub fn frame(&self) -> Frame {
        let (request, scene) = (&self.request.frame, &self.assembled.scene);
        Frame {
            memory_budget: request.memory_budget,
            fragments: request.counts,
            // An error is measured of every bit.
            stop: if self.wish().is_some() { Stop::Exact } else { request.stop },
            factors: Factors { radius: self.radius_factor() * request.factors.radius, ..request.factors },
            max_error: request.max_error,
            spread: request.spread,
            detail: request.detail.unwrap_or(scene.detail),
            ..Frame::of_scene(scene, self.camera.camera(), self.request.wanted.seed)
        }
    }

    /// Returns the metadata of an image by a method on a device.
    pub fn metadata(&self, method: &str, device: &str) -> Vec<(String, String)> {
        let Scene { settings, image, .. } = &self.assembled.scene;
        let mut tags = output::tags(&self.request.name, method, settings, device, self.request.wanted.seed);
        if self.request.scene.image.background == Background::Auto {
            let name = if image.background.color() == Vec3::ONE { "white" } else { "black" };
            tags.push(("pellucid:background".to_owned(), name.to_owned()));
        }
        tags
    }

    /// Returns the metadata that holds the camera of an image.
    pub fn camera_metadata(&self) -> (String, String) {
        (output::CAMERA_TAG.to_owned(), self.camera.to_toml())
    }

    /// Says how much was read of clouds that stay in their files.
    pub fn described_reads(&self) -> Option<String> {
        let [read, all] = self.assembled.stored()?.bytes_read();
        let share = 100.0 * read as f64 / all.max(1) as f64;
        Some(format!("{} of {} were read for the picture ({share:.1} %)", ByteSize(read), ByteSize(all)))
    }
}
