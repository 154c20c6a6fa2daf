//! Points to the device, in whichever order they are.

use super::{Error, Renderer};
use crate::cloud::shadow_texture::ShadowTexture;
use crate::passes::compose::Cut;
use crate::passes::project::DeviceCloud;
use crate::prepare::{Arranged, Supplied};
use crate::scene::Detail;

impl Renderer {
    /// Uploads points as [`Renderer::upload`] does, or, if they were dealt, with their clouds.
    ///
    /// # Errors
    /// More points than the device can address, or no memory for them.
    pub fn upload_arranged(&self, arranged: &Arranged) -> Result<DeviceCloud, Error> {
        match arranged {
            Arranged::Canonical(points) if points.len() as u64 > Cut::most(&self.device) => self.supply_held(points),
            Arranged::Canonical(points) => self.upload(points),
            Arranged::Dealt(dealt) => self.upload_dealt(dealt),
            Arranged::Supplied(Supplied { sample, dealt: Some(file), .. }) => self.upload_dealt_file(sample, file),
            Arranged::Supplied(Supplied { sample, supply, .. }) => self.supply(sample, supply),
        }
    }

    /// Like [`Renderer::upload_arranged`], with the shadows that were stored with the points, in the order of their
    /// files.
    ///
    /// # Errors
    /// More points than the device can address, or no memory for them.
    pub fn upload_lit(&self, arranged: &Arranged, texture: Option<&ShadowTexture>) -> Result<DeviceCloud, Error> {
        let mut cloud = self.upload_arranged(arranged)?;
        if let Some(texture) = texture {
            self.put_lit(&mut cloud, arranged, texture)?;
        }
        Ok(cloud)
    }

    /// Like [`Renderer::upload_lit`], for frames with this detail: where they leave points out, those in memory come some at a time.
    ///
    /// # Errors
    /// No memory for them.
    pub fn upload_for(
        &self,
        detail: &Detail,
        arranged: &Arranged,
        texture: Option<&ShadowTexture>,
    ) -> Result<DeviceCloud, Error> {
        match arranged {
            Arranged::Canonical(points) if !detail.is_whole() => self.supply_held(points),
            _ => self.upload_lit(arranged, texture),
        }
    }

    /// Gives a cloud, uploaded from `arranged`, the shadows that were stored with its points, in the order of their
    /// files. Dealt points accept none.
    ///
    /// # Errors
    /// No memory for them.
    pub fn put_lit(&self, cloud: &mut DeviceCloud, arranged: &Arranged, texture: &ShadowTexture) -> Result<(), Error> {
        if let Arranged::Canonical(points) = arranged {
            let place = |i: usize| points.file_order.get(i).map_or(i, |place| *place as usize);
            let lit = |i: usize| texture.lit.get(place(i)).copied().unwrap_or(1.0);
            cloud.put_lit(&self.device, points, texture.casting, lit)?;
        }
        Ok(())
    }
}
