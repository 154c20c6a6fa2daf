//! The Vulkan instance, with a debug messenger whose messages are collected.

use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use ash::{ext, khr, vk};

use super::Error;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Messages of the validation layers, in order of arrival.
#[derive(Default)]
pub struct Messages {
    all: Mutex<Vec<String>>,
    /// The number of messages that were returned already.
    given: AtomicUsize,
}

impl Messages {
    pub fn push(&self, message: String) {
        self.all.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }

    pub fn snapshot(&self) -> Vec<String> {
        let all = self.all.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.given.store(all.len(), Ordering::Relaxed);
        all
    }

    /// The messages since [`Messages::snapshot`], for the end, when they are no longer requested.
    fn late(&self) -> Vec<String> {
        let given = self.given.load(Ordering::Relaxed);
        self.snapshot().split_off(given)
    }
}

/// Owns the instance; destroyed last.
pub struct Instance {
    pub raw: ash::Instance,
    pub messages: Arc<Messages>,
    /// `true` if VK_EXT_debug_utils is enabled, which labels and names need.
    pub debug_utils: bool,
    /// The surface that shows frames, if a window exists.
    pub surface: Option<super::surface::Surface>,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    pub entry: ash::Entry,
}

impl Instance {
    /// Opens the loader. With `validation`, validation and synchronization validation are on and every warning or error
    /// is collected; with `gpu_assisted` besides, shaders are instrumented, and synchronization is not looked at.
    /// `wanted` are names of further extensions, those of a surface.
    pub fn new(validation: bool, gpu_assisted: bool, wanted: &[*const c_char]) -> Result<Self, Error> {
        // SAFETY: loading the system's Vulkan loader runs its initializers; this is the only way to reach Vulkan.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| Error::NoLoader(e.to_string()))?;
        // SAFETY: plain queries on a loaded entry.
        let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
        // SAFETY: as above.
        let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
        let offers = |name| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let debug_utils = offers(ext::debug_utils::NAME) || validation;
        // Without it the loader hides devices that leave out parts of Vulkan, as MoltenVK does on macOS.
        let portability = offers(khr::portability_enumeration::NAME);
        if validation && !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
            return Err(Error::NoValidation);
        }

        let application = vk::ApplicationInfo::default().application_name(c"pellucid").api_version(vk::API_VERSION_1_3);
        let layer_names = [VALIDATION_LAYER.as_ptr()];
        let mut extension_names = wanted.to_vec();
        use vk::ValidationFeatureEnableEXT as Feature;
        let enabled: &[_] = match gpu_assisted {
            true => &[Feature::GPU_ASSISTED, Feature::GPU_ASSISTED_RESERVE_BINDING_SLOT],
            false => &[Feature::SYNCHRONIZATION_VALIDATION],
        };
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(enabled);
        if debug_utils {
            extension_names.push(ext::debug_utils::NAME.as_ptr());
        }
        let mut flags = vk::InstanceCreateFlags::empty();
        if portability {
            extension_names.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        let mut info = vk::InstanceCreateInfo::default()
            .flags(flags)
            .application_info(&application)
            .enabled_extension_names(&extension_names);
        if validation {
            info = info.enabled_layer_names(&layer_names).push_next(&mut features);
        }
        // SAFETY: every pointer in `info` lives to the end of this function.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
            vk::Result::ERROR_EXTENSION_NOT_PRESENT if !wanted.is_empty() => {
                Error::NoSurface("no Vulkan driver here knows windows of this kind".into())
            }
            result => Error::start("vkCreateInstance")(result),
        })?;

        let mut instance = Self { raw, messages: Arc::default(), debug_utils, surface: None, messenger: None, entry };
        if validation {
            instance.listen()?;
        }
        Ok(instance)
    }

    fn listen(&mut self) -> Result<(), Error> {
        let loader = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(collect))
            .user_data(Arc::as_ptr(&self.messages).cast_mut().cast());
        // SAFETY: the messages outlive the messenger: both belong to `self`, whose drop destroys the messenger first.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .map_err(Error::call("vkCreateDebugUtilsMessengerEXT"))?;
        self.messenger = Some((loader, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        for message in self.messages.late() {
            eprintln!("warning: validation: {message}");
        }
        // SAFETY: the device keeps an Arc of this instance, so nothing made from it is left.
        unsafe {
            if let Some(surface) = self.surface.take() {
                surface.destroy();
            }
            if let Some((loader, messenger)) = self.messenger.take() {
                loader.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// Called by the layers, possibly from several threads.
unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is the pointer given in `listen`, alive as long as the messenger; the layer passes valid data.
    let (messages, text) = unsafe {
        let text = data.as_ref().and_then(|d| d.message_as_c_str());
        (user.cast::<Messages>().as_ref(), text.map(|t| t.to_string_lossy().into_owned()))
    };
    // GPU-assisted validation reports on its own setup (features that it switches on, checks that the device lacks),
    // which doesn't concern this program.
    if let (Some(messages), Some(text)) = (messages, text.filter(|text| !text.contains("Internal Warning: "))) {
        messages.push(text);
    }
    vk::FALSE
}
