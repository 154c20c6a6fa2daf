//! Points to the device, in whichever order they are.

use std::sync::Arc;

use super::{Error, Renderer};
use crate::cloud::shadow_texture::ShadowTexture;
use crate::passes::compose::Cut;
use crate::passes::project::DeviceCloud;
use crate::points::Points;
use crate::prepare::dealt_file::DealtFile;
use crate::prepare::ensembles::Dealt;
use crate::prepare::{Arranged, Supplied};
use crate::scene::Detail;

impl Renderer {
    /// Uploads a scene's points.
    pub fn upload(&self, points: &Points) -> Result<DeviceCloud, Error> {
        Cut::new(&self.device, points.len() as u64)?;
        Ok(DeviceCloud::new(&self.device, points)?)
    }

    /// Takes points that were dealt: for `spbr` and `spbr-simplified`, but any method may render them. They go to the
    /// device with the first frame; points that don't fit
    /// [`Frame::memory_budget`](crate::methods::Frame::memory_budget) go through it while a frame of these methods is
    /// rendered. The list stays in the host's memory.
    pub fn upload_dealt(&self, dealt: &Dealt) -> Result<DeviceCloud, Error> {
        check_dealt(dealt.points.len() as u64)?;
        Ok(DeviceCloud::of_dealt(&self.device, dealt)?)
    }

    /// Takes points that were dealt into a file, where they stay; `sample` stands for them, with what is known of all.
    ///
    /// # Errors
    /// More points than an index tells apart, or no memory for small buffers.
    pub fn upload_dealt_file(&self, sample: &Points, file: &Arc<DealtFile>) -> Result<DeviceCloud, Error> {
        check_dealt(file.len())?;
        Ok(DeviceCloud::of_dealt_file(&self.device, sample, file)?)
    }

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

    /// Like [`Renderer::upload_lit`], for frames with this detail: where they leave points out, those in memory come
    /// some at a time.
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

/// Refuses more points than an index tells apart: it has 32 bits, and all ones marks none of them.
fn check_dealt(points: u64) -> Result<(), Error> {
    let limit = u64::from(u32::MAX);
    if points > limit { Err(Error::TooManyPoints { points, limit }) } else { Ok(()) }
}
