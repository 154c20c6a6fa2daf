use ash::vk;
use bytesize::ByteSize;

/// The reason why the device failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The Vulkan loader is not installed.
    #[error(
        "no Vulkan loader: {0}; install it (Debian, Ubuntu: libvulkan1 and mesa-vulkan-drivers) or run tools/setup.sh"
    )]
    NoLoader(String),
    /// The loader finds no driver.
    #[error("no Vulkan device; install a driver (without a GPU: mesa-vulkan-drivers) or run tools/setup.sh")]
    NoDevice,
    /// Drivers are named, and none of them starts.
    #[error(
        "no Vulkan device: no driver starts ({call}: {result:?}); a driver's manifest may be damaged (one that VK_DRIVER_FILES \
         or VK_ICD_FILENAMES names, else one in /usr/share/vulkan/icd.d), or its GPU may be missing (pass /dev/dri into a \
         container); without a GPU, install mesa-vulkan-drivers"
    )]
    NoDriver {
        /// The call.
        call: &'static str,
        /// The result that the call returned.
        result: vk::Result,
    },
    /// `--device` matches none of the present devices.
    #[error("no Vulkan device matches {wanted:?}; devices: {present}")]
    NoSuchDevice {
        /// The requested name.
        wanted: String,
        /// Index and name of each device.
        present: String,
    },
    /// The device lacks something required.
    #[error("device {device} lacks {missing}; `pellucid devices` lists the others")]
    Lacks {
        /// The device's name.
        device: String,
        /// The missing features, separated by commas.
        missing: String,
    },
    /// Windows can't be shown here.
    #[error("can't show pictures in a window: {0}; `pellucid render` writes them to a file")]
    NoSurface(String),
    /// A frame can't be captured.
    #[error("can't capture a frame: {0}")]
    Capture(String),
    /// Validation was asked for, but its layer is not installed.
    #[error(
        "validation was requested, but VK_LAYER_KHRONOS_validation is not installed (Debian, Ubuntu: vulkan-validationlayers)"
    )]
    NoValidation,
    /// An allocation failed.
    #[error("out of device memory: {name} needs {} in addition to {} in use; use a smaller --memory-budget or --size", ByteSize(*.bytes), ByteSize(*.in_use))]
    OutOfMemory {
        /// The allocation's name.
        name: String,
        /// Bytes asked for.
        bytes: u64,
        /// Bytes allocated at that moment.
        in_use: u64,
    },
    /// A buffer is larger than the device binds or allocates at once.
    #[error("{name} needs {}, but this device allows {} ({limit_name})", ByteSize(*.bytes), ByteSize(*.limit))]
    TooLarge {
        /// The buffer's name.
        name: String,
        /// Bytes asked for.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
        /// The limit's name in Vulkan.
        limit_name: &'static str,
    },
    /// An image or a draw is larger than the device supports on a side, or empty.
    #[error(
        "{name}: {} × {} pixels, but this device draws 1 to {} × 1 to {}", size[0], size[1], limit[0], limit[1]
    )]
    Framebuffer {
        /// The image's or the pass's name.
        name: String,
        /// Columns and rows asked for.
        size: [u32; 2],
        /// Most columns and rows.
        limit: [u32; 2],
    },
    /// The device stopped answering.
    #[error(
        "the device was lost during {during}: its driver stopped or restarted, often because a dispatch took too long; try \
         again, then with a smaller --size or --memory-budget, which make dispatches shorter, or with another --device"
    )]
    Lost {
        /// The submission.
        during: String,
    },
    /// No more submissions are wanted ([`super::Device::allow_submissions`]).
    #[error("stopped before {before}")]
    Stopped {
        /// The submission.
        before: String,
    },
    /// Any other Vulkan failure.
    #[error("Vulkan: {call} failed with {result:?}{help}", help = help(*result))]
    Vulkan {
        /// The call.
        call: &'static str,
        /// The result that the call returned.
        result: vk::Result,
    },
    /// A shader does not compile or does not match its pass.
    #[error("shader {name}: {message}")]
    Shader {
        /// Stem of the file.
        name: String,
        /// The cause.
        message: String,
    },
    /// A shader wrote behind a range that it was given: found in debug builds alone.
    #[error(
        "{passes}: something was written {bytes} bytes behind the end of {buffer} (bound as {binding}): {word:#010x}"
    )]
    Overrun {
        /// The buffer's name.
        buffer: String,
        /// The variable that it was bound to.
        binding: &'static str,
        /// The passes that it was bound to, first and last.
        passes: String,
        /// Bytes between the end of the range and the first wrong word.
        bytes: u64,
        /// The word found there.
        word: u32,
    },
    /// A pass did not store what another one had counted: found in debug builds alone.
    #[error(
        "{pass} did not store what was counted: {item} {element} ends at {stored} instead of {counted} \
        ({differing} of {of} differ)"
    )]
    Miscounted {
        /// The pass that stored.
        pass: &'static str,
        /// The item that each count belongs to.
        item: &'static str,
        /// The index of a wrong element.
        element: u64,
        /// The end of its cursor.
        stored: u32,
        /// The expected end.
        counted: u32,
        /// The number of wrong elements.
        differing: u32,
        /// The number of elements.
        of: u64,
    },
    /// The validation layers complained.
    #[error("{} validation message(s), the first: {}", .0.len(), .0.first().map_or("", String::as_str))]
    Validation(Vec<String>),
}

