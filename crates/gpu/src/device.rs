//! Selection of the device and its required features.

use std::ffi::{CStr, c_char};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::{ext, vk};

use super::context::{Context, lock};
use super::image::{self, Attachment, Format};
use super::instance::{Instance, Messages};
use super::limits::{DeviceInfo, DeviceOptions, Limits, features, queue_family};
use super::memory::{self, MemoryBudget};
use super::surface::Surface;
use super::{Buffer, Compilation, Error, GpuType, Memory, PipelineSource, Preferences, Recorder, Stamps};

/// Returns the Vulkan devices in Vulkan's order, and the index of the one that `--device wanted` (or nothing) would
/// take, if it can be.
pub fn devices(wanted: Option<&str>) -> Result<(Vec<DeviceInfo>, Option<usize>), Error> {
    let instance = Instance::new(false, false, &[])?;
    let found = enumerate(&instance)?;
    let taken = match wanted {
        Some(wanted) => Some(named(&found, wanted)?).filter(|(info, _)| info.lacks.is_empty()),
        None => best(&found),
    };
    let taken = taken.map(|(info, _)| info.index);
    Ok((found.into_iter().map(|(info, _)| info).collect(), taken))
}

type Candidate = (DeviceInfo, vk::PhysicalDevice);

fn enumerate(instance: &Instance) -> Result<Vec<Candidate>, Error> {
    // SAFETY: a plain query on a live instance.
    let physical =
        unsafe { instance.raw.enumerate_physical_devices() }.map_err(Error::start("vkEnumeratePhysicalDevices"))?;
    Ok(physical.into_iter().enumerate().map(|(index, p)| (describe(instance, index, p), p)).collect())
}

/// Discrete before integrated before virtual before CPU; the first of equals.
fn best(found: &[Candidate]) -> Option<&Candidate> {
    found.iter().filter(|(info, _)| info.lacks.is_empty()).min_by_key(|(info, _)| (info.rank, info.index))
}

