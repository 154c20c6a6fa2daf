//! Buffers that a family of methods has for itself.

use std::any::{Any, TypeId};
use std::collections::HashMap;

use super::Error;
use crate::gpu::Device;

/// Buffers of a family, kept from frame to frame.
pub(crate) trait FamilyBuffers: Any + Send + Sync + Sized {
    /// Allocates only the small buffers.
    ///
    /// # Errors
    /// Out of memory.
    fn made(device: &Device) -> Result<Self, Error>;
}

impl<T: Default + Any + Send + Sync> FamilyBuffers for T {
    fn made(_device: &Device) -> Result<Self, Error> {
        Ok(Self::default())
    }
}

/// Buffers by their type, made for the first frame that asks for them.
#[derive(Default)]
pub(crate) struct Own(HashMap<TypeId, Box<dyn Any + Send + Sync>>);

impl Own {
    /// Returns buffers, which are made unless they are there.
    ///
    /// # Errors
    /// Out of memory.
    pub fn of<T: FamilyBuffers>(&mut self, device: &Device) -> Result<&mut T, Error> {
        if self.there::<T>().is_none() {
            self.0.insert(TypeId::of::<T>(), Box::new(T::made(device)?));
        }
        let found = self.0.get_mut(&TypeId::of::<T>()).and_then(|buffers| buffers.downcast_mut());
        Ok(found.expect("made above"))
    }

    /// Returns buffers, if a frame asked for them before.
    pub fn there<T: FamilyBuffers>(&self) -> Option<&T> {
        self.0.get(&TypeId::of::<T>())?.downcast_ref()
    }
}
