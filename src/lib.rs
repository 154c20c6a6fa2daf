//! Renders point clouds you can see through, exactly, on any Vulkan device, and times every pass.

#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod camera;
pub mod cloud;
pub mod color;
pub mod error;
#[allow(unsafe_code)]
pub mod gpu;
pub mod image;
pub mod io;
pub mod methods;
pub mod metrics;
pub mod output;
pub mod passes;
pub mod plan;
pub mod points;
pub mod prepare;
pub mod profile;
pub mod reference;
pub mod scene;

pub use error::{Error, Result};
