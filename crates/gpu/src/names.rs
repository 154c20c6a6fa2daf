//! Names of Vulkan's objects, for validation layers and for debuggers such as RenderDoc and Nsight
//! (VK_EXT_debug_utils).
//!
//! Objects get their names when they are made. Without the extension nothing has a name.

use std::ffi::CString;

use ash::vk::{self, Handle};

use super::Context;
use super::pipeline::Pipeline;

impl Context {
    /// Names an object; must not be called while another thread names the same one.
    pub fn name_object<H: Handle>(&self, object: H, name: &str) {
        self.name_handle((H::TYPE, object.as_raw()), name);
    }

    /// Names an object by its kind and handle.
    pub(super) fn name_handle(&self, (kind, handle): (vk::ObjectType, u64), name: &str) {
        let Some(debug) = &self.debug else { return };
        let name = CString::new(name).unwrap_or_default();
        let mut info = vk::DebugUtilsObjectNameInfoEXT::default().object_name(&name);
        info.object_type = kind;
        info.object_handle = handle;
        // SAFETY: the object was just made from this device, so that nobody else uses it yet. A name that could not be
        // set changes nothing else.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Names a pipeline and its layouts.
    pub(super) fn name_pipeline(&self, pipeline: &Pipeline) {
        let title = pipeline.made.title();
        self.name_object(pipeline.raw, &title);
        self.name_object(pipeline.layout, &title);
        self.name_object(pipeline.set_layout, &title);
    }

    /// Calls `submit` within a label on the queue, so that a debugger groups what is submitted by frames. The caller
    /// holds the queue.
    pub(super) fn labelled<R>(&self, name: &str, submit: impl FnOnce() -> R) -> R {
        let Some(debug) = &self.debug else { return submit() };
        let name = CString::new(name).unwrap_or_default();
        let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
        // SAFETY: the extension is enabled, and no other thread uses the queue.
        unsafe { debug.queue_begin_debug_utils_label(self.queue, &label) };
        let result = submit();
        // SAFETY: as above; the label was begun here.
        unsafe { debug.queue_end_debug_utils_label(self.queue) };
        result
    }
}
