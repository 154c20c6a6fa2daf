//! The points of a scene on the device, and what of them has to go there again when the scene is another.

use pellucid_engine::progress::Progress;

use super::navigate::Subject;
use super::stage::no_points;
use super::thin::Thin;
use pellucid_engine::Result;
use pellucid_engine::cloud::Cloud;
use pellucid_engine::methods::Renderer;
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::{Changes, Points};
use pellucid_engine::scene::tracked::{Known, Tracked};
use pellucid_engine::scene::{self, Light, Scene, Shadows};

/// The clouds as they were read, and what was found about them.
pub struct Sources {
    clouds: Vec<Cloud>,
    known: Vec<Known>,
    seed: u64,
}

impl Sources {
    pub fn new(clouds: Vec<Cloud>, seed: u64) -> Self {
        let known = clouds.iter().map(|_| Known::default()).collect();
        Self { clouds, known, seed }
    }

    /// The clouds.
    pub fn clouds(&self) -> &[Cloud] {
        &self.clouds
    }

    /// The clouds, when everything else goes.
    pub fn into_clouds(self) -> Vec<Cloud> {
        self.clouds
    }

    /// The seed of stochastic methods.
    pub fn seed(&self) -> u64 {
        self.seed
    }
}

/// What decides whether shadows that are stored with a cloud are those of a scene, while its points stay where they are.
type Lighting = (Light, Option<Shadows>);

fn lighting(scene: &Scene) -> Lighting {
    (scene.shading.light, scene.shadows)
}

/// Points on the device.
pub struct Placed {
    /// The same on the host.
    pub arranged: Tracked,
    /// The device's.
    pub cloud: DeviceCloud,
    /// Fewer of them, for coarser pictures.
    pub thin: Option<Thin>,
    /// Their box, largest radius and vertical.
    pub subject: Subject,
    /// What the device lacks since it was stopped, or had no room.
    pending: Changes,
    /// For which stored shadows were last looked at, if those that the device has are not out of date.
    lighting: Option<Lighting>,
}

impl Placed {
    /// Brings the points of a scene to the device.
    ///
    /// # Errors
    /// No point is left, a cloud lacks what its field is made of, or the device has no room.
    pub fn new(renderer: &Renderer, sources: &mut Sources, scene: &Scene, progress: &Progress) -> Result<Self> {
        let Sources { clouds, known, seed } = sources;
        let arranged = Tracked::new(scene, clouds, known, *seed, progress)?;
        let (texture, _) = scene::shadow_texture(scene, clouds, *seed);
        let Some(bounds) = arranged.points().bounds() else { return Err(no_points()) };
        let subject = Subject { bounds, radius: most_radius(arranged.points()), up: scene::up_axis(clouds) };
        progress.set_message("uploading points");
        let cloud = renderer.upload_lit(arranged.arranged(), texture.as_ref())?;
        Ok(Self { arranged, cloud, thin: None, subject, pending: Changes::default(), lighting: Some(lighting(scene)) })
    }

    /// Makes of them the points of another scene of the same clouds; what became another since this last went well. `None`, and all
    /// stays as it was, if those are elsewhere and must be arranged anew.
    ///
    /// # Errors
    /// A cloud lacks what its field is made of: all stays as it was. The device failed or was stopped: what it lacks is brought there
    /// next time.
    pub fn follow(
        &mut self,
        renderer: &Renderer,
        sources: &mut Sources,
        scene: &Scene,
        progress: &Progress,
    ) -> Result<Option<Changes>> {
        let Sources { clouds, known, seed } = sources;
        self.cloud.let_go();
        let followed = self.arranged.follow(scene, clouds, known, progress);
        if let Ok(Some(changes)) = followed {
            self.note(changes);
        }
        let arranged = self.arranged.arranged();
        self.cloud.follow(renderer.device(), arranged, self.pending).map_err(pellucid_engine::methods::Error::from)?;
        if followed?.is_none() {
            return Ok(None);
        }
        let lighting = Some(lighting(scene));
        if self.lighting != lighting {
            // Others are cast when a frame asks for them.
            if let (Some(texture), _) = scene::shadow_texture(scene, clouds, *seed) {
                renderer.put_lit(&mut self.cloud, arranged, &texture)?;
            }
            self.lighting = lighting;
        }
        Ok(Some(std::mem::take(&mut self.pending)))
    }

    /// Takes in what is another on the host.
    fn note(&mut self, changes: Changes) {
        self.pending = self.pending.and(changes);
        if changes.any() {
            self.thin = None;
        }
        if changes.radii {
            self.subject.radius = most_radius(self.arranged.points());
        }
        if changes.order {
            self.lighting = None;
        }
    }
}

fn most_radius(points: &Points) -> f64 {
    points.radii.iter().fold(0.0, |max: f64, r| max.max(f64::from(*r)))
}
