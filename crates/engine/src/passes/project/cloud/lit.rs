//! Shares of light of the points on the device, which stand beside their normals.

use std::sync::Arc;

use super::{Column, DeviceCloud};
use crate::cloud::light_image::Holes;
use crate::cloud::shadow_texture::{Casting, ShadowTexture};
use crate::gpu::{Buffer, Device, Error, Memory};
use crate::prepare::Arranged;
use pellucid_core::parallel;

/// Light's view of all points of a cloud whose points come some at a time.
pub struct LightImages {
    /// The lights.
    pub casting: Casting,
    /// The bits of the depths of the surfaces in each image, image after image of each light.
    pub depths: Vec<Buffer<u32>>,
    /// Holes in those of the first light, if they were counted.
    pub holes: Option<Holes>,
}

impl DeviceCloud {
    /// Keeps the images of lights for points to come, or frees them.
    pub fn set_light_images(&mut self, images: Option<Arc<LightImages>>) {
        self.light_images = images;
    }

    /// Returns the images of lights.
    pub fn light_images(&self) -> Option<&Arc<LightImages>> {
        self.light_images.as_ref()
    }

    /// Returns the number of device bytes of the images of lights.
    pub fn light_bytes(&self) -> u64 {
        self.light_images.iter().flat_map(|images| &images.depths).map(Buffer::bytes).sum()
    }

    /// Returns `true` if shadows are cast already: points have their shares of light, or, if they come some at a time,
    /// images to find them in.
    pub fn has_cast(&self, casting: &Casting) -> bool {
        match &self.supplied {
            Some(_) => self.light_images.as_ref().is_some_and(|images| images.casting == *casting),
            None => self.casting.as_ref() == Some(casting),
        }
    }

    /// Room for shares of light, which clouds without normals have none for yet. What was there belongs to no light
    /// from here on.
    pub fn reserve_shares(&mut self, device: &Device) -> Result<(), Error> {
        (self.casting, self.light_holes) = (None, None);
        if self.normals.len() < self.len {
            self.normals = device.buffer("normals", self.len, Memory::Device)?;
        }
        Ok(())
    }

    /// Returns the shadows that the shares of light belong to; `None` if none were cast, or the shares were replaced.
    pub fn casting(&self) -> Option<&Casting> {
        self.casting.as_ref()
    }

    /// Sets the shadows that the shares of light belong to.
    pub fn set_casting(&mut self, casting: Casting) {
        self.casting = Some(casting);
    }

    /// Keeps the holes that were counted in the images of the first light.
    pub fn set_light_holes(&mut self, holes: Option<Holes>) {
        self.light_holes = holes;
    }

    /// Returns the holes in the images of the first light of the shadows that were cast last; `None` if they were not
    /// counted, as for shadows that were stored.
    pub fn light_holes(&self) -> Option<Holes> {
        match &self.light_images {
            Some(images) => images.holes,
            None => self.light_holes.filter(|_| self.casting.is_some()),
        }
    }

    /// Puts shares of light there that were stored with the points, in the order of their files. Points that were
    /// dealt, or come some at a time, take none.
    ///
    /// # Errors
    /// No memory for them.
    pub fn put_lit(&mut self, device: &Device, arranged: &Arranged, texture: &ShadowTexture) -> Result<(), Error> {
        let Arranged::Canonical(points) = arranged else { return Ok(()) };
        if self.supplied.is_some() {
            return Ok(());
        }
        self.reserve_shares(device)?;
        self.normals.upload_by(self.len, |range, to| {
            let place = |i: usize| points.file_order.get(i).map_or(i, |place| *place as usize);
            let lit = |i: usize| texture.lit.get(place(i)).copied().unwrap_or(1.0);
            parallel::for_each_mut(to, |i, to| {
                let [x, y, z, _] = Column::Normal.value(points, self.origin, range.start + i);
                *to = [x, y, z, lit(range.start + i)];
            });
        })?;
        self.set_casting(texture.casting);
        Ok(())
    }

    /// m of each point, the share of light that reaches it, in the order of the points that were uploaded; 1 without
    /// shadows.
    pub fn lit(&self) -> Result<Vec<f32>, Error> {
        match self.casting {
            Some(_) => Ok(self.normals.read(0, self.len)?.into_iter().map(|normal| normal[3]).collect()),
            None => Ok(vec![1.0; self.len as usize]),
        }
    }
}
