//! The logical device with its queue, allocator and pipelines; everything made from it holds an `Arc` of it.

use std::collections::HashMap;
use std::ffi::CStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings, MemoryLocation};

use super::clock::{Calibrator, Clock};
use super::commands::Commands;
use super::deletions::Deletions;
use super::instance::Instance;
use super::limits::{DeviceInfo, DeviceOptions, Limits, features, has_extension, queue_family};
use super::memory::largest_heap;
use super::pipeline::{Compilation, Pipeline, PipelineKey};
use super::{Declaration, Error, Variant, cache, fault, guard, shader};

/// Bytes of one block of sub-allocated memory: small, so that the reserved peak stays near what is used.
const BLOCK_BYTES: u64 = 8 << 20;

/// The Vulkan device with its queue, its memory and its pipelines.
pub struct Context {
    /// Functions of the device.
    pub device: ash::Device,
    /// Device as the instance names it.
    pub physical: vk::PhysicalDevice,
    /// Family of the queue.
    pub queue_family: u32,
    /// Queue that takes all submissions.
    pub queue: vk::Queue,
    /// Facts about the device.
    pub info: DeviceInfo,
    /// Limits of the device.
    pub limits: Limits,
    /// Names and labels, with validation or a profiler.
    pub debug: Option<ext::debug_utils::Device>,
    /// There if the device can leave out commands.
    pub conditional: Option<ext::conditional_rendering::Device>,
    /// Counter of timestamps.
    pub clock: Clock,
    /// There if the device tells what its counter shows.
    pub calibrator: Option<Calibrator>,
    /// Pipelines of earlier runs.
    pub pipeline_cache: vk::PipelineCache,
    /// `true` if shaders keep their names and their source.
    pub debug_shaders: bool,
    /// There if the driver keeps what it finds out about pipelines.
    pub executables: Option<khr::pipeline_executable_properties::Device>,
    /// Instance that the device belongs to.
    pub instance: Instance,
    /// Held for every submission: a queue must not be used from two threads at once.
    pub submission: Mutex<()>,
    /// Command buffers that nobody records, each with what a recording takes besides.
    pub idle_commands: Mutex<Vec<Commands>>,
    /// Resources that interrupted recordings may still need.
    pub deletions: Mutex<Deletions>,
    allocator: Mutex<Option<Allocator>>,
    /// Names and sizes by kind and handle: handles of different kinds may be equal.
    live: Mutex<HashMap<(vk::ObjectType, u64), (String, u64)>>,
    /// Largest number of bytes of device memory that were allocated.
    pub peak: AtomicU64,
    /// Bytes of [`super::Buffer::upload`] so far.
    pub uploaded: AtomicU64,
    /// Submissions that the host has waited for so far.
    pub waits: AtomicU64,
    /// Submissions that may still be made.
    pub allowed: AtomicU64,
    /// All pipelines so far.
    pub pipelines: Mutex<HashMap<PipelineKey, Arc<Pipeline>>>,
    /// `true` for overrides that shaders have, of those that were asked for.
    overrides: Mutex<HashMap<OverrideKey, bool>>,
    /// Times at which each of them was made.
    pub compilations: Mutex<Vec<Compilation>>,
    cache_key: String,
}

/// Shader, the pieces that it takes, and the name of an override.
type OverrideKey = (&'static str, Option<&'static str>, Option<&'static str>, &'static str);