fn describe(instance: &Instance, index: usize, physical: vk::PhysicalDevice) -> DeviceInfo {
    let mut features12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut features13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut atomics = vk::PhysicalDeviceShaderAtomicInt64Features::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    let mut subgroup_sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
    // SAFETY: plain queries on a live instance; the structs are of this Vulkan version or zero-filled if it is older.
    let (basic, core) = unsafe {
        let basic = instance.raw.get_physical_device_properties(physical);
        let modern = basic.api_version >= vk::API_VERSION_1_3;
        let mut found = vk::PhysicalDeviceFeatures2::default();
        if modern {
            found = found.push_next(&mut features12).push_next(&mut features13);
            let mut properties = vk::PhysicalDeviceProperties2::default()
                .push_next(&mut driver)
                .push_next(&mut subgroups)
                .push_next(&mut subgroup_sizes);
            instance.raw.get_physical_device_properties2(physical, &mut properties);
        }
        instance.raw.get_physical_device_features2(physical, &mut found);
        let core = found.features;
        if modern {
            // Some drivers report 64-bit atomics only in the stand-alone struct, which may not share a chain with the
            // 1.2 struct.
            let mut alone = vk::PhysicalDeviceFeatures2::default().push_next(&mut atomics);
            instance.raw.get_physical_device_features2(physical, &mut alone);
        }
        (basic, core)
    };

    let text = |s: Result<&CStr, _>| s.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let version = |v: u32| format!("{}.{}", vk::api_version_major(v), vk::api_version_minor(v));
    let mut lacks = Vec::new();
    if basic.api_version < vk::API_VERSION_1_3 {
        lacks.push(format!("Vulkan 1.3 (it has {})", version(basic.api_version)));
    } else {
        for (present, name) in [
            (features13.synchronization2, "synchronization2"),
            (features13.dynamic_rendering, "dynamicRendering"),
            (features13.maintenance4, "maintenance4"),
            (features12.host_query_reset, "hostQueryReset"),
        ] {
            if present == vk::FALSE {
                lacks.push(name.to_owned());
            }
        }
    }
    match queue_family(&instance.raw, physical) {
        None => lacks.push("a queue for compute and graphics with timestamps".to_owned()),
        Some(family) if instance.surface.as_ref().is_some_and(|s| !s.takes_from(&instance.raw, physical, family)) => {
            lacks.push("a way to show pictures in this window".to_owned());
        }
        Some(_) => {}
    }
    let (kind, rank) = match basic.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => ("discrete", 0),
        vk::PhysicalDeviceType::INTEGRATED_GPU => ("integrated", 1),
        vk::PhysicalDeviceType::VIRTUAL_GPU => ("virtual", 2),
        vk::PhysicalDeviceType::CPU => ("CPU", 3),
        _ => ("other", 4),
    };
    let conditional: vk::PhysicalDeviceConditionalRenderingFeaturesEXT<'_> =
        features(&instance.raw, physical, Some(ext::conditional_rendering::NAME));
    // SAFETY: a plain query on a live instance.
    let heaps = unsafe { instance.raw.get_physical_device_memory_properties(physical) };
    let driver_name = text(driver.driver_name_as_c_str());
    let driver_info = text(driver.driver_info_as_c_str());
    DeviceInfo {
        index,
        name: text(basic.device_name_as_c_str()),
        driver: format!("{driver_name} {driver_info}").trim().to_owned(),
        kind,
        lacks,
        timestamp_period_ns: f64::from(basic.limits.timestamp_period),
        int64_atomics: core.shader_int64 == vk::TRUE
            && (features12.shader_buffer_int64_atomics == vk::TRUE || atomics.shader_buffer_int64_atomics == vk::TRUE),
        fragment_atomics: core.fragment_stores_and_atomics == vk::TRUE,
        multisampled: image::multisampled_size(instance, physical),
        pipeline_statistics: core.pipeline_statistics_query == vk::TRUE,
        subgroup: (features13.subgroup_size_control == vk::TRUE && features13.compute_full_subgroups == vk::TRUE)
            .then(|| subgroup_size(&subgroups, &subgroup_sizes))
            .flatten(),
        conditional: conditional.conditional_rendering == vk::TRUE,
        heap_bytes: memory::largest_heap(&heaps).map_or(0, |(_, bytes)| bytes),
        memory: memory::budget(instance, physical),
        prefers: Preferences::of(basic.device_type),
        rank,
    }
}

/// The subgroup size that compute shaders ask for: the largest up to 32, so that a ballot is one word.
fn subgroup_size(
    subgroups: &vk::PhysicalDeviceSubgroupProperties<'_>,
    sizes: &vk::PhysicalDeviceSubgroupSizeControlProperties<'_>,
) -> Option<u32> {
    use vk::SubgroupFeatureFlags as F;
    let compute = vk::ShaderStageFlags::COMPUTE;
    let able = subgroups.supported_operations.contains(F::BASIC | F::BALLOT | F::SHUFFLE)
        && subgroups.supported_stages.contains(compute)
        && sizes.required_subgroup_size_stages.contains(compute);
    let size = sizes.max_subgroup_size.min(32);
    // With fewer than 8, kernels hold so many pixels per invocation that they take minutes to compile (SwiftShader has
    // 4).
    (able && size >= sizes.min_subgroup_size.max(8)).then_some(size)
}

/// An open device. Cheap to clone; buffers keep it alive.
#[derive(Clone)]
pub struct Device(pub(super) Arc<Context>);

impl Device {
    /// Opens the device that `options` names, or the best one.
    pub fn open(options: &DeviceOptions) -> Result<Self, Error> {
        Self::open_on(Instance::new(options.validation, options.gpu_assisted, &[])?, options)
    }

