//! Shape of work that fits a device. It is decided here alone, by what a device says of itself and never by its name.

use ash::vk;

/// The shapes of work that a device prefers. Images have the same bytes whatever they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preferences {
    /// The number of sequential pieces that work is cut into to occupy the device: few on CPUs, where more only cost.
    pub concurrent_runs: u64,
    /// `true` if the invocations of a workgroup go through neighboring words together and share sums, so that a GPU
    /// reads whole stretches of memory; false if each goes through words of its own, as the threads of a CPU should.
    pub shared_work: bool,
    /// Splats of at most so many pixels are walked by one invocation each, larger ones tile by tile. The invocations of
    /// a GPU's subgroup wait for the largest splat among theirs; on a CPU tiles only cost.
    pub small_area: u32,
    /// `true` if the host writes into the device's memory by itself where it can: on a CPU driver, which would copy
    /// with one core what all cores can write at once.
    pub host_writes: bool,
    /// `true` if the tiles' lists of ordered splats come from a stable sort of pairs of tile and splat, of which a GPU
    /// moves thousands at once; false if each subgroup takes a run of splats one by one, which needs no further memory.
    pub tile_pairs: bool,
    /// `true` if the invocations of a workgroup share the pixels of its squares in `spbr`, and each goes through few
    /// points; false if each walks the squares of its own points, one after another.
    pub spread_squares: bool,
    /// `true` if buffers may be larger than maxMemoryAllocationSize, up to maxBufferSize. Vulkan lets such allocations
    /// succeed or fail; drivers of GPUs with much memory name 4 GiB and give more. A CPU driver has what it promises.
    pub large_allocations: bool,
}

impl Preferences {
    /// Preferences of drivers that run on a CPU.
    pub const CPU: Self = Self {
        concurrent_runs: 32,
        shared_work: false,
        small_area: 1024,
        host_writes: true,
        tile_pairs: false,
        spread_squares: false,
        large_allocations: false,
    };
    /// Preferences of GPUs.
    pub const GPU: Self = Self {
        concurrent_runs: 4096,
        shared_work: true,
        small_area: 64,
        host_writes: false,
        tile_pairs: true,
        spread_squares: true,
        large_allocations: true,
    };

    pub(super) fn of(device_type: vk::PhysicalDeviceType) -> Self {
        if device_type == vk::PhysicalDeviceType::CPU { Self::CPU } else { Self::GPU }
    }

    /// Returns what `PELLUCID_PREFER` asks for: `cpu` or `gpu`.
    pub(super) fn from_env() -> Option<Self> {
        match std::env::var("PELLUCID_PREFER").as_deref() {
            Ok("cpu") => Some(Self::CPU),
            Ok("gpu") => Some(Self::GPU),
            _ => None,
        }
    }
}