/// Locks a mutex, also after a panic of another thread.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Context {
    /// Creates the device of an instance.
    ///
    /// # Errors
    /// Vulkan errors.
    pub fn new(
        instance: Instance,
        physical: vk::PhysicalDevice,
        info: DeviceInfo,
        options: &DeviceOptions,
    ) -> Result<Self, Error> {
        let family = queue_family(&instance.raw, physical)
            .ok_or_else(|| Error::Lacks { device: info.name.clone(), missing: "a queue".to_owned() })?;
        let statistics = options.statistics && {
            let found: vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR<'_> =
                features(&instance.raw, physical, Some(khr::pipeline_executable_properties::NAME));
            found.pipeline_executable_info == vk::TRUE
        };
        let calibrated = Calibrator::extension(&instance, physical);
        let asked = Asked { robust: options.robust, statistics, calibrated };
        let device = create_device(&instance, physical, family, &info, asked)?;
        // SAFETY: the family and index are those the device was created with.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.clone(),
            physical_device: physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::new(BLOCK_BYTES, BLOCK_BYTES),
        })
        .map_err(|_| Error::OutOfMemory { name: "the allocator".to_owned(), bytes: 0, in_use: 0 })?;

        let (limits, cache_key) = limits(&instance, physical);
        // A pipeline that comes out of a cache may have lost what the driver found out about it.
        let kept = (!options.statistics).then(|| cache::load("pipelines", &cache_key)).flatten();
        let initial = kept.unwrap_or_default();
        let cache_info = vk::PipelineCacheCreateInfo::default().initial_data(&initial);
        // The cache of an earlier run is optional.
        let (filled, empty) = (cache_info, vk::PipelineCacheCreateInfo::default());
        // SAFETY: the data carry a checksum of ours and the driver checks its own header.
        let pipeline_cache = unsafe {
            device.create_pipeline_cache(&filled, None).or_else(|_| device.create_pipeline_cache(&empty, None))
        }
        .map_err(Error::call("vkCreatePipelineCache"))?;
        let executables = statistics.then(|| khr::pipeline_executable_properties::Device::new(&instance.raw, &device));
        let debug = instance.debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &device));
        let clock = Clock::of(&instance.raw, physical, family, info.timestamp_period_ns);
        let calibrator = calibrated.map(|extension| Calibrator::new(&instance, &device, extension));
        let conditional = info.conditional.then(|| ext::conditional_rendering::Device::new(&instance.raw, &device));
        Ok(Self {
            device,
            physical,
            queue_family: family,
            queue,
            info,
            limits,
            debug,
            conditional,
            clock,
            calibrator,
            debug_shaders: options.debug_shaders,
            pipeline_cache,
            executables,
            instance,
            submission: Mutex::new(()),
            idle_commands: Mutex::default(),
            deletions: Mutex::default(),
            allocator: Mutex::new(Some(allocator)),
            live: Mutex::default(),
            peak: AtomicU64::new(0),
            allowed: AtomicU64::new(u64::MAX),
            uploaded: AtomicU64::new(0),
            waits: AtomicU64::new(0),
            pipelines: Mutex::default(),
            overrides: Mutex::default(),
            compilations: Mutex::default(),
            cache_key,
        })
    }

    /// Runs `f` with the allocator and then notes the peak.
    pub fn with_allocator<R>(&self, f: impl FnOnce(&mut Allocator) -> R) -> Option<R> {
        let mut guard = lock(&self.allocator);
        let allocator = guard.as_mut()?;
        let result = f(allocator);
        self.peak.fetch_max(allocator.capacity(), Ordering::Relaxed);
        Some(result)
    }

    /// Returns the bytes of device memory that are allocated.
    pub fn in_use(&self) -> u64 {
        lock(&self.allocator).as_ref().map_or(0, Allocator::capacity)
    }

    /// Returns the error of an allocation of so many bytes that failed.
    pub fn out_of_memory(&self, name: &str, bytes: u64) -> Error {
        Error::OutOfMemory { name: name.to_owned(), bytes, in_use: self.in_use() }
    }

    /// Allocates memory for a buffer, or for an image, which is not linear. `bytes` are those that an error names.
    pub fn allocate(
        &self,
        name: &str,
        bytes: u64,
        requirements: vk::MemoryRequirements,
        (location, linear): (MemoryLocation, bool),
    ) -> Result<Allocation, Error> {
        fault::vulkan("allocate").map_err(|_| self.out_of_memory(name, bytes))?;
        let allocation_scheme = AllocationScheme::GpuAllocatorManaged;
        let wanted = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme };
        let allocated = self.with_allocator(|allocator| allocator.allocate(&wanted)).and_then(Result::ok);
        allocated.ok_or_else(|| self.out_of_memory(name, bytes))
    }

    /// Takes note of the allocation of a buffer or an image, and names this.
    pub fn note_allocation(&self, key: (vk::ObjectType, u64), name: &str, bytes: u64) {
        self.name_handle(key, name);
        lock(&self.live).insert(key, (name.to_owned(), bytes));
    }

    /// Takes note that an allocation is gone.
    pub fn forget_allocation(&self, key: (vk::ObjectType, u64)) {
        lock(&self.live).remove(&key);
    }

    /// Returns the name of an allocation; empty if it is gone.
    pub fn name_of(&self, key: (vk::ObjectType, u64)) -> String {
        lock(&self.live).get(&key).map_or_else(String::new, |(name, _)| name.clone())
    }

    /// Returns names and sizes of all allocations, by name.
    pub fn live_allocations(&self) -> Vec<(String, u64)> {
        let mut list: Vec<_> = lock(&self.live).values().cloned().collect();
        list.sort();
        list
    }

    /// Returns a command buffer to record, used again if one is idle.
    pub fn take_commands(&self) -> Result<Commands, Error> {
        if let Some(commands) = lock(&self.idle_commands).pop() {
            return Ok(commands);
        }
        let commands = Commands::new(&self.device, self.queue_family)?;
        self.name_object(commands.pool, "recordings");
        self.name_object(commands.buffer, "recording");
        self.name_object(commands.fence, "recording");
        Ok(commands)
    }

    /// Keeps a command buffer for the next recording. It must not be pending.
    pub fn give_commands_back(&self, mut commands: Commands) {
        // SAFETY: the caller has waited for the submission, or made none, and holds the only copy of these handles.
        unsafe {
            match commands.reset(&self.device) {
                Ok(()) => lock(&self.idle_commands).push(commands),
                Err(_) => commands.destroy(&self.device),
            }
        }
    }

    /// Returns `true` if the shader of a pass has an override of this name, with the pieces of a variant.
    pub fn has_override(&self, pass: &Declaration, variant: &Variant, name: &'static str) -> Result<bool, Error> {
        let key = (pass.shader, pass.piece, variant.walker, name);
        if let Some(has) = lock(&self.overrides).get(&key) {
            return Ok(*has);
        }
        let has = shader::has_override(pass, variant, name)?;
        lock(&self.overrides).insert(key, has);
        Ok(has)
    }

    /// Returns the pipeline of a key, built at its first use.
    pub fn pipeline(
        &self,
        key: PipelineKey,
        build: impl FnOnce() -> Result<Pipeline, Error>,
    ) -> Result<Arc<Pipeline>, Error> {
        if let Some(pipeline) = lock(&self.pipelines).get(&key) {
            return Ok(pipeline.clone());
        }
        let begin = Instant::now();
        let pipeline = Arc::new(build()?);
        self.name_pipeline(&pipeline);
        lock(&self.compilations).push(Compilation { begin, time: begin.elapsed() });
        lock(&self.pipelines).insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        for (name, bytes) in self.live_allocations() {
            eprintln!("warning: device memory leaked: {name}, {bytes} bytes");
        }
        // SAFETY: buffers and recorders hold an Arc of this context, so all are gone; the queue is idle after the wait.
        unsafe {
            // A lost device cannot be waited for; destroying is all that is left then.
            let _ = self.device.device_wait_idle();
            for (_, pipeline) in lock(&self.pipelines).drain() {
                pipeline.destroy(&self.device);
            }
            if let (Ok(data), None) = (self.device.get_pipeline_cache_data(self.pipeline_cache), &self.executables) {
                cache::store("pipelines", &self.cache_key, &data);
            }
            self.device.destroy_pipeline_cache(self.pipeline_cache, None);
            for commands in lock(&self.idle_commands).drain(..) {
                commands.destroy(&self.device);
            }
            drop(lock(&self.allocator).take());
            self.device.destroy_device(None);
        }
    }
}

