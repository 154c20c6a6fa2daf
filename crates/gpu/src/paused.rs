//! Recordings that are interrupted. What they were given may be dropped meanwhile: it is destroyed once no recording is
//! left that may hold it.

use std::sync::Arc;

use ash::vk::{self, Handle};

use super::context::lock;
use super::deletions::Deletion;
use super::{Context, Recorder};

/// A recording that goes on later.
pub struct Paused(Recorder<'static>);

impl Paused {
    /// Goes on.
    pub fn resume<'a>(self) -> Recorder<'a> {
        self.0
    }
}

impl Recorder<'_> {
    /// Interrupts the recording. From here on until it is submitted or dropped, what is dropped on this device is
    /// destroyed later.
    pub fn pause(mut self) -> Paused {
        if self.held.is_none() {
            self.held = Some(DeletionHold::new(self.context()));
        }
        // SAFETY: the lifetime only says that what was recorded outlives the recording, which `held` sees to.
        Paused(unsafe { std::mem::transmute::<Recorder<'_>, Recorder<'static>>(self) })
    }
}

/// While there is one, nothing is destroyed.
pub struct DeletionHold(Arc<Context>);

impl DeletionHold {
    fn new(context: &Arc<Context>) -> Self {
        lock(&context.deletions).recordings += 1;
        Self(context.clone())
    }
}

impl Drop for DeletionHold {
    fn drop(&mut self) {
        let mut deletions = lock(&self.0.deletions);
        deletions.recordings -= 1;
        if deletions.recordings > 0 {
            return;
        }
        let waiting = std::mem::take(&mut deletions.waiting);
        drop(deletions);
        for deletion in waiting {
            self.0.destroy(deletion);
        }
    }
}

impl Context {
    /// Destroys what nobody but an interrupted recording may need, as soon as there is none.
    pub fn delete(&self, deletion: Deletion) {
        let mut deletions = lock(&self.deletions);
        if deletions.recordings > 0 {
            deletions.waiting.push(deletion);
        } else {
            drop(deletions);
            self.destroy(deletion);
        }
    }

    fn destroy(&self, deletion: Deletion) {
        // SAFETY: whoever owned the handles gave them up. Submissions are waited for before their recorders are
        // dropped, and no interrupted recording is left; so the device no longer uses them. A null view is ignored.
        let allocation = unsafe {
            match deletion {
                Deletion::Buffer(raw, allocation) => {
                    self.forget_allocation((vk::Buffer::TYPE, raw.as_raw()));
                    self.device.destroy_buffer(raw, None);
                    allocation
                }
                Deletion::Image(raw, view, allocation) => {
                    self.forget_allocation((vk::Image::TYPE, raw.as_raw()));
                    self.device.destroy_image_view(view, None);
                    self.device.destroy_image(raw, None);
                    allocation
                }
            }
        };
        if let Some(allocation) = allocation {
            // Freeing what this allocator gave out cannot fail.
            let _ = self.with_allocator(|allocator| allocator.free(allocation));
        }
    }
}
