//! The points of a scene on the device, and which of them must be uploaded again when the scene changes.

use pellucid_engine::progress::Progress;

use super::navigate::Subject;
use super::stage::no_points;
use super::thinned::ThinnedCloud;
use pellucid_engine::Result;
use pellucid_engine::cloud::Cloud;
use pellucid_engine::io::{self, LasColumns};
use pellucid_engine::methods::Renderer;
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::Changes;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::tracked::{self, DerivedColumns, Tracked};
use pellucid_engine::scene::{self, Light, Scene, Shadows};

/// The clouds as they were read, and data derived from them.
pub struct Sources {
    clouds: Vec<Cloud>,
    derived: Vec<DerivedColumns>,
    /// Columns of each cloud's file that were asked for once it had been read.
    asked: Vec<LasColumns>,
    seed: u64,
}

impl Sources {
    pub fn new(clouds: Vec<Cloud>, seed: u64) -> Self {
        let derived = clouds.iter().map(|_| DerivedColumns::default()).collect();
        let asked = vec![LasColumns::default(); clouds.len()];
        Self { clouds, derived, asked, seed }
    }

    /// Reads files again that may have columns which the scene needs and which were not asked for before.
    ///
    /// # Errors
    /// A file that can't be read any more.
    pub fn complete(&mut self, scene: &Scene, progress: &Progress) -> Result<()> {
        for ((settings, cloud), asked) in scene.clouds.iter().zip(&mut self.clouds).zip(&mut self.asked) {
            let all = settings.hints().las.and(*asked);
            if all == *asked || all.lacking(cloud) == LasColumns::default() {
                continue;
            }
            progress.reset();
            progress.set_message(format!("reading {}", settings.path.display()));
            match io::load_with(&settings.path, io::Hints { las: all, ..settings.hints() }, progress) {
                Ok(found) if found.len() == cloud.len() => cloud.scalars = found.scalars,
                // A built-in cloud has no file, and one that changed meanwhile is another cloud.
                Ok(_) | Err(io::Error::Missing { .. }) => {}
                Err(error) => return Err(error.into()),
            }
            *asked = all;
        }
        Ok(())
    }

    /// The clouds.
    pub fn clouds(&self) -> &[Cloud] {
        &self.clouds
    }

    /// The clouds, when everything else goes.
    pub fn into_clouds(self) -> Vec<Cloud> {
        self.clouds
    }

    /// What the colors of the scene mean whose points were last asked for.
    ///
    /// # Errors
    /// A cloud lacks what its colors are to show.
    pub fn legend(&self, scene: &Scene) -> Result<Legend> {
        Ok(tracked::legend(scene, &self.clouds, &self.derived)?)
    }

    /// The seed of stochastic methods.
    pub fn seed(&self) -> u64 {
        self.seed
    }
}

/// The settings that decide if shadows stored with a cloud fit a scene, while its points stay in place.
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
    pub thinned: Option<ThinnedCloud>,
    /// Their box, largest radius and vertical.
    pub subject: Subject,
    /// Changes that have not reached the device because an upload was stopped or failed for lack of memory.
    pending: Changes,
    /// The lighting for which stored shadows were last checked, if those on the device are not out of date.
    lighting: Option<Lighting>,
}

impl Placed {
    /// Brings the points of a scene to the device.
    ///
    /// # Errors
    /// No point is left, a cloud lacks what its field is made of, or the device has no room.
    pub fn new(renderer: &Renderer, sources: &mut Sources, scene: &Scene, progress: &Progress) -> Result<Self> {
        let Sources { clouds, derived, seed, .. } = sources;
        let arranged = Tracked::new(scene, clouds, derived, *seed, progress)?;
        let (texture, _) = scene::shadow_texture(scene, clouds, *seed);
        let Some(bounds) = arranged.points().bounds() else { return Err(no_points()) };
        let subject = Subject { bounds, radius: arranged.points().largest_radius(), up: scene::up_axis(clouds) };
        progress.set_message("uploading points");
        let cloud = renderer.upload_lit(arranged.arranged(), texture.as_ref())?;
        Ok(Self {
            arranged,
            cloud,
            thinned: None,
            subject,
            pending: Changes::default(),
            lighting: Some(lighting(scene)),
        })
    }

    /// Turns these points into those of another scene of the same clouds. Returns the changes since the last success,
    /// or `None`, with everything unchanged, if points move and must be arranged again.
    ///
    /// # Errors
    /// A cloud lacks the columns of its field: nothing changes. The device failed or was stopped: the next call uploads
    /// the rest.
    pub fn follow(
        &mut self,
        renderer: &Renderer,
        sources: &mut Sources,
        scene: &Scene,
        progress: &Progress,
    ) -> Result<Option<Changes>> {
        let Sources { clouds, derived, seed, .. } = sources;
        self.cloud.let_go();
        let followed = self.arranged.follow(scene, clouds, derived, progress);
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
            self.thinned = None;
        }
        if changes.radii || changes.unseen {
            self.subject.radius = self.arranged.points().largest_radius();
        }
        if changes.order {
            self.lighting = None;
        }
    }
}
