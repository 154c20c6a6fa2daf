//! Points to the device in whichever order they are.

use super::{Error, Renderer};
use crate::passes::project::DeviceCloud;
use crate::points::Arranged;

impl Renderer {
    /// Uploads points as [`Renderer::upload`] does, or, if they were dealt, with their clouds.
    ///
    /// # Errors
    /// More points than the device can address, or no memory for them.
    pub fn upload_arranged(&self, arranged: &Arranged) -> Result<DeviceCloud, Error> {
        match arranged {
            Arranged::Canonical(points) => self.upload(points),
            Arranged::Dealt(dealt) => self.upload_dealt(dealt),
        }
    }
}
