//! The device layer: everything that talks to Vulkan, and the only place with `unsafe`.
//!
//! [`Device`] chooses and opens a device, [`Buffer`] owns typed memory, [`Attachment`] an image, [`shader`] turns WGSL
//! into SPIR-V, [`pass!`](crate::pass) declares what a pass binds, and [`Recorder`] alone adds barriers, labels,
//! timestamps and dispatches.

mod agree;
mod barriers;
mod buffer;
pub mod cache;
mod calibration;
mod capture;
mod clock;
mod commands;
mod compiled;
mod context;
mod deletions;
mod device;
mod error;
#[doc(hidden)]
pub mod fault;
mod foresee;
mod guard;
mod image;
mod instance;
pub mod layout;
mod limits;
mod memory;
mod names;
mod pass;
mod paused;
mod pipeline;
mod preferences;
mod recorder;
mod scratch;
pub mod shader;
mod spirv;
mod surface;

pub use agree::{Agree, Expected};
pub use buffer::{Buffer, Memory, RawSlice, Slice};
pub use calibration::{Calibration, Spin, SpinPush, Yardstick};
pub use capture::Capture;
pub use compiled::{Compiled, CompiledPipeline, Executable};
pub use device::{Device, ValidationLog, devices};
pub use error::Error;
pub use foresee::Foresee;
pub use guard::{bytes as guard_bytes, checks};
pub use image::{Attachment, DepthSamples, Format, NumberSamples, Pixels, SAMPLES, ScratchAttachment, Texture};
pub use layout::{GpuType, Member, Shape};
pub use limits::{DeviceInfo, DeviceOptions, Limits};
pub use memory::MemoryBudget;
pub use pass::{Access, Binding, Declaration, Group, PARTS, Pass, PushConstants, Resource};
pub use paused::Paused;
pub use pipeline::{Blend, Compilation, Outputs, PipelineSource};
pub use preferences::Preferences;
pub use recorder::{Dispatch, Draw, Given, PassTime, Recorder, Run, Stamps, Submitted, Targets, Vertices};
pub use scratch::Scratch;
pub use shader::Variant;

// For the crate that shows pictures in windows.
#[doc(hidden)]
pub use barriers::{full_barrier, image_barriers};
#[doc(hidden)]
pub use context::{Context, lock};
#[doc(hidden)]
pub use surface::Surface;

/// The WGSL files of the device layer's own passes.
pub static SHADERS: shader::Sources = shader::Sources {
    files: include_dir::include_dir!("$CARGO_MANIFEST_DIR/shaders"),
    constants: &[&[("WG_SIZE", shader::WORKGROUP)], &agree::CONSTANTS],
    floats: &[],
};

/// Returns the device layer's own passes, with all their variants.
pub fn shaders() -> Vec<shader::Shader> {
    vec![shader::Shader::plain::<Agree>(), shader::Shader::plain::<Foresee>(), shader::Shader::plain::<Spin>()]
}