    /// Opens the device that `options` names, or the best one of those that can present to a surface, which needs these
    /// extensions of the instance.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`] and of `surface`, and [`Error::NoSurface`] if no driver knows the
    /// extensions.
    #[doc(hidden)]
    pub fn open_for(
        options: &DeviceOptions,
        extensions: &[*const c_char],
        surface: impl FnOnce(&ash::Entry, &ash::Instance) -> Result<Surface, Error>,
    ) -> Result<Self, Error> {
        let mut instance = Instance::new(options.validation, options.gpu_assisted, extensions)?;
        instance.surface = Some(surface(&instance.entry, &instance.raw)?);
        Self::open_on(instance, options)
    }

    /// Returns everything that it is made of.
    #[doc(hidden)]
    pub fn context(&self) -> &Arc<Context> {
        &self.0
    }

    fn open_on(instance: Instance, options: &DeviceOptions) -> Result<Self, Error> {
        let found = enumerate(&instance)?;
        if found.is_empty() {
            return Err(Error::NoDevice);
        }
        let (info, physical) = match &options.device {
            Some(wanted) => named(&found, wanted)?,
            None => match best(&found) {
                Some(found) => found,
                None => &found[0],
            },
        };
        if !info.lacks.is_empty() {
            return Err(Error::Lacks { device: info.name.clone(), missing: info.lacks.join(", ") });
        }
        let prefers = options.prefers.unwrap_or(info.prefers);
        let mut context = Context::new(instance, *physical, DeviceInfo { prefers, ..info.clone() }, options)?;
        let Limits { binding_bytes, allocation_bytes, buffer_bytes, .. } = &mut context.limits;
        for (allowed, option) in
            [(&mut *binding_bytes, options.binding_bytes), (&mut *allocation_bytes, options.allocation_bytes)]
        {
            *allowed = option.map_or(*allowed, |bytes| bytes.min(*allowed));
        }
        if !prefers.large_allocations {
            *buffer_bytes = *allocation_bytes;
        }
        Ok(Self(Arc::new(context)))
    }

    /// Returns properties of the opened device.
    pub fn info(&self) -> &DeviceInfo {
        &self.0.info
    }

    /// Limits of the device.
    pub fn limits(&self) -> &Limits {
        &self.0.limits
    }

    /// Returns a buffer of `len` elements; its content is undefined.
    pub fn buffer<T: GpuType>(&self, name: &str, len: u64, memory: Memory) -> Result<Buffer<T>, Error> {
        Buffer::new(&self.0, name, len, memory)
    }

    /// Returns a device-local buffer with this content. An empty slice makes a buffer of one undefined element, since
    /// Vulkan has no empty ones.
    pub fn upload<T: GpuType>(&self, name: &str, data: &[T]) -> Result<Buffer<T>, Error> {
        let buffer = self.buffer(name, (data.len() as u64).max(1), Memory::Device)?;
        buffer.upload(data)?;
        Ok(buffer)
    }

    /// Returns an image of `samples` samples per pixel to draw into and read; its content is undefined.
    /// [`DeviceInfo::multisampled`] bounds its size.
    pub fn attachment(&self, name: &str, format: Format, samples: u32, size: [u32; 2]) -> Result<Attachment, Error> {
        Attachment::new(&self.0, name, format, samples, size)
    }

