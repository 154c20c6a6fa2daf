//! The points of a scene on the device, with fewer of them for coarser pictures.

use pellucid_engine::Result;
use pellucid_engine::methods::Renderer;
use pellucid_engine::points::{Changes, Points};
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::legend::Legend;
use pellucid_engine::scene::stored::Stored;
use pellucid_engine::scene::{Detail, Scene};
use pellucid_session::{Assembled, Silent, Sources, Uploaded, Wanted};

use super::navigate::Subject;
use super::stage::no_points;
use super::thinned::ThinnedCloud;

/// Points on the device.
pub struct Placed {
    /// The points on the host.
    pub assembled: Assembled,
    /// The points on the device.
    pub uploaded: Uploaded,
    /// A smaller number of the points, for coarser pictures.
    pub thinned: Option<ThinnedCloud>,
    /// The points' box, largest radius and vertical.
    pub subject: Subject,
}

impl Placed {
    /// Brings the points of a scene to the device.
    ///
    /// # Errors
    /// Returns an error if no point is left, if a cloud lacks the columns of its field, or if the device has no room.
    pub fn new(
        renderer: &Renderer,
        sources: &mut Sources,
        (scene, seed): (&Scene, u64),
        progress: &Progress,
    ) -> Result<Self> {
        let wanted = Wanted { seed, legend: false, radii: false, is_edited: true };
        let assembled = Assembled::new(sources, scene, wanted, &Silent, progress)?;
        progress.set_message("uploading points");
        let uploaded = Uploaded::new(renderer, &assembled, &Detail::default(), false)?;
        let Some(bounds) = assembled.points().bounds() else { return Err(no_points()) };
        let subject = Subject { bounds, radius: assembled.points().largest_radius(), up: assembled.up };
        Ok(Self { assembled, uploaded, thinned: None, subject })
    }

    /// Returns the points, or a sample of those that stay in files.
    pub fn points(&self) -> &Points {
        self.assembled.points()
    }

    /// Returns the scene in its files, if its clouds stay there.
    pub fn stored(&self) -> Option<&Stored> {
        self.assembled.stored()
    }

    /// Returns the legend of the scene that the points were last made for.
    ///
    /// # Errors
    /// Returns an error if a cloud lacks the columns that its colors are to show.
    pub fn legend(&self, scene: &Scene, sources: &Sources) -> Result<Legend> {
        self.assembled.legend_of(scene, sources)
    }

    /// Turns these points into those of another scene of the same clouds. Returns the changes since the last success,
    /// or `None` if points must be made again.
    ///
    /// # Errors
    /// Returns an error if a cloud lacks the columns of its field or colors: nothing changes. If the device failed or
    /// was stopped, the next call uploads the rest.
    pub fn follow(
        &mut self,
        renderer: &Renderer,
        sources: &mut Sources,
        (scene, seed): (&Scene, u64),
        progress: &Progress,
    ) -> Result<Option<Changes>> {
        let Self { assembled, uploaded, .. } = self;
        let Some(changes) = uploaded.follow(renderer, assembled, sources, (scene, seed), progress)? else {
            return Ok(None);
        };
        if changes.any() {
            self.thinned = None;
        }
        if changes.radii || changes.unseen {
            self.subject.radius = self.points().largest_radius();
        }
        Ok(Some(changes))
    }
}
