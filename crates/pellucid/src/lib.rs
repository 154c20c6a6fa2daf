//! Renders point clouds you can see through, exactly or nearly, on devices with Vulkan 1.3, and times every pass.
//!
//! ```no_run
//! # fn main() -> pellucid::Result<()> {
//! # let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let cloud = pellucid::Cloud::from_positions(positions).opacity(0.2).build()?;
//! let scene = pellucid::Scene::from_clouds([cloud])?;
//! pellucid::render(&scene)?.save("cloud.png")?;
//! # Ok(())
//! # }
//! ```
//!
//! - A [`Cloud`] holds points from arrays.
//! - A [`Scene`] holds clouds, from arrays or from files, and settings. Settings have the names that they have in a
//!   scene file, as in `scene.set("method.name", "stochastic")`; docs/scene-file.md lists them.
//! - A [`Renderer`] is a device. It takes a scene once ([`Renderer::load`]) and renders any number of frames of it
//!   ([`Loaded::frame`]), each with a [`Camera`], a [`Method`] and a size of its own.
//! - A [`Picture`] holds linear color, opacity and depth, and the [`Profile`] of the frame: what each pass took.
//!
//! The same points with the same settings give the same bytes. Neither the order of the points nor the scheduling on
//! the device affects them.
//!
//! # Versions
//!
//! The public items of this crate follow Semantic Versioning. Before 1.0, a new minor version may break them and a new
//! patch version doesn't. The crates that it is built on, such as `pellucid-engine`, promise nothing. docs/install.md
//! lists what else is promised.
//!
//! # Example
//!
//! ```
//! use pellucid::{Camera, Cloud, Renderer, Scene};
//!
//! # fn main() -> pellucid::Result<()> {
//! // Three layers that each let 0.75 of the light through.
//! let positions: Vec<[f64; 3]> = (0..3).map(|layer| [0.0, 0.0, f64::from(layer)]).collect();
//! let cloud = Cloud::from_positions(positions).radius(2.0).opacity(0.25).build()?;
//! let mut scene = Scene::from_clouds([cloud])?;
//! scene.set("image.size", [64, 64])?;
//!
//! # if pellucid::devices()?.is_empty() {
//! #     pellucid_testing::skip::skip(pellucid_testing::skip::NO_DEVICE, "none was found");
//! #     return Ok(());
//! # }
//! let renderer = Renderer::open()?;
//! let mut loaded = renderer.load(&scene)?;
//! let camera = Camera::look_at([0.0, 0.0, 8.0], [0.0; 3], [0.0, 1.0, 0.0]).orthographic(2.0);
//! let picture = loaded.frame().camera(camera).timed().render()?;
//!
//! assert!(picture.pixels().iter().all(|[.., a]| (a - (1.0 - 0.75f32.powi(3))).abs() < 1e-6));
//! for pass in picture.profile().passes() {
//!     println!("{:<20} {:?}", pass.name, pass.time);
//! }
//! # Ok(())
//! # }
//! ```

mod camera;
mod cloud;
mod error;
mod frame;
mod method;
mod observer;
mod picture;
mod profile;
mod renderer;
mod scene;
#[cfg(test)]
mod tests;

// The examples, which the tests run, name the crate as everyone does.
#[cfg(test)]
extern crate self as pellucid;

pub use camera::Camera;
pub use cloud::{Cloud, CloudBuilder};
pub use error::{Error, ErrorKind, Result};
pub use frame::{Accuracy, FrameBuilder, Samples};
pub use method::Method;
pub use observer::Observer;
pub use picture::Picture;
pub use profile::{Pass, Profile};
pub use renderer::{Loaded, Renderer, devices};
pub use scene::{Scene, Setting};

/// Renders a scene on the best device, with the scene's camera or one that sees all of the scene.
///
/// # Errors
/// Returns the errors of [`Renderer::open`], [`Renderer::load`] and [`FrameBuilder::render`].
pub fn render(scene: &Scene) -> Result<Picture> {
    Renderer::open()?.load(scene)?.frame().render()
}
