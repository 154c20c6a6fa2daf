//! A scene to the device: its points in whichever order they are, and a frame of it.

use super::{Error, Factors, Frame, Renderer, Stop};
use crate::camera::Camera;
use crate::cloud::shadow_texture::ShadowTexture;
use crate::passes::project::DeviceCloud;
use crate::prepare::Arranged;
use crate::scene::Scene;

impl Frame {
    /// A frame of a scene by a camera and a seed, to the last bit, with all memory that there is. In place of `auto` it has
    /// the A-buffer; [`crate::plan::choose`] says what is cheaper.
    pub fn of_scene(scene: &Scene, camera: Camera, seed: u64) -> Self {
        Self {
            camera,
            size: scene.image.size,
            shading: scene.shading,
            shadows: scene.shadows,
            color: scene.image.color,
            method: scene.method.representative(),
            memory_budget: None,
            fragments: false,
            stop: Stop::Exact,
            seed,
            max_error: None,
            spread: false,
            ensembles: None,
            factors: Factors::default(),
        }
    }
}

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

    /// As [`Renderer::upload_arranged`], with the shadows that were stored with the points, in the order of their files.
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

    /// Gives a cloud, uploaded from `arranged`, the shadows that were stored with its points, in the order of their files. Points
    /// that were dealt take none.
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
