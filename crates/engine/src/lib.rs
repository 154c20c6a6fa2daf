//! Renders point clouds you can see through, exactly or nearly, on devices with Vulkan 1.3, and times every pass.
//!
//! The road from file to image, one module per step:
//!
//! 1. [`pellucid_io`] reads a file into a [`pellucid_core::cloud::Cloud`]: float64 positions and named columns.
//! 2. [`pellucid_scene`] reads a scene file, applies its settings to the clouds, which gives
//!    [`pellucid_core::points::Points`] in canonical order (radii, fields and order come from
//!    [`pellucid_scene::prepare`]), and finds the [`pellucid_core::camera::Camera`] if none was given.
//! 3. [`plan`] decides what `auto` stands for, and says which passes a frame has and why.
//! 4. [`methods::Renderer`] uploads the points and renders a [`methods::Frame`]: windows and bands of the image through
//!    the stages in [`passes`] and [`methods`], all of it by way of [`pellucid_gpu`].
//! 5. The result is a [`pellucid_core::image::Image`], which [`pellucid_io::output`] writes as PNG or EXR and
//!    [`pellucid_core::metrics`] compares, and times, which [`profile`] turns into JSON and traces.
//!
//! In addition to this road the crate `pellucid-reference` computes the same images in float64, without a device: what
//! the tests trust. ARCHITECTURE.md in the repository tells the same at more length.
//!
//! # Example
//!
//! ```
//! use pellucid_gpu::{Device, DeviceOptions};
//! use pellucid_engine::methods::{Frame, Renderer};
//! use pellucid_engine::plan;
//! use pellucid_core::progress::Progress;
//! use pellucid_scene::{self as scene, Scene, procedural};
//!
//! # fn main() -> pellucid_engine::Result<()> {
//! // Three layers of opacity 0.05 over the whole image, built in; `Scene::read` and `scene::load_clouds` take files.
//! let parameters = [("layers".to_owned(), 3.0), ("size".to_owned(), 16.0)];
//! let built_in = procedural::build("stack", &parameters, 0).map_err(scene::Error::from)?;
//! let scene = Scene::from_toml(&built_in.scene_toml, "stack".as_ref())?;
//! let clouds = scene::take_generated(&scene, &built_in)?;
//!
//! let up = scene::up_axis(&clouds);
//! let points = scene::assemble(&scene, clouds, scene.method.needs_radii(), &Progress::hidden())?;
//! let (camera, _warnings) = scene::camera(&scene, &points, up)?;
//! let (method, _why) = plan::resolve(scene.method, &points);
//!
//! # if let Err(error) = Device::open(&DeviceOptions::from_env()) {
//! #     pellucid_testing::skip::skip(pellucid_testing::skip::NO_DEVICE, &error.to_string());
//! #     return Ok(());
//! # }
//! let device = Device::open(&DeviceOptions::from_env())?;
//! let mut renderer = Renderer::new(&device)?;
//! let mut cloud = renderer.upload(&points)?;
//! let frame = Frame { fragments: true, ..Frame::new(camera, scene.image.size, method) };
//! let rendered = renderer.render(&mut cloud, &frame)?;
//!
//! // Every pixel has three fragments, which let 0.95³ of the light through; float32 rounds at 6e-8.
//! assert!(rendered.image.fragments.iter().flatten().all(|length| *length == 3));
//! assert!(rendered.image.rgba.iter().all(|[.., a]| (a - 0.142_625).abs() < 1e-6));
//! for pass in &rendered.profile.passes {
//!     println!("{} {:?}", pass.name, pass.gpu);
//! }
//! # Ok(())
//! # }
//! ```

pub mod choices;
pub mod error;
mod fields;
mod frame_error;
pub mod identity;
pub mod methods;
pub mod passes;
#[cfg(test)]
mod passes_page;
pub mod pipelines;
pub mod plan;
pub mod profile;
mod shaders;
pub mod spread;
pub mod totals;

pub use error::{Error, Result};
pub(crate) use fields::fields;
// The modules of the layers below, as this crate names them.
pub(crate) use pellucid_core::{camera, cloud, color, image, points, progress, random};
#[doc(hidden)]
pub use pellucid_gpu as gpu;
pub(crate) use pellucid_gpu::{gpu_struct, group};
pub(crate) use pellucid_io as io;
pub(crate) use pellucid_io::output;
pub(crate) use pellucid_scene as scene;
pub(crate) use pellucid_scene::{prepare, supply};
pub use shaders::{NUMBERS, SHADERS, key_without_numbers, shaders};

/// Declares a pass whose shader is one of [`SHADERS`]; see [`gpu::pass!`].
#[macro_export]
macro_rules! pass {
    ($($declaration:tt)*) => { $crate::gpu::pass! { @from $crate::SHADERS; $($declaration)* } };
}
