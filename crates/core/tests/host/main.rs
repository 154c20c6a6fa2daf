//! Tests of what all crates share: camera paths and metrics.

mod camera_paths;
mod metrics;
