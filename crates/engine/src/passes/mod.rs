//! Passes that several methods use.

pub mod bin;
pub mod compose;
pub mod project;
pub mod radix;
pub mod raster;
pub mod scan;
pub mod tiles;
