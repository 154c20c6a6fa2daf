//! Passes that several methods use.

pub mod bands;
pub mod bin;
pub mod compose;
pub mod foresight;
pub mod portion;
pub mod project;
pub mod radix;
pub mod raster;
pub mod scan;
pub mod tiles;
pub mod timeline;

pub use crate::frame_error::Error;