/// Things that a device is made with where it has them.
struct Asked {
    robust: bool,
    statistics: bool,
    calibrated: Option<&'static CStr>,
}

fn create_device(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    family: u32,
    info: &DeviceInfo,
    Asked { robust, statistics, calibrated }: Asked,
) -> Result<ash::Device, Error> {
    let modern: vk::PhysicalDeviceVulkan13Features<'_> = features(&instance.raw, physical, None);
    let has_robustness2 = robust && has_extension(&instance.raw, physical, ext::robustness2::NAME);
    let found: vk::PhysicalDeviceRobustness2FeaturesEXT<'_> =
        features(&instance.raw, physical, Some(ext::robustness2::NAME));
    let mut robustness2 = vk::PhysicalDeviceRobustness2FeaturesEXT::default()
        .robust_buffer_access2(found.robust_buffer_access2 == vk::TRUE)
        .robust_image_access2(found.robust_image_access2 == vk::TRUE);
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&priorities)];
    let core = vk::PhysicalDeviceFeatures::default()
        .shader_int64(info.int64_atomics)
        // Every device has it.
        .robust_buffer_access(robust)
        .fragment_stores_and_atomics(info.fragment_atomics)
        .pipeline_statistics_query(info.pipeline_statistics);
    let mut features12 = vk::PhysicalDeviceVulkan12Features::default()
        .host_query_reset(true)
        .shader_buffer_int64_atomics(info.int64_atomics);
    let mut features13 = vk::PhysicalDeviceVulkan13Features::default()
        .synchronization2(true)
        .dynamic_rendering(true)
        .maintenance4(true)
        .robust_image_access(robust && modern.robust_image_access == vk::TRUE)
        .subgroup_size_control(info.subgroup.is_some())
        .compute_full_subgroups(info.subgroup.is_some());
    let mut extensions = Vec::new();
    extensions.extend(instance.surface.is_some().then_some(khr::swapchain::NAME.as_ptr()));
    extensions.extend(has_robustness2.then_some(ext::robustness2::NAME.as_ptr()));
    extensions.extend(statistics.then_some(khr::pipeline_executable_properties::NAME.as_ptr()));
    extensions.extend(calibrated.map(CStr::as_ptr));
    extensions.extend(info.conditional.then_some(ext::conditional_rendering::NAME.as_ptr()));
    // Vulkan wants it enabled wherever a device has it, as MoltenVK does. Its features stay off.
    let portability = has_extension(&instance.raw, physical, khr::portability_subset::NAME);
    extensions.extend(portability.then_some(khr::portability_subset::NAME.as_ptr()));
    let mut conditional = vk::PhysicalDeviceConditionalRenderingFeaturesEXT::default().conditional_rendering(true);
    let mut executables =
        vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default().pipeline_executable_info(true);
    let mut create = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&core)
        .push_next(&mut features12)
        .push_next(&mut features13);
    if statistics {
        create = create.push_next(&mut executables);
    }
    if info.conditional {
        create = create.push_next(&mut conditional);
    }
    if has_robustness2 {
        create = create.push_next(&mut robustness2);
    }
    // SAFETY: every feature was reported by this device, and the pointers live to the end of this function.
    unsafe { instance.raw.create_device(physical, &create, None) }.map_err(Error::call("vkCreateDevice"))
}

