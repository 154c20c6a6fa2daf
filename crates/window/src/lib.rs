//! A window's images: a picture copied into them, and egui's drawing on top.
//!
//! [`open`] opens a device for a window. A [`Screen`] belongs to one thread, while another one may render. The queue is
//! shared under the submission lock; everything else belongs to the screen.

mod panel;
mod screen;
mod surface;
mod swapchain;

pub use panel::{Drawing, Textures};
pub use screen::{Picture, Screen, Shown};
pub use surface::{Handle, Handles, open};
