//! The points of a scene on the device, and their way to those of a changed scene.

use pellucid_core::points::Changes;
use pellucid_core::progress::Progress;
use pellucid_engine::Result;
use pellucid_engine::methods::{self, Renderer, Upload};
use pellucid_engine::passes::project::DeviceCloud;
use pellucid_scene::{Detail, Lighting, Scene};

use crate::assembled::Assembled;
use crate::sources::Sources;

/// Points on the device.
pub struct Uploaded {
    /// The device's points.
    pub cloud: DeviceCloud,
    /// Changes that have not reached the device because an upload was stopped or failed for lack of memory.
    pending: Changes,
    /// Lighting for which stored shadows were last checked; `None` if those on the device are out of date.
    lighting: Option<Lighting>,
}

impl Uploaded {
    /// Brings points to the device, with the shadows that were stored with them. Frames of this detail may leave points
    /// out. With `by_windows` points in memory come to the device window by window.
    ///
    /// # Errors
    /// Returns an error if the device has no room for the points.
    pub fn new(renderer: &Renderer, assembled: &Assembled, detail: &Detail, by_windows: bool) -> Result<Self> {
        let by_windows = by_windows || !detail.is_whole();
        let shadows = assembled.shadow_texture.as_ref();
        let cloud = renderer.upload(Upload { by_windows, shadows, ..assembled.arranged().into() })?;
        Ok(Self { cloud, pending: Changes::default(), lighting: Some(Lighting::of(&assembled.scene)) })
    }

    /// Has the points come some at a time, if a detail is to leave some out.
    ///
    /// # Errors
    /// Returns an error if memory is exhausted.
    pub fn allow_detail(&mut self, renderer: &Renderer, assembled: &Assembled, detail: &Detail) -> Result<()> {
        if !detail.is_whole() && self.cloud.supply().is_none() {
            self.cloud = renderer.upload(Upload::with_detail(assembled.arranged(), detail))?;
        }
        Ok(())
    }

    /// Turns the points into those of another scene of the same clouds. Returns the changes since the last success, or
    /// `None` if points must be made again.
    ///
    /// # Errors
    /// Returns an error if a cloud lacks the columns of its field or colors: nothing changes. If the device failed or
    /// was stopped, the next call uploads the rest.
    pub fn follow(
        &mut self,
        renderer: &Renderer,
        assembled: &mut Assembled,
        sources: &mut Sources,
        (scene, seed): (&Scene, u64),
        progress: &Progress,
    ) -> Result<Option<Changes>> {
        self.cloud.let_go();
        let followed = assembled.follow(sources, scene, seed, progress);
        if let Ok(Some(changes)) = followed {
            self.note(changes);
        }
        let arranged = assembled.arranged();
        if self.cloud.supply().is_some() && self.pending.any() {
            // Points that come some at a time are those of the moment when they were brought.
            self.cloud = renderer.upload(Upload::with_detail(arranged, &scene.detail))?;
        } else {
            self.cloud.follow(renderer.device(), arranged, self.pending).map_err(methods::Error::from)?;
        }
        if followed?.is_none() {
            return Ok(None);
        }
        let lighting = Some(Lighting::of(scene));
        if self.lighting != lighting {
            // Other shadows are cast when a frame asks for them.
            if let Some(texture) = assembled.stored_shadows(sources, scene, seed) {
                self.cloud.put_lit(renderer.device(), arranged, &texture).map_err(methods::Error::from)?;
            }
            self.lighting = lighting;
        }
        Ok(Some(std::mem::take(&mut self.pending)))
    }

    /// Takes note of columns that changed on the host.
    fn note(&mut self, changes: Changes) {
        self.pending = self.pending.and(changes);
        if changes.order {
            self.lighting = None;
        }
    }
}