/// The limits, and a key that changes with the driver.
fn limits(instance: &Instance, physical: vk::PhysicalDevice) -> (Limits, String) {
    let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
    let mut maintenance4 = vk::PhysicalDeviceMaintenance4Properties::default();
    let mut properties =
        vk::PhysicalDeviceProperties2::default().push_next(&mut maintenance3).push_next(&mut maintenance4);
    // SAFETY: plain queries on a live instance.
    let memory = unsafe {
        instance.raw.get_physical_device_properties2(physical, &mut properties);
        instance.raw.get_physical_device_memory_properties(physical)
    };
    let basic = properties.properties;
    let heap_bytes = largest_heap(&memory).map_or(0, |(_, bytes)| bytes);
    let limits = Limits {
        binding_bytes: u64::from(basic.limits.max_storage_buffer_range),
        range_bytes: u64::from(basic.limits.max_storage_buffer_range),
        // The guard is part of each allocation and buffer.
        allocation_bytes: maintenance3
            .max_memory_allocation_size
            .min(maintenance4.max_buffer_size)
            .saturating_sub(guard::bytes()),
        // No allocation may be larger than its heap.
        buffer_bytes: maintenance4.max_buffer_size.min(heap_bytes).saturating_sub(guard::bytes()),
        offset_alignment: basic.limits.min_storage_buffer_offset_alignment.max(16),
        groups_x: basic.limits.max_compute_work_group_count[0],
        shared_bytes: basic.limits.max_compute_shared_memory_size,
        heap_bytes,
        storage_buffers: basic.limits.max_per_stage_descriptor_storage_buffers,
        framebuffer: [basic.limits.max_framebuffer_width, basic.limits.max_framebuffer_height],
    };
    let identity =
        [&basic.pipeline_cache_uuid[..], &basic.driver_version.to_le_bytes(), &basic.device_id.to_le_bytes()].concat();
    (limits, blake3::hash(&identity).to_hex().to_string())
}
