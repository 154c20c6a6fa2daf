//! Memory of a device that is free now (VK_EXT_memory_budget): other programs use it, too.

use ash::{ext, vk};

use super::instance::Instance;
use super::limits::has_extension;

/// Memory of the largest heap of a device, as its driver estimates it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryBudget {
    /// Bytes that this process may use in all before allocations fail or become slow.
    pub budget: u64,
    /// Bytes that it uses, those of the driver for it among them.
    pub used: u64,
}

impl MemoryBudget {
    /// Returns the bytes that it may use in addition.
    pub fn free(self) -> u64 {
        self.budget.saturating_sub(self.used)
    }
}

/// Returns the index and the bytes of the largest heap of the device's own memory; `None` if it has none.
pub(super) fn largest_heap(memory: &vk::PhysicalDeviceMemoryProperties) -> Option<(usize, u64)> {
    let own = |(_, heap): &(usize, &vk::MemoryHeap)| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
    let sizes = memory.memory_heaps_as_slice().iter().enumerate().filter(own).map(|(index, heap)| (index, heap.size));
    // The first of equals.
    sizes.rev().max_by_key(|(_, size)| *size)
}

/// Asks how much of the largest heap may be used; `None` where the driver doesn't tell.
pub(super) fn budget(instance: &Instance, physical: vk::PhysicalDevice) -> Option<MemoryBudget> {
    if !has_extension(&instance.raw, physical, ext::memory_budget::NAME) {
        return None;
    }
    // SAFETY: a plain query on a live instance.
    let plain = unsafe { instance.raw.get_physical_device_memory_properties(physical) };
    // RADV of Mesa 22.3 crashes when asked of an integrated GPU that is not there, which has no memory.
    largest_heap(&plain).filter(|(_, bytes)| *bytes > 0)?;
    let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
    let mut properties = vk::PhysicalDeviceMemoryProperties2::default().push_next(&mut budget);
    // SAFETY: a plain query on a live instance; the device has the extension, which a query of the device as such
    // does not need to be enabled.
    unsafe { instance.raw.get_physical_device_memory_properties2(physical, &mut properties) };
    let (heap, _) = largest_heap(&properties.memory_properties)?;
    Some(MemoryBudget { budget: budget.heap_budget[heap], used: budget.heap_usage[heap] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_free_is_what_the_budget_leaves_and_never_negative() {
        assert_eq!(MemoryBudget { budget: 100, used: 30 }.free(), 70);
        assert_eq!(MemoryBudget { budget: 100, used: 130 }.free(), 0);
    }

    #[test]
    fn the_largest_heap_is_one_of_the_device() {
        let mut memory = vk::PhysicalDeviceMemoryProperties { memory_heap_count: 4, ..Default::default() };
        let own = vk::MemoryHeapFlags::DEVICE_LOCAL;
        let heaps = [(900, vk::MemoryHeapFlags::empty()), (300, own), (700, own), (700, own)];
        for (heap, (size, flags)) in memory.memory_heaps.iter_mut().zip(heaps) {
            *heap = vk::MemoryHeap { size, flags };
        }
        assert_eq!(largest_heap(&memory), Some((2, 700)));
        memory.memory_heap_count = 1;
        assert_eq!(largest_heap(&memory), None);
    }
}
