//! Renderers whose buffers last while frames of several methods take turns.

use std::collections::BTreeMap;

use pellucid_engine::methods::{Error, Renderer};
use pellucid_gpu::Device;

/// One renderer for each method if memory allows, so that no method frees another's buffers; else one for all.
pub struct Renderers {
    device: Device,
    each: bool,
    by_name: BTreeMap<&'static str, Renderer>,
}

impl Renderers {
    /// Plans for methods with these peak bytes per frame.
    pub fn new(device: &Device, peaks: impl Iterator<Item = (&'static str, u64)>) -> Self {
        let mut most = BTreeMap::new();
        for (name, peak) in peaks {
            let greatest: &mut u64 = most.entry(name).or_default();
            *greatest = peak.max(*greatest);
        }
        let each = most.values().sum::<u64>() <= device.limits().heap_bytes / 2;
        Self { device: device.clone(), each, by_name: BTreeMap::new() }
    }

    /// The renderer of a method, created on first use.
    pub fn for_method(&mut self, name: &'static str) -> Result<&mut Renderer, Error> {
        let name = if self.each { name } else { "" };
        if !self.by_name.contains_key(name) {
            self.by_name.insert(name, Renderer::new(&self.device)?);
        }
        Ok(self.by_name.get_mut(name).expect("just made"))
    }
}
