//! A window's images: a picture copied into them, and what egui draws over it.
//!
//! A [`Screen`] belongs to one thread, while another one may render: the queue is shared under the submission lock, all
//! else is the screen's own.

mod panel;
mod screen;
mod surface;
mod swapchain;

pub use panel::{Drawing, Textures};
pub use screen::{Picture, Screen, Shown};
pub(super) use surface::extensions;
pub use surface::{Handle, Handles, Surface};
