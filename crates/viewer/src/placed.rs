//! The points of a scene on the device, and which of them must be uploaded again when the scene changes.

use pellucid_engine::progress::Progress;

use super::navigate::Subject;
use super::sources::{self, Clouds};
use super::stage::no_points;
use super::thinned::ThinnedCloud;
use pellucid_engine::Result;
use pellucid_engine::cloud::UpAxis;
use pellucid_engine::io::{self, LasColumns};
use pellucid_engine::methods::Renderer;
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_engine::points::{Changes, Points};
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::stored::Stored;
use pellucid_engine::scene::tracked::{self, DerivedColumns, Tracked};
use pellucid_engine::scene::{self, Clip, CloudSettings, Light, Scene, ShadingModel, Shadows};

/// The clouds of a scene, and data derived from them.
pub struct Sources {
    clouds: Clouds,
    /// Of each cloud in memory.
    derived: Vec<DerivedColumns>,
    /// Columns of each cloud's file that were asked for once it had been read.
    asked: Vec<LasColumns>,
    seed: u64,
    /// Bytes that may keep nodes of clouds that are not in memory.
    memory: u64,
}

impl Sources {
    pub fn new(clouds: Clouds, seed: u64, memory: u64) -> Self {
        let (count, derived) = match &clouds {
            Clouds::Held(clouds) => (clouds.len(), clouds.iter().map(|_| DerivedColumns::default()).collect()),
            Clouds::Stored(stores) => (stores.len(), Vec::new()),
        };
        Self { clouds, derived, asked: vec![LasColumns::default(); count], seed, memory }
    }

    /// Reads files again that may have columns which the scene needs and which were not asked for before.
    ///
    /// # Errors
    /// A file that can't be read any more.
    pub fn complete(&mut self, scene: &Scene, progress: &Progress) -> Result<()> {
        let clouds = match &mut self.clouds {
            Clouds::Held(clouds) => clouds,
            Clouds::Stored(stores) => return sources::complete(stores, &mut self.asked, scene),
        };
        for ((settings, cloud), asked) in scene.clouds.iter().zip(clouds).zip(&mut self.asked) {
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
    pub fn clouds(&self) -> &Clouds {
        &self.clouds
    }

    /// The clouds, when everything else goes.
    pub fn into_clouds(self) -> Clouds {
        self.clouds
    }

    /// The seed of stochastic methods.
    pub fn seed(&self) -> u64 {
        self.seed
    }
}

/// Where the points on the device come from.
pub enum Origin {
    /// Memory, where they follow the scene.
    Held(Box<Tracked>),
    /// Stores, some at a time.
    Stored(Box<Stored>),
}

/// The settings that the points of stores depend on.
#[derive(PartialEq)]
struct Wanted {
    clouds: Vec<CloudSettings>,
    clips: Vec<Clip>,
    shading: ShadingModel,
    /// Radii, fields, and the order of ensembles.
    method: [bool; 3],
}

impl Wanted {
    fn by(scene: &Scene) -> Self {
        let method = scene.method;
        Self {
            clouds: scene.clouds.clone(),
            clips: scene.clips.clone(),
            shading: scene.shading.model,
            method: [method.needs_radii(), method.needs_field(), method.is_dealt()],
        }
    }
}

/// The settings that decide if shadows stored with a cloud fit a scene, while its points stay in place.
type Lighting = (Light, Option<Shadows>);

fn lighting(scene: &Scene) -> Lighting {
    (scene.shading.light, scene.shadows)
}

/// Points on the device.
pub struct Placed {
    /// Where they come from.
    pub origin: Origin,
    /// The settings that the points of stores were made for.
    wanted: Wanted,
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

impl Origin {
    /// The points, or some that stand for all.
    pub fn points(&self) -> &Points {
        match self {
            Self::Held(tracked) => tracked.points(),
            Self::Stored(stored) => stored.sample(),
        }
    }
}

impl Placed {
    /// Brings the points of a scene to the device.
    ///
    /// # Errors
    /// No point is left, a cloud lacks what its field is made of, or the device has no room.
    pub fn new(renderer: &Renderer, sources: &mut Sources, scene: &Scene, progress: &Progress) -> Result<Self> {
        let Sources { clouds, derived, seed, memory, .. } = sources;
        let stores = match clouds {
            Clouds::Held(clouds) => {
                let tracked = Tracked::new(scene, clouds, derived, *seed, progress)?;
                let (texture, _) = scene::shadow_texture(scene, clouds, *seed);
                progress.set_message("uploading points");
                let cloud = renderer.upload_lit(tracked.arranged(), texture.as_ref())?;
                return Self::with(Origin::Held(Box::new(tracked)), cloud, scene::up_axis(clouds), scene);
            }
            Clouds::Stored(stores) => stores,
        };
        let stored = Stored::new(scene, stores, *memory, progress)?;
        let arranged = match scene.method.is_dealt() {
            true => stored.dealt(*seed, &std::env::temp_dir(), progress)?,
            false => stored.arranged(),
        };
        let (cloud, up) = (renderer.upload_arranged(&arranged)?, stored.up());
        Self::with(Origin::Stored(Box::new(stored)), cloud, up, scene)
    }

    fn with(origin: Origin, cloud: DeviceCloud, up: UpAxis, scene: &Scene) -> Result<Self> {
        let Some(bounds) = origin.points().bounds() else { return Err(no_points()) };
        let subject = Subject { bounds, radius: origin.points().largest_radius(), up };
        Ok(Self {
            origin,
            wanted: Wanted::by(scene),
            cloud,
            thinned: None,
            subject,
            pending: Changes::default(),
            lighting: Some(lighting(scene)),
        })
    }

    /// The points, or some that stand for all.
    pub fn points(&self) -> &Points {
        self.origin.points()
    }

    /// The stored scene, if the points come from stores.
    pub fn stored(&self) -> Option<&Stored> {
        match &self.origin {
            Origin::Held(_) => None,
            Origin::Stored(stored) => Some(stored),
        }
    }

    /// The legend of the scene that the points were last made for.
    ///
    /// # Errors
    /// A cloud lacks what its colors are to show.
    pub fn legend(&self, scene: &Scene, sources: &Sources) -> Result<Legend> {
        match (&self.origin, &sources.clouds) {
            (Origin::Held(_), Clouds::Held(clouds)) => Ok(tracked::legend(scene, clouds, &sources.derived)?),
            (Origin::Stored(stored), _) => Ok(stored.legend().clone()),
            (Origin::Held(_), Clouds::Stored(_)) => Ok(Legend::default()),
        }
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
        let (Origin::Held(tracked), Clouds::Held(clouds)) = (&mut self.origin, clouds) else {
            return Ok((self.wanted == Wanted::by(scene)).then(Changes::default));
        };
        self.cloud.let_go();
        let followed = tracked.follow(scene, clouds, derived, progress);
        if let Ok(Some(changes)) = followed {
            self.note(changes);
        }
        let Origin::Held(tracked) = &self.origin else { return Ok(None) };
        let arranged = tracked.arranged();
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
            self.subject.radius = self.points().largest_radius();
        }
        if changes.order {
            self.lighting = None;
        }
    }
}
