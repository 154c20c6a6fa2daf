//! Options, features and limits of devices.

use std::ffi::CStr;

use ash::vk;

use super::{MemoryBudget, Preferences};

/// Options for opening a device.
#[derive(Debug, Clone, Default)]
pub struct DeviceOptions {
    /// Part of a device's name (case does not matter) or its index; the best one if `None`.
    pub device: Option<String>,
    /// Switch validation and synchronization validation on.
    pub validation: bool,
    /// Validate memory accesses of shaders instead of synchronization: slow.
    pub gpu_assisted: bool,
    /// Keep accesses of shaders within what is bound, as far as the device can: robustBufferAccess, robustImageAccess,
    /// robustBufferAccess2 and robustImageAccess2.
    pub robust: bool,
    /// Bind no more bytes at a time than this, even if the device allows more: shows on any device how work is cut.
    pub binding_bytes: Option<u64>,
    /// Take this for the device's maxMemoryAllocationSize if it is lower: shows on any device what becomes of larger
    /// buffers.
    pub allocation_bytes: Option<u64>,
    /// Shape work like this, whatever the device prefers: shows on any device what another one does.
    pub prefers: Option<Preferences>,
    /// Have the driver keep what it finds out about each pipeline, as far as it can:
    /// [`Shader::compiled`](super::shader::Shader::compiled).
    pub statistics: bool,
    /// Keep names and WGSL source in the shaders, for debuggers such as RenderDoc and Nsight. Changes no result.
    pub debug_shaders: bool,
}

impl DeviceOptions {
    /// Returns the best device. With the environment variable `PELLUCID_VALIDATION` at `1` validation and robust access
    /// are on, at `gpu` GPU-assisted validation is. `PELLUCID_PREFER` at `cpu` or `gpu` shapes work as for one of
    /// these.
    pub fn from_env() -> Self {
        let prefers = Preferences::from_env();
        match std::env::var("PELLUCID_VALIDATION").as_deref() {
            Ok("1") => Self { validation: true, robust: true, prefers, ..Self::default() },
            // Robust access would silently correct wrong indices, which this validation should report.
            Ok("gpu") => Self { validation: true, gpu_assisted: true, prefers, ..Self::default() },
            _ => Self { prefers, ..Self::default() },
        }
    }

    /// Like [`Self::from_env`], but with validation and robust access unless the environment asks for another kind: for
    /// tests.
    pub fn validated() -> Self {
        let asked = Self::from_env();
        if asked.validation { asked } else { Self { validation: true, robust: true, ..asked } }
    }
}

/// Limits that decide how work is cut.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Bytes that one storage-buffer binding may cover.
    pub binding_bytes: u64,
    /// The device's own limit of that, with the guard of debug builds: [`Self::binding_bytes`] may be lower.
    pub(super) range_bytes: u64,
    /// Bytes of one allocation that the device promises (maxMemoryAllocationSize). A larger one may fail.
    pub allocation_bytes: u64,
    /// Bytes of one buffer: [`Self::allocation_bytes`], or more on devices where larger allocations are tried
    /// ([`Preferences::large_allocations`]).
    pub buffer_bytes: u64,
    /// Alignment of a storage-buffer binding's offset.
    pub offset_alignment: u64,
    /// Workgroups in x of one dispatch.
    pub groups_x: u32,
    /// Bytes of memory that a workgroup may share.
    pub shared_bytes: u32,
    /// Bytes of the largest device-local heap.
    pub heap_bytes: u64,
    /// Storage buffers that one stage may see.
    pub storage_buffers: u32,
    /// Largest width and height of a framebuffer.
    pub framebuffer: [u32; 2],
}

/// A device as `pellucid devices` lists it.
#[derive(Debug, Clone)]
pub struct DeviceInfo {
    /// Position in Vulkan's list.
    pub index: usize,
    /// The device's name.
    pub name: String,
    /// The driver's name and version.
    pub driver: String,
    /// Discrete, integrated, virtual, CPU, other.
    pub kind: &'static str,
    /// Required features and limits that are missing; empty if the device can be used.
    pub lacks: Vec<String>,
    /// Nanoseconds of one tick of a timestamp.
    pub timestamp_period_ns: f64,
    /// Optional: 64-bit integers with atomic minimum in storage buffers.
    pub int64_atomics: bool,
    /// Optional: storage writes and atomics in fragment shaders, so that the rasterizer can be used.
    pub fragment_atomics: bool,
    /// Optional: largest width and height of attachments with 4 samples per pixel, and of those that blend floats.
    pub multisampled: Option<[u32; 2]>,
    /// Optional: counts of shader invocations.
    pub pipeline_statistics: bool,
    /// Optional: invocations of the subgroups of compute shaders, 8 to 32, if ballots and shuffles work in them and
    /// their size is known beforehand.
    pub subgroup: Option<u32>,
    /// Optional: commands that the device leaves out by a word that it finds itself (`VK_EXT_conditional_rendering`).
    pub conditional: bool,
    /// Bytes of the largest heap of its own memory.
    pub heap_bytes: u64,
    /// Memory that was free when the device was listed; `None` where the driver doesn't tell (VK_EXT_memory_budget).
    pub memory: Option<MemoryBudget>,
    /// The shapes of work that it prefers.
    pub prefers: Preferences,
    pub(super) rank: u32,
}

impl DeviceInfo {
    /// Returns `true` if the driver runs on the CPU, whose cores other programs use as well.
    pub fn is_cpu(&self) -> bool {
        self.kind == "CPU"
    }
}

/// Returns the index of a queue family for compute and graphics with timestamps.
pub(super) fn queue_family(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: a plain query on a live instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let wanted = vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS;
    families
        .iter()
        .position(|f| f.queue_flags.contains(wanted) && f.timestamp_valid_bits > 0)
        .and_then(|i| u32::try_from(i).ok())
}

/// Returns `true` if the device has the extension of this name.
pub(super) fn has_extension(instance: &ash::Instance, physical: vk::PhysicalDevice, name: &CStr) -> bool {
    // SAFETY: a plain query on a live instance.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
}

/// Returns features of a device; none of those of an extension that it lacks.
pub(super) fn features<F: vk::ExtendsPhysicalDeviceFeatures2 + Default>(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    extension: Option<&CStr>,
) -> F {
    let mut found = F::default();
    if extension.is_none_or(|name| has_extension(instance, physical, name)) {
        let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut found);
        // SAFETY: a plain query on a live instance; the struct is only asked for where its extension is present.
        unsafe { instance.get_physical_device_features2(physical, &mut all) };
    }
    found
}
