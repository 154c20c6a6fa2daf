//! Passes that several methods use.

pub mod project;
pub mod raster;
pub mod scan;