    /// Returns a new recorder, which times its passes and counts their invocations.
    pub fn recorder(&self) -> Result<Recorder<'_>, Error> {
        Recorder::new(&self.0, Stamps::Passes)
    }

    /// A new recorder without times and counts: passes that have nothing to do with one another may run at once.
    pub fn plain_recorder(&self) -> Result<Recorder<'_>, Error> {
        Recorder::new(&self.0, Stamps::None)
    }

    /// Returns a new recorder with timestamps at these places.
    pub fn recorder_with(&self, stamps: Stamps) -> Result<Recorder<'_>, Error> {
        Recorder::new(&self.0, stamps)
    }

    /// Command buffers that wait for the next [`Self::recorder`]: as many as there were recorders at one time, less
    /// those that there are now.
    pub fn idle_command_buffers(&self) -> usize {
        lock(&self.0.idle_commands).len()
    }

    /// Returns the largest number of bytes that was reserved on the device at any time since [`Self::reset_peak`].
    pub fn peak_bytes(&self) -> u64 {
        self.0.peak.load(Ordering::Relaxed)
    }

    /// Starts a new measurement of the peak from the bytes reserved now; returns that.
    pub fn reset_peak(&self) -> u64 {
        let now = self.0.in_use();
        self.0.peak.store(now, Ordering::Relaxed);
        now
    }

    /// Returns the memory that may be used now; `None` where the driver doesn't tell (VK_EXT_memory_budget).
    pub fn memory_budget(&self) -> Option<MemoryBudget> {
        memory::budget(&self.0.instance, self.0.physical)
    }

    /// Allows `count` further submissions, with `None` all of them; later ones fail with [`Error::Stopped`]. Any thread
    /// may call this: `Some(0)` ends an obsolete frame at its next submission. Submissions that show pictures in a
    /// window are not counted.
    pub fn allow_submissions(&self, count: Option<u64>) {
        self.0.allowed.store(count.unwrap_or(u64::MAX), Ordering::Relaxed);
    }

    /// Returns `true` if no further submission is allowed: work for the next one is in vain.
    pub fn is_stopped(&self) -> bool {
        self.0.allowed.load(Ordering::Relaxed) == 0
    }

    /// Returns the number of bytes uploaded so far, without the view that every frame writes. Changing the threshold,
    /// softness or radius factor adds nothing.
    pub fn uploaded_bytes(&self) -> u64 {
        self.0.uploaded.load(Ordering::Relaxed)
    }

    /// Returns the number of submissions that the host has waited for so far, those of uploads and reads among them.
    /// Those that show pictures in a window don't count.
    pub fn waits(&self) -> u64 {
        self.0.waits.load(Ordering::Relaxed)
    }

    /// Returns the names and sizes of all allocations: a leak report when it should be empty.
    pub fn live_allocations(&self) -> Vec<(String, u64)> {
        self.0.live_allocations()
    }

    /// Returns when each pipeline so far was made, and how long that took, from WGSL to what the driver makes of it.
    /// The pipelines are in the order in which they were done.
    pub fn compilations(&self) -> Vec<Compilation> {
        lock(&self.0.compilations).clone()
    }

    /// Returns what every pipeline so far was made from; in no order.
    pub fn made(&self) -> Vec<PipelineSource> {
        lock(&self.0.pipelines).values().map(|pipeline| pipeline.made.clone()).collect()
    }

    /// Returns everything that the validation layers said so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.0.instance.messages.snapshot()
    }

    /// Returns messages of the validation layers, to be read after the device is gone.
    pub fn validation_log(&self) -> ValidationLog {
        ValidationLog(self.0.instance.messages.clone())
    }

    /// An error if the validation layers said anything.
    pub fn check_validation(&self) -> Result<(), Error> {
        self.validation_log().check()
    }
}

/// The messages of the validation layers; outlives the device, so that those about its end are in it, too.
pub struct ValidationLog(Arc<Messages>);

impl ValidationLog {
    /// An error if the validation layers said anything.
    pub fn check(&self) -> Result<(), Error> {
        let messages = self.0.snapshot();
        if messages.is_empty() { Ok(()) } else { Err(Error::Validation(messages)) }
    }
}

fn named<'a>(found: &'a [Candidate], wanted: &str) -> Result<&'a Candidate, Error> {
    let lower = wanted.to_lowercase();
    let by_index = wanted.parse::<usize>().ok().and_then(|i| found.get(i));
    by_index.or_else(|| found.iter().find(|(info, _)| info.name.to_lowercase().contains(&lower))).ok_or_else(|| {
        let present =
            found.iter().map(|(info, _)| format!("{} {}", info.index, info.name)).collect::<Vec<_>>().join(", ");
        Error::NoSuchDevice { wanted: wanted.to_owned(), present }
    })
}