/// Advice to end an error message with.
fn help(result: vk::Result) -> &'static str {
    match result {
        vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => ": out of device memory; use a smaller --memory-budget or --size",
        vk::Result::ERROR_OUT_OF_HOST_MEMORY => ": out of memory; use fewer points or a smaller --size",
        _ => "",
    }
}

impl Error {
    /// Returns `true` if the device or the host ran out of memory, so that a later attempt may succeed.
    pub fn is_out_of_memory(&self) -> bool {
        let none_left = [vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, vk::Result::ERROR_OUT_OF_HOST_MEMORY];
        match self {
            Self::OutOfMemory { .. } => true,
            Self::Vulkan { result, .. } => none_left.contains(result),
            _ => false,
        }
    }

    /// Returns a function for `map_err` after a call that starts drivers.
    pub(crate) fn start(call: &'static str) -> impl FnOnce(vk::Result) -> Self {
        move |result| match result {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Self::NoDevice,
            // The loader answers so to a manifest that it can't read, and drivers where their device file is missing.
            vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_INITIALIZATION_FAILED => {
                Self::NoDriver { call, result }
            }
            result => Self::call(call)(result),
        }
    }

    /// Returns a function for `map_err` that makes an error which names the failed call.
    #[doc(hidden)]
    pub fn call(call: &'static str) -> impl FnOnce(vk::Result) -> Self {
        move |result| match result {
            vk::Result::ERROR_DEVICE_LOST => Self::Lost { during: call.to_owned() },
            result => Self::Vulkan { call, result },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drivers_that_do_not_start_are_no_device_and_no_lack_of_memory() {
        let start = |result| Error::start("vkCreateInstance")(result);
        assert!(matches!(start(vk::Result::ERROR_INCOMPATIBLE_DRIVER), Error::NoDevice));
        for result in [vk::Result::ERROR_OUT_OF_HOST_MEMORY, vk::Result::ERROR_INITIALIZATION_FAILED] {
            let error = start(result);
            assert!(!error.is_out_of_memory());
            let text = error.to_string();
            assert!(text.starts_with("no Vulkan device: ") && text.contains("VK_DRIVER_FILES"), "{text}");
        }
        assert!(matches!(start(vk::Result::ERROR_LAYER_NOT_PRESENT), Error::Vulkan { .. }));
    }

    #[test]
    fn a_device_that_any_call_finds_lost_is_lost() {
        assert!(
            matches!(Error::call("vkAny")(vk::Result::ERROR_DEVICE_LOST), Error::Lost { during } if during == "vkAny")
        );
        let other = Error::call("vkAny")(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY);
        assert!(matches!(other, Error::Vulkan { call: "vkAny", .. }) && other.is_out_of_memory());
    }
}
